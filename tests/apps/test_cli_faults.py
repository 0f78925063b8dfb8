"""What goes wrong around a command becomes one sentence and an exit code; what was computed is kept."""

import signal
import time
from pathlib import Path

import jax
import pytest
from app_runs import CASE_FILES, raising, refused
from cases import ertel_, names

from ertel.apps import running
from ertel.apps.process import SIGNALS
from ertel.inputs import case_files
from ertel.runs import store
from ertel.runs.store import RunStore


def test_home_directory_in_every_path(here, monkeypatch):
    home = here / "home"
    home.mkdir()
    (home / "own.toml").write_text(CASE_FILES["ball.toml"])
    monkeypatch.setenv("HOME", str(home))
    assert "ertel plot home/res" in ertel_("run", "~/own.toml", "--out=~/res").stdout
    assert RunStore.open(home / "res").summary()["status"] == "converged"
    assert "~" not in names(here)
    for command in ("show", "resume"):
        assert "converged" in ertel_(command, "~/res").stdout


@pytest.mark.parametrize("arguments", ["run ball.toml --set {}", "show {}", "{}"])
def test_messages_are_short_and_without_control_characters(here, arguments):
    for long in ("x" * 100_000, "\x1b[31m\x07", "\udcff"):
        sentence = refused(*arguments.replace("{}", long).split(" "))
        assert len(sentence) < 3000
        assert all(c.isprintable() for c in sentence.rstrip("\n"))


def test_usage_errors_are_sentences(here):
    assert "No such option: --frobnicate" in refused("run", "ball.toml", "--frobnicate")
    assert "--help" in refused("--frobnicate")
    assert "No such command" in refused("walk")
    assert "for 'kind': 'sliding' is not one of" in refused("new", "sliding")  # without the prefix of a library
    assert "Usage" in ertel_().stdout  # a command alone helps


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_before_the_run_and_during_warm_up(here, monkeypatch, number):
    monkeypatch.setattr(running, "warm_up", lambda case: signal.raise_signal(number))
    assert "ertel: interrupted\n" in ertel_("warm-up", "ball.toml", code=128 + number).stderr
    monkeypatch.setattr(case_files, "load_case", lambda *_: signal.raise_signal(number))
    assert refused("run", "ball.toml", code=128 + number) == "ertel: interrupted\n"
    assert names(here) == set(CASE_FILES)


def test_a_signal_in_a_destructor_is_not_lost(here, monkeypatch):
    class Dying:
        def __del__(self):
            signal.raise_signal(signal.SIGTERM)

    def compile_long(case):
        Dying()
        for _ in range(1000):  # until the signal comes again
            time.sleep(0.01)

    monkeypatch.setattr(running, "warm_up", compile_long)
    assert "interrupted" in ertel_("warm-up", "ball.toml", code=143).stderr


@pytest.mark.parametrize(
    ("file", "command", "advice"),
    [
        ("checkpoint.npz", "resume", "rm 'my run/checkpoint.npz'; ertel resume 'my run'\n"),
        ("run.zarr/zarr.json", "show", "ertel run 'my run/case.toml'\n"),
        ("case.toml", "show", "put the run's own back\n"),
    ],
)
def test_damage(ball, file, command, advice):
    if file != "case.toml":
        (ball / "summary.json").unlink()
    content = (ball / file).read_bytes()
    (ball / file).write_bytes(b"\x00" + content[1:])
    assert refused(command, "my run").endswith(advice)


@pytest.mark.parametrize("error", [MemoryError(), jax.errors.JaxRuntimeError("RESOURCE_EXHAUSTED: out of memory")])
def test_out_of_memory(here, monkeypatch, error):
    monkeypatch.setattr(store, "compute", raising(error))
    sentence = refused("run", "ball.toml", "-q", code=1)
    assert "out of memory: solver.nodes = 33 needs about 0.55 GB of memory, the machine has" in sentence
    assert "solver.nodes = 17 needs 0.55 GB" in sentence


@pytest.mark.parametrize("error", [RuntimeError("Unable to initialize backend 'cuda'"), AssertionError()])
def test_no_device(here, monkeypatch, error):
    monkeypatch.setattr(jax, "devices", raising(error))
    monkeypatch.setenv("JAX_PLATFORMS", "cuda")
    assert "JAX_PLATFORMS=cuda: JAX finds no such device here" in refused("run", "ball.toml")
    assert names(here) == set(CASE_FILES)
    assert "none: JAX_PLATFORMS=cuda" in ertel_("about").stdout


def test_a_fault_of_ertel_is_told_without_a_traceback(here, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(here))
    monkeypatch.setattr(running, "run", lambda *_: 1 / 0)
    sentence = refused("run", "ball.toml", code=1)
    assert "internal error, ZeroDivisionError: division by zero" in sentence
    report = Path(sentence.split()[-1])
    assert "Traceback" in report.read_text()
    assert "test_cli_faults.py" in report.read_text()
    monkeypatch.setattr("tempfile.tempdir", str(here / "none"))
    assert "Traceback" in ertel_("run", "ball.toml", code=1).stderr  # there is no room for it
