"""Temperatures of a steady contact on its grid: the balance of heat, the isothermal limit, surfaces at rest."""

from dataclasses import replace
from functools import cache
from math import pi
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from closed_forms import flash_temperature
from numpy.testing import assert_allclose

from ertel.case.case import Case
from ertel.case.estimates import grid_of
from ertel.equations import discretise
from ertel.equations.account import friction
from ertel.inputs.case_files import parse_case
from ertel.numerics.integrals import Plane
from ertel.physics.geometry import CIRCLE
from ertel.physics.thermal import gupta_factor
from ertel.solvers.heat import Heated, heated

CONTACT = {
    "kind": "rolling",
    "radius": "10 mm",
    "load": "100 N",
    "mean_speed": "2 m/s",
    "slide_to_roll": 0.4,
    "material_1": "steel",
    "material_2": "glass",
}
OIL = {"oil": "squalane", "temperature": "40 degC", "rheology": {"law": "carreau", "G": "6 MPa", "n": 0.42}}
BATH = 313.15  # K


def case_of(contact: dict[str, Any] | None = None, **thermal: Any) -> Case:
    return parse_case(
        {"contact": {**CONTACT, **(contact or {})}, "lubricant": OIL, "solver": {"nodes": 33}, "thermal": thermal}
    )


def film_of(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """A Hertzian contact with a film of 100 nm: no solution of Reynolds' equation, which matters nothing here."""
    grid, s = grid_of(case), case.scales
    assert s is not None
    r2 = grid.kept_x[None, :] ** 2 + grid.kept_y[:, None] ** 2
    P = np.sqrt(np.maximum(1.0 - r2, 0.0))
    return P, np.full_like(P, 1e-7 / s.film) + np.where(r2 > 1.0, r2 - 1.0, 0.0)


def heated_at(slide_to_roll: float, contact: dict[str, Any] | None = None, **thermal: Any) -> Heated:
    case = case_of({"slide_to_roll": slide_to_roll, **(contact or {})}, **thermal)
    return heated(case, *film_of(case))


@cache
def usual() -> tuple[Case, Heated]:
    case = case_of()
    return case, heated(case, *film_of(case))


def test_the_balance_of_heat() -> None:
    """Both fluxes that the temperatures of the film imply heat the surfaces to just these temperatures."""
    case, warm = usual()
    thermal, s, grid = case.thermal, case.scales, grid_of(case)
    assert thermal and s and warm.converged
    film = np.asarray(warm.film) * s.film
    heat = np.asarray(warm.stress[0]) * s.shear_stress * 0.4 * 2.0
    assert_allclose(warm.heat, heat, rtol=1e-4, atol=1e-6 * heat.max())
    crossing = thermal.conductivity * (warm.T_2 - warm.T_1) / film
    for T, flux, body, speed in zip(
        (warm.T_1, warm.T_2), (heat / 2 + crossing, heat / 2 - crossing), thermal.bodies, (2.4, 1.6), strict=True
    ):
        assert_allclose(T - BATH, flash_temperature(flux, body, speed, grid.spacing * s.a), atol=1e-3)
    above = heat * film / (12 * thermal.conductivity)
    assert_allclose(warm.T_film, (warm.T_1 + warm.T_2) / 2 + above, atol=1e-3)
    assert warm.T_2.max() > warm.T_1.max() > BATH + 1.0  # the glass is the warmer one
    assert warm.inlet.L_t == pytest.approx(case.oil.eta0 * thermal.beta * 4.0 / 0.14)
    assert warm.inlet.factor == gupta_factor(warm.inlet.L_t, 0.4, s.p_h / s.E_prime)
    assert_allclose(warm.film, warm.inlet.factor * film_of(case)[1])


@pytest.mark.parametrize("rheology", [OIL["rheology"], pytest.param("newtonian", marks=pytest.mark.slow)], ids=str)
def test_without_heat_the_friction_is_the_isothermal_one(rheology: Any) -> None:
    case = case_of(beta="1e-8 / K", viscosity="exponential", inlet_factor="none")
    case = parse_case({**case.to_data(), "lubricant": {**OIL, "rheology": rheology}})
    P, H = film_of(case)
    warm, grid = heated(case, P, H), grid_of(case)
    c, load = discretise.contact_of(case, grid), case.geometry.hertz_load
    cold = jax.jit(friction)(Plane.of(grid), c, jnp.asarray(P), jnp.asarray(H), 0.4, 1.0, load)
    assert case.thermal is not None
    hotter = float(np.max(warm.T_film)) - case.thermal.temperature
    left = 1.01e-8 * hotter  # of the viscosity, by the least beta that is allowed
    assert left < 1e-4
    assert_allclose(warm.stress, cold.stress, rtol=left, atol=1e-12)
    assert_allclose(warm.sliding, cold.sliding, rtol=left)


def test_heat_reduces_the_traction_and_more_so_with_sliding() -> None:
    slow, fast = heated_at(0.2), heated_at(1.0)
    cold = {"beta": "1e-8 / K", "viscosity": "exponential", "inlet_factor": "none"}
    share = [float(hot.sliding[0] / heated_at(S, **cold).sliding[0]) for hot, S in ((slow, 0.2), (fast, 1.0))]
    assert 0.2 < share[1] < share[0] < 1.0
    assert fast.T_film.max() > slow.T_film.max() > BATH


def test_exchange_of_the_bodies() -> None:
    """The slower surface above instead of below: the same temperatures, and the force the other way round."""
    one = heated_at(0.4)
    other = heated_at(-0.4, {"material_1": "glass", "material_2": "steel"})
    assert_allclose(other.T_1, one.T_2, rtol=1e-9)
    assert_allclose(other.T_2, one.T_1, rtol=1e-9)
    assert_allclose(other.sliding[0], -one.sliding[0], rtol=1e-7)


LIMITED = {"law": "limited", "base": OIL["rheology"], "Lambda": 0.05}


@pytest.mark.parametrize("law", [OIL["rheology"], pytest.param(LIMITED, marks=pytest.mark.slow)], ids=str)
def test_pure_rolling_has_no_heat_of_sliding(law: Any) -> None:
    """The stress is zero everywhere, where the length of a vector, which a limit asks for, has no derivative."""
    case = parse_case({**case_of({"slide_to_roll": 0.0}).to_data(), "lubricant": {**OIL, "rheology": law}})
    warm = heated(case, *film_of(case))
    assert warm.converged
    assert_allclose([warm.T_1, warm.T_2, warm.T_film], BATH, rtol=1e-12)
    assert_allclose(warm.sliding, 0.0, atol=1e-12)


def test_warm_bodies_warm_the_film() -> None:
    warm = heated_at(0.0, temperature_1="60 degC", temperature_2="50 degC")
    inside = np.asarray(warm.stress[0]).shape[1] * 3 // 4
    assert 323.15 < warm.T_film[0, inside] < 333.15
    assert warm.converged
    sliding, cold = heated_at(0.2, temperature_1="60 degC", temperature_2="60 degC"), heated_at(0.2)
    assert float(sliding.sliding[0]) < float(cold.sliding[0])


@pytest.mark.parametrize("slide_to_roll", [2.0, pytest.param(-2.0, marks=pytest.mark.slow)])
def test_a_surface_at_rest(slide_to_roll: float) -> None:
    """Its highest temperature continues that of a surface that hardly moves either way."""
    warm, before, after = (heated_at(slide_to_roll * share) for share in (1.0, 0.98, 1.02))
    resting = 1 if slide_to_roll > 0 else 0
    assert warm.converged and warm.peclet[resting] == pytest.approx(0.0)
    hottest = [(heat.T_1, heat.T_2)[resting].max() - BATH for heat in (before, warm, after)]
    assert hottest[1] == pytest.approx((hottest[0] + hottest[2]) / 2, rel=0.1)


def test_temperature_of_a_body_at_rest_under_hertzian_heat() -> None:
    """q0 (1 - r^2)^{1/2} raises the middle of a half space by pi q0 a/(4 k)."""
    from ertel.solvers.heat import _rise

    case, _ = usual()
    s, thermal, grid = case.scales, case.thermal, grid_of(case)
    assert s and thermal
    heat = 1e8 * film_of(case)[0]
    exact = pi * 1e8 * s.a / (4 * thermal.bodies[1].conductivity)
    assert _rise(thermal.bodies[1], 0.0, 0.0, s.a, grid, CIRCLE)(heat).max() == pytest.approx(exact, rel=0.01)


def test_the_start_does_not_matter() -> None:
    case, warm = usual()
    again = heated(case, *film_of(case), heat=30.0 * warm.heat)
    assert again.converged
    assert_allclose(again.T_film, warm.T_film, atol=1e-3)
    assert_allclose(again.sliding, warm.sliding, rtol=1e-6)


def test_heat_thins_what_a_flooded_inlet_lets_pass_and_not_the_layer() -> None:
    case, flooded = usual()
    assert case.scales is not None
    factors = []
    for layer in (1e-4, 0.3, 20.0):  # over the flooded film
        oil = {**OIL, "layer": f"{layer * case.film_scale * case.scales.film} m"}
        thin = parse_case({"contact": CONTACT, "lubricant": oil, "solver": {"nodes": 33}, "thermal": {}})
        factors.append(heated(thin, *film_of(case)).inlet.factor)
    assert factors[0] == pytest.approx(1.0, abs=1e-6) and factors[2] == pytest.approx(flooded.inlet.factor, rel=1e-3)
    assert flooded.inlet.factor < factors[1] < 1.0 and factors[1] > 0.9


def test_a_case_without_thermal_data_has_no_temperatures() -> None:
    case = replace(case_of(), thermal=None)
    P, H = film_of(case)
    with pytest.raises(ValueError, match=r"^thermal: the case has no such section"):
        heated(case, P, H)
