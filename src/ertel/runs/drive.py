"""The loop over a run, with observers, and a run in memory.

    drive(course_of(case), [observer, ...])

An observer sees every accepted time step, or every grid of a steady contact.  The store, the progress bar and the
Ctrl-C handler are observers; one that returns True asks for a stop.
"""

import time as clock
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ertel.case.status import Status
from ertel.inputs.case_files import CaseLike, as_case
from ertel.numerics.programs import double_precision
from ertel.results.result import Result
from ertel.results.summary import attributes
from ertel.runs.compile import check_jax, compilations
from ertel.runs.courses import Run, StepResult, course_of
from ertel.runs.outlook import warnings_of, with_case_warnings
from ertel.runs.stepping import Frame

Observer = Callable[[Any], object]


def drive(run: Run, observers: Sequence[Observer] = (), result: Any = None) -> Any:
    """Advance a run to its end, or until an observer asks for a stop; the last result.

    result: from which the run goes on, None for its start.  A run that gives up ends with a result that has the reason
    as its status and no record.
    """
    result = run.begin() if result is None else result
    if result.status is not Status.RUNNING:
        _show(result, observers)
    while result.status is Status.RUNNING:
        result = run.advance(result)
        if _show(result, observers) and result.status is Status.RUNNING:
            return replace(result, status=Status.INTERRUPTED)
    return result


def _show(result: StepResult, observers: Sequence[Observer]) -> bool:
    """Whether any observer asks for a stop."""
    return any([observer(result) is True for observer in observers])


class Recorder:
    """An observer that keeps the scalars and the maps of a run in memory."""

    def __init__(self, run: Run):
        self.run = run
        self._started, self._compiled = clock.monotonic(), compilations()
        self.records: list[Mapping[str, float]] = []
        self.frames: list[Frame] = []

    def __call__(self, result: StepResult) -> None:
        if result.record:
            self.records.append(result.record)
        self.frames.extend(result.frames)

    def result(self, last: Any) -> Result:
        """The result of the run, from its last step."""
        data = self.run.dataset(self.records, self.frames, last)
        work = {"compilations": compilations() - self._compiled, "wall_s": clock.monotonic() - self._started}
        summary = with_case_warnings(self.run.case, self.run.summary(data, last, last.status, work))
        return Result(self.run.case, data.assign_attrs(attributes(summary)), summary, Status(summary["status"]))


@double_precision()
def simulate(case: CaseLike, progress: bool = False, observers: Sequence[Observer] = ()) -> Result:
    """Run a case from start to end in memory.

    Parameters
    ----------
    case : Case, str, Path or mapping
        From `impact` or `rolling`; or a case file, or its plain data, as for `load_case` and `parse_case`.
    progress : bool
        Whether to show a progress bar.
    observers : sequence of callables
        Each sees every accepted time step, or every grid of a steady contact; one that returns True stops the run.

    Returns
    -------
    Result
        Its `status` says how the run ended; warnings about grid, domain, oil and inlet are also issued as Python
        warnings, before the run where the case alone tells them.

    Raises
    ------
    ConfigError
        The case is anything else than a case; the message names the argument or the field.
    """
    case = as_case(case)
    before = warnings_of(case)
    warn(before)  # of the caller of this function, which is decorated
    check_jax()
    run = course_of(case)
    recorder = Recorder(run)
    with bars(progress) as shown:
        last = drive(run, [recorder, watch(shown, run), *observers])
    result = recorder.result(last)
    warn([sentence for sentence in result.warnings if sentence not in before])
    return result


def warn(sentences: Sequence[str], frames: int = 2) -> None:
    """Issue sentences about a run as Python warnings of the line so many frames above the caller's."""
    for sentence in sentences:
        warnings.warn(sentence, stacklevel=2 + frames)


# -- progress bars ----------------------------------------------------------------------------------------------------


def bars(shown: bool) -> Any:
    """Bars on stderr (a `rich.progress.Progress`); none if stderr is not a terminal or they are not wanted."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    label, message = (TextColumn(text, markup=False) for text in ("{task.description}", "{task.fields[message]}"))
    hidden = not shown or not (console.is_terminal or console.is_jupyter)
    return Progress(label, BarColumn(24), message, TimeElapsedColumn(), console=console, disable=hidden)


def watch(progress: Any, run: Run, label: str = "") -> Observer:
    """An observer that shows a run in a new bar."""
    label = label or run.case.name or run.case.kind
    bar = progress.add_task(label, total=1.0, message="compiling (once per machine and grid size)")

    def show(result: StepResult) -> None:
        if result.record:
            now = run.progress(result)
            progress.update(bar, completed=now.done, message=now.message)

    return show
