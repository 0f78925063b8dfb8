"""Random case files, valid and spoiled: none may hang, give a traceback, or be read as something else.

    python validation/faults/case_files.py --number 20000 --seed 1

Each file is either a case that reads back as the same case, or refused with one short printable line that names a
place.  Prints how many files had which outcome, the slowest file, and every failure with its file, which is kept
beside the failures; the exit code is 1 if there is any.
"""

import argparse
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from hypothesis import HealthCheck, Phase, given, seed, settings

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests" / "inputs"), str(ROOT / "tests")]
import SurfaceTopography  # noqa: E402, F401 - now, and not when the first file with a measured surface is read
from case_file_strategies import case_files, outcome  # noqa: E402

LONGEST = 10  # seconds; a file that takes longer hangs


def main() -> int:
    """Read the files and print the table."""
    options = parsed()
    folder = Path(options.keep or tempfile.mkdtemp(prefix="case-files-"))
    folder.mkdir(parents=True, exist_ok=True)
    counts: Counter[str] = Counter()
    slowest = (0.0, b"")

    @seed(options.seed)
    @settings(
        max_examples=options.number,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(content=case_files())
    def read(content: bytes) -> None:
        nonlocal slowest
        path = folder / "case.toml"
        path.write_bytes(content)
        start = time.monotonic()
        found = outcome_of(path)
        taken = time.monotonic() - start
        slowest = max(slowest, (taken, content))
        if taken > LONGEST:  # what reads a value may have caught the alarm and called it wrong input
            found = f"FAILED: takes {taken:.0f} s"
        counts[found.partition("\n")[0]] += 1
        if found.startswith("FAILED"):
            kept = folder / f"failure-{counts.total()}.toml"
            kept.write_bytes(content)
            print(f"{kept}: {found}\n", flush=True)

    read()
    print(f"seed {options.seed}, {counts.total()} case files")
    for name, count in sorted(counts.items(), key=lambda item: -item[1]):
        print(f"{count:8d}  {name}")
    (folder / "slowest.toml").write_bytes(slowest[1])
    print(f"slowest: {slowest[0]:.2f} s, {folder / 'slowest.toml'}")
    return int(any(name.startswith("FAILED") for name in counts))


def outcome_of(path: Path) -> str:
    """The outcome of a file, or "FAILED" with what happened."""
    try:
        with limited(LONGEST):
            return outcome(path)
    except Exception as error:
        return f"FAILED: {type(error).__name__}\n{traceback.format_exc(limit=-6)}"


@contextmanager
def limited(seconds: int) -> Iterator[None]:
    """Raise TimeoutError after some seconds."""

    def ring(number: int, frame: FrameType | None) -> None:
        raise TimeoutError(f"not read after {seconds} s")

    signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)


def parsed() -> argparse.Namespace:
    """The options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--number", type=int, default=20_000, help="case files to read")
    parser.add_argument("--seed", type=int, default=1, help="another seed reads other files")
    parser.add_argument("--keep", help="folder for the files that fail; default: a temporary one")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
