"""The heat balance of a sheared film and its surfaces: its equations, closed forms, one solution, and what jumps."""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
import pytest
from closed_forms import nahme
from jax import Array
from jax.tree_util import register_dataclass
from numpy.testing import assert_allclose
from scipy.special import lambertw

from ertel.physics.thermal import Solid, response
from ertel.solvers.heat import Floats, Moving, Warmed, warmed

STEEL, GLASS = Solid(7850.0, 460.0, 47.0), Solid(2510.0, 858.0, 1.114)
NODES, SPACING = 41, 7.5e-6
CONDUCTIVITY = 0.14


def moving(solid: Solid, speed: float) -> Moving:
    return Moving(response(solid, speed, NODES, SPACING))


@register_dataclass
@dataclass(frozen=True)
class Exponential:
    """A Newtonian oil: q falls as the viscosity does."""

    heat: Floats
    beta: float = 0.0

    def __call__(self, film: Array) -> tuple[Array, Array]:
        heat = self.heat * jnp.exp(-self.beta * film)
        return heat, -self.beta * heat


def hertzian() -> Floats:
    """Heat that rises by four decades from the edge of a contact to its middle, as the viscosity does."""
    x, y = np.linspace(-1.2, 1.2, NODES), np.linspace(0.0, 1.0, 3)[:, None]
    return 1e7 * np.exp(9.0 * np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0)))


# -- the equations ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_the_equations_hold(speed: float) -> None:
    draw = np.random.default_rng(5)
    film = draw.uniform(5e-8, 5e-7, (3, NODES))
    first, second = moving(STEEL, 0.7), moving(GLASS, speed)
    warm = warmed(
        Exponential(draw.uniform(1e8, 1e9, (3, NODES)), 0.05), (first, second), film / CONDUCTIVITY, (5.0, 2.0)
    )
    crossing = CONDUCTIVITY * (warm.surface_2 - warm.surface_1) / film
    assert warm.converged
    assert_allclose(warm.surface_1, 5.0 + first(warm.x[0] / 2 + crossing), rtol=1e-6)
    assert_allclose(warm.surface_2, 2.0 + second(warm.x[0] / 2 - crossing), rtol=1e-6)
    middle = (warm.surface_1 + warm.surface_2) / 2 + warm.x[0] * film / (12 * CONDUCTIVITY)
    assert_allclose(warm.film, middle, rtol=1e-12)


def test_equal_surfaces_take_half_each() -> None:
    heat, into = np.full((2, NODES), 1e8), moving(STEEL, 1.0)
    warm = warmed(Exponential(heat), (into, into), np.full_like(heat, 1e-7))
    assert_allclose(warm.surface_1, into(heat / 2), rtol=1e-12)
    assert_allclose(warm.surface_2, warm.surface_1, rtol=1e-12)


def test_thin_films_leave_the_partition_to_the_solids() -> None:
    """h -> 0: both surfaces have one temperature, and uniform heat is shared by the effusivities."""
    slow, fast, heat = moving(STEEL, 1.0), moving(STEEL, 4.0), np.full((1, NODES), 1e8)
    warm = warmed(Exponential(heat), (slow, fast), np.full_like(heat, 1e-12))
    assert_allclose(warm.surface_1, slow(heat / 3), rtol=1e-3)
    assert_allclose(warm.surface_2, warm.surface_1, rtol=1e-3)


# -- the film between cold walls --------------------------------------------------------------------------------------


def between_cold_walls(Na: float) -> float:
    beta, speed, film = 0.04, 1.0, 1e-7
    stress = Na * CONDUCTIVITY / (beta * speed * film)
    heat, wall = np.array([stress * speed]), Moving(np.zeros((1, 1)))  # it stays cold
    warm = warmed(Exponential(heat, beta), (wall, wall), np.array([film / CONDUCTIVITY]))
    assert warm.converged
    return float(warm.x[0][0] / heat[0])


@pytest.mark.parametrize(("Na", "excess"), [(0.1, 2e-5), (1, 1.69e-3), (8, 0.0411), (50, 0.201), (1000, 0.572)])
def test_one_temperature_for_the_film_against_nahme(Na: float, excess: float) -> None:
    """eta(T_mean) exceeds Nahme's exact viscosity: by 0.2 % at Na = 1, 4 % at 8, 20 % at 50, 57 % at 1000."""
    viscosity = between_cold_walls(Na)
    assert viscosity == pytest.approx(float(np.exp(-lambertw(Na / 12).real)), rel=1e-9)  # theta e^theta = Na/12
    assert viscosity / nahme(Na).viscosity - 1 == pytest.approx(excess, rel=0.02)
    assert between_cold_walls(0.01) == pytest.approx(nahme(0.01).viscosity, abs=0.01**2 / 400)


# -- one solution -----------------------------------------------------------------------------------------------------


def strongly_heated(start: Floats | None = None) -> Warmed:
    heat = hertzian()
    into = moving(STEEL, 1.5), moving(GLASS, 0.5)
    return warmed(Exponential(heat, 0.08), into, np.full_like(heat, 1e-7 / CONDUCTIVITY), heat=start)


def test_cold_and_hot_starts_end_at_the_same_temperatures() -> None:
    cold_start = strongly_heated()
    hot_start = strongly_heated(20.0 * cold_start.x[0])
    assert cold_start.converged and hot_start.converged
    assert cold_start.film.max() > 60.0  # beta T of about 5: the viscosity falls by more than a hundredth
    assert_allclose(hot_start.film, cold_start.film, rtol=1e-6, atol=1e-9)


def test_the_plain_iteration_jumps_between_two_branches_that_are_none() -> None:
    """T <- T(q(T)) ends in a cycle of a cold and a hot film, with the solution between them."""
    heat, into, film = hertzian(), (moving(STEEL, 1.5), moving(GLASS, 0.5)), np.zeros((3, NODES))
    seen = []
    for _ in range(40):
        q = heat * np.exp(-0.08 * film)
        film = warmed(Exponential(q), into, np.full_like(q, 1e-7 / CONDUCTIVITY)).film
        seen.append(film.max())
    low, high = seen[-2:] if seen[-2] < seen[-1] else seen[:-3:-1]
    assert high > 1.5 * low
    assert low < strongly_heated().film.max() < high


@pytest.mark.parametrize("speed", [0.01, 1.0, -1.0, 100.0])
def test_a_surface_never_gives_back_more_heat_than_it_took(speed: float) -> None:
    """What the proof of one solution needs of the discrete kernel: q K q is not below zero."""
    into = response(STEEL, speed, 200, 1e-6)
    assert np.linalg.eigvalsh(into + into.T).min() > 0.0


def test_a_film_that_is_absurdly_stiff_when_cold() -> None:
    """Barus' law far above its range: each iteration takes a factor of e off the viscosity."""
    heat = np.exp(40.0) * hertzian()
    into = moving(STEEL, 1.5), moving(STEEL, 0.5)
    warm = warmed(Exponential(heat, 0.08), into, np.full_like(heat, 1e-7 / CONDUCTIVITY))
    assert warm.converged
    assert_allclose(warm.x[0], heat * np.exp(-0.08 * warm.film), rtol=1e-4)


def test_work() -> None:
    """Few Newton iterations, each with some ten convolutions for both surfaces."""
    warm = strongly_heated()
    assert warm.iterations <= 14
    assert warm.applications <= 25 * warm.iterations
