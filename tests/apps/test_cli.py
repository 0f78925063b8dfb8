"""The command line: what it prints and where, its exit codes, and that wrong input leaves nothing behind."""

import json
import re
import signal
from pathlib import Path

import pytest
import xarray as xr
from app_runs import CASE_FILES, given, raising, refused
from cases import ertel_, names
from matplotlib.figure import Figure

import ertel
from ertel import plots
from ertel.apps import about
from ertel.inputs.case_files import load_case
from ertel.runs import compile, store
from ertel.runs.directory import ask_to_stop, is_asked_to_stop, read_progress
from ertel.runs.store import RunStore


def numbers(*arguments):
    return json.loads(ertel_(*arguments, "--json").stdout)


def test_version_and_about(monkeypatch):
    assert ertel_("--version").stdout == f"ertel {ertel.__version__}\n"
    text = ertel_("about").stdout
    for said in (ertel.__version__, "NumPy", "cpu", str(compile.cache_directory()), "Tribology"):
        assert said in text
    monkeypatch.setattr(about, "version", lambda package: "0.11.0")  # it computes wrongly
    assert 'pip install "jax!=0.10.2,!=0.11.0"' in ertel_("about").stdout


def test_run_tells_what_it_stores(runs):
    folder, printed = runs
    assert f"{RunStore.open(folder / 'small').summary()['H_c']:.5g}" in printed["small"]
    assert "Warning: the film is not resolved at the front" in printed["small"]  # 33 nodes do not resolve it
    assert f"ertel plot {folder / 'small'}" in printed["small"] and "M = 200, L = 10" in printed["small"]


def test_a_second_run_gets_its_own_directory_and_is_as_quiet_unless_jax_computes_wrongly(here, monkeypatch):
    command = ("run", "ball.toml", "--quiet", *given("time.until=0.02", "contact.mass=30 g"))
    for _ in range(2):
        assert ertel_(*command).output == ""
    assert names(here / "runs") == {"ball", "ball-2"}
    case = RunStore.open(here / "runs" / "ball").case
    assert (case.contact.mass, case.time.until) == (pytest.approx(0.03), 0.02)
    monkeypatch.setattr(compile, "version", lambda package: "0.10.2")
    compile.check_jax.cache_clear()
    assert refused(*command, code=0) == f"ertel: warning: {compile.wrong_version('0.10.2')}\n"


@pytest.mark.slow
def test_error_estimate(here):
    """Of a run that has ended.  It is that of a run on the half grid; the parts are tested with the loop."""
    radial = ("run", "small.toml", *given("solver.method=radial"))
    before = numbers(*radial, "--out", "fine", *given("solver.nodes=33"))
    fine = numbers("resume", "fine", "--error")
    assert not before.get("error_estimate") and before["H_c"] == fine["H_c"]
    at_once = numbers(*radial, "--out", "at once", "--error", *given("solver.nodes=33"))
    assert at_once["error_estimate"] == fine["error_estimate"]
    assert numbers("show", "fine") == fine
    half = numbers(*radial, "--out", "half", *given("solver.nodes=17"))
    assert list(fine["error_estimate"]) == ["T", "H_c", "H_min", "P_c", "Delta", "F", "power_loss"]
    estimate = fine["error_estimate"]["H_c"]
    assert estimate["grid"] == pytest.approx((fine["H_c"] - half["H_c"]) / 3, rel=1e-12)
    shown = ertel_("show", "fine").stdout
    assert re.search(rf"error is that of the {estimate['dominant']} in .*H_c", shown) and "on the grid" in shown


def test_a_full_disk_and_a_run_that_gives_up(here, monkeypatch):
    """What they store is tested with the store."""
    monkeypatch.setattr(RunStore, "_write_checkpoint", raising(OSError(28, "No space left on device")))
    said = ertel_("run", "ball.toml", code=1).stderr
    assert "cannot write to runs/ball: no space left on device; to continue: ertel resume runs/ball" in said
    summary = {"kind": "impact", "M": 200.0, "L": 10.0, "status": "the time step became too small"}
    monkeypatch.setattr(store, "compute", lambda *_: summary)
    result = ertel_("run", "small.toml", "--out", "b", "-q", code=1)
    assert "failed: the time step became too small; refine the grid" in result.stderr
    assert "Results so far are in b" in result.stderr


@pytest.mark.parametrize(
    ("ask", "code"),
    [(lambda run: signal.raise_signal(signal.SIGTERM), 143), (ask_to_stop, 130)],
    ids=["SIGTERM", "file"],
)
def test_interrupt_and_resume(here, ball, monkeypatch, ask, code):
    """A file from before does not stop a run, and none is left."""
    original = RunStore.__call__

    def take(self, step):
        original(self, step)
        if step.state.counts.steps == 2:
            ask(self.directory)

    with monkeypatch.context() as patch:
        patch.setattr(RunStore, "__call__", take)
        said = refused("run", "ball.toml", "-q", "--out", "cut off", code=code)
    assert said == "ertel: interrupted; to continue: ertel resume 'cut off'\n"
    assert numbers("show", "cut off")["steps"] == 2
    assert not is_asked_to_stop(here / "cut off")
    ask_to_stop(here / "cut off")
    ertel_("resume", "cut off", "-q")
    assert not is_asked_to_stop(here / "cut off")
    whole, resumed = (RunStore.open(path).dataset() for path in (ball, here / "cut off"))
    assert whole.drop_attrs(deep=False).identical(resumed.drop_attrs(deep=False))


def test_formulas_side_by_side_and_of_a_contact_that_is_too_light_to_run(here):
    """Hamrock and Dowson's, and Nijenbanning's, of the case in SI of reference/rolling.json."""
    rolls = "check", "steady.toml", *given("contact.load=38.885237 N")
    films = {film["name"]: film["si"] for film in numbers(*rolls)["films"]}
    assert films["Hamrock-Dowson"] == pytest.approx({"h_c_m": 167.8e-9, "h_min_m": 95.7e-9}, rel=1e-3)
    assert films["Nijenbanning-Venner-Moes"]["h_c_m"] == pytest.approx(172.9e-9, rel=1e-3)
    assert films["Nijenbanning-Venner-Moes"]["h_min_m"] is None
    text = ertel_(*rolls).stdout
    assert all(part in text for part in ("p_h_Pa", "167.8 nm", "95.71 nm", "172.9 nm"))
    first, *_ = numbers("check", *given("contact.kind=rolling", "contact.M=20", "contact.L=10"))["films"]
    assert first["central"] > 0 and "si" not in first and first["source"]
    # A ball of 3 mm under 2 mN: the formulas are printed before the refusal.
    ball = ("kind=rolling", "radius=3 mm", "load=2 mN", "mean_speed=2 m/s", "E_prime=226 GPa")
    light = [f"contact.{entry}" for entry in ball] + ["lubricant.eta0=50 mPa*s", "lubricant.alpha=22 / GPa"]
    told = ertel_("check", *given(*light), code=2)
    assert "9.458 mm" in told.stdout and "a rigid ball's" in told.stderr
    assert "ertel check" not in told.stderr
    told = ertel_("check", "--json", *given(*light), code=2)
    assert json.loads(told.stdout)["films"][0]["central"] > 0 and "M = " in told.stderr


def test_run_show_and_plot(here, monkeypatch):
    monkeypatch.setattr(plots, "draw", lambda *_, **__: Figure())  # what is drawn is tested with the figures
    text = ertel_("run", "steady.toml").stdout
    for part in ("converged", "H_c", "error", "on the grid", "nm", "Nijenbanning", "Hamrock", "computed", "%"):
        assert part in text
    assert text == ertel_("show", "runs/steady").stdout
    printed = ertel_("plot", "runs/steady").stdout.split()
    assert {Path(path).stem for path in printed} >= {"film", "pressure", "midlines", "convergence"}
    found = read_progress(here / "runs" / "steady")
    assert (found["status"], found["T"], found["step"], found["done"]) == ("converged", None, 2, 1.0)


@pytest.mark.slow
def test_a_run_on_the_track_of_another(here, runs):
    options = (*given("lubricant.layer=0.2 um", "solver.nodes=33"), "--quiet")
    ertel_("run", "steady.toml", *options, "--out", "first")
    ertel_("run", "steady.toml", *options, "--out", "second", "--after", "first")
    first, second = (xr.open_zarr(here / name / "run.zarr") for name in ("first", "second"))
    assert load_case(here / "second" / "case.toml").track.extremes[1] == pytest.approx(float(first["oil"][:, -1].max()))
    assert float(second["H_c"][-1]) < float(first["H_c"][-1])
    assert "the run is an impact" in ertel_("run", "steady.toml", "--after", str(runs[0] / "small"), code=2).stderr


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("--error --set solver.nodes=17", "solver.nodes = 9"),
        ("--flush -1", "Invalid value for '--flush'"),
        ("--out taken", "taken: exists already; choose another --out"),
        ("--out small.toml/sub", "small.toml/sub: cannot write there"),
    ],
)
def test_wrong_input(here, command, said):
    (here / "taken").mkdir()
    (here / "taken" / "file").write_text("")
    assert said in refused("run", "small.toml", *command.split())
    assert names(here) == {*CASE_FILES, "taken"} and names(here / "taken") == {"file"}
