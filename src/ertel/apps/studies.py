"""`ertel sweep` and `ertel traction`: studies from their input to the printed table."""

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

from ertel.apps import running, tables
from ertel.apps.process import interruptible
from ertel.apps.terminal import ASKED, FAILED, bad_input, in_shell, leave, print_json, reason_of, say, shown
from ertel.case.case import Case
from ertel.case.derived import newtonian_stress
from ertel.case.status import Status
from ertel.inputs.studies import Study
from ertel.results.study_result import StudyResult
from ertel.runs import traction as curves
from ertel.runs.compile import prepare_jax
from ertel.runs.studies import EVERY, NAME, Part, alone, files_in, gather, left_of, run_study, write_study
from ertel.runs.tasks import Engine as Engine

GOES_ON = "the same command continues"
LISTED = 5  # failed runs that the last line names


def part_of(text: str | None) -> Part:
    """The part "2/8" as numbers.  Raises ValueError for anything else."""
    if text is None:
        return EVERY
    number, slash, parts = text.partition("/")
    if slash and number.isdecimal() and parts.isdecimal() and 1 <= int(number) <= int(parts):
        return int(number), int(parts)
    raise ValueError(f"--part {text}: must be I/N with I from 1 to N, for example 2/8")


def sweep(study: Study, directory: Path, engine: Engine, part: Part, as_json: bool, quiet: bool) -> None:
    """Do what is left of a study, write and print what all its runs say."""
    prepare_jax()
    left = left_of(study.cases, directory, part)
    if not quiet:
        say(f"{len(study.cases)} runs, {len(left)} of them to do{_in_part(part)}")
    with interruptible() as stop, ExitStack() as stack:
        with bad_input():
            workers = stack.enter_context(engine.workers(len(left)))
        if part == EVERY:
            stack.enter_context(alone(directory))
        try:
            said = run_study(study.cases, directory, workers, part, stop, not quiet)
            result = gather(study, directory, said)
            if part == EVERY:
                write_study(result, directory)
        except OSError as error:
            leave(FAILED, f"cannot write to {shown(directory)}: {reason_of(error)}; {GOES_ON}")
    if part == EVERY:
        _report(result, directory, NAME, as_json, quiet)
    if stop.code or len(said) < len(left) or Status.INTERRUPTED.value in said.values():
        leave(stop.code or ASKED, f"interrupted; {GOES_ON}")
    _leave_if_failed(said, result, directory, part)


def _in_part(part: Part) -> str:
    return "" if part == EVERY else f" in part {part[0]} of {part[1]}"


def _leave_if_failed(said: Mapping[str, str], result: StudyResult, directory: Path, part: Part) -> None:
    """Exit with a code where runs failed: in a part those of the part."""
    failed = result.failed
    if part != EVERY:
        failed = [name for name in failed if Path(name).name in said]
    if failed:
        named = ", ".join(failed[:LISTED]) + (" ..." if len(failed) > LISTED else "")
        advice = f"ertel show {in_shell(directory / failed[0])} tells more"
        leave(FAILED, f"{len(failed)} of {result.dataset['status'].size} runs failed: {named}; {advice}")


def traction(
    case: Case, given: Mapping[str, str | None], film: str | None, directory: Path, as_json: bool, quiet: bool
) -> None:
    """Compute what is left of a traction curve, write and print it."""
    with bad_input():
        curve = curves.curve_of(case, given, film)
    if not quiet:
        running.say_before([max(curve.cases, key=newtonian_stress)])
    prepare_jax()
    with running.within_memory(case), interruptible() as stop:
        try:
            found = curves.store_curve(curve, directory, not quiet, stop)
        except OSError as error:
            leave(FAILED, f"cannot write to {shown(directory)}: {reason_of(error)}; {GOES_ON}")
    _report(found, directory, curves.NAME, as_json, quiet)
    if not found.complete:
        leave(stop.code or ASKED, f"interrupted; {GOES_ON}")
    if found.failed:
        places = ", ".join(f"{value:.4g}" for value in found.failed)
        leave(FAILED, f"failed: the film did not converge at {found.axis} = {places}; the other points are there")


def _report(result: StudyResult, directory: Path, name: str, as_json: bool, quiet: bool) -> None:
    """Print a study in the form that the user asked for.  name: of its files."""
    if as_json:
        print_json(result.as_data())
    elif not quiet:
        out = tables.console()
        out.print(result.heading, style="bold")
        for line in result.table_lines():
            out.print(line)
        for remark in result.remarks:
            out.print(f"{remark[0].upper()}{remark[1:]}", style="yellow" if remark.startswith("warning") else None)
        *files, last = files_in(directory, name)
        out.print(f"Stored in {shown(directory)}, with {', '.join(files)} and {last}")
