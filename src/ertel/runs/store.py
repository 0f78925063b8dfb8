"""The directory of a run, safe against interruption at any time.

======================  =========================================================================================
case.toml               the resolved case: `ertel run` of it is the same run again
run.zarr                scalars of every step, maps at chosen times, provenance; `xarray.open_zarr` alone opens it
                        (of a steady contact: scalars of every grid, the maps on the finest one so far)
checkpoint.npz          the state to go on from, and how much of run.zarr belongs to it
summary.json            the outcome
======================  =========================================================================================

A flush writes to run.zarr, then renews its consolidated metadata: now readers see the new rows; then replaces the
checkpoint: now a resumed run goes on from here.  Each file is replaced in one stroke.  The digest of the case stands in
run.zarr and in the checkpoint, and is compared whenever the directory is opened.
"""

import json
import os
import shutil
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
import xarray as xr

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]

from ertel.inputs.case_files import parse_case, read_toml, to_toml
from ertel.model.case import Case
from ertel.model.records import show
from ertel.model.status import Status
from ertel.results.result import Result
from ertel.results.summary import attributes
from ertel.runs import compiling
from ertel.runs.arrays import attributes_in, commit, data_of, old_of, open_arrays
from ertel.runs.courses import Course, Item, course_of
from ertel.runs.drive import Observer, drive, warn_of
from ertel.runs.progress import progress_bar

CASE, DATA, CHECKPOINT, SUMMARY = "case.toml", "run.zarr", "checkpoint.npz", "summary.json"


class StoreError(ValueError):
    """A run directory cannot be made or is not valid; the message names it and says what is wrong."""


class RunStore:
    """The directory of one run.  `create` makes one and `open` opens one; it is an observer of its run."""

    def __init__(self, directory: Path, case: Case, course: Course | None = None):
        self.directory, self.case = directory, case
        self._course = course
        self._started = self._flushed = time.monotonic()
        self._seconds_before = 0.0  # of computing, before this process took over
        self._item: Any = None  # the last one taken and not yet written

    @classmethod
    def create(cls, directory: Path, case: Case, course: Course | None = None) -> "RunStore":
        """The store of a new run in a directory that does not exist or is empty.

        Raises StoreError where the directory cannot be made, ValueError where the case cannot be written.
        """
        store = cls(directory, case, course)
        store._make()
        return store

    @classmethod
    def open(cls, directory: Path) -> "RunStore":
        """The store of the run in a directory.  Raises StoreError if there is none or it belongs to another case."""
        if not (directory / CASE).exists():
            raise StoreError(f"{directory} is not an ertel run directory (no {CASE})")
        data = directory / DATA
        if not (data.exists() or old_of(data).exists()):
            raise StoreError(f"{directory} is not an ertel run directory (no {DATA})")
        store = cls(directory, parse_case(read_toml(directory / CASE)))
        store._check_digest()
        return store

    @property
    def course(self) -> Course:
        """How the case is run."""
        if self._course is None:
            self._course = course_of(self.case)
        return self._course

    @property
    def _data(self) -> Path:
        return self.directory / DATA

    @property
    def seconds(self) -> float:
        """Wall time of the run so far, over all processes that worked on it."""
        return self._seconds_before + time.monotonic() - self._started

    # -- writing ------------------------------------------------------------------------------------------------------

    def _make(self) -> None:
        """Make the directory; nothing is left behind if that fails."""
        text = to_toml(self.case)
        draft = self.directory.parent / f".{self.directory.name}-{uuid4().hex[:8]}"
        try:
            _require_free(self.directory)
            draft.mkdir(parents=True)
            (draft / CASE).write_text(text, encoding="utf-8")
            self._writer = data_of(self.course)
            self._writer.create(draft / DATA)
            draft.rename(self.directory)
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise StoreError(f"{self.directory}: cannot write there, {reason}") from error
        finally:
            shutil.rmtree(draft, ignore_errors=True)

    def __call__(self, item: Item) -> None:
        """Add one item; the items are written at intervals."""
        self._writer.take(item)
        self._item = item
        if time.monotonic() - self._flushed > self._writer.flush_interval:
            self.flush()

    def flush(self) -> None:
        """Write the items taken since the last flush, then the checkpoint."""
        if self._item is None:
            return
        item, self._item = self._item, None
        known = self._writer.flush(self._data)
        self._write_checkpoint({**self.course.to_arrays(item), **known})
        self._writer.after_checkpoint(self._data, item)
        self._flushed = time.monotonic()

    def _write_checkpoint(self, arrays: Mapping[str, Any]) -> None:
        path = self.directory / CHECKPOINT
        draft = path.with_suffix(".partial")
        own = {"store_seconds": np.array(self.seconds), "store_digest": np.array(self.case.digest)}
        with draft.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays, **own)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Write the remaining items and the summary of the run."""
        self.flush()
        open_arrays(self._data).attrs.update(attributes(summary))
        commit(self._data)
        draft = (self.directory / SUMMARY).with_suffix(".partial")
        draft.write_text(to_json(summary), encoding="utf-8")
        draft.replace(self.directory / SUMMARY)

    # -- reading ------------------------------------------------------------------------------------------------------

    def resume(self) -> Any:
        """The item from which to continue, None for the start; later data and the summary are deleted."""
        checkpoint = self._read_checkpoint()
        item = self._item_of(checkpoint)
        self._seconds_before = float(checkpoint.get("store_seconds", 0.0))
        self._started = self._flushed = time.monotonic()
        (self.directory / SUMMARY).unlink(missing_ok=True)
        self._writer = data_of(self.course)
        self._writer.restore(self._data, checkpoint, item)
        return item

    def item(self) -> Any:
        """The item that the checkpoint holds; None where the run is still at its very start."""
        return self._item_of(self._read_checkpoint())

    def _item_of(self, checkpoint: Mapping[str, Any]) -> Any:
        return self.course.from_arrays(checkpoint) if checkpoint else None

    def _read_checkpoint(self) -> dict[str, Any]:
        """What `_write_checkpoint` was given and more, nothing where the run is still at its very start."""
        if not (self.directory / CHECKPOINT).exists():
            return {}
        with np.load(self.directory / CHECKPOINT) as file:
            checkpoint = dict(file)
        if str(checkpoint.get("store_digest")) != self.case.digest:
            raise StoreError(f"{self.directory}: {CHECKPOINT} is not that of {CASE}")
        return checkpoint

    def _check_digest(self) -> None:
        """Raise StoreError if the data belong to another case."""
        attributes = attributes_in(self._data)
        if "digest" not in attributes:
            raise StoreError(
                f"{self.directory}: was written by an older version ({attributes.get('source', 'unknown')}), which did "
                f"not record its case; run {self.directory / CASE} again"
            )
        if attributes["digest"] != self.case.digest:
            changes = _changes(json.loads(str(attributes["case"])), self.case.to_data())
            raise StoreError(f"{self.directory}: {CASE} was changed ({changes}); put it back, or run it as a new case")

    def dataset(self) -> xr.Dataset:
        """The run as far as it has been written."""
        path = self._data if self._data.exists() else old_of(self._data)
        data: xr.Dataset = xr.open_zarr(path)
        return data.load()

    def summary(self) -> dict[str, Any] | None:
        """The outcome, None while the run has not ended."""
        path = self.directory / SUMMARY
        if not path.exists():
            return None
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return content

    def summarise(self, status: Status, work: Mapping[str, float]) -> dict[str, Any]:
        """The summary of what is written, of which there must be something; work: compilations, wall_s."""
        return self.course.summary(self.dataset(), self.item(), status, work)

    def summary_so_far(self) -> dict[str, Any]:
        """The summary of a run that has not ended.  Raises StoreError where there is nothing yet."""
        checkpoint = self._read_checkpoint()
        if not checkpoint:
            raise StoreError(f"{self.directory}: nothing is computed yet")
        return self.summarise(Status.RUNNING, {"compilations": 0, "wall_s": float(checkpoint["store_seconds"])})

    def result(self) -> Result:
        """The run as far as it is written.  Raises StoreError where there is nothing yet."""
        summary = self.summary() or self.summary_so_far()
        return Result(self.case, self.dataset(), summary, Status(summary["status"]), self.directory)


def _changes(before: Any, now: Any, place: str = "") -> str:
    """What differs between two cases as plain data, names and references apart."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        free = ("name", "reference")
        keys = [key for key in {**before, **now} if before.get(key) != now.get(key) and key not in free]
        return ", ".join(_changes(before.get(key), now.get(key), f"{place}.{key}".removeprefix(".")) for key in keys)
    return f"{place} {show(before)} → {show(now)}"


# -- running ----------------------------------------------------------------------------------------------------------


def compute(store: RunStore, observers: Sequence[Observer] = ()) -> dict[str, Any]:
    """Continue a stored case to its end, write all results, and return the summary."""
    compiled = compiling.count()
    with _alone(store.directory):
        last = drive(store.course, [store, *observers], store.resume())
        store.flush()
        work = {"compilations": compiling.count() - compiled, "wall_s": store.seconds}
        summary = store.summarise(last.status, work)
        store.finish(summary)
    return summary


def run(case: Case, directory: str | Path, progress: bool = False, observers: Sequence[Observer] = ()) -> Result:
    """Run a case and store it; an interrupted run is continued, and a complete run is read.

    Parameters
    ----------
    case : Case
        What to run.
    directory : str or Path
        The run directory: made if it is not there.
    progress, observers
        As in `simulate`.

    Raises StoreError where the directory holds another case, or cannot be written.
    """
    compiling.check_jax()
    compiling.keep_on_disk()
    directory = Path(directory)
    store = RunStore.open(directory) if (directory / CASE).exists() else RunStore.create(directory, case)
    if store.case != case:
        raise StoreError(f"{directory}: holds another case ({_changes(store.case.to_data(), case.to_data())})")
    outcome = store.summary()
    if outcome is None or not Status(outcome["status"]).ok:
        with progress_bar(store.course, progress) as shown:
            compute(store, [*shown, *observers])
    result = store.result()
    warn_of(result)
    return result


def open_run(directory: str | Path) -> Result:
    """The run in a directory, as far as it is written.  Raises StoreError where there is none."""
    return RunStore.open(Path(directory)).result()


@contextmanager
def _alone(directory: Path) -> Iterator[None]:
    """Lock a run against other processes, as far as the system allows."""
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
        raise StoreError(f"{directory}: exists already")
