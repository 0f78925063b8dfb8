"""The run directories in a folder, and the state of each: read without JAX, so that many are listed at once."""

import os
from collections import deque
from collections.abc import Iterator, Mapping
from datetime import datetime
from math import inf
from os.path import lexists
from pathlib import Path
from typing import Any, NamedTuple

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.results.numbers import Scalar, scalars
from ertel.runs.directory import CASE, DATA, PROGRESS, SUMMARY, read_case, read_progress, read_summary
from ertel.runs.files import StoreError, is_locked, reading

DEEPEST = 4  # levels of folders that are looked into


class Listed(NamedTuple):
    """A run directory.

    case: None where it cannot be read.  status: as in the summary; "running", or "unfinished" where no process is at
    it.  done: the share of the run.  written: when it was last changed.  numbers: those of its summary.
    """

    directory: Path
    case: Case | None
    status: str
    done: float
    written: datetime
    numbers: Mapping[str, Scalar]


def listed(folder: Path) -> list[Listed]:
    """The runs in a folder and in those below it, in the order of their names; a run directory is itself one.

    Raises OSError where the folder cannot be read; a folder below it that cannot be read is left out.
    """
    next(folder.iterdir(), None)
    return [_listed(directory) for directory in sorted(find_runs(folder))]


def find_runs(folder: Path, most_folders: float = inf) -> Iterator[Path]:
    """The run directories in a folder and below it, the nearest first; in a large tree not all.

    A run directory is itself one, and is not looked into.
    """
    left, looked = deque([(folder, DEEPEST)]), 0
    while left:
        path, levels = left.popleft()
        if is_run(path):
            yield path
        elif levels and looked < most_folders:
            looked += 1
            left.extend((inside, levels - 1) for inside in _folders_in(path))


def _folders_in(folder: Path) -> list[Path]:
    """The folders in a folder, by name, without hidden ones and symbolic links; none where it cannot be read."""
    try:
        with os.scandir(folder) as entries:
            return sorted(Path(e.path) for e in entries if e.name[0] != "." and e.is_dir(follow_symlinks=False))
    except OSError:
        return []


def is_run(path: Path) -> bool:
    """Whether a folder has a case and the data of a run, be they readable or not."""
    return lexists(path / CASE) and any(lexists(path / name) for name in (DATA, f"{DATA}.old"))


def status_of(directory: Path, summary: Mapping[str, Any] | None) -> str:
    """The status of a run with this summary; "running", or "unfinished" where no process is computing it."""
    if summary and Status(summary["status"]).ok:
        return str(summary["status"])
    return "running" if is_locked(directory) else summary["status"] if summary else "unfinished"


def _listed(directory: Path) -> Listed:
    files = [directory / name for name in (CASE, PROGRESS, SUMMARY)]
    changed = max((path.lstat().st_mtime for path in files if lexists(path)), default=0.0)
    written = datetime.fromtimestamp(changed)
    try:
        case, summary = read_case(directory), read_summary(directory)
        with reading(directory / SUMMARY, ""):
            numbers = scalars(summary) if summary else {}
    except (StoreError, OSError):
        return Listed(directory, None, "damaged", 0.0, written, {})
    status = status_of(directory, summary)
    progress = read_progress(directory) or {"done": 0.0}
    done = 1.0 if summary and Status(summary["status"]).ok else float(progress["done"])
    return Listed(directory, case, status, done, written, numbers)
