"""Run directories: their names, also of several processes at once, those that will not do, and their locks."""

import errno
import os
import shutil
import signal
import subprocess
import sys
import threading
import warnings
from dataclasses import replace
from pathlib import Path

import pytest
from cases import SHORT_FALL, names, stop_after

import ertel
from ertel.runs import files
from ertel.runs.arrays import AppendedData
from ertel.runs.directory import Taken
from ertel.runs.files import StoreError
from ertel.runs.store import RunStore, compute, prune


def refusing(monkeypatch, place, name, number, when=lambda *arguments: True):
    system = getattr(place, name)

    def call(*arguments, **options):
        if when(*arguments):
            raise OSError(number, os.strerror(number))
        return system(*arguments, **options)

    monkeypatch.setattr(place, name, call)


def test_the_next_free_name_and_an_empty_directory(tmp_path):
    taken = [RunStore.create_unused(SHORT_FALL, tmp_path / "runs").directory.name for _ in range(2)]
    assert taken == ["small", "small-2"] == sorted(names(tmp_path / "runs"))
    # A move onto an empty directory replaces it, so another name is found where none is given.
    (tmp_path / "small").mkdir()
    assert RunStore.create_unused(SHORT_FALL, tmp_path).directory == tmp_path / "small-2"
    assert names(tmp_path / "small") == set()
    RunStore.create(tmp_path / "small", SHORT_FALL)
    assert RunStore.open(tmp_path / "small").case == SHORT_FALL


def test_a_name_that_is_taken_at_the_last_moment(tmp_path, monkeypatch):
    """Between the look for it and the move."""
    rename = Path.rename

    def late(self, target):
        if Path(target).name == "small":
            (Path(target) / "of others").mkdir(parents=True)
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", late)
    assert RunStore.create_unused(SHORT_FALL, tmp_path).directory == tmp_path / "small-2"
    assert names(tmp_path) == {"small", "small-2"}
    with pytest.raises(Taken, match="small: exists already"):
        RunStore.create(tmp_path / "small", SHORT_FALL)


def test_a_path_is_a_path(tmp_path, monkeypatch):
    """Zarr would read some as addresses and others as below the home directory."""
    for name in ("home", "here"):
        (tmp_path / name).mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path / "here")
    for path in ("run::1", "~/run", "s3:/bucket/run", "memory:/run"):
        summary = compute(RunStore.create(Path(path), SHORT_FALL), [stop_after(1)])
        assert ertel.open(path).summary == summary
        assert (tmp_path / "here" / path / "run.zarr").is_dir()
    assert names(tmp_path / "home") == set()


def test_existing_output_is_left_alone_and_a_failure_leaves_nothing(tmp_path, monkeypatch):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "precious").write_text("data")
    for target, said in (("run", "exists already"), ("run/precious", "precious: "), ("run/precious/run", "run: ")):
        with pytest.raises(StoreError, match=said):
            RunStore.create(tmp_path / target, SHORT_FALL)
    assert [path.name for path in tmp_path.rglob("*")] == ["run", "precious"]

    refusing(monkeypatch, AppendedData, "create", errno.ENOSPC)
    with pytest.raises(StoreError, match="other: cannot write there, no space left on device"):
        RunStore.create(tmp_path / "other", SHORT_FALL)
    assert names(tmp_path) == {"run"}


@pytest.mark.parametrize("missing", ["case.toml", "run.zarr"])
def test_not_a_run(tmp_path, missing):
    for name in {"case.toml", "run.zarr"} - {missing}:
        (tmp_path / name).mkdir()
    with pytest.raises(StoreError, match=rf"is not an ertel run directory \(no {missing}\)"):
        RunStore.open(tmp_path)


locking = pytest.mark.skipif(files.fcntl is None, reason="no locks on this system")


@locking
def test_the_lock_keeps_others_out_and_is_given_back(tmp_path):
    """Also where case.toml is replaced, as an editor does when it saves."""
    run = RunStore.create(tmp_path / "run", SHORT_FALL)
    with run.alone(), run.alone():
        second = RunStore.open(tmp_path / "run")
        with pytest.raises(StoreError, match="run: another process is computing"), second.alone():
            pytest.fail("two at once")
        path = tmp_path / "run" / "case.toml"
        shutil.copy(path, tmp_path / "new")
        (tmp_path / "new").replace(path)
        with pytest.raises(StoreError, match="another process is computing"):
            compute(RunStore.open(tmp_path / "run"))
    with second.alone():
        pass


def asked(path: Path) -> bool:
    handle = os.open(path, os.O_RDONLY)
    try:
        files.fcntl.flock(handle, files.fcntl.LOCK_SH | files.fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    finally:
        os.close(handle)
    return True


@locking
def test_a_file_is_locked_and_those_who_ask_are_in_nobodys_way(tmp_path):
    """NFS does not pass the lock of a directory to the server, so that other machines did not see it.

    Reading the file keeps the lock of this process; one of `lockf` would be lost here.
    """
    file = tmp_path / files.LOCK
    assert not files.is_locked(tmp_path) and not files.is_locked(tmp_path / "none")
    assert not file.exists()
    file.touch()
    asking = os.open(file, os.O_RDONLY)
    files.fcntl.flock(asking, files.fcntl.LOCK_SH)  # what `is_locked` does
    assert not files.is_locked(tmp_path)
    threading.Timer(0.05, os.close, [asking]).start()
    with files.locked(tmp_path):
        assert files.is_locked(tmp_path)
        file.read_bytes()
        assert not asked(file) and asked(tmp_path)
    assert asked(file)
    directory = os.open(tmp_path, os.O_RDONLY)
    files.fcntl.flock(directory, files.fcntl.LOCK_EX)
    assert not files.is_locked(tmp_path)
    with files.locked(tmp_path):
        assert files.is_locked(tmp_path)
    os.close(directory)


DIES = """
import os, pathlib
from ertel.runs import files
with files.locked(pathlib.Path()):
    os.kill(os.getpid(), 9)
"""


@locking
def test_the_file_is_not_the_lock(tmp_path):
    """A process that was killed leaves it behind, and a copy of the run has one."""
    with files.locked(tmp_path):
        copy = Path(shutil.copytree(tmp_path, tmp_path / "copy"))
        assert files.is_locked(tmp_path) and not files.is_locked(copy)
    assert subprocess.run([sys.executable, "-c", DIES], cwd=copy).returncode == -signal.SIGKILL
    assert (copy / files.LOCK).exists() and not files.is_locked(copy)
    inode = (copy / files.LOCK).stat().st_ino
    with files.locked(copy):
        assert files.is_locked(copy)
    assert (copy / files.LOCK).stat().st_ino == inode and (copy / files.LOCK).read_bytes() == b""


@locking
@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir, lambda path: path.symlink_to("other")])
def test_something_else_in_the_place_of_the_lock(tmp_path, make):
    """A pipe must not be waited for, and a link not followed."""
    make(tmp_path / files.LOCK)
    assert not files.is_locked(tmp_path)
    said = r"\.lock: is not a regular file, so that .* delete it$"
    with pytest.raises(StoreError, match=said), files.locked(tmp_path):
        pytest.fail("not locked")
    assert not (tmp_path / "other").exists()


@locking
@pytest.mark.parametrize("kept", [False, True])
def test_a_directory_that_may_only_be_read(tmp_path, monkeypatch, kept):
    """It is asked as others are.  Whoever computes there all the same is warned, unless the lock file can be read."""
    if kept:
        (tmp_path / files.LOCK).touch()
    refusing(monkeypatch, os, "open", errno.EROFS, lambda path, flags, *_: flags & (os.O_RDWR | os.O_CREAT))
    assert not files.is_locked(tmp_path)
    with warnings.catch_warnings(record=True) as said, files.locked(tmp_path):
        assert files.is_locked(tmp_path) is kept
    assert len(said) == (0 if kept else 1)
    assert all(f"{tmp_path}: cannot be locked (read-only" in str(each.message) for each in said)


@locking
def test_a_file_system_without_locks(tmp_path, monkeypatch):
    """It is said once a directory, and the run goes on."""
    run = RunStore.create(tmp_path / "run", SHORT_FALL)
    for number in (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EBADF):
        refusing(monkeypatch, files.fcntl, "flock", number)
        place = tmp_path / str(number)
        place.mkdir()
        with warnings.catch_warnings(record=True, action="always") as said:
            for _ in range(2):
                with files.locked(place):
                    pass
        why = f"cannot be locked ({os.strerror(number).lower()})"
        assert [str(each.message).partition(";")[0] for each in said] == [f"{place}: {why}"]
    with warnings.catch_warnings(record=True, action="always") as said:
        compute(run, [stop_after(1)])
        assert compute(run)["status"] == "converged"
    (ours,) = [str(warning.message) for warning in said if "locked" in str(warning.message)]
    assert ours.startswith(f"{run.directory}: cannot be locked (")


# -- deleted ----------------------------------------------------------------------------------------------------------


def test_a_study_is_pruned_of_its_own_runs_only(tmp_path):
    """Nothing goes that it has, that ertel did not write, that a process works on, or that lies elsewhere."""
    study, elsewhere = tmp_path / "study", tmp_path / "elsewhere"
    cases = [replace(SHORT_FALL, time=replace(SHORT_FALL.time, tolerance=0.1 + 0.01 * n)) for n in range(6)]
    kept, stale, noted, locked, linked, renamed = (case.digest for case in cases)
    for case in cases:
        RunStore.create(study / "runs" / case.digest, case)
    (study / "runs" / noted / "notes.txt").touch()
    (study / "runs" / linked).rename(elsewhere)
    (study / "runs" / linked).symlink_to(elsewhere)
    (study / "runs" / renamed).rename(study / "runs" / ("0" * 16))  # a copy under a name of the user's
    for path in ("mine/case.toml", "f" * 16 + "/run.zarr/zarr.json", "a" * 16):
        (study / "runs" / path).parent.mkdir(exist_ok=True, parents=True)
        (study / "runs" / path).write_text("{}")
    before = names(study / "runs")
    with files.locked(study / "runs" / locked):
        removed, stayed = prune(study, [kept])
    assert removed == 1 and names(study / "runs") == before - {stale} and (elsewhere / "case.toml").exists()
    reasons = dict(each.split(": ", 1) for each in stayed)
    assert reasons.keys() == {f"runs/{noted}", f"runs/{locked}"} and len(stayed) == 2
    assert "(notes.txt)" in reasons[f"runs/{noted}"] and "is running" in reasons[f"runs/{locked}"]
    (study / "runs").rename(tmp_path / "runs")
    (study / "runs").symlink_to(tmp_path / "runs")
    with pytest.raises(StoreError, match="runs: is a symbolic link"):
        prune(study, [])
    assert names(tmp_path / "runs") == before - {stale}
