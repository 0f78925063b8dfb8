"""The closed forms of `closed_forms`: against integrals, the design's tables and an equation of heat."""

from math import asinh, exp

import numpy as np
import pytest
from closed_forms import (
    arana_traction,
    eyring_flow_factor,
    eyring_stress,
    hertz_mean_stress,
    nahme,
    small_gradient_mobility,
)
from numpy.testing import assert_allclose
from scipy.integrate import quad, solve_bvp

from ertel.physics.fluidity import Carreau, ReeEyring

LOG_S = [-2, -1, 0, 1, 2, 4, 6, 8]


def test_hertz_means() -> None:
    for alpha_p_h, means in {
        10: [0.5063, 0.932, 1.4959, 2.1791, 2.9618, 4.7466, 6.6969, 8.6932],
        20: [1.3668, 1.8626, 2.4266, 3.0538, 3.7392, 5.2647, 6.9629, 8.794],
        30: [2.314, 2.831, 3.3932, 3.9983, 4.6441, 6.0487, 7.5895, 9.2485],
    }.items():
        assert_allclose([hertz_mean_stress(exp(power), alpha_p_h) for power in LOG_S], means, atol=6e-5)
    for S_c, alpha_p_h in ((0.1, 40.0), (1e3, 30.0)):
        exact, _ = quad(lambda s, S=S_c, a=alpha_p_h: 2 * s * asinh(S * exp(a * (s - 2 / 3))), 0, 1, epsabs=1e-12)
        assert hertz_mean_stress(S_c, alpha_p_h) == pytest.approx(exact, rel=1e-8)


# -- Arana et al. -----------------------------------------------------------------------------------------------------


def test_formula_of_arana() -> None:
    args = {"limit": 0.05, "alpha": 2e-8, "p_mean": 6.7e8, "film": 2e-7}
    slow = arana_traction(viscosity=10.0, sliding=0.01, **args)
    eyring = 2 * 0.05 / 2e-8
    assert slow == pytest.approx(eyring / 6.7e8 * asinh(10.0 * 0.01 / (2e-7 * eyring)))
    assert arana_traction(viscosity=1e5, sliding=2.0, **args) == 0.05
    rising = [arana_traction(viscosity=100.0, sliding=v, **args) for v in (1e-4, 1e-3, 1e-2)]
    assert rising == sorted(rising)
    assert rising[0] == pytest.approx(100.0 * 1e-4 / 2e-7 / 6.7e8, rel=1e-3)  # Newtonian: eta V/(h p)


# -- Eyring's flow ----------------------------------------------------------------------------------------------------

SIGMA = np.array([0.5, 1.0, 2.0, 4.0, 8.0])


@pytest.mark.parametrize(
    ("B", "at_rest", "factors"),
    [
        (0, 1.0, [1.025224, 1.103638, 1.461574, 3.841079, 61.132936]),
        (1, 1.414214, [1.420842, 1.449116, 1.669069, 3.88212, 61.133817]),
        (10, 10.049875, [9.890484, 9.455686, 8.191172, 6.815509, 61.220932]),
        (100, 100.005, [98.37739, 93.91707, 80.610459, 56.431213, 69.38225]),
    ],
)
def test_table(B: float, at_rest: float, factors: list) -> None:
    assert_allclose(eyring_flow_factor(B, SIGMA), factors, rtol=5.6e-7)
    assert float(eyring_flow_factor(B, 0.0)) == pytest.approx(at_rest, rel=1e-6)
    assert float(eyring_stress(B, 0.0)) == pytest.approx(np.arcsinh(B))
    series, closed = eyring_flow_factor(3.0, np.array([0.1 - 1e-12, 0.1 + 1e-12]))
    assert series == pytest.approx(closed, rel=1e-12)


def test_small_gradients() -> None:
    x = np.array([0.3, 2.0, 5.0])
    along, across = small_gradient_mobility(ReeEyring(1.0), x, 0.0)
    assert_allclose(along, np.cosh(x), rtol=1e-9)
    assert_allclose(across, np.sinh(x) / x, rtol=1e-13)
    along, across = small_gradient_mobility(Carreau(1.0, 0.5), x, 0.0)
    assert_allclose(along, (1 + 2 * x**2) / np.sqrt(1 + x**2), rtol=1e-9)
    assert_allclose(across, np.sqrt(1 + x**2), rtol=1e-13)


# -- a film that heats itself -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("Na", [0.1, 20.0])
def test_nahme_solves_the_equation_of_heat(Na: float) -> None:
    """theta'' + Na sigma^2 e^theta = 0 with sigma = tau h/(eta Delta u) and integral of sigma e^theta = 1."""
    sigma = nahme(Na).viscosity
    z = np.linspace(0, 1, 41)
    solved = solve_bvp(
        lambda z, y: np.stack([y[1], -Na * sigma**2 * np.exp(y[0])]),
        lambda low, high: np.array([low[0], high[0]]),
        z,
        np.stack([4 * nahme(Na).largest_rise * z * (1 - z), nahme(Na).largest_rise * (4 - 8 * z)]),
        tol=1e-8,
    )
    fine = np.linspace(0, 1, 4001)
    theta = solved.sol(fine)[0]
    assert theta.max() == pytest.approx(nahme(Na).largest_rise, rel=1e-6)
    assert sigma * np.trapezoid(np.exp(theta), fine) == pytest.approx(1.0, rel=1e-6)
