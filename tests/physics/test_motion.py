"""What drives a contact: signals and their integrals, and how far the surfaces travel."""

from dataclasses import replace
from math import copysign, isclose, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from ertel.physics.motion import (
    FREE_BALL,
    STEADY_ROLLING,
    Motion,
    Oscillation,
    Polyline,
    Signal,
    SlidingRatio,
    Smooth,
    constant,
    reversed_sign,
)
from ertel.physics.units import Quantity

numbers = st.floats(-3.0, 3.0)
points = st.tuples(st.floats(-2.0, 5.0), numbers)
polylines = st.lists(points, min_size=1, max_size=5, unique_by=lambda point: round(point[0], 2))
simple = st.one_of(
    polylines.map(lambda points: Polyline(tuple(sorted(points)))),
    polylines.map(lambda points: Smooth(tuple(sorted(points)))),
    st.builds(Oscillation, numbers, numbers, st.floats(0.3, 5.0), numbers),
)
signals = st.one_of(simple, st.builds(SlidingRatio, simple, simple))


@given(signals, st.floats(-1.0, 6.0))
def test_the_integral_is_the_integral(signal: Signal, T: float) -> None:
    knots = sorted({t for t in signal.breaks() if min(0, T) < t < max(0, T)})
    expected, _ = quad(signal, 0.0, T, points=knots or None, limit=200)
    assert isclose(signal.integral(T), expected, rel_tol=1e-7, abs_tol=1e-7)


@given(signals, st.floats(0.1, 6.0), st.floats(0.0, 1.0))
def test_the_range_holds_every_value(signal: Signal, until: float, share: float) -> None:
    low, high = signal.range(until)
    assert low - 1e-12 <= signal(share * until) <= high + 1e-12


def test_a_smooth_signal_has_a_slope_without_jumps_and_no_overshoot() -> None:
    """And needs a step that ends with it at its ends alone."""
    points = ((0.0, 1.0), (1.0, 1.0), (1.5, 2.0), (2.0, 2.0), (4.0, 0.5))
    signal, e = Smooth(points), 1e-6
    assert [signal(T) for T, _ in points] == pytest.approx([value for _, value in points])
    assert (signal(-1.0), signal(9.0), signal.range(9.0)) == (1.0, 0.5, (0.5, 2.0))
    for T in (1.0, 1.5, 2.0):
        before, after = (signal(T) - signal(T - e)) / e, (signal(T + e) - signal(T)) / e
        assert before == pytest.approx(after, abs=1e-4)
    times = np.linspace(0.0, 4.0, 401)
    assert (np.diff(signal.at(times)[times <= 2.0]) >= 0.0).all() and signal.at(times).min() >= 0.5
    assert (signal.knots(), len(Polyline(points).knots())) == ((0.0, 4.0), 5)


def test_values_of_signals_and_motions() -> None:
    """A polyline is constant outside its points, an oscillation starts at its phase."""
    start_up = Polyline(((1.0, 0.2), (2.0, 1.0)))
    assert [start_up(T) for T in (0.0, 1.0, 1.5, 2.0, 9.0)] == pytest.approx([0.2, 0.2, 0.6, 1.0, 1.0])
    assert Oscillation(1.0, 0.5, 2.0, pi / 2)(0.0) == pytest.approx(1.5)
    assert Motion(constant(0.0), constant(0.0), 0.8) == FREE_BALL
    assert Motion(constant(1.0), constant(1.0), 0.0) == STEADY_ROLLING


def test_what_is_no_signal_is_refused() -> None:
    for points in ((), ((1.0, 0.0), (1.0, 1.0)), ((2.0, 0.0), (1.0, 1.0))):
        with pytest.raises(ValueError, match=r"^points: .*rising T"):
            Polyline(points)
    with pytest.raises(ValueError, match=r"^period = 0"):
        Oscillation(1.0, 0.1, 0.0)


@given(st.floats(-2.0, 2.0), st.floats(0.0, 5.0))
def test_the_surfaces_travel_at_their_own_speeds(slide_to_roll: float, T: float) -> None:
    """u1 - u2 = S u_m, and their mean is u_m."""
    motion = replace(STEADY_ROLLING, sliding=constant(slide_to_roll))
    first, second = motion.travel(1, T), motion.travel(2, T)
    assert isclose((first + second) / 2, T, abs_tol=1e-12)
    assert isclose(first - second, slide_to_roll * T, abs_tol=1e-12)


@given(simple, simple, st.floats(-1.0, 6.0))
def test_the_surfaces_travel_with_the_integral_of_their_speeds(U: Signal, ratio: Signal, T: float) -> None:
    """A slide-to-roll ratio that changes in time, as a product or as the sliding speed itself."""
    motion = Motion(constant(1.0), U, 0.0, SlidingRatio(ratio, U))
    knots = sorted({t for t in motion.sliding.breaks() if min(0, T) < t < max(0, T)}) or None
    speed = quad(lambda t: U(t) * (1.0 + ratio(t) / 2.0), 0.0, T, points=knots, limit=200)[0]
    assert isclose(motion.travel(1, T), speed, rel_tol=1e-6, abs_tol=1e-6)
    assert motion.slide_to_roll == ratio(0.0)


@given(signals, st.floats(-1.0, 6.0))
def test_the_reverse_of_a_signal_is_its_negative(signal: Signal, T: float) -> None:
    back = reversed_sign(signal)
    assert back(T) == pytest.approx(-signal(T), abs=1e-12)
    assert back.integral(T) == pytest.approx(-signal.integral(T), abs=1e-12)
    assert back.range(6.0) == pytest.approx([-value for value in reversed(signal.range(6.0))], abs=1e-12)


def test_seconds_are_not_the_time_of_a_case() -> None:
    """A signal may be given in seconds; its values are asked for when it has come to units t0."""
    swing, line = Oscillation(1.0, 0.1, Quantity(0.002, "s")), Polyline(((Quantity(0.0, "s"), 1.0), (1.0, 2.0)))
    for signal in (swing, line):
        with pytest.raises(TypeError, match="is in SI"):
            signal(0.5)


def test_a_rest_keeps_the_sign_of_the_flow_before() -> None:
    """Which says on which side the oil outside ruptured."""
    for U in (1.0, -0.5):
        motion = Motion(constant(1.0), Polyline(((0.0, U), (1.0, 0.0))), 0.0)
        assert motion.flow_at(0.5) == U / 2
        assert motion.flow_at(3.0) == 0.0 and copysign(1.0, motion.flow_at(3.0)) == copysign(1.0, U)
