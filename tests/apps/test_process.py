"""The command line as a process: its memory, its streams, closed, full or in ASCII, and the signals that end it."""

import os
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import pytest
from app_runs import CHILD, STUDY, is_alive, until

from ertel.apps.process import NO_GLYPH, warnings_as_sentences
from ertel.runs.store import RunStore

pytestmark = pytest.mark.skipif(os.name == "nt", reason="no signals and no /dev/full")
ERTEL = [sys.executable, "-m", "ertel"]
CHECK = [*ERTEL, "check", "--set", "contact.M=1000", "--set", "contact.L=10"]
RADIAL = ["run", "ball.toml", "--set", "solver.method=radial", "--set", "solver.nodes=17"]
FULL = "/dev/full"


def done(command, **streams):
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "env": CHILD, **streams}
    return subprocess.run(command, text=True, encoding="utf-8", timeout=120, check=False, **streams)


def started(command, **more):
    return subprocess.Popen(command, env=CHILD, **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **more})


@pytest.mark.skipif(not Path(FULL).exists(), reason=f"no {FULL}")
def test_full_output_is_one_sentence_and_one_that_nobody_reads_is_no_error():
    with open(FULL, "w") as full:
        ended = done(CHECK, stdout=full)
    assert ended.stderr == "ertel: cannot write to standard output: no space left on device\n"
    assert ended.returncode == 1
    reading, writing = os.pipe()
    os.close(reading)  # nobody reads
    ended = done(CHECK, stdout=writing)
    os.close(writing)
    assert (ended.returncode, ended.stderr) == (0, "")


def test_characters_without_a_glyph_are_said_once(capsys):
    with warnings_as_sentences():
        for code in ("27833", "33180"):
            warnings.warn(f"Glyph {code} missing from font(s) DejaVu Sans.", stacklevel=1)
        warnings.warn("other", stacklevel=1)
    assert capsys.readouterr().err == f"ertel: warning: {NO_GLYPH}\nertel: warning: other\n"


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self").exists(), reason="no directory in which even root cannot write")
def test_a_cache_that_cannot_be_written(here):
    """As for a home directory that may only be read; the programs are compiled in silence."""
    code = """
from ertel.apps import process
from ertel.runs.compile import prepare_jax
with process.warnings_as_sentences():
    prepare_jax()
    import jax
    print(jax.jit(lambda x: x + 1)(1))
"""
    smallest = {"JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0", "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1"}
    ended = done([sys.executable, "-c", code], env={**CHILD, **smallest, "JAX_COMPILATION_CACHE_DIR": "/proc/self"})
    assert (ended.stdout, ended.stderr) == ("2\n", "")


IN_COMPILED_CODE = """
import hashlib
from ertel.apps.process import interruptible

with interruptible("the same command continues") as stop:
    print("computing", flush=True)
    while not stop():
        pass
    print("heard", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"", b"", 100_000_000)  # a minute without Python
"""
LISTENING = """
import sys
from ertel.__main__ import main
from ertel.apps import cli

app = cli.app

def told():
    from ertel.apps import running  # brings JAX, which reads the settings of main
    watch = running.watch

    def tell(*arguments):
        print("listening", file=sys.stderr, flush=True)
        return watch(*arguments)

    running.watch = tell
    app()

cli.app = told
main()
"""


def test_control_c(here, monkeypatch):
    """XLA has nothing to add on stderr."""
    monkeypatch.delitem(CHILD, "TF_CPP_MIN_LOG_LEVEL", raising=False)
    with started([sys.executable, "-c", LISTENING, *RADIAL, "--set", "time.until=100"]) as process:
        assert process.stderr.readline() == b"listening\n"
        process.send_signal(signal.SIGINT)
        _, said = process.communicate()
    assert process.returncode == 130
    assert said == b"ertel: interrupted; to continue: ertel resume runs/ball\n"


def test_a_second_signal_ends_at_once():
    """The first one has said so on the terminal."""
    terminal, stderr = os.openpty()
    with started([sys.executable, "-c", IN_COMPILED_CODE], stderr=stderr) as process:
        for word in (b"computing\n", b"heard\n"):
            assert process.stdout.readline() == word
            time.sleep(0.2)
            process.send_signal(signal.SIGTERM)
        assert process.wait(30) == -signal.SIGTERM
    assert b"on a second Ctrl-C at once; the same command continues" in os.read(terminal, 1000)
    os.close(terminal)
    os.close(stderr)


@pytest.mark.slow
def test_nohup_goes_on_and_results_are_kept_where_the_output_fails(here):
    def ignore():
        signal.signal(signal.SIGHUP, signal.SIG_IGN)

    command = [sys.executable, "-c", LISTENING, *RADIAL, "--out", "a"]
    fails = Path(FULL).exists()
    with open(FULL if fails else os.devnull, "w") as full, started(command, preexec_fn=ignore, stdout=full) as process:
        assert process.stderr.readline() == b"listening\n"
        process.send_signal(signal.SIGHUP)
        _, said = process.communicate(timeout=120)
    assert RunStore.open(here / "a").summary()["status"] == "converged"
    expected = (1, b"ertel: cannot write to standard output: no space left on device\n") if fails else (0, b"")
    assert (process.returncode, said) == expected


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="no list of children")
def test_ctrl_c_stops_the_runs_of_a_study_so_that_they_go_on(here):
    """A terminal sends it to the workers too."""
    long = STUDY.replace("40]", "40, 60]").replace("until = 0.02\ntolerance = 0.1", "until = 1000\nstep = 1e-3")
    (here / "loads.toml").write_text(long)
    with started([*ERTEL, "sweep", "loads.toml", "--jobs", "2"], start_new_session=True) as process:
        until(lambda: len(list(here.glob("sweeps/loads/runs/*/progress.json"))) >= 2, 120)
        tasks = Path(f"/proc/{process.pid}/task").glob("*/children")  # of any thread
        workers = [child for task in tasks for child in task.read_text().split()]
        os.killpg(process.pid, signal.SIGINT)
        out, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert told.decode().splitlines() == ["3 runs, 3 of them to do", "ertel: interrupted; the same command continues"]
    assert "\n3 runs: 2 interrupted, 1 missing" in out.decode()
    for directory in here.glob("sweeps/loads/runs/*"):
        assert RunStore.open(directory).summary()["steps"] > 0
    until(lambda: not any(map(is_alive, workers)), 60)
