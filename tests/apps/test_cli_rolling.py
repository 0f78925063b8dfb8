"""The command line and rolling contacts: runs from their start to their report."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from app_runs import given
from cases import ertel_, physics, stop_after
from matplotlib.figure import Figure

from ertel import plots
from ertel.inputs.case_files import load_case
from ertel.runs import stepping
from ertel.runs.directory import read_progress
from ertel.runs.drive import drive
from ertel.runs.stepping import StepLimits
from ertel.runs.store import RunStore, compute


@pytest.fixture
def empty_figures(monkeypatch):
    """What is drawn is tested with the figures."""
    monkeypatch.setattr(plots, "draw", lambda *_, **__: Figure())


def test_a_film_below_zero_fails_with_the_number_of_nodes(here):
    (here / "thin.toml").write_text('[contact]\nkind = "rolling"\nM = 20000\nL = 10\n[solver]\nnodes = 33\n')
    ran = ertel_("run", "thin.toml", code=1)
    assert "failed: the surfaces overlap" in ran.stderr
    assert "use solver.nodes >= 1409" in ran.stderr
    for text in (ran.stdout, ertel_("show", "runs/thin").stdout, ertel_("ls", "runs").stdout):
        assert "the film vanishes on this grid" in text
        assert "mu" not in text
        assert "computed" not in text


def test_run_show_and_plot(here, empty_figures):
    text = ertel_("run", "steady.toml").stdout
    for part in ("converged", "H_c", "error", "extrapolated", "nm", "Nijenbanning", "Hamrock", "computed", "%"):
        assert part in text
    assert text == ertel_("show", "runs/steady").stdout
    printed = ertel_("plot", "runs/steady").stdout.split()
    assert {Path(path).stem for path in printed} >= {"film", "pressure", "midlines", "convergence"}
    found = read_progress(here / "runs" / "steady")
    assert (found["status"], found["T"], found["step"], found["done"]) == ("converged", None, 2, 1.0)


def test_a_run_on_the_track_of_another(here, runs):
    options = (*given("lubricant.layer=0.2 um", "solver.nodes=33"), "--quiet")
    ertel_("run", "steady.toml", *options, "--out", "first")
    ertel_("run", "steady.toml", *options, "--out", "second", "--after", "first")
    first, second = (xr.open_zarr(here / name / "run.zarr") for name in ("first", "second"))
    assert load_case(here / "second" / "case.toml").track.extremes[1] == pytest.approx(float(first["oil"][:, -1].max()))
    assert float(second["H_c"][-1]) < float(first["H_c"][-1])
    assert "the run is an impact" in ertel_("run", "steady.toml", "--after", str(runs[0] / "small"), code=2).stderr


def test_a_run_under_way(here):
    run = RunStore.create(here / "cut", load_case("steady.toml"))
    for command in ("show", "plot"):
        ertel_(command, "cut", code=2)
    drive(run.run, [run, stop_after(1)], run.resume())
    run.flush()
    summary = json.loads(ertel_("show", "cut", "--json").stdout)
    assert (summary["status"], summary["nodes"]) == ("running", 33)


def test_a_transient_run_whole_and_resumed(here, empty_figures):
    text = ertel_("run", "transient.toml").stdout
    for part in ("at the last time", "H_c", "Nijenbanning", "steps"):
        assert part in text
    summary = json.loads(ertel_("show", "runs/transient", "--json").stdout)
    assert (summary["T"], summary["H_c_error"]) == (pytest.approx(0.3), None)
    assert {"steps", "newton_iterations", "krylov_iterations", "convolutions"} <= set(summary)
    assert {"max_approach", "restitution"}.isdisjoint(summary)
    data = RunStore.open(here / "runs" / "transient").dataset()
    w = 1 + 0.1 * np.sin(2 * np.pi * data["time"].values)
    np.testing.assert_allclose(data["w"].values, w, rtol=1e-12)
    np.testing.assert_allclose(data["F"].values, w, rtol=1e-3)
    assert np.all(data["U"].values == 1.0)
    assert summary["load"] == pytest.approx(2 * np.pi / 3 * w[-1], rel=1e-3)
    assert "overview.png" in {Path(path).name for path in ertel_("plot", "runs/transient").stdout.split()}
    compute(RunStore.create(here / "cut", load_case("transient.toml")), [stop_after(3)])
    ertel_("resume", "cut", "-q")
    xr.testing.assert_identical(physics(RunStore.open(here / "cut").dataset()), physics(data))


@pytest.mark.slow
def test_the_error_of_a_transient_run(here):
    short = ("run", "transient.toml", "--json", "--set", "time.until=0.1")
    fine = json.loads(ertel_(*short, "--error").stdout)
    coarse = json.loads(ertel_(*short, "--set", "solver.nodes=17").stdout)
    for name in ("H_c", "H_min"):
        parts = fine["error_estimate"][name]
        assert parts["grid"] == pytest.approx((fine[name] - coarse[name]) / 3)
        sizes = {part: abs(parts[part]) for part in ("grid", "time", "domain")}
        assert fine[f"{name}_error"] == pytest.approx(sum(size**2 for size in sizes.values()) ** 0.5)
        assert parts["dominant"] == max(sizes, key=sizes.get)


def test_a_transient_run_that_cannot_begin(here, monkeypatch):
    monkeypatch.setattr(stepping, "StepLimits", partial(StepLimits, smallest=10.0))
    result = ertel_("run", "transient.toml", code=1)
    assert "failed: " in result.stderr
    assert "No step was taken" in ertel_("show", "runs/transient").stdout
