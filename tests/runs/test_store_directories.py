"""Names, locks and the disk: several processes at once, odd paths, systems that cannot do everything."""

import errno
import os
import shutil
import signal
import subprocess
import sys
import threading
import warnings
from pathlib import Path

import pytest
import xarray as xr
from cases import physics, stop_after

import ertel
from ertel.case.status import Status
from ertel.inputs.case_files import parse_case
from ertel.runs import checked_zarr, files, store
from ertel.runs.courses import TransientRun, method_of
from ertel.runs.directory import Taken, changes
from ertel.runs.files import StoreError
from ertel.runs.stepping import StepLimits
from ertel.runs.store import RunStore, compute

pytestmark = pytest.mark.filterwarnings("ignore:the film is not resolved", "ignore:the oil outside the domain")
DATA = {"name": "small", "contact": {"M": 200, "L": 10}, "solver": {"method": "radial", "nodes": 33}}
CASE = parse_case({**DATA, "time": {"tolerance": 0.01, "until": 0.15}, "output": {"interval": 0.05}})


# -- names ------------------------------------------------------------------------------------------------------------


def test_the_next_free_name(tmp_path):
    taken = [RunStore.create_unused(CASE, tmp_path / "runs").directory.name for _ in range(3)]
    assert taken == ["small", "small-2", "small-3"]
    assert sorted(path.name for path in (tmp_path / "runs").iterdir()) == taken


@pytest.mark.filterwarnings("ignore:Consolidated metadata is currently not part")  # filters are not those of a thread
def test_many_runs_at_once_take_different_names(tmp_path):
    """Of four, two were refused."""
    together, made = threading.Barrier(4), []

    def make():
        together.wait()
        made.append(RunStore.create_unused(CASE, tmp_path).directory)

    threads = [threading.Thread(target=make) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(path.name for path in made) == ["small", "small-2", "small-3", "small-4"]
    assert sorted(tmp_path.iterdir()) == sorted(made)
    assert all(RunStore.open(path).case == CASE for path in made)


def test_a_name_that_is_taken_at_the_last_moment(tmp_path, monkeypatch):
    """Between the look for it and the move."""
    rename = Path.rename

    def late(self, target):
        if Path(target).name == "small":
            (Path(target) / "of others").mkdir(parents=True)
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", late)
    assert RunStore.create_unused(CASE, tmp_path).directory == tmp_path / "small-2"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["small", "small-2"]
    with pytest.raises(Taken, match="small: exists already"):
        RunStore.create(tmp_path / "small", CASE)


def test_an_empty_directory_of_that_name_is_not_ours(tmp_path):
    """A move onto an empty directory replaces it."""
    (tmp_path / "small").mkdir()
    assert RunStore.create_unused(CASE, tmp_path).directory == tmp_path / "small-2"
    assert list((tmp_path / "small").iterdir()) == []


@pytest.mark.parametrize("path", ["run::1", "~/run", "s3:/bucket/run", "memory:/run"])
def test_a_path_is_a_path(tmp_path, monkeypatch, path):
    """Zarr would read some as addresses and others as below the home directory."""
    (tmp_path / "home").mkdir()
    (tmp_path / "here").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path / "here")
    compute(RunStore.create(Path(path), CASE), [stop_after(1)])
    summary = compute(RunStore.open(Path(path)))
    assert ertel.open(path).summary == summary
    assert list((tmp_path / "home").iterdir()) == []
    assert (tmp_path / "here" / path / "run.zarr").is_dir()


# -- one process at a time --------------------------------------------------------------------------------------------


def test_a_run_that_has_ended_meanwhile_is_left_alone(tmp_path):
    """A second process saw it running, and would have deleted its summary."""
    run = RunStore.create(tmp_path / "run", CASE)
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


def test_the_lock_keeps_others_out_and_is_given_back(tmp_path):
    run = RunStore.create(tmp_path / "run", CASE)
    with run.alone(), run.alone():
        second = RunStore.open(tmp_path / "run")
        with pytest.raises(StoreError, match="run: another process is computing this run"), second.alone():
            pytest.fail("two at once")
        with pytest.raises(StoreError, match="another process is computing this run"):
            compute(second)
    with second.alone():
        pass


def test_replacing_the_case_file_does_not_open_the_lock(tmp_path):
    """As an editor does when it saves."""
    run = RunStore.create(tmp_path / "run", CASE)
    with run.alone():
        path = tmp_path / "run" / "case.toml"
        (tmp_path / "new").write_text(path.read_text())
        (tmp_path / "new").replace(path)
        with pytest.raises(StoreError, match="another process is computing this run"):
            compute(RunStore.open(tmp_path / "run"))


def test_those_who_ask_for_the_lock_are_in_nobodys_way(tmp_path):
    """Neither of others who ask, nor of a run that begins just then."""
    fcntl = pytest.importorskip("fcntl")
    assert not files.is_locked(tmp_path) and not files.is_locked(tmp_path / "none")
    assert not (tmp_path / files.LOCK).exists()
    (tmp_path / files.LOCK).touch()
    asking = os.open(tmp_path / files.LOCK, os.O_RDONLY)
    fcntl.flock(asking, fcntl.LOCK_SH)  # what `is_locked` does
    assert not files.is_locked(tmp_path)
    threading.Timer(0.05, os.close, [asking]).start()
    with files.locked(tmp_path):
        assert files.is_locked(tmp_path)


needs_locks = pytest.mark.skipif(files.fcntl is None, reason="no locks on this system")
TRY = """
import fcntl, os, sys
handle = os.open(sys.argv[1], os.O_RDONLY)
try:
    fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
except BlockingIOError:
    print("refused")
else:
    print("taken")
"""
DIES = """
import os, pathlib, sys
from ertel.runs import files
with files.locked(pathlib.Path(sys.argv[1])):
    os.kill(os.getpid(), 9)
"""


def locking(path):
    """What another process gets that asks for the lock of a file or a directory."""
    return subprocess.run([sys.executable, "-c", TRY, path], capture_output=True, text=True, check=True).stdout.strip()


@needs_locks
def test_a_file_is_locked(tmp_path):
    """NFS does not pass the lock of a directory to the server, so that other machines did not see it."""
    run = RunStore.create(tmp_path / "run", CASE)
    assert not (tmp_path / "run" / files.LOCK).exists()
    with run.alone():
        assert locking(tmp_path / "run" / files.LOCK) == "refused"
        assert locking(tmp_path / "run") == "taken"
    assert locking(tmp_path / "run" / files.LOCK) == "taken"


@needs_locks
def test_a_locked_directory_is_in_nobodys_way(tmp_path):
    directory = os.open(tmp_path, os.O_RDONLY)
    files.fcntl.flock(directory, files.fcntl.LOCK_EX)
    assert not files.is_locked(tmp_path)
    with files.locked(tmp_path):
        assert files.is_locked(tmp_path)
    os.close(directory)


@needs_locks
def test_the_file_is_not_the_lock(tmp_path):
    """A process that was killed leaves it behind, and a copy of the run has one."""
    with files.locked(tmp_path):
        copy = Path(shutil.copytree(tmp_path, tmp_path / "copy"))
        assert files.is_locked(tmp_path) and not files.is_locked(copy)
    killed = subprocess.run([sys.executable, "-c", DIES, copy], capture_output=True)
    assert killed.returncode == -signal.SIGKILL
    assert (copy / files.LOCK).exists() and not files.is_locked(copy)
    inode = (copy / files.LOCK).stat().st_ino
    with files.locked(copy):
        assert files.is_locked(copy)
    assert (copy / files.LOCK).stat().st_ino == inode and (copy / files.LOCK).read_bytes() == b""


@needs_locks
def test_asking_keeps_the_lock_of_this_process(tmp_path):
    """A lock of `lockf` would be lost here."""
    with files.locked(tmp_path):
        assert files.is_locked(tmp_path)
        (tmp_path / files.LOCK).read_bytes()
        assert locking(tmp_path / files.LOCK) == "refused"


@needs_locks
@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir, lambda path: path.symlink_to("other")])
def test_something_else_in_the_place_of_the_lock(tmp_path, make):
    """A pipe must not be waited for, and a link not followed."""
    run = RunStore.create(tmp_path / "run", CASE)
    make(tmp_path / "run" / files.LOCK)
    assert not files.is_locked(tmp_path / "run")
    with pytest.raises(StoreError, match=r"run/.lock: is not a regular file, so that .* delete it$"), run.alone():
        pytest.fail("not locked")
    assert not (tmp_path / "run" / "other").exists()


@needs_locks
@pytest.mark.parametrize("kept", [False, True])
def test_a_directory_that_may_only_be_read(tmp_path, monkeypatch, kept):
    """It is asked as others are.  Whoever computes there all the same is warned, unless the lock file can be read."""
    if kept:
        (tmp_path / files.LOCK).touch()
    system = os.open

    def read_only(path, flags, mode=0o777, **options):
        if flags & (os.O_RDWR | os.O_CREAT):
            raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(path))
        return system(path, flags, mode, **options)

    monkeypatch.setattr(os, "open", read_only)
    assert not files.is_locked(tmp_path)
    with warnings.catch_warnings(record=True) as said, files.locked(tmp_path):
        assert files.is_locked(tmp_path) is kept
    assert [f"{tmp_path}: cannot be locked (read-only file system)" in str(each.message) for each in said] == (
        [] if kept else [True]
    )


@needs_locks
def test_a_lock_file_that_cannot_be_made(tmp_path, monkeypatch):
    def full(*arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "open", full)
    with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)), files.locked(tmp_path):
        pytest.fail("not locked")


@needs_locks
@pytest.mark.parametrize("number", [errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EBADF])
def test_a_file_system_without_locks(tmp_path, monkeypatch, number):
    def flock(handle, operation):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(files.fcntl, "flock", flock)
    run = RunStore.create(tmp_path / "run", CASE)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        compute(run, [stop_after(1)])
        assert compute(run)["status"] == "converged"
    ours = [str(warning.message) for warning in said if "locked" in str(warning.message)]
    assert len(ours) == 1
    assert ours[0].startswith(
        f"{tmp_path / 'run'}: cannot be locked ({os.strerror(number).lower()}); make sure that no"
    )


# -- the disk ---------------------------------------------------------------------------------------------------------


def test_all_is_on_the_disk_before_the_checkpoint_counts_on_it(tmp_path, monkeypatch):
    synced: list[int] = []
    fsync = os.fsync

    def record(handle):
        synced.append(os.fstat(handle).st_ino)
        fsync(handle)

    monkeypatch.setattr(os, "fsync", record)
    run = RunStore.create(tmp_path / "run", CASE)
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


def test_a_system_that_cannot_sync(tmp_path, monkeypatch):
    def fsync(handle):
        raise OSError(errno.EINVAL, "invalid argument")

    monkeypatch.setattr(os, "fsync", fsync)
    assert compute(RunStore.create(tmp_path / "run", CASE))["status"] == "converged"


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO])
def test_a_disk_that_fails_loses_nothing(tmp_path, monkeypatch, number):
    whole = compute(RunStore.create(tmp_path / "whole", CASE))
    run = RunStore.create(tmp_path / "run", CASE)
    compute(run, [stop_after(2)])

    def fsync(handle):
        raise OSError(number, os.strerror(number))

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", fsync)
        with pytest.raises(OSError, match=os.strerror(number)):
            compute(run)
    assert not list((tmp_path / "run").rglob("*.partial"))
    again = RunStore.open(tmp_path / "run")
    assert compute(again)["steps"] == whole["steps"]
    stored = RunStore.open(tmp_path / "whole").dataset()
    xr.testing.assert_identical(physics(again.dataset()), physics(stored))


# -- the end ----------------------------------------------------------------------------------------------------------


class Killed(BaseException):
    """Nobody catches it, like SIGKILL."""


def ends():
    """Runs by how they end: at a time, at an event, and by giving up."""
    event = parse_case({**DATA, "time": {"tolerance": 0.02, "until": "max-approach"}})
    return {
        "time": (CASE, None),
        "event": (event, None),
        "given up": (CASE, TransientRun(CASE, method_of(CASE), StepLimits(first=0.03, smallest=0.02))),
    }


@pytest.fixture(scope="module", params=["time", "event", "given up"])
def ended(request, tmp_path_factory):
    """A run that has ended, its course and its summary."""
    case, course = ends()[request.param]
    directory = tmp_path_factory.mktemp("ended") / "run"
    return directory, case, course, compute(RunStore.create(directory, case, course))


CUTS = [(RunStore, "summarise"), (RunStore, "finish"), (checked_zarr, "update_attributes"), (store, "sealed")]


@pytest.mark.parametrize(("place", "name"), CUTS)
def test_a_cut_between_the_last_checkpoint_and_the_summary(ended, tmp_path, monkeypatch, place, name):
    """A resumed run stepped past its end: restitution changed after an event, and a time raised an error."""
    directory, case, course, whole = ended
    original = getattr(place, name)

    def deadly(*arguments):
        original(*arguments)
        raise Killed

    run = RunStore.create(tmp_path / "run", case, course)
    with monkeypatch.context() as patch:
        patch.setattr(place, name, deadly)
        with pytest.raises(Killed):
            compute(run)
    (tmp_path / "run" / "summary.json").unlink(missing_ok=True)
    seen = []
    again = RunStore.open(tmp_path / "run")
    summary = compute(again, [lambda item: seen.append(item.record)])
    assert not any(seen)
    own = ("wall_s", "compilations")
    assert {k: v for k, v in summary.items() if k not in own} == {k: v for k, v in whole.items() if k not in own}
    assert Status(summary["status"]) is not Status.RUNNING
    data, expected = again.dataset(), RunStore.open(directory).dataset()
    xr.testing.assert_identical(physics(data), physics(expected))
    same = {k: v for k, v in data.attrs.items() if k not in (*own, "date_created")}
    assert same == {k: v for k, v in expected.attrs.items() if k not in (*own, "date_created")}


def test_directories_say_what_changed():
    before, now = {"contact": {"M": 200.0}, "name": "a"}, {"contact": {"M": 300.0}, "name": "b"}
    assert changes(before, now) == "contact.M 200.0 → 300.0"
