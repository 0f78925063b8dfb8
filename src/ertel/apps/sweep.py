"""`ertel sweep`: a parameter study from its file to the printed table."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

from ertel.apps import tables
from ertel.apps.process import interruptible
from ertel.apps.terminal import ASKED, FAILED, bad_input, in_shell, leave, print_json, reason_of, say, shown
from ertel.case.status import Status
from ertel.inputs.studies import Study
from ertel.results.study_result import StudyResult
from ertel.runs.compile import prepare_jax
from ertel.runs.studies import EVERY, Part, alone, gather, left_of, run_study, study_bars, write
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
    left = left_of(study, directory, part)
    if not quiet:
        say(f"{len(study.cases)} runs, {len(left)} of them to do{_in_part(part)}")
    with interruptible() as stop, ExitStack() as stack:
        with bad_input():
            workers = stack.enter_context(engine.workers(len(left)))
        if part == EVERY:
            stack.enter_context(alone(directory))
        try:
            with study_bars(directory, left, not quiet) as shown_bars:
                said = run_study(study, directory, workers, part, stop, shown_bars.done)
            result = gather(study, directory, said)
            files = write(result, directory) if part == EVERY else []
        except OSError as error:
            leave(FAILED, f"cannot write to {shown(directory)}: {reason_of(error)}; {GOES_ON}")
    if files:
        _report(result, directory, files, as_json, quiet)
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


def _report(result: StudyResult, directory: Path, files: Sequence[str], as_json: bool, quiet: bool) -> None:
    """Print the study in the form that the user asked for."""
    if as_json:
        print_json({"title": result.dataset.attrs["title"], "runs": result.rows()})
    elif not quiet:
        out = tables.console()
        out.print(result.dataset.attrs["title"], style="bold")
        for line in (*result.table_lines(), *result.remarks):
            out.print(line)
        out.print(f"Stored in {shown(directory)}, with {', '.join(files[:-1])} and {files[-1]}")
