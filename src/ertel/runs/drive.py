"""From a case to its course in time: steps of controlled error, events, maps, and a state to resume from.

`transient` yields accepted steps and knows neither files nor screens; `simulate` gathers them, or the grids of a steady
case, into a Result.
"""

import time as clock
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.model.case import Case
from ertel.model.state import Attempt, GridSolution, Level, Method
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
    """The maps of P and H at a time; event: "", "max-approach" or "end"."""

    T: float
    P: NDArray[np.float64]
    H: NDArray[np.float64]
    event: str


@dataclass(frozen=True)
class Counts:
    """Work done so far; convolutions count by nodes of the finest grid."""

    steps: int = 0
    newton_iterations: int = 0
    krylov_iterations: int = 0
    convolutions: float = 0.0
    rejected: int = 0

    def plus(self, attempt: Attempt) -> "Counts":
        return Counts(
            self.steps,
            self.newton_iterations + attempt.newton,
            self.krylov_iterations + attempt.krylov,
            self.convolutions + attempt.convolutions,
            self.rejected,
        )

    def minus(self, other: "Counts") -> "Counts":
        return Counts(*(getattr(self, k) - getattr(other, k) for k in self.__dataclass_fields__))


@dataclass(frozen=True)
class State:
    """All that a run needs to go on: the last time levels (newest first), the next step, what has happened so far."""

    levels: tuple[Level, ...]
    next_step: float
    counts: Counts = Counts()
    next_frame: int = 1
    max_approach: Mapping[str, float] | None = None

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """The state as named arrays, exact to the last bit."""
        scalars = {"next_step": self.next_step, "next_frame": self.next_frame, **vars(self.counts)}
        reached = {f"max_approach_{key}": value for key, value in (self.max_approach or {}).items()}
        stacks = {name: np.array([getattr(level, name) for level in self.levels]) for name in Level._fields}
        return {key: np.asarray(value) for key, value in {**scalars, **reached, **stacks}.items()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "State":
        """Undo `to_arrays`."""
        rows = zip(*(arrays[name] for name in Level._fields), strict=True)
        levels = tuple(Level(float(T), float(Delta), float(V), P, H) for T, Delta, V, P, H in rows)
        counts = Counts(**{name: arrays[name].item() for name in Counts.__dataclass_fields__})
        prefix = "max_approach_"
        reached = {key.removeprefix(prefix): float(v) for key, v in arrays.items() if key.startswith(prefix)}
        return cls(levels, float(arrays["next_step"]), counts, int(arrays["next_frame"]), reached or None)


@dataclass(frozen=True)
class Step:
    """One accepted time step: the state after it, its scalars, the maps that fell due, and how the run stands."""

    state: State
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


def transient(case: Case, state: State | None = None, method: Method | None = None) -> Iterator[Step]:
    """Accepted steps from the start, or from a state, until the case's end; the last one's status says how it ended.

    A run that must give up yields its last good step again, with the reason as status.
    """
    method = method or method_of(case)
    if state is None:
        start = method.start()
        state = _first(case, start)
        if not start.status.ok:
            yield Step(state, {}, (), start.status)
            return
    while True:
        step = _next(case, method, state)
        yield step
        if step.status is not Status.RUNNING:
            return
        state = step.state


def simulate(
    case: Case,
    on_step: Callable[[Any], object] | None = None,
    state: State | None = None,
    method: Method | None = None,
) -> Result:
    """Run a case from start to end in memory.

    on_step sees every Step as it comes (progress, storage), or every GridSolution of a steady case.
    """
    if case.solver.method == "steady":
        return _simulate_steady(case, on_step)
    started, compiled = clock.monotonic(), compiling.count()
    method = method or method_of(case)
    steps = []
    for step in transient(case, state, method):
        steps.append(replace(step, state=replace(step.state, levels=())))  # the levels of old steps are large
        if on_step:
            on_step(step)
    records = [step.record for step in steps if step.record]
    frames = [frame for step in steps for frame in step.frames]
    data = assemble(case, records, frames, method.coordinates)
    work = {"compilations": compiling.count() - compiled, "wall_s": clock.monotonic() - started}
    summary = summarise(case, step, data, work)
    return Result(case, data.assign_attrs(status=step.status.value), summary, step.status)


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


def _first(case: Case, start: Attempt) -> State:
    """The state at T = 0; of a rolling contact its film is worth a map."""
    step = case.schedule.step or FIRST_STEP * abs(case.schedule.start_approach)
    return State((start.level,), step, Counts().plus(start), next_frame=1 if case.starts_apart else 0)


# -- one step -------------------------------------------------------------------------------------------------------


def _next(case: Case, method: Method, state: State) -> Step:
    """The next accepted step, with as many attempts as it takes."""
    fixed = case.schedule.step
    step = fixed or state.next_step
    counts = state.counts
    while step >= SMALLEST_STEP:
        length = _landing(case, state.levels[0].T, step)
        attempt = method.advance(state.levels, length)
        counts = counts.plus(attempt)
        if not attempt.status.ok:
            step, counts = CUT * length, replace(counts, rejected=counts.rejected + 1)
            continue
        error = 0.0 if fixed else _error(case, method, state.levels, attempt.level)
        if not fixed and not CONTROL.accepts(error):
            step, counts = CONTROL.next_step(length, error), replace(counts, rejected=counts.rejected + 1)
            continue
        following = fixed or min(CONTROL.next_step(length, error), LARGEST_STEP)
        return _accept(case, method, state, attempt, replace(counts, steps=counts.steps + 1), following, error)
    return Step(replace(state, counts=counts), {}, (), Status.STEP_TOO_SMALL)


def _landing(case: Case, T: float, step: float) -> float:
    """The step, cut where it would run past an end given as a time."""
    if isinstance(case.schedule.until, str):
        return step
    left = case.schedule.until - T
    return left if left < step * (1 + 1e-9) else step


def _error(case: Case, method: Method, levels: Sequence[Level], new: Level) -> float:
    """Local error of Delta, V and H in units of the tolerance: what the prediction tells (see `bdf.error_factor`).

    Without inertia V is no unknown of its own, and may jump.
    """
    if len(levels) < 3:
        return 1.0  # too little history; keep the step
    times = [level.T for level in levels]
    predict = bdf.interpolation_weights(new.T, times)
    approach, velocity, H = (
        sum(w * getattr(level, name) for w, level in zip(predict, levels, strict=True))
        for name in ("approach", "velocity", "H")
    )
    of_speed = abs(new.velocity - velocity) if case.motion.inertia else 0.0
    difference = max(abs(new.approach - approach), of_speed, method.film_error(new.H, H, new.P))
    return float(bdf.error_factor([new.T, *times]) * difference / case.schedule.tolerance)


def _accept(
    case: Case, method: Method, state: State, attempt: Attempt, counts: Counts, following: float, error: float
) -> Step:
    levels = (attempt.level, *state.levels)[:3]
    measured = method.measure(attempt.level)
    frames, next_frame = _due_frames(case, method, levels, state.next_frame)
    reached = state.max_approach
    if case.starts_apart and reached is None and levels[0].velocity <= 0.0 < levels[1].velocity:
        peak = interpolate(levels, turning_time(levels))
        reached = {"T": peak.T, "Delta": peak.approach, **method.measure(peak)}
        frames.append(_frame(method, peak, "max-approach"))
    status = Status.CONVERGED if _ended(case, attempt.level, measured["F"], reached) else Status.RUNNING
    if status is Status.CONVERGED and case.schedule.until != "max-approach":
        frames.append(_frame(method, attempt.level, "end"))
    spent = counts.minus(state.counts)
    record = {
        "T": attempt.level.T,
        "dT": levels[0].T - levels[1].T,
        "Delta": attempt.level.approach,
        "V": attempt.level.velocity,
        **measured,
        "U": case.motion.entrainment(attempt.level.T),
        "w": case.motion.load(attempt.level.T),
        "error": error,
        **{name: float(getattr(spent, name)) for name in Counts.__dataclass_fields__ if name != "steps"},
    }
    return Step(
        State(levels, following, counts, next_frame, reached),
        record,
        tuple(sorted(frames, key=lambda frame: frame.T)),
        status,
    )


def _ended(case: Case, level: Level, F: float, reached: Mapping[str, float] | None) -> bool:
    match case.schedule.until:
        case "max-approach":
            return reached is not None
        case "rebound":
            return reached is not None and F < UNLOADED
        case until:
            return level.T >= until * (1 - 1e-12)


# -- between steps --------------------------------------------------------------------------------------------------


def interpolate(levels: Sequence[Level], T: float) -> Level:
    """The level at a time between the last steps, by a parabola through them; P stays non-negative."""
    weights = bdf.interpolation_weights(T, [level.T for level in levels])
    _, approach, velocity, P, H = (
        sum(w * getattr(level, name) for w, level in zip(weights, levels, strict=True)) for name in Level._fields
    )
    return Level(T, float(approach), float(velocity), P.clip(0.0), H)


def turning_time(levels: Sequence[Level]) -> float:
    """When V = 0 between the last two levels, by bisection of its parabola."""
    times = [level.T for level in levels]
    V = np.array([level.velocity for level in levels])
    late, early = times[0], times[1]
    for _ in range(60):
        middle = (early + late) / 2
        early, late = (middle, late) if bdf.interpolation_weights(middle, times) @ V > 0 else (early, middle)
    return (early + late) / 2


def _due_frames(case: Case, method: Method, levels: Sequence[Level], number: int) -> tuple[list[Frame], int]:
    """The maps due since the step before, at multiples of the interval."""
    frames = []
    while number * case.schedule.interval <= levels[0].T:
        frames.append(_frame(method, interpolate(levels, number * case.schedule.interval), ""))
        number += 1
    return frames, number


def _frame(method: Method, level: Level, event: str) -> Frame:
    P, H = (np.asarray(method.whole(field)) for field in (level.P, level.H))
    return Frame(level.T, P, H, event)
