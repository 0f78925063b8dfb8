"""The Python blocks of README and docs run, page by page in one process, and their links lead somewhere.

They run on grids of at most 65 nodes, as most pages have them; the full grids are `slow`.  A block that is only to be
read has `<!-- not run -->` on the line before it.
"""

import re
from pathlib import Path

import matplotlib
import pytest

import ertel

ROOT = Path(__file__).parents[1]
PAGES = sorted({ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").glob("*.md")})
BLOCK = re.compile(r"(?P<skip><!-- not run -->[ \t]*\n+)?```python\n(?P<code>.*?)\n```", re.DOTALL)
NODES = re.compile(r"\bnodes=(\d+)")
MOST_NODES = 65
LINK = re.compile(r"\]\((?!https?:)([^)#\s]+)")


def blocks(page: Path) -> list[tuple[int, str]]:
    """The blocks to be run, each with its line."""
    text = page.read_text(encoding="utf-8")
    found = [match for match in BLOCK.finditer(text) if not match["skip"]]
    return [(text.count("\n", 0, match.start("code")), match["code"]) for match in found]


def named(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def coarser(code: str) -> str:
    """The same code on coarser grids, with as many lines."""
    return NODES.sub(lambda found: f"nodes={min(int(found[1]), MOST_NODES)}", code)


WITH_CODE = {page: "".join(code for _, code in blocks(page)) for page in PAGES if blocks(page)}
RUNS = [
    *(pytest.param(page, coarser, id=named(page)) for page in WITH_CODE),
    *(
        pytest.param(page, str, id=f"{named(page)}-all nodes", marks=pytest.mark.slow)
        for page, code in WITH_CODE.items()
        if coarser(code) != code
    ),
]


@pytest.mark.filterwarnings("ignore::UserWarning:ertel", "ignore::UserWarning:__main__")
@pytest.mark.parametrize(("page", "made"), RUNS)
def test_python_of_the_documents_runs(page, made, tmp_path, monkeypatch):
    """In an empty directory that has the examples, on the names that the blocks before have left."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    matplotlib.use("agg")
    names = {"__name__": "__main__"}
    for line, code in blocks(page):
        exec(compile("\n" * line + made(code), str(page), "exec"), names)


@pytest.mark.parametrize("page", [page for page in PAGES], ids=named)
def test_links_of_the_documents_lead_somewhere(page):
    missing = [link for link in LINK.findall(page.read_text(encoding="utf-8")) if not (page.parent / link).exists()]
    assert missing == []


def test_every_public_name_is_on_the_pages_of_the_api():
    text = "\n".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs/api").glob("*.rst"))
    listed = {line.strip() for line in text.splitlines()} | set(re.findall(r"``ertel\.(\w+)``", text))
    assert set(ertel.__all__) - {"__version__"} - listed == set()


def test_blocks_are_found(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("a\n```python\nx = 1\n```\n<!-- not run -->\n```python\nx = 2\n```\n```sh\ny\n```\n")
    assert blocks(page) == [(2, "x = 1")]
