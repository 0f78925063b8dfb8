"""The laws for the approach Delta, and the dry impact that Newton's law must reproduce."""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from ertel.equations.approach import NewtonsLaw, balanced, rate_of_change
from ertel.numerics.bdf import derivative_weights
from ertel.physics import hertz
from ertel.physics.dry_contact import HERTZ_LOAD
from ertel.physics.motion import FREE_BALL, STEADY_ROLLING, Oscillation, constant
from ertel.physics.scales import impact_scales

BALL = NewtonsLaw(FREE_BALL.inertia, FREE_BALL.load)
NEWTON = 15 / (8 * pi)  # of Delta'' = - NEWTON * double integral of P


def dry_impact(step: float, end: float = 3.2, start: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """T, Delta and V of the dry impact by BDF2 (first step BDF1): F = (2 pi/3) Delta^{3/2} closes Newton's law."""
    law = BALL
    T, Delta, V = [start], [start], [1.0]
    for k in range(1, round((end - start) / step) + 1):
        T.append(start + k * step)
        rates = derivative_weights(T[:-4:-1])
        earlier = Delta[::-1][: len(rates) - 1]
        line = law.line(T[-1], rates, earlier, V[::-1][: len(rates) - 1])

        def misfit(new, line=line):
            return line.approach_weight * new + line.load_weight * HERTZ_LOAD * float(hertz.load(new)) - line.value

        new = brentq(misfit, -3.0, 3.0, xtol=1e-15, rtol=1e-14)
        V.append(rate_of_change(rates, new, earlier))
        Delta.append(new)
    return np.array(T), np.array(Delta), np.array(V)


def maximum(T: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Where and how high the parabola through the largest value and its neighbours is (equal steps)."""
    k = int(np.argmax(y))
    slope, bend = (y[k + 1] - y[k - 1]) / 2, y[k + 1] - 2 * y[k] + y[k - 1]
    return float(T[k] - slope / bend * (T[1] - T[0])), float(y[k] - slope**2 / (2 * bend))


def parting(T: np.ndarray, Delta: np.ndarray) -> float:
    """When Delta comes back to zero: inverse interpolation through four points."""
    k = int(np.flatnonzero((Delta[:-1] > 0) & (Delta[1:] <= 0))[-1])
    near = slice(k - 1, k + 3)
    return float(np.polynomial.Polynomial.fit(Delta[near], T[near], 3)(0.0))


def test_constants():
    """15/(8 pi) times the dry load 2 pi/3 is 5/4, and energy then lets the ball reach Delta = 1.

    The paper's 3/(2 pi) belongs to another unit of time: with it the dry ball would go to (5/4)^{2/5} = 1.093.
    """
    assert pytest.approx(1 / BALL.inertia, rel=1e-15) == NEWTON * HERTZ_LOAD
    assert NEWTON * HERTZ_LOAD * 2 / 5 == pytest.approx(0.5, rel=1e-15)
    assert (0.5 / (3 / (2 * pi) * HERTZ_LOAD * 2 / 5)) ** 0.4 == pytest.approx(1.25**0.4)


@given(st.floats(1e-3, 1.0), st.floats(1e-4, 10.0), st.floats(1e-3, 10.0), st.floats(1e9, 1e12))
def test_newtons_coefficient_follows_from_the_scales(R, mass, speed, E_prime):
    """m delta*/t0^2 Delta'' = -p_h a^2 F."""
    s = impact_scales(R, mass, speed, E_prime)
    assert pytest.approx(s.p_h * s.a**2 * s.t0**2 / (mass * s.film), rel=1e-12) == NEWTON


def test_dry_impact_reaches_one_and_lasts_2_943275():
    T, Delta, V = dry_impact(step=0.0025)
    top_time, top = maximum(T, Delta)
    assert top == pytest.approx(1.0, abs=5e-6)
    assert top_time == pytest.approx(hertz.HALF_CONTACT_TIME, abs=2e-5)
    assert parting(T, Delta) == pytest.approx(2.943275, abs=3e-5)
    assert V[-1] == pytest.approx(-1.0, abs=2e-5)


@pytest.mark.parametrize("start", [-1.0, 0.0])
def test_dry_impact_is_second_order_in_time(start):
    """Delta and V at all times up to the parting, the maximum and the contact time, from four steps."""
    errors = []
    for step in (0.02, 0.01, 0.005, 0.0025):
        T, Delta, V = dry_impact(step, start=start)
        touching = T < hertz.CONTACT_TIME
        errors.append(
            [
                np.max(np.abs(Delta - hertz.approach(T))[touching]),
                np.max(np.abs(V - hertz.velocity(T))[touching]),
                abs(maximum(T, Delta)[1] - 1.0),
                abs(parting(T, Delta) - hertz.CONTACT_TIME),
            ]
        )
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert_allclose(orders, 2.0, atol=0.1)


TIMES = st.lists(st.floats(0.01, 0.5), min_size=3, max_size=3).map(lambda steps: [1.0, *(1.0 - np.cumsum(steps))])
NUMBERS = st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=2)


@given(TIMES, NUMBERS, NUMBERS, st.floats(-2.0, 2.0), st.sampled_from([2, 3]))
def test_newtons_line_is_both_backward_differences_at_once(times, approaches, velocities, Delta, count):
    """Any Delta with the F of the line satisfies V = Delta' and V' = -NEWTON F in backward differences."""
    rates = derivative_weights(times[:count])
    approaches, velocities = approaches[: count - 1], velocities[: count - 1]
    line = BALL.line(times[0], rates, approaches, velocities)
    F = (line.value - line.approach_weight * Delta) / line.load_weight
    V = rate_of_change(rates, Delta, approaches)
    scale = 1 + np.sum(np.abs(rates)) ** 2
    assert pytest.approx(rates @ [Delta, *approaches], abs=1e-12 * scale) == V
    assert rates @ [V, *velocities] == pytest.approx(-NEWTON * F, abs=1e-12 * scale)


def test_forces_without_a_film():
    """None: the ball moves straight on.  A constant one: inertia Delta'' = w, exact for a parabola."""
    T, Delta, V = dry_impact(step=0.05, start=-1.0, end=0.0)
    assert_allclose(Delta, T, atol=1e-13)
    assert_allclose(V, 1.0, atol=1e-12)
    law, T = NewtonsLaw(0.5, constant(2.0)), np.array([0.5, 0.4, 0.2])
    line = law.line(T[0], derivative_weights(T), list(2.0 * T[1:] ** 2), list(4.0 * T[1:]))
    assert line.value / line.approach_weight == pytest.approx(2.0 * T[0] ** 2, rel=1e-12)


@given(TIMES, st.floats(0.01, 10.0), st.floats(0.1, 2.0))
def test_a_ball_at_rest_carries_the_load_that_is_applied(times, inertia, load):
    """Delta constant: F = w(T), at every inertia; without any whatever the motion was before."""
    rolling = NewtonsLaw(STEADY_ROLLING.inertia, STEADY_ROLLING.load)
    assert rolling.line(0.5, derivative_weights([0.5, 0.4, 0.2]), [0.9, 0.8], [1.0, 2.0]) == balanced()
    law = NewtonsLaw(inertia, Oscillation(load, 0.1, 2.0))
    line = law.line(times[0], derivative_weights(times[:3]), [0.9, 0.9], [0.0, 0.0])
    F = (line.value - 0.9 * line.approach_weight) / line.load_weight / HERTZ_LOAD
    assert pytest.approx(law.load(times[0]), abs=1e-9 * (1 + line.approach_weight)) == F
