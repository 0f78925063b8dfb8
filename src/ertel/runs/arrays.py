"""The arrays of a run on disk, as `checked_zarr` writes them: appended in time, replaced grid by grid.

`create` writes those of a run that has not started.  `flush` writes what is new before a checkpoint, and returns what
the checkpoint must store about it; `after_checkpoint` does what remains.  `restore` resets the arrays to a checkpoint;
an empty checkpoint and no result mean the start.  It raises Damaged where that cannot be done; then nothing has
changed.

flush_interval: seconds between flushes, unless the store is told others; a killed run loses at most this much.
advice: how to go on where the data are damaged.
"""

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from zarr.storage import LocalStore

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.results import dataset
from ertel.results.dataset import provenance
from ertel.runs import checked_zarr as zarrs
from ertel.runs.courses import Run
from ertel.runs.files import Damaged
from ertel.runs.stepping import Frame

WRITTEN = "store_written"  # in a checkpoint: how many rows of the arrays belong to it


class AppendedData:
    """Scalars of every time step and maps at chosen times; what no checkpoint counts is cut off by `restore`."""

    flush_interval = 5.0
    advice = "the run must be computed again from its case.toml"

    def __init__(self, run: Run):
        self._run = run

    def create(self, path: Path) -> None:
        data = self._run.dataset([], [], None)
        zarrs.write(zarrs.SyncedStore(path), data.assign_attrs(status=Status.RUNNING.value))

    def flush(self, path: Path, records: Sequence[Mapping[str, float]], frames: Sequence[Frame]) -> dict[str, Any]:
        root = zarrs.read_root(path, self.advice)
        old = zarrs.has_old_coefficients(root)  # they stay as the run began
        columns = dataset.columns(records, None if old else self._run.case.scales) if records else {}
        maps = dataset.maps(frames) if frames else {}
        zarrs.append(path, {**columns, **maps})
        new = {"time": len(records), "frame": len(frames)}
        rows = {dimension: count + new[dimension] for dimension, count in zarrs.rows_of(root).items()}
        zarrs.write_root(path, zarrs.with_rows(root, rows))
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
        known = provenance(self._run.case)
        attributes = {name: value for name, value in root["attributes"].items() if name in known}
        root = {**zarrs.with_rows(root, rows), "attributes": {**attributes, "status": Status.RUNNING.value}}
        zarrs.write_root(path, root)
        zarrs.delete_uncounted(path, root)


class ReplacedData:
    """Scalars of every grid and the maps on the finest one so far: they follow from the checkpoint."""

    flush_interval = 5.0
    advice = "it is written again when the run is continued"

    def __init__(self, run: Run):
        self._run = run

    def create(self, path: Path) -> None:
        self._write(path, self._run.begin())

    def _write(self, path: Path, result: Any) -> None:
        data = self._run.dataset([], [], result).assign_attrs(status=Status.RUNNING.value)
        zarrs.write(LocalStore(path), data)

    def flush(self, path: Path, records: Sequence[Mapping[str, float]], frames: Sequence[Frame]) -> dict[str, Any]:
        return {}

    def after_checkpoint(self, path: Path, result: Any) -> None:
        """Write the data again; the old data remain readable between the two renames."""
        old, draft = zarrs.old_of(path), path.with_name(f"{path.name}.partial")
        shutil.rmtree(draft, ignore_errors=True)
        self._write(draft, result)
        if path.exists():
            shutil.rmtree(old, ignore_errors=True)
            path.rename(old)
        draft.rename(path)
        shutil.rmtree(old, ignore_errors=True)

    def restore(self, path: Path, checkpoint: Mapping[str, Any], result: Any) -> None:
        self.after_checkpoint(path, result or self._run.begin())


def data_class(case: Case) -> type[AppendedData] | type[ReplacedData]:
    """The class that writes the arrays of a case."""
    return ReplacedData if case.is_steady else AppendedData
