"""Time steps with error control: attempts until one is accepted, events, and maps at given times.

Nothing here loops over a run (`drive`), and nothing solves: `next_step` is a generator that yields the problems of its
attempts and is sent their solutions, so that one run and a batch of runs share it.
"""

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.equations.account import coefficients, whole_maps
from ertel.equations.state import Method, State, Work, combined, interpolated
from ertel.numerics import bdf
from ertel.results.dataset import Frame

UNLOADED = 1e-8  # F below which the ball has left
SAME_TIME = 1e-9  # t0: two maps closer than this are one


@dataclass(frozen=True)
class StepLimits:
    """Limits of the step, in t0.

    first: of an impact, as a share of the initial gap.  cut: after a step that did not converge.  of_period: share of
    the period of an oscillating signal; 16 steps a period meet its extremes within 1 - cos(pi/16) = 2 %, and a parabola
    through three of them misses the next value visibly, so that the error control sees the oscillation.
    """

    first: float = 0.01
    largest: float = 0.1  # the impact lasts about 3
    smallest: float = 1e-7
    cut: float = 0.5
    of_period: float = 1 / 16


@dataclass(frozen=True)
class Counts:
    """Work done so far; convolutions count by nodes of the finest grid."""

    steps: int = 0
    newton_iterations: int = 0
    krylov_iterations: int = 0
    convolutions: float = 0.0
    rejected: int = 0

    def plus(self, work: Work) -> "Counts":
        return replace(
            self,
            newton_iterations=self.newton_iterations + work.newton,
            krylov_iterations=self.krylov_iterations + work.krylov,
            convolutions=self.convolutions + work.convolutions,
        )


@dataclass(frozen=True)
class RunState:
    """Everything that a run needs to continue: the last time levels (newest first), the next step, the past events."""

    levels: tuple[State, ...]
    next_step: float
    counts: Counts = Counts()
    next_frame: int = 1
    max_approach: Mapping[str, float] | None = None


@dataclass(frozen=True)
class Step:
    """One accepted time step: the state after it, its scalars, its maps, and the progress of the run."""

    state: RunState
    record: Mapping[str, float]
    frames: tuple[Frame, ...]
    status: Status


def begin(case: Case, method: Method, limits: StepLimits) -> Step:
    """The run before its first step, without a record; the film from which rolling starts is worth a map."""
    start = method.start()
    step = case.schedule.step or min(limits.first * abs(case.schedule.start_approach), _longest(case, limits))
    state = RunState((start,), step, Counts().plus(start.work), next_frame=1 if case.starts_apart else 0)
    return Step(state, {}, (), Status.RUNNING if start.status.ok else start.status)


# -- one step -------------------------------------------------------------------------------------------------------


def next_step(case: Case, method: Method, state: RunState, limits: StepLimits) -> Generator[Any, Any, Step]:
    """The next accepted step after one or more attempts: yields their problems and receives the solutions.

    Where the step would become too small it returns the last state again, with that status and without a record.
    """
    fixed = case.schedule.step
    step = fixed or state.next_step
    counts = state.counts
    while step >= limits.smallest:
        length = _landing(case, state.levels[0].T, step, limits)
        new = yield from method.attempt(state.levels, length)
        counts = counts.plus(new.work)
        if not new.status.ok:
            step, counts = limits.cut * length, replace(counts, rejected=counts.rejected + 1)
            continue
        error = 0.0 if fixed else _error(case, state.levels, new)
        if not fixed and not error <= bdf.REJECTED:
            step, counts = bdf.adapted(length, error), replace(counts, rejected=counts.rejected + 1)
            continue
        following = fixed or min(bdf.adapted(length, error), _longest(case, limits))
        return _accept(case, method, state, new, replace(counts, steps=counts.steps + 1), following, error)
    return Step(replace(state, counts=counts), {}, (), Status.STEP_TOO_SMALL)


def _landing(case: Case, T: float, step: float, limits: StepLimits) -> float:
    """The step, changed to end on the next stop where that is near: a knot of a signal, or an end given as a time.

    An adaptive step that would leave less than its own length is halved, so that no very short step follows.  A stop
    nearer than the smallest step counts as reached.
    """
    end = inf if isinstance(case.schedule.until, str) else case.schedule.until
    remaining = min(case.motion.next_knot(T + limits.smallest), end) - T
    if remaining < step * (1 + 1e-9):
        return remaining
    return remaining / 2 if remaining < 2 * step and not case.schedule.step else step


def _longest(case: Case, limits: StepLimits) -> float:
    """The longest adaptive step."""
    return min(limits.largest, limits.of_period * case.motion.shortest_period)


def _error(case: Case, levels: Sequence[State], new: State) -> float:
    """Local error of Delta, V and the film in units of the tolerance, from the prediction (see `bdf.error_factor`).

    Without inertia V is no unknown of its own, and may jump.
    """
    if len(levels) < 3:
        return 1.0  # too little history; keep the step
    times = [level.T for level in levels]
    predict = bdf.interpolation_weights(new.T, times)
    approach, velocity = (combined(predict, [getattr(o, name) for o in levels]) for name in ("approach", "velocity"))
    of_speed = abs(new.velocity - velocity) if case.motion.inertia else 0.0
    difference = max(abs(new.approach - approach), of_speed, new.error)
    return float(bdf.error_factor([new.T, *times]) * difference / case.schedule.tolerance)


def _accept(
    case: Case, method: Method, state: RunState, new: State, counts: Counts, following: float, error: float
) -> Step:
    levels = (new, *state.levels)[:3]
    frames, next_frame = _due_frames(case, method, levels, state.next_frame)
    reached = state.max_approach
    if case.starts_apart and reached is None and levels[0].velocity <= 0.0 < levels[1].velocity:
        peak = interpolated(levels, turning_time(levels))
        friction = method.friction(peak)
        reached = {"T": peak.T, "Delta": peak.approach, **method.measure(peak), **coefficients(friction)}
        frames.append(Frame(peak.T, whole_maps(method.whole, peak.fields, friction), "max-approach"))
    status = Status.CONVERGED if _ended(case, new, new.record["F"], reached) else Status.RUNNING
    if status is Status.CONVERGED and case.schedule.until != "max-approach":
        frames.append(frame_of(method, new, "end"))
    spent = {
        name: float(value - getattr(state.counts, name)) for name, value in vars(counts).items() if name != "steps"
    }
    record = {
        "T": new.T,
        "dT": levels[0].T - levels[1].T,
        "Delta": new.approach,
        "V": new.velocity,
        **new.record,
        "U": case.motion.entrainment(new.T),
        "w": case.motion.load(new.T),
        "error": error,
        **spent,
    }
    return Step(RunState(levels, following, counts, next_frame, reached), record, _each_time_once(frames), status)


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
    """The time at which V = 0 between the last two levels, by bisection of its parabola."""
    times = [level.T for level in levels]
    V = np.array([level.velocity for level in levels])
    late, early = times[0], times[1]
    for _ in range(60):
        middle = (early + late) / 2
        early, late = (middle, late) if bdf.interpolation_weights(middle, times) @ V > 0 else (early, middle)
    return (early + late) / 2


def _due_frames(case: Case, method: Method, levels: Sequence[State], number: int) -> tuple[list[Frame], int]:
    """The maps since the previous step, at multiples of the interval."""
    frames = []
    while number * case.schedule.interval <= levels[0].T:
        frames.append(frame_of(method, interpolated(levels, number * case.schedule.interval), ""))
        number += 1
    return frames, number


def _each_time_once(frames: Sequence[Frame]) -> tuple[Frame, ...]:
    """The maps in order of time; of two at the same time the one of an event."""
    events = [frame.T for frame in frames if frame.event]
    kept = [frame for frame in frames if frame.event or all(abs(frame.T - T) > SAME_TIME for T in events)]
    return tuple(sorted(kept, key=lambda frame: frame.T))


def frame_of(method: Method, level: State, event: str) -> Frame:
    """The maps of a level."""
    return Frame(level.T, whole_maps(method.whole, level.fields, method.friction(level)), event)
