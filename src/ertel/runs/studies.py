"""Parameter studies: the runs of all cases of a study in one directory, on workers, and their numbers.

    ertel.sweep("speeds.toml", "sweeps/speeds", jobs=2)

======================  =========================================================================================
runs/DIGEST             an ordinary run directory for each case, named by the digest of the case
sweep.zarr              the numbers of all runs over what varies; `xarray.open_zarr` alone opens it
sweep.csv               the same as a table
sweep.png               and as a figure
stop                    made by whoever wants the study to stop, see `directory`
.lock                   empty; the process at the study holds a lock on it, see `files.locked`
======================  =========================================================================================

Nothing else is remembered: what is missing or unfinished in runs/ is done, so that a study can be stopped, killed,
edited and started again.  Runs that the study no longer has stay, until `store.prune` deletes them.
"""

import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, TypeVar, cast
from uuid import uuid4

from ertel.case.case import Case
from ertel.case.height_map import HeightMap
from ertel.case.status import Status
from ertel.inputs.case_files import CaseLike, as_case
from ertel.inputs.studies import Study, convergence_series, coordinates, load_study, parse_study
from ertel.numerics.programs import double_precision
from ertel.results.convergence import with_limits
from ertel.results.numbers import scalars
from ertel.results.study_table import MISSING, StudyRun, grouped, study_dataset
from ertel.runs.compile import check_jax
from ertel.runs.directory import (
    CASE,
    PROGRESS,
    RUNS,
    STOP,
    Taken,
    heeding_stop,
    is_asked_to_stop,
    read_progress,
    status_of,
)  # fmt: skip
from ertel.runs.drive import bars
from ertel.runs.engine import Engine
from ertel.runs.files import NUMBERED, NotDrawn, StoreError, delete, locked, require_no_links
from ertel.runs.store import RunStore, compute
from ertel.runs.study_result import ConvergenceResult, StudyResult
from ertel.runs.workers import Condition, Failure, StopSignal, Task, Workers, never

NAME, ENDINGS = "sweep", ("zarr", "csv", "png")  # of the files with the numbers
FAILED = "failed: "  # how the status of a run begins that raised an exception
EVERY = (1, 1)  # the part that is all of it

Part = tuple[int, int]  # i of n
AnyStudy = TypeVar("AnyStudy", bound=StudyResult)


def sweep(
    study: str | Path | Mapping[str, Any],
    directory: str | Path,
    *,
    overrides: Sequence[str] = (),
    jobs: int | None = 1,
    scheduler: str | None = None,
    progress: bool = False,
) -> StudyResult:
    """Run all cases of a parameter study that are not there yet, and gather their numbers.

    Parameters
    ----------
    study : str, Path or mapping
        A case file, or plain data of the same layout, in which a list or a range, "FIRST:LAST:NUMBER", may stand
        for any value; [sweep] mode is "product" or "zip".  See `ertel.inputs.studies`.
    directory : str or Path
        Of the study: made if it is not there.  Its runs are ordinary run directories, runs/DIGEST of the case.  What
        is missing or unfinished is done, and nothing else is remembered.
    overrides : sequence of str
        Values of the case, "contact.M=[100, 200]".
    jobs : int
        Number of processes on this machine, with one thread each; None: one for each core.  1: this process, with all
        cores.  A script that asks for more must begin its work below `if __name__ == "__main__":`, because they
        import it.
    scheduler : str
        Address of a scheduler of dask.distributed that runs: its workers do the runs.  Whoever reaches it can run
        programs as you, unless it is at tls://; its certificates are those of dask's configuration.
    progress : bool
        Whether to show a progress bar; in a file, a line a minute.

    Returns
    -------
    StudyResult
        It shows itself as a table; `dataset`, `plot()`, `to_csv(path)`.  They are also in the directory.  A run that
        failed is a row with its reason.

    Raises
    ------
    ConfigError
        A value is not allowed; the message names the field, its value and what is allowed.
    StoreError
        Another process is working on the study, or the directory holds other files.
    """
    planned = parse_study(study) if isinstance(study, Mapping) else load_study(study, overrides)
    return _do(planned, directory, Engine(jobs, scheduler), progress)


def converge(
    case: CaseLike,
    directory: str | Path | None = None,
    *,
    grids: int = 3,
    along: Literal["grid", "time"] = "grid",
    jobs: int | None = 1,
    scheduler: str | None = None,
    progress: bool = False,
) -> ConvergenceResult:
    """Run a case on several grids: the observed order of its numbers, their extrapolated values and errors.

    Parameters
    ----------
    case : Case, str, Path or mapping
        Its grid is the finest one.
    directory : str or Path, optional
        Of the series, a study as that of `sweep`: what is missing or unfinished in it is done.  Left out, no run is
        kept.
    grids : int
        How many, 3 to 6; each has the double spacing of the next.
    along : "grid" or "time"
        A run in time halves its steps, too, from grid to grid; the coarsest has those of the case (a tolerance goes as
        the third power of the step).  "time" halves the steps alone.
    jobs, scheduler
        Who does the runs, as in `sweep`.
    progress : bool
        Whether to show a progress bar.

    Returns
    -------
    ConvergenceResult
        It shows itself as a table; `limits`, `dataset`, `plot()`, `to_csv(path)`.  The domain is that of the case.

    Raises
    ------
    ConfigError
        The case is steady and `along` is "time", its grid has no half grids, or an argument is not allowed.
    StoreError
        Another process is working on the series, or the directory holds other files.
    """
    series, engine = convergence_series(as_case(case), grids, along), Engine(jobs, scheduler)
    return cast(ConvergenceResult, _do(series, directory, engine, progress))


def _do(study: Study, directory: str | Path | None, engine: Engine, progress: bool) -> StudyResult:
    """Do what is left of a study, gather its numbers and write them."""
    check_jax()

    def do(path: Path) -> StudyResult:
        with engine.workers(len(left_of(study.cases, path))) as workers, alone(path):
            result = gather(study, path, run_study(study.cases, path, workers, progress=progress))
            write_study(result, path, study.purpose)
        return result

    return in_directory(directory, study.purpose, do)


# -- runs -------------------------------------------------------------------------------------------------------------


def run_directory(directory: Path, case: Case) -> Path:
    """The directory of the run of a case."""
    return directory / RUNS / case.digest


def left_of(cases: Sequence[Case], directory: Path, part: Part = EVERY) -> dict[str, Case]:
    """The cases of a part whose runs are missing or unfinished, each once, by digest: cases i, i + n, i + 2n, ..."""
    number, parts = part
    every = {case.digest: case for case in cases}
    chosen = dict(list(every.items())[number - 1 :: parts])
    return {digest: case for digest, case in chosen.items() if not _is_done(run_directory(directory, case))}


def _is_done(directory: Path) -> bool:
    with suppress(StoreError, OSError):
        return (directory / CASE).exists() and RunStore.open(directory).outcome() is not None
    return False


def require_place(directory: str | Path, name: str = NAME, option: str = "directory") -> Path:
    """The absolute path of a directory for a study; that of an earlier one may hold other files as well.

    name: of the files of the study.  Raises Taken, naming the option, where it would overwrite files or be mixed with.
    """
    place = Path(directory).absolute()
    visible = {path.name for path in place.glob("[!.]*")}
    own = {RUNS, STOP, PROGRESS, *(f"{name}.{ending}" for ending in ENDINGS)}
    written = {NUMBERED.sub("", file) for file in visible}  # a process may have been killed while it wrote one
    is_own = f"{name}.zarr" in visible or (RUNS in visible and written <= own)
    if visible and not is_own:
        some = ", ".join(sorted(visible)[:5])
        earlier = {NAME: "study", "traction": "curve", "convergence": "series"}.get(name, name)
        allowed = f"give a new or empty directory, or that of an earlier {earlier}"
        raise Taken(f"{option} {place}: holds other files ({some}); {allowed}")
    return place


def in_directory(directory: str | Path | None, name: str, do: Callable[[Path], AnyStudy]) -> AnyStudy:
    """Return what `do` gives for the directory of a study, or for a temporary one, deleted afterwards.

    name: as in `require_place`.
    """
    if directory is not None:
        return do(require_place(directory, name))
    with TemporaryDirectory(prefix=f"ertel-{name}-") as place:
        result = do(Path(place))
    if "directory" in result.dataset:
        result.dataset["directory"][...] = ""
    return replace(result, directory=None)


@contextmanager
def alone(directory: Path) -> Iterator[None]:
    """Keep other processes from this study as a whole, and heed a file `stop` up to the end of this block.

    The folder of its runs is made first: by it the directory of a killed process is known (`require_place`).  Raises
    StoreError where another process is working on it, or its runs would be written elsewhere.
    """
    require_no_links([directory / RUNS])
    (directory / RUNS).mkdir(parents=True, exist_ok=True)
    with locked(directory), heeding_stop(directory):
        yield


def run_study(
    cases: Sequence[Case],
    directory: Path,
    workers: Workers,
    part: Part = EVERY,
    asked: Condition = never,
    progress: bool = False,
) -> dict[str, str]:
    """Do what is left of a part; the status of each run that was worked on, by digest, or why it failed.

    asked: whether all should stop, asked again and again; a file in the directory asks too, and whoever calls deletes
    it, see `alone`.  progress: whether to show progress bars.  Raises OSError where the directory cannot be made,
    StoreError where its runs would be written elsewhere.
    """
    require_no_links([directory / RUNS, *(run_directory(directory, case) for case in cases)])
    (directory / RUNS).mkdir(parents=True, exist_ok=True)
    file = directory / f".stop-{uuid4().hex[:8]}"  # of this call only: other parts of the study go on
    statuses = {}
    with bars(progress) as shown:
        left = left_of(cases, directory, part)
        study_bars = StudyBars(shown, directory, left)

        def should_stop() -> bool:
            study_bars.renew()
            return asked() or is_asked_to_stop(directory)

        stop = StopSignal(file, should_stop)
        try:
            places = {digest: str(run_directory(directory, case)) for digest, case in left.items()}
            tasks = [Task(n, run_case, (places[n], case.to_data(), case.maps, stop)) for n, case in left.items()]
            for digest, outcome in workers.outcomes(tasks, stop):
                status = f"{FAILED}{outcome.reason}" if isinstance(outcome, Failure) else str(outcome)
                statuses[digest] = status
                study_bars.done(digest, status)
        finally:
            file.unlink(missing_ok=True)
    return statuses


@double_precision()
def run_case(directory: str, data: Mapping[str, Any], maps: Mapping[str, HeightMap], stop: Condition) -> str:
    """Begin or continue the run of a case in a directory, on whichever worker takes it; its status.

    data, maps: of the case, see `Case.from_data`.  Raises StoreError where the directory holds something else or
    another process is computing the run.
    """
    if stop():
        return Status.INTERRUPTED.value
    store = _store(Path(directory), Case.from_data(data, maps))
    return str(compute(store, [lambda item: stop()])["status"])


def _store(directory: Path, case: Case) -> RunStore:
    if not (directory / CASE).exists():
        with suppress(Taken):  # by another process, just now
            return RunStore.create(directory, case)
    return RunStore.open(directory)


# -- progress ---------------------------------------------------------------------------------------------------------

LOOK = 0.5  # s between looks at what the runs say of their progress
IN_SIGHT = 100  # runs that may be computed now, next in the study


class StudyBars:
    """A bar for all runs that are left, and one for each that is computed now, as its progress.json says."""

    def __init__(self, progress: Any, directory: Path, left: Mapping[str, Case]):
        self._progress = progress
        self._all = progress.add_task("runs", total=len(left), message="")
        self._directories = {digest: run_directory(directory, case) for digest, case in left.items()}
        self._bars: dict[str, Any] = {}
        self._renewed = 0.0

    def renew(self) -> None:
        """Renew the bars, unless they were renewed a moment ago."""
        if self._progress.disable or time.monotonic() - self._renewed < LOOK:
            return
        self._renewed = time.monotonic()
        for digest, directory in islice(self._directories.items(), IN_SIGHT):
            run = read_progress(directory)
            if run is None or run["status"] != Status.RUNNING.value:
                continue
            if digest not in self._bars:
                self._bars[digest] = self._progress.add_task(digest[:8], total=1.0, message="")
            now = "" if run["T"] is None else f"T {run['T']:.3f}  "
            self._progress.update(self._bars[digest], completed=run["done"], message=f"{now}step {run['step']}")

    def done(self, digest: str, status: str) -> None:
        """Count a run that is done."""
        self._directories.pop(digest, None)
        if digest in self._bars:
            self._progress.remove_task(self._bars.pop(digest))
        self._progress.update(self._all, advance=1, message=f"{digest[:8]} {status}"[:60])


# -- numbers ----------------------------------------------------------------------------------------------------------


def gather(study: Study, directory: Path, statuses: Mapping[str, str] | None = None) -> StudyResult:
    """The numbers of all runs as they are on the disk.  statuses: of `run_study`, which say why runs failed."""
    runs = [study_run(case, directory, statuses or {}) for case in study.cases]
    about: dict[str, Any] = {"title": study.name, "kind": study.cases[0].kind}
    warnings = grouped(((run.directory, each) for run in runs for each in run.warnings), "run")
    about |= {"warnings": warnings} if warnings else {}
    data = study_dataset(study.mode, coordinates(study), runs, about)
    if study.purpose == "convergence":
        return ConvergenceResult(with_limits(data), directory)
    return StudyResult(data, directory)


def study_run(case: Case, directory: Path, statuses: Mapping[str, str]) -> StudyRun:
    """A run as it is on the disk.  statuses: see `gather`."""
    path = run_directory(directory, case)
    status, summary = statuses.get(case.digest, ""), None
    try:
        if not status.startswith(FAILED):
            summary = RunStore.open(path).summary() if (path / CASE).exists() else None
            status = status_of(path, summary) if path.exists() else MISSING
    except (StoreError, OSError) as error:
        status = f"{FAILED}{error}"
    numbers, warnings = (scalars(summary), summary["warnings"]) if summary else ({}, [])
    return StudyRun(numbers, warnings, status, str(path.relative_to(directory)))


def files_in(directory: Path, name: str = NAME) -> list[str]:
    """The names of the files with the numbers of a study; there is no figure before a run has numbers to draw."""
    return [file for ending in ENDINGS if (directory / (file := f"{name}.{ending}")).exists()]


def write_study(result: StudyResult, directory: Path, name: str = NAME) -> None:
    """Write the numbers of all runs into the directory of the study, then draw them.

    Issues a `NotDrawn` where they cannot be drawn, for want of a font or of space perhaps.
    """
    with TemporaryDirectory(prefix=f".{name}-", dir=directory) as place:
        drafts = data, table, picture = [Path(place) / f"{name}.{ending}" for ending in ENDINGS]
        result.dataset.to_zarr(data, mode="w", consolidated=False)
        result.to_csv(table)
        for draft in drafts:
            delete(directory / draft.name)  # also a link, which is not followed
        data.rename(directory / data.name)
        table.rename(directory / table.name)
        try:
            from ertel.plots.drawing import NoFigure  # here, so that workers need no matplotlib

            with suppress(NoFigure):
                result.plot().savefig(picture)
                picture.rename(directory / picture.name)
        except Exception as error:  # of matplotlib, of the system
            text = f"{directory / picture.name} is not drawn ({error}); the numbers are written"
            warnings.warn(NotDrawn(text), stacklevel=2)
