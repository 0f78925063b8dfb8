"""The figures of the paper: the page, the command, and Figs. 1 to 4 from small runs."""

import ast
import errno
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from app_runs import raising, refused
from cases import ertel_
from matplotlib.figure import Figure

from ertel.apps import boundary_layers
from ertel.apps.boundary_layers import figures, front, runs
from ertel.apps.boundary_layers.figures import PaperFigure
from ertel.apps.boundary_layers.pages import Drawn, side_by_side, to_csv
from ertel.apps.boundary_layers.plans import FULL, LOADS, QUICK, SHOWN_LOAD, L, Plan
from ertel.apps.boundary_layers.runs import Results
from ertel.results import fronts
from ertel.runs.tasks import Task, run_tasks
from ertel.runs.workers import LocalWorker

LONG = "a text that is longer than the fifty characters at which tables are cut off"


def square(x: float) -> float:
    return x**2


def fail() -> float:
    raise RuntimeError("no <film>")


def drawn(results: Results, plan: Plan) -> Drawn:
    assert results == {"one": 4.0}
    figure, x = Figure(), [results["one"]]
    figure.subplots().plot(x)
    return Drawn(
        figure, "a < b", {"squares": pd.DataFrame({"x": x})}, {"c < d": pd.DataFrame({"y & z": ["1 & 2", LONG]})}
    )


SMALL = {
    "fig1": PaperFigure("First", lambda plan: [Task("one", square, (2.0,), 30.0)], drawn),
    "fig2": PaperFigure("Second", lambda plan: [Task("one", square, (2.0,), 30.0), Task("bad", fail)], drawn),
}


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(figures, "FIGURES", SMALL)


# -- page and command --------------------------------------------------------------------------------------------------


def test_the_page_needs_no_network_and_has_everything(small, tmp_path):
    """The texts are whole and escaped; a figure whose runs failed is missing and says why."""
    file, missing = figures.make(["fig1", "fig2"], True, tmp_path, LocalWorker())
    text = file.read_text(encoding="utf-8")
    assert missing == {"fig2": "RuntimeError: no <film>"} and file.name == "index.html"
    assert "http" not in text and 'src="data:image/svg+xml;base64,' in text
    assert 'download="fig1_squares.csv" href="data:text/csv;base64,' in text
    assert {"fig1.svg", "fig1.png", "fig1_squares.csv"} <= {path.name for path in tmp_path.iterdir()}
    said = "a &lt; b", "c &lt; d", "y &amp; z", "1 &amp; 2", LONG, "Not made: RuntimeError: no &lt;film&gt;"
    assert all(words in text for words in said)
    seen = [element.tag for element in ElementTree.fromstring(text).iter()]
    tags = ("html", "head", "title", "body", "section", "figure", "img")
    assert [seen.count(tag) for tag in tags] == [1, 1, 1, 1, 2, 1, 1]
    assert text.startswith("<!DOCTYPE html>")


def test_what_it_takes_is_known_before(small, tmp_path):
    assert figures.expected(["fig1", "fig2"], True, tmp_path, 2) == (2, 0, 30.0)
    figures.make(["fig1"], True, tmp_path, LocalWorker())
    assert figures.expected(["fig1", "fig2"], True, tmp_path, 2) == (2, 1, 0.0)


def test_columns_of_different_length_stand_side_by_side():
    table = side_by_side({"a": np.array([1.0, 2.5, np.nan]), "b": np.array([1 / 3])})
    assert to_csv(table) == "a,b\n1,0.333333333\n2.5,\n,\n"


def test_command_and_a_full_disk(small, tmp_path, monkeypatch):
    command = ("paper", "fig1", "--quick", "--out", str(tmp_path), "--jobs", "1", "--quiet")
    assert ertel_(*command).stdout.strip() == str(tmp_path / "fig1.html")
    assert "fig9" in refused("paper", "fig9", "--out", str(tmp_path))
    monkeypatch.setattr(figures, "make", raising(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))))
    said = refused(*command, code=1)
    assert f"cannot write to {tmp_path}: no space left on device; the same command continues" in said


@pytest.mark.parametrize("plan", [QUICK, FULL])
def test_every_run_has_one_name_for_one_meaning(plan):
    """Two figures may share a run, but not a name for different runs."""
    every = [task for figure in figures.FIGURES.values() for task in figure.tasks(plan)]
    assert len({task.name for task in every}) == len({(task.name, repr(task.arguments)) for task in every})
    assert all(task.seconds > 0 for task in every)


# -- the app is a user of the library ----------------------------------------------------------------------------------

PUBLIC = """
    ertel ertel.physics ertel.physics.surfaces ertel.results ertel.results.fronts ertel.results.waves
    ertel.plots.drawing ertel.runs.response ertel.runs.tasks ertel.runs.workers
"""  # what it may import of ertel
OWN = "ertel.apps.boundary_layers"


def imported(tree: ast.AST) -> Iterator[tuple[str, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from ((str(node.module), alias.name) for alias in node.names)


@pytest.mark.parametrize("file", sorted(Path(next(iter(boundary_layers.__path__))).glob("*.py")), ids=lambda f: f.stem)
def test_only_public_names_are_imported(file):
    found = [(module, name) for module, name in imported(ast.parse(file.read_text(encoding="utf-8")))]
    elsewhere = {module for module, _ in found if module.startswith("ertel") and not module.startswith(OWN)}
    assert elsewhere <= set(PUBLIC.split())
    assert not [name for _, name in found if name.startswith("_")]


# -- Figs. 1 to 4 from small runs --------------------------------------------------------------------------------------

COARSE = replace(QUICK, radial_nodes=101)


def turned(run: xr.Dataset) -> xr.Dataset:
    """A radial run turned round the centre: the result of an exact 2-D method."""
    x = xr.DataArray(np.linspace(-1.5, 1.5, 61), dims="X")
    X, Y = x.assign_coords(X=x), x.rename(X="Y").assign_coords(Y=x.values)
    last = run.isel(frame=run["frame"] == fronts.at_max_approach(run)["frame"])
    return last.drop_dims("r").assign(H=last["H"].interp(r=np.hypot(X, Y)).drop_vars("r"))


@pytest.fixture(scope="module")
def impacts() -> Results:
    tasks = front.radial_tasks(COARSE)
    done = dict(zip([task.name for task in tasks], run_tasks(tasks, LocalWorker()), strict=True))
    return {**done, runs.plane_run(COARSE).name: turned(done[runs.radial_run(COARSE, (SHOWN_LOAD, L)).name])}


@pytest.mark.parametrize("name", ["fig1", "fig2", "fig3", "fig4"])
def test_figures_of_the_front(impacts, name):
    made = figures.FIGURES[name].draw(impacts, COARSE)
    assert made.caption and made.figure.axes
    assert all(np.isfinite(table).any().all() for table in made.data.values())
    for table in made.tables.values():
        assert len(table) and table.notna().all().all()


def test_figures_find_their_runs_by_name(impacts):
    """The order of the results does not matter.  At the centre both methods agree."""
    assert "0.00%)" in figures.FIGURES["fig3"].draw(impacts, COARSE).caption
    usual, other = (front.dry_impact(runs, COARSE) for runs in (impacts, dict(reversed(impacts.items()))))
    for title, table in usual.tables.items():
        assert table.equals(other.tables[title])
    assert list(usual.tables["Full base fitted to the front"]["M"]) == [str(M) for M in LOADS]


def test_an_impact_that_gives_up_is_a_failure():
    with pytest.raises(ValueError, match=r"solver\.nodes"):
        runs.smooth_impact(1000, 10, {"method": "radial", "nodes": 3}, 0.1)
