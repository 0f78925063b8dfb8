"""Runs in time: steps with error control, attempts until one is accepted, events, and maps at given times.

Nothing here loops over a run (`drive`), and nothing solves (`solvers`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.equations.account import coefficients, whole_maps
from ertel.equations.state import State, Stepper, Work, combined, interpolated
from ertel.numerics import bdf
from ertel.results.dataset import Frame, assemble
from ertel.results.summary import impact_summary, rolling_summary

UNLOADED = 1e-8  # F below which the ball has left
SAME_TIME = 1e-9  # t0: two maps closer than this are one
NUMBERS = ("T", "approach", "velocity", "load", "outside")  # of a State, besides its fields
REACHED = "max_approach_"  # how the names of numbers at maximum approach begin in a checkpoint

Arrays = Mapping[str, NDArray[Any]]


class Progress(NamedTuple):
    """The progress of a run.

    T: time in t0, None of a steady contact.  step: the number of time steps, or of grids.  done: the approximate
    fraction of the run, 0 to 1.  message: the last result as one line of text.
    """

    T: float | None
    step: int
    done: float
    message: str


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


class TransientRun:
    """An impact, or rolling in time from the steady film.

    A run of either kind gives one result after the other, a `Step` or a `GridStep`.  Each has a record, scalars by
    name; frames, the maps that fell due; and the status of the run after it.
    """

    def __init__(self, case: Case, method: Stepper, limits: StepLimits | None = None):
        self.case, self.method, self.limits = case, method, limits or StepLimits()

    def begin(self) -> Step:
        """The result before the first step, without a record; the film from which rolling starts is worth a map."""
        start, schedule = self.method.start(), self.case.schedule
        step = schedule.step or min(self.limits.first * abs(schedule.start_approach), self._longest)
        state = RunState((start,), step, Counts().plus(start.work), next_frame=1 if self.case.starts_apart else 0)
        return Step(state, {}, (), Status.RUNNING if start.status.ok else start.status)

    def advance(self, result: Step) -> Step:
        """Return the next accepted step, after one or more attempts.

        Where the step would become too small it returns the last state again, with that status and without a record.
        """
        fixed, limits, state = self.case.schedule.step, self.limits, result.state
        step = fixed or state.next_step
        counts = state.counts
        while step >= limits.smallest:
            length = self._landing(state.levels[0].T, step)
            new = self.method.advance(state.levels, length)
            counts = counts.plus(new.work)
            if not new.status.ok:
                step, counts = limits.cut * length, replace(counts, rejected=counts.rejected + 1)
                continue
            error = 0.0 if fixed else self._error(state.levels, new)
            if not fixed and not error <= bdf.REJECTED:
                step, counts = bdf.adapted(length, error), replace(counts, rejected=counts.rejected + 1)
                continue
            following = fixed or min(bdf.adapted(length, error), self._longest)
            return self._accept(state, new, replace(counts, steps=counts.steps + 1), following, error)
        return Step(replace(state, counts=counts), {}, (), Status.STEP_TOO_SMALL)

    # -- one step -----------------------------------------------------------------------------------------------------

    def _landing(self, T: float, step: float) -> float:
        """The step, changed to end on the next stop where that is near: a knot of a signal, or an end given as a time.

        An adaptive step that would leave less than its own length is halved, so that no very short step follows.  A
        stop nearer than the smallest step counts as reached.
        """
        schedule = self.case.schedule
        end = inf if isinstance(schedule.until, str) else schedule.until
        remaining = min(self.case.motion.next_knot(T + self.limits.smallest), end) - T
        if remaining < step * (1 + 1e-9):
            return remaining
        return remaining / 2 if remaining < 2 * step and not schedule.step else step

    @property
    def _longest(self) -> float:
        """The longest adaptive step."""
        return min(self.limits.largest, self.limits.of_period * self.case.motion.shortest_period)

    def _error(self, levels: Sequence[State], new: State) -> float:
        """Local error of Delta, V and the film in units of the tolerance, from the prediction (`bdf.error_factor`).

        Without inertia V is not an unknown of its own, and may jump.
        """
        if len(levels) < 3:
            return 1.0  # too little history; keep the step
        times = [level.T for level in levels]
        predict = bdf.interpolation_weights(new.T, times)
        approach = combined(predict, [level.approach for level in levels])
        velocity = combined(predict, [level.velocity for level in levels])
        of_speed = abs(new.velocity - velocity) if self.case.motion.inertia else 0.0
        difference = np.max([abs(new.approach - approach), of_speed, new.error])  # nan where one of them is
        return float(bdf.error_factor([new.T, *times]) * difference / self.case.schedule.tolerance)

    def _accept(self, state: RunState, new: State, counts: Counts, following: float, error: float) -> Step:
        case, method, levels = self.case, self.method, (new, *state.levels)[:3]
        frames, number, interval = [], state.next_frame, case.schedule.interval
        while number * interval <= new.T:
            frames.append(frame_of(method, interpolated(levels, number * interval), ""))
            number += 1
        reached = state.max_approach
        if case.starts_apart and reached is None and levels[0].velocity <= 0.0 < levels[1].velocity:
            peak = interpolated(levels, turning_time(levels))
            friction = method.friction(peak)
            reached = {"T": peak.T, "Delta": peak.approach, **method.measure(peak), **coefficients(friction)}
            frames.append(Frame(peak.T, whole_maps(method.whole, peak.fields, friction), "max-approach"))
        status = Status.CONVERGED if self._ended(new, reached) else Status.RUNNING
        if status is Status.CONVERGED and case.schedule.until != "max-approach":
            frames.append(frame_of(method, new, "end"))
        before = vars(state.counts)
        record = {
            "T": new.T,
            "dT": levels[0].T - levels[1].T,
            "Delta": new.approach,
            "V": new.velocity,
            **new.record,
            "F_outside": new.outside / case.geometry.hertz_load,
            "U": case.motion.entrainment(new.T),
            "w": case.motion.load(new.T),
            "error": error,
            **{name: float(value - before[name]) for name, value in vars(counts).items() if name != "steps"},
        }
        return Step(RunState(levels, following, counts, number, reached), record, _each_time_once(frames), status)

    def _ended(self, level: State, reached: Mapping[str, float] | None) -> bool:
        match self.case.schedule.until:
            case "max-approach":
                return reached is not None
            case "rebound":
                # oil that a moving track drags along never lets go of the ball: back where it started it has left
                back = level.approach < self.case.schedule.start_approach
                return reached is not None and (back or level.record["F"] < UNLOADED)
            case until:
                return level.T >= until * (1 - 1e-12)

    # -- what is shown and kept ---------------------------------------------------------------------------------------

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


def _each_time_once(frames: Sequence[Frame]) -> tuple[Frame, ...]:
    """The maps in order of time; of two at the same time the one of an event."""
    events = [frame.T for frame in frames if frame.event]
    kept = [frame for frame in frames if frame.event or all(abs(frame.T - T) > SAME_TIME for T in events)]
    return tuple(sorted(kept, key=lambda frame: frame.T))


def frame_of(method: Stepper, level: State, event: str) -> Frame:
    """The maps of a level."""
    return Frame(level.T, whole_maps(method.whole, level.fields, method.friction(level)), event)
