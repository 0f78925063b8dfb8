"""The data of a run on disk, as `checked_zarr` writes them.

A run in time appends: what was appended after the last checkpoint is cut off again when the run is resumed.  The data
of a steady contact follow from its checkpoint and are replaced as a whole.
"""

import shutil
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from zarr.storage import LocalStore

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.results import dataset
from ertel.results.dataset import provenance
from ertel.runs import checked_zarr as zarrs
from ertel.runs.courses import Run, StepResult
from ertel.runs.files import Damaged
from ertel.runs.stepping import Frame

WRITTEN = "store_written"  # in a checkpoint: how many rows of the arrays belong to it


class RunData(ABC):
    """The arrays of a run.

    flush_interval: seconds between flushes, unless the store is told others; a killed run loses at most this much.
    advice: what helps where the data are damaged.
    """

    flush_interval = 5.0
    advice: ClassVar[str]

    def __init__(self, run: Run):
        self._run = run

    @abstractmethod
    def create(self, path: Path) -> None:
        """Write the arrays of a run that has not started."""

    @abstractmethod
    def take(self, result: StepResult) -> None:
        """Keep a result until the next flush."""

    @abstractmethod
    def flush(self, path: Path) -> dict[str, Any]:
        """Write the kept results; return what the checkpoint must store about them."""

    @abstractmethod
    def after_checkpoint(self, path: Path, result: Any) -> None:
        """Do what remains when a checkpoint has been written."""

    @abstractmethod
    def restore(self, path: Path, checkpoint: Mapping[str, Any], result: Any) -> None:
        """Reset the arrays to the state of a checkpoint; an empty checkpoint and no result mean the start.

        Raises Damaged where that cannot be done; then nothing has changed.
        """


class AppendedData(RunData):
    """Scalars of every time step and maps at chosen times."""

    advice = "the run must be computed again from its case.toml"

    def __init__(self, run: Run):
        super().__init__(run)
        self._records: list[Mapping[str, float]] = []
        self._frames: list[Frame] = []

    def create(self, path: Path) -> None:
        data = self._run.dataset([], [], None)
        zarrs.write(zarrs.SyncedStore(path), data.assign_attrs(status=Status.RUNNING.value))

    def take(self, result: StepResult) -> None:
        if result.record:  # a run that gives up ends with a result that has none
            self._records.append(result.record)
        self._frames.extend(result.frames)

    def flush(self, path: Path) -> dict[str, Any]:
        root = zarrs.read_root(path, self.advice)
        old = zarrs.has_old_coefficients(root)  # they stay as the run began
        scales = None if old else self._run.case.scales
        columns = dataset.columns(self._records, scales) if self._records else {}
        maps = dataset.maps(self._frames) if self._frames else {}
        zarrs.append(path, {**columns, **maps})
        new = {"time": len(self._records), "frame": len(self._frames)}
        rows = {dimension: count + new[dimension] for dimension, count in zarrs.rows_of(root).items()}
        zarrs.write_root(path, zarrs.with_rows(root, rows))
        self._records, self._frames = [], []
        return {WRITTEN: np.array(list(rows.values()))}

    def after_checkpoint(self, path: Path, result: Any) -> None:
        """Do nothing: the arrays were written before the checkpoint."""

    def restore(self, path: Path, checkpoint: Mapping[str, Any], result: Any) -> None:
        root = zarrs.read_root(path, self.advice)
        present = zarrs.rows_of(root)
        written: Sequence[int] = checkpoint[WRITTEN].tolist() if checkpoint else [0] * len(present)
        rows = dict(zip(present, written, strict=True))
        if any(rows[dimension] > count for dimension, count in present.items()):
            raise Damaged(path, "holds fewer rows than the checkpoint counts", self.advice)
        zarrs.read(path, self.advice)  # nothing is computed on damaged data
        self._records, self._frames = [], []
        known = provenance(self._run.case)
        attributes = {name: value for name, value in root["attributes"].items() if name in known}
        root = {**zarrs.with_rows(root, rows), "attributes": {**attributes, "status": Status.RUNNING.value}}
        zarrs.write_root(path, root)
        zarrs.delete_uncounted(path, root)


class ReplacedData(RunData):
    """Scalars of every grid and the maps on the finest one so far; the checkpoint has all solutions."""

    advice = "it is written again when the run is continued"

    def __init__(self, run: Run):
        super().__init__(run)
        self._new = False  # whether the data on disk are those that this object wrote of the run before its start

    def create(self, path: Path) -> None:
        self._write(path, self._run.begin())
        self._new = True

    def _write(self, path: Path, result: Any) -> None:
        data = self._run.dataset([], [], result).assign_attrs(status=Status.RUNNING.value)
        zarrs.write(LocalStore(path), data)

    def take(self, result: StepResult) -> None:
        """Do nothing: the checkpoint has all solutions."""

    def flush(self, path: Path) -> dict[str, Any]:
        return {}

    def after_checkpoint(self, path: Path, result: Any) -> None:
        """Write the data again; the old data remain readable between the two renames."""
        self._new = False
        old, draft = zarrs.old_of(path), path.with_name(f"{path.name}.partial")
        shutil.rmtree(draft, ignore_errors=True)
        self._write(draft, result)
        if path.exists():
            shutil.rmtree(old, ignore_errors=True)
            path.rename(old)
        draft.rename(path)
        shutil.rmtree(old, ignore_errors=True)

    def restore(self, path: Path, checkpoint: Mapping[str, Any], result: Any) -> None:
        if result or not self._new:
            self.after_checkpoint(path, result or self._run.begin())


def data_class(case: Case) -> type[RunData]:
    """How the data of a case are written."""
    return ReplacedData if case.is_steady else AppendedData
