"""The store of a run: what it holds, and that no moment of death costs more than the last seconds, or the last grid."""

import errno
import itertools
import os
import shutil
import threading
import warnings
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from cases import LEFT, RADIAL, SHORT_FALL, names, stop_after
from stored_runs import CASES

import ertel
from ertel.case.status import Status
from ertel.inputs.case_files import load_case, parse_case
from ertel.runs import arrays, files
from ertel.runs.arrays import ReplacedData
from ertel.runs.files import StoreError
from ertel.runs.stepping import TransientRun
from ertel.runs.store import RunStore, compute
from ertel.solvers import steady


@pytest.fixture(params=["radial", "steady", pytest.param("impact", marks=pytest.mark.slow)])
def kind(request, kinds):
    return kinds[request.param]


# -- a whole run ------------------------------------------------------------------------------------------------------


def test_a_stored_run_is_the_run_in_memory(tmp_path, kind):
    run = RunStore.create(tmp_path / "run", kind.case)
    summary = compute(run)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = xr.open_zarr(tmp_path / "run" / "run.zarr").load()  # and nothing else
    assert (data.attrs["status"], data.attrs["M"]) == ("converged", kind.case.parameters.M)
    assert run.summary() == summary and kind.is_whole(run)
    again = load_case(tmp_path / "run" / "case.toml")
    assert again == kind.case and again.to_data() == kind.case.to_data()
    files_of_a_run = {"case.toml", "run.zarr", "checkpoint.npz", "summary.json", "progress.json"}
    assert names(tmp_path / "run") == LEFT | files_of_a_run


# -- interrupted ------------------------------------------------------------------------------------------------------


MORE = [pytest.param(*each, marks=pytest.mark.slow) for each in (("impact", 4), ("radial", 1), ("steady", 1))]


@pytest.mark.parametrize(("name", "steps"), [("radial", 2), *MORE])
def test_resumed_as_often_as_need_be_equals_uninterrupted(tmp_path, kinds, name, steps):
    kind, seconds, rows = kinds[name], 0.0, "grid" if name == "steady" else "time"
    RunStore.create(tmp_path / "run", kind.case)
    for number in range(1, 100):
        run = RunStore.open(tmp_path / "run")
        summary = compute(run, [stop_after(steps)])
        assert summary["wall_s"] > seconds
        if summary["status"] == "converged":
            break
        assert summary["status"] == "interrupted"
        assert xr.open_zarr(tmp_path / "run" / "run.zarr").sizes[rows] == number * steps
        seconds = float(np.load(tmp_path / "run" / "checkpoint.npz")["store_seconds"])
        assert seconds > 0
    assert kind.is_whole(run) and number > 1


BOTH = [(arrays, "write_root"), (Path, "replace"), (RunStore, "_write_checkpoint")]
IN_TIME = [*BOTH, (arrays, "append"), (TransientRun, "to_arrays")]
GRIDS = [*BOTH, (ReplacedData, "_write"), (Path, "rename")]
EVER = list(itertools.product(("before", "after"), range(1, 6)))
DEATHS = {  # before or after which calls of the functions that a flush calls, and how many states these are at least
    "radial": (IN_TIME, [("before", 2), ("after", 3)], 7),
    "steady": (GRIDS, [("before", 1), ("after", 2)], 5),
    "radial, ever": (IN_TIME, EVER, 20),
    "steady, ever": (GRIDS, EVER, 15),
    "impact, ever": (IN_TIME, EVER, 20),
}


def states(kind, functions, moments, place, monkeypatch):
    """Copies of a run while it is computed: the different states in which a death at one of the moments leaves it."""
    run = RunStore.open(Path(shutil.copytree(kind.begun, place / "run")))
    found, known, still = [], [], threading.RLock()  # chunks are written by many threads

    def look(moment, name):
        if moment not in moments:
            return
        with still:
            about = {path: path.stat() for path in run.directory.rglob("*") if path.is_file()}
            files = {path: (stat.st_ino, stat.st_mtime_ns, stat.st_size) for path, stat in about.items()}
            if files not in known:
                known.append(files)
                found.append(Path(shutil.copytree(run.directory, place / f"{moment} {name}")))

    def watched(function):
        calls, is_short = itertools.count(1), function is Path.replace

        def call(*arguments, **options):
            number = next(calls)
            with still if is_short else nullcontext():  # nothing vanishes while it is copied
                look(("before", number), function.__name__)
                result = function(*arguments, **options)
                look(("after", number), function.__name__)
            return result

        return call

    with monkeypatch.context() as patch:
        for owner, name in functions:
            patch.setattr(owner, name, watched(getattr(owner, name)))
        compute(run, [lambda result: run.flush(), stop_after(max(number for _, number in moments))])
    return found


@pytest.mark.parametrize(
    "deaths", [pytest.param(name, marks=[] if name == "radial" else pytest.mark.slow) for name in DEATHS]
)
def test_death_at_any_moment(tmp_path, monkeypatch, kinds, grids, deaths):
    functions, moments, fewest = DEATHS[deaths]
    kind = kinds[deaths.partition(",")[0]]
    if kind.case.is_steady:
        monkeypatch.setattr(steady, "nested", lambda case, done: iter(grids[len(done) :]))
    left = states(kind, functions, moments, tmp_path, monkeypatch)
    assert len(left) >= fewest
    monkeypatch.setattr(files, "YOUNG", 0.0)  # a minute has passed
    for directory in left:
        xr.open_zarr(arrays.present(directory / "run.zarr")).load()  # a whole, if shorter, run
        again = RunStore.open(directory)
        again.dataset()
        compute(again)
        assert kind.is_whole(again), directory.name
        assert not list(directory.rglob("*.partial")) and not list(directory.glob("*.old"))


# -- the end ----------------------------------------------------------------------------------------------------------


def test_a_steady_run_that_ended_is_not_computed_again_without_its_summary(tmp_path, monkeypatch, kinds, grids):
    with monkeypatch.context() as patch:
        patch.setattr(steady, "nested", lambda case, done: iter(grids[len(done) :]))
        compute(RunStore.create(tmp_path / "run", CASES["steady"]))
    (tmp_path / "run" / "summary.json").unlink()
    monkeypatch.setattr(steady, "nested", lambda *_: pytest.fail("the run has ended"))
    again = RunStore.open(tmp_path / "run")
    compute(again)
    assert kinds["steady"].is_whole(again)


def test_a_run_that_has_ended_meanwhile_is_left_alone(tmp_path):
    """A second process saw it running, and would have deleted its summary."""
    run = RunStore.create(tmp_path / "run", SHORT_FALL)
    second = RunStore.open(tmp_path / "run")
    assert second.summary() is None
    summary = compute(run)
    before = (tmp_path / "run" / "summary.json").read_bytes()
    with second.alone():
        assert second.outcome() == summary
        assert compute(second, [lambda item: pytest.fail("nothing is left to do")]) == summary
        assert (tmp_path / "run" / "summary.json").read_bytes() == before
        second.finish({**summary, "error_estimate": None})
    assert RunStore.open(tmp_path / "run").summary() == {**summary, "error_estimate": None}


class Killed(BaseException):
    """Nobody catches it, like SIGKILL."""


ENDS = ("ends at a time", "ends at an event", "gives up")
CUTS = [(RunStore, "summarise"), (RunStore, "finish"), (arrays, "update_attributes"), (files, "sealed")]
QUICK = [(ENDS[0], "summarise"), (ENDS[2], "finish")]


@pytest.mark.parametrize(
    ("end", "place", "name"),
    [pytest.param(end, *cut, marks=[] if (end, cut[1]) in QUICK else pytest.mark.slow) for end in ENDS for cut in CUTS],
)
def test_a_cut_between_the_last_checkpoint_and_the_summary(kinds, tmp_path, monkeypatch, end, place, name):
    """A resumed run stepped past its end: restitution changed after an event, and a time raised an error."""
    run = RunStore(Path(shutil.copytree(kinds[end].begun, tmp_path / "run")), CASES[end], kinds[end].run)
    original = getattr(place, name)

    def deadly(*arguments, **options):
        original(*arguments, **options)
        raise Killed

    with monkeypatch.context() as patch, pytest.raises(Killed):
        patch.setattr(place, name, deadly)
        compute(run)
    (tmp_path / "run" / "summary.json").unlink(missing_ok=True)
    seen = []
    again = RunStore.open(tmp_path / "run")
    compute(again, [lambda item: seen.append(item.record)])
    assert kinds[end].is_whole(again) and not any(seen)
    status = Status.STEP_TOO_SMALL if end == "gives up" else Status.CONVERGED
    summary, data = again.summary(), again.dataset()
    assert summary["status"] == data.attrs["status"] == status.value and 0 < data.sizes["time"] == summary["steps"]


# -- the disk ---------------------------------------------------------------------------------------------------------


def test_all_is_on_the_disk_before_the_checkpoint_counts_on_it(tmp_path, monkeypatch):
    synced: list[int] = []
    monkeypatch.setattr(os, "fsync", lambda handle: synced.append(os.fstat(handle).st_ino))
    run = RunStore.create(tmp_path / "run", SHORT_FALL)
    compute(run)
    last = {inode: place for place, inode in enumerate(synced)}
    inode = {path: path.stat().st_ino for path in (tmp_path / "run").rglob("*")}
    checkpoint = last[inode[tmp_path / "run" / "checkpoint.npz"]]
    chunks = [path for path in (tmp_path / "run" / "run.zarr").glob("*/c/**/*") if path.is_file()]
    assert {"H_c", "H", "r"} <= {path.relative_to(tmp_path / "run" / "run.zarr").parts[0] for path in chunks}
    for chunk in chunks:
        assert last[inode[chunk]] < checkpoint
        assert inode[chunk.parent] in synced
    assert inode[tmp_path / "run" / "case.toml"] in synced
    assert inode[tmp_path / "run" / "run.zarr" / "zarr.json"] in synced
    assert last[inode[tmp_path / "run" / "summary.json"]] > checkpoint


def test_a_disk_that_fails_loses_nothing(tmp_path, monkeypatch, kinds):
    run = RunStore.create(tmp_path / "run", SHORT_FALL)
    compute(run, [stop_after(2)])
    for number in (errno.ENOSPC, errno.EIO):

        def refuse(handle, number=number):
            raise OSError(number, os.strerror(number))

        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", refuse)
            with pytest.raises(OSError, match=os.strerror(number)):
                compute(run)
        assert not list((tmp_path / "run").rglob("*.partial"))
    again = RunStore.open(tmp_path / "run")
    compute(again)
    assert kinds[ENDS[0]].is_whole(again)


# -- ertel.run and ertel.open -----------------------------------------------------------------------------------------


def test_run_takes_up_what_was_interrupted_and_reads_what_is_done(tmp_path, impact):
    first = ertel.run(impact.case, tmp_path / "run", observers=[stop_after(4)])
    assert (first.status, first.dataset.sizes["time"]) == (Status.INTERRUPTED, 4)
    second = ertel.run(impact.case, str(tmp_path / "run"))
    assert impact.opened(tmp_path / "run")
    third = ertel.run(impact.case, tmp_path / "run", observers=[lambda item: pytest.fail("nothing is left to do")])
    assert third.status.ok
    xr.testing.assert_identical(third.dataset, second.dataset)
    again = ertel.open(tmp_path / "run")
    assert (again.case, again.directory) == (impact.case, tmp_path / "run")
    assert again.summary == third.summary
    assert f"stored in {tmp_path / 'run'}" in repr(again)


def test_run_refuses_the_directory_of_another_case(tmp_path):
    RunStore.create(tmp_path / "run", SHORT_FALL)
    other = parse_case({**RADIAL, "contact": {"M": 300, "L": 10}})
    with pytest.raises(StoreError, match=r"run: holds another case \(contact\.M 200\.0 → 300\.0"):
        ertel.run(other, tmp_path / "run")
