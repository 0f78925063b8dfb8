"""Time steps end where they must: on the knots of signals, several times a period, at the end; maps are kept once."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from cases import OIL, rolled, steps_of

from ertel.case.case import Case
from ertel.case.methods import METHODS
from ertel.case.sections import Drive, Output, Time
from ertel.case.status import Status
from ertel.equations.account import Friction
from ertel.equations.state import State, Stepper, combined
from ertel.numerics import bdf
from ertel.physics.motion import Oscillation, Polyline, Signal
from ertel.physics.scales import Parameters
from ertel.runs.drive import Recorder, drive
from ertel.runs.stepping import TransientRun

PULSE = Polyline(((0.0, 1.0), (1.0, 1.0), (1.02, 3.0), (1.04, 1.0)))


class LikeTheLoad(Stepper):
    """A contact whose approach and film are the load of the moment: every step is exact and costs nothing."""

    def __init__(self, case: Case):
        self.load = case.motion.load
        self.coordinates = {"Y": np.zeros(1), "X": np.zeros(1)}

    def _state(self, T: float) -> State:
        field = np.full((1, 1), self.load(T))
        return State(T, self.load(T), 0.0, {"P": field, "H": field, "mass": field})

    def start(self) -> State:
        return self._state(0.0)

    def advance(self, levels: Sequence[State], step: float) -> State:
        new = self._state(levels[0].T + step)
        weights = bdf.interpolation_weights(new.T, [level.T for level in levels])
        error = abs(new.H - combined(weights, [level.H for level in levels])).max()
        record = self.measure(new)
        return replace(new, error=float(error), record=record)

    def measure(self, level: State) -> dict[str, float]:
        names = ("F", "P_c", "P_max", "X_P_max", "Y_P_max", "P_fall", "H_c", "H_min", "X_min", "Y_min")
        return dict.fromkeys(names, float(level.H[0, 0]))

    def friction(self, level: State) -> Friction:
        return Friction(np.zeros((2, 1, 1)), np.zeros((1, 1)), np.zeros(2), np.zeros(2), np.zeros(()))

    def whole(self, field: object, odd: bool = False) -> object:
        return field


def rolling(time: Time, output: Output | None = None, load: Signal | None = None, speed: Signal | None = None) -> Case:
    case = rolled(Parameters.from_moes(20, 5), OIL, METHODS["transient"].defaults, Drive(load, speed), time=time)
    return case if output is None else Case(case.contact, case.oil, case.solver, case.drive, (), time, output)


def times(case: Case) -> np.ndarray:
    return np.array([step.record["T"] for step in steps_of(case, LikeTheLoad(case))])


@pytest.mark.parametrize("step", [None, 0.03])
@pytest.mark.parametrize("name", ["load", "speed"])
def test_steps_end_on_the_knots_of_a_signal(name: str, step: float | None) -> None:
    """A pulse between two steps would not be felt at all."""
    T = times(rolling(Time(until=2.0, step=step), **{name: PULSE}))
    for knot in (1.0, 1.02, 1.04, 2.0):
        assert np.abs(T - knot).min() < 1e-12


def test_steps_are_fixed_never_very_short_and_feel_a_pulse() -> None:
    """The way to it is divided evenly instead."""
    T = times(rolling(Time(until=2.0), speed=Polyline(((0.0, 1.0), (1.0301, 1.0), (1.2, 0.9)))))
    assert np.abs(T - 1.0301).min() < 1e-12
    assert np.diff(T[T > 0.2]).min() > 0.04
    case = rolling(Time(until=2.0), load=PULSE)
    steps = steps_of(case, LikeTheLoad(case))
    assert max(step.record["w"] for step in steps) == 3.0
    assert 0 < sum(step.record["rejected"] for step in steps) < 20
    assert 1.0 < max(step.record["error"] for step in steps) <= bdf.REJECTED
    np.testing.assert_allclose(np.diff(times(rolling(Time(until=1.5, step=0.05)))), 0.05, rtol=1e-9)
    # Also where the steps would fall on the same phase of every period, so that the swing is not seen.
    T = times(rolling(Time(until=1.0, tolerance=0.5), load=Oscillation(1.0, 0.5, 0.1)))
    assert np.diff(T).max() <= 0.1 / 16 * (1 + 1e-9)


class Unwilling(LikeTheLoad):
    def advance(self, levels: Sequence[State], step: float) -> State:
        new = super().advance(levels, step)
        return new if step <= 0.02 else replace(new, status=Status.NEWTON_STALLED)


def test_a_step_that_fails_is_repeated_smaller() -> None:
    case = rolling(Time(until=0.2, step=0.05))
    records = [step.record for step in steps_of(case, Unwilling(case))]
    assert records[-1]["T"] == pytest.approx(0.2)
    assert max(record["dT"] for record in records) <= 0.02
    assert sum(record["rejected"] for record in records) > 0


class Lost(LikeTheLoad):
    """A method one number of which is not a number after a while."""

    def __init__(self, case: Case, lost: str):
        super().__init__(case)
        self.lost = lost

    def advance(self, levels: Sequence[State], step: float) -> State:
        new = super().advance(levels, step)
        return new if new.T < 0.3 else replace(new, **{self.lost: float("nan")})


@pytest.mark.parametrize("lost", ["approach", "error"])
def test_an_error_that_is_no_number_is_not_accepted(lost: str) -> None:
    """Shorter steps are tried, as after one that fails."""
    case = rolling(Time(until=2.0))
    *_, last = steps_of(case, Lost(case, lost))
    assert last.status is Status.STEP_TOO_SMALL and 0.29 < last.state.levels[0].T < 0.3
    assert last.state.counts.rejected > 5


@pytest.mark.parametrize("interval", [0.1, 0.25])
@pytest.mark.parametrize("step", [None, 0.05])
def test_the_last_map_is_kept_once(interval: float, step: float | None) -> None:
    case = rolling(Time(until=1.5, step=step), Output(interval=interval))
    run = TransientRun(case, LikeTheLoad(case))
    recorder = Recorder(run)
    drive(run, [recorder])
    frames = recorder.frames
    assert [frame.event for frame in frames][-2:] == ["", "end"]
    assert frames[-1].T == pytest.approx(1.5, rel=1e-12)
    assert len(frames) == round(1.5 / interval) + 1
    assert np.diff([frame.T for frame in frames]).min() > 0.9 * interval
