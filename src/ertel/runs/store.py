"""The directory of a run, safe against being cut off at any moment.

======================  =========================================================================================
case.toml               the resolved case: `ertel run` of it is the same run again
run.zarr                scalars of every step, maps at chosen times, provenance; `xarray.open_zarr` alone opens it
                        (of a steady contact: scalars of every grid, the maps on the finest one so far)
checkpoint.npz          the state to go on from, and how much of run.zarr belongs to it
summary.json            the outcome
======================  =========================================================================================

A flush appends to run.zarr, then renews its consolidated metadata: now readers see the new rows; then replaces the
checkpoint: now a resumed run goes on from here.  Each file is replaced in one stroke, and what was appended after the
last checkpoint is cut off again when the run is resumed.  The run.zarr of a steady contact follows from its checkpoint,
which comes first, and is replaced as a whole.
"""

import json
import os
import shutil
import time
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast
from uuid import uuid4

import jax.numpy as jnp
import numpy as np
import xarray as xr
import zarr
from numpy.typing import NDArray

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]

from ertel.inputs.case_files import load_case
from ertel.inputs.schema import to_toml
from ertel.model.case import Case
from ertel.model.state import GridSolution, Method
from ertel.model.status import Status
from ertel.numerics.grid import Grid
from ertel.numerics.symmetry import Even
from ertel.results import variables
from ertel.results.summary import steady_summary
from ertel.runs import compiling
from ertel.runs.drive import Course, Frame, Step, method_of, summarise, transient
from ertel.solvers import steady

CASE, DATA, CHECKPOINT, SUMMARY = "case.toml", "run.zarr", "checkpoint.npz", "summary.json"
OLD_DATA = f"{DATA}.old"
FLUSH_INTERVAL = 5.0  # s: what a killed run loses at most
ROWS = 4096  # steps in a chunk of scalars; each map is a chunk of its own
NAMES = {"time": ("time", *variables.SCALARS), "frame": ("frame", "event", *variables.FIELDS)}  # what grows along what


class StoreError(ValueError):
    """A run directory cannot be made, or is none: the message names it and says what to do."""


class RunStore(ABC):
    """The directory of one run.  Make one with `create`, or take up one with `open`.

    Items are what a run is made of: time steps, or the grids of a steady contact.
    """

    def __init__(self, directory: Path, case: Case):
        self.directory = directory
        self.case = case
        self._started = time.monotonic()
        self._seconds_before = 0.0  # of computing, before this process took over

    @classmethod
    def create(cls, directory: Path, case: Case, method: Method | None = None) -> "RunStore":
        """The store of a new run in a directory that does not exist or is empty.  Raises StoreError.

        method spares making the case's method again.
        """
        if case.solver.method == "steady":
            store: RunStore = SteadyStore(directory, case)
        else:
            store = TransientStore(directory, case, (method or method_of(case)).coordinates)
        store._make()
        return store

    @classmethod
    def open(cls, directory: Path) -> "RunStore":
        """The store of the run in a directory.  Raises StoreError where there is none."""
        for names in ((CASE,), (DATA, OLD_DATA)):
            if not any((directory / name).exists() for name in names):
                raise StoreError(f"{directory}: is no run of ertel, {names[0]} is missing")
        case = load_case(directory / CASE)
        return (SteadyStore if case.solver.method == "steady" else TransientStore)(directory, case)

    @property
    def seconds(self) -> float:
        """Wall time of the run so far, over all processes that worked on it."""
        return self._seconds_before + time.monotonic() - self._started

    # -- what differs -------------------------------------------------------------------------------------------------

    @abstractmethod
    def _make_data(self, path: Path) -> None:
        """Write the DATA of a run that has not begun."""

    @abstractmethod
    def course(self, method: Method | None = None) -> Iterator[Step | GridSolution]:
        """Go on from where the run stands to its end, every item taken in before it is yielded."""

    @abstractmethod
    def ended(self, item: Any) -> bool:
        """Whether an item is the run's last."""

    @abstractmethod
    def flush(self) -> None:
        """Write what is not yet written."""

    @abstractmethod
    def summarise(self, status: Status, work: Mapping[str, float]) -> dict[str, Any]:
        """The summary of what is written, of which there must be something; work: compilations, wall_s."""

    # -- writing ------------------------------------------------------------------------------------------------------

    def _make(self) -> None:
        """Make the directory; nothing is left behind where that fails."""
        if not self.case.source:
            raise StoreError("case: has no source to store; make it with ertel.load_case or ertel.parse_case")
        draft = self.directory.parent / f".{self.directory.name}-{uuid4().hex[:8]}"
        try:
            _require_free(self.directory)
            draft.mkdir(parents=True)
            (draft / CASE).write_text(to_toml(self.case.source), encoding="utf-8")
            self._make_data(draft / DATA)
            draft.rename(self.directory)
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise StoreError(f"{self.directory}: cannot write there, {reason}") from error
        finally:
            shutil.rmtree(draft, ignore_errors=True)

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Write what is left, and the outcome of the run."""
        self.flush()
        plain = {key: value for key, value in summary.items() if isinstance(value, str | int | float)}
        _open_arrays(self.directory / DATA).attrs.update(plain)
        _commit(self.directory / DATA)
        draft = (self.directory / SUMMARY).with_suffix(".partial")
        draft.write_text(to_json(summary), encoding="utf-8")
        draft.replace(self.directory / SUMMARY)

    def _write_checkpoint(self, arrays: Mapping[str, Any]) -> None:
        path = self.directory / CHECKPOINT
        draft = path.with_suffix(".partial")
        with draft.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays, store_seconds=np.array(self.seconds))
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)

    # -- reading ------------------------------------------------------------------------------------------------------

    def _read_checkpoint(self) -> dict[str, Any]:
        """What `_write_checkpoint` was given and `store_seconds`, nothing where the run is still at its very start."""
        if not (self.directory / CHECKPOINT).exists():
            return {}
        with np.load(self.directory / CHECKPOINT) as file:
            return dict(file)

    def _go_on(self, checkpoint: Mapping[str, Any]) -> None:
        """The clock runs again, and there is no outcome any more."""
        self._seconds_before = float(checkpoint.get("store_seconds", 0.0))
        self._started = time.monotonic()
        (self.directory / SUMMARY).unlink(missing_ok=True)

    def dataset(self) -> xr.Dataset:
        """The run as far as it is written."""
        path = self.directory / DATA
        data: xr.Dataset = xr.open_zarr(path if path.exists() else self.directory / OLD_DATA)
        return data.load()

    def summary(self) -> dict[str, Any] | None:
        """The outcome, None while the run has not ended."""
        path = self.directory / SUMMARY
        if not path.exists():
            return None
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return content

    def summary_so_far(self) -> dict[str, Any]:
        """The summary of a run that has not ended.  Raises StoreError where there is nothing yet."""
        checkpoint = self._read_checkpoint()
        if not checkpoint:
            raise StoreError(f"{self.directory}: nothing is computed yet; begin with ertel resume {self.directory}")
        return self.summarise(Status.RUNNING, {"compilations": 0, "wall_s": float(checkpoint["store_seconds"])})


# -- a run in time ----------------------------------------------------------------------------------------------------


class TransientStore(RunStore):
    """The directory of a run in time."""

    def __init__(self, directory: Path, case: Case, coordinates: Mapping[str, Any] | None = None):
        super().__init__(directory, case)
        self._coordinates = coordinates or {}
        self._flushed = time.monotonic()
        self._written = dict.fromkeys(NAMES, 0)
        self._records: list[Mapping[str, float]] = []
        self._frames: list[Frame] = []
        self._state: Course | None = None  # the last one taken and not yet written

    def _make_data(self, path: Path) -> None:
        _create_arrays(path, self.case, self._coordinates)

    def course(self, method: Method | None = None) -> Iterator[Step]:
        """Accepted steps, now and then written."""
        for step in transient(self.case, self.resume(), method):
            self.append(step)
            yield step

    def ended(self, item: Step) -> bool:
        """Whether a step is the run's last."""
        return item.status is not Status.RUNNING

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
        self._extend("time", variables.columns(self._records) if self._records else {})
        self._extend("frame", variables.maps(self._frames) if self._frames else {})
        _commit(self.directory / DATA)
        written = np.array(list(self._written.values()))
        self._write_checkpoint({**self._state.to_arrays(), "store_written": written})
        self._records, self._frames, self._state = [], [], None
        self._flushed = time.monotonic()

    def _extend(self, dimension: str, arrays: Mapping[str, Any]) -> None:
        group = _open_arrays(self.directory / DATA)
        for name, values in arrays.items():
            _array(group, name).append(values)
        self._written[dimension] += len(arrays[dimension]) if arrays else 0

    def state(self) -> Course | None:
        """The state to go on from; None where the run is still at its very start."""
        arrays = self._read_checkpoint()
        return Course.from_arrays(arrays) if arrays else None

    def resume(self) -> Course | None:
        """The state to go on from; what was written after it is cut off."""
        checkpoint = self._read_checkpoint()
        self._go_on(checkpoint)
        self._flushed = self._started
        written = checkpoint["store_written"].tolist() if checkpoint else [0] * len(NAMES)
        self._written = dict(zip(NAMES, written, strict=True))
        group = _open_arrays(self.directory / DATA)
        for dimension, names in NAMES.items():
            for name in names:
                array = _array(group, name)
                array.resize((self._written[dimension], *array.shape[1:]))
        if group.attrs["status"] != Status.RUNNING.value:
            group.attrs["status"] = Status.RUNNING.value
        _commit(self.directory / DATA)
        return Course.from_arrays(checkpoint) if checkpoint else None

    def summarise(self, status: Status, work: Mapping[str, float]) -> dict[str, Any]:
        """See `simulation.summarise`."""
        state = self.state()
        assert state, "there is a checkpoint"
        return summarise(self.case, Step(state, {}, (), status), self.dataset(), work)


# -- a steady contact -------------------------------------------------------------------------------------------------


class SteadyStore(RunStore):
    """The directory of a steady contact: written after every grid, so that a killed run loses the one under way."""

    def _make_data(self, path: Path) -> None:
        data = variables.assemble_steady(self.case, self.solutions(), {"status": Status.RUNNING.value})
        data.to_zarr(path, consolidated=False)
        _commit(path)

    def course(self, method: Method | None = None) -> Iterator[GridSolution]:
        """Solutions on the grids, coarsest first, every one written."""
        checkpoint = self._read_checkpoint()
        self._go_on(checkpoint)
        done = _from_arrays(checkpoint)
        self._replace_data()
        if done and self.ended(done[-1]):  # it gave up, and would again
            yield done[-1]
            return
        for solution in steady.nested(self.case, done):
            done.append(solution)
            self._write_checkpoint(_to_arrays(done))
            self._replace_data()
            yield solution

    def ended(self, item: GridSolution) -> bool:
        """Whether it is the solution on the finest grid."""
        return item.grid.nodes == self.case.solver.nodes

    def flush(self) -> None:
        """Nothing waits: every grid is written as it comes."""

    def _replace_data(self) -> None:
        """Make DATA anew from the checkpoint; OLD_DATA stands in for it between the two renames."""
        path, old, draft = (self.directory / name for name in (DATA, OLD_DATA, f"{DATA}.partial"))
        shutil.rmtree(draft, ignore_errors=True)
        self._make_data(draft)
        if path.exists():
            shutil.rmtree(old, ignore_errors=True)
            path.rename(old)
        draft.rename(path)
        shutil.rmtree(old, ignore_errors=True)

    def solutions(self) -> list[GridSolution]:
        """The grids that are done, coarsest first."""
        return _from_arrays(self._read_checkpoint())

    def summarise(self, status: Status, work: Mapping[str, float]) -> dict[str, Any]:
        """See `summary.steady_summary`."""
        return steady_summary(self.case, self.solutions(), work, status)


COUNTED = ("approach", "residual", "newton", "krylov", "convolutions")  # the plain numbers of a GridSolution


def _to_arrays(solutions: Sequence[GridSolution]) -> dict[str, NDArray[Any]]:
    """Solutions as named arrays, exact to the last bit."""
    arrays = {name: np.array([getattr(s, name) for s in solutions]) for name in COUNTED}
    arrays["grid"] = np.array([_grid_numbers(s.grid) for s in solutions], dtype=float)
    arrays["status"] = np.array([s.status.value for s in solutions])
    for i, s in enumerate(solutions):
        arrays |= {f"{name}_{i}": np.asarray(getattr(s, name)) for name in ("P", "H", "history")}
    return arrays


def _grid_numbers(grid: Grid) -> tuple[float, ...]:
    return (grid.nodes_x, grid.nodes_y, grid.spacing, grid.centre_x, grid.centre_y, *grid.even)


def _from_arrays(arrays: Mapping[str, NDArray[Any]]) -> list[GridSolution]:
    """Undo `_to_arrays`; nothing gives none."""
    found = []
    for i, (*nodes, spacing, x, y, even_y, even_x) in enumerate(arrays["grid"].tolist() if arrays else []):
        found.append(
            GridSolution(
                grid=Grid(int(nodes[0]), int(nodes[-1]), spacing, x, y, Even(bool(even_y), bool(even_x))),
                P=jnp.asarray(arrays[f"P_{i}"]),
                H=jnp.asarray(arrays[f"H_{i}"]),
                status=Status(str(arrays["status"][i])),
                history=tuple(arrays[f"history_{i}"].tolist()),
                **{name: arrays[name][i].item() for name in COUNTED},
            )
        )
    return found


# -- running ----------------------------------------------------------------------------------------------------------


def run(store: RunStore, on_item: Callable[[Any], bool], method: Method | None = None) -> dict[str, Any]:
    """Run a stored case, from where it stands to its end, and give its summary, all of it written down.

    on_item sees every Step, or GridSolution, and says whether to go on.  method spares making the case's method again.
    """
    compiled = compiling.count()
    with _alone(store.directory):
        status = Status.RUNNING
        for item in store.course(method):
            status = item.status
            if not on_item(item) and not store.ended(item):
                status = Status.INTERRUPTED
                break
        store.flush()
        work = {"compilations": compiling.count() - compiled, "wall_s": store.seconds}
        summary = store.summarise(status, work)
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
    attributes = {**variables.provenance(case), "status": Status.RUNNING.value}
    group = zarr.create_group(path, attributes=cast(dict[str, Any], attributes))
    axes = {name: np.asarray(values, dtype=float) for name, values in coordinates.items()}
    shape = tuple(len(values) for values in axes.values())
    for name in (*axes, *NAMES["time"], *NAMES["frame"]):
        rest = shape if name in variables.FIELDS else ()
        array = group.create_array(
            name,
            shape=axes[name].shape if name in axes else (0, *rest),
            chunks=axes[name].shape if name in axes else (1, *rest) if rest else (ROWS,),
            dtype="int8" if name == "event" else "float64",
            dimension_names=variables.dimensions(name, coordinates),
            attributes=cast(dict[str, Any], variables.variable_attributes(name, case.scales)),
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
