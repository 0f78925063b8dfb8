"""The two kinds of run, in time steps or over the grids of a steady contact, and the loop over a run with observers.

    drive(run_of(case), [observer, ...])

`run_of` chooses the kind; nobody else asks which it is.  An observer sees every accepted time step, or every grid of a
steady contact.  The store, the progress bar and the Ctrl-C handler are observers; one that returns True asks for a
stop.
"""

import time as clock
import warnings
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.case.definition import grid_of
from ertel.case.status import Status
from ertel.equations.state import Method, State, solved
from ertel.inputs.case_files import CaseLike, as_case
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.programs import double_precision
from ertel.results.dataset import Frame, assemble, assemble_steady
from ertel.results.result import Result
from ertel.results.summary import attributes, impact_summary, rolling_summary, steady_summary
from ertel.runs import workers
from ertel.runs.compile import check_jax, compilations
from ertel.runs.outlook import warnings_of, with_case_warnings
from ertel.runs.stepping import Counts, RunState, Step, StepLimits, begin, next_step
from ertel.solvers import steady
from ertel.solvers.radial import RadialImpact
from ertel.solvers.steady import GridSolution
from ertel.solvers.transient import Transient2D

Arrays = Mapping[str, NDArray[Any]]
Observer = Callable[[Any], object]


class Progress(NamedTuple):
    """The progress of a run.

    T: time in t0, None of a steady contact.  step: the number of time steps, or of grids.  done: the approximate
    fraction of the run, 0 to 1.  message: the last result as one line of text.
    """

    T: float | None
    step: int
    done: float
    message: str


METHODS: Mapping[str, Callable[[Case], Method]] = {"2d": Transient2D, "transient": Transient2D, "radial": RadialImpact}


def method_of(case: Case) -> Method:
    """The time stepping method of a case."""
    return METHODS[case.solver.method](case)


# -- in time ----------------------------------------------------------------------------------------------------------

NUMBERS = ("T", "approach", "velocity", "load", "outside")  # of a State, besides its fields
REACHED = "max_approach_"


class TransientRun:
    """An impact, or rolling in time from the steady film.

    A run of either kind gives one `StepResult` after the other.  Each has a record, scalars by name; frames, the maps
    that fell due; and the status of the run after it.
    """

    def __init__(self, case: Case, method: Method, limits: StepLimits | None = None):
        self.case, self.method, self.limits = case, method, limits or StepLimits()

    def begin(self) -> Step:
        """Return the result before the first step, without a record."""
        return begin(self.case, self.method, self.limits)

    def advance(self, result: Step) -> Step:
        """Return the next result."""
        return solved(self.attempts(result), self.method.solve)

    def attempts(self, result: Step) -> Generator[Any, Any, Step]:
        """The next result: yields the problem of each attempt and is sent its solution, see `simulate_batch`."""
        return next_step(self.case, self.method, result.state, self.limits)

    def progress(self, result: Step) -> Progress:
        """Tell how far the run is after a result."""
        record, counts, schedule = result.record, result.state.counts, self.case.schedule
        T = result.state.levels[0].T
        if not record:
            return Progress(T, counts.steps, 0.0, "")
        turned = schedule.until == "max-approach" and record["V"] <= 0
        done = 1.0 if turned else min(T / schedule.duration, 1.0)
        work = f"{counts.steps} steps, {counts.newton_iterations} Newton, {counts.krylov_iterations} Krylov"
        message = f"T {T:.3f}  Δ {record['Delta']:+.4f}  H_c {record['H_c']:.5f}  {work}"
        return Progress(T, counts.steps, done, message)

    def to_arrays(self, result: Step) -> dict[str, NDArray[Any]]:
        """Everything that is needed to continue after a result, as named arrays, exact to the last bit."""
        state, levels = result.state, result.state.levels
        scalars = {"next_step": state.next_step, "next_frame": state.next_frame, **vars(state.counts)}
        reached = {f"{REACHED}{key}": value for key, value in (state.max_approach or {}).items()}
        names = list(levels[0].fields)
        stacks = {name: np.array([getattr(level, name) for level in levels]) for name in NUMBERS}
        stacks |= {name: np.array([level.fields[name] for level in levels]) for name in names}
        everything = {**scalars, **reached, **stacks, "fields": names, "status": result.status.value}
        return {key: np.asarray(value) for key, value in everything.items()}

    def from_arrays(self, arrays: Arrays) -> Step:
        """Return the result from the arrays of `to_arrays`."""
        names = arrays["fields"].tolist()
        numbers = zip(*(arrays[name].tolist() for name in NUMBERS), strict=True)
        levels = tuple(
            State(T, Delta, V, {name: arrays[name][i] for name in names}, outside=outside, load=load)
            for i, (T, Delta, V, load, outside) in enumerate(numbers)
        )
        counts = Counts(**{name: arrays[name].item() for name in Counts.__dataclass_fields__})
        reached = {key.removeprefix(REACHED): float(v) for key, v in arrays.items() if key.startswith(REACHED)}
        next_step, next_frame = float(arrays["next_step"]), int(arrays["next_frame"])
        state = RunState(levels, next_step, counts, next_frame, reached or None)
        return Step(state, {}, (), Status(str(arrays["status"])))

    def dataset(self, records: Sequence[Mapping[str, float]], frames: Sequence[Frame], last: Any) -> xr.Dataset:
        """Return the run as a Dataset."""
        return assemble(self.case, records, frames, self.method.coordinates)

    def summary(self, data: xr.Dataset, last: Step, status: Status, work: Mapping[str, float]) -> dict[str, Any]:
        """Return the outcome of the run as plain data; work: compilations, wall_s."""
        counts = {**vars(last.state.counts), **work}
        counts["convolutions"] = round(counts["convolutions"], 1)
        if self.case.starts_apart:
            return impact_summary(self.case, data, last.state.max_approach, counts, status)
        return rolling_summary(self.case, data, counts, status)


# -- steady -----------------------------------------------------------------------------------------------------------

COUNTED = ("approach", "residual", "newton", "krylov", "convolutions", "outside")  # the plain numbers of a GridSolution
FIELDS = ("P", "H", "history")


@dataclass(frozen=True)
class GridStep:
    """The steady contact after one more grid: all solutions so far, coarsest first."""

    solutions: tuple[GridSolution, ...]
    status: Status
    frames: tuple[Frame, ...] = ()

    @property
    def record(self) -> Mapping[str, float]:
        """The values on the finest grid so far, and the work on it."""
        if not self.solutions:
            return {}
        s = self.solutions[-1]
        work = {"newton_iterations": s.newton, "krylov_iterations": s.krylov, "residual": s.residual}
        return {**s.measure(), **work, "nodes": s.grid.nodes_x, "nodes_y": s.grid.nodes_y}


StepResult = Step | GridStep  # an accepted time step, or the solution on a grid


class SteadyRun:
    """A steady contact, grid by grid: each solution is the first guess on the next grid."""

    def __init__(self, case: Case):
        self.case = case

    def begin(self) -> GridStep:
        return GridStep((), Status.RUNNING)

    def advance(self, result: GridStep) -> GridStep:
        solution = next(steady.nested(self.case, result.solutions))
        finest = solution.grid.nodes == self.case.solver.nodes
        return GridStep((*result.solutions, solution), solution.status if finest else Status.RUNNING)

    def progress(self, result: GridStep) -> Progress:
        if not result.solutions:
            return Progress(None, 0, 0.0, "")
        r = result.record
        work = f"{r['newton_iterations']} Newton, {r['krylov_iterations']} Krylov"
        message = f"{r['nodes']} x {r['nodes_y']}  residual {r['residual']:.1e}  H_c {r['H_c']:.5f}  {work}"
        return Progress(None, len(result.solutions), (r["nodes"] / self.case.solver.nodes) ** 2, message)

    def to_arrays(self, result: GridStep) -> dict[str, NDArray[Any]]:
        solutions = result.solutions
        grids = [
            (s.grid.nodes_x, s.grid.nodes_y, s.grid.spacing, s.grid.centre_x, s.grid.centre_y, *s.grid.even)
            for s in solutions
        ]
        arrays = {name: np.array([getattr(s, name) for s in solutions]) for name in COUNTED}
        arrays["grid"] = np.array(grids, dtype=float)
        arrays["grid_status"] = np.array([s.status.value for s in solutions])
        arrays["status"] = np.asarray(result.status.value)
        for i, s in enumerate(solutions):
            arrays |= {f"{name}_{i}": np.asarray(getattr(s, name)) for name in FIELDS}
        return arrays

    def from_arrays(self, arrays: Arrays) -> GridStep:
        solutions = []
        for i, (nodes_x, nodes_y, spacing, x, y, *even) in enumerate(arrays["grid"].tolist()):
            solutions.append(
                GridSolution(
                    case=self.case,
                    grid=Grid(int(nodes_x), int(nodes_y), spacing, x, y, Symmetry(*(bool(e) for e in even))),
                    P=jax.device_put(arrays[f"P_{i}"]),
                    H=jax.device_put(arrays[f"H_{i}"]),
                    status=Status(str(arrays["grid_status"][i])),
                    history=tuple(arrays[f"history_{i}"].tolist()),
                    **{name: arrays[name][i].item() for name in COUNTED},
                )
            )
        return GridStep(tuple(solutions), Status(str(arrays["status"])))

    def dataset(self, records: Sequence[Mapping[str, float]], frames: Sequence[Frame], last: GridStep) -> xr.Dataset:
        grid = last.solutions[-1].grid if last.solutions else grid_of(self.case)
        return assemble_steady(self.case, grid, last.solutions)

    def summary(self, data: xr.Dataset, last: GridStep, status: Status, work: Mapping[str, float]) -> dict[str, Any]:
        return steady_summary(self.case, last.solutions, work, status)


Run = TransientRun | SteadyRun


def run_of(case: Case) -> Run:
    """The run of a case.  Raises Forked."""
    workers.check_fork()
    return SteadyRun(case) if case.is_steady else TransientRun(case, method_of(case))


# -- the loop ---------------------------------------------------------------------------------------------------------


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
    run = run_of(case)
    with bars(progress) as shown:
        result = result_of(run, [watch(shown, run), *observers])
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

    def show(result: Any) -> None:
        if result.record:
            now = run.progress(result)
            progress.update(bar, completed=now.done, message=now.message)

    return show
