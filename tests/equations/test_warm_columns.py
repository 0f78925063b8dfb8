"""WarmColumns of warm oil and their energy equation: closed forms, limits, the balance of heat."""

from dataclasses import dataclass, field, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from closed_forms import nahme
from jax import Array
from jax.tree_util import register_dataclass
from numpy.testing import assert_allclose

from ertel.equations.across import Vector
from ertel.equations.columns import WarmColumns
from ertel.equations.contact import traceable
from ertel.equations.energy import Energy, sweeps_of
from ertel.equations.shear import shear
from ertel.numerics.grid import NO_SYMMETRY
from ertel.numerics.lobatto import Lobatto
from ertel.physics.fluidity import NewtonianOil, ReeEyring
from ertel.physics.thermal import Exponential, Solid, response
from ertel.solvers.heat import Moving, _program

ACROSS = Lobatto.of(7)
BETA, K, FILM = 0.04, 0.14, 1e-7
SHAPE = 3, 9
STEEL = Solid(7850.0, 460.0, 47.0)


NEWTONIAN = NewtonianOil()


def columns(law: Any = NEWTONIAN) -> WarmColumns:
    """With gradients of up to 20 MPa along X and 6 MPa along Y."""
    draw = np.random.default_rng(3)
    slope = Vector(*(jnp.asarray(draw.uniform(-most, most, SHAPE)) for most in (2e7, 6e6)))
    flat = jnp.ones(SHAPE)
    thermal = traceable(Exponential(BETA))
    return WarmColumns(traceable(law), thermal, 5e8 * flat, FILM * flat, 10.0 * flat, flat, slope, 3.0, 1.0, ACROSS)


def test_a_cold_column_has_the_flow_of_an_isothermal_film() -> None:
    """Couette's and Poiseuille's profile; with thinning the stress and the flux of `shear`."""
    cold, z = columns(), np.asarray(ACROSS.z)
    m, zero = jax.jit(WarmColumns.motion)(cold, jnp.zeros((7, *SHAPE))), jnp.zeros((7, *SHAPE))
    parabola = (z**2 - 0.25) / 2 * FILM / 10.0
    assert_allclose(m.u, 2.0 + 2.0 * z + parabola * np.asarray(cold.gradient.x), rtol=1e-12)
    assert_allclose(m.v, parabola * np.asarray(cold.gradient.y), atol=1e-12)
    thin = columns(ReeEyring(5e6))
    m, M = jax.jit(WarmColumns.motion)(thin, zero), jax.jit(WarmColumns.mobility)(thin, zero)
    g, s = jnp.stack([thin.gradient.x, thin.gradient.y]), thin.sliding
    known = shear(thin.law, thin.pressure, jnp.stack([s.x, s.y]), g)
    assert_allclose(jnp.stack([m.stress.x, m.stress.y]), known.stress, rtol=1e-6, atol=1.0)
    flow = 2.0 * FILM - FILM**2 / 10.0 * np.asarray(known.flux[0])
    assert_allclose(FILM * ACROSS.integral(m.u), flow, rtol=1e-5)
    assert np.all(np.asarray(M) > 1 / 12)  # sliding thins the oil for the flow in both directions
    assert_allclose(thin.share(zero), 1.0, rtol=1e-14)


@pytest.mark.parametrize("b", [0.5, -3.0])
def test_share_and_mobility_where_the_viscosity_grows_exponentially_across(b: float) -> None:
    """f = exp(b zeta): c = 1 - S (coth(b/2)/2 - 1/b), and M = S_2 - S_1^2/S_0 with the moments of f."""
    warm = columns()
    T = b / BETA * ACROSS.z * jnp.ones((7, *SHAPE))
    S_0 = 2.0 * np.sinh(b / 2) / b
    mean = 0.5 / np.tanh(b / 2) - 1.0 / b
    S_2 = S_0 * (0.25 - 2.0 * mean / b)
    assert_allclose(warm.share(T), 1.0 - mean, rtol=1e-7)  # S = 1
    assert_allclose(jax.jit(WarmColumns.mobility)(warm, T), S_2 - S_0 * mean**2, rtol=1e-6)
    m = jax.jit(WarmColumns.motion)(warm, T)
    pressure = (S_2 - S_0 * mean**2) * FILM / 10.0 * np.asarray(warm.gradient.x)
    assert_allclose(ACROSS.integral(m.u), 2.0 * (1.0 - mean) - pressure, rtol=1e-6)


@register_dataclass
@dataclass(frozen=True)
class Cold:
    """A wall that stays as it is."""

    shape: tuple[int, int] = field(metadata={"static": True})

    def __call__(self, heat: Array) -> Array:
        return jnp.zeros_like(heat)

    def split(self) -> tuple[Array, Array, Array]:
        return jnp.zeros(self.shape), jnp.zeros(self.shape[1]), jnp.zeros(self.shape[1])


LONG, MANY, SPACING = (1, 41), Lobatto.of(15), 2e-4


def between_cold_walls(u: tuple[float, float], viscosity: float, h: float, capacity: float, wall: float) -> Any:
    """The heat of a film h without pressure gradient, with oil of this heat capacity, one wall warmer; its columns."""
    flat, thermal = jnp.ones(LONG), traceable(Exponential(BETA))
    still = Vector(0.0 * flat, 0.0 * flat)
    one = WarmColumns(traceable(NEWTONIAN), thermal, flat, h * flat, viscosity * flat, flat, still, *u, MANY)
    walls = (Cold(LONG), Cold(LONG))
    energy = Energy(one, capacity * flat, K, 0.0, 300.0, (wall, 0.0), walls, 0.0 * flat, SPACING, NO_SYMMETRY)
    found = _program(energy, jnp.zeros((15, *LONG)), jnp.ones((2, *LONG)), np.inf, 60)
    assert found.change < 1e-5
    return found, one


@pytest.mark.parametrize(("Na", "error"), [(0.01, 1e-9), (1.0, 1e-7), (8.0, 2e-5), (50.0, 2e-3)])
def test_nahmes_column(Na: float, error: float) -> None:
    """A sheared film between walls that stay cold: his exact solution; Na = beta eta u^2/k."""
    found, one = between_cold_walls((1.0, -1.0 + 1e-9), Na * K / (4.0 * BETA), FILM, 0.0, 0.0)
    assert float(found.stress[0, 0, 20] / one.sliding.x[0, 20]) == pytest.approx(nahme(Na).viscosity, rel=error)


def test_oil_that_slides_along_a_wall_gets_warm_as_by_the_square_root_of_its_way() -> None:
    """A film so thick that heat enters a layer beside the warm wall only: flux T (rho c k u/(pi x))^{1/2}."""
    u = 2.0
    found, _ = between_cold_walls((u, u), 1e-9, 4e-4, 1.8e6, 5.0)
    x = SPACING * np.arange(1, LONG[1] + 1)
    assert_allclose(found.into[0][0, 15:], (-5.0 * np.sqrt(1.8e6 * K * u / (np.pi * x)))[15:], rtol=0.02)


def film_with_heat(law: Any) -> Energy:
    one = columns(law)
    bodies = tuple(Moving(jnp.asarray(response(STEEL, u, SHAPE[1], 1e-5))) for u in (1.0, 3.0))
    solid = jnp.full(SHAPE, 2e7)
    return Energy(one, 1.8e6 * jnp.ones(SHAPE), K, 6e-4, 313.0, (2.0, 0.0), bodies, solid, 1e-5, NO_SYMMETRY)


def test_the_balance_of_heat_and_of_the_temperatures_of_both_surfaces() -> None:
    energy = film_with_heat(ReeEyring(5e6))
    found = _program(energy, jnp.zeros((7, *SHAPE)), jnp.ones((2, *SHAPE)), np.inf, 60)
    assert found.change < 1e-5
    gone = sum(found.into) + found.carried
    assert_allclose(gone, found.heat, rtol=1e-4, atol=1e-4 * float(jnp.max(found.heat)))
    for end, body, rise, flux in zip((0, -1), energy.bodies, energy.rises, found.into, strict=True):
        assert_allclose(found.T[end], body + rise(flux), rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("flipped", [False, True])
def test_a_sweep_is_the_inverse_where_all_oil_flows_to_one_corner(flipped: bool) -> None:
    """Where no oil flows upstream, nor against a sweep along Y, one sweep is the solution."""
    energy = film_with_heat(NewtonianOil())
    outwards = (2.0 * flipped - 1.0) * 30.0 * jnp.ones(SHAPE) * float(jnp.max(jnp.abs(energy.columns.gradient.x)))
    gradient = Vector(jnp.zeros(SHAPE), outwards)
    energy = replace(energy, columns=replace(energy.columns, gradient=gradient))
    T = jnp.zeros((7, *SHAPE))
    m, warmer = jax.jvp(energy.columns.motion, (T,), (jnp.ones_like(T),))
    softer = jnp.minimum(warmer.heat, 0.0)
    assert float(jnp.max(jnp.abs(m.v))) > 0.1 * float(jnp.min(m.u)) > 0.0
    d = jnp.asarray(np.random.default_rng(4).normal(size=T.shape))
    _, sweeps = sweeps_of(energy, m, softer)
    assert_allclose(sweeps[flipped](energy.change(d, m, softer), back=False), d, atol=1e-8)
    assert float(jnp.max(jnp.abs(sweeps[not flipped](energy.change(d, m, softer), back=False) - d))) > 1e-3
