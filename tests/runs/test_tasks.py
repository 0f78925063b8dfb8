"""Tasks and their results: order, failures, what is kept, what is run again."""

import errno
import os
import pickle
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from cases import names
from stored_runs import Evil
from threadpoolctl import ThreadpoolController, threadpool_limits

from ertel.runs import tasks as tasks_module
from ertel.runs.files import with_checksum
from ertel.runs.tasks import Failure, Task, kept, run_tasks
from ertel.runs.workers import LocalWorker, never, one_blas_thread
from ertel.version import source_digest

CALLS: list[float] = []


def double(x: float) -> float:
    CALLS.append(x)
    return 2 * x


def one_over(x: float) -> float:
    return 1 / x


def same(x: object) -> object:
    return x


class Backwards(LocalWorker):
    def outcomes(self, tasks, should_stop=never):
        return super().outcomes(tasks[::-1])


TWO = [Task(str(x), double, (x,)) for x in (1, 2)]


def test_results_come_in_the_order_of_the_tasks():
    assert run_tasks([Task(str(x), double, (x,)) for x in (3, 1, 2)], Backwards()) == [6, 2, 4]
    with pytest.raises(ValueError, match="must differ"):
        run_tasks([Task("a", double, (1,)), Task("a", double, (2,))], LocalWorker())


def test_a_failure_is_a_value_that_is_not_kept(tmp_path: Path):
    tasks = [Task("good", one_over, (2,)), Task("bad", one_over, (0,))]
    failure = Failure("ZeroDivisionError: division by zero")
    assert run_tasks(tasks, LocalWorker(), tmp_path) == [0.5, failure]
    assert kept(tasks, tmp_path) == {"good": 0.5}


def test_what_is_kept_is_not_run_again(tmp_path: Path):
    run_tasks(TWO[:1], LocalWorker(), tmp_path)
    CALLS.clear()
    seen = []
    assert run_tasks(TWO, LocalWorker(), tmp_path, lambda task, result: seen.append((task.name, result))) == [2, 4]
    assert CALLS == [2]
    assert seen == [("1", 2), ("2", 4)]


def test_results_of_other_arguments_or_sources_are_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    task = Task("a", double, (1,))
    run_tasks([task], LocalWorker(), tmp_path)
    assert kept([task], tmp_path) == {"a": 2}
    assert run_tasks([Task("a", double, (5,))], LocalWorker(), tmp_path) == [10]
    run_tasks([task], LocalWorker(), tmp_path)
    monkeypatch.setattr(tasks_module, "own_sources", lambda: "other sources")
    assert kept([task], tmp_path) == {}


def test_a_kept_result_with_any_bit_flipped_is_computed_again(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    task = Task("a", double, (1.5,))
    run_tasks([task], LocalWorker(), tmp_path)
    file = tmp_path / "a.result"
    whole = file.read_bytes()
    for bit in range(0, 8 * len(whole), 7):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        file.write_bytes(changed)
        assert kept([task], tmp_path) == {}, f"bit {bit}"
    for length in range(0, len(whole), 7):
        file.write_bytes(whole[:length])
        assert kept([task], tmp_path) == {}, f"{length} bytes"
    assert "a.result: is damaged (its checksum does not agree)" in caplog.text
    assert run_tasks([task], LocalWorker(), tmp_path) == [3.0]
    assert file.read_bytes() == whole


@pytest.mark.parametrize("body", [b"", b"PK\x03\x04 no archive", pickle.dumps(Evil()), b"text", b"3", b'{"a": 1}'])
def test_a_file_of_another_kind_is_computed_again(tmp_path: Path, caplog: pytest.LogCaptureFixture, body: bytes):
    """Also with the right checksum: only somebody else can have written it.  No code of it is run."""
    (tmp_path / "a.result").write_bytes(with_checksum(body))
    assert run_tasks([Task("a", double, (1,))], LocalWorker(), tmp_path) == [2]
    assert "a.result: is damaged" in caplog.text


def test_datasets_numbers_and_lists_come_back_exactly(tmp_path: Path):
    data = xr.Dataset(
        {"H": (("wave", "X"), np.array([[0.1, np.nan], [np.inf, -0.0]])), "event": ("X", np.array([1, 2], "int8"))},
        {"wave": ["rings, 0.4", "µ"], "X": [0.5, 1 / 3], "frame": 1.0},
        {"M": 200.0, "title": "ball"},
    )
    task = Task("a", same, ([data, (1, 2.5e-300, None, True, np.float32(0.5)), {"list": {"dict": "array"}}],))
    run_tasks([task], LocalWorker(), tmp_path)
    again, numbers, names = kept([task], tmp_path)["a"]
    assert again.identical(data) and again["event"].dtype == "int8"
    assert np.signbit(again["H"].values[1, 1])
    assert numbers == [1, 2.5e-300, None, True, 0.5] and names == {"list": {"dict": "array"}}


@pytest.mark.parametrize(
    ("task", "message"),
    [
        (Task("a", double, (Path(),)), "arguments of task a: a PosixPath cannot be kept"),
        (Task("a", same, ({1: 2},)), "arguments of task a: a dict cannot be kept"),
        (Task("a", complex, (1, 2)), "result of task a: a complex cannot be kept"),
    ],
)
def test_what_is_not_plain_data_is_refused_where_it_would_be_kept(tmp_path: Path, task: Task, message: str):
    with pytest.raises(TypeError, match=message):
        run_tasks([task], LocalWorker(), tmp_path)


def disk_full(*_: object, **__: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_full_disk_leaves_the_results_before_it_and_nothing_half_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    run_tasks(TWO[:1], LocalWorker(), tmp_path)
    monkeypatch.setattr(Path, "replace", disk_full)
    with pytest.raises(OSError, match=f"No space left on device: '{tmp_path / '2.result'}'"):
        run_tasks(TWO, LocalWorker(), tmp_path)
    assert names(tmp_path) == {"1.result"}
    assert kept(TWO, tmp_path) == {"1": 2}
    CALLS.clear()
    monkeypatch.setattr(tasks_module, "TemporaryFile", disk_full)  # a directory that cannot be written
    with pytest.raises(OSError, match="No space left"):
        run_tasks(TWO, LocalWorker(), tmp_path)
    assert CALLS == []


def test_an_interrupt_keeps_what_is_done(tmp_path: Path):
    def interrupt(task: Task, result: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_tasks(TWO, LocalWorker(), tmp_path, interrupt)
    assert kept(TWO, tmp_path) == {"1": 2}


def test_the_digest_of_sources_sees_every_byte_and_name_of_sources_only(tmp_path: Path):
    sources = tmp_path / "package"
    (sources / "room").mkdir(parents=True)
    (sources / "a.py").write_bytes(b"x = 1")
    (sources / "room" / "b.py").write_bytes(b"y = 2")
    before = source_digest(sources)
    (sources / "notes.txt").write_text("no code")
    assert source_digest(sources) == before
    (sources / "a.py").write_bytes(b"x = 2")
    changed = source_digest(sources)
    (sources / "a.py").write_bytes(b"x = 1")
    assert changed != before == source_digest(sources)
    (sources / "room" / "b.py").rename(sources / "room" / "c.py")
    assert source_digest(sources) != before


def test_blas_has_one_thread_until_the_last_block_ends():
    """Also where blocks of two threads overlap and the first one ends first."""
    libraries = ThreadpoolController().select(user_api="blas").lib_controllers

    def threads():
        return {library.num_threads for library in libraries}

    with threadpool_limits(2, "blas"):
        first, second = one_blas_thread(), one_blas_thread()
        first.__enter__(), second.__enter__()
        assert threads() == {1}
        first.__exit__(None, None, None)
        assert threads() == {1}
        second.__exit__(None, None, None)
        assert threads() == {2}
