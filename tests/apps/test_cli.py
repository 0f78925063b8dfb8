"""The command line: what it prints and where, its exit codes, and that wrong input leaves nothing behind."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from cases import LEFT, SMALL_IMPACT, ertel_, names
from matplotlib.figure import Figure

import ertel
from ertel import plots
from ertel.apps import about, running
from ertel.runs import compile, store
from ertel.runs.directory import ask_to_stop, is_asked_to_stop
from ertel.runs.store import RunStore

MOES = """
[contact]
M = 200
L = 10
[solver]
nodes = 33
[time]
tolerance = 0.01
"""
BALL = SMALL_IMPACT + "until = 1.2\n"
SOURCE = str(Path(ertel.__path__[0]).parent)
SUMMARY_KEYS = [
    *("kind", "lambda_bar", "alpha_bar", "M", "L", "max_approach", "restitution", "steps", "newton_iterations"),
    *("krylov_iterations", "convolutions", "compilations", "wall_s", "status"),
]


@pytest.fixture(scope="session")
def runs(tmp_path_factory):
    """Finished runs that the tests look at, with what they printed: small, to maximum approach; ball, to T = 1.2."""
    directory = tmp_path_factory.mktemp("cli")
    printed = {}
    for name, text in (("small", MOES), ("ball", BALL)):
        (directory / f"{name}.toml").write_text(text)
        printed[name] = ertel_("run", str(directory / f"{name}.toml"), "--out", str(directory / name)).stdout
    return directory, printed


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working directory with a case in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(MOES)
    (tmp_path / "ball.toml").write_text(BALL)
    return tmp_path


@pytest.fixture
def small(here, runs):
    """A copy of the small run in the working directory."""
    return Path(shutil.copytree(runs[0] / "small", here / "runs" / "small"))


@pytest.fixture
def ball(here, runs):
    """A copy of the ball's run in the working directory."""
    return Path(shutil.copytree(runs[0] / "ball", here / "a"))


@pytest.fixture
def quick_figures(monkeypatch):
    """As if a run were drawn in two empty figures, with the choice of the moment in the title."""

    def draw(data, name, at):
        figure = Figure()
        figure.suptitle(repr(at))
        return figure

    monkeypatch.setattr(plots, "names_of", lambda data: ("film", "history"))
    monkeypatch.setattr(plots, "draw", draw)


# -- answers at once --------------------------------------------------------------------------------------------------


def test_version():
    assert ertel_("--version").stdout == f"ertel {ertel.__version__}\n"


COMMANDS = ["run", "resume", "show", "plot", "params", "film", "about", "paper", "sweep", "ls", "compare", "export"]


def test_help():
    text = ertel_("--help").stdout
    for command in COMMANDS:
        assert command in text
        assert "--help" in ertel_(command, "--help").stdout


def test_about():
    text = ertel_("about").stdout
    for said in (f"ertel          {ertel.__version__}", "NumPy", "cpu", str(compile.cache_directory()), "Tribology"):
        assert said in text


def test_about_a_jax_that_computes_wrongly(monkeypatch):
    monkeypatch.setattr(about, "version", lambda package: "0.11.0")
    assert 'pip install "jax!=0.10.2,!=0.11.0"' in ertel_("about").stdout


# -- run --------------------------------------------------------------------------------------------------------------


def test_run_stores_and_tells(small, runs):
    assert names(small) == LEFT | {"case.toml", "run.zarr", "checkpoint.npz", "summary.json", "progress.json"}
    summary = json.loads((small / "summary.json").read_text())
    assert set(SUMMARY_KEYS) <= set(summary)
    keys = ["T", "Delta", "F", "P_c", "P_max", "H_c", "H_min", "X_min", "Y_min", "power_loss"]
    assert list(summary["max_approach"]) == keys
    assert summary["status"] == "converged"
    assert summary["restitution"] is None
    printed = runs[1]["small"]
    assert "M = 200, L = 10" in printed
    assert f"{summary['max_approach']['H_c']:.5g}" in printed
    assert "Warning: the film is not resolved at the front" in printed  # 33 nodes do not resolve it
    assert f"ertel plot {runs[0] / 'small'}" in printed


def test_run_json_is_json_and_nothing_else(here):
    result = ertel_("run", "ball.toml", "--out", "here", "--json")
    summary = json.loads(result.stdout)
    assert summary == RunStore.open(here / "here").summary()
    assert summary["max_approach"] is None  # it ends before
    assert summary["si"]["p_h_Pa"] == pytest.approx(1.39361e9, rel=1e-5)
    assert summary["si"]["max_approach"] is None


def test_a_second_run_is_as_quiet_and_gets_its_own_directory(here):
    for _ in range(2):
        assert ertel_("run", "ball.toml", "--quiet", "--set", "time.until=0.1").output == ""
    assert names(here / "runs") == {"ball", "ball-2"}


def test_run_with_a_jax_that_computes_wrongly(here, monkeypatch):
    monkeypatch.setattr(compile, "version", lambda package: "0.10.2")
    compile.check_jax.cache_clear()
    result = ertel_("run", "ball.toml", "--quiet", "--set", "time.until=0.1")
    assert result.stdout == ""
    assert result.stderr == f"ertel: warning: {compile.wrong_version('0.10.2')}\n"


def test_set_overrides(here):
    ertel_("run", "small.toml", "--out", "a", "-q", "--set", "time.until=0.1", "--set", "contact.M=300")
    case = RunStore.open(here / "a").case
    assert (round(case.parameters.M, 9), case.time.until) == (300, 0.1)


def test_error_estimate(small):
    radial = ("run", "small.toml", "--json", "--set", "solver.method=radial", "--set")
    summary = json.loads(ertel_(*radial, "solver.nodes=65", "--out", "fine", "--error").stdout)
    half = json.loads(ertel_(*radial, "solver.nodes=33", "--out", "half").stdout)
    assert list(summary["error_estimate"]) == ["H_c", "H_min", "Delta_max"]
    H_c = summary["error_estimate"]["H_c"]
    fine, coarse = summary["max_approach"]["H_c"], half["max_approach"]["H_c"]
    assert H_c["value"] == fine
    assert H_c["grid"] == pytest.approx((fine - coarse) / 3, rel=1e-12)
    parts = [H_c[part] for part in ("grid", "time", "domain")]
    assert H_c["extrapolated"] == pytest.approx(fine + sum(parts), rel=1e-12)
    assert abs(H_c[H_c["dominant"]]) == max(abs(part) for part in parts)
    assert f"The largest error is of H_c that of the {H_c['dominant']}" in ertel_("show", "fine").stdout
    assert "extrapolated" in ertel_("show", "fine").stdout


def test_run_that_gives_up(here, small, monkeypatch):
    """What it stores is tested with the store."""
    summary = json.loads((small / "summary.json").read_text())
    monkeypatch.setattr(store, "compute", lambda *_: {**summary, "status": "the time step became too small"})
    result = ertel_("run", "small.toml", "--out", "b", code=1)
    assert "failed: the time step became too small; refine the grid" in result.stderr
    assert "Results so far are in b" in result.stderr


def test_full_disk(here, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(RunStore, "_write_checkpoint", full)
    result = ertel_("run", "small.toml", code=1)
    assert "cannot write to runs/small: no space left on device; to continue: ertel resume runs/small" in result.stderr


# -- interrupted ------------------------------------------------------------------------------------------------------


WAYS_TO_STOP = pytest.mark.parametrize(
    "ask", [lambda run: signal.raise_signal(signal.SIGINT), ask_to_stop], ids=["signal", "file"]
)


@WAYS_TO_STOP
def test_interrupt_and_resume(here, runs, monkeypatch, ask):
    """A file from before does not stop a run, and none is left."""
    original = RunStore.__call__

    def take(self, step):
        original(self, step)
        if step.state.counts.steps == 5:
            ask(self.directory)

    with monkeypatch.context() as patch:
        patch.setattr(RunStore, "__call__", take)
        result = ertel_("run", "small.toml", "--out", "cut", code=130)
    assert "interrupted; to continue: ertel resume cut" in result.stderr
    assert json.loads(ertel_("show", "cut", "--json").stdout)["steps"] == 5
    assert not is_asked_to_stop(here / "cut")
    ask_to_stop(here / "cut")
    ertel_("resume", "cut", "-q")
    assert not is_asked_to_stop(here / "cut")
    whole, resumed = (RunStore.open(path).dataset() for path in (runs[0] / "small", here / "cut"))
    assert whole.drop_attrs(deep=False).identical(resumed.drop_attrs(deep=False))


@WAYS_TO_STOP
def test_interrupt_of_the_half_grid(here, monkeypatch, ask):
    original = running.drive

    def interrupted(course, observers):
        ask(here / "runs" / "small")
        return original(course, observers)

    with monkeypatch.context() as patch:
        patch.setattr(running, "drive", interrupted)
        result = ertel_("run", "small.toml", "--error", "--set", "solver.nodes=65", code=130)
    assert "to continue: ertel resume runs/small" in result.stderr
    assert "; to start it: ertel resume runs/small" in ertel_("show", "runs/small", code=2).stderr
    ertel_("resume", "runs/small", "-q")
    assert json.loads(ertel_("show", "runs/small", "--json").stdout)["status"] == "converged"


def test_resume_of_a_finished_run_shows_it(ball):
    summary = RunStore.open(ball).summary()
    assert json.loads(ertel_("resume", "a", "--json").stdout) == summary
    assert json.loads(ertel_("show", "a", "--json").stdout) == summary


LISTENING = """
from ertel.__main__ import main
from ertel.apps import cli

app = cli.app

def told():
    from ertel.apps import running  # brings JAX, which reads the settings of main
    watch = running.watch

    def tell(*arguments):
        print("listening", flush=True)
        return watch(*arguments)

    running.watch = tell
    app()

cli.app = told
main()
"""


@pytest.mark.skipif(os.name == "nt", reason="no SIGINT to another process")
def test_control_c(here):
    """A real one, at a real process; XLA has nothing to add on stderr."""
    command = [sys.executable, "-c", LISTENING, "run", "small.toml", "--set", "time.step=1e-5"]
    environment = {name: value for name, value in os.environ.items() if name != "TF_CPP_MIN_LOG_LEVEL"}
    environment["PYTHONPATH"] = SOURCE
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"listening\n"
        process.send_signal(signal.SIGINT)
        _, said = process.communicate()
    assert process.returncode == 130
    assert said == b"ertel: interrupted; to continue: ertel resume runs/small\n"


# -- show, plot, params -----------------------------------------------------------------------------------------------


def test_show_si(here):
    ertel_("run", "ball.toml", "-q", "--set", "time.until=max-approach")
    text = ertel_("show", "runs/ball").stdout
    assert "in SI" in text
    assert "GPa" in text
    assert "µm" in text


def test_show_of_a_run_that_ends_before_maximum_approach(ball):
    said = ertel_("show", "a").stdout
    assert "Maximum approach was not reached." in said
    assert "Thinnest film of the run" in said
    assert "mbalance: mass " in said


def test_show_of_a_run_under_way(small):
    (small / "summary.json").unlink()
    assert json.loads(ertel_("show", "runs/small", "--json").stdout)["status"] == "running"


def test_plot(ball):
    printed = ertel_("plot", "a").stdout.split()
    pictures = {f"{name}.png" for name in ("overview", "maps", "profiles", "friction", "history")}
    assert names(ball / "plots") == pictures
    assert {Path(path).name for path in printed} == pictures


@pytest.mark.parametrize(("kind", "start"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_plot_formats(ball, quick_figures, kind, start):
    ertel_("plot", "a", "--format", kind)
    assert names(ball / "plots") == {f"film.{kind}", f"history.{kind}"}
    assert (ball / "plots" / f"film.{kind}").read_bytes().startswith(start)


def test_plot_elsewhere(here, ball, quick_figures):
    ertel_("plot", "a", "--out", "pictures/of/it")
    assert names(here / "pictures" / "of" / "it") == {"film.png", "history.png"}


@pytest.mark.parametrize(("at", "title"), [("1.5", "1.5"), ("max-approach", "'max-approach'"), (None, "None")])
def test_plot_at(ball, quick_figures, monkeypatch, at, title):
    saved = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, path: saved.append(figure.get_suptitle()))
    ertel_("plot", "a", *(["--at", at] if at else []))
    assert saved == [title, title]


def test_plot_at_refused(ball):
    assert "at = 99.0: must be a time" in ertel_("plot", "a", "--at", "99", code=2).stderr


def test_params_from_moes():
    content = json.loads(ertel_("params", "--set", "contact.M=1000", "--set", "contact.L=10", "--json").stdout)
    assert content["lambda_bar"] == pytest.approx(0.00109777359, rel=1e-8)
    assert content["trapped_film"] == pytest.approx(0.1)
    assert "si" not in content


PHYSICAL = [
    "contact.radius=10 mm",
    "contact.mass=32.6726 g",
    "contact.speed=0.1 m/s",
    "contact.E_prime=226.37 GPa",
    "lubricant.eta0=0.1 Pa*s",
    "lubricant.alpha=22 / GPa",
]


def test_params_from_quantities():
    """The dimensional example of reference/impact.json."""
    flags = [word for setting in PHYSICAL for word in ("--set", setting)]
    content = json.loads(ertel_("params", *flags, "--json").stdout)
    expected = {"stokes": 17.3333, "lambda_bar": 0.0615385, "alpha_bar": 30.6595, "M": 48.8118, "L": 23.0237}
    scales = {"delta_m": 3.74064e-06, "a_m": 0.000193407, "F_N": 109.181, "p_h_Pa": 1393610000.0, "t0_s": 3.74064e-05}
    for found, wanted in ((content, expected), (content["si"], scales | {"contact_time_s": 0.000110098})):
        assert {key: found[key] for key in wanted} == pytest.approx(wanted, rel=1e-5)
    assert "p_h_Pa" in ertel_("params", *flags).stdout


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (["contact.M=1000"], "contact.L: missing"),
        (["contact.M=1000", "contact.L=10", "contact.lambda_bar=1"], "given together"),
        (["contact.radius='10'"], 'contact.radius = "10": must be a quantity'),
        (["contact.M=nan", "contact.L=1"], "contact.M = NaN"),
        (["contact.raduis=10 mm"], "did you mean radius?"),
        (["lubricant=5", "contact.M=1"], "lubricant = 5: must be a section"),
        ([], "contact.M: missing"),
    ],
)
def test_params_refused(settings, said):
    result = ertel_("params", *(word for setting in settings for word in ("--set", setting)), code=2)
    assert said in result.stderr
    assert result.stdout == ""


# -- wrong input: code 2, one line on stderr, nothing on stdout, nothing written ---------------------------------------


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "no.toml"], "no.toml: no such file"),
        (["run", "."], ": is a directory"),
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
        (["run", "small.toml", "--out", "taken"], "taken: exists already"),
        (["run", "small.toml", "--out", "taken"], "; choose another --out"),
        (["run", "small.toml", "--out", "small.toml"], "small.toml: exists already"),
        (["run", "small.toml", "--out", "small.toml/sub"], "small.toml/sub: cannot write there"),
        (["resume", "nowhere"], "nowhere is not an ertel run directory (no case.toml)"),
        (["show", "taken"], "taken is not an ertel run directory (no case.toml)"),
        (["plot", "taken"], "taken is not an ertel run directory (no case.toml)"),
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


def test_directory_of_a_run_is_taken(small):
    result = ertel_("run", "small.toml", "--out", "runs/small", code=2)
    assert "; choose another --out, or continue it: ertel resume runs/small" in result.stderr


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write anywhere")
def test_unwritable_output(here):
    (here / "locked").mkdir(mode=0o500)
    result = ertel_("run", "small.toml", "--out", "locked/run", code=2)
    assert "locked/run: cannot write there, permission denied" in result.stderr


def test_plot_of_a_run_without_maps(here):
    ertel_("run", "ball.toml", "--out", "a", "-q", "--set", "output.interval=50", "--set", "time.until=0.01")
    run = RunStore.open(here / "a")
    assert run.dataset().sizes["frame"] == 1  # the end
    ertel_("plot", "a")
