"""Runs of the paper's figures: their order, failures, what is kept, what is run again."""

import os
import pickle
from operator import truediv

import numpy as np
import pytest
import xarray as xr
from boundary_layers import tasks as tasks_module
from boundary_layers.tasks import Failure, Task, kept, run_tasks


class Evil:
    def __reduce__(self):
        return pytest.fail, ("code of a file was run",)


CALLS = []


def double(x):
    CALLS.append(x)
    return 2 * x


TWO = [Task(str(x), double, (x,)) for x in (1, 2)]


def test_a_failure_is_a_value_that_is_not_kept(tmp_path):
    tasks = [Task("good", truediv, (1, 2)), Task("bad", truediv, (1, 0))]
    failure = Failure("ZeroDivisionError: division by zero")
    assert run_tasks(tasks, tmp_path) == {"good": 0.5, "bad": failure}
    assert kept(tasks, tmp_path) == {"good": 0.5}
    assert run_tasks([Task("a", abs, (-1,)), Task("b", abs, (-2,))], tmp_path, jobs=2) == {"a": 1, "b": 2}


def test_what_is_kept_is_not_run_again(tmp_path):
    run_tasks(TWO[:1], tmp_path)
    CALLS.clear()
    seen = []
    run_tasks(TWO, tmp_path, 1, lambda task, result: seen.append((task.name, result)))
    assert CALLS == [2]
    assert seen == [("1", 2), ("2", 4)]


def test_results_of_other_arguments_or_sources_are_not_used(tmp_path, monkeypatch):
    task = Task("a", double, (1,))
    run_tasks([task], tmp_path)
    assert kept([task], tmp_path) == {"a": 2}
    assert run_tasks([Task("a", double, (5,))], tmp_path) == {"a": 10}
    run_tasks([task], tmp_path)
    monkeypatch.setattr(tasks_module, "_sources", lambda: "other sources")
    assert kept([task], tmp_path) == {}


def test_a_damaged_result_is_computed_again(tmp_path):
    task = Task("a", double, (1.5,))
    run_tasks([task], tmp_path)
    file = tmp_path / "a.result"
    whole = file.read_bytes()
    for bit in range(0, 8 * len(whole), 7):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        file.write_bytes(changed)
        assert kept([task], tmp_path) == {}, f"bit {bit}"
    for body in (b"", pickle.dumps(Evil()), b"text", b"3", b'{"a": 1}'):  # with the right checksum, too
        file.write_bytes(tasks_module._checksum(body) + b"\n" + body)
        assert kept([task], tmp_path) == {}, body
    assert run_tasks([task], tmp_path) == {"a": 3.0}
    assert file.read_bytes() == whole


def test_datasets_numbers_and_lists_come_back_exactly(tmp_path):
    data = xr.Dataset(
        {"H": (("wave", "X"), np.array([[0.1, np.nan], [np.inf, -0.0]])), "event": ("X", np.array([1, 2], "int8"))},
        {"wave": ["rings, 0.4", "µ"], "X": [0.5, 1 / 3], "frame": 1.0},
        {"M": 200.0, "title": "ball"},
    )
    task = Task("a", list, ([data, (1, 2.5e-300, None, True, np.float32(0.5)), {"list": {"dict": "array"}}],))
    run_tasks([task], tmp_path)
    again, numbers, names = kept([task], tmp_path)["a"]
    assert again.identical(data) and again["event"].dtype == "int8"
    assert np.signbit(again["H"].values[1, 1])
    assert numbers == [1, 2.5e-300, None, True, 0.5] and names == {"list": {"dict": "array"}}


def test_an_interruption_keeps_what_is_done(tmp_path, monkeypatch):
    def interrupt(task, result):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_tasks(TWO, tmp_path, 1, interrupt)
    assert kept(TWO, tmp_path) == {"1": 2}
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        run_tasks(TWO, tmp_path)
    assert kept(TWO, tmp_path) == {"1": 2}
