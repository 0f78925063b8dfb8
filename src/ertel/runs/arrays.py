"""The data of a run on disk, as `checked_zarr` writes them.

A run in time appends: what was appended after the last checkpoint is cut off again when the run is resumed.  The data
of a steady contact follow from its checkpoint and are replaced as a whole.
"""

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from zarr.storage import LocalStore

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.results import dataset
from ertel.results.dataset import provenance
from ertel.runs import checked_zarr as zarrs
from ertel.runs.courses import Course, Item, SteadyCourse
from ertel.runs.files import Damaged
from ertel.runs.stepping import Frame

WRITTEN = "store_written"  # in a checkpoint: how many rows of the arrays belong to it


class Data(Protocol):
    """The arrays of a run.

    flush_interval: seconds between flushes, unless the store is told others; a killed run loses at most this much.
    """

    flush_interval: float

    def create(self, path: Path) -> None:
        """Write the arrays of a run that has not started."""
        ...

    def take(self, item: Item) -> None:
        """Keep an item until the next flush."""
        ...

    def flush(self, path: Path) -> dict[str, Any]:
        """Write the kept items; return what the checkpoint must store about them."""
        ...

    def after_checkpoint(self, path: Path, item: Any) -> None:
        """Actions after a checkpoint has been written."""
        ...

    def restore(self, path: Path, checkpoint: Mapping[str, Any], item: Any) -> None:
        """Reset the arrays to the state of a checkpoint; an empty checkpoint and no item mean the start.

        Raises Damaged where that cannot be done; then nothing has changed.
        """
        ...


def data_of(course: Course) -> Data:
    """How the data of a course are written."""
    return ReplacedData(course) if isinstance(course, SteadyCourse) else AppendedData(course)


def advice_of(case: Case) -> str:
    """What helps where the data of a case are damaged."""
    return (ReplacedData if case.is_steady else AppendedData).advice


class AppendedData:
    """Scalars of every time step and maps at chosen times."""

    flush_interval = 5.0
    advice = "the run must be computed again from its case.toml"

    def __init__(self, course: Course):
        self._course = course
        self._records: list[Mapping[str, float]] = []
        self._frames: list[Frame] = []

    def create(self, path: Path) -> None:
        data = self._course.dataset([], [], None)
        zarrs.write(zarrs.SyncedStore(path), data.assign_attrs(status=Status.RUNNING.value))

    def take(self, item: Item) -> None:
        if item.record:  # a run that gives up ends with an item that has none
            self._records.append(item.record)
        self._frames.extend(item.frames)

    def flush(self, path: Path) -> dict[str, Any]:
        old = zarrs.has_old_coefficients(zarrs.read_root(path, self.advice))  # they stay as the run began
        scales = None if old else self._course.case.scales
        columns = dataset.columns(self._records, scales) if self._records else {}
        maps = dataset.maps(self._frames) if self._frames else {}
        zarrs.append(path, {**columns, **maps})
        new = {"time": len(self._records), "frame": len(self._frames)}
        root = zarrs.read_root(path, self.advice)
        rows = {dimension: count + new[dimension] for dimension, count in zarrs.rows_of(root).items()}
        zarrs.write_root(path, zarrs.with_rows(root, rows))
        self._records, self._frames = [], []
        return {WRITTEN: np.array(list(rows.values()))}

    def after_checkpoint(self, path: Path, item: Any) -> None:
        """Do nothing: the arrays were written before the checkpoint."""

    def restore(self, path: Path, checkpoint: Mapping[str, Any], item: Any) -> None:
        root = zarrs.read_root(path, self.advice)
        present = zarrs.rows_of(root)
        written: Sequence[int] = checkpoint[WRITTEN].tolist() if checkpoint else [0] * len(present)
        rows = dict(zip(present, written, strict=True))
        if any(rows[dimension] > count for dimension, count in present.items()):
            raise Damaged(path, "holds fewer rows than the checkpoint counts", self.advice)
        zarrs.read(path, self.advice)  # nothing is computed on damaged data
        self._records, self._frames = [], []
        known = provenance(self._course.case)
        attributes = {name: value for name, value in root["attributes"].items() if name in known}
        root = {**zarrs.with_rows(root, rows), "attributes": {**attributes, "status": Status.RUNNING.value}}
        zarrs.write_root(path, root)
        zarrs.delete_uncounted(path, root)


class ReplacedData:
    """Scalars of every grid and the maps on the finest one so far."""

    flush_interval = 5.0
    advice = "it is written again when the run is continued"

    def __init__(self, course: Course):
        self._course = course
        self._new = False  # whether the data on disk are those that this object wrote of the run before its start

    def create(self, path: Path) -> None:
        self._write(path, self._course.begin())
        self._new = True

    def _write(self, path: Path, item: Any) -> None:
        data = self._course.dataset([], [], item).assign_attrs(status=Status.RUNNING.value)
        zarrs.write(LocalStore(path), data)

    def take(self, item: Item) -> None:
        """Return nothing: the checkpoint has all solutions."""

    def flush(self, path: Path) -> dict[str, Any]:
        return {}

    def after_checkpoint(self, path: Path, item: Any) -> None:
        """Write the data again; the old data remain readable between the two renames."""
        self._new = False
        old, draft = zarrs.old_of(path), path.with_name(f"{path.name}.partial")
        shutil.rmtree(draft, ignore_errors=True)
        self._write(draft, item)
        if path.exists():
            shutil.rmtree(old, ignore_errors=True)
            path.rename(old)
        draft.rename(path)
        shutil.rmtree(old, ignore_errors=True)

    def restore(self, path: Path, checkpoint: Mapping[str, Any], item: Any) -> None:
        if item or not self._new:
            self.after_checkpoint(path, item or self._course.begin())
