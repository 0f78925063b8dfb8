"""The data of a run on disk, as Zarr arrays that `xarray.open_zarr` alone opens.

A run in time appends: what was appended after the last checkpoint is cut off again when the run is resumed.  The data
of a steady contact follow from its checkpoint and are replaced as a whole.
"""

import shutil
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
import zarr

from ertel.model.status import Status
from ertel.results import dataset, variables
from ertel.results.provenance import provenance
from ertel.runs.courses import Course, Item, SteadyCourse
from ertel.runs.stepping import Frame

ROWS = 4096  # steps in a chunk of scalars; each map is a chunk of its own
NAMES = {"time": ("time", *variables.SCALARS), "frame": ("frame", "event", *variables.FIELDS)}  # what grows along what
WRITTEN = "store_written"  # in a checkpoint: how much of the arrays belongs to it


class Data(Protocol):
    """The arrays of a run.  flush_interval: seconds between flushes; a killed run loses at most this much."""

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
        """Reset the arrays to the state of a checkpoint; an empty checkpoint and no item mean the start."""
        ...


def data_of(course: Course) -> Data:
    """How the data of a course are written."""
    return ReplacedData(course) if isinstance(course, SteadyCourse) else AppendedData(course)


def attributes_of(course: Course) -> dict[str, Any]:
    """The attributes of a run that has not ended."""
    return {**provenance(course.case), "status": Status.RUNNING.value}


class AppendedData:
    """Scalars of every time step and maps at chosen times."""

    flush_interval = 5.0

    def __init__(self, course: Course):
        self._course = course
        self._written = dict.fromkeys(NAMES, 0)
        self._records: list[Mapping[str, float]] = []
        self._frames: list[Frame] = []

    def create(self, path: Path) -> None:
        _create_arrays(path, self._course)

    def take(self, item: Item) -> None:
        if item.record:  # a run that gives up ends with an item that has none
            self._records.append(item.record)
        self._frames.extend(item.frames)

    def flush(self, path: Path) -> dict[str, Any]:
        self._extend(path, "time", dataset.columns(self._records) if self._records else {})
        self._extend(path, "frame", dataset.maps(self._frames) if self._frames else {})
        commit(path)
        self._records, self._frames = [], []
        return {WRITTEN: np.array(list(self._written.values()))}

    def _extend(self, path: Path, dimension: str, arrays: Mapping[str, Any]) -> None:
        group = open_arrays(path)
        for name, values in arrays.items():
            _array(group, name).append(values)
        self._written[dimension] += len(arrays[dimension]) if arrays else 0

    def after_checkpoint(self, path: Path, item: Any) -> None:
        """Do nothing: the arrays were written before the checkpoint."""

    def restore(self, path: Path, checkpoint: Mapping[str, Any], item: Any) -> None:
        written: Sequence[int] = checkpoint[WRITTEN].tolist() if checkpoint else [0] * len(NAMES)
        self._written = dict(zip(NAMES, written, strict=True))
        self._records, self._frames = [], []
        group = open_arrays(path)
        for dimension, names in NAMES.items():
            for name in names:
                array = _array(group, name)
                array.resize((self._written[dimension], *array.shape[1:]))
        if group.attrs["status"] != Status.RUNNING.value:
            group.attrs["status"] = Status.RUNNING.value
        commit(path)


class ReplacedData:
    """Scalars of every grid and the maps on the finest one so far: written after every grid."""

    flush_interval = 0.0

    def __init__(self, course: Course):
        self._course = course

    def create(self, path: Path) -> None:
        self._write(path, self._course.begin())

    def _write(self, path: Path, item: Any) -> None:
        data = self._course.dataset([], [], item).assign_attrs(attributes_of(self._course))
        data.to_zarr(path, consolidated=False)
        commit(path)

    def take(self, item: Item) -> None:
        """Return nothing: the checkpoint has all solutions."""

    def flush(self, path: Path) -> dict[str, Any]:
        return {}

    def after_checkpoint(self, path: Path, item: Any) -> None:
        """Write the data again; the old data remain readable between the two renames."""
        old, draft = old_of(path), path.with_name(f"{path.name}.partial")
        shutil.rmtree(draft, ignore_errors=True)
        self._write(draft, item)
        if path.exists():
            shutil.rmtree(old, ignore_errors=True)
            path.rename(old)
        draft.rename(path)
        shutil.rmtree(old, ignore_errors=True)

    def restore(self, path: Path, checkpoint: Mapping[str, Any], item: Any) -> None:
        self.after_checkpoint(path, item or self._course.begin())


def attributes_in(path: Path) -> dict[str, Any]:
    """The attributes of the data at a path."""
    return dict(zarr.open_group(path if path.exists() else old_of(path), mode="r", use_consolidated=False).attrs)


def old_of(path: Path) -> Path:
    """The temporary path of the data while they are replaced."""
    return path.with_name(f"{path.name}.old")


# -- zarr -------------------------------------------------------------------------------------------------------------


def _create_arrays(path: Path, course: Course) -> None:
    group = zarr.create_group(path, attributes=attributes_of(course))
    axes = {name: np.asarray(values, dtype=float) for name, values in course.coordinates.items()}
    shape = tuple(len(values) for values in axes.values())
    for name in (*axes, *NAMES["time"], *NAMES["frame"]):
        rest = shape if name in variables.FIELDS else ()
        array = group.create_array(
            name,
            shape=axes[name].shape if name in axes else (0, *rest),
            chunks=axes[name].shape if name in axes else (1, *rest) if rest else (ROWS,),
            dtype="int8" if name == "event" else "float64",
            dimension_names=dataset.dimensions(name, course.coordinates),
            attributes=cast(dict[str, Any], variables.variable_attributes(name, course.case.scales)),
        )
        if name in axes:
            array[:] = axes[name]
    commit(path)


def open_arrays(path: Path) -> zarr.Group:
    """The arrays, opened for writing."""
    return zarr.open_group(path, mode="r+", use_consolidated=False)


def _array(group: zarr.Group, name: str) -> "zarr.Array[Any]":
    array = group[name]
    assert isinstance(array, zarr.Array)
    return array


def commit(path: Path) -> None:
    """Make the present state of the arrays visible to readers."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Consolidated metadata is currently not part")
        zarr.consolidate_metadata(path)
