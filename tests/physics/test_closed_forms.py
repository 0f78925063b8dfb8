"""The closed forms of `closed_forms` that are not compared with the solver: against integrals and equations."""

from math import asinh, exp

import numpy as np
import pytest
from closed_forms import arana_traction, hertz_mean_stress, nahme
from scipy.integrate import quad, solve_bvp


@pytest.mark.parametrize(("S_c", "alpha_p_h"), [(0.1, 40.0), (1e3, 30.0), (exp(-2), 10.0)])
def test_hertz_means(S_c: float, alpha_p_h: float) -> None:
    exact, _ = quad(lambda s: 2 * s * asinh(S_c * exp(alpha_p_h * (s - 2 / 3))), 0, 1, epsabs=1e-12)
    assert hertz_mean_stress(S_c, alpha_p_h) == pytest.approx(exact, rel=1e-8)


def test_formula_of_arana() -> None:
    args = {"limit": 0.05, "alpha": 2e-8, "p_mean": 6.7e8, "film": 2e-7}
    slow = arana_traction(viscosity=10.0, sliding=0.01, **args)
    eyring = 2 * 0.05 / 2e-8
    assert slow == pytest.approx(eyring / 6.7e8 * asinh(10.0 * 0.01 / (2e-7 * eyring)))
    assert arana_traction(viscosity=1e5, sliding=2.0, **args) == 0.05


@pytest.mark.parametrize("Na", [0.1, 20.0])
def test_nahme_solves_the_equation_of_heat(Na: float) -> None:
    """theta'' + Na sigma^2 e^theta = 0 with sigma = tau h/(eta Delta u) and integral of sigma e^theta = 1."""
    rise, sigma = nahme(Na)
    z = np.linspace(0, 1, 41)
    solved = solve_bvp(
        lambda z, y: np.stack([y[1], -Na * sigma**2 * np.exp(y[0])]),
        lambda low, high: np.array([low[0], high[0]]),
        z,
        np.stack([4 * rise * z * (1 - z), rise * (4 - 8 * z)]),
        tol=1e-8,
    )
    fine = np.linspace(0, 1, 4001)
    theta = solved.sol(fine)[0]
    assert theta.max() == pytest.approx(rise, rel=1e-6)
    assert sigma * np.trapezoid(np.exp(theta), fine) == pytest.approx(1.0, rel=1e-6)
