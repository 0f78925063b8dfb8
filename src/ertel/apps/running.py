"""A run from its new directory to the printed report, with progress bars and signals."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import xarray as xr

from ertel.apps import tables
from ertel.apps.arguments import Report, RunOptions
from ertel.apps.process import Stop, interruptible
from ertel.apps.terminal import BAD_INPUT, FAILED, bad_input, in_shell, leave, print_json, say, shown, writing_to
from ertel.case.case import Case
from ertel.case.status import Status
from ertel.results.summary import comparisons, with_error
from ertel.runs import outlook, store
from ertel.runs.compile import cache_directory, prepare_jax
from ertel.runs.directory import CASE, Taken
from ertel.runs.drive import Recorder, Run, bars, drive, run_of, warm_up, watch
from ertel.runs.files import StoreError
from ertel.runs.result import Result, verdict
from ertel.runs.store import RunStore

# -- commands ---------------------------------------------------------------------------------------------------------


def run(case: Case, directory: Path | None, options: RunOptions) -> None:
    """Run a case in a new directory: that one, or runs/NAME; `prepare_jax` comes first."""
    if not options.quiet:
        say_before(case)
    with within_memory(case):
        course = run_of(case)
        others = _compared(course, options)
        _finish(_create(directory, course), others, options)


def resume(directory: Path, options: RunOptions) -> None:
    """Continue a run, or estimate the error of a finished one; where nothing is left to do, print its summary."""
    run = RunStore.open(directory)
    summary = run.outcome()
    if summary and (not options.error or summary.get("error_estimate")):
        report(run, summary, options)
        return
    prepare_jax()
    with within_memory(run.case):
        _finish(run, _compared(run.run, options), options)


def _compared(course: Run, options: RunOptions) -> Mapping[str, Run]:
    """The runs with which a run is compared for its error.  A grid may have no half grid for them."""
    with bad_input():
        return {part: run_of(other) for part, other in comparisons(course.case).items()} if options.error else {}


def warm_up_all(cases: Sequence[Case]) -> None:
    """Compile ahead for all cases, with a line for each on stderr."""
    if cache_directory() is None:
        leave(BAD_INPUT, "compiled programs cannot be kept without a home directory; set XDG_CACHE_HOME to a directory")
    directory = prepare_jax()
    if directory is None:
        leave(BAD_INPUT, f"compiled programs cannot be kept in {cache_directory()}")
    for number, case in enumerate(cases, start=1):
        say(f"{number}/{len(cases)}  {case.name or case.kind}: compiling")
        with within_memory(case):
            warm_up(case)
    say(f"Compiled programs are in {directory}")


def say_before(case: Case) -> None:
    """Say what follows from a case before it is computed."""
    for sentence in outlook.warnings_of(case):
        say(f"ertel: warning: {sentence}")


# -- directories ------------------------------------------------------------------------------------------------------


def _create(directory: Path | None, course: Run) -> RunStore:
    """The store of a new run.  Raises StoreError with advice if the directory cannot be used."""
    if directory is None:
        return RunStore.create_unused(course.case, Path("runs").absolute(), course)
    try:
        return RunStore.create(directory, course.case, course)
    except Taken as error:
        resumable = f", or continue it: ertel resume {in_shell(directory)}" if (directory / CASE).exists() else ""
        raise StoreError(f"{error}; choose another --out{resumable}") from error
    except StoreError as error:
        raise StoreError(f"{error}; choose another --out") from error


# -- computing --------------------------------------------------------------------------------------------------------


@contextmanager
def within_memory(case: Case) -> Iterator[None]:
    """Warn of a grid that is too large for the memory, and say so if memory ends."""
    there = outlook.memory_available()
    if 0 < there < outlook.memory_needed(case):
        say(f"ertel: warning: {outlook.memory_shortage(case)}")
    try:
        yield
    except Exception as error:
        if not outlook.is_out_of_memory(error):
            raise
        leave(FAILED, f"out of memory: {outlook.memory_shortage(case)}")


def _finish(run: RunStore, others: Mapping[str, Run], options: RunOptions) -> None:
    """Continue a run to its end and report; exit with a code if it did not reach its end."""
    if options.flush is not None:
        run.flush_interval = options.flush
    to_continue = f"to continue: ertel resume {in_shell(run.directory)}{' --error' if others else ''}"
    with interruptible(to_continue) as stop:
        with writing_to(run.directory, to_continue):
            summary = _computed(run, others, options.quiet, stop)
        if summary is None:
            stop.leave()
        report(run, summary, options)
    status = Status(summary["status"])
    if status is Status.INTERRUPTED:
        stop.leave()
    if not status.ok:
        gone = status is Status.FILM_VANISHED
        reason = summary["warnings"][0] if gone else f"{status.value}; {status.advice}"
        leave(FAILED, f"failed: {reason}. Results so far are in {shown(run.directory)}")


def _computed(run: RunStore, others: Mapping[str, Run], quiet: bool, stop: Stop) -> Mapping[str, Any] | None:
    """The summary at the end or at a stop, with errors if other runs are compared; None if those were stopped."""
    with bars(not quiet) as shown_bars, run.alone():
        compared = {}
        for part, course in others.items():
            recorder, bar = Recorder(course), watch(shown_bars, course, f"for the error of the {part}")
            last = drive(course, [recorder, bar, stop, run.asked_to_stop])
            if stop.code or run.asked_to_stop():
                return None
            compared[part] = recorder.result(last).summary
        summary = run.outcome() or store.compute(run, [watch(shown_bars, run.run), stop])
        if not compared or summary["status"] != "converged":
            return summary
        for part, other in compared.items():
            if other["status"] != "converged":
                why = f"the run for the error of the {part} failed: {other['status']}"
                say(f"ertel: warning: no error is estimated: {why}")
                return summary
        summary = with_error(run.case, summary, compared)
        run.finish(summary)
    return summary


# -- reporting --------------------------------------------------------------------------------------------------------


def report(run: RunStore, summary: Mapping[str, Any], options: Report, sigma: Sequence[str] = ()) -> None:
    """Print a summary in the form that the user asked for.  sigma: rms roughness of the surfaces, for the verdict."""
    if options.as_json:
        print_json(summary)
    elif not options.quiet:
        status = Status(summary["status"])
        data = run.dataset() if run.case.roughness else xr.Dataset()  # a summary is shown without data, too
        with bad_input():
            line = verdict(Result(run.case, data, dict(summary), status), *sigma) if status.ok else ""
        figures = "" if status.failed else f"; for figures: ertel plot {in_shell(run.directory)}"
        tables.print_summary(run.case, summary, line, f"Stored in {shown(run.directory)}{figures}")
