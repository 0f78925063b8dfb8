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

from ertel.inputs.case_files import CaseLike, as_case
from ertel.model.state import solved
from ertel.model.status import Status
from ertel.numerics.precision import double_precision
from ertel.results import accessor as accessor  # datasets of runs have .ertel
from ertel.results.result import Result
from ertel.results.summary import attributes
from ertel.runs import compiling
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
        self._started, self._compiled = clock.monotonic(), compiling.count()
        self.records: list[Mapping[str, float]] = []
        self.frames: list[Frame] = []

    def __call__(self, item: Item) -> None:
        if item.record:
            self.records.append(item.record)
        self.frames.extend(item.frames)

    def result(self, last: Any) -> Result:
        """The result of the run, from its last item."""
        data = self.course.dataset(self.records, self.frames, last)
        work = {"compilations": compiling.count() - self._compiled, "wall_s": clock.monotonic() - self._started}
        summary = self.course.summary(data, last, last.status, work)
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
        Its `status` says how the run ended; what a careful colleague would warn of is also given as Python warnings.

    Raises ConfigError for anything else than a case, naming the argument or the field.
    """
    compiling.check_jax()
    course = course_of(as_case(case))
    gathering = Gathering(course)
    with progress_bar(course, progress) as shown:
        last = drive(course, [gathering, *shown, *observers])
    result = gathering.result(last)
    warn_of(result)
    return result


def warn_of(result: Result) -> None:
    """Issue the warnings of a run as Python warnings."""
    for sentence in result.warnings:
        warnings.warn(sentence, stacklevel=4)  # of the caller of a decorated function
