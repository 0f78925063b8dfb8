"""The contact and the impact without oil: against quadrature, against their differential equations, at their limits."""

from math import expm1, log1p, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad, solve_ivp
from scipy.special import ellipkm1

from ertel.physics import hertz
from ertel.physics.hertz import CONTACT_TIME, HALF_CONTACT_TIME

# --- statics --------------------------------------------------------------------------------------------------------


def ring_displacement(r: float, A: float) -> float:
    """The double integral of eq. (3) over the Hertzian pressure: rings, each a complete elliptic integral K.

    K(m) is taken of 1 - m, as small as it may be, for its logarithmic peak lies at the ring through r itself.
    """

    def ring(s: float) -> float:
        return 4 * s * float(hertz.pressure(s, A)) / (r + s) * ellipkm1(max(((r - s) / (r + s)) ** 2, 1e-300))

    points = [r] if 0 < r < A else None
    return 2 / pi**2 * quad(ring, 0, A, points=points, epsabs=0, epsrel=1e-10, limit=200)[0]


@pytest.mark.parametrize("A", [0.3, 1.0, 1.5])
@pytest.mark.parametrize("share", [0.0, 0.2, 0.7, 0.95, 1.0, 1.05, 1.5, 4.0])
def test_displacement_is_the_integral_over_the_pressure(share, A):
    assert hertz.displacement(share * A, A) == pytest.approx(ring_displacement(share * A, A), rel=1e-7)


@given(st.floats(0.05, 2.0))
def test_load_is_the_integral_of_the_pressure(A):
    integral = quad(lambda r: 2 * pi * r * float(hertz.pressure(r, A)), 0, A, epsabs=0, epsrel=1e-9)[0]
    assert hertz.load(A**2) == pytest.approx(A**3, rel=1e-12) == pytest.approx(integral / (2 * pi / 3), rel=1e-8)


def test_dry_film_is_closed_inside_and_open_outside():
    """At the edge it opens with the power 3/2, and far away the pressure acts like a point force."""
    r = np.linspace(0.0, 3.0, 301)
    film = -1 + r**2 / 2 + hertz.displacement(r)
    assert_allclose(film[r <= 1], 0, atol=1e-15)
    assert np.all(film[r > 1] > 0)
    assert_allclose(film, hertz.gap(r), atol=2e-15)
    assert np.all(np.diff(hertz.gap(r)[r > 1]) > 0)
    assert hertz.displacement(50.0) == pytest.approx(2 / pi**2 * (2 * pi / 3) / 50, rel=1e-3)
    step = np.array([1e-4, 1e-5])
    assert_allclose(hertz.gap(1 + step) / step**1.5, 8 * sqrt(2) / (3 * pi), rtol=2e-3)
    for function in (hertz.pressure, hertz.displacement, hertz.gap):
        assert_allclose(function(-r), function(r), rtol=0)


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan")])
def test_radius_and_half_time_must_be_positive(bad):
    for function in (hertz.pressure, hertz.displacement, hertz.gap):
        with pytest.raises(ValueError, match=f"A = {bad}"):
            function(0.5, bad)


# --- exact motion ---------------------------------------------------------------------------------------------------


def test_contact_time():
    """Johnson's 2.94: twice the integral of dx/sqrt(1 - x^{5/2}), with x = 1 - s^2 to be rid of the singularity."""
    half = quad(lambda s: 2 * s / sqrt(-expm1(2.5 * log1p(-s * s))), 0, 1, epsabs=0, epsrel=1e-13)[0]
    assert pytest.approx(2.943275, abs=5e-7) == CONTACT_TIME == pytest.approx(2 * half, rel=1e-12)
    assert 2 * HALF_CONTACT_TIME == CONTACT_TIME


def test_motion_solves_newtons_law():
    """Delta'' = -(5/4) Delta^{3/2}: 15/(8 pi) times the load (2 pi/3) Delta^{3/2}."""
    T, fine = np.linspace(0.0, CONTACT_TIME, 60), {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    solution = solve_ivp(lambda T, y: [y[1], -1.25 * max(y[0], 0) ** 1.5], (0, CONTACT_TIME), [0, 1], t_eval=T, **fine)
    assert_allclose(hertz.approach(T), solution.y[0], atol=1e-10)
    assert_allclose(hertz.velocity(T), solution.y[1], atol=1e-10)


@given(st.floats(0.0, CONTACT_TIME))
def test_energy_is_kept_and_the_rebound_mirrors_the_approach(T):
    Delta, V = float(hertz.approach(T)), float(hertz.velocity(T))
    assert V**2 + Delta**2.5 == pytest.approx(1.0, abs=1e-14)
    assert hertz.approach(CONTACT_TIME - T) == pytest.approx(Delta, abs=1e-13)
    assert hertz.velocity(CONTACT_TIME - T) == pytest.approx(-V, abs=1e-12)


@given(st.floats(-2.0, 1.0))
def test_time_and_approach_invert_each_other(Delta):
    assert hertz.approach(hertz.time_at(Delta)) == pytest.approx(Delta, abs=1e-13)


@pytest.mark.parametrize("Delta", [1e-6, 0.1, 0.5, 0.9, 0.999])
def test_time_at_against_quadrature(Delta):
    time = quad(lambda y: 1 / sqrt(1 - y**2.5), 0, Delta, epsabs=0, epsrel=1e-12)[0]
    assert hertz.time_at(Delta) == pytest.approx(time, rel=1e-11)


def test_free_flight_before_and_after_and_the_maximum_between():
    T = np.array([-2.0, -0.5, 0.0, CONTACT_TIME, CONTACT_TIME + 0.5])
    assert_allclose(hertz.approach(T), [-2.0, -0.5, 0.0, 0.0, -0.5], atol=1e-15)
    assert_allclose(hertz.velocity(T), [1.0, 1.0, 1.0, -1.0, -1.0], atol=1e-15)
    assert_allclose(hertz.contact_radius(T), 0.0, atol=1e-7)
    assert_allclose(hertz.load(hertz.approach(T)), 0.0, atol=1e-15)
    assert (hertz.approach(HALF_CONTACT_TIME), hertz.velocity(HALF_CONTACT_TIME)) == (1.0, 0.0)
    assert np.isnan(hertz.time_at(1.0 + 1e-6))
    step = np.array([1e-9, 1e-7, 1e-5])  # the velocity does not cancel: Delta'' = -5/4 there
    assert_allclose(hertz.velocity(HALF_CONTACT_TIME + step), -1.25 * step, rtol=1e-6)


@given(st.floats(0.05, HALF_CONTACT_TIME - 0.02))
def test_front_speed_is_the_derivative_of_the_radius(T):
    h = 1e-5
    difference = (hertz.contact_radius(T + h) - hertz.contact_radius(T - h)) / (2 * h)
    assert hertz.front_speed(hertz.contact_radius(T)) == pytest.approx(difference, rel=1e-6)


def test_front_speed_at_its_ends():
    assert_allclose(hertz.front_speed([0.0, 1.0, -0.1, 1.1]), [np.inf, 0.0, np.nan, np.nan])
    assert hertz.front_speed(1e-4) == pytest.approx(1 / 2e-4, rel=1e-12)
    assert hertz.front_speed(1 - 1e-6) == pytest.approx(sqrt(5) / 2 * 1e-3, rel=1e-5)


@pytest.mark.filterwarnings("error")
def test_all_functions_are_vectorised_and_silent():
    values = np.linspace(-3.0, 3.0, 12).reshape(3, 4)
    names = [name for name in dir(hertz) if callable(getattr(hertz, name)) and not name.startswith("_")]
    functions = [name for name in names if getattr(getattr(hertz, name), "__module__", "") == "ertel.physics.hertz"]
    assert len(functions) == 9
    for name in functions:
        result = getattr(hertz, name)(values)
        assert (result.shape, result.dtype) == (values.shape, np.float64)
        each = [float(getattr(hertz, name)(value)) for value in values.flat]
        assert_allclose(result.ravel(), each, rtol=1e-15)
