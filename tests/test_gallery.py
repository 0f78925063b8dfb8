"""The gallery's scripts are short, say what they show, draw, and check a number; two run here on coarse grids."""

import ast
from pathlib import Path

import matplotlib
import pytest
from matplotlib import pyplot

GALLERY = Path(__file__).parents[1] / "examples/gallery"
SCRIPTS = sorted(GALLERY.glob("plot_*.py"))
LONGEST = 60
COARSER = {
    "plot_bell_interferogram": {"nodes=151": "nodes=97"},
    "plot_film_against_speed": {"129)": "65)", "[0.25, 0.5, 1.0, 2.0]": "[2.0, 4.0]"},  # thick films
}


def named(script: Path) -> str:
    return script.stem


def test_there_are_ten():
    assert len(SCRIPTS) >= 10


@pytest.mark.parametrize("script", SCRIPTS, ids=named)
def test_a_script_is_short_and_checks_a_number(script):
    text = script.read_text(encoding="utf-8")
    tree = ast.parse(text)
    title, line, *_ = ast.get_docstring(tree).splitlines()
    assert len(title) == len(line) and set(line) == {"="}
    assert len(text.splitlines()) <= LONGEST
    assert any(isinstance(node, ast.Assert) for node in tree.body)


def run(text: str, name: str) -> None:
    matplotlib.use("agg")
    exec(compile(text, name, "exec"), {"__name__": "__main__"})
    pyplot.close("all")


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", COARSER)
def test_a_script_runs_on_a_coarse_grid(name):
    text = (GALLERY / f"{name}.py").read_text(encoding="utf-8")
    for fine, coarse in COARSER[name].items():
        assert fine in text
        text = text.replace(fine, coarse)
    run(text, name)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("script", SCRIPTS, ids=named)
def test_a_script_runs(script):
    run(script.read_text(encoding="utf-8"), script.name)
