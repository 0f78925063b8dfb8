"""The loop over a run, with observers, and a run in memory.

    drive(course_of(case), [observer, ...])

An observer sees every accepted time step, or every grid of a steady contact.  The store, the progress bar and the ear
for Ctrl-C are observers; one that returns True asks for a stop.
"""

import time as clock
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ertel.case.status import Status
from ertel.equations.state import solved
from ertel.inputs.case_files import CaseLike, as_case
from ertel.numerics.precision import double_precision
from ertel.results.result import Result
from ertel.results.summary import attributes
from ertel.runs import beforehand
from ertel.runs.beforehand import with_these
from ertel.runs.compile import check_jax, compilations
from ertel.runs.courses import Course, Item, course_of
from ertel.runs.progress import progress_bar
from ertel.runs.stepping import Frame

Observer = Callable[[Any], object]


def drive(course: Course, observers: Sequence[Observer] = (), item: Any = None) -> Any:
    """Run a course to its end, or until an observer asks for a stop; the last item.

    item: where the run stands, None for its start.  A run that gives up ends with an item that has the reason as its
    status and no record.
    """
    item = course.begin() if item is None else item
    if item.status is not Status.RUNNING:
        _show(item, observers)
    while item.status is Status.RUNNING:
        item = solved(course.following(item), course.solve)
        if _show(item, observers) and item.status is Status.RUNNING:
            return replace(item, status=Status.INTERRUPTED)
    return item


def _show(item: Item, observers: Sequence[Observer]) -> bool:
    """Whether any observer asks for a stop."""
    return any([observer(item) is True for observer in observers])


class Gathering:
    """An observer that keeps the scalars and the maps of a run in memory."""

    def __init__(self, course: Course):
        self.course = course
        self._started, self._compiled = clock.monotonic(), compilations()
        self.records: list[Mapping[str, float]] = []
        self.frames: list[Frame] = []

    def __call__(self, item: Item) -> None:
        if item.record:
            self.records.append(item.record)
        self.frames.extend(item.frames)

    def result(self, last: Any) -> Result:
        """The result of the run, from its last item."""
        data = self.course.dataset(self.records, self.frames, last)
        work = {"compilations": compilations() - self._compiled, "wall_s": clock.monotonic() - self._started}
        summary = with_these(self.course.case, self.course.summary(data, last, last.status, work))
        return Result(self.course.case, data.assign_attrs(attributes(summary)), summary, Status(summary["status"]))


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

    Raises ConfigError for anything else than a case, naming the argument or the field.
    """
    case = as_case(case)
    before = beforehand.warnings_of(case)
    warn(before)  # of the caller of this function, which is decorated
    check_jax()
    course = course_of(case)
    gathering = Gathering(course)
    with progress_bar(course, progress) as shown:
        last = drive(course, [gathering, *shown, *observers])
    result = gathering.result(last)
    warn([sentence for sentence in result.warnings if sentence not in before])
    return result


def warn(sentences: Sequence[str], frames: int = 2) -> None:
    """Issue sentences about a run as Python warnings of the line so many frames above the caller's."""
    for sentence in sentences:
        warnings.warn(sentence, stacklevel=2 + frames)
