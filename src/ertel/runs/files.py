"""Crash-safe files: atomic replacement, fsync, checksum, lock.

A file that is replaced holds the old content or the new one at any moment, never a part of it.  A checksum tells a
flipped bit, and a file that was cut short, from content.
"""

import errno
import json
import os
import re
import shutil
import time
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import sha256
from itertools import chain
from pathlib import Path
from stat import S_ISREG
from typing import Any
from uuid import uuid4

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]

CHECKSUM = "checksum"  # the key of it in a JSON file
LENGTH = 2 * sha256().digest_size  # of a checksum, in hexadecimal digits
DRAFT = ".partial"  # how the name of a file ends that is being written
NUMBERED = re.compile(rf"\.[0-9a-f]{{8}}\{DRAFT}$")  # that of one which is replaced
YOUNG = 60.0  # seconds: a younger draft may be that of a process that writes
LOCK = ".lock"  # the file in a directory that is locked
ASKING = 0.2  # s: `is_locked` holds the lock for much less
LARGEST = 64 * 10**6  # bytes: a summary has some kB, the metadata of all arrays some 100 kB
UNABLE = (errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS)  # of a file system that cannot sync
FORBIDDEN = (errno.EACCES, errno.EPERM, errno.EROFS)  # to make a file, or to write to it
NO_FILE = (errno.EINVAL, errno.EISDIR, errno.ELOOP, errno.EMLINK, errno.ENXIO)  # a pipe, directory, link or socket


class StoreError(ValueError):
    """A run directory cannot be made or is not valid; the message names it and says what is wrong."""


class Damaged(StoreError):
    """A file of a run is damaged.  path: the file.  The message names it and says how to go on."""

    def __init__(self, path: Path, what: str, advice: str):
        super().__init__(f"{path}: is damaged ({what}); {advice}")
        self.path = path


class NotDrawn(UserWarning):
    """A picture cannot be drawn; what it shows is written."""


# -- replaced ---------------------------------------------------------------------------------------------------------


def replace(path: Path, content: bytes, durable: bool = True) -> None:
    """Replace a file atomically; a link in its place is replaced and never followed.

    The draft has a name of its own, so that two may write at once; `locked` deletes that of a killed process.
    durable: make its directory if it is not there, and return when the file is on the disk.
    """
    if durable:
        path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f"{path.name}.{uuid4().hex[:8]}{DRAFT}")
    try:
        with draft.open("xb") as file:
            file.write(content)
            file.flush()
            if durable:
                _sync(file.fileno())
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)  # a full disk needs its space
    if durable:
        sync_directory(path.parent)


def delete(path: Path) -> None:
    """Delete a file, a link (not what it leads to) or a directory with all that it holds, where it is there."""
    if path.is_symlink() or path.is_file():
        path.unlink()
    else:
        shutil.rmtree(path, ignore_errors=True)


def delete_drafts(directory: Path, age: float) -> None:
    """Delete the drafts of `replace` that are older than so many seconds: those of killed processes."""
    for draft in directory.glob(f"*{DRAFT}"):
        with suppress(FileNotFoundError):
            if NUMBERED.search(draft.name) and time.time() - draft.lstat().st_mtime > age:
                delete(draft)


def within(directory: Path) -> Iterator[Path]:
    """A directory and all that it holds, at any depth; links are not followed."""
    return chain([directory], (Path(folder) / name for folder, *names in os.walk(directory) for name in chain(*names)))


def require_no_links(paths: Iterable[Path]) -> None:
    """Raise StoreError where a path is a symbolic link: what is written there would go elsewhere."""
    for path in paths:
        if path.is_symlink():
            raise StoreError(f"{path}: is a symbolic link, and ertel would write where it leads; delete it")


def sync_directory(directory: Path) -> None:
    """Return when the names in a directory are on the disk, as far as the system can say so."""
    if os.name == "posix":
        handle = os.open(directory, os.O_RDONLY)
        try:
            _sync(handle)
        finally:
            os.close(handle)


def _sync(handle: int) -> None:
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in UNABLE:
            raise


# -- read -------------------------------------------------------------------------------------------------------------


def content_of(path: Path, most: int = LARGEST) -> bytes:
    """The content of a regular file of at most so many bytes, opened once: reading a pipe may never end.

    Raises OSError where it is something else, too large, or cannot be read.
    """
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0))) as file:
        status = os.fstat(file.fileno())
        if not S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "not a regular file", str(path))
        if status.st_size > most:
            raise OSError(errno.EFBIG, os.strerror(errno.EFBIG), str(path))
        return file.read(status.st_size)


# -- checksums --------------------------------------------------------------------------------------------------------


def with_checksum(content: bytes) -> bytes:
    """Content with its checksum at the end; `numpy.load` still reads an npz file of it."""
    return content + sha256(content).hexdigest().encode()


def without_checksum(content: bytes) -> bytes:
    """The content without its checksum.  Raises ValueError if the checksum differs."""
    body = content[:-LENGTH]
    if with_checksum(body) != content:
        raise ValueError("its checksum does not agree")
    return body


def sealed(content: Mapping[str, Any], section: str = "") -> bytes:
    """Plain data as JSON, with their checksum among them or in one of their sections."""
    place = content[section] if section else content
    whole = {**place, CHECKSUM: _checksum(content)}
    complete = {**content, section: whole} if section else whole
    return (json.dumps(complete, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def unsealed(text: bytes, section: str = "") -> dict[str, Any]:
    """The plain data in JSON without their checksum.  Raises ValueError if it differs or the text is not JSON."""
    try:
        content: dict[str, Any] = json.loads(text)
    except RecursionError as error:
        raise ValueError("its lists are nested hundreds of times") from error
    if not isinstance(content, dict) or not isinstance(content.get(section, {}), dict):
        raise ValueError("it is not a table of values")
    stored = (content[section] if section else content).pop(CHECKSUM, None)
    if stored is None:
        raise ValueError("it has no checksum; older versions wrote none")
    if stored != _checksum(content):
        raise ValueError("its checksum does not agree")
    return content


def _checksum(content: Mapping[str, Any]) -> str:
    return sha256(json.dumps(content, ensure_ascii=False, allow_nan=False).encode()).hexdigest()


@contextmanager
def reading(path: Path, advice: str) -> Iterator[None]:
    """Raise Damaged for whatever goes wrong with the content of a file in this block; errors of the system pass."""
    try:
        yield
    except (OSError, StoreError, MemoryError):
        raise
    except Exception as error:  # of json, numpy, zipfile, zarr, its codecs
        line = (str(error).strip() or type(error).__name__).splitlines()[0]
        raise Damaged(path, line.split(". ")[0][:200].rstrip("."), advice) from error


# -- locks ------------------------------------------------------------------------------------------------------------


@contextmanager
def locked(directory: Path) -> Iterator[None]:
    """Keep other processes, on other machines too, out of a block on this directory.

    Raises StoreError where one is in it, or where something else than a file has the name of the lock file, OSError
    where the file cannot be made.  On a file system without locks, and in a directory that may only be read, the block
    runs after a warning.

    What is locked is an empty file in the directory.  It stays there, and says nothing by being there: whoever deleted
    it could delete one that another process has just locked.  A file, because Linux passes `flock` on a file to an NFS
    server, on a directory not.  `flock`, because a lock of `fcntl` or `lockf` is lost when this process closes the
    file anywhere, as `is_locked` does.
    """
    handle = None if fcntl is None else _lock_file(directory)
    if handle is None:
        yield
        return
    try:
        _hold(handle, directory)
        delete_drafts(directory, YOUNG)
        yield
    finally:
        os.close(handle)


def is_locked(directory: Path) -> bool:
    """Whether a process is in a `locked` block on this directory; False where that cannot be seen.

    For the moment of asking the lock is held itself, together with others that ask.  A process that begins waits for
    them.  Nothing is written.
    """
    if fcntl is None:
        return False
    try:
        handle = _opened(directory / LOCK, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError as error:
        return isinstance(error, BlockingIOError)
    finally:
        os.close(handle)
    return False


def _lock_file(directory: Path) -> int | None:
    """The open lock file of a directory, made if it is not there; None, after a warning, where that is forbidden."""
    path = directory / LOCK
    try:
        return _opened(path, os.O_RDWR | os.O_CREAT)  # NFS locks for one process only what is open for writing
    except OSError as error:
        if error.errno in NO_FILE:
            raise StoreError(f"{path}: is not a regular file, so that the run cannot be locked; delete it") from error
        if error.errno not in FORBIDDEN:
            raise
        refused = error
    try:
        return _opened(path, os.O_RDONLY)  # of another user: enough on a local disk
    except OSError:
        _warn_unlocked(directory, refused.strerror)
        return None


def _opened(path: Path, access: int) -> int:
    """A regular file, opened without following a link and without waiting for the other end of a pipe."""
    handle = os.open(path, access | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
    if S_ISREG(os.fstat(handle).st_mode):
        return handle
    os.close(handle)
    raise OSError(errno.EINVAL, "not a regular file", str(path))


def _hold(handle: int, directory: Path) -> None:
    """Take the lock; warn where there are none.  Raises StoreError where it is kept longer than `is_locked` does."""
    deadline = time.monotonic() + ASKING
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError as error:
            if time.monotonic() > deadline:
                raise StoreError(f"{directory}: another process is computing this run") from error
        except OSError as error:
            _warn_unlocked(directory, error.strerror)
            return
        time.sleep(ASKING / 10)


@cache
def _warn_unlocked(directory: Path, reason: str | None) -> None:
    unlocked = f"{directory}: cannot be locked ({(reason or 'for no known reason').lower()})"
    alone = "make sure that no other process is computing this run"
    warnings.warn(f"{unlocked}; {alone}", RuntimeWarning, stacklevel=2)
