"""The scripts of gallery and tutorials say what they show, draw, and check numbers; two run here on coarse grids."""

import ast
from pathlib import Path

import matplotlib
import pytest
from matplotlib import pyplot

ROOT = Path(__file__).parents[1]
LONGEST = {"gallery": 60, "tutorials": 240}  # lines of a script
FILES = [script for folder in LONGEST for script in sorted((ROOT / "examples" / folder).glob("plot_*.py"))]
SCRIPTS = {script.stem: script.read_text(encoding="utf-8") for script in FILES}
LARGEST_THUMBNAIL = 15_000  # bytes
COARSER = {
    "plot_bell_interferogram": {"nodes=151": "nodes=97"},
    "plot_film_against_speed": {"129)": "65)", "[0.25, 0.5, 1.0, 2.0]": "[2.0, 4.0]"},  # thick films
}
RUNS = [
    *((name, COARSER[name]) for name in COARSER),
    *(pytest.param(name, {}, marks=pytest.mark.slow) for name in SCRIPTS),
]


def test_scripts_are_thirteen_or_more_and_short_and_check_a_number():
    assert len(SCRIPTS) >= 13
    for script in FILES:
        name, text = script.stem, SCRIPTS[script.stem]
        tree = ast.parse(text)
        title, line, *_ = ast.get_docstring(tree).splitlines()
        assert len(title) == len(line) and set(line) == {"="}, name
        assert len(text.splitlines()) <= LONGEST[script.parent.name], name
        assert any(isinstance(node, ast.Assert) for node in tree.body), name


def test_every_script_has_a_small_thumbnail_for_pages_that_are_built_without_it():
    kept = {path.relative_to(ROOT / "docs/thumbnails"): path for path in (ROOT / "docs/thumbnails").glob("*/*.png")}
    assert set(kept) == {Path(script.parent.name, f"sphx_glr_{script.stem}_thumb.png") for script in FILES}
    assert max(path.stat().st_size for path in kept.values()) <= LARGEST_THUMBNAIL


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(("name", "coarser"), RUNS)
def test_a_script_runs(name, coarser, monkeypatch, tmp_path):
    matplotlib.use("agg")
    monkeypatch.chdir(tmp_path)
    text = SCRIPTS[name]
    for fine, coarse in coarser.items():
        assert fine in text
        text = text.replace(fine, coarse)
    exec(compile(text, name, "exec"), {"__name__": "__main__"})
    pyplot.close("all")
