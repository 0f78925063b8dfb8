"""The two kinds of run, in time steps or over the grids of a steady contact, and the loop over a run with observers.

    drive(run_of(case), [observer, ...])

`run_of` chooses the kind; nobody else asks which it is.  An observer sees every accepted time step, or every grid of a
steady contact.  The store, the progress bar and the Ctrl-C handler are observers; one that returns True asks for a
stop.
"""

import time as clock
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from importlib.util import find_spec
from math import inf
from typing import Any

import jax
import numpy as np
import rich.progress
import xarray as xr
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.equations.state import SteadySolver
from ertel.inputs.case_files import CaseLike, as_case, require_laws
from ertel.numerics.programs import double_precision
from ertel.results.dataset import Frame, assemble_steady
from ertel.results.numbers import duration
from ertel.results.summary import attributes, steady_summary
from ertel.runs import workers
from ertel.runs.compile import accelerator, check_jax, compilations
from ertel.runs.outlook import warnings_of, with_case_warnings
from ertel.runs.result import Result
from ertel.runs.stepping import Arrays, Progress, Step, TransientRun
from ertel.solvers import SOLVERS

Observer = Callable[[Any], object]


# -- steady -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class GridStep:
    """The steady contact after one more grid: all solutions so far, coarsest first."""

    solutions: tuple[Any, ...]
    status: Status
    frames: tuple[Frame, ...] = ()

    @property
    def record(self) -> Mapping[str, float]:
        """The numbers of the finest grid so far, and the work on it."""
        return self.solutions[-1].record if self.solutions else {}


StepResult = Step | GridStep  # an accepted time step, or the solution on a grid


class SteadyRun:
    """A steady contact, grid by grid: each solution is the first guess on the next grid."""

    def __init__(self, case: Case, solver: SteadySolver):
        self.case, self.solver = case, solver

    def begin(self) -> GridStep:
        return GridStep((), Status.RUNNING)

    def advance(self, result: GridStep) -> GridStep:
        solutions = (*result.solutions, self.solver.solve(result.solutions))
        is_finest = len(solutions) == len(self.solver.grids)
        return GridStep(solutions, solutions[-1].status if is_finest else Status.RUNNING)

    def progress(self, result: GridStep) -> Progress:
        if not result.solutions:
            return Progress(None, 0, 0.0, "")
        r, grid = result.record, result.solutions[-1].grid
        work = f"{r['newton_iterations']} Newton, {r['krylov_iterations']} Krylov"
        size = " x ".join(str(len(axis)) for axis in reversed(grid.coordinates.values()))
        message = f"{size}  residual {r['residual']:.1e}  H_c {r['H_c']:.5f}  {work}"
        return Progress(None, len(result.solutions), (grid.nodes / self.case.solver.nodes) ** 2, message)

    def to_arrays(self, result: GridStep) -> dict[str, NDArray[Any]]:
        """The fields of the solutions beside case and grid, by name and number of the grid."""
        arrays: dict[str, Any] = {"status": result.status.value}
        for i, s in enumerate(result.solutions):
            stored = {field.name: getattr(s, field.name) for field in fields(s) if field.name not in ("case", "grid")}
            stored["status"] = s.status.value
            arrays |= {f"{name}_{i}": value for name, value in stored.items() if value is not None}
        return {name: np.asarray(value) for name, value in arrays.items()}

    def from_arrays(self, arrays: Arrays) -> GridStep:
        solutions: list[Any] = []
        while f"status_{len(solutions)}" in arrays:
            end = f"_{len(solutions)}"
            there = {name.removesuffix(end): value for name, value in arrays.items() if name.endswith(end)}
            stored: dict[str, Any] = {name: value if value.ndim else value.item() for name, value in there.items()}
            stored |= {"status": Status(stored["status"]), "history": tuple(stored["history"].tolist())}
            stored |= {name: jax.device_put(stored[name]) for name in ("P", "H")}
            solutions.append(self.solver.restored(len(solutions), stored))
        return GridStep(tuple(solutions), Status(str(arrays["status"])))

    def dataset(self, records: Sequence[Mapping[str, float]], frames: Sequence[Frame], last: GridStep) -> xr.Dataset:
        grid = last.solutions[-1].grid if last.solutions else self.solver.grids[-1]
        return assemble_steady(self.case, grid, last.solutions)

    def summary(self, data: xr.Dataset, last: GridStep, status: Status, work: Mapping[str, float]) -> dict[str, Any]:
        return steady_summary(self.case, last.solutions, work, status)


Run = TransientRun | SteadyRun


def run_of(case: Case) -> Run:
    """The run of a case.  Raises Forked, and ConfigError, see `require_laws`."""
    workers.check_fork()
    require_laws(case)
    solver: Any = SOLVERS[case.solver.method](case)
    return SteadyRun(case, solver) if case.is_steady else TransientRun(case, solver)


# -- the loop ---------------------------------------------------------------------------------------------------------


@workers.one_blas_thread()
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


def result_of(run: Run, observers: Sequence[Observer] = ()) -> Result:
    """The result of a run in memory."""
    recorder = Recorder(run)
    return recorder.result(drive(run, [recorder, *observers]))


@double_precision()
def simulate(case: CaseLike, progress: bool = False, observers: Sequence[Observer] = ()) -> Result:
    """Run a case from start to end in memory.

    Parameters
    ----------
    case : Case, str, Path or mapping
        From `impact` or `rolling`; or a case file, or its plain data, as for `load_case` and `parse_case`.
    progress : bool
        Whether to show a progress bar; in a file, a line a minute.
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
    run = run_of(case)
    with bars(progress) as shown:
        result = result_of(run, [watch(shown, run), *observers])
    warn([sentence for sentence in result.warnings if sentence not in before])
    return result


# -- compiling ahead --------------------------------------------------------------------------------


STEPS = 4  # the first three have histories of different length


@double_precision()
def warm_up(case: Case) -> None:
    """Compile what a run of the case needs.

    A steady case is run to its end, a run in time for a few steps.
    """
    run: Any = run_of(case)
    steps = iter(range(STEPS))

    def enough(result: Any) -> bool:
        if case.is_steady or next(steps, None) is not None:
            return False
        run.method.measure(result.state.levels[0])  # as at the moments of which maps are kept
        run.method.friction(result.state.levels[0])
        return True

    result_of(run, [enough])


def warn(sentences: Sequence[str], frames: int = 2) -> None:
    """Issue sentences about a run as Python warnings of the line so many frames above the caller's."""
    for sentence in sentences:
        warnings.warn(sentence, stacklevel=2 + frames)


# -- progress bars ----------------------------------------------------------------------------------------------------

LOG_INTERVAL = 60.0  # s between two lines in a log


def bars(shown: bool) -> rich.progress.Progress:
    """Bars on stderr, or lines where it is a file or a notebook without ipywidgets; neither if they are not wanted."""
    console = Console(stderr=True)
    in_widgets = console.is_jupyter and find_spec("ipywidgets")
    if shown and not (console.is_terminal or in_widgets):
        return LogLines(Console(stderr=True, force_jupyter=False), at_end=console.is_jupyter)
    label, message = (TextColumn(text, markup=False) for text in ("{task.description}", "{task.fields[message]}"))
    columns = label, BarColumn(24), message, TimeElapsedColumn()
    return rich.progress.Progress(*columns, console=console, disable=not shown)


class LogLines(rich.progress.Progress):
    """Progress in a file, such as the log of a cluster: a line a minute in place of bars.

    The line is that of the newest run, or of a study as a whole, with the shares of its runs.  The rest is expected at
    the pace since the first result; compiling came before it.  at_end: whether there is a line then, too.
    """

    def __init__(self, console: Console, get_time: Callable[[], float] | None = None, at_end: bool = False):
        super().__init__(console=console, get_time=get_time, speed_estimate_period=inf)
        self._next, self._at_end = self.get_time() + LOG_INTERVAL, at_end

    def start(self) -> None:
        """Show no bars."""

    def stop(self) -> None:
        """Show no bars; in a notebook a line of the end."""
        if self._at_end and self.tasks:
            self.console.out(self._line(), highlight=False)

    def update(self, *task: Any, **changes: Any) -> None:
        """Take the progress of a task, and write a line if the last one is a minute old.

        Errors in writing the log are ignored.
        """
        super().update(*task, **changes)
        if self.get_time() >= self._next:
            self._next = self.get_time() + LOG_INTERVAL
            with suppress(OSError):
                self.console.out(self._line(), highlight=False)

    def _line(self) -> str:
        """Label, share, message, time so far and time left."""
        whole = max(reversed(self.tasks), key=lambda task: task.total or 0.0)
        total = whole.total or 1.0
        done = whole.completed + sum(part.completed for part in self.tasks if (part.total or 0.0) < total)
        left = whole.time_remaining
        rest = "" if not left else f", about {duration(left)} left"
        so_far = f"{duration(whole.elapsed or 0.0)} so far{rest}"
        return "  ".join(filter(None, (whole.description, f"{done / total:.0%}", whole.fields["message"], so_far)))


def watch(shown: rich.progress.Progress, run: Run, label: str = "") -> Observer:
    """An observer that shows a run in a new bar, which names the device where that is not the CPU."""
    on = accelerator()
    label = (label or run.case.name or run.case.kind) + (f" on {on}" if on else "")
    bar = shown.add_task(label, total=1.0, message="compiling (once per machine and grid size)")

    def show(result: Any) -> None:
        if result.record:
            now = run.progress(result)
            shown.update(bar, completed=now.done, message=now.message)

    return show
