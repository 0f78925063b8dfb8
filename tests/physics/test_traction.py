"""Traction: integrals over a contact against closed forms, the design's table, and published formulas."""

from math import asinh, exp, pi

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from ertel.physics.fluidity import cut_off
from ertel.physics.traction import (
    arana_traction,
    hertz_mean_stress,
    hooke_waviness,
    uniform_film_traction,
)


def test_stress_that_is_cut_off_keeps_its_direction() -> None:
    stress = np.array([[3.0, 0.3], [4.0, 0.4]])
    assert_allclose(cut_off(stress, np.array([1.0, 1.0])), [[0.6, 0.3], [0.8, 0.4]])


LOG_S = [-2, -1, 0, 1, 2, 4, 6, 8]


@pytest.mark.parametrize(
    ("alpha_p_h", "means"),
    [
        (10, [0.5063, 0.932, 1.4959, 2.1791, 2.9618, 4.7466, 6.6969, 8.6932]),
        (20, [1.3668, 1.8626, 2.4266, 3.0538, 3.7392, 5.2647, 6.9629, 8.794]),
        (30, [2.314, 2.831, 3.3932, 3.9983, 4.6441, 6.0487, 7.5895, 9.2485]),
    ],
)
def test_hertz_means(alpha_p_h: float, means: list) -> None:
    found = [hertz_mean_stress(exp(power), alpha_p_h) for power in LOG_S]
    assert_allclose(found, means, atol=6e-5)


def test_hertz_mean_is_converged() -> None:
    for S_c, alpha_p_h in ((0.1, 40.0), (1e3, 30.0)):
        exact, _ = quad(lambda s, S=S_c, a=alpha_p_h: 2 * s * asinh(S * exp(a * (s - 2 / 3))), 0, 1, epsabs=1e-12)
        assert hertz_mean_stress(S_c, alpha_p_h) == pytest.approx(exact, rel=1e-8)


def test_uniform_film_at_high_sliding() -> None:
    """With S_c = e^8 and alpha p_h = 10 the mean is within 2e-5 of ln(2 S_c)."""
    alpha, p_h, tau0 = 1e-8, 1e9, 5e6
    p_mean = 2 * p_h / 3
    newtonian = tau0 * exp(8 - alpha * p_mean)
    exact = hertz_mean_stress(exp(8), alpha * p_h) * tau0 / p_mean
    assert uniform_film_traction(alpha, tau0, p_mean, newtonian) == pytest.approx(exact, rel=2e-5)


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


# -- Hooke ------------------------------------------------------------------------------------------------------------


def waviness(lag: float, bulk: float = float("inf")) -> tuple[complex, complex]:
    return hooke_waviness(100e-6, 200e-9, 226e9, effective_viscosity=10.0, lag=lag, bulk_modulus=bulk)


def test_waviness_stays_where_the_oil_carries_it() -> None:
    assert waviness(0.0) == (1.0, 0.0)


def test_fast_waviness_is_flattened_elastically() -> None:
    """Q -> infinity without compressibility: no ripple of the film, pressure ripple w E'/4."""
    clearance, pressure = waviness(1e9)
    assert abs(clearance) < 1e-6
    assert abs(pressure) == pytest.approx(2 * pi / 100e-6 * 226e9 / 4, rel=1e-9)


def test_compressible_oil_leaves_a_ripple() -> None:
    clearance, _ = waviness(1e9, bulk=5e9)
    C = 200e-9 * 226e9 * 2 * pi / 100e-6 / (4 * 5e9)
    assert abs(clearance) == pytest.approx(C / (1 + C), rel=1e-6)


def test_ripples_of_film_and_of_pressure_add_up_to_the_waviness() -> None:
    """The pressure ripple flattens the waviness by 4 p/(w E'), in its own phase."""
    for lag in (1e-3, 1e-2, -0.3):
        clearance, pressure = waviness(lag, bulk=5e9)
        assert abs(clearance - 4 / (2 * pi / 100e-6 * 226e9) * pressure - 1.0) < 1e-12
