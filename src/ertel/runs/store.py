"""The data of a run on disk, safe against interruption at any time; `directory` has the names of its files.

A flush writes to run.zarr, then renews its metadata: now readers see the new rows; then replaces the checkpoint: now a
resumed run goes on from here.  Each file has a checksum, is replaced atomically, and is on the disk before the next one
counts on it.  The digest of the case stands in run.zarr, in the checkpoint and in the summary, and is compared when
they are read.
"""

import json
import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ertel.case.case import Case
from ertel.case.records import show
from ertel.case.status import Status
from ertel.inputs.case_files import CaseLike, as_case, path_of
from ertel.numerics.programs import double_precision
from ertel.results.dataset import Frame
from ertel.results.numbers import differences
from ertel.results.summary import attributes
from ertel.runs import arrays, files
from ertel.runs.arrays import AppendedData, ReplacedData
from ertel.runs.compile import check_jax, compilations
from ertel.runs.directory import (
    CASE,
    CHECKPOINT,
    DATA,
    RUNS,
    SUMMARY,
    ProgressFile,
    folders_in,
    heeding_stop,
    is_asked_to_stop,
    is_run,
    make,
    numbered,
    read_case,
    read_summary,
    remove,
)
from ertel.runs.drive import Observer, Run, SteadyRun, StepResult, bars, drive, run_of, warn, watch
from ertel.runs.files import Damaged, StoreError
from ertel.runs.outlook import warnings_of, with_case_warnings
from ertel.runs.result import Result

LARGEST_CHECKPOINT = 4 * 10**9  # bytes: of 4097 x 4097 nodes a map has 0.13 GB, and there are several


class RunStore:
    """The directory of one run.  `create` makes one and `open` opens one; it is an observer of its run.

    flush_interval: seconds between flushes, of which a killed run loses at most so many.
    """

    flush_interval = 5.0

    def __init__(self, directory: Path, case: Case, run: Run | None = None):
        self.directory, self.case, self._run = directory, case, run
        self._advice = (ReplacedData if case.is_steady else AppendedData).advice
        self._started = self._flushed = time.monotonic()
        self._seconds_before = 0.0  # of computing, before this process took over
        self._item: Any = None  # the last result taken and not yet written
        self._records: list[Mapping[str, float]] = []  # taken and not yet written
        self._frames: list[Frame] = []
        self._alone = False  # whether this object holds the lock

    @classmethod
    def create(cls, directory: Path, case: Case, run: Run | None = None, others: Iterable[Path] = ()) -> "RunStore":
        """The store of a new run in a directory that does not exist or is empty; if it is taken, in one of the others.

        Raises Taken where there is no place, StoreError where it cannot be made, ValueError where the case cannot be
        written.
        """
        store = cls(directory, case, run)
        store.directory = make(directory, case, lambda draft: store._arrays.create(draft / DATA), others)
        return store

    @classmethod
    def create_unused(cls, case: Case, parent: Path, run: Run | None = None) -> "RunStore":
        """The store of a new run in parent/NAME, parent/NAME-2, ...: the first that does not exist.

        Other processes may take names at the same time.  Raises as `create`.
        """
        unused = (path for path in numbered(parent / (case.name or case.kind)) if not path.exists())
        return cls.create(next(unused), case, run, unused)

    @classmethod
    def open(cls, directory: Path) -> "RunStore":
        """The store of the run in a directory.  Raises StoreError if there is none or it belongs to another case."""
        if not directory.is_dir():
            raise StoreError(f"{directory}: {'not a directory' if directory.exists() else 'no such file or directory'}")
        for name, path in ((CASE, directory / CASE), (DATA, arrays.present(directory / DATA))):
            if not path.exists():
                raise StoreError(f"{directory} is not an ertel run directory (no {name})")
        store = cls(directory, read_case(directory))
        store._require_own_data()
        return store

    @property
    def run(self) -> Run:
        """The run that this store observes."""
        if self._run is None:
            self._run = run_of(self.case)
        return self._run

    @cached_property
    def _arrays(self) -> AppendedData | ReplacedData:
        return ReplacedData(self.run) if isinstance(self.run, SteadyRun) else AppendedData(self.run)

    @property
    def _data(self) -> Path:
        return self.directory / DATA

    @property
    def seconds(self) -> float:
        """Wall time of the run so far, over all processes that worked on it."""
        return self._seconds_before + time.monotonic() - self._started

    # -- writing ------------------------------------------------------------------------------------------------------

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Keep other processes from computing this run; may be nested.

        Raises StoreError where another process computes it, or where case.toml was edited since it was opened.
        """
        if self._alone:
            yield
            return
        with files.locked(self.directory), heeding_stop(self.directory):
            self._require_same(read_case(self.directory), self.case.digest, self.case.to_data())
            self._require_own_data()
            files.require_no_links(files.within(arrays.present(self._data)))
            self._alone = True
            try:
                yield
            finally:
                self._alone = False

    def asked_to_stop(self, result: object = None) -> bool:
        """Whether there is a file that asks the run to stop; this is an observer."""
        return is_asked_to_stop(self.directory)

    def __call__(self, result: StepResult) -> None:
        """Add one result; the results are written at intervals."""
        self._item = result
        if result.record:  # a run that gives up ends with a result that has none
            self._records.append(result.record)
        self._frames.extend(result.frames)
        if time.monotonic() - self._flushed > self.flush_interval:
            self.flush()

    def flush(self) -> None:
        """Write the results taken since the last flush, then the checkpoint."""
        if self._item is None:
            return
        result, self._item = self._item, None
        written = self._arrays.flush(self._data, self._records, self._frames, result)
        self._records, self._frames = [], []
        self._write_checkpoint({**self.run.to_arrays(result), **written})
        self._flushed = time.monotonic()

    def _write_checkpoint(self, values: Mapping[str, Any]) -> None:
        about = {"store_seconds": np.array(self.seconds), "store_digest": np.array(self.case.digest)}
        content = BytesIO()
        np.savez(content, allow_pickle=False, **values, **about)
        files.replace(self.directory / CHECKPOINT, files.with_checksum(content.getvalue()))

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Write the remaining results and the summary of the run."""
        self.flush()
        arrays.update_attributes(self._data, attributes(summary), self._advice)
        files.replace(self.directory / SUMMARY, files.sealed({**summary, "digest": self.case.digest}))

    # -- reading ------------------------------------------------------------------------------------------------------

    def resume(self) -> Any:
        """The result from which to continue, None for the start; later data and the summary are deleted.

        Raises Damaged where the checkpoint, or data that do not follow from it, are damaged; then nothing has changed.
        """
        checkpoint, result = self._read_checkpoint()
        self._arrays.restore(self._data, checkpoint, result)
        (self.directory / SUMMARY).unlink(missing_ok=True)
        self._records, self._frames = [], []
        self._seconds_before = float(checkpoint.get("store_seconds", 0.0))
        self._started = self._flushed = time.monotonic()
        return result

    def item(self) -> Any:
        """The result that the checkpoint holds; None where the run is still at its very start."""
        return self._read_checkpoint()[1]

    def _read_checkpoint(self) -> tuple[dict[str, Any], Any]:
        """The arrays of the checkpoint and its result; none where the run is still at its very start."""
        path = self.directory / CHECKPOINT
        try:
            content = files.content_of(path, LARGEST_CHECKPOINT)
        except FileNotFoundError:
            return {}, None
        with files.reading(path, "delete it to have the run computed from its start"):
            with np.load(BytesIO(files.without_checksum(content)), allow_pickle=False) as file:
                checkpoint = dict(file)
            self._require_own(CHECKPOINT, str(checkpoint.get("store_digest")))
            return checkpoint, self.run.from_arrays(checkpoint)

    def _require_own(self, name: str, digest: object) -> None:
        if digest != self.case.digest:
            raise StoreError(f"{self.directory}: {name} is not that of {CASE}; put the run's own file back")

    def _require_own_data(self) -> None:
        """Raise StoreError if the data belong to another case; damage is reported where the data are needed."""
        try:
            attributes = arrays.read_root(arrays.present(self._data), self._advice)["attributes"]
        except Damaged:
            return
        self._require_same(self.case, attributes["digest"], json.loads(attributes["case"]))

    def _require_same(self, case: Case, digest: str, data: Mapping[str, Any]) -> None:
        """Raise StoreError unless the case of the file is the one with this digest and these plain data."""
        if digest != case.digest:
            changed = changes(data, case.to_data())
            raise StoreError(f"{self.directory}: {CASE} was changed ({changed}); put it back, or run it as a new case")

    def dataset(self) -> xr.Dataset:
        """The run as far as it has been written.  Raises Damaged."""
        return arrays.read(self._data, self._advice)

    def summary(self) -> dict[str, Any] | None:
        """The summary as it is stored, None where there is none yet.  Raises Damaged."""
        summary = read_summary(self.directory)
        if summary is not None:
            self._require_own(SUMMARY, summary.pop("digest", None))
        return summary

    def outcome(self) -> dict[str, Any] | None:
        """The summary of a run that has converged and is whole; None where there is something left to do."""
        try:
            summary = self.summary()
            whole = summary is not None and self.dataset().attrs["status"] == summary["status"]
        except StoreError:
            return None
        return summary if summary and whole and Status(summary["status"]).ok else None

    def summarise(self, result: Any, status: Status, work: Mapping[str, float]) -> dict[str, Any]:
        """The summary of what is written, up to this result; work: compilations, wall_s."""
        return with_case_warnings(self.case, self.run.summary(self.dataset(), result, status, work))

    def summary_so_far(self) -> dict[str, Any]:
        """The summary of a run that has not ended.  Raises StoreError where there is nothing yet."""
        checkpoint, result = self._read_checkpoint()
        if result is None:
            raise StoreError(f"{self.directory}: nothing is computed yet; to start it: ertel resume {self.directory}")
        return self.summarise(result, Status.RUNNING, {"compilations": 0, "wall_s": float(checkpoint["store_seconds"])})

    def result(self) -> Result:
        """The run as far as it is written.  Raises StoreError where there is nothing yet."""
        summary = self.summary() or self.summary_so_far()
        return Result(self.case, self.dataset(), summary, Status(summary["status"]), self.directory)


def changes(before: Any, now: Any) -> str:
    """The fields in which two cases differ as plain data, names and references apart."""
    found = differences(before, now)
    return ", ".join(f"{each['field']} {show(each['first'])} → {show(each['second'])}" for each in found)


# -- running ----------------------------------------------------------------------------------------------------------


@double_precision()
def compute(store: RunStore, observers: Sequence[Observer] = ()) -> dict[str, Any]:
    """Continue a stored case to its end, write all results, and return the summary.

    A run that has converged is left alone, unless something is missing or damaged that follows from the rest: the
    summary, or the data of a steady contact.  Raises StoreError where another process computes this run, where
    case.toml was edited, or where something else is damaged.
    """
    compiled = compilations()
    with store.alone():
        finished = store.outcome()
        if finished is not None:
            return finished
        progress = ProgressFile(store.directory, store.run)
        last = drive(store.run, [store, progress, *observers, store.asked_to_stop], store.resume())
        progress.write(last)
        store.flush()
        work = {"compilations": compilations() - compiled, "wall_s": store.seconds}
        summary = store.summarise(last, last.status, work)
        store.finish(summary)
    return summary


@double_precision()
def run(case: CaseLike, directory: str | Path, progress: bool = False, observers: Sequence[Observer] = ()) -> Result:
    """Run a case and store it; an interrupted run is continued, and a complete run is read.

    Parameters
    ----------
    case : Case, str, Path or mapping
        What to run, as for `simulate`.
    directory : str or Path
        The run directory: made if it is not there.
    progress, observers
        As in `simulate`.

    Returns
    -------
    Result
        The stored run, as of `simulate`.

    Raises
    ------
    StoreError
        The directory holds another case, or cannot be written.
    """
    check_jax()
    case, directory = as_case(case), path_of("directory", directory, "a run directory")
    store = RunStore.open(directory) if (directory / CASE).exists() else RunStore.create(directory, case)
    if store.case != case:
        raise StoreError(f"{directory}: holds another case ({changes(store.case.to_data(), case.to_data())})")
    before = warnings_of(case)
    warn(before)
    if store.outcome() is None:
        with bars(progress) as shown:
            compute(store, [watch(shown, store.run), *observers])
    result = store.result()
    warn([sentence for sentence in result.warnings if sentence not in before])
    return result


@double_precision()
def open_run(directory: str | Path) -> Result:
    """Read the run in a directory, as far as it is written.

    Parameters
    ----------
    directory : str or Path
        The run directory.

    Returns
    -------
    Result
        The run; its `status` says whether it is complete.

    Raises
    ------
    StoreError
        There is no run, or it is damaged.
    """
    return RunStore.open(path_of("directory", directory, "a run directory")).result()


# -- the runs of a study -----------------------------------------------------------------------------------------------


def prune(study: Path, kept: Collection[str]) -> tuple[int, list[str]]:
    """Delete the runs of a study that it no longer has: their number, and why others of them stay.

    kept: the digests of the cases that it has.  A run is a directory with the digest of its case as its name; nothing
    else is touched, and links are not followed.
    """
    files.require_no_links([study / RUNS])
    removed, left = 0, []
    for run in folders_in(study / RUNS):
        if run.name not in kept and is_run(run) and _digest_in(run) == run.name:
            try:
                remove(run, f"{RUNS}/{run.name}")
                removed += 1
            except (StoreError, OSError) as error:
                left.append(str(error))
    return removed, left


def _digest_in(run: Path) -> str:
    """The digest of the case that the data of a run have; empty where they cannot be read."""
    with suppress(OSError, ValueError, LookupError, TypeError, RecursionError):
        return str(json.loads(files.content_of(run / DATA / arrays.ROOT))["attributes"]["digest"])
    return ""
