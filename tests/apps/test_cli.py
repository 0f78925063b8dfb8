"""The command line: what it prints and where, its exit codes, and that wrong input leaves nothing behind."""

import json
import os
import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import pytest
from cases import ertel_, names

import ertel
from ertel.runs import store

MOES = """
[contact]
M = 200
L = 10
[solver]
nodes = 33
[time]
tolerance = 0.01
"""
BALL = """
[contact]
radius = "10 mm"
mass = "32.6726 g"
speed = "0.1 m/s"
E_prime = "226.37 GPa"
[lubricant]
eta0 = "10 mPa*s"
alpha = "22 / GPa"
[solver]
nodes = 33
[time]
tolerance = 0.01
until = 1.2
"""
SOURCE = str(Path(ertel.__path__[0]).parent)
SUMMARY_KEYS = [
    *("kind", "lambda_bar", "alpha_bar", "M", "L", "max_approach", "restitution", "steps", "newton_iterations"),
    *("krylov_iterations", "convolutions", "compilations", "wall_s", "status"),
]


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working directory with a case in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(MOES)
    (tmp_path / "ball.toml").write_text(BALL)
    return tmp_path


# -- answers at once --------------------------------------------------------------------------------------------------


def test_version():
    assert ertel_("--version").stdout == f"ertel {ertel.__version__}\n"


def test_help_names_the_commands():
    text = ertel_("--help").stdout
    assert all(command in text for command in ("run", "resume", "show", "plot", "params"))


@pytest.mark.parametrize("command", ["run", "resume", "show", "plot", "params"])
def test_help_of_commands(command):
    assert "--help" in ertel_(command, "--help").stdout


# -- run --------------------------------------------------------------------------------------------------------------


def test_run_stores_and_tells(here):
    result = ertel_("run", "small.toml")
    assert names(here / "runs" / "small") == {"case.toml", "run.zarr", "checkpoint.npz", "summary.json"}
    summary = json.loads((here / "runs" / "small" / "summary.json").read_text())
    assert set(SUMMARY_KEYS) <= set(summary)
    assert list(summary["max_approach"]) == ["T", "Delta", "F", "P_c", "P_max", "H_c", "H_min", "X_min"]
    assert summary["status"] == "converged"
    assert summary["restitution"] is None
    assert "M = 200, L = 10" in result.stdout
    assert f"{summary['max_approach']['H_c']:.5g}" in result.stdout
    assert "Warning: the front" in result.stdout  # 33 nodes do not resolve it
    assert "ertel plot runs/small" in result.stdout


def test_run_json_is_json_and_nothing_else(here):
    result = ertel_("run", "ball.toml", "--out", "here", "--json")
    assert result.stdout == (here / "here" / "summary.json").read_text()
    summary = json.loads(result.stdout)
    assert summary["max_approach"] is None  # it ends before
    assert summary["si"]["p_h_Pa"] == pytest.approx(1.39361e9, rel=1e-5)
    assert summary["si"]["max_approach"] is None


def test_run_quiet(here):
    result = ertel_("run", "ball.toml", "--quiet")
    assert result.output == ""
    assert (here / "runs" / "ball").is_dir()


def test_second_run_gets_its_own_directory(here):
    for _ in range(2):
        ertel_("run", "ball.toml", "-q", "--set", "time.until=0.1")
    assert names(here / "runs") == {"ball", "ball-2"}


def test_set_overrides(here):
    ertel_("run", "small.toml", "--out", "a", "-q", "--set", "time.until=0.1", "--set", "contact.M=300")
    case = store.RunStore.open(here / "a").case
    assert (round(case.parameters.M, 9), case.time.until) == (300, 0.1)


def test_error_estimate(here):
    summary = json.loads(ertel_("run", "small.toml", "--json", "--error", "--set", "solver.nodes=65").stdout)
    half = json.loads(ertel_("run", "small.toml", "--json").stdout)
    assert list(summary["error_estimate"]) == ["H_c", "H_min", "Delta_max"]
    H_c = summary["error_estimate"]["H_c"]
    fine, coarse = summary["max_approach"]["H_c"], half["max_approach"]["H_c"]
    assert H_c == {
        "value": fine,
        "half_grid": coarse,
        "error": abs(fine - coarse) / 3,
        "extrapolated": fine + (fine - coarse) / 3,
    }
    assert "extrapolated" in ertel_("show", "runs/small").stdout


def test_run_that_gives_up(here, monkeypatch):
    monkeypatch.setattr(import_module("ertel.runs.drive"), "SMALLEST_STEP", 0.02)
    monkeypatch.setattr(import_module("ertel.runs.drive"), "FIRST_STEP", 0.03)
    result = ertel_("run", "small.toml", code=1)
    assert "failed: the time step became too small" in result.stderr
    assert "runs/small" in result.stderr
    summary = json.loads((here / "runs" / "small" / "summary.json").read_text())
    assert summary["status"] == "the time step became too small"
    assert summary["steps"] > 0


def test_full_disk(here, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(store.RunStore, "_write_checkpoint", full)
    result = ertel_("run", "small.toml", code=1)
    assert "cannot write to runs/small: no space left on device; to continue: ertel resume runs/small" in result.stderr


# -- interrupted ------------------------------------------------------------------------------------------------------


def test_interrupt_and_resume(here, monkeypatch):
    ertel_("run", "small.toml", "--out", "whole", "-q")
    original = store.TransientStore.append

    def append(self, step):
        original(self, step)
        if step.state.counts.steps == 5:
            signal.raise_signal(signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(store.TransientStore, "append", append)
        result = ertel_("run", "small.toml", "--out", "cut", code=130)
    assert "interrupted; to continue: ertel resume cut" in result.stderr
    assert json.loads(ertel_("show", "cut", "--json").stdout)["steps"] == 5
    ertel_("resume", "cut", "-q")
    whole, resumed = (store.RunStore.open(here / name).dataset() for name in ("whole", "cut"))
    assert whole.drop_attrs(deep=False).identical(resumed.drop_attrs(deep=False))


def test_interrupt_of_the_half_grid(here, monkeypatch):
    def interrupted(case, on_step):
        signal.raise_signal(signal.SIGINT)
        for step in ertel.transient(case):
            on_step(step)

    with monkeypatch.context() as patch:
        patch.setattr(import_module("ertel.runs.drive"), "simulate", interrupted)
        result = ertel_("run", "small.toml", "--error", "--set", "solver.nodes=65", code=130)
    assert "to continue: ertel resume runs/small" in result.stderr
    ertel_("show", "runs/small", code=2)  # nothing to show yet
    ertel_("resume", "runs/small", "-q")
    assert json.loads(ertel_("show", "runs/small", "--json").stdout)["status"] == "converged"


def test_resume_of_a_finished_run_shows_it(here):
    summary = ertel_("run", "ball.toml", "--out", "a", "--json").stdout
    assert ertel_("resume", "a", "--json").stdout == summary
    assert ertel_("show", "a", "--json").stdout == summary


@pytest.mark.skipif(os.name == "nt", reason="no SIGINT to another process")
def test_control_c(here):
    """A real one, at a real process."""
    command = [sys.executable, "-m", "ertel", "run", "small.toml", "--set", "time.step=1e-5"]
    with subprocess.Popen(command, env={**os.environ, "PYTHONPATH": SOURCE}, stderr=subprocess.PIPE) as process:
        while not (here / "runs" / "small").exists():
            time.sleep(0.05)
        time.sleep(2.0)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert b"to continue: ertel resume runs/small" in said


# -- show, plot, params -----------------------------------------------------------------------------------------------


def test_show_si(here):
    ertel_("run", "ball.toml", "-q", "--set", "time.until=max-approach")
    text = ertel_("show", "runs/ball").stdout
    assert "in SI" in text
    assert "GPa" in text
    assert "µm" in text


def test_show_of_a_run_under_way(here, monkeypatch):
    def die(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(store, "FLUSH_INTERVAL", -1.0)
        patch.setattr(store.RunStore, "finish", die)
        ertel_("run", "small.toml", code=130)
    result = ertel_("show", "runs/small", "--json")
    assert json.loads(result.stdout)["status"] == "running"


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_plot(here, kind):
    ertel_("run", "ball.toml", "--out", "a", "-q")
    printed = ertel_("plot", "a", "--format", kind).stdout.split()
    pictures = {f"{name}.{kind}" for name in ("overview", "maps", "profiles", "history")}
    assert names(here / "a" / "plots") == pictures
    assert {Path(path).name for path in printed} == pictures
    start = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[kind]
    assert (here / "a" / "plots" / f"overview.{kind}").read_bytes().startswith(start)


def test_plot_elsewhere(here):
    ertel_("run", "ball.toml", "--out", "a", "-q")
    ertel_("plot", "a", "--out", "pictures/of/it")
    assert "maps.png" in names(here / "pictures" / "of" / "it")


def test_params_from_moes():
    content = json.loads(ertel_("params", "--M", "1000", "--L", "10", "--json").stdout)
    assert content["lambda_bar"] == pytest.approx(0.00109777359, rel=1e-8)
    assert content["trapped_film"] == pytest.approx(0.1)
    assert "si" not in content


PHYSICAL = {
    "--radius": "10 mm",
    "--mass": "32.6726 g",
    "--speed": "0.1 m/s",
    "--E-prime": "226.37 GPa",
    "--eta0": "0.1 Pa*s",
    "--alpha": "22 / GPa",
}


def test_params_from_quantities():
    """The dimensional example of reference/impact.json."""
    flags = [word for pair in PHYSICAL.items() for word in pair]
    content = json.loads(ertel_("params", *flags, "--json").stdout)
    expected = {"stokes": 17.3333, "lambda_bar": 0.0615385, "alpha_bar": 30.6595, "M": 48.8118, "L": 23.0237}
    scales = {"delta_m": 3.74064e-06, "a_m": 0.000193407, "F_N": 109.181, "p_h_Pa": 1393610000.0, "t0_s": 3.74064e-05}
    for found, wanted in ((content, expected), (content["si"], scales | {"contact_time_s": 0.000110098})):
        assert {key: found[key] for key in wanted} == pytest.approx(wanted, rel=1e-5)
    assert "p_h_Pa" in ertel_("params", *flags).stdout


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--M", "1000"], "contact.L: missing"),
        (["--M", "1000", "--L", "10", "--lambda-bar", "1"], "given together"),
        (["--radius", "10"], 'contact.radius = "10": must be a quantity'),
        (["--M", "nan", "--L", "1"], "contact.M = NaN"),
        ([], "contact.M: missing"),
    ],
)
def test_params_refused(flags, said):
    result = ertel_("params", *flags, code=2)
    assert said in result.stderr
    assert result.stdout == ""


# -- wrong input: code 2, one line on stderr, nothing on stdout, nothing written ---------------------------------------


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "no.toml"], "no.toml: no such file"),
        (["run", "."], "cannot read the case file ."),
        (["run", "small.toml", "--set", "solver.node=9"], "solver.node = 9: unknown key; did you mean nodes?"),
        (["run", "small.toml", "--set", "solver.nodes=100"], "solver.nodes = 100: must be"),
        (["run", "small.toml", "--set", "solver.nodes"], "--set solver.nodes: must be section.key=value"),
        (["run", "small.toml", "--set", "contact.radius=10 mm"], 'contact.radius = "10 mm" are given together'),
        (["run", "small.toml", "--set", "contact.M=nan"], "contact.M = NaN: must be a finite number"),
        (["run", "small.toml", "--set", "contact.M=0"], "contact.M = 0: must be greater than 0"),
        (["run", "ball.toml", "--set", "contact.radius=-1 mm"], 'contact.radius = "-1 mm": must be'),
        (["run", "ball.toml", "--set", "contact.radius=1 kg"], 'contact.radius = "1 kg": has the wrong dimension'),
        (["run", "ball.toml", "--set", "contact.drop_height=1 m"], "are given together"),
        (["run", "small.toml", "--error", "--set", "solver.nodes=17"], "solver.nodes = 9"),
        (["run", "small.toml", "--out", "taken"], "taken: exists already; choose another --out"),
        (["run", "small.toml", "--out", "small.toml"], "small.toml: exists already"),
        (["run", "small.toml", "--out", "small.toml/sub"], "small.toml/sub: cannot write there"),
        (["resume", "nowhere"], "nowhere: is no run of ertel, case.toml is missing"),
        (["show", "taken"], "taken: is no run of ertel"),
        (["plot", "taken"], "taken: is no run of ertel"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_wrong_input(here, arguments, said):
    (here / "taken").mkdir()
    (here / "taken" / "file").write_text("")
    result = ertel_(*arguments, code=2)
    assert said in result.stderr
    assert result.stderr.startswith("ertel: ")
    assert len(result.stderr.splitlines()) == 1
    assert result.stdout == ""
    assert names(here) == {"small.toml", "ball.toml", "taken"}
    assert names(here / "taken") == {"file"}


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write anywhere")
def test_unwritable_output(here):
    (here / "locked").mkdir(mode=0o500)
    result = ertel_("run", "small.toml", "--out", "locked/run", code=2)
    assert "locked/run: cannot write there, permission denied" in result.stderr


def test_plot_of_a_run_without_maps(here):
    ertel_("run", "ball.toml", "--out", "a", "-q", "--set", "output.interval=50", "--set", "time.until=0.01")
    run = store.RunStore.open(here / "a")
    assert run.dataset().sizes["frame"] == 1  # the end
    ertel_("plot", "a")


def test_unknown_option_and_command(here):
    ertel_("run", "small.toml", "--frobnicate", code=2)
    ertel_("walk", code=2)
