"""Locks: one process at a time, on systems that cannot do everything."""

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
from cases import stop_after

from ertel.inputs.case_files import parse_case
from ertel.runs import files
from ertel.runs.files import StoreError
from ertel.runs.store import RunStore, compute

pytestmark = [
    pytest.mark.filterwarnings("ignore:the film is not resolved", "ignore:the oil outside the domain"),
    pytest.mark.skipif(files.fcntl is None, reason="no locks on this system"),
]
DATA = {"contact": {"M": 200, "L": 10}, "solver": {"method": "radial", "nodes": 33}}
CASE = parse_case({**DATA, "time": {"tolerance": 0.01, "until": 0.15}})


def test_the_lock_keeps_others_out_and_is_given_back(tmp_path):
    """Also where case.toml is replaced, as an editor does when it saves."""
    run = RunStore.create(tmp_path / "run", CASE)
    with run.alone(), run.alone():
        second = RunStore.open(tmp_path / "run")
        with pytest.raises(StoreError, match="run: another process is computing this run"), second.alone():
            pytest.fail("two at once")
        path = tmp_path / "run" / "case.toml"
        (tmp_path / "new").write_text(path.read_text())
        (tmp_path / "new").replace(path)
        with pytest.raises(StoreError, match="another process is computing this run"):
            compute(RunStore.open(tmp_path / "run"))
    with second.alone():
        pass


def test_those_who_ask_for_the_lock_are_in_nobodys_way(tmp_path):
    """Neither of others who ask, nor of a run that begins just then."""
    assert not files.is_locked(tmp_path) and not files.is_locked(tmp_path / "none")
    assert not (tmp_path / files.LOCK).exists()
    (tmp_path / files.LOCK).touch()
    asking = os.open(tmp_path / files.LOCK, os.O_RDONLY)
    files.fcntl.flock(asking, files.fcntl.LOCK_SH)  # what `is_locked` does
    assert not files.is_locked(tmp_path)
    threading.Timer(0.05, os.close, [asking]).start()
    with files.locked(tmp_path):
        assert files.is_locked(tmp_path)


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


def test_a_file_is_locked(tmp_path):
    """NFS does not pass the lock of a directory to the server, so that other machines did not see it.

    Asking keeps the lock of this process; one of `lockf` would be lost here.
    """
    run = RunStore.create(tmp_path / "run", CASE)
    file = tmp_path / "run" / files.LOCK
    assert not file.exists()
    with run.alone():
        assert files.is_locked(tmp_path / "run")
        file.read_bytes()
        assert (locking(file), locking(tmp_path / "run")) == ("refused", "taken")
    assert locking(file) == "taken"


def test_a_locked_directory_is_in_nobodys_way(tmp_path):
    directory = os.open(tmp_path, os.O_RDONLY)
    files.fcntl.flock(directory, files.fcntl.LOCK_EX)
    assert not files.is_locked(tmp_path)
    with files.locked(tmp_path):
        assert files.is_locked(tmp_path)
    os.close(directory)


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


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir, lambda path: path.symlink_to("other")])
def test_something_else_in_the_place_of_the_lock(tmp_path, make):
    """A pipe must not be waited for, and a link not followed."""
    run = RunStore.create(tmp_path / "run", CASE)
    make(tmp_path / "run" / files.LOCK)
    assert not files.is_locked(tmp_path / "run")
    with pytest.raises(StoreError, match=r"run/.lock: is not a regular file, so that .* delete it$"), run.alone():
        pytest.fail("not locked")
    assert not (tmp_path / "run" / "other").exists()


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
    assert len(said) == (0 if kept else 1)
    assert all(f"{tmp_path}: cannot be locked (read-only" in str(each.message) for each in said)


def test_a_lock_file_that_cannot_be_made(tmp_path, monkeypatch):
    def full(*arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "open", full)
    with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)), files.locked(tmp_path):
        pytest.fail("not locked")


def test_a_file_system_without_locks(tmp_path, monkeypatch):
    """It is said once, and the run goes on."""

    def flock(handle, operation):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(files.fcntl, "flock", flock)
    for number in (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EBADF):
        run = RunStore.create(tmp_path / str(number), CASE)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            compute(run, [stop_after(1)])
            compute(run, [stop_after(1)])
        (ours,) = [str(warning.message) for warning in said if "locked" in str(warning.message)]
        assert ours.startswith(f"{run.directory}: cannot be locked ({os.strerror(number).lower()})")
    assert compute(run)["status"] == "converged"
