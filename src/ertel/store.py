"""The directory of a run, safe against being cut off at any moment.

======================  =========================================================================================
case.toml               the resolved case: `ertel run` of it is the same run again
run.zarr                scalars of every step, maps at chosen times, provenance; `xarray.open_zarr` alone opens it
checkpoint.npz          the state to go on from, and how much of run.zarr belongs to it
summary.json            the outcome
======================  =========================================================================================

A flush appends to run.zarr, then renews its consolidated metadata: now readers see the new rows; then replaces the
checkpoint: now a resumed run goes on from here.  Each file is replaced in one stroke, and what was appended after the
last checkpoint is cut off again when the run is resumed.
"""

import json
import os
import shutil
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, cast
from uuid import uuid4

import numpy as np
import xarray as xr
import zarr

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]

from ertel import compiling, dataset
from ertel.case import Case
from ertel.config import load_case, to_toml
from ertel.level import Method
from ertel.simulation import Frame, State, Step, summarise, transient
from ertel.status import Status

CASE, DATA, CHECKPOINT, SUMMARY = "case.toml", "run.zarr", "checkpoint.npz", "summary.json"
FLUSH_INTERVAL = 5.0  # s: what a killed run loses at most
ROWS = 4096  # steps in a chunk of scalars; each map is a chunk of its own
NAMES = {"time": ("time", *dataset.SCALARS), "frame": ("frame", "event", *dataset.FIELDS)}  # what grows along what


class StoreError(ValueError):
    """A run directory cannot be made, or is none: the message names it and says what to do."""


class RunStore:
    """The directory of one run.  Make one with `create`, or take up one with `open`."""

    def __init__(self, directory: Path, case: Case):
        self.directory = directory
        self.case = case
        self._started = self._flushed = time.monotonic()
        self._seconds_before = 0.0  # of computing, before this process took over
        self._written = dict.fromkeys(NAMES, 0)
        self._records: list[Mapping[str, float]] = []
        self._frames: list[Frame] = []
        self._state: State | None = None  # the last one taken and not yet written

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
        return self._seconds_before + time.monotonic() - self._started

    def append(self, step: Step) -> None:
        """Take one more step; now and then the steps taken so far are written."""
        if step.record:  # a run that gives up ends with a step that has none
            self._records.append(step.record)
        self._frames.extend(step.frames)
        self._state = step.state
        if time.monotonic() - self._flushed > FLUSH_INTERVAL:
            self.flush()

    def flush(self) -> None:
        """Write the steps taken since the last flush, then the checkpoint."""
        if self._state is None:
            return
        self._extend("time", dataset.columns(self._records) if self._records else {})
        self._extend("frame", dataset.maps(self._frames) if self._frames else {})
        _commit(self.directory / DATA)
        self._write_checkpoint(self._state)
        self._records, self._frames, self._state = [], [], None
        self._flushed = time.monotonic()

    def _extend(self, dimension: str, arrays: Mapping[str, Any]) -> None:
        group = _open_arrays(self.directory / DATA)
        for name, values in arrays.items():
            _array(group, name).append(values)
        self._written[dimension] += len(arrays[dimension]) if arrays else 0

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Write what is left, and the outcome of the run."""
        self.flush()
        plain = {key: value for key, value in summary.items() if isinstance(value, str | int | float)}
        _open_arrays(self.directory / DATA).attrs.update(plain)
        _commit(self.directory / DATA)
        draft = (self.directory / SUMMARY).with_suffix(".partial")
        draft.write_text(to_json(summary), encoding="utf-8")
        draft.replace(self.directory / SUMMARY)

    def _write_checkpoint(self, state: "State") -> None:
        ours = {"store_written": np.array(list(self._written.values())), "store_seconds": np.array(self.seconds)}
        arrays = {**state.to_arrays(), **ours}
        path = self.directory / CHECKPOINT
        draft = path.with_suffix(".partial")
        with draft.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)

    # -- reading ------------------------------------------------------------------------------------------------------

    def state(self) -> State | None:
        """The state to go on from; None where the run is still at its very start."""
        if not (self.directory / CHECKPOINT).exists():
            return None
        with np.load(self.directory / CHECKPOINT) as file:
            arrays = dict(file)
        self._written = dict(zip(NAMES, arrays["store_written"].tolist(), strict=True))
        self._seconds_before = float(arrays["store_seconds"])
        return State.from_arrays(arrays)

    def resume(self) -> State | None:
        """The state to go on from; what was written after it is cut off."""
        state = self.state()
        self._started = self._flushed = time.monotonic()
        (self.directory / SUMMARY).unlink(missing_ok=True)
        group = _open_arrays(self.directory / DATA)
        for dimension, names in NAMES.items():
            for name in names:
                array = _array(group, name)
                array.resize((self._written[dimension], *array.shape[1:]))
        if group.attrs["status"] != Status.RUNNING.value:
            group.attrs["status"] = Status.RUNNING.value
        _commit(self.directory / DATA)
        return state

    def dataset(self) -> xr.Dataset:
        """The run as far as it is written."""
        data: xr.Dataset = xr.open_zarr(self.directory / DATA)
        return data.load()

    def summary(self) -> dict[str, Any] | None:
        """The outcome, None while the run has not ended."""
        path = self.directory / SUMMARY
        if not path.exists():
            return None
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return content

    def summary_so_far(self) -> dict[str, Any]:
        """The summary of a run that has not ended.  Raises StoreError where there is no step yet."""
        state = self.state()
        if state is None:
            raise StoreError(f"{self.directory}: nothing is computed yet; begin with ertel resume {self.directory}")
        work = {"compilations": 0, "wall_s": self._seconds_before}
        return summarise(self.case, Step(state, {}, (), Status.RUNNING), self.dataset(), work)


def run(store: RunStore, on_step: Callable[[Step], bool], method: Method | None = None) -> dict[str, Any]:
    """Run a stored case, from where it stands to its end, and give its summary, all of it written down.

    on_step sees every step and says whether to go on.  method spares making the case's method again.
    """
    compiled = compiling.count()
    with _alone(store.directory):
        for step in transient(store.case, store.resume(), method):
            store.append(step)
            if not on_step(step) and step.status is Status.RUNNING:
                step = replace(step, status=Status.INTERRUPTED)
                break
        store.flush()
        work = {"compilations": compiling.count() - compiled, "wall_s": store.seconds}
        summary = summarise(store.case, step, store.dataset(), work)
        store.finish(summary)
    return summary


@contextmanager
def _alone(directory: Path) -> Iterator[None]:
    """Hold a run against other processes, as far as the system can."""
    with (directory / CASE).open() as file:
        if fcntl:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise StoreError(f"{directory}: another process is computing this run") from error
        yield


def to_json(summary: Mapping[str, Any]) -> str:
    """A summary as the text of summary.json."""
    return json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


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
    attributes = {**dataset.provenance(case), "status": Status.RUNNING.value}
    group = zarr.create_group(path, attributes=cast(dict[str, Any], attributes))
    axes = {name: np.asarray(values, dtype=float) for name, values in coordinates.items()}
    shape = tuple(len(values) for values in axes.values())
    for name in (*axes, *NAMES["time"], *NAMES["frame"]):
        rest = shape if name in dataset.FIELDS else ()
        array = group.create_array(
            name,
            shape=axes[name].shape if name in axes else (0, *rest),
            chunks=axes[name].shape if name in axes else (1, *rest) if rest else (ROWS,),
            dtype="int8" if name == "event" else "float64",
            dimension_names=dataset.dimensions(name, coordinates),
            attributes=cast(dict[str, Any], dataset.variable_attributes(name, case.scales)),
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
