"""The paper's figures: what they are made of, the page, and the command."""

import csv
import io
from collections.abc import Sequence

import numpy as np
import pytest
from matplotlib.figure import Figure
from test_sweep import Now
from typer.testing import CliRunner

from ertel.apps.boundary_layers import figures, front, page
from ertel.apps.boundary_layers.figures import PaperFigure
from ertel.apps.boundary_layers.page import Drawn, Table
from ertel.apps.cli import app
from ertel.runs.sweep import Task


def square(x: float) -> float:
    return x**2


def fail() -> float:
    raise RuntimeError("no <film>")


def drawn(results: Sequence[float], quick: bool) -> Drawn:
    figure = Figure()
    figure.subplots().plot(results)
    return Drawn(figure, "a < b", {"squares": {"x": np.array(results)}}, [Table(["x"], [["1 & 2"]])])


SMALL = {
    "fig1": PaperFigure("First", lambda quick: [Task("one", square, (2.0,), 30.0)], drawn),
    "fig2": PaperFigure("Second", lambda quick: [Task("one", square, (2.0,), 30.0), Task("bad", fail)], drawn),
}


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(figures, "FIGURES", SMALL)


def test_the_page_needs_no_network_and_has_everything(small, tmp_path):
    file, missing = figures.make(["fig1"], True, tmp_path, Now())
    text = file.read_text(encoding="utf-8")
    assert missing == {} and file.name == "fig1.html"
    assert "http" not in text and "src=" in text and "data:image/svg+xml;base64," in text
    assert "a &lt; b" in text and "1 &amp; 2" in text
    assert {"fig1.svg", "fig1.png", "fig1_squares.csv"} <= {path.name for path in tmp_path.iterdir()}


def test_a_figure_whose_runs_failed_is_missing_and_says_why(small, tmp_path):
    file, missing = figures.make(["fig1", "fig2"], True, tmp_path, Now())
    assert missing == {"fig2": "RuntimeError: no <film>"}
    assert "Not made: RuntimeError: no &lt;film&gt;" in file.read_text(encoding="utf-8")


def test_what_it_takes_is_known_before(small, tmp_path):
    assert figures.expected(["fig1", "fig2"], True, tmp_path, 2) == (2, 0, 30.0)
    figures.make(["fig1"], True, tmp_path, Now())
    assert figures.expected(["fig1", "fig2"], True, tmp_path, 2) == (2, 1, 0.0)


def test_columns_of_different_length_stand_side_by_side():
    rows = list(csv.reader(io.StringIO(page.to_csv({"a": np.array([1.0, 2.5]), "b": np.array([3.0])}))))
    assert rows == [["a", "b"], ["1", "3"], ["2.5", ""]]


def test_command(small, tmp_path):
    runner = CliRunner()
    done = runner.invoke(app, ["paper", "fig1", "--quick", "--out", str(tmp_path), "--jobs", "1", "--quiet"])
    assert done.exit_code == 0 and done.stdout.strip() == str(tmp_path / "fig1.html")
    assert runner.invoke(app, ["paper", "fig9", "--out", str(tmp_path)]).exit_code == 2


def test_every_run_has_one_name_for_one_meaning():
    """Two figures may share a run, but not a name for different runs."""
    for quick in (True, False):
        every = [task for figure in figures.FIGURES.values() for task in figure.tasks(quick)]
        assert len({task.name for task in every}) == len({(task.name, repr(task.arguments)) for task in every})
        assert all(task.seconds > 0 for task in every)


# -- the figures themselves, from small runs ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def impacts():
    radial = [front.smooth_impact(M, 10, {"method": "radial", "nodes": 101}, 0.03) for M in front.LOADS]
    return [*radial, front.smooth_impact(front.SHOWN, 10, {"nodes": 33, "half_width": 1.5}, 10.0)]


@pytest.mark.parametrize("name", ["fig1", "fig2", "fig3", "fig4"])
def test_figures_of_the_front(impacts, name):
    made = figures.FIGURES[name].draw(impacts, True)
    assert made.caption and made.figure.axes
    for columns in made.data.values():
        assert all(np.isfinite(values).any() for values in columns.values())
    for table in made.tables:
        assert table.rows and all(len(row) == len(table.head) for row in table.rows)


def test_an_impact_that_gives_up_is_a_failure():
    with pytest.raises(ValueError, match=r"solver\.nodes"):
        front.smooth_impact(1000, 10, {"method": "radial", "nodes": 3}, 0.1)
