"""The run directory: what it holds, and that no moment of death costs more than the last seconds."""

import itertools
import os
import signal
import subprocess
import sys
import textwrap
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from cases import physics, stop_after

import ertel
from ertel.case.status import Status
from ertel.inputs.case_files import load_case, parse_case
from ertel.runs import checked_zarr
from ertel.runs.arrays import AppendedData
from ertel.runs.courses import TransientRun, method_of
from ertel.runs.drive import simulate
from ertel.runs.files import StoreError
from ertel.runs.stepping import StepLimits
from ertel.runs.store import RunStore, compute

pytestmark = pytest.mark.filterwarnings("ignore:the film is not resolved", "ignore:the oil outside the domain")
CASE = {
    "name": "small",
    "contact": {"M": 200, "L": 10},
    "solver": {"nodes": 33},
    "time": {"tolerance": 0.01, "until": 0.9},
}


@pytest.fixture(scope="module")
def case():
    return parse_case(CASE)


@pytest.fixture(scope="module")
def uninterrupted(case):
    return simulate(case)


def at_every_step(run):
    """An observer that has everything written at once."""
    return lambda item: run.flush()


# -- a whole run ------------------------------------------------------------------------------------------------------


def test_a_stored_run_is_the_run_in_memory(tmp_path, case, uninterrupted):
    run = RunStore.create(tmp_path / "run", case)
    summary = compute(run)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = xr.open_zarr(tmp_path / "run" / "run.zarr").load()  # and nothing else
    xr.testing.assert_identical(physics(data), physics(uninterrupted.dataset))
    assert data.attrs["status"] == "converged"
    assert data.attrs["M"] == case.parameters.M
    assert data.attrs["steps"] == summary["steps"] == uninterrupted.summary["steps"]
    assert run.summary() == summary
    same = {key: value for key, value in summary.items() if key not in ("wall_s", "compilations")}
    assert same.items() <= dict(uninterrupted.summary).items()


def test_the_resolved_case_is_the_case(tmp_path, case):
    RunStore.create(tmp_path / "run", case)
    again = load_case(tmp_path / "run" / "case.toml")
    assert again == case
    assert again.to_data() == case.to_data()


def test_variables_say_what_they_are(uninterrupted):
    for name, variable in uninterrupted.dataset.variables.items():
        assert {"units", "long_name", "symbol"} <= set(variable.attrs), name
    assert uninterrupted.dataset["H"].dims == ("frame", "Y", "X")
    assert uninterrupted.dataset["H_c"].dims == ("time",)


def test_frames_are_at_their_times(uninterrupted, case):
    frames = uninterrupted.dataset["frame"].values
    regular = frames[uninterrupted.dataset["event"].values == 0]
    assert np.allclose(regular, case.output.interval * np.arange(1, len(regular) + 1), rtol=1e-12)
    assert np.all(np.diff(frames) >= 0)  # so that .sel(frame=..., method="nearest") works


def test_a_flush_writes_once_however_many_steps_there_are(tmp_path, monkeypatch, case):
    """It costs far less than the seconds between two of them: what is appended does not grow with the run."""
    run = RunStore.create(tmp_path / "run", case)
    appended, append = [], checked_zarr.append

    def counting(path, arrays):
        appended.append(len(arrays.get("time", ())))
        append(path, arrays)

    monkeypatch.setattr(checked_zarr, "append", counting)
    summary = compute(run)
    assert sum(appended) == summary["steps"] > len(appended)


# -- interrupted ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("steps", [1, 2, 7])
def test_resumed_equals_uninterrupted(tmp_path, case, uninterrupted, steps):
    run = RunStore.create(tmp_path / "run", case)
    assert compute(run, [stop_after(steps)])["status"] == "interrupted"
    assert run.dataset().sizes["time"] == steps
    again = RunStore.open(tmp_path / "run")
    summary = compute(again)
    xr.testing.assert_identical(physics(again.dataset()), physics(uninterrupted.dataset))
    assert summary["status"] == "converged"
    assert summary["newton_iterations"] == uninterrupted.summary["newton_iterations"]


def test_resumed_equals_uninterrupted_for_the_radial_method(tmp_path):
    case = parse_case({**CASE, "solver": {"method": "radial", "nodes": 49}})
    compute(RunStore.create(tmp_path / "run", case), [stop_after(9)])
    again = RunStore.open(tmp_path / "run")
    compute(again)
    assert again.dataset()["H"].dims == ("frame", "r")
    xr.testing.assert_identical(physics(again.dataset()), physics(simulate(case).dataset))


def test_resumed_many_times(tmp_path, case, uninterrupted):
    RunStore.create(tmp_path / "run", case)
    for _ in range(100):
        run = RunStore.open(tmp_path / "run")
        if compute(run, [stop_after(3)])["status"] == "converged":
            break
    xr.testing.assert_identical(physics(run.dataset()), physics(uninterrupted.dataset))


def test_wall_time_adds_up(tmp_path, case):
    first = compute(RunStore.create(tmp_path / "run", case), [stop_after(2)])["wall_s"]
    second = compute(RunStore.open(tmp_path / "run"))["wall_s"]
    assert second > first > 0


def test_a_run_that_ended_is_not_stepped_further_without_its_summary(tmp_path, case, uninterrupted):
    """The checkpoint says that the run has ended, and how."""
    compute(RunStore.create(tmp_path / "run", case))
    (tmp_path / "run" / "summary.json").unlink()
    seen = []
    again = RunStore.open(tmp_path / "run")
    summary = compute(again, [lambda item: seen.append(item.record)])
    assert summary["status"] == "converged"
    assert not any(seen)
    xr.testing.assert_identical(physics(again.dataset()), physics(uninterrupted.dataset))


class Killed(BaseException):
    """Nobody catches it, like SIGKILL."""


def deaths():
    """Where a run can die: the functions that a flush calls, before and after each, sooner or later.

    Quick: early before, late after.
    """
    places = [
        (checked_zarr, "append"),
        (checked_zarr, "write_root"),
        (Path, "replace"),
        (RunStore, "_write_checkpoint"),
        (TransientRun, "to_arrays"),
    ]
    quick = [("before", 2), ("after", 5)]
    slow = [("before", 5), ("after", 2)]
    return [
        *((place, name, *moment) for place, name in places for moment in quick),
        *(pytest.param(place, name, *moment, marks=pytest.mark.slow) for place, name in places for moment in slow),
    ]


@pytest.mark.parametrize(("place", "name", "when", "count"), deaths())
def test_death_within_a_flush(tmp_path, monkeypatch, case, uninterrupted, place, name, when, count):
    run = RunStore.create(tmp_path / "run", case)
    original, calls = getattr(place, name), itertools.count(1)

    def deadly(*arguments, **options):
        last = next(calls) == count
        if last and when == "before":
            raise Killed
        result = original(*arguments, **options)
        if last:
            raise Killed
        return result

    with monkeypatch.context() as patch:
        patch.setattr(place, name, deadly)
        with pytest.raises(Killed):
            compute(run, [at_every_step(run)])
    xr.open_zarr(tmp_path / "run" / "run.zarr").load()  # readers see a whole, if shorter, run
    again = RunStore.open(tmp_path / "run")
    compute(again)
    xr.testing.assert_identical(physics(again.dataset()), physics(uninterrupted.dataset))


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signal here")
def test_killed_process(tmp_path, case, uninterrupted):
    """A real SIGKILL while the store is being written."""
    RunStore.create(tmp_path / "run", case)
    program = f"""
        from pathlib import Path
        from ertel.runs import store
        run = store.RunStore.open(Path({str(tmp_path / "run")!r}))
        def tell(item):
            print("step", flush=True)
            run.flush()
        store.compute(run, [tell])
    """
    path = str(Path(ertel.__path__[0]).parent)
    environment = {**os.environ, "PYTHONPATH": path}
    command = [sys.executable, "-c", textwrap.dedent(program)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout is not None
        for _ in range(4):
            process.stdout.readline()
        process.kill()
    again = RunStore.open(tmp_path / "run")
    seen = again.summary_so_far()["steps"]
    assert 0 < seen < uninterrupted.summary["steps"]
    compute(again)
    xr.testing.assert_identical(physics(again.dataset()), physics(uninterrupted.dataset))


def test_a_run_that_gives_up_keeps_what_it_has(tmp_path, case, uninterrupted):
    course = TransientRun(case, method_of(case), StepLimits(first=0.03, smallest=0.02))
    run = RunStore.create(tmp_path / "run", case, course)
    summary = compute(run)
    assert summary["status"] == Status.STEP_TOO_SMALL.value
    assert summary["max_approach"] is None
    assert 0 < run.dataset().sizes["time"] == summary["steps"] < uninterrupted.summary["steps"]
    assert run.dataset().attrs["status"] == summary["status"]


def test_only_one_at_a_time(tmp_path, case):
    run = RunStore.create(tmp_path / "run", case)
    second = RunStore.open(tmp_path / "run")

    def meddle(item):
        with pytest.raises(StoreError, match="another process"):
            compute(second)
        return True

    compute(run, [meddle])
    assert compute(second)["status"] == "converged"


# -- ertel.run and ertel.open -----------------------------------------------------------------------------------------


def test_run_takes_up_what_was_interrupted_and_reads_what_is_done(tmp_path, case, uninterrupted):
    first = ertel.run(case, tmp_path / "run", observers=[stop_after(4)])
    assert (first.status, first.dataset.sizes["time"]) == (Status.INTERRUPTED, 4)
    second = ertel.run(case, str(tmp_path / "run"))
    xr.testing.assert_identical(physics(second.dataset), physics(uninterrupted.dataset))
    seen = []
    third = ertel.run(case, tmp_path / "run", observers=[seen.append])
    assert seen == [] and third.status.ok
    xr.testing.assert_identical(third.dataset, second.dataset)
    again = ertel.open(tmp_path / "run")
    assert (again.case, again.directory) == (case, tmp_path / "run")
    assert again.summary == third.summary
    assert f"stored in {tmp_path / 'run'}" in repr(again)


def test_run_refuses_the_directory_of_another_case(tmp_path, case):
    RunStore.create(tmp_path / "run", case)
    other = parse_case({**CASE, "contact": {"M": 300, "L": 10}})
    with pytest.raises(StoreError, match=r"run: holds another case \(contact\.M 200\.0 → 300\.0\)"):
        ertel.run(other, tmp_path / "run")


def test_open_where_nothing_is(tmp_path):
    with pytest.raises(ValueError, match=r"nowhere is not an ertel run directory \(no case\.toml\)"):
        ertel.open(tmp_path / "nowhere")


# -- directories that will not do -------------------------------------------------------------------------------------


def test_existing_output_is_left_alone(tmp_path, case):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "precious").write_text("data")
    with pytest.raises(StoreError, match=r"run: exists already"):
        RunStore.create(tmp_path / "run", case)
    assert [path.name for path in tmp_path.rglob("*")] == ["run", "precious"]


def test_an_empty_directory_will_do(tmp_path, case):
    (tmp_path / "run").mkdir()
    RunStore.create(tmp_path / "run", case)
    assert RunStore.open(tmp_path / "run").case == case


def test_a_file_in_the_way(tmp_path, case):
    (tmp_path / "file").write_text("")
    for target in (tmp_path / "file", tmp_path / "file" / "run"):
        with pytest.raises(StoreError):
            RunStore.create(target, case)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_failure_while_making_leaves_nothing(tmp_path, monkeypatch, case):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(AppendedData, "create", full)
    with pytest.raises(StoreError, match="run: cannot write there, no space left on device"):
        RunStore.create(tmp_path / "run", case)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("missing", ["case.toml", "run.zarr"])
def test_not_a_run(tmp_path, missing):
    for name in {"case.toml", "run.zarr"} - {missing}:
        (tmp_path / name).mkdir()
    with pytest.raises(StoreError, match=rf"is not an ertel run directory \(no {missing}\)"):
        RunStore.open(tmp_path)


def test_nothing_computed_yet(tmp_path, case):
    run = RunStore.create(tmp_path / "run", case)
    assert run.summary() is None
    assert run.dataset().sizes["time"] == 0
    with pytest.raises(StoreError, match="nothing is computed yet"):
        run.summary_so_far()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a POSIX system")
@pytest.mark.parametrize("name", ["summary.json", "checkpoint.npz"])
def test_a_pipe_is_not_waited_for(tmp_path, case, name):
    """Reading it would never end."""
    run = RunStore.create(tmp_path / "run", case)
    os.mkfifo(tmp_path / "run" / name)
    read = run.summary if name == "summary.json" else run.item
    with pytest.raises(OSError, match=f"not a regular file: .*{name}"):
        read()
