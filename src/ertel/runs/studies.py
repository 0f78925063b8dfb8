"""The directory of a study, and its runs on workers.

======================  =========================================================================================
runs/DIGEST             an ordinary run directory for each case, named by the digest of the case
sweep.zarr              the numbers of all runs over what varies; `xarray.open_zarr` alone opens it
sweep.csv               the same as a table
sweep.png               and as a figure
stop                    made by whoever wants the study to stop, see `directory`
.lock                   empty; the process at the study holds a lock on it, see `files.locked`
======================  =========================================================================================

Nothing else is remembered: what is missing or unfinished in runs/ is done, so that a study can be stopped, killed,
edited and started again.  Runs that the study no longer has are left alone.
"""

import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from ertel.case.case import Case
from ertel.inputs.coordinates import coordinates
from ertel.inputs.studies import Study
from ertel.results.study_result import StudyResult
from ertel.results.study_runs import MISSING, RUNNING, UNFINISHED, Ran, assemble
from ertel.runs.directory import heeding_stop, is_asked_to_stop
from ertel.runs.files import StoreError, is_locked, locked
from ertel.runs.store import CASE, RunStore
from ertel.runs.study_jobs import job_of
from ertel.runs.workers import Asked, Failure, Hear, Workers, deaf, never

RUNS, DATA, TABLE, PICTURE = "runs", "sweep.zarr", "sweep.csv", "sweep.png"
FAILED = "failed: "  # how the status of a run begins that raised an exception
EVERY = (1, 1)  # the part that is all of it

Part = tuple[int, int]  # i of n
OnDone = Callable[[str, str], object]  # takes the digest and the status of a run


def run_directory(directory: Path, case: Case) -> Path:
    """The directory of the run of a case."""
    return directory / RUNS / case.digest


def left_of(study: Study, directory: Path, part: Part = EVERY) -> dict[str, Case]:
    """The cases of a part whose runs are missing or unfinished, each once, by digest: cases i, i + n, i + 2n, ..."""
    number, parts = part
    every = {case.digest: case for case in study.cases}
    own = dict(list(every.items())[number - 1 :: parts])
    return {digest: case for digest, case in own.items() if not _is_done(run_directory(directory, case))}


def _is_done(directory: Path) -> bool:
    if not (directory / CASE).exists():
        return False
    try:
        return RunStore.open(directory).outcome() is not None
    except (StoreError, OSError):
        return False


def run_study(
    study: Study,
    directory: Path,
    workers: Workers,
    part: Part = EVERY,
    hear: Hear = deaf,
    asked: Asked = never,
    on_done: OnDone = lambda digest, status: None,
) -> dict[str, str]:
    """Do what is left of a part; the status of each run that was worked on, by digest, or why it failed.

    hear, asked: see `workers.Workers`; a file in the directory asks too, see `directory`.  Raises OSError where the
    directory cannot be made.
    """
    left = left_of(study, directory, part)
    (directory / RUNS).mkdir(parents=True, exist_ok=True)
    jobs = [job_of(run_directory(directory, case), case) for case in left.values()]
    found = {}
    with heeding_stop(directory):
        for digest, outcome in workers.outcomes(jobs, hear, lambda: asked() or is_asked_to_stop(directory)):
            found[digest] = f"{FAILED}{outcome.reason}" if isinstance(outcome, Failure) else str(outcome)
            on_done(digest, found[digest])
    return found


def gather(study: Study, directory: Path, said: Mapping[str, str] | None = None) -> StudyResult:
    """The numbers of all runs as they are on the disk.  said: why runs failed, from `run_study`."""
    runs = [_ran(case, directory, said or {}) for case in study.cases]
    data = assemble(study.name, study.mode, study.shape, coordinates(study), runs)
    return StudyResult(data, directory)


def _ran(case: Case, directory: Path, said: Mapping[str, str]) -> Ran:
    """A run as it is on the disk."""
    place = run_directory(directory, case)
    status, summary = said.get(case.digest, ""), None
    try:
        if not status.startswith(FAILED):
            summary = RunStore.open(place).summary() if (place / CASE).exists() else None
            status = summary["status"] if summary else _standing(place)
    except (StoreError, OSError) as error:
        status = f"{FAILED}{error}"
    return Ran(case, summary, status, str(place.relative_to(directory)))


def _standing(place: Path) -> str:
    """The status of a run without a summary."""
    if not place.exists():
        return MISSING
    return RUNNING if is_locked(place) else UNFINISHED


def write(result: StudyResult, directory: Path) -> list[str]:
    """Write what all runs say into the directory of the study; the names of what is there now.

    There is no figure before a run has numbers to draw.
    """
    from ertel.plots.drawing import NoFigure  # here, so that workers need no matplotlib

    draft = directory / f".{DATA}-{uuid4().hex[:8]}"
    try:
        result.dataset.to_zarr(draft, mode="w", consolidated=False)
        shutil.rmtree(directory / DATA, ignore_errors=True)
        draft.rename(directory / DATA)
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    result.to_csv(directory / TABLE)
    (directory / PICTURE).unlink(missing_ok=True)
    with suppress(NoFigure):
        result.plot().savefig(directory / PICTURE)
    return [name for name in (DATA, TABLE, PICTURE) if (directory / name).exists()]


@contextmanager
def alone(directory: Path) -> Iterator[None]:
    """Keep other processes from this study as a whole.  Raises StoreError where one is at it."""
    directory.mkdir(parents=True, exist_ok=True)
    with locked(directory):
        yield
