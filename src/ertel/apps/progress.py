"""Progress bars of a run, and the ear for Ctrl-C."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

if TYPE_CHECKING:  # ertel paper shows its bar before it needs these
    from ertel.model.case import Case
    from ertel.model.state import GridSolution
    from ertel.runs.drive import Step

Watch = Callable[[Any], bool]  # sees a Step, or a GridSolution, and says whether to go on


def progress(quiet: bool) -> Progress:
    """Bars on stderr; none where stderr is no terminal."""
    console = Console(stderr=True)
    label, news = (TextColumn(text, markup=False) for text in ("{task.description}", "{task.fields[news]}"))
    return Progress(
        label, BarColumn(24), news, TimeElapsedColumn(), console=console, disable=quiet or not console.is_terminal
    )


def watch(bars: Progress, case: "Case", label: str, stop: Callable[[], bool]) -> Watch:
    """A callback that shows each step, or grid, in a new bar and says whether to go on."""
    bar = bars.add_task(label, total=1.0, news="compiling")
    news = _grid_news if case.solver.method == "steady" else _step_news

    def on_item(item: Any) -> bool:
        fraction, text = news(case, item)
        if text:
            bars.update(bar, completed=fraction, news=text)
        return not stop()

    return on_item


def _step_news(case: "Case", step: "Step") -> tuple[float, str]:
    """The fraction of the run that is done, and a line on the step."""
    from ertel.runs.drive import progress_fraction

    if not step.record:
        return 1.0, ""
    record, counts = step.record, step.state.counts
    work = f"{counts.steps} steps, {counts.newton_iterations} Newton, {counts.krylov_iterations} Krylov"
    news = f"T {record['T']:.3f}  Δ {record['Delta']:+.4f}  H_c {record['H_c']:.5f}  {work}"
    return progress_fraction(case, record), news


def _grid_news(case: "Case", solution: "GridSolution") -> tuple[float, str]:
    """The fraction of the work that is done, and a line on the grid."""
    H_c, nodes = solution.measure()["H_c"], solution.grid.nodes
    work = f"{solution.newton} Newton, {solution.krylov} Krylov"
    news = f"{nodes} x {nodes}  residual {solution.residual:.1e}  H_c {H_c:.5f}  {work}"
    return (nodes / case.solver.nodes) ** 2, news


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C was pressed.  The step, or grid, under way is finished first; a second Ctrl-C ends at once."""
    asked = False

    def on_interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True

    before = signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield lambda: asked
    finally:
        signal.signal(signal.SIGINT, before)
