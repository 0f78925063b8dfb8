"""What goes wrong around a command becomes one sentence and an exit code; what was computed is kept."""

import json
import signal
import time
import warnings
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import jax
import pytest
from app_runs import CASE_FILES, raising, refused
from cases import ertel_, names

from ertel.apps import running, tables, terminal
from ertel.apps.process import SIGNALS, raised
from ertel.inputs import case_files
from ertel.runs import outlook, store
from ertel.runs.store import RunStore

STEADY = ("steady.toml", "-q", "--set", "solver.nodes=33")


# -- paths ------------------------------------------------------------------------------------------------------------


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


@pytest.mark.parametrize("out", ["", "file:///tmp/run", "s3://bucket/run", "run::1", "~nobody-of-this-name/run"])
def test_no_place_for_a_run(here, out):
    assert "'--out'" in refused("run", "ball.toml", "--out", out)
    assert names(here) == set(CASE_FILES)


# -- messages ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        "run ball.toml --{}",
        "run ball.toml --set solver.nodes={}",
        "run ball.toml --set {}",
        "show {}",
        "plot x --format {}",
        "check --set contact.M={}",
        "check --set contact.radius={}",
        "check --set contact.kind={}",
        "{}",
    ],
)
def test_messages_are_short_and_without_control_characters(here, arguments):
    for long in ("x" * 100_000, "\x1b[31m\x07", "\udcff"):
        sentence = refused(*arguments.replace("{}", long).split(" "))
        assert len(sentence) < 3000
        assert all(c.isprintable() for c in sentence.rstrip("\n"))


def test_tables_and_json_show_no_control_characters(capsys):
    """JSON reads back in any terminal."""
    tables.console().print("a\x1b[31mb")
    assert capsys.readouterr().out == "a\\x1b[31mb\n"
    content = {"name": "Öl\x1b µ"}
    terminal.print_json(content)
    printed = capsys.readouterr().out
    assert printed.isascii() and json.loads(printed) == content


@pytest.mark.parametrize(("name", "word"), [("a b", "'a b'"), ("-x", "./-x"), ("plain", "plain")])
def test_a_path_in_advice_is_one_word_of_a_command(here, name, word):
    assert terminal.in_shell(here / name) == word


def test_usage_errors_are_sentences(here):
    assert "No such option: --frobnicate" in refused("run", "ball.toml", "--frobnicate")
    assert "--help" in refused("--frobnicate")
    assert "No such command" in refused("walk")
    assert "Usage" in ertel_().stdout  # a command alone helps


# -- signals ----------------------------------------------------------------------------------------------------------


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


def test_signals_end_what_may_be_left_out():
    """Work that waits for Ctrl-C in the library ends at every signal."""
    with raised(), suppress(KeyboardInterrupt):
        signal.raise_signal(signal.SIGTERM)


def test_handlers_are_put_back(ball):
    before = [signal.getsignal(number) for number in SIGNALS]
    ertel_("resume", "my run", "-q")
    assert [signal.getsignal(number) for number in SIGNALS] == before


# -- run directories --------------------------------------------------------------------------------------------------


def test_a_second_resume_of_a_running_directory(ball):
    (ball / "summary.json").unlink()
    with RunStore.open(ball).alone():
        assert "another process is computing this run" in refused("resume", "my run")


def spoil(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content))


@pytest.mark.parametrize(
    ("file", "command", "advice"),
    [
        ("checkpoint.npz", "resume", "rm 'my run/checkpoint.npz'; ertel resume 'my run'\n"),
        ("summary.json", "show", "ertel resume 'my run'\n"),
        ("run.zarr/H_c/c/0", "plot", "ertel run 'my run/case.toml'\n"),
        ("run.zarr/zarr.json", "show", "ertel run 'my run/case.toml'\n"),
        ("case.toml", "show", "put the run's own back\n"),
    ],
)
def test_damage(ball, file, command, advice):
    if command == "resume" or file.endswith("zarr.json"):
        (ball / "summary.json").unlink()
    (ball / file).write_bytes(b"\x00 = [") if file == "case.toml" else spoil(ball / file)
    assert refused(command, "my run").endswith(advice)


def test_commands_of_advice_repair(ball):
    whole = json.loads(ertel_("show", "my run", "--json").stdout)
    (ball / "summary.json").unlink()
    spoil(ball / "checkpoint.npz")
    ertel_("resume", "my run", code=2)
    (ball / "checkpoint.npz").unlink()
    again = json.loads(ertel_("resume", "my run", "--json").stdout)
    assert {**again, "wall_s": 0, "compilations": 0} == {**whole, "wall_s": 0, "compilations": 0}


def test_a_known_error_is_not_computed_again(ball, monkeypatch):
    run = RunStore.open(ball)
    run.finish({**run.summary(), "error_estimate": {"H_c": {"error": 0.1, "extrapolated": 0.2, "dominant": "grid"}}})
    monkeypatch.delattr(running, "drive")
    assert "dominant" in ertel_("resume", "my run", "--error", "--json").stdout


def test_a_comparison_that_fails_is_told(here, monkeypatch):
    """And not the end: the error is estimated when it is asked for again."""
    failed = SimpleNamespace(summary={"status": "Newton iteration stalled"})
    with monkeypatch.context() as patch:
        patch.setattr(running.Recorder, "result", lambda *_: failed)
        assert "no error is estimated" in refused("run", *STEADY, "--error", code=0)
    found = json.loads(ertel_("resume", "runs/steady", "--error", "--json").stdout)
    assert set(found["error_estimate"]) >= {"H_c", "H_min"}
    assert json.loads(ertel_("show", "runs/steady", "--json").stdout) == found


# -- the machine ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("error", [MemoryError(), jax.errors.JaxRuntimeError("RESOURCE_EXHAUSTED: out of memory")])
def test_out_of_memory(here, monkeypatch, error):
    monkeypatch.setattr(store, "compute", raising(error))
    sentence = refused("run", "ball.toml", "-q", code=1)
    assert "out of memory: solver.nodes = 33 needs about 0.55 GB of memory, the machine has" in sentence
    assert "solver.nodes = 17 needs 0.55 GB" in sentence


def test_a_grid_beyond_the_memory_is_told_before(here, monkeypatch):
    monkeypatch.setattr(outlook, "memory_available", lambda: 1e9)
    monkeypatch.setattr(running, "run_of", lambda case: 1 / 0)
    result = ertel_("run", "ball.toml", "--set", "solver.nodes=2049", "--set", "output.interval=0.05", code=1)
    assert "warning: solver.nodes = 2049 needs about" in result.stderr
    assert "the machine has 1 GB; solver.nodes = 513 needs" in result.stderr


@pytest.mark.parametrize("error", [RuntimeError("Unable to initialize backend 'cuda'"), AssertionError()])
def test_no_device(here, monkeypatch, error):
    monkeypatch.setattr(jax, "devices", raising(error))
    monkeypatch.setenv("JAX_PLATFORMS", "cuda")
    assert "JAX_PLATFORMS=cuda: JAX finds no such device here" in refused("run", "ball.toml")
    assert names(here) == set(CASE_FILES)
    assert "none: JAX_PLATFORMS=cuda" in ertel_("about").stdout


def test_no_home(here, monkeypatch):
    for name in ("XDG_CACHE_HOME", "JAX_COMPILATION_CACHE_DIR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", raising(RuntimeError("Could not determine home directory.")))
    assert "none: there is no home directory" in ertel_("about").stdout
    assert "set XDG_CACHE_HOME" in refused("warm-up")
    ertel_("run", "ball.toml", "-q")


def test_warnings_are_sentences(here, monkeypatch):
    monkeypatch.setattr(
        running, "run", lambda *_: warnings.warn("the disk knows no locks", RuntimeWarning, stacklevel=1)
    )
    assert refused("run", "ball.toml", code=0) == "ertel: warning: the disk knows no locks\n"


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


# -- case files -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", ["run", "warm-up", "check"])
def test_case_files_that_cannot_be_read(here, command):
    (here / "binary").write_bytes(b"\xff\xfe\x00")
    (here / "loop").symlink_to("loop")
    for path in (".", "none.toml", "binary", "loop"):
        assert "case file" in refused(command, path)


@pytest.mark.parametrize("command", ["resume", "show", "plot"])
def test_directories_without_a_run(here, command):
    (here / "empty").mkdir()
    for path in ("empty", "none", "case.toml", "x" * 5000):
        assert refused(command, path)
