"""Runs side by side: order, failures, what is kept, what is run again."""

import os
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from executors import Now

from ertel.runs import sweep as sweep_module
from ertel.runs.sweep import Failure, Task, kept, processes, sweep
from ertel.version import source_digest

HANG = 120  # s: a process that lives longer is taken for one that never ends
CALLS: list[float] = []


def double(x: float) -> float:
    CALLS.append(x)
    return 2 * x


def one_over(x: float) -> float:
    return 1 / x


def worker(_: int) -> tuple[str | None, int]:
    return os.environ.get("OPENBLAS_NUM_THREADS"), os.getpid()


def test_results_come_in_the_order_of_the_tasks():
    with ThreadPoolExecutor(3) as executor:
        assert sweep([Task(str(x), double, (x,)) for x in (3, 1, 2)], executor) == [6, 2, 4]


def test_a_failure_is_a_value():
    results = sweep([Task("good", one_over, (2,)), Task("bad", one_over, (0,))], Now())
    assert results == [0.5, Failure("ZeroDivisionError: division by zero")]


def test_what_is_kept_is_not_run_again(tmp_path: Path):
    tasks = [Task(str(x), double, (x,)) for x in (1, 2)]
    sweep(tasks[:1], Now(), tmp_path)
    CALLS.clear()
    seen = []
    assert sweep(tasks, Now(), tmp_path, lambda task, result: seen.append((task.name, result))) == [2, 4]
    assert CALLS == [2]
    assert seen == [("1", 2), ("2", 4)]


def test_other_arguments_and_broken_files_are_run_again(tmp_path: Path):
    sweep([Task("a", double, (1,)), Task("b", double, (1,))], Now(), tmp_path)
    (tmp_path / "b.pickle").write_bytes(b"no pickle")
    assert sweep([Task("a", double, (5,)), Task("b", double, (1,))], Now(), tmp_path) == [10, 2]


def test_failures_are_not_kept(tmp_path: Path):
    task = Task("bad", one_over, (0,))
    sweep([task], Now(), tmp_path)
    assert kept([task], tmp_path) == {}


def test_names_must_differ():
    with pytest.raises(ValueError, match="must differ"):
        sweep([Task("a", double, (1,)), Task("a", double, (2,))], Now())


def test_worker_processes_keep_to_one_thread_each():
    with processes(1) as executor:
        [(threads, pid)] = sweep([Task("w", worker, (0,))], executor)
    assert threads == "1"
    assert pid != os.getpid()


# -- what belongs to the stamp of a kept result ------------------------------------------------------------------------


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    directory = tmp_path / "package"
    (directory / "room").mkdir(parents=True)
    (directory / "a.py").write_bytes(b"x = 1")
    (directory / "room" / "b.py").write_bytes(b"y = 2")
    return directory


def test_the_digest_of_sources_sees_every_byte_and_name(sources: Path):
    before = source_digest(sources)
    assert source_digest(sources) == before
    (sources / "a.py").write_bytes(b"x = 2")
    changed = source_digest(sources)
    (sources / "a.py").write_bytes(b"x = 1")
    assert changed != before == source_digest(sources)
    (sources / "room" / "b.py").rename(sources / "room" / "c.py")
    assert source_digest(sources) != before


def test_the_digest_of_sources_sees_only_sources(sources: Path):
    before = source_digest(sources)
    (sources / "notes.txt").write_text("no code")
    assert source_digest(sources) == before


def test_a_result_of_other_sources_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    task = Task("a", double, (1,))
    sweep([task], Now(), tmp_path)
    assert kept([task], tmp_path) == {"a": 2}
    monkeypatch.setattr(sweep_module, "own_sources", lambda: "other sources")
    assert kept([task], tmp_path) == {}


# -- how workers end: each sweep runs in a process of its own, so that a worker that stays can be seen -----------------

# The worker holds the other end of the standard output, which is therefore at its end only when the worker is.

INTERRUPTED = """
import sys
from pathlib import Path
from ertel.runs.sweep import Task, processes, sweep
from test_sweep import double, never_ends
def interrupt(task, result):
    raise KeyboardInterrupt
if __name__ == "__main__":
    try:
        with processes(2) as executor:
            sweep([Task("short", double, (1,)), Task("long", never_ends)], executor, Path(sys.argv[1]), interrupt)
    except KeyboardInterrupt:
        print("interrupted")
"""
KILLED = """
from ertel.runs.sweep import Task, processes, sweep
from test_sweep import never_ends
if __name__ == "__main__":
    with processes(1) as executor:
        sweep([Task("long", never_ends)], executor)
"""


def never_ends() -> None:
    print("running", flush=True)
    threading.Event().wait()


def started(script: Path, text: str, *arguments: str) -> subprocess.Popen[str]:
    script.write_text(text)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    command = [sys.executable, str(script), *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment, start_new_session=True)


def rest_of_output(parent: subprocess.Popen[str]) -> str:
    """What is printed until parent and workers have ended; where they do not, they are killed and the test fails."""
    try:
        return parent.communicate(timeout=HANG)[0]
    except subprocess.TimeoutExpired:
        os.killpg(parent.pid, signal.SIGKILL)
        raise


def test_an_interrupt_ends_the_workers_and_keeps_what_is_done(tmp_path: Path):
    parent = started(tmp_path / "interrupted.py", INTERRUPTED, str(tmp_path / "kept"))
    assert rest_of_output(parent).splitlines()[-1] == "interrupted"
    assert parent.returncode == 0
    assert kept([Task("short", double, (1,)), Task("long", never_ends)], tmp_path / "kept") == {"short": 2}


def test_workers_end_with_a_parent_that_is_killed(tmp_path: Path):
    parent = started(tmp_path / "killed.py", KILLED)
    assert parent.stdout and parent.stdout.readline() == "running\n"
    parent.send_signal(signal.SIGKILL)
    assert rest_of_output(parent) == ""
    assert parent.returncode == -signal.SIGKILL
