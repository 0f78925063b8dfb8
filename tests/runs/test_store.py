"""The store of a run: what it holds, and that no moment of death costs more than the last seconds, or the last grid."""

import errno
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import warnings
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr
from cases import LEFT, names, physics, stop_after
from dying import killed

import ertel
from ertel.case.case import Case
from ertel.case.status import Status
from ertel.inputs.case_files import load_case, parse_case
from ertel.runs import arrays, files
from ertel.runs.arrays import ReplacedData
from ertel.runs.drive import TransientRun, method_of, simulate
from ertel.runs.files import StoreError
from ertel.runs.stepping import StepLimits
from ertel.runs.store import RunStore, compute
from ertel.solvers import steady

pytestmark = pytest.mark.filterwarnings(
    "ignore:the film is not resolved", "ignore:the oil outside the domain", "ignore:H_min is uncertain"
)
OWN = ("wall_s", "compilations", "date_created")  # of the process
BALL = {"name": "small", "contact": {"M": 200, "L": 10}}
RADIAL = {**BALL, "solver": {"method": "radial", "nodes": 33}}
SHORT = parse_case({**RADIAL, "time": {"tolerance": 0.01, "until": 0.15}, "output": {"interval": 0.05}})
NINE_STEPS = {"time": {"tolerance": 0.01, "until": 0.2}, "output": {"interval": 0.05}}
CASES = {
    "impact": parse_case({**BALL, "solver": {"nodes": 33}, **NINE_STEPS}),
    "radial": parse_case({**RADIAL, **NINE_STEPS}),
    "steady": parse_case({"name": "small", "contact": {"kind": "rolling", "M": 20, "L": 10}, "solver": {"nodes": 65}}),
}


class Kind(NamedTuple):
    """A kind of run: its case, and its result in memory."""

    case: Case
    whole: ertel.Result

    def is_whole(self, run: RunStore) -> bool:
        """Whether a stored run is the one in memory."""
        xr.testing.assert_identical(physics(run.dataset()), physics(self.whole.dataset))
        summary = run.summary()
        return summary is not None and of_no_process(summary) == of_no_process(self.whole.summary)


def of_no_process(values):
    return {key: value for key, value in values.items() if key not in OWN}


@pytest.fixture(scope="module")
def kinds():
    return {name: Kind(case, simulate(case)) for name, case in CASES.items()}


@pytest.fixture(params=CASES)
def kind(request, kinds):
    return kinds[request.param]


@pytest.fixture
def impact(kinds):
    return kinds["impact"]


@pytest.fixture(scope="module")
def grids():
    """The solutions of the steady contact."""
    return list(steady.nested(CASES["steady"]))


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    """Runs that have not started; to copy one takes a fifth of the time in which it is made."""
    place = tmp_path_factory.mktemp("begun")
    return {name: RunStore.create(place / name, case).directory for name, case in CASES.items()}


# -- a whole run ------------------------------------------------------------------------------------------------------


def test_a_stored_run_is_the_run_in_memory(tmp_path, kind):
    run = RunStore.create(tmp_path / "run", kind.case)
    summary = compute(run)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = xr.open_zarr(tmp_path / "run" / "run.zarr").load()  # and nothing else
    xr.testing.assert_identical(physics(data), physics(kind.whole.dataset))
    assert (data.attrs["status"], data.attrs["M"]) == ("converged", kind.case.parameters.M)
    assert run.summary() == summary and kind.is_whole(run)
    again = load_case(tmp_path / "run" / "case.toml")
    assert again == kind.case and again.to_data() == kind.case.to_data()
    own = {"case.toml", "run.zarr", "checkpoint.npz", "summary.json", "progress.json"}
    assert names(tmp_path / "run") == LEFT | own


def test_variables_say_what_they_are(impact):
    data = impact.whole.dataset
    for name, variable in data.variables.items():
        assert {"units", "long_name", "symbol"} <= set(variable.attrs), name
    assert (data["H"].dims, data["H_c"].dims) == (("frame", "Y", "X"), ("time",))
    regular = data["frame"].values[data["event"].values == 0]
    np.testing.assert_allclose(regular, impact.case.output.interval * np.arange(1, len(regular) + 1), rtol=1e-12)
    assert np.all(np.diff(data["frame"]) >= 0)  # so that .sel(frame=..., method="nearest") works


def test_a_flush_writes_once_however_many_steps_there_are(tmp_path, monkeypatch):
    """It costs far less than the seconds between two of them: what is appended does not grow with the run."""
    appended, append = [], arrays.append

    def counting(path, arrays):
        appended.append(len(arrays.get("time", ())))
        append(path, arrays)

    monkeypatch.setattr(arrays, "append", counting)
    summary = compute(RunStore.create(tmp_path / "run", SHORT))
    assert sum(appended) == summary["steps"] > len(appended)


def test_nothing_computed_yet(tmp_path, kind):
    run = RunStore.create(tmp_path / "run", kind.case)
    assert run.summary() is None
    data = run.dataset()
    assert data.sizes["grid" if kind.case.is_steady else "time"] == 0
    assert np.isnan(data["H"].values).all()  # every map of a contact that is still to be computed: not a missing chunk
    with pytest.raises(StoreError, match="nothing is computed yet"):
        run.summary_so_far()


# -- interrupted ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "steps"), [("impact", 1), ("impact", 2), ("radial", 5), ("steady", 1)])
def test_resumed_equals_uninterrupted(tmp_path, kinds, name, steps):
    kind, run = kinds[name], RunStore.create(tmp_path / "run", CASES[name])
    first = compute(run, [stop_after(steps)])
    assert first["status"] == "interrupted"
    assert xr.open_zarr(tmp_path / "run" / "run.zarr").sizes["grid" if name == "steady" else "time"] == steps
    again, checkpoint = RunStore.open(tmp_path / "run"), np.load(tmp_path / "run" / "checkpoint.npz")
    assert compute(again)["wall_s"] > float(checkpoint["store_seconds"]) > 0
    assert kind.is_whole(again)


def test_resumed_many_times(tmp_path, impact):
    RunStore.create(tmp_path / "run", impact.case)
    for _ in range(100):
        run = RunStore.open(tmp_path / "run")
        if compute(run, [stop_after(3)])["status"] == "converged":
            break
    assert impact.is_whole(run)


def deaths():
    """Where a run can die: the functions that a flush calls, before and after each, sooner or later."""
    both = [(arrays, "write_root"), (Path, "replace"), (RunStore, "_write_checkpoint")]
    in_time = [*both, (arrays, "append"), (TransientRun, "to_arrays")]
    places = {"radial": in_time, "impact": in_time, "steady": [*both, (ReplacedData, "_write"), (Path, "rename")]}
    sooner = {"radial": [("before", 2), ("after", 3)], "impact": [], "steady": [("before", 1), ("after", 2)]}
    later = {
        "radial": [("after", 2), ("before", 5), ("after", 5)],
        "impact": [("before", 2), ("after", 2), ("before", 5), ("after", 5)],
        "steady": [("before", 2), ("before", 3), ("before", 4), ("after", 1), ("after", 3), ("after", 4)],
    }
    also_quick = [
        ("impact", "_write_checkpoint", "before", 2),
        ("impact", "append", "after", 5),
        ("steady", "write_root", "before", 4),  # at the end
        ("steady", "rename", "before", 4),  # between two of them
    ]
    for name, functions in places.items():
        for place, function in functions:
            yield from ((name, place, function, *moment) for moment in sooner[name])
            for moment in later[name]:
                quick = (name, function, *moment) in also_quick
                yield pytest.param(name, place, function, *moment, marks=[] if quick else pytest.mark.slow)


@pytest.mark.parametrize(("name", "place", "function", "when", "count"), list(deaths()))
def test_death_at_any_moment(tmp_path, monkeypatch, kinds, grids, begun, name, place, function, when, count):
    if name == "steady":
        monkeypatch.setattr(steady, "nested", lambda case, done: iter(grids[len(done) :]))
    run = RunStore.open(Path(shutil.copytree(begun[name], tmp_path / "run")))
    with killed(monkeypatch, place, function, when, count):
        compute(run, [lambda result: run.flush()])
    xr.open_zarr(arrays.present(tmp_path / "run" / "run.zarr")).load()  # a whole, if shorter, run
    again = RunStore.open(tmp_path / "run")
    again.dataset()
    compute(again)
    assert kinds[name].is_whole(again)
    assert not list((tmp_path / "run").rglob("*.partial")) and not list((tmp_path / "run").glob("*.old"))


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signal here")
@pytest.mark.parametrize("name", ["radial", pytest.param("impact", marks=pytest.mark.slow)])
def test_killed_process(tmp_path, name):
    """A real SIGKILL while the store is being written; a process that waits for it longer stays before its last step.

    All processes are new: commands tested before may have left other programs in this one, equal but for round-off.
    """
    program = """
        import sys
        from pathlib import Path
        from ertel.runs import store
        told = []
        def tell(item):
            print("step", flush=True)
            run.flush()
            told.append(item)
            if len(told) == 6:
                sys.stdin.read()
        for directory in sys.argv[1:]:
            run = store.RunStore.open(Path(directory))
            store.compute(run, [tell])
    """
    environment = {**os.environ, "PYTHONPATH": str(Path(ertel.__path__[0]).parent)}
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    start = [sys.executable, "-c", textwrap.dedent(program)]
    whole, broken = (RunStore.create(tmp_path / place, CASES[name]) for place in ("whole", "broken"))
    with subprocess.Popen([*start, broken.directory], **pipes, env=environment) as process:
        assert process.stdout is not None
        for _ in range(3):
            process.stdout.readline()
        process.kill()
    before = RunStore.open(broken.directory).summary_so_far()["steps"]
    both = [broken.directory, whole.directory]
    subprocess.run([*start, *both], env=environment, check=True, stdin=subprocess.DEVNULL, capture_output=True)
    assert 0 < before < whole.summary()["steps"]
    assert of_no_process(broken.summary()) == of_no_process(whole.summary())
    xr.testing.assert_identical(physics(broken.dataset()), physics(whole.dataset()))


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
    run = RunStore.create(tmp_path / "run", SHORT)
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


def ends():
    """Runs by how they end: at a time, at an event, and by giving up."""
    event = parse_case({**RADIAL, "time": {"tolerance": 0.02, "until": "max-approach"}})
    limits = StepLimits(first=0.03, smallest=0.02)
    return {"time": (SHORT, None), "event": (event, None), "given up": (SHORT, limits)}


class Ended(NamedTuple):
    """A run that has ended: its course, its summary and its data, and the directory as it was before it started."""

    course: TransientRun
    summary: dict
    data: xr.Dataset
    begun: Path


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """A function that gives the run with an end."""

    @cache
    def run(end):
        case, limits = ends()[end]
        course, place = TransientRun(case, method_of(case), limits), tmp_path_factory.mktemp("ended")
        store = RunStore.create(place / "run", case, course)
        begun = Path(shutil.copytree(place / "run", place / "begun"))
        return Ended(course, compute(store), store.dataset(), begun)

    return run


@pytest.mark.parametrize("end", ends())
def test_a_run_that_has_ended_keeps_what_it_has(ended, end):
    course, summary, data, _ = ended(end)
    assert summary["status"] == (Status.STEP_TOO_SMALL if course.limits.smallest == 0.02 else Status.CONVERGED).value
    assert 0 < data.sizes["time"] == summary["steps"]
    assert data.attrs["status"] == summary["status"]


CUTS = [(RunStore, "summarise"), (RunStore, "finish"), (arrays, "update_attributes"), (files, "sealed")]
QUICK = [*(("event", name) for _, name in CUTS), ("time", "summarise"), ("given up", "finish")]
EACH_CUT = [
    pytest.param(end, *cut, marks=[] if (end, cut[1]) in QUICK else pytest.mark.slow) for end in ends() for cut in CUTS
]


@pytest.mark.parametrize(("end", "place", "name"), EACH_CUT)
def test_a_cut_between_the_last_checkpoint_and_the_summary(ended, tmp_path, monkeypatch, end, place, name):
    """A resumed run stepped past its end: restitution changed after an event, and a time raised an error."""
    course, summary, data, begun = ended(end)
    run = RunStore(Path(shutil.copytree(begun, tmp_path / "run")), course.case, course)
    with killed(monkeypatch, place, name):
        compute(run)
    (tmp_path / "run" / "summary.json").unlink(missing_ok=True)
    seen = []
    again = RunStore.open(tmp_path / "run")
    assert of_no_process(compute(again, [lambda item: seen.append(item.record)])) == of_no_process(summary)
    assert not any(seen)
    xr.testing.assert_identical(physics(again.dataset()), physics(data))
    assert of_no_process(again.dataset().attrs) == of_no_process(data.attrs)


# -- the disk ---------------------------------------------------------------------------------------------------------


def test_all_is_on_the_disk_before_the_checkpoint_counts_on_it(tmp_path, monkeypatch):
    synced: list[int] = []
    fsync = os.fsync

    def record(handle):
        synced.append(os.fstat(handle).st_ino)
        fsync(handle)

    monkeypatch.setattr(os, "fsync", record)
    run = RunStore.create(tmp_path / "run", SHORT)
    compute(run)
    last = {inode: place for place, inode in enumerate(synced)}
    inode = {path: path.stat().st_ino for path in (tmp_path / "run").rglob("*")}
    checkpoint = last[inode[tmp_path / "run" / "checkpoint.npz"]]
    chunks = [path for path in inode if path.is_file() and "c" in path.parts]
    assert {"H_c", "H", "r"} <= {path.relative_to(tmp_path / "run" / "run.zarr").parts[0] for path in chunks}
    for chunk in chunks:
        assert last[inode[chunk]] < checkpoint
        assert inode[chunk.parent] in synced
    assert inode[tmp_path / "run" / "case.toml"] in synced
    assert inode[tmp_path / "run" / "run.zarr" / "zarr.json"] in synced
    assert last[inode[tmp_path / "run" / "summary.json"]] > checkpoint


def failing(number):
    def fsync(handle):
        raise OSError(number, os.strerror(number))

    return fsync


def test_a_system_that_cannot_sync(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", failing(errno.EINVAL))
    assert compute(RunStore.create(tmp_path / "run", SHORT))["status"] == "converged"


def test_a_disk_that_fails_loses_nothing(tmp_path, monkeypatch):
    whole, run = simulate(SHORT), RunStore.create(tmp_path / "run", SHORT)
    compute(run, [stop_after(2)])
    for number in (errno.ENOSPC, errno.EIO):
        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", failing(number))
            with pytest.raises(OSError, match=os.strerror(number)):
                compute(run)
        assert not list((tmp_path / "run").rglob("*.partial"))
    again = RunStore.open(tmp_path / "run")
    assert compute(again)["steps"] == whole.summary["steps"]
    xr.testing.assert_identical(physics(again.dataset()), physics(whole.dataset))


# -- ertel.run and ertel.open -----------------------------------------------------------------------------------------


def test_run_takes_up_what_was_interrupted_and_reads_what_is_done(tmp_path, impact):
    first = ertel.run(impact.case, tmp_path / "run", observers=[stop_after(4)])
    assert (first.status, first.dataset.sizes["time"]) == (Status.INTERRUPTED, 4)
    second = ertel.run(impact.case, str(tmp_path / "run"))
    xr.testing.assert_identical(physics(second.dataset), physics(impact.whole.dataset))
    seen = []
    third = ertel.run(impact.case, tmp_path / "run", observers=[seen.append])
    assert seen == [] and third.status.ok
    xr.testing.assert_identical(third.dataset, second.dataset)
    again = ertel.open(tmp_path / "run")
    assert (again.case, again.directory) == (impact.case, tmp_path / "run")
    assert again.summary == third.summary
    assert f"stored in {tmp_path / 'run'}" in repr(again)


def test_run_refuses_the_directory_of_another_case(tmp_path):
    RunStore.create(tmp_path / "run", SHORT)
    other = parse_case({**RADIAL, "contact": {"M": 300, "L": 10}})
    with pytest.raises(StoreError, match=r"run: holds another case \(contact\.M 200\.0 → 300\.0"):
        ertel.run(other, tmp_path / "run")
