"""`ertel sweep`: a parameter study from its file to the printed table."""

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from ertel.apps import output, running, tables
from ertel.apps.exits import FAILED, bad_input, leave, reason_of
from ertel.apps.interrupts import Stop, interruptible
from ertel.apps.paths import in_shell, shown
from ertel.inputs.studies import Study
from ertel.results.study_result import StudyResult
from ertel.runs.progress import bars
from ertel.runs.studies import DATA, EVERY, PICTURE, TABLE, Part, alone, gather, left_of, run_study, write
from ertel.runs.sweep import Watched, workers_of
from ertel.runs.workers import cores

GOES_ON = "the same command continues"
LISTED = 5  # failed runs that the last line names


@dataclass(frozen=True)
class Engine:
    """Who does the runs.  jobs: processes; None: one for each core.  part: i of n, of a study without a scheduler."""

    jobs: int | None = None
    scheduler: str | None = None
    scheduler_file: Path | None = None
    part: Part = EVERY


def part_of(text: str | None) -> Part:
    """The part "2/8" as numbers.  Raises ValueError for anything else."""
    if text is None:
        return EVERY
    number, slash, parts = text.partition("/")
    if slash and number.isdecimal() and parts.isdecimal() and 1 <= int(number) <= int(parts):
        return int(number), int(parts)
    raise ValueError(f"--part {text}: must be I/N with I from 1 to N, for example 2/8")


def sweep(study: Study, directory: Path, engine: Engine, as_json: bool, quiet: bool) -> None:
    """Do what is left of a study, write and print what all its runs say."""
    running.prepare()
    with interruptible() as stop, ExitStack() as stack:
        if engine.part == EVERY:
            stack.enter_context(alone(directory))
        try:
            said = _run(study, directory, engine, quiet, stop)
            result = gather(study, directory, said)
            if engine.part == EVERY:
                write(result, directory)
        except OSError as error:
            leave(FAILED, f"cannot write to {shown(directory)}: {reason_of(error)}; {GOES_ON}")
    if engine.part == EVERY:
        _report(result, directory, as_json, quiet)
    if stop.code:
        leave(stop.code, f"interrupted; {GOES_ON}")
    _leave_if_failed(said, result, directory, engine.part)


def _run(study: Study, directory: Path, engine: Engine, quiet: bool, stop: Stop) -> Mapping[str, str]:
    """Do what is left; how each run ended that was worked on."""
    left = left_of(study, directory, engine.part)
    if not quiet:
        output.say(f"{len(study.cases)} runs, {len(left)} of them to do{_in_part(engine.part)}")
    if not left:
        return {}
    jobs = min(engine.jobs or cores(), len(left))
    with bad_input():
        stack = ExitStack()
        workers = stack.enter_context(workers_of(jobs, engine.scheduler, engine.scheduler_file))
    with stack, bars(not quiet) as progress:
        watched = Watched(progress, len(left))
        return run_study(study, directory, workers, engine.part, watched.hear, lambda: stop.code > 0, watched.done)


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


def _report(result: StudyResult, directory: Path, as_json: bool, quiet: bool) -> None:
    """Print the study in the form that the user asked for."""
    if as_json:
        output.print_json({"title": result.dataset.attrs["title"], "runs": result.rows()})
    elif not quiet:
        out = tables.console()
        out.print(result.dataset.attrs["title"], style="bold")
        for line in (*result.table_lines(), *result.remarks):
            out.print(line)
        out.print(f"Stored in {shown(directory)}, with {DATA}, {TABLE} and {PICTURE}")
