"""From a case to its course in time: steps of controlled error, events, maps, and a state to resume from.

`transient` yields accepted steps and knows neither files nor screens; `simulate` gathers them, or the grids of a steady
case, into a Result.
"""

import time as clock
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.model.case import Case
from ertel.model.state import GridSolution, Method, State, Work, combined, interpolated, solved
from ertel.model.status import Status
from ertel.numerics import bdf
from ertel.results.dataset import assemble, assemble_steady
from ertel.results.summary import steady_summary, transient_summary
from ertel.runs import compiling
from ertel.solvers import steady
from ertel.solvers.radial import RadialImpact
from ertel.solvers.transient import Transient2D

CONTROL = bdf.StepControl()
FIRST_STEP = 0.01  # of the initial gap
LARGEST_STEP = 0.1  # t0: the impact lasts about 3
SMALLEST_STEP = 1e-7  # t0
CUT = 0.5  # after a step that did not converge
UNLOADED = 1e-8  # F below which the ball has left


class Frame(NamedTuple):
    """The maps of all fields at a time, by name; event: "", "max-approach" or "end"."""

    T: float
    fields: Mapping[str, NDArray[np.float64]]
    event: str

    @property
    def P(self) -> NDArray[np.float64]:
        """The pressure."""
        return self.fields["P"]

    @property
    def H(self) -> NDArray[np.float64]:
        """The film thickness."""
        return self.fields["H"]


@dataclass(frozen=True)
class Counts:
    """Work done so far; convolutions count by nodes of the finest grid."""

    steps: int = 0
    newton_iterations: int = 0
    krylov_iterations: int = 0
    convolutions: float = 0.0
    rejected: int = 0

    def plus(self, work: Work) -> "Counts":
        return Counts(
            self.steps,
            self.newton_iterations + work.newton,
            self.krylov_iterations + work.krylov,
            self.convolutions + work.convolutions,
            self.rejected,
        )

    def minus(self, other: "Counts") -> "Counts":
        return Counts(*(getattr(self, k) - getattr(other, k) for k in self.__dataclass_fields__))


@dataclass(frozen=True)
class Course:
    """All that a run needs to go on: the last time levels (newest first), the next step, what has happened so far."""

    levels: tuple[State, ...]
    next_step: float
    counts: Counts = Counts()
    next_frame: int = 1
    max_approach: Mapping[str, float] | None = None

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """The state as named arrays, exact to the last bit."""
        scalars = {"next_step": self.next_step, "next_frame": self.next_frame, **vars(self.counts)}
        reached = {f"max_approach_{key}": value for key, value in (self.max_approach or {}).items()}
        names, numbers = list(self.levels[0].fields), ("T", "approach", "velocity")
        stacks = {name: np.array([getattr(level, name) for level in self.levels]) for name in numbers}
        stacks |= {name: np.array([level.fields[name] for level in self.levels]) for name in names}
        stacks["fields"] = np.array(names)
        return {key: np.asarray(value) for key, value in {**scalars, **reached, **stacks}.items()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "Course":
        """Undo `to_arrays`."""
        names = arrays["fields"].tolist() if "fields" in arrays else ["P", "H"]  # older checkpoints name none
        numbers = zip(*(arrays[name].tolist() for name in ("T", "approach", "velocity")), strict=True)
        levels = tuple(
            State(T, Delta, V, {name: arrays[name][i] for name in names}) for i, (T, Delta, V) in enumerate(numbers)
        )
        counts = Counts(**{name: arrays[name].item() for name in Counts.__dataclass_fields__})
        prefix = "max_approach_"
        reached = {key.removeprefix(prefix): float(v) for key, v in arrays.items() if key.startswith(prefix)}
        return cls(levels, float(arrays["next_step"]), counts, int(arrays["next_frame"]), reached or None)


@dataclass(frozen=True)
class Step:
    """One accepted time step: the state after it, its scalars, the maps that fell due, and how the run stands."""

    state: Course
    record: Mapping[str, float]
    frames: tuple[Frame, ...]
    status: Status


@dataclass(frozen=True)
class Result:
    """What a run gave: its Dataset, its summary (see `results.summary`) and how it ended."""

    case: Case
    dataset: xr.Dataset
    summary: Mapping[str, Any]
    status: Status


def method_of(case: Case) -> Method:
    """The way to step that a case asks for.  Raises ValueError for a steady case, which has no steps."""
    match case.solver.method:
        case "radial":
            return RadialImpact(case)
        case "2d" | "transient":
            return Transient2D(case)
    raise ValueError(f'solver.method = "{case.solver.method}": has no time steps')


def transient(case: Case, state: Course | None = None, method: Method | None = None) -> Iterator[Step]:
    """Accepted steps from the start, or from a state, until the case's end; the last one's status says how it ended.

    A run that must give up yields its last good step again, with the reason as status.
    """
    method = method or method_of(case)
    step = begin(case, method) if state is None else Step(state, {}, (), Status.RUNNING)
    if step.status is not Status.RUNNING:
        yield step
    while step.status is Status.RUNNING:
        step = solved(attempts(case, method, step.state), method.solve)
        yield step


class Gathering:
    """The steps of a run in memory."""

    def __init__(self, case: Case):
        self._case = case
        self._started, self._compiled = clock.monotonic(), compiling.count()
        self._records: list[Mapping[str, float]] = []
        self._frames: list[Frame] = []

    def take(self, step: Step) -> None:
        """One more step."""
        if step.record:  # a run that gives up ends with a step that has none
            self._records.append(step.record)
        self._frames.extend(step.frames)

    def result(self, last: Step, method: Method) -> Result:
        """What the run gave, from its last step."""
        data = assemble(self._case, self._records, self._frames, method.coordinates)
        work = {"compilations": compiling.count() - self._compiled, "wall_s": clock.monotonic() - self._started}
        summary = summarise(self._case, last, data, work)
        return Result(self._case, data.assign_attrs(status=last.status.value), summary, last.status)


def simulate(
    case: Case,
    on_step: Callable[[Any], object] | None = None,
    state: Course | None = None,
    method: Method | None = None,
) -> Result:
    """Run a case from start to end in memory.

    on_step sees every Step as it comes (progress, storage), or every GridSolution of a steady case.
    """
    if case.solver.method == "steady":
        return _simulate_steady(case, on_step)
    gathering = Gathering(case)
    method = method or method_of(case)
    for step in transient(case, state, method):
        gathering.take(step)
        if on_step:
            on_step(step)
    return gathering.result(step, method)


def _simulate_steady(case: Case, on_grid: Callable[[GridSolution], object] | None) -> Result:
    started, compiled = clock.monotonic(), compiling.count()
    solutions = []
    for solution in steady.nested(case):
        solutions.append(solution)
        if on_grid:
            on_grid(solution)
    work = {"compilations": compiling.count() - compiled, "wall_s": clock.monotonic() - started}
    status = solutions[-1].status
    summary = steady_summary(case, solutions, work, status)
    data = assemble_steady(case, solutions)
    return Result(case, data.assign_attrs(status=status.value), summary, status)


def summarise(case: Case, last: Step, data: xr.Dataset, work: Mapping[str, float]) -> dict[str, Any]:
    """The summary of a run from its last step, its Dataset, and what only the clock knows."""
    counts = {**vars(last.state.counts), **work}
    counts["convolutions"] = round(counts["convolutions"], 1)
    return transient_summary(case, data, last.state.max_approach, counts, last.status)


def progress_fraction(case: Case, record: Mapping[str, float]) -> float:
    """How much of a run lies behind a step, 0 to 1, roughly."""
    T, start, until = record["T"], case.schedule.start_approach, case.schedule.until
    if not isinstance(until, str):
        return min(T / until, 1.0)
    touch, half, whole = -start, 1.47 - start, 2.95 - 2 * start
    if until == "rebound":
        return min(T / whole, 1.0)
    return 1.0 if record["V"] <= 0 else min(T / half, 1.0) if T > touch else T / half


def begin(case: Case, method: Method) -> Step:
    """The run before its first step, without a record; of a rolling contact the film at T = 0 is worth a map."""
    start = method.start()
    step = case.schedule.step or FIRST_STEP * abs(case.schedule.start_approach)
    course = Course((start,), step, Counts().plus(start.work), next_frame=1 if case.starts_apart else 0)
    return Step(course, {}, (), Status.RUNNING if start.status.ok else start.status)


# -- one step -------------------------------------------------------------------------------------------------------


def attempts(case: Case, method: Method, state: Course) -> Generator[Any, Any, Step]:
    """The next accepted step, with as many attempts as it takes: yields their problems, is sent the solutions."""
    fixed = case.schedule.step
    step = fixed or state.next_step
    counts = state.counts
    while step >= SMALLEST_STEP:
        length = _landing(case, state.levels[0].T, step)
        new = yield from method.attempt(state.levels, length)
        counts = counts.plus(new.work)
        if not new.status.ok:
            step, counts = CUT * length, replace(counts, rejected=counts.rejected + 1)
            continue
        error = 0.0 if fixed else _error(case, method, state.levels, new)
        if not fixed and not CONTROL.accepts(error):
            step, counts = CONTROL.next_step(length, error), replace(counts, rejected=counts.rejected + 1)
            continue
        following = fixed or min(CONTROL.next_step(length, error), LARGEST_STEP)
        return _accept(case, method, state, new, replace(counts, steps=counts.steps + 1), following, error)
    return Step(replace(state, counts=counts), {}, (), Status.STEP_TOO_SMALL)


def _landing(case: Case, T: float, step: float) -> float:
    """The step, cut where it would run past an end given as a time."""
    if isinstance(case.schedule.until, str):
        return step
    left = case.schedule.until - T
    return left if left < step * (1 + 1e-9) else step


def _error(case: Case, method: Method, levels: Sequence[State], new: State) -> float:
    """Local error of Delta, V and the fields in units of the tolerance, from the prediction (see `bdf.error_factor`).

    Without inertia V is no unknown of its own, and may jump.
    """
    if len(levels) < 3:
        return 1.0  # too little history; keep the step
    times = [level.T for level in levels]
    predict = bdf.interpolation_weights(new.T, times)
    approach, velocity = (combined(predict, [getattr(o, name) for o in levels]) for name in ("approach", "velocity"))
    fields = {name: combined(predict, [level.fields[name] for level in levels]) for name in method.controlled}
    of_speed = abs(new.velocity - velocity) if case.motion.inertia else 0.0
    difference = max(abs(new.approach - approach), of_speed, method.error(new, fields))
    return float(bdf.error_factor([new.T, *times]) * difference / case.schedule.tolerance)


def _accept(
    case: Case, method: Method, state: Course, new: State, counts: Counts, following: float, error: float
) -> Step:
    levels = (new, *state.levels)[:3]
    measured = method.measure(new)
    frames, next_frame = _due_frames(case, method, levels, state.next_frame)
    reached = state.max_approach
    if case.starts_apart and reached is None and levels[0].velocity <= 0.0 < levels[1].velocity:
        peak = interpolated(levels, turning_time(levels))
        reached = {"T": peak.T, "Delta": peak.approach, **method.measure(peak)}
        frames.append(_frame(method, peak, "max-approach"))
    status = Status.CONVERGED if _ended(case, new, measured["F"], reached) else Status.RUNNING
    if status is Status.CONVERGED and case.schedule.until != "max-approach":
        frames.append(_frame(method, new, "end"))
    spent = counts.minus(state.counts)
    record = {
        "T": new.T,
        "dT": levels[0].T - levels[1].T,
        "Delta": new.approach,
        "V": new.velocity,
        **measured,
        "U": case.motion.entrainment(new.T),
        "w": case.motion.load(new.T),
        "error": error,
        **{name: float(getattr(spent, name)) for name in Counts.__dataclass_fields__ if name != "steps"},
    }
    return Step(
        Course(levels, following, counts, next_frame, reached),
        record,
        tuple(sorted(frames, key=lambda frame: frame.T)),
        status,
    )


def _ended(case: Case, level: State, F: float, reached: Mapping[str, float] | None) -> bool:
    match case.schedule.until:
        case "max-approach":
            return reached is not None
        case "rebound":
            return reached is not None and F < UNLOADED
        case until:
            return level.T >= until * (1 - 1e-12)


# -- between steps --------------------------------------------------------------------------------------------------


def turning_time(levels: Sequence[State]) -> float:
    """When V = 0 between the last two levels, by bisection of its parabola."""
    times = [level.T for level in levels]
    V = np.array([level.velocity for level in levels])
    late, early = times[0], times[1]
    for _ in range(60):
        middle = (early + late) / 2
        early, late = (middle, late) if bdf.interpolation_weights(middle, times) @ V > 0 else (early, middle)
    return (early + late) / 2


def _due_frames(case: Case, method: Method, levels: Sequence[State], number: int) -> tuple[list[Frame], int]:
    """The maps due since the step before, at multiples of the interval."""
    frames = []
    while number * case.schedule.interval <= levels[0].T:
        frames.append(_frame(method, interpolated(levels, number * case.schedule.interval), ""))
        number += 1
    return frames, number


def _frame(method: Method, level: State, event: str) -> Frame:
    return Frame(level.T, {name: np.asarray(method.whole(field)) for name, field in level.fields.items()}, event)
