"""`ertel sweep`, `converge`, `traction` and `fit`: studies from their input to the printed table."""

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

from ertel.apps import running
from ertel.apps.arguments import Report
from ertel.apps.process import interruptible
from ertel.apps.terminal import FAILED, capital, in_shell, leave, print_json, print_text, say, shown, writing_to
from ertel.case.case import Case
from ertel.case.estimates import newtonian_stress
from ertel.case.records import ConfigError
from ertel.case.status import Status
from ertel.inputs.quantities import Given
from ertel.inputs.studies import Study
from ertel.results.numbers import aligned
from ertel.results.study_table import counted
from ertel.runs import fit as fits
from ertel.runs import studies as stored
from ertel.runs import traction as curves
from ertel.runs.compile import prepare_jax
from ertel.runs.directory import heeding_stop
from ertel.runs.engine import Engine as Engine
from ertel.runs.fit_problem import FitProblem
from ertel.runs.store import prune as pruned
from ertel.runs.study_result import StudyResult

GOES_ON = "the same command continues"
LISTED = 5  # failed runs that the last line names


def part_of(text: str | None) -> stored.Part:
    """The part "2/8" as numbers.  Raises ConfigError for anything else."""
    if text is None:
        return stored.EVERY
    number, slash, parts = text.partition("/")
    if slash and number.isdecimal() and parts.isdecimal() and 1 <= int(number) <= int(parts):
        return int(number), int(parts)
    raise ConfigError(f"--part {text}: must be I/N with I from 1 to N, for example 2/8")


def sweep(
    study: Study, directory: Path, engine: Engine, part: stored.Part, options: Report, prune: bool = False
) -> None:
    """Do what is left of a study, write and print what all its runs say.

    prune: delete the runs that the study no longer has.
    """
    if prune and part != stored.EVERY:
        raise ConfigError("--prune: is for the whole study; leave out --part")
    stored.require_place(directory, study.purpose, "--out")
    prepare_jax()
    left = stored.left_of(study.cases, directory, part)
    if not options.quiet:
        in_part = "" if part == stored.EVERY else f" in part {part[0]} of {part[1]}"
        say(f"{counted(len(study.cases), 'run')}, {len(left)} of them to do{in_part}")
    with interruptible(GOES_ON) as stop, ExitStack() as stack:
        workers = stack.enter_context(engine.workers(len(left)))
        stack.enter_context(stored.alone(directory) if part == stored.EVERY else heeding_stop(directory))
        with writing_to(directory, GOES_ON):
            statuses = stored.run_study(study.cases, directory, workers, part, stop, not options.quiet)
            result = stored.gather(study, directory, statuses)
            if part == stored.EVERY:
                stored.write_study(result, directory, study.purpose)
            if prune:
                removed, stayed = pruned(directory, [case.digest for case in study.cases])
                said = [] if options.quiet else [f"deleted runs that the study no longer has: {removed}"]
                for line in (*said, *(f"ertel: warning: {reason}" for reason in stayed)):
                    say(line)
    if part == stored.EVERY:
        _report(result, directory, study.purpose, options)
    if stop.code or len(statuses) < len(left) or Status.INTERRUPTED.value in statuses.values():
        stop.leave()
    failed = [name for name in result.failed if part == stored.EVERY or Path(name).name in statuses]
    if failed:
        named = ", ".join(failed[:LISTED]) + (" ..." if len(failed) > LISTED else "")
        advice = f"ertel show {in_shell(directory / failed[0])} tells more"
        leave(FAILED, f"{len(failed)} of {result.dataset['status'].size} runs failed: {named}; {advice}")


def traction(case: Case, given: Mapping[str, Given | None], film: str | None, directory: Path, options: Report) -> None:
    """Compute what is left of a traction curve, write and print it."""
    curve = curves.curve_of(case, given, film)
    stored.require_place(directory, curves.NAME, "--out")
    if not options.quiet:
        running.say_before(max(curve.cases, key=newtonian_stress))
    prepare_jax()
    with running.within_memory(case), interruptible(GOES_ON) as stop, writing_to(directory, GOES_ON):
        result = curves.store_curve(curve, directory, not options.quiet, stop)
    _report(result, directory, curves.NAME, options)
    if not result.complete:
        stop.leave()
    if result.failed:
        values = ", ".join(f"{value:.4g}" for value in result.failed)
        leave(FAILED, f"failed: the film did not converge at {result.axis} = {values}; the other points are there")


def fit(problem: FitProblem, directory: Path, engine: Engine, options: Report, keep: fits.Keep = "best") -> None:
    """Do what is left of a fit, write and print it.  keep: the runs that stay, see `ertel.fit`."""
    stored.require_place(directory, fits.NAME, "--out")
    prepare_jax()
    with interruptible(GOES_ON) as stop, writing_to(directory, GOES_ON):
        try:
            result = fits.store_fit(problem, directory, engine, stop, not options.quiet, keep)
        except fits.StoppedFit:
            stop.leave()
        except fits.FitError as error:
            leave(FAILED, str(error))
    _report(result, directory, fits.NAME, options)


def _report(result: StudyResult, directory: Path, name: str, options: Report) -> None:
    """Print a study in the form that the user asked for.  name: of its files."""
    if options.as_json:
        print_json(result.as_data())
    elif not options.quiet:
        print_text(result.heading, bold=True)
        for line in aligned(result.table()):
            print_text(line)
        for remark in result.remarks:
            print_text(capital(remark), fg="yellow" if remark.startswith("warning") else None)
        *files, last = stored.files_in(directory, name)
        print_text(f"Stored in {shown(directory)}, with {', '.join(files)} and {last}")
