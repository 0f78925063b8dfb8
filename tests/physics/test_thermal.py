"""Inlet shear heating, the film's temperatures and the flash temperature, against tables and closed forms."""

from math import log, pi, sqrt

import numpy as np
import pytest
from closed_forms import flash_temperature, mean_rise
from numpy.testing import assert_allclose

from ertel.physics import thermal
from ertel.physics.lubricant import Roelands, roelands_exponent

STEEL = thermal.Solid(7850.0, 460.0, 47.0)


def test_inlet_factors_of_gupta_and_of_wilson_and_sheu() -> None:
    for L_t, factors in {
        0.01: [0.9848, 0.9784, 0.9611],
        0.1: [0.9429, 0.9178, 0.8543],
        0.5: [0.8605, 0.8039, 0.6786],
        1: [0.8003, 0.7256, 0.5751],
        3: [0.6668, 0.5668, 0.3991],
    }.items():
        assert [round(thermal.gupta_factor(L_t, S, 0.5 / 226), 4) for S in (0, 0.2, 1)] == factors
    assert thermal.wilson_sheu_factor(1.0, 0.0) == pytest.approx(1 / 1.1)
    assert thermal.wilson_sheu_factor(1.0, 1.0) == pytest.approx(1 / 2.58)
    assert thermal.thermal_loading(0.04, 0.04, 5.0, 0.14) == pytest.approx(0.04 * 0.04 * 25 / 0.14)
    for bad in ({"L_t": -1.0}, {"slide_to_roll": -0.1}, {"p_h_over_E": float("nan")}):
        with pytest.raises(ValueError, match=rf"^{next(iter(bad))} = .*must be finite and not below zero"):
            thermal.gupta_factor(**{"L_t": 1.0, "slide_to_roll": 0.1, "p_h_over_E": 0.002, **bad})


def test_inlet_factors_by_name() -> None:
    found = {name: factor.formula(1.0, 0.2, 0.002) for name, factor in thermal.INLET_FACTORS.items()}
    assert found == {
        "gupta": thermal.gupta_factor(1, 0.2, 0.002),
        "wilson-sheu": thermal.wilson_sheu_factor(1, 0.2),
        "solved": 1.0,
        "none": 1.0,
    }
    assert {factor.formula(0.0, 0.5, 0.002) for factor in thermal.INLET_FACTORS.values()} == {1.0}
    for name in ("gupta", "wilson-sheu"):
        factor = thermal.INLET_FACTORS[name]
        falling = [factor.formula(L_t, 0.5, 0.002) for L_t in (0.01, 0.1, 1.0, factor.largest_L_t)]
        assert falling == sorted(falling, reverse=True) and falling[-1] > 0


# -- the viscosity of the warm oil ------------------------------------------------------------------------------------


def roelands_houpert(p: float, T: float, eta0: float, alpha: float, beta: float, T0: float) -> float:
    """ln eta by Houpert 1985: (ln eta0 + 9.67) {-1 + (1 + p/1.96e8)^z [(T - 138)/(T0 - 138)]^-S0} more than ln eta0."""
    Y = log(eta0) + 9.67
    z, S0 = 1.96e8 * alpha / Y, beta * (T0 - 138) / Y
    return log(eta0) + Y * (-1 + (1 + p / 1.96e8) ** z * ((T - 138) / (T0 - 138)) ** -S0)


@pytest.mark.parametrize("T", [300.0, 340.0, 420.0])
@pytest.mark.parametrize("p", [0.0, 0.5e9, 1.5e9])
def test_houperts_law_for_roelands_oil(p: float, T: float) -> None:
    eta0, alpha, beta, T0 = 0.04, 2.2e-8, 0.045, 313.0
    at_inlet = log(Roelands(alpha, roelands_exponent(alpha, eta0)).viscosity(p))
    found = log(eta0) + at_inlet + thermal.Houpert.of(eta0, beta, T0).change(at_inlet, T - T0)
    assert found == pytest.approx(roelands_houpert(p, T, eta0, alpha, beta, T0), rel=1e-12)


def test_the_coefficient_of_temperature_grows_with_the_logarithm_of_the_viscosity() -> None:
    law, beta, eta0 = thermal.Houpert.of(0.04, 0.045, 313.0), 0.045, 0.04
    for log_ratio in (0.0, 10.0, 20.0):
        slope = -(law.change(log_ratio, 1e-4) - law.change(log_ratio, -1e-4)) / 2e-4
        assert slope == pytest.approx(beta * (log(eta0) + 9.67 + log_ratio) / (log(eta0) + 9.67), rel=1e-6)
    assert thermal.Exponential.of(0.04, 0.045, 313.0).change(20.0, 10.0) == pytest.approx(-0.45)


@pytest.mark.parametrize(
    ("bad", "message"), [((6e-5, 0.04, 313.0), "eta0 = 6e-05"), ((0.04, 0.04, 138.0), "temperature")]
)
def test_where_houperts_law_has_no_meaning(bad: tuple[float, float, float], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}.*: Houpert's law needs"):
        thermal.Houpert.of(*bad)


# -- the surfaces -----------------------------------------------------------------------------------------------------


def test_worked_example() -> None:
    """40 MPa, 1 m/s, 100 nm, k = 0.14: 2.38 K in the film; steel at 0.5 m/s over 280 um: 41 K."""
    assert mean_rise(40e6, 1.0, 100e-9, 0.14) == pytest.approx(2.38, abs=0.005)
    heat = np.full(281, 0.5 * 40e6 * 1.0)
    heat[0] /= 2
    assert flash_temperature(heat, STEEL, 0.5, 1e-6)[-1] == pytest.approx(41.0, abs=0.5)
    assert STEEL.effusivity == pytest.approx(sqrt(7850 * 460 * 47))
    assert thermal.peclet_number(STEEL, -0.5, 140e-6) == pytest.approx(0.5 * 140e-6 * 7850 * 460 / 94)


def closed_uniform(q: float, x: float, speed: float) -> float:
    return 2 * q * sqrt(x / (pi * speed)) / STEEL.effusivity


def test_linear_sources_are_exact() -> None:
    """The kernel is integrated exactly: q = x gives (4/3) x^{3/2}."""
    x = np.linspace(0.0, 1.0, 33)
    weights = thermal.moving_source_weights(33, x[1])
    assert_allclose(np.convolve(weights, x)[:33], 4 / 3 * x**1.5, rtol=1e-12, atol=1e-15)


def test_order_two_behind_the_edge_of_a_uniform_source_and_for_a_smooth_one() -> None:
    def uniform(n: int) -> float:
        heat = np.ones(n + 1)
        heat[0] = 0.5
        return abs(flash_temperature(heat, STEEL, 2.0, 1.0 / n)[-1] / closed_uniform(1.0, 1.0, 2.0) - 1)

    def smooth(n: int) -> float:
        x = np.linspace(0.0, 1.0, n + 1)
        return float(flash_temperature(np.sin(pi * x) ** 2, STEEL, 1.0, 1.0 / n)[3 * n // 4])

    errors = np.array([(uniform(n), abs(smooth(n) - smooth(4096))) for n in (16, 32, 64, 128)])
    assert errors[-1, 0] < 1e-5 and np.log2(errors[:-1] / errors[1:]).min() > 1.9


def test_a_surface_that_moves_back_is_heated_from_the_other_side() -> None:
    heat = np.exp(-((np.linspace(-3, 1, 41)) ** 2))
    there, back = flash_temperature(heat, STEEL, 1.0, 0.1), flash_temperature(heat[::-1], STEEL, -1.0, 0.1)
    assert_allclose(back[::-1], there, rtol=1e-14)
    with pytest.raises(ValueError, match=r"^speed = 0"):
        thermal.response(STEEL, 0.0, 5, 0.1)
