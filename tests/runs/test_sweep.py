"""Runs side by side: order, failures, what is kept, what is run again."""

import errno
import hashlib
import io
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from cases import names
from executors import Now

from ertel.runs import plain
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


def test_other_arguments_are_run_again(tmp_path: Path):
    sweep([Task("a", double, (1,))], Now(), tmp_path)
    assert sweep([Task("a", double, (5,))], Now(), tmp_path) == [10]


def flipped(content: bytes, bit: int) -> bytes:
    changed = bytearray(content)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


def test_a_kept_result_with_any_bit_flipped_is_computed_again(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    task = Task("a", double, (1.5,))
    sweep([task], Now(), tmp_path)
    file = tmp_path / "a.result"
    whole = file.read_bytes()
    for bit in range(0, 8 * len(whole), 97):
        file.write_bytes(flipped(whole, bit))
        assert kept([task], tmp_path) == {}, f"bit {bit}"
    for length in range(0, len(whole), 97):
        file.write_bytes(whole[:length])
        assert kept([task], tmp_path) == {}, f"{length} bytes"
    assert "a.result: is damaged, its checksum does not fit" in caplog.text
    assert sweep([task], Now(), tmp_path) == [3.0]
    assert file.read_bytes() == whole


class Evil:
    """An object whose pickle runs code when it is loaded."""

    def __init__(self, proof: Path):
        self.proof = proof

    def __reduce__(self) -> tuple[object, ...]:
        return Path.touch, (self.proof,)


@pytest.mark.parametrize("name", ["a.pickle", "a.result"])
def test_a_file_beside_the_results_runs_no_code(tmp_path: Path, name: str):
    """Neither a plain pickle nor one inside an archive with the right checksum."""
    proof, task, directory = tmp_path / "proof", Task("a", double, (1,)), tmp_path / "kept"
    directory.mkdir()
    archive = io.BytesIO()
    np.savez(archive, text=np.array([Evil(proof)], dtype=object))
    body = archive.getvalue() if name.endswith("result") else pickle.dumps(Evil(proof))
    checksum = hashlib.sha256(body).digest() if name.endswith("result") else b""
    (directory / name).write_bytes(checksum + body)
    assert sweep([task], Now(), directory) == [2]
    assert not proof.exists()


@pytest.mark.parametrize("body", [b"", b"PK\x03\x04 no archive", b"\x80\x04N.", b"text"])
def test_a_file_of_another_kind_is_computed_again(tmp_path: Path, caplog: pytest.LogCaptureFixture, body: bytes):
    """Also with the right checksum: only somebody else can have written it."""
    (tmp_path / "a.result").write_bytes(hashlib.sha256(body).digest() + body)
    assert sweep([Task("a", double, (1,))], Now(), tmp_path) == [2]
    assert "is no file of plain data" in caplog.text


def test_datasets_numbers_and_lists_come_back_exactly(tmp_path: Path):
    data = xr.Dataset(
        {"H": (("wave", "X"), np.array([[0.1, np.nan], [np.inf, -0.0]])), "event": ("X", np.array([1, 2], "int8"))},
        {"wave": ["rings, 0.4", "µ"], "X": [0.5, 1 / 3], "frame": 1.0},
        {"M": 200.0, "title": "ball"},
    )
    plain.write(tmp_path / "file", [data, (1, 2.5e-300, None, True), {"list": {"dict": "array"}}])
    again, numbers, names = plain.read(tmp_path / "file")
    assert again.identical(data) and again["event"].dtype == "int8"
    assert np.signbit(again["H"].values[1, 1])
    assert numbers == [1, 2.5e-300, None, True] and names == {"list": {"dict": "array"}}


@pytest.mark.parametrize(
    ("task", "message"),
    [
        (Task("a", double, (Path(),)), "arguments of task a: a PosixPath cannot be kept"),
        (Task("a", complex, (1, 2)), "result of task a: a complex cannot be kept"),
    ],
)
def test_what_is_not_plain_data_is_refused_where_it_would_be_kept(tmp_path: Path, task: Task, message: str):
    with pytest.raises(TypeError, match=message):
        sweep([task], Now(), tmp_path)


def test_a_full_disk_leaves_the_results_before_it_and_nothing_half_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    tasks = [Task(str(x), double, (x,)) for x in (1, 2)]
    sweep(tasks[:1], Now(), tmp_path)
    monkeypatch.setattr(Path, "replace", disk_full)
    with pytest.raises(OSError, match=f"No space left on device: '{tmp_path / '2.result'}'"):
        sweep(tasks, Now(), tmp_path)
    assert names(tmp_path) == {"1.result"}
    assert kept(tasks, tmp_path) == {"1": 2}


def disk_full(*_: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_directory_that_cannot_be_written_is_refused_before_anything_is_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    CALLS.clear()
    monkeypatch.setattr(sweep_module, "TemporaryFile", lambda dir: disk_full())
    with pytest.raises(OSError, match="No space left"):
        sweep([Task("a", double, (1,))], Now(), tmp_path)
    assert CALLS == []


def test_failures_are_not_kept(tmp_path: Path):
    task = Task("bad", one_over, (0,))
    sweep([task], Now(), tmp_path)
    assert kept([task], tmp_path) == {}


def test_names_must_differ():
    with pytest.raises(ValueError, match="must differ"):
        sweep([Task("a", double, (1,)), Task("a", double, (2,))], Now())


def test_workers_that_are_ended_leave_no_traceback(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Results cannot be written while other tasks wait: the pool's thread then stumbles over the cancelled ones."""
    complaints: list[Any] = []
    monkeypatch.setattr(threading, "excepthook", complaints.append)

    def full_disk(task: Task, result: object) -> None:
        raise OSError("no space left on device")

    tasks = [Task(f"{seconds} s, {i}", time.sleep, (seconds,)) for i, seconds in enumerate((0.05, *[60.0] * 5))]
    with pytest.raises(OSError, match="no space"), processes(1) as executor:
        sweep(tasks, executor, tmp_path, full_disk)
    assert complaints == []
    assert threading.excepthook == complaints.append


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
from typing import Any
from ertel.runs.sweep import Task, processes, sweep
from test_sweep import double, never_ends
def interrupt(task, result):
    raise KeyboardInterrupt
if __name__ == "__main__":
    try:
        with processes(2) as executor:
            sweep([Task("short", double, (1,)), Task("long", never_ends)], executor, Path(sys.argv[1]), interrupt)
    except KeyboardInterrupt:
        print("\\ninterrupted")  # a worker may have been ended within its own line
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
