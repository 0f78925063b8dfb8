"""The directory of a run, safe against being cut off at any moment.

======================  =========================================================================================
case.toml               the resolved case: `ertel run` of it is the same run again
run.zarr                scalars of every step, maps at chosen times, provenance; `xarray.open_zarr` alone opens it
checkpoint.npz          the state to go on from, and how much of run.zarr belongs to it
summary.json            the outcome
======================  =========================================================================================

A flush appends to run.zarr, then renews its consolidated metadata, which is the moment when readers see the new rows,
then replaces the checkpoint, which is the moment from which a resumed run goes on.  Each file is replaced in one stroke,
and what was appended after the last checkpoint is cut off again when the run is resumed.
"""

import json
import os
import shutil
import time
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numpy as np
import xarray as xr
import zarr

from ertel import dataset
from ertel.case import Case
from ertel.config import load_case, to_toml

if TYPE_CHECKING:
    from ertel.simulate import State, Step

CASE, DATA, CHECKPOINT, SUMMARY = "case.toml", "run.zarr", "checkpoint.npz", "summary.json"
FLUSH_INTERVAL = 5.0  # s: what a killed run loses at most
ROWS = 4096  # steps in a chunk of scalars


class StoreError(ValueError):
    """A run directory cannot be made, or is none: the message names it and says what to do."""


class RunStore:
    """The directory of one run.  Make one with `create`, or take up one with `open`."""

    def __init__(self, directory: Path, case: Case):
        self.directory = directory
        self.case = case
        self.seconds_before = 0.0  # of computing, before this process took over
        self._started = self._flushed = time.monotonic()
        self._rows = {"time": 0, "frame": 0}
        self._steps: list[Step] = []

    @classmethod
    def create(cls, directory: Path, case: Case, coordinates: Mapping[str, Any]) -> "RunStore":
        """A new run in a directory that does not exist or is empty; nothing is left behind where that fails.

        coordinates are the space axes of the maps, in order.  Raises StoreError.
        """
        if not case.source:
            raise StoreError("case: has no source to store; make it with ertel.load_case or ertel.parse_case")
        draft = directory.parent / f".{directory.name}-{uuid4().hex[:8]}"
        try:
            _require_free(directory)
            draft.mkdir(parents=True)
            (draft / CASE).write_text(to_toml(case.source), encoding="utf-8")
            _create_arrays(draft / DATA, case, coordinates)
            draft.rename(directory)
        except OSError as error:
            raise StoreError(f"{directory}: cannot write there, {(error.strerror or str(error)).lower()}") from error
        finally:
            shutil.rmtree(draft, ignore_errors=True)
        return cls(directory, case)

    @classmethod
    def open(cls, directory: Path) -> "RunStore":
        """The run in a directory.  Raises StoreError where there is none."""
        for name in (CASE, DATA):
            if not (directory / name).exists():
                raise StoreError(f"{directory}: is no run of ertel, {name} is missing")
        return cls(directory, load_case(directory / CASE))

    # -- writing ------------------------------------------------------------------------------------------------------

    @property
    def seconds(self) -> float:
        """Wall time of the run so far, over all processes that worked on it."""
        return self.seconds_before + time.monotonic() - self._started

    def append(self, step: "Step") -> None:
        """Take one more step; now and then the steps taken so far are written."""
        self._steps.append(step)
        if time.monotonic() - self._flushed > FLUSH_INTERVAL:
            self.flush()

    def flush(self) -> None:
        """Write the steps taken since the last flush, then the checkpoint."""
        if self._steps:
            rows = {"time": dataset.columns([step.record for step in self._steps])}
            frames = [frame for step in self._steps for frame in step.frames]
            if frames:
                rows["frame"] = dataset.maps(frames)
            group = _open_arrays(self.directory / DATA)
            for dimension, arrays in rows.items():
                for name, values in arrays.items():
                    _array(group, name).append(values)
                self._rows[dimension] += len(arrays[dimension])
            _commit(self.directory / DATA)
            self._write_checkpoint(self._steps[-1].state)
        self._steps = []
        self._flushed = time.monotonic()

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Write what is left, and the outcome of the run."""
        self.flush()
        group = _open_arrays(self.directory / DATA)
        group.attrs.update({key: value for key, value in summary.items() if isinstance(value, str | int | float)})
        _commit(self.directory / DATA)
        text = json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        _replace(self.directory / SUMMARY, text.encode())

    def _write_checkpoint(self, state: "State") -> None:
        path = self.directory / CHECKPOINT
        draft = path.with_suffix(".partial")
        with draft.open("wb") as file:
            np.savez(file, **state.to_arrays(), **{f"store_{k}": n for k, n in self._rows.items()}, seconds=self.seconds)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)

    # -- reading ------------------------------------------------------------------------------------------------------

    def resume(self) -> "State | None":
        """The state to go on from, None for the very start; cuts off what was written after it."""
        from ertel.simulate import State

        state = None
        if (self.directory / CHECKPOINT).exists():
            with np.load(self.directory / CHECKPOINT) as file:
                arrays = dict(file)
            self._rows = {dimension: int(arrays.pop(f"store_{dimension}")) for dimension in self._rows}
            self.seconds_before = float(arrays.pop("seconds"))
            state = State.from_arrays(arrays)
        group = _open_arrays(self.directory / DATA)
        for _, array in group.arrays():
            first, *rest = array.metadata.dimension_names
            if first in self._rows and (first not in group or array.shape[0] != self._rows[first]):
                array.resize((self._rows[first], *array.shape[1:]))
        _commit(self.directory / DATA)
        return state

    def dataset(self) -> xr.Dataset:
        """The run as far as it is written."""
        return xr.open_zarr(self.directory / DATA)

    def summary(self) -> dict[str, Any] | None:
        """The outcome, None while the run has not ended."""
        path = self.directory / SUMMARY
        if not path.exists():
            return None
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return content


def unused_directory(case: Case, parent: Path = Path("runs")) -> Path:
    """runs/NAME, or runs/NAME-2, ... : the first that does not exist."""
    name = case.name or case.kind
    candidates = (parent / (name if number == 1 else f"{name}-{number}") for number in range(1, 100_000))
    return next(path for path in candidates if not path.exists())


def _require_free(directory: Path) -> None:
    if directory.exists() and not (directory.is_dir() and not any(directory.iterdir())):
        raise StoreError(f"{directory}: exists already; choose another --out, or take the run up with ertel resume")


# -- zarr -------------------------------------------------------------------------------------------------------------


def _create_arrays(path: Path, case: Case, coordinates: Mapping[str, Any]) -> None:
    group = zarr.create_group(path, attributes={**dataset.provenance(case), "status": "running"})
    axes = {name: np.asarray(values, dtype=float) for name, values in coordinates.items()}
    shape = tuple(len(values) for values in axes.values())
    for name in ("time", *dataset.SCALARS, "frame", "event", *dataset.FIELDS, *axes):
        names = dataset.dimensions(name, coordinates)
        array = group.create_array(
            name,
            shape=axes[name].shape if name in axes else (0, *shape) if name in dataset.FIELDS else (0,),
            chunks=axes[name].shape if name in axes else (1, *shape) if name in dataset.FIELDS else (ROWS,),
            dtype="int8" if name == "event" else "float64",
            dimension_names=names,
            attributes=dataset.variable_attributes(name, case.scales),
        )
        if name in axes:
            array[:] = axes[name]
    _commit(path)


def _open_arrays(path: Path) -> zarr.Group:
    return zarr.open_group(path, mode="r+", use_consolidated=False)


def _array(group: zarr.Group, name: str) -> "zarr.Array[Any]":
    array = group[name]
    assert isinstance(array, zarr.Array)
    return array


def _commit(path: Path) -> None:
    """Show readers the arrays as they are now."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Consolidated metadata is currently not part")
        zarr.consolidate_metadata(path)


def _replace(path: Path, content: bytes) -> None:
    draft = path.with_suffix(".partial")
    draft.write_bytes(content)
    draft.replace(path)
