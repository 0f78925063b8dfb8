"""The Python blocks of README and docs run, page by page in one process, and their links lead somewhere.

They run on grids of at most 33 nodes, or as many more as they need; the full grids are `slow`.  A block that is only to
be read has `<!-- not run -->` on the line before it.

The scripts of gallery and tutorials say what they show, draw, and check numbers; two run here on coarse grids.
"""

import ast
import re
from pathlib import Path

import matplotlib
import pytest
from matplotlib import pyplot

import ertel

ROOT = Path(__file__).parents[1]
PAGES = sorted({ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").glob("*.md")})
BLOCK = re.compile(r"(?P<skip><!-- not run -->[ \t]*\n+)?```python\n(?P<code>.*?)\n```", re.DOTALL)
NODES = re.compile(r"\bnodes=(\d+)")
MOST_NODES = 33
AT_LEAST = {"docs/howto/convergence.md": 65}  # an error is estimated from there on
SLOW = {"docs/howto/impact_viscometer.md", "docs/howto/convergence.md", "docs/howto/printing.md"}  # many programs
LINK = re.compile(r"\]\((?!https?:)([^)#\s]+)")


def blocks(text: str) -> list[str]:
    """The blocks of a page that are to be run, each below as many empty lines as stand above it in the page."""
    found = [match for match in BLOCK.finditer(text) if not match["skip"]]
    return ["\n" * text.count("\n", 0, match.start("code")) + match["code"] for match in found]


def coarser(code: str, page: str) -> str:
    """The same code on coarser grids, with as many lines."""
    return NODES.sub(lambda found: f"nodes={min(int(found[1]), AT_LEAST.get(page, MOST_NODES))}", code)


TEXTS = {page.relative_to(ROOT).as_posix(): page.read_text(encoding="utf-8") for page in PAGES}
CODES = {page: blocks(text) for page, text in TEXTS.items() if blocks(text)}
FINE = [page for page, codes in CODES.items() if [coarser(code, page) for code in codes] != codes]
RUNS = [
    *(pytest.param(page, coarser, id=page, marks=[pytest.mark.slow] if page in SLOW else []) for page in CODES),
    *(pytest.param(page, lambda code, page: code, id=f"{page}-all nodes", marks=pytest.mark.slow) for page in FINE),
]


@pytest.mark.filterwarnings("ignore::UserWarning:ertel", "ignore::UserWarning:__main__")
@pytest.mark.parametrize(("page", "made"), RUNS)
def test_python_of_the_documents_runs(page, made, tmp_path, monkeypatch):
    """In an empty directory that has the examples, on the names that the blocks before have left."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    matplotlib.use("agg")
    names = {"__name__": "__main__"}
    for code in CODES[page]:
        exec(compile(made(code, page), page, "exec"), names)


def test_links_of_the_documents_lead_somewhere():
    links = [(page, link) for page, text in TEXTS.items() for link in LINK.findall(text)]
    assert [(page, link) for page, link in links if not ((ROOT / page).parent / link).exists()] == []
    text = "\n".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs/api").glob("*.rst"))
    listed = {line.strip() for line in text.splitlines()} | set(re.findall(r"``ertel\.(\w+)``", text))
    assert set(ertel.__all__) - {"__version__"} - listed == set()
    text = "a\n```python\nx = 1\n```\n<!-- not run -->\n```python\nx = 2\n```\n```sh\ny\n```\n"
    assert blocks(text) == ["\n\nx = 1"]


LONGEST = {"gallery": 60, "tutorials": 240}  # lines of a script
FILES = [script for folder in LONGEST for script in sorted((ROOT / "examples" / folder).glob("plot_*.py"))]
SCRIPTS = {script.stem: script.read_text(encoding="utf-8") for script in FILES}
LARGEST_THUMBNAIL = 15_000  # bytes
THICK_FILMS = {"129)": "65)", "[0.25, 0.5, 1.0, 2.0]": "[2.0, 4.0]"}  # what is replaced by what
SCRIPTS_RUN = [
    ("plot_film_against_speed", THICK_FILMS),
    *(pytest.param(name, {}, marks=pytest.mark.slow) for name in SCRIPTS),
]


def test_scripts_are_short_check_a_number_and_have_a_small_thumbnail():
    assert len(SCRIPTS) >= 13
    for script in FILES:
        name, text = script.stem, SCRIPTS[script.stem]
        tree = ast.parse(text)
        title, line, *_ = ast.get_docstring(tree).splitlines()
        assert len(title) == len(line) and set(line) == {"="}, name
        assert len(text.splitlines()) <= LONGEST[script.parent.name], name
        assert any(isinstance(node, ast.Assert) for node in tree.body), name
    kept = {path.relative_to(ROOT / "docs/thumbnails"): path for path in (ROOT / "docs/thumbnails").glob("*/*.png")}
    assert set(kept) == {Path(script.parent.name, f"sphx_glr_{script.stem}_thumb.png") for script in FILES}
    assert max(path.stat().st_size for path in kept.values()) <= LARGEST_THUMBNAIL


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(("name", "changes"), SCRIPTS_RUN)
def test_a_script_runs(name, changes, monkeypatch, tmp_path):
    matplotlib.use("agg")
    monkeypatch.chdir(tmp_path)
    text = SCRIPTS[name]
    for fine, coarse in changes.items():
        assert fine in text
        text = text.replace(fine, coarse)
    exec(compile(text, name, "exec"), {"__name__": "__main__"})
    pyplot.close("all")
