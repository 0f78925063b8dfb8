"""The figures of the paper: the page, the command, marks on made-up fields, and figures from small runs."""

import ast
import errno
import os
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from app_runs import raising
from boundary_layers import __main__ as program
from boundary_layers import beyond, figures, reduction, runs
from boundary_layers.figures import PaperFigure
from boundary_layers.pages import Drawn, side_by_side, to_csv
from boundary_layers.plans import FULL, LOADS, QUICK, SHOWN_LOAD
from boundary_layers.reduction import extrapolated, over_film
from boundary_layers.tasks import Failure, Task, run_tasks
from boundary_layers.waves import local_nabla2
from matplotlib.figure import Figure

import ertel
from ertel.case.status import Status
from ertel.physics import amplitude_reduction
from ertel.physics.scales import Parameters
from ertel.results import fronts

LONG = "a text that is longer than the fifty characters at which tables are cut off"


def square(x):
    return x**2


def fail():
    raise RuntimeError("no <film>")


def drawn_squares(results, plan):
    assert results["one"] == 4.0
    figure, x = Figure(), [results["one"]]
    figure.subplots().plot(x)
    table = pd.DataFrame({"y & z": ["1 & 2", LONG]})
    return Drawn(figure, "a < b", {"squares": pd.DataFrame({"x": x})}, {"c < d": table})


FAKE = {
    "fig1": PaperFigure("First", lambda plan: {"one": Task("one", square, (2.0,), 30.0)}, drawn_squares),
    "fig2": PaperFigure("Second", lambda plan: [Task("one", square, (2.0,), 30.0), Task("bad", fail)], drawn_squares),
}


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(figures, "FIGURES", FAKE)


def test_the_page_needs_no_network_and_has_everything(small, tmp_path):
    """The texts are whole and escaped; a figure whose runs failed is missing and says why."""
    file, missing = figures.make(["fig1", "fig2"], True, tmp_path)
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
    figures.make(["fig1"], True, tmp_path)
    assert figures.expected(["fig1", "fig2"], True, tmp_path, 2) == (2, 1, 0.0)
    table = side_by_side({"a": np.array([1.0, 2.5, np.nan]), "b": np.array([1 / 3])})
    assert to_csv(table) == "a,b\n1,0.333333333\n2.5,\n,\n"


def test_command_and_a_full_disk(small, tmp_path, monkeypatch, capsys):
    command = ["fig1", "--quick", "--out", str(tmp_path)]
    assert program.main(command) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "fig1.html")
    monkeypatch.setattr(figures, "make", raising(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))))
    assert program.main(command) == 1
    assert f"cannot write to {tmp_path}: No space left on device" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        program.main(["fig99"])


@pytest.mark.parametrize("plan", [QUICK, FULL])
def test_every_run_has_one_name_for_one_meaning(plan):
    """Two figures may share a run, but not a name for different runs."""
    every = [task for figure in figures.FIGURES.values() for task in runs.tasks_in(figure.runs(plan))]
    assert len({task.name for task in every}) == len({(task.name, repr(task.arguments)) for task in every})
    assert all(task.seconds > 0 for task in every)


@pytest.mark.parametrize("file", sorted(Path(figures.__file__).parent.glob("*.py")), ids=lambda file: file.stem)
def test_only_public_names_are_imported(file):
    """Names of `ertel.`, no modules below it and none of its rooms."""
    tree = [*ast.walk(ast.parse(file.read_text(encoding="utf-8")))]
    modules = {alias.name for node in tree if isinstance(node, ast.Import) for alias in node.names}
    of_modules = {
        (node.module, alias.name) for node in tree if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    modules |= {str(module) for module, _ in of_modules}
    assert {module for module in modules if module.startswith("ertel")} <= {"ertel"}
    names = {name for module, name in of_modules if module == "ertel"}
    assert all(hasattr(ertel, name) for name in names)
    assert names.isdisjoint(
        ["apps", "runs", "inputs", "results", "solvers", "equations", "case", "physics", "numerics"]
    )


M, L, WAVE = 200, 10, 0.4
X = np.linspace(-1.5, 1.5, 301)
SMALL = replace(
    QUICK,
    radial_nodes=129,
    impacts={(M, L): (WAVE,)},
    impact_grids=(33, 65),
    rolling={(M, L): (1.0, 1.5)},
    rolling_grids=(33, 65),
    twins=((M, L, WAVE, 0.6),),
    twin_grids=(33, 65),
    marched=(100, L, 1.0, 65),
    shown=(M, L),
    shaped={(M, L): (WAVE,)},
    oils={(M, L): (WAVE,)},
    soft={M: (WAVE,)},
    beyond_grids=(33, 65),
    straight=((M, L, 1.0),),
    straight_grids=(33, 65),
    starved={"impact": ((M, L),), "rolling": ((50, 10),)},
    starved_grids=(33, 65),
)


def test_extrapolation_and_its_bar():
    """Of errors with h^2 the limit is exact; with h the bar just reaches it."""
    second, first = extrapolated(0.5 + 0.04, 0.5 + 0.01), extrapolated(0.5 + 0.04, 0.5 + 0.02)
    assert second["limit"] == pytest.approx(0.5)
    assert first["limit"] - first["error"] == pytest.approx(0.5)
    p = Parameters.from_moes(M, L)
    assert over_film(p, WAVE) == pytest.approx(p.nabla2(WAVE))
    assert over_film(p, WAVE, 0.3, 0.7) == pytest.approx(float(local_nabla2(p, WAVE, 0.3, 0.7)))
    soft = Parameters.from_moes(M, 0)
    assert over_film(soft, WAVE) == pytest.approx(WAVE / (0.3135 * np.sqrt(soft.lambda_bar)))


def fading(amplitude):
    """What an impact leaves of one wave, and a front that comes to rest at 1, A^2 = 1 - (1 - T)^2."""
    T = np.linspace(0, 1, 101)
    dH = amplitude * np.cos(2 * np.pi * X / WAVE)
    names = [runs.wave_name(shape, runs.HEIGHT, WAVE) for shape in ("transverse", "rings")]
    return xr.Dataset(
        {
            "dH": (("wave", "X"), [dH, dH / 2]),
            "along": (("wave", "X"), [np.full_like(X, amplitude / 4)] * 2),
            "X_min": ("time", np.sqrt(1 - (1 - T) ** 2)),
            "Y_min": ("time", np.zeros_like(T)),
            "P_max": ("time", np.ones_like(T)),
        },
        {"X": X, "time": T, "frame": 1.0, "wave": names},
    )


def test_marks_of_other_shapes():
    marks = list(beyond.impacts_on_shapes({"impacts": {(M, L): [fading(0.6), fading(0.5)]}}, SMALL))
    assert [mark["kind"] for mark in marks] == ["transverse", "rings", "longitudinal"]
    assert [mark["coarse"] for mark in marks[:2]] == pytest.approx([0.6, 0.3], rel=1e-3)
    assert [mark["fine"] for mark in marks[:2]] == pytest.approx([0.5, 0.25], rel=1e-3)
    across, _, along = marks
    assert (along["coarse"], along["fine"]) == pytest.approx((0.15, 0.125))
    assert along["X"] == across["X"] == pytest.approx(0.7)
    speed, p = np.sqrt(1 - across["X"] ** 2) / across["X"], Parameters.from_moes(M, L)
    assert across["local"] == pytest.approx(float(local_nabla2(p, WAVE, speed)), rel=0.02)
    assert across["hertz"] == pytest.approx(float(local_nabla2(p, WAVE, speed, across["X"])), rel=0.02)


def test_figure_5():
    """The last complete wave of a response of constant amplitude 0.4."""
    known, name = fading(0.4), runs.wave_name("isotropic", runs.HEIGHT, WAVE)
    response = known.isel(wave=[0]).assign(shape=known["dH"], H=known["dH"][0]).assign_coords(wave=[name])
    results = {"smooth": {(M, L): known}, "waves": {(M, L): [None, response]}}
    made = reduction.deformed_waves(results, SMALL)
    [table] = made.tables.values()
    assert table.to_dict("list") == {"wavelength (a*)": ["0.4"], "X": ["0.700"], "A_d/A_i": ["0.400"]}
    assert list(made.data["dH"]) == ["X", "H", "dH/A_i, wavelength 0.4"]


def drawn(name, results, plan=SMALL):
    """A figure, for which what is not there yet is run."""
    needed = figures.FIGURES[name].runs(plan)
    for task in runs.tasks_in(needed):
        if task.name not in results:
            results[task.name] = task.function(*task.arguments)
    made = figures.FIGURES[name].draw(runs.in_place(needed, results), plan)
    assert made.caption and made.figure.axes
    assert all(len(table) and table.notna().all().all() for table in made.tables.values())
    assert all(np.isfinite(table.select_dtypes("number")).any().all() for table in made.data.values())
    return made


def turned(run):
    """A radial run turned round the centre: the result of an exact 2-D method."""
    x = xr.DataArray(np.linspace(-1.5, 1.5, 61), dims="X")
    X, Y = x.assign_coords(X=x), x.rename(X="Y").assign_coords(Y=x.values)
    last = run.isel(frame=run["frame"] == fronts.at_max_approach(run)["frame"])
    return last.drop_dims("r").assign(H=last["H"].interp(r=np.hypot(X, Y)).drop_vars("r"))


@pytest.fixture(scope="module")
def impacts(tmp_path_factory):
    needed = runs.smooth_runs(SMALL)
    radial = needed["radial"]
    done = run_tasks([*radial.values()], tmp_path_factory.mktemp("impacts"))
    return {**done, needed["plane"].name: turned(done[radial[SHOWN_LOAD].name])}


@pytest.mark.parametrize("name", ["fig1", "fig2", "fig3", "fig4"])
def test_figures_of_the_front(impacts, name):
    """The order of the results does not matter.  At the centre both methods agree."""
    made, other = (drawn(name, dict(results)) for results in (impacts.items(), reversed(impacts.items())))
    assert all(table.equals(other.tables[title]) for title, table in made.tables.items())
    assert name != "fig1" or list(made.tables["Full base fitted to the front"]["M"]) == [str(M) for M in LOADS]
    assert name != "fig3" or "0.00%)" in made.caption


def test_an_impact_that_gives_up_is_a_failure(monkeypatch, tmp_path):
    """Which impact does so is tested with the loop."""
    monkeypatch.setattr(ertel, "simulate", lambda case: SimpleNamespace(status=Status.FILM_VANISHED))
    [failure] = run_tasks([Task("thin", runs.smooth_impact, (1000, 10, {"nodes": 33}, 0.1))], tmp_path).values()
    assert isinstance(failure, Failure)
    assert failure.reason.startswith("RuntimeError: M = 1000, L = 10: the film vanishes on this grid; ")


@pytest.mark.slow
def test_figures_of_waves():
    results = {}  # what has been run already, shared by the figures
    made = drawn("fig6", results)
    assert 0.3 < made.data["rolling"]["limit"][0] < 0.8
    assert made.data["impact"]["last"].sum() == 1
    assert (drawn("fig7", results).data["impact"]["fine"] < 1.05).all()
    assert len(drawn("fig8", results).tables[f"Compared with {runs.USUAL}"]) == 2


@pytest.mark.slow
def test_a_starved_impact_follows_a_curve_like_that_of_rolling():
    made = drawn("fig9", {})
    fits = made.tables["Exponents of the curve"]
    assert list(fits["contact"]) == ["impact", "rolling"]
    assert fits["g"].astype(float).between(1.8, 3.2).all()
    shares = made.data["starved"]
    assert (shares["R"] < np.minimum(shares["r"], 1.0) + 0.02).all()


@pytest.mark.slow
def test_long_ridges_under_rolling():
    """Hardly deformed where they are short, nearly flat where they are long, as (15) has it with f = e."""
    nabla2 = Parameters.from_moes(M, L).nabla2(0.5)
    found = runs.ridged_rolling(M, L, 0.5, 65)
    assert found == pytest.approx(float(amplitude_reduction.ratio_left(nabla2, np.inf)), abs=0.2)
