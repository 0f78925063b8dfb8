"""A run from its new directory to the printed report, with progress bars and Ctrl-C."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ertel.apps import tables
from ertel.apps.exits import FAILED, INTERRUPTED, check_jax, leave, reason_of
from ertel.apps.interrupts import interruptible
from ertel.model.case import Case
from ertel.model.status import Status
from ertel.runs import compiling, store
from ertel.runs.courses import Course
from ertel.runs.drive import Gathering, drive
from ertel.runs.progress import bars, watch
from ertel.runs.store import CASE, RunStore, StoreError
from ertel.runs.warm_up import warm_up


def create(directory: Path, course: Course) -> RunStore:
    """The store of a new run.  Raises StoreError with advice if the directory cannot be used."""
    try:
        return RunStore.create(directory, course.case, course)
    except StoreError as error:
        resumable = f", or continue it: ertel resume {directory}" if (directory / CASE).exists() else ""
        raise StoreError(f"{error}; choose another --out{resumable}") from error


def finish(run: RunStore, others: Mapping[str, Course], as_json: bool, quiet: bool) -> None:
    """Continue a run to its end and report; exit with a code if it did not reach its end."""
    check_jax()
    compiling.start_at_once()
    try:
        summary = _computed(run, others, quiet)
    except OSError as error:
        leave(FAILED, f"cannot write to {run.directory}: {reason_of(error)}; {_to_continue(run)}")
    report(run, summary, as_json, quiet)
    _conclude(run, summary)


def _computed(run: RunStore, others: Mapping[str, Course], quiet: bool) -> Mapping[str, Any]:
    """Run under progress bars until the end or Ctrl-C: the summary, with errors if other runs are compared."""
    with interruptible() as stop, bars(not quiet) as shown:
        compared = {
            part: _summary_of(run, course, [watch(shown, course, f"for the error of the {part}"), stop])
            for part, course in others.items()
        }
        summary = store.compute(run, [watch(shown, run.course), stop])
    if compared and all(one["status"] == "converged" for one in (summary, *compared.values())):
        summary = run.course.with_error(summary, compared)
        run.finish(summary)
    return summary


def _summary_of(run: RunStore, course: Course, observers: list[Any]) -> Mapping[str, Any]:
    gathering = Gathering(course)
    last = drive(course, [gathering, *observers])
    if last.status is Status.INTERRUPTED:
        leave(INTERRUPTED, f"interrupted before the first step; {_to_continue(run)}")
    return gathering.result(last).summary


def warm_up_all(cases: Sequence[Case]) -> None:
    """Compile ahead for all cases, with a line for each on stderr."""
    check_jax()
    compiling.start_at_once()
    for number, case in enumerate(cases, start=1):
        print(f"{number}/{len(cases)}  {case.name or case.kind}: compiling", file=sys.stderr, flush=True)
        warm_up(case)
    print(f"Compiled programs are in {compiling.cache_directory()}", file=sys.stderr)


def summary_so_far(run: RunStore) -> Mapping[str, Any]:
    """The summary of a run, complete or so far.  Raises StoreError with advice if there is none."""
    try:
        return run.summary() or run.summary_so_far()
    except StoreError as error:
        raise StoreError(f"{error}; to start it: ertel resume {run.directory}") from error


def report(run: RunStore, summary: Mapping[str, Any], as_json: bool, quiet: bool) -> None:
    """Print a summary in the form that the user asked for."""
    if as_json:
        sys.stdout.write(store.to_json(summary))
    elif not quiet:
        out = tables.console()
        tables.print_summary(out, run.case, summary)
        out.print(f"Stored in {run.directory}; for figures: ertel plot {run.directory}")


def _conclude(run: RunStore, summary: Mapping[str, Any]) -> None:
    status = Status(summary["status"])
    if status is Status.INTERRUPTED:
        leave(INTERRUPTED, f"interrupted; {_to_continue(run)}")
    if not status.ok:
        leave(FAILED, f"failed: {status.value}; {status.advice}. Results so far are in {run.directory}")


def _to_continue(run: RunStore) -> str:
    return f"to continue: ertel resume {run.directory}"
