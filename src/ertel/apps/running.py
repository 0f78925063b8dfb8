"""A run from its new directory to the printed report, with progress bars and Ctrl-C."""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ertel.apps import tables
from ertel.apps.exits import FAILED, INTERRUPTED, check_jax, leave, reason_of
from ertel.apps.progress import Watch, interruptible, progress, watch
from ertel.inputs.case_files import check_case
from ertel.model.case import Case
from ertel.model.state import Method
from ertel.model.status import Status
from ertel.results.summary import with_error
from ertel.runs import compiling, drive, store
from ertel.runs.store import CASE, RunStore, StoreError


class _Stopped(Exception):
    """The user asked to stop while the half grid was running."""


def create(directory: Path, case: Case, method: Method | None) -> RunStore:
    """The store of a new run.  Raises StoreError with advice where the directory cannot be taken."""
    try:
        return RunStore.create(directory, case, method)
    except StoreError as error:
        resumable = f", or continue it: ertel resume {directory}" if (directory / CASE).exists() else ""
        raise StoreError(f"{error}; choose another --out{resumable}") from error


def summary_so_far(run: RunStore) -> dict[str, Any]:
    """The summary of a run that has not ended.  Raises StoreError with advice where there is nothing yet."""
    try:
        return run.summary_so_far()
    except StoreError as error:
        raise StoreError(f"{error}; to start it: ertel resume {run.directory}") from error


def half_grid(case: Case) -> Case | None:
    """The case for an error estimate, None where the run has one of its own."""
    return None if case.solver.method == "steady" else check_case(case.on_half_grid())


def finish(run: RunStore, coarse: Case | None, as_json: bool, quiet: bool, method: Method | None = None) -> None:
    """Compute a run from where it stands to its end, report, and exit with a code if it did not come to its end."""
    check_jax()
    compiling.keep_on_disk()
    try:
        summary = _computed(run, coarse, quiet, method)
    except _Stopped:
        leave(INTERRUPTED, f"interrupted before the first step; {_to_continue(run)}")
    except OSError as error:
        leave(FAILED, f"cannot write to {run.directory}: {reason_of(error)}; {_to_continue(run)}")
    report(run, summary, as_json, quiet)
    _conclude(run, summary)


def _computed(run: RunStore, coarse: Case | None, quiet: bool, method: Method | None) -> Mapping[str, Any]:
    """Run under progress bars until the end or Ctrl-C: the summary, with errors if there is a half grid."""
    with interruptible() as stop, progress(quiet) as bars:
        half = _half_grid_summary(coarse, watch(bars, coarse, "half grid", stop)) if coarse else None
        summary = store.run(run, watch(bars, run.case, run.case.name, stop), method)
    if half and half["status"] == summary["status"] == "converged":
        summary = with_error(run.case, summary, half)
        run.finish(summary)
    return summary


def _half_grid_summary(coarse: Case, on_item: Watch) -> Mapping[str, Any]:
    def on_step(step: drive.Step) -> None:
        if not on_item(step):
            raise _Stopped

    return drive.simulate(coarse, on_step).summary


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
