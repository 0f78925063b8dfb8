"""Regenerate every table of validation and benchmarks, or compare the stored ones with new ones.

    python validation/all.py                    # all pages of validation, about three hours on two cores
    python validation/all.py rolling impact     # the pages whose path contains one of these words
    python validation/all.py benchmarks         # the tables of the benchmarks: only on an idle machine
    python validation/all.py --most 2           # those that take up to two minutes
    python validation/all.py --check            # write nothing, list the numbers that differ, exit with 1

A program either writes its page itself or prints tables.  A printed table replaces the table with the same head in the
page, in their order.  The figures of the paper have a command of their own, see boundary_layers/README.md.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
REFERENCE = ROOT.parent / "shared" / "reference"
NUMBER = re.compile(r"[-+]?\d+(?:\.(\d+))?(?:e([-+]\d+))?")
UNITS, SHARE = 2.0, 0.02  # a number may differ by so many units of its last digit, or by this share
COUNTS = re.compile(r"iterations|convolutions|steps|Krylov|Newton|runs", re.IGNORECASE)
SHARE_OF_COUNTS = 0.2  # of iterations and steps, which depend on the last digits
NOISE = re.compile(r"imbalance|differs|deviation|off by|change of all oil|noise", re.IGNORECASE)


class Page(NamedTuple):
    """A page, the program that makes its tables, the program's arguments, and minutes on one core."""

    path: str
    program: str
    arguments: str
    minutes: float


def _pages(folder: str, program: str, **minutes: float) -> list[Page]:
    """The pages that a program with one argument for each writes."""
    return [Page(f"{folder}/{name}.md", f"{folder}/{program}", name, taken) for name, taken in minutes.items()]


PAGES = [
    *_pages("validation/rolling", "validate.py", reference=10, limits=3, cavity=2),
    Page("validation/rolling/bars.md", "validation/rolling/bars.py", "", 12),
    Page("validation/rolling/waves.md", "validation/rolling/validate.py", "waves --nodes 257", 3),
    *_pages("validation/impact", "validate.py", work=12, orders=2, reference=15, errors=20),
    *_pages("validation/starvation", "validate.py", impact=5, order=3, track=4, work=3, settled=5, again=4),
    Page("validation/starvation/restitution.md", "validation/starvation/restitution.py", "", 2),
    *_pages("validation/contacts", "validate.py", formula=8, angle=1, mass=8),
    Page("validation/contacts/resistance.md", "validation/contacts/validate.py", "resistance --nodes 65", 4),
    Page("validation/contacts/line.md", "validation/contacts/line.py", "films", 2),
    *(
        Page(f"validation/contacts/line_{name}.md", "validation/contacts/line.py", name, minutes)
        for name, minutes in {"impacts": 3, "waves": 2, "formulas": 2, "ellipses": 3}.items()
    ),
    Page("validation/contacts/README.md", "validation/contacts/mesh.py", "", 4),
    Page("validation/contacts/classics.md", "validation/contacts/classics.py", "", 3),
    Page("validation/optics/README.md", "validation/optics/films.py", "", 4),
    Page("validation/friction/README.md", "validation/friction/film_thinning.py", "", 1),
    Page("validation/friction/README.md", "validation/friction/order.py", "", 1),
    Page("validation/friction/heat.md", "validation/friction/heat.py", "", 7),
    Page("validation/friction/traction.md", "validation/friction/traction.py", "", 2),
    Page("validation/friction/waviness.md", "validation/friction/waviness.py", "", 4),
    *_pages("validation/fit", "validate.py", twins=15, noise=1, mourier=6),
    *(
        Page("benchmarks/README.md", f"benchmarks/{name}.py", "", minutes)
        for name, minutes in {"steps": 3, "rebound": 2, "rolling": 2, "thinning": 2, "shares": 5, "scaling": 10,
                              "time_error": 2, "fft": 1, "lines": 3}.items()
    ),
]  # fmt: skip


# -- tables in pages --------------------------------------------------------------------------------------------------


def tables(text: str) -> Iterator[tuple[int, list[str]]]:
    """Each table of a text: its first line's number, from 0, and its lines."""
    lines = text.splitlines()
    start = None
    for number, line in enumerate([*lines, ""]):
        if line.startswith("|") and start is None:
            start = number
        elif not line.startswith("|") and start is not None:
            yield start, lines[start:number]
            start = None


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def spliced(page: str, printed: str) -> str:
    """The page with the printed tables in place of those with the same head, the first for the first."""
    found = [lines for _, lines in tables(printed)]
    lines = page.splitlines()
    for start, old in reversed(list(tables(page))):
        same = [new for new in found if cells(new[0]) == cells(old[0])]
        if same:
            new = same[-1]
            found.remove(new)
            lines[start : start + len(old)] = new
    return "\n".join(lines) + "\n"


def differences(stored: str, made: str) -> list[str]:
    """The lines of two pages whose numbers or words differ, as "stored -> made"."""
    found, head = [], ""
    for old, new in zip_longest(stored.splitlines(), made.splitlines(), fillvalue=""):
        is_row = old.startswith("|")
        heads = cells(head) if is_row else []
        pairs = zip_longest(cells(old), cells(new), fillvalue="") if is_row else [(old, new)]
        if not all(equal(*pair, heads[k] if k < len(heads) else "") for k, pair in enumerate(pairs)):
            found.append(f"{old} -> {new}")
        head = (head or old) if is_row else ""
    return found


def equal(old: str, new: str, column: str) -> bool:
    """Whether two cells of a column, or two lines, say the same within `UNITS` and `SHARE`; noise may differ."""
    if NOISE.search(column):
        return True
    if NUMBER.sub("#", old) != NUMBER.sub("#", new):
        return False
    share = SHARE_OF_COUNTS if COUNTS.search(column) else SHARE
    for a, b in zip(NUMBER.finditer(old), NUMBER.finditer(new), strict=True):
        last = 10.0 ** (int(a[2] or 0) - len(a[1] or ""))
        if abs(float(a[0]) - float(b[0])) > max(UNITS * last, share * abs(float(a[0]))):
            return False
    return True


# -- programs ---------------------------------------------------------------------------------------------------------


def regenerate(page: Page, root: Path) -> list[str]:
    """Run a page's program in this tree and put its tables into the page; there is nothing to list.

    Raises
    ------
    subprocess.CalledProcessError
        The program failed.
    """
    path = root / page.path
    before = path.read_text(encoding="utf-8") if path.exists() else ""
    command = [sys.executable, str(root / page.program), *page.arguments.split()]
    environment = {"ERTEL_REFERENCE": str(REFERENCE), **os.environ}
    printed = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True).stdout
    if path.exists() and path.read_text(encoding="utf-8") == before:  # the program has not written it
        path.write_text(spliced(before, printed), encoding="utf-8")
    return []


def check(page: Page) -> list[str]:
    """The lines of a stored page that a new run does not confirm."""
    with tempfile.TemporaryDirectory() as place:
        for folder in ("validation", "benchmarks", "examples", "papers", "tests"):
            shutil.copytree(ROOT / folder, Path(place) / folder, ignore=shutil.ignore_patterns("__pycache__"))
        regenerate(page, Path(place))
        path = ROOT / page.path
        stored = path.read_text(encoding="utf-8") if path.exists() else ""
        return differences(stored, (Path(place) / page.path).read_text(encoding="utf-8"))


def chosen(words: list[str], most: float) -> list[Page]:
    """The pages that contain one of the words (the benchmarks only if asked for) and take so many minutes at most."""
    wanted = words or ["validation/"]
    return [page for page in PAGES if page.minutes <= most and any(w in f"{page.path} {page.program}" for w in wanted)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", help="parts of the paths of pages or programs")
    parser.add_argument("--most", type=float, default=float("inf"), help="minutes a page at most")
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    asked = parser.parse_args()
    differ = 0
    for page in chosen(asked.words, asked.most):
        print(f"{page.path}: python {page.program} {page.arguments}", flush=True)
        try:
            found = check(page) if asked.check else regenerate(page, ROOT)
        except subprocess.CalledProcessError as error:
            found = [str(error)]
        differ += len(found)
        print("".join(f"    {line}\n" for line in found), end="", flush=True)
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
