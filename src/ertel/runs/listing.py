"""Run directories in a folder, and what each says of its run: read without JAX, so that many are listed at once."""

import os
from collections.abc import Iterator, Mapping
from datetime import datetime
from os.path import lexists
from pathlib import Path
from typing import Any, NamedTuple

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.results.numbers import Scalar, as_now, scalars
from ertel.results.report import lines
from ertel.runs import progress_file
from ertel.runs.directories import CASE, read_case
from ertel.runs.files import StoreError, content_of, is_locked, reading, unsealed

DATA, SUMMARY = "run.zarr", "summary.json"  # see `store`, which imports JAX
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
    return [_listed(directory) for directory in _run_directories(folder, DEEPEST)]


def _run_directories(folder: Path, levels: int) -> Iterator[Path]:
    if is_run(folder):
        yield folder
    elif levels:
        for path in folders_in(folder):
            yield from _run_directories(path, levels - 1)


def folders_in(folder: Path) -> list[Path]:
    """The folders in a folder, by name, without hidden ones and symbolic links; none where it cannot be read."""
    try:
        with os.scandir(folder) as entries:
            return sorted(Path(e.path) for e in entries if e.name[0] != "." and e.is_dir(follow_symlinks=False))
    except OSError:
        return []


def is_run(path: Path) -> bool:
    """Whether a folder has a case and the data of a run, be they readable or not."""
    return lexists(path / CASE) and any(lexists(path / name) for name in (DATA, f"{DATA}.old"))


def summary_in(directory: Path) -> dict[str, Any] | None:
    """The summary of a run; None where there is none yet.

    Raises OSError where it cannot be read, Damaged where its checksum or a value that readers count on is wrong.
    """
    path = directory / SUMMARY
    if not lexists(path):
        return None
    with reading(path, "it is written again when the run is continued"):
        found = as_now(unsealed(content_of(path)))
        Status(found["status"])
        if not all(isinstance(text, str) for text in (*lines(found), *found["warnings"])):
            raise ValueError("a warning is not a text")
    return found


def _listed(directory: Path) -> Listed:
    written = _written(directory)
    try:
        case, summary = read_case(directory), summary_in(directory)
        with reading(directory / SUMMARY, ""):
            numbers = scalars(summary) if summary else {}
    except (StoreError, OSError):
        return Listed(directory, None, "damaged", 0.0, written, {})
    if summary and Status(summary["status"]).ok:
        return Listed(directory, case, summary["status"], 1.0, written, numbers)
    done = float((progress_file.read(directory) or {}).get("done", 0.0))
    status = "running" if is_locked(directory) else summary["status"] if summary else "unfinished"
    return Listed(directory, case, status, done, written, numbers)


def _written(directory: Path) -> datetime:
    paths = [directory / name for name in (CASE, progress_file.PROGRESS, SUMMARY)]
    return datetime.fromtimestamp(max((path.lstat().st_mtime for path in paths if lexists(path)), default=0.0))
