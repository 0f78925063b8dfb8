"""BDF2 on variable steps: exact for what it must be exact for, of the order claimed, stable, honest on its error."""

from collections.abc import Callable
from math import sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from numpy.testing import assert_allclose

from ertel.numerics import bdf
from ertel.numerics.bdf import derivative_weights, error_factor, interpolation_weights

STEPS = st.lists(st.floats(0.01, 1.0), min_size=4, max_size=4)
COEFFICIENTS = st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4)


def times_of(steps: list[float], now: float = 0.3) -> list[float]:
    """The newest time and those before it, the newest first."""
    return [now, *(now - np.cumsum(steps))]


# --- polynomials ----------------------------------------------------------------------------------------------------


@given(STEPS, COEFFICIENTS, st.integers(1, 4), st.floats(-1.0, 1.0))
def test_interpolation_is_exact_for_polynomials(steps, coefficients, count, t):
    y = Polynomial(coefficients[:count])
    times = times_of(steps)[:count]
    weights = interpolation_weights(t, times)
    scale = np.sum(np.abs(weights)) * 20
    assert weights @ y(np.array(times)) == pytest.approx(y(t), abs=1e-11 * scale)


@given(STEPS, COEFFICIENTS, st.integers(2, 4))
def test_derivative_is_exact_for_polynomials(steps, coefficients, count):
    y = Polynomial(coefficients[:count])
    times = times_of(steps)[:count]
    weights = derivative_weights(times)
    scale = np.sum(np.abs(weights)) * 20
    assert weights @ y(np.array(times)) == pytest.approx(y.deriv()(times[0]), abs=1e-11 * scale)


def test_equal_steps_give_the_textbook_weights():
    assert_allclose(derivative_weights([0.2, 0.1]), [10.0, -10.0])
    assert_allclose(derivative_weights([0.2, 0.1, 0.0]), np.array([1.5, -2.0, 0.5]) / 0.1)
    assert_allclose(interpolation_weights(0.3, [0.2, 0.1, 0.0]), [3.0, -3.0, 1.0])
    assert error_factor([0.3, 0.2, 0.1, 0.0]) == pytest.approx((4 / 3) / (4 / 3 + 6))


# --- the error estimate ---------------------------------------------------------------------------------------------


@given(st.lists(st.floats(0.05, 1.0), min_size=3, max_size=3), st.floats(-2.0, 2.0).filter(lambda c: abs(c) > 0.1))
def test_error_factor_is_exact_for_cubics(steps, c):
    """y = c t^3 + a parabola: one BDF2 step from exact values misses y by exactly the estimate."""
    times = np.array(times_of(steps))
    y = Polynomial([0.7, -0.4, 1.1, c])
    weights = derivative_weights(times[:3])
    solution = (y.deriv()(times[0]) - weights[1:] @ y(times[1:3])) / weights[0]
    prediction = interpolation_weights(times[0], times[1:]) @ y(times[1:])
    estimate = error_factor(times) * (solution - prediction)
    assert estimate == pytest.approx(solution - y(times[0]), rel=1e-8, abs=1e-12)


# --- orders ---------------------------------------------------------------------------------------------------------


def solve_linear(rate: float, force, y0: float, times: np.ndarray) -> np.ndarray:
    """y' = -rate (y - force(t)) by BDF2, the first step by BDF1."""
    ys = [y0]
    for k in range(1, len(times)):
        weights = derivative_weights(times[k::-1][:3])
        past = weights[1:] @ ys[::-1][: len(weights) - 1]
        ys.append((rate * force(times[k]) - past) / (weights[0] + rate))
    return np.array(ys)


def orders(times: list[np.ndarray], exact: Callable[[Any], Any], since: int, **equation: Any) -> np.ndarray:
    """Orders of the largest error since a time level."""
    found = [solve_linear(y0=1.0, times=each, **equation) for each in times]
    errors = np.array([np.abs(y - exact(each))[since:].max() for y, each in zip(found, times, strict=True)])
    return np.log2(errors[:-1] / errors[1:])


@pytest.mark.parametrize("rate", [1.0, 1e4])  # mild and stiff
def test_second_order_on_variable_steps(rate):
    """Steps that swing smoothly, and between neighbours by up to a factor 1.5 on the coarsest grid.

    At the end time: in the stiff case the first step, by BDF1, is of lower order and is soon forgotten.
    """
    s = [np.linspace(0.0, 1.0, count + 1) for count in (40, 80, 160, 320)]
    times = [2.0 * (each + 0.1 * np.sin(2 * np.pi * each)) for each in s]

    def exact(t):
        return np.cos(3 * t)

    found = orders(times, exact, -1, rate=rate, force=lambda t: exact(t) - 3 * np.sin(3 * t) / rate)
    assert np.all(found >= 1.9)
    assert found[-1] == pytest.approx(2.0, abs=0.15)


def test_second_order_on_erratic_steps():
    """Steps that jump at random by up to a factor 2, every grid from the same jumps halved."""
    jumps = np.random.default_rng(7).uniform(1.0, 2.0, 40)
    steps = [np.repeat(jumps, 2**level) for level in range(4)]
    times = [np.concatenate([[0.0], np.cumsum(each)]) * 2.0 / each.sum() for each in steps]
    assert_allclose(orders(times, lambda t: np.exp(-t), 0, rate=1.0, force=lambda t: 0.0), 2.0, atol=0.15)


# --- stability and step control -------------------------------------------------------------------------------------


def test_the_allowed_growth_is_stable():
    """Steps that grow by a constant factor damp the parasitic solution of BDF2 below the factor 1 + sqrt(2) only."""

    def parasitic(growth: float) -> float:
        w = derivative_weights([0.0, -1.0, -1.0 - 1.0 / growth])
        return min(np.abs(np.roots(w)))

    assert parasitic(bdf.LARGEST_GROWTH) < 0.6
    assert parasitic(1 + sqrt(2) - 1e-3) < 1
    roots = np.abs(np.roots(derivative_weights([0.0, -1.0, -1.0 - 1.0 / 2.5])))
    assert max(roots) > 1


@given(st.floats(1e-6, 1.0), st.floats(0.0, 1e9))
def test_next_step_stays_in_its_bounds(step, error):
    assert bdf.LARGEST_CUT * (1 - 1e-12) <= bdf.adapted(step, error) / step <= bdf.LARGEST_GROWTH * (1 + 1e-12)


@given(st.floats(0.0, 1e6), st.floats(0.0, 1e6))
def test_a_larger_error_never_gives_a_larger_step(one, other):
    assert bdf.adapted(1.0, max(one, other)) <= bdf.adapted(1.0, min(one, other))


@given(st.floats(0.05, 20.0), st.floats(0.1, 10.0))
def test_steps_settle_where_a_third_order_error_is_below_the_tolerance(step, unit):
    for _ in range(40):
        step = bdf.adapted(step, (step / unit) ** 3)
    assert step == pytest.approx(bdf.SAFETY * unit, rel=1e-9)


@given(st.lists(st.tuples(st.floats(0.1, 1.0), st.floats(-3.0, 3.0)), min_size=2, max_size=12))
def test_the_integral_of_backward_differences_is_what_they_are_of(steps):
    """Of any values: so a balance of rates that obey the steps closes to round-off."""
    times, values = np.cumsum(np.array(steps), axis=0).T
    levels = [slice(max(k - 2, 0), k + 1) for k in range(1, len(times))]
    rates = np.array([derivative_weights(times[k][::-1].tolist()) @ values[k][::-1] for k in levels])
    scale = np.abs(values).max() + 1.0
    assert bdf.backward_integral(times, rates) == pytest.approx(values[-1] - values[1], abs=1e-8 * scale)
