"""The gallery's scripts are short, say what they show, draw, and check a number; two run here on coarse grids."""

import ast
from pathlib import Path

import matplotlib
import pytest
from matplotlib import pyplot

GALLERY = Path(__file__).parents[1] / "examples/gallery"
SCRIPTS = {script.stem: script.read_text(encoding="utf-8") for script in sorted(GALLERY.glob("plot_*.py"))}
LONGEST = 60
COARSER = {
    "plot_bell_interferogram": {"nodes=151": "nodes=97"},
    "plot_film_against_speed": {"129)": "65)", "[0.25, 0.5, 1.0, 2.0]": "[2.0, 4.0]"},  # thick films
}
RUNS = [
    *((name, COARSER[name]) for name in COARSER),
    *(pytest.param(name, {}, marks=pytest.mark.slow) for name in SCRIPTS),
]


def test_scripts_are_ten_or_more_and_short_and_check_a_number():
    assert len(SCRIPTS) >= 10
    for name, text in SCRIPTS.items():
        tree = ast.parse(text)
        title, line, *_ = ast.get_docstring(tree).splitlines()
        assert len(title) == len(line) and set(line) == {"="}, name
        assert len(text.splitlines()) <= LONGEST, name
        assert any(isinstance(node, ast.Assert) for node in tree.body), name


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(("name", "coarser"), RUNS)
def test_a_script_runs(name, coarser):
    matplotlib.use("agg")
    text = SCRIPTS[name]
    for fine, coarse in coarser.items():
        assert fine in text
        text = text.replace(fine, coarse)
    exec(compile(text, name, "exec"), {"__name__": "__main__"})
    pyplot.close("all")
