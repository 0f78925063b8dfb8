"""Run directories: made in one stroke under a name of their own, and held to their case."""

import errno
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any
from uuid import uuid4

from ertel.case.case import Case
from ertel.case.records import show
from ertel.inputs.case_files import ConfigError, parse_case, read_toml, to_toml
from ertel.runs.files import StoreError, replace, sync_directory

CASE = "case.toml"
OCCUPIED = (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR, errno.EISDIR)  # why a directory cannot be moved to a name


class Taken(StoreError):
    """The directory for a new run exists already."""


# -- made -------------------------------------------------------------------------------------------------------------


@contextmanager
def draft(directory: Path, case: Case, fill: Callable[[Path], object]) -> Iterator[Path]:
    """A new directory beside another, with the files of a case and what `fill` writes.

    It is deleted at the end if it is still there.  Raises StoreError where it cannot be written, ValueError where the
    case cannot.
    """
    text = to_toml(case)
    path = directory.parent / f".{directory.name}-{uuid4().hex[:8]}"
    try:
        replace(path / CASE, text.encode())
        for name, heights in case.maps.items():
            replace(path / name, heights.to_bytes())
        fill(path)
        yield path
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise StoreError(f"{directory}: cannot write there, {reason}") from error
    finally:
        shutil.rmtree(path, ignore_errors=True)


def move(path: Path, directory: Path) -> None:
    """Give a directory its name.  Raises Taken unless that is free or the name of an empty directory."""
    if directory.exists() and not (directory.is_dir() and not any(directory.iterdir())):
        raise Taken(f"{directory}: exists already")
    try:
        path.rename(directory)
    except OSError as error:
        if error.errno in OCCUPIED:  # another process has just taken the name
            raise Taken(f"{directory}: exists already") from error
        raise
    sync_directory(directory.parent)


def move_to_unused(path: Path, directory: Path) -> Path:
    """Give a directory a name, or NAME-2, ... : the first that does not exist.  The name that it got."""
    for number in count(1):
        candidate = directory if number == 1 else directory.with_name(f"{directory.name}-{number}")
        if not candidate.exists():
            try:
                move(path, candidate)
                return candidate
            except Taken:
                continue
    raise AssertionError("there is always a next number")


# -- held to their case -----------------------------------------------------------------------------------------------


def read_case(directory: Path) -> Case:
    """The case of a run.  Raises StoreError where its file cannot be read."""
    try:
        return parse_case(read_toml(directory / CASE), directory)
    except ConfigError as error:
        raise StoreError(f"{directory / CASE}: cannot be read as a case ({error}); put the run's own back") from error


def require_same(directory: Path, digest: str, data: Mapping[str, Any], case: Case) -> None:
    """Raise StoreError unless the case with this digest and data is the case of the directory's file."""
    if digest != case.digest:
        said = changes(data, case.to_data())
        raise StoreError(f"{directory}: {CASE} was changed ({said}); put it back, or run it as a new case")


def changes(before: Any, now: Any, place: str = "") -> str:
    """What differs between two cases as plain data, names and references apart."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        free = ("name", "reference")
        keys = [key for key in {**before, **now} if before.get(key) != now.get(key) and key not in free]
        return ", ".join(changes(before.get(key), now.get(key), f"{place}.{key}".removeprefix(".")) for key in keys)
    return f"{place} {show(before)} → {show(now)}"
