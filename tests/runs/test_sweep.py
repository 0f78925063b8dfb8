"""Runs side by side: order, failures, what is kept, what is run again."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path

import pytest

from ertel.runs.sweep import Failure, Task, kept, processes, sweep

CALLS: list[float] = []


def double(x: float) -> float:
    CALLS.append(x)
    return 2 * x


def one_over(x: float) -> float:
    return 1 / x


def worker(_: int) -> tuple[str | None, int]:
    return os.environ.get("OPENBLAS_NUM_THREADS"), os.getpid()


class Now(Executor):
    """Runs at once: the least that an Executor is."""

    def submit(self, fn, /, *args, **kwargs):
        future: Future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


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


def test_an_interrupt_ends_the_workers_and_keeps_what_is_done(tmp_path: Path):
    tasks = [Task("short", double, (1,)), Task("long", time.sleep, (60,))]

    def interrupt(task: Task, result: object) -> None:
        raise KeyboardInterrupt

    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt), processes(2) as executor:
        sweep(tasks, executor, tmp_path, interrupt)
    assert time.monotonic() - started < 30
    assert kept(tasks, tmp_path) == {"short": 2}


KILLED = """
from ertel.runs.sweep import Task, processes, sweep
from test_sweep import long_run
if __name__ == "__main__":
    with processes(1) as executor:
        sweep([Task("long", long_run)], executor)
"""


def long_run() -> None:
    print(os.getpid(), flush=True)
    time.sleep(600)


def test_workers_end_with_a_parent_that_is_killed(tmp_path: Path):
    script = tmp_path / "killed.py"
    script.write_text(KILLED)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    parent = subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True, env=environment)
    assert parent.stdout
    pid = int(parent.stdout.readline())
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    assert parent.stdout.read() == ""  # the worker holds the other end until it ends
    with pytest.raises(ProcessLookupError):
        for _ in range(100):
            os.kill(pid, 0)
            time.sleep(0.1)
