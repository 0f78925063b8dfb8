"""Progress bars: an observer for each run."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ertel.runs.courses import Course


def bars(shown: bool) -> Any:
    """Bars on stderr (a `rich.progress.Progress`); none if stderr is not a terminal or they are not wanted."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    label, news = (TextColumn(text, markup=False) for text in ("{task.description}", "{task.fields[news]}"))
    hidden = not shown or not (console.is_terminal or console.is_jupyter)
    return Progress(label, BarColumn(24), news, TimeElapsedColumn(), console=console, disable=hidden)


def watch(progress: Any, course: Course, label: str = "") -> Callable[[Any], None]:
    """An observer that shows a run in a new bar."""
    bar = progress.add_task(
        label or course.case.name or course.case.kind, total=1.0, news="compiling (once per machine and grid size)"
    )

    def show(item: Any) -> None:
        if item.record:
            progress.update(bar, completed=course.fraction(item), news=course.news(item))

    return show


@contextmanager
def progress_bar(course: Course, shown: bool) -> Iterator[list[Callable[[Any], None]]]:
    """The observers that show a run; none if progress is not wanted."""
    if not shown:
        yield []
        return
    with bars(shown) as progress:
        yield [watch(progress, course)]
