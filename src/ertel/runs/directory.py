"""A run directory: made at once under an unused name, held to its case, asked how far it is, and asked to stop.

======================  =========================================================================================
case.toml               the resolved case: `ertel run` of it is the same run again
run.zarr                scalars of every step, maps at chosen times, provenance; `xarray.open_zarr` alone opens it
                        (of a steady contact: scalars of every grid, the maps on the finest one so far)
checkpoint.npz          the state to go on from, and how much of run.zarr belongs to it
summary.json            the outcome
progress.json           how far the run is, for programs that watch it; not part of the data
stop                    made by whoever wants the run to stop
.lock                   empty; the process that computes the run holds a lock on it, see `files.locked`
======================  =========================================================================================

The data are written by `store`.  This module imports no JAX, so that programs that only watch runs stay small.

progress.json::

    {"status": "running", "T": 1.07, "step": 83, "done": 0.43, "seconds": 12.1, "seconds_left": 15.9,
     "written": "2026-11-22T10:15:03+00:00", "process": 4711}

status: as in the summary.  T: time in t0, null for a steady contact.  step: the number of time steps, or of grids.
done: the share of the run, 0 to 1, about.  seconds: since this process took the run over.  seconds_left: an estimate
from the pace so far, null before there is one, among others while programs are compiled.  written: when.  process: a
number on the machine of the run, which is never signalled.  The file is renewed at most once a second and has no
checksum: nothing is computed from it.  A run that was killed leaves "running" behind, until another process takes it
over; the lock tells.
"""

import errno
import json
import os
import re
import shutil
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from itertools import chain, count
from math import inf, isfinite
from os.path import lexists
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args
from uuid import uuid4

from ertel.case.case import Case
from ertel.case.conditions import Kind
from ertel.case.status import Status
from ertel.inputs.case_files import ConfigError, parse_case, read_toml, to_toml
from ertel.results.figures import FIGURES_IN_TIME, FIGURES_STEADY, MADE_BY
from ertel.results.numbers import lines
from ertel.runs import files
from ertel.runs.files import StoreError, content_of, is_locked

if TYPE_CHECKING:  # it brings JAX, which readers do not need
    from ertel.runs.drive import Run

CASE, DATA, CHECKPOINT, SUMMARY = "case.toml", "run.zarr", "checkpoint.npz", "summary.json"
PROGRESS, STOP = "progress.json", "stop"
OCCUPIED = (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR, errno.EISDIR)  # why a directory cannot be moved to a name
RUNS = "runs"  # the directory with the runs of a study, and where `ertel run` puts one
KINDS = "sweep", "traction", "convergence", "fit"  # of studies, by the names of the files with their numbers
DIGEST = re.compile(r"[0-9a-f]{16}")
INTERVAL = 1.0  # s between two versions of progress.json
DEEPEST = 4  # levels of folders that are searched for runs
LARGEST_PROCESS = 2**31  # numbers of processes are below it


class Taken(StoreError):
    """The directory for a new run exists already."""


# -- made -------------------------------------------------------------------------------------------------------------


def numbered(directory: Path) -> Iterator[Path]:
    """NAME, NAME-2, NAME-3, ... in the place of a directory."""
    return (directory.with_name(directory.name + (f"-{n}" if n > 1 else "")) for n in count(1))


def make(directory: Path, case: Case, fill: Callable[[Path], object], others: Iterable[Path] = ()) -> Path:
    """Make a directory with the files of a case and what `fill` writes; if it is taken, the first of the others.

    It is made beside its place and moved there when it is complete.  An empty directory in its place is replaced.
    Raises Taken where there is no place, StoreError where it cannot be written, ValueError where the case cannot.
    """
    text = to_toml(case)
    draft = directory.parent / f".{directory.name}-{uuid4().hex[:8]}"
    try:
        files.replace(draft / CASE, text.encode())
        for name, heights in case.maps.items():
            files.replace(draft / name, heights.to_bytes())
        fill(draft)
        for candidate in chain([directory], others):
            if _moved(draft, candidate):
                return candidate
        raise Taken(f"{directory}: exists already")
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise StoreError(f"{directory}: cannot write there, {reason}") from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _moved(draft: Path, directory: Path) -> bool:
    """Whether a directory got its place: False where something else is there."""
    if directory.exists() and not (directory.is_dir() and not any(directory.iterdir())):
        return False
    try:
        draft.rename(directory)
    except OSError as error:
        if error.errno in OCCUPIED:  # another process has just taken it
            return False
        raise
    files.sync_directory(directory.parent)
    return True


# -- its files --------------------------------------------------------------------------------------------------------

_PARTIAL, _ASKED = r"((\.[0-9a-f]{8})?\.partial)?", rf"stop|\.stop-[0-9a-f]{{8}}|\{files.LOCK}"
_ZARR = rf"(c(/\d+)*|zarr(\.json)?)(\.[0-9a-f]{{32}})?{_PARTIAL}"
_FIGURE = rf"({'|'.join({*FIGURES_IN_TIME, *FIGURES_STEADY})}|interferogram-(mono|two-beam|white)|compared-[^/]+)"
_RUN = (
    rf"(case\.toml|checkpoint\.npz|summary\.json|progress\.json|heights-[0-9a-f]{{16}}\.npy|{_ASKED}){_PARTIAL}|"
    rf"run\.zarr(\.old|\.partial)?/(\w+/)?{_ZARR}|plots/{_FIGURE}\.(png|svg|pdf|gif|webp|mp4)|"
    r"export/(history\.csv|grids\.csv|run\.nc|maps\.pvd|maps_\d+\.vti|profile_[xy](_[\w.-]+)?\.csv)"
)
_STUDY = rf"({'|'.join(KINDS)})"
WRITTEN = re.compile(
    rf"{_RUN}|runs/\.?[0-9a-f]{{16}}(-[0-9a-f]{{8}})?/({_RUN})|"
    rf"(\.{_STUDY}-\w{{8}}/)?{_STUDY}\.(csv|png|zarr/([\w.-]+/)?{_ZARR})"
)


def others_in(directory: Path) -> list[str]:
    """The files in the directory of a run, or of a study, that ertel does not write there.

    Files of other names, and pictures in `plots` without ertel's mark.
    """
    found = [path for path in files.within(directory) if path.is_symlink() or not path.is_dir()]
    return [name for path in found if not _is_written(path, name := path.relative_to(directory).as_posix())]


def _is_written(path: Path, name: str) -> bool:
    with suppress(OSError):
        return bool(WRITTEN.fullmatch(name)) and (path.parent.name != "plots" or MADE_BY.encode() in content_of(path))
    return False


# -- the case ---------------------------------------------------------------------------------------------------------


def read_case(directory: Path) -> Case:
    """The case of a run.  Raises StoreError where its file cannot be read."""
    try:
        return parse_case(read_toml(directory / CASE), directory)
    except ConfigError as error:
        raise StoreError(f"{directory / CASE}: cannot be read as a case ({error}); put the run's own back") from error


# -- the summary ------------------------------------------------------------------------------------------------------


def read_summary(directory: Path) -> dict[str, Any] | None:
    """The summary of a run; None where there is none yet.

    Raises OSError where it cannot be read, Damaged where its checksum or a value that readers count on is wrong.
    """
    path = directory / SUMMARY
    if not lexists(path):
        return None
    with files.reading(path, "it is written again when the run is continued"):
        summary = files.unsealed(content_of(path))
        Status(summary["status"])
        if summary["kind"] not in get_args(Kind):
            raise ValueError(f"kind = {summary['kind']!r} is neither impact nor rolling")
        if not all(isinstance(text, str) for text in (*lines(summary), *summary["warnings"])):
            raise ValueError("a warning is not a text")
    return summary


# -- the file `stop` --------------------------------------------------------------------------------------------------


def ask_to_stop(directory: Path) -> None:
    """Ask the run, or the study, in a directory to stop after its current step or grid, as after Ctrl-C.

    Any machine may ask; the run can be resumed.  Raises OSError where the file cannot be made.
    """
    files.replace(directory / STOP, b"", durable=False)


def is_asked_to_stop(directory: Path) -> bool:
    """Whether the run, or the study, in a directory is asked to stop."""
    return (directory / STOP).is_file()


@contextmanager
def heeding_stop(directory: Path) -> Iterator[None]:
    """Delete the file `stop` after this block, and also before: a file that is left over does not stop a run."""
    _forget_stop(directory)
    try:
        yield
    finally:
        _forget_stop(directory)


def _forget_stop(directory: Path) -> None:
    if is_asked_to_stop(directory):
        (directory / STOP).unlink(missing_ok=True)


# -- the file progress.json -------------------------------------------------------------------------------------------


class ProgressFile:
    """An observer that keeps the progress of a run in its directory.

    A process that was killed left "running" behind, and this one has no result yet: the run is interrupted until then.
    """

    def __init__(self, directory: Path, run: "Run"):
        self._directory, self._run = directory, run
        before = read_progress(directory)
        if before and before["status"] == Status.RUNNING.value:
            write_progress(directory, **{**before, "status": Status.INTERRUPTED.value})
        self._started = time.monotonic()
        self._first: tuple[float, float] | None = None  # time and share done at the first result with a record
        self._written = -INTERVAL

    def __call__(self, result: Any) -> None:
        """Write the progress, unless it was written a moment ago."""
        now = time.monotonic()
        if self._first is None and result.record:
            self._first = now, self._run.progress(result).done
        if result.status is not Status.RUNNING or now - self._written >= INTERVAL:
            self._written = now
            self.write(result)

    def write(self, result: Any) -> None:
        """Write the progress."""
        progress = self._run.progress(result)
        done = 1.0 if result.status.ok else progress.done
        write_progress(
            self._directory,
            status=result.status.value,
            T=progress.T,
            step=progress.step,
            done=round(done, 4),
            seconds=round(time.monotonic() - self._started, 1),
            seconds_left=self._left(result.status, done),
        )

    def _left(self, status: Status, done: float) -> float | None:
        """Seconds to the end at the pace since the first result; compiling came before it."""
        if status is not Status.RUNNING:
            return 0.0 if status.ok else None
        if self._first is None or done <= self._first[1]:
            return None
        then, share = self._first
        return round((time.monotonic() - then) * (1.0 - done) / (done - share), 1)


def write_progress(directory: Path, **content: Any) -> None:
    """Replace the progress of a run, or of a fit; a disk that refuses it stops neither.

    content: as in progress.json, and more of a fit.  When it is written and by which process is added.
    """
    now = {"written": datetime.now(UTC).isoformat(timespec="seconds"), "process": os.getpid()}
    with suppress(OSError):
        files.replace(directory / PROGRESS, (json.dumps({**now, **content}) + "\n").encode(), durable=False)


def read_progress(directory: Path) -> dict[str, Any] | None:
    """The progress of a run; None where there is none or it cannot be read."""
    with suppress(OSError, ValueError, LookupError, TypeError, RecursionError, OverflowError):
        progress: dict[str, Any] = json.loads(content_of(directory / PROGRESS))
        if _is_valid(progress):
            return progress
    return None


def _is_valid(progress: Mapping[str, Any]) -> bool:
    """Whether the values that readers count on have their types and ranges.  Raises many errors where they have not."""
    kinds = {"status": str, "written": str, "step": int, "process": int}
    if not all(type(progress[name]) is kind for name, kind in kinds.items()):
        return False
    numbers = [progress[name] for name in ("step", "process", "T", "done", "seconds", "seconds_left")]
    if not all(isfinite(number) for number in numbers if number is not None):
        return False
    is_process = 0 < progress["process"] < LARGEST_PROCESS
    return is_process and progress["step"] >= 0 and 0.0 <= progress["done"] <= 1.0 and progress["seconds"] >= 0.0


# -- the runs in a folder ---------------------------------------------------------------------------------------------


def find_runs(folder: Path, most_folders: float = inf) -> Iterator[Path]:
    """The run directories in a folder and below it, the nearest first; in a large tree not all.

    A run directory is returned and not searched further.
    """
    waiting, looked = deque([(folder, DEEPEST)]), 0
    while waiting:
        path, levels = waiting.popleft()
        if is_run(path):
            yield path
        elif levels and looked < most_folders:
            looked += 1
            waiting.extend((inside, levels - 1) for inside in folders_in(path))


def folders_in(folder: Path) -> list[Path]:
    """The folders in a folder, by name, without hidden ones and symbolic links; none where it cannot be read."""
    try:
        with os.scandir(folder) as entries:
            return sorted(Path(e.path) for e in entries if e.name[0] != "." and e.is_dir(follow_symlinks=False))
    except OSError:
        return []


def is_run(path: Path) -> bool:
    """Whether a folder has a case and the data of a run, be they readable or not."""
    return lexists(path / CASE) and any(lexists(path / name) for name in (DATA, f"{DATA}.old"))


def status_of(directory: Path, summary: Mapping[str, Any] | None) -> str:
    """The status of a run with this summary; "running", or "unfinished" where no process is computing it."""
    if summary and Status(summary["status"]).ok:
        return str(summary["status"])
    return "running" if is_locked(directory) else summary["status"] if summary else "unfinished"


# -- studies, and how they are deleted ---------------------------------------------------------------------------------


def study_of(run: Path, root: Path) -> Path | None:
    """The directory of the study that has a run, which is named by the digest of its case; None of other runs.

    root: a folder, which is not a study itself.
    """
    study = run.parent.parent
    is_in_study = run.parent.name == RUNS and DIGEST.fullmatch(run.name)
    return study if is_in_study and root in study.parents else None


def kind_of(study: Path) -> str:
    """The kind of a study, one of `KINDS`; empty where it has no numbers yet."""
    return next((kind for kind in KINDS if (study / f"{kind}.zarr").exists()), "")


def remove(place: Path, name: str) -> None:
    """Delete the directory of a run, or of a study with all its runs.  name: in messages.

    It is moved to a hidden name first, so that it is gone as a whole.  Raises StoreError where a process works on it,
    and where it holds files that ertel does not write; OSError where the system refuses.
    """
    if any(is_locked(each) for each in (place, *find_runs(place))):
        raise StoreError(f"{name}: is running; stop it before you delete it")
    if others := others_in(place):
        pictures = any(Path(other).parent.name == "plots" for other in others)
        mark = "; ertel plot DIR --overwrite marks the pictures of an earlier version" if pictures else ""
        raise StoreError(f"{name}: holds other files ({', '.join(sorted(others)[:5])}); move them away first{mark}")
    hidden = place.with_name(f".{place.name}-{uuid4().hex[:8]}")
    with files.locked(place):
        place.rename(hidden)
    shutil.rmtree(hidden)
