"""Run directories in a folder, and what each says of its run: read without JAX, so that many are listed at once."""

from collections.abc import Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

from ertel.model.case import Case
from ertel.model.status import Status
from ertel.results.kinds import as_now
from ertel.results.scalars import Scalar, scalars
from ertel.runs import progress_file
from ertel.runs.directories import CASE, read_case
from ertel.runs.files import StoreError, is_locked, unsealed

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
    """The runs in a folder and in those below it, in the order of their names; a run directory is itself one."""
    return [_listed(directory) for directory in _run_directories(folder, DEEPEST)]


def _run_directories(folder: Path, levels: int) -> Iterator[Path]:
    if (folder / CASE).is_file() and (folder / DATA).exists():
        yield folder
        return
    if levels:
        for path in sorted(folder.iterdir()):
            if path.is_dir() and not path.is_symlink() and not path.name.startswith("."):
                yield from _run_directories(path, levels - 1)


def _listed(directory: Path) -> Listed:
    written, summary = _written(directory), _summary(directory)
    try:
        case = read_case(directory)
    except StoreError:
        return Listed(directory, None, "damaged", 0.0, written, {})
    numbers = scalars(summary, case.scales) if summary else {}
    if summary and Status(summary["status"]).ok:
        return Listed(directory, case, summary["status"], 1.0, written, numbers)
    done = float((progress_file.read(directory) or {}).get("done", 0.0))
    status = "running" if is_locked(directory) else summary["status"] if summary else "unfinished"
    return Listed(directory, case, status, done, written, numbers)


def _written(directory: Path) -> datetime:
    paths = (directory / name for name in (CASE, progress_file.PROGRESS, SUMMARY))
    return datetime.fromtimestamp(max(path.stat().st_mtime for path in paths if path.exists()))


def _summary(directory: Path) -> dict[str, Any] | None:
    try:
        return as_now(unsealed((directory / SUMMARY).read_bytes()))
    except (OSError, ValueError):
        return None
