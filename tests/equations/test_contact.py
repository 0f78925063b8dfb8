from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import orders
from hypothesis import given, settings
from hypothesis import strategies as st
from jax import Array

from ertel.equations import contact
from ertel.equations.contact import Contact
from ertel.equations.flow import Rate, flow_aligned
from ertel.equations.linearised import linear_film
from ertel.numerics import stencils
from ertel.numerics.grid import Grid
from ertel.numerics.stencils import Pair
from ertel.physics import hertz
from ertel.physics.geometry import CIRCLE, Geometry
from ertel.physics.lubricant import Barus, DowsonHigginson, Incompressible, Isoviscous, Lubricant, Roelands

FILM_THICKNESS = jax.jit(contact.film_thickness)
PLAIN = Lubricant(Isoviscous(), Incompressible())
REAL = Lubricant(Roelands(20.0, 0.67, 5.0), DowsonHigginson(1.6))


def smooth_fields(grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    x, y = grid.x[None, :], grid.y[:, None]
    P = np.exp(-2 * (x**2 + 1.3 * y**2 + 0.4 * x * y)) * (4 - x**2) * (4 - y**2) / 16
    return P, 0.3 + 0.1 * x**2 + 0.2 * y**2 + 0.05 * np.sin(x + 2 * y)


def test_hertz_pressure_closes_the_gap() -> None:
    grid = Grid.square(257, 2.0)
    dry = contact.bare_contact(CIRCLE, grid, 1.0, PLAIN)
    r = np.hypot(grid.x[None, :], grid.y[:, None])
    H = np.asarray(FILM_THICKNESS(dry, hertz.pressure(r), 1.0))
    assert np.abs(H[r < 0.9]).max() < 1e-3
    np.testing.assert_allclose(H[r > 1.1], hertz.gap(r)[r > 1.1], atol=1e-3)
    assert float(jax.jit(contact.pressure_load)(dry, hertz.pressure(r))) == pytest.approx(2 * np.pi / 3, rel=1e-3)


@pytest.mark.parametrize("entrainment", [0.0, 1.0, -1.0])
@pytest.mark.parametrize("oil", [PLAIN, REAL, Lubricant(Barus(6.0), Incompressible())])
def test_the_residual_is_second_order(entrainment: float, oil: Lubricant) -> None:
    """Successive grids agree at common nodes, away from the edge, with differences falling by four."""
    values = []
    for nodes in (65, 129, 257, 513):
        grid = Grid.square(nodes, 2.0)
        P, H = smooth_fields(grid)
        c = contact.bare_contact(CIRCLE, grid, 0.05, oil)
        r = residual_in_any_flow(c, P, H, Rate(3.0, -0.5, entrainment))
        step = (nodes - 1) // 64
        values.append(np.asarray(r)[4 * step : -4 * step : step, 4 * step : -4 * step : step])
    assert np.all(np.abs(orders(values) - 2) < 0.25), orders(values)


def test_the_residual_of_a_known_flow() -> None:
    """H = 1, isoviscous: div(P flux) = Laplacian(P)/lambda_bar; P = X^2 (1 + Y) has the Laplacian 2 (1 + Y)."""
    grid = Grid.square(33, 2.0)
    x, y = grid.x[None, :], grid.y[:, None]
    c = contact.bare_contact(CIRCLE, grid, 0.25, PLAIN)
    r = jax.jit(contact.residual)(c, x**2 * (1 + y), np.ones((33, 33)), Rate(0.0, 0.0))
    np.testing.assert_allclose(
        np.asarray(r)[1:-1, 1:-1], np.broadcast_to(-8 * (1 + y), (33, 33))[1:-1, 1:-1], rtol=1e-10
    )


@jax.jit
def net_flux(eps: Array, P: Array) -> Array:
    return jnp.sum(stencils.inside(stencils.diffusion(Pair(eps), P)))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_mass_is_conserved_by_the_fluxes(seed: int) -> None:
    """What the fluxes take out of the inner cells is exactly what passes the edge."""
    rng = np.random.default_rng(seed)
    eps, P = rng.random((17, 17)), rng.random((17, 17))
    net = float(net_flux(eps, P))
    face = (eps[1:] + eps[:-1]) / 2 * np.diff(P, axis=0)
    side = (eps[:, 1:] + eps[:, :-1]) / 2 * np.diff(P, axis=1)
    through = (face[-1] - face[0])[1:-1].sum() + (side[:, -1] - side[:, 0])[1:-1].sum()
    assert net == pytest.approx(through, abs=1e-12)


@jax.jit
def residual_in_any_flow(c: Contact, P: Array, H: Array, rate: Rate) -> Array:
    """As the solver takes it: X along the flow, and back again."""
    turned = partial(flow_aligned, rate)
    return turned(contact.residual(c, turned(P), turned(H), Rate(rate.new, turned(rate.past), abs(rate.wedge))))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.floats(-2, 2))
def test_mirroring_the_contact_mirrors_the_residual(seed: int, U: float) -> None:
    """Along the flow with the speed, and across it."""
    rng = np.random.default_rng(seed)
    c = contact.bare_contact(CIRCLE, Grid.square(17, 2.0), 0.1, REAL)
    P, H = rng.random((17, 17)), 0.1 + rng.random((17, 17))
    r = np.asarray(residual_in_any_flow(c, P, H, Rate(2.0, -H, U)))
    along = residual_in_any_flow(c, P[:, ::-1], H[:, ::-1], Rate(2.0, -H[:, ::-1], -U))
    across = residual_in_any_flow(c, P[::-1], H[::-1], Rate(2.0, -H[::-1], U))
    np.testing.assert_allclose(along, r[:, ::-1], atol=1e-10)
    np.testing.assert_allclose(across, r[::-1], atol=1e-10)


@jax.jit
def changes_of_the_residual(c: Contact, films: tuple[Array, Array], by: tuple[Array, Array]) -> tuple[Array, Array]:
    """By `LinearFilm`, and by the derivative of the residual itself."""
    rate = Rate(3.0, -0.5, 0.7)
    linear = linear_film(c, *films).residual(*by, lambda mass: rate._replace(past=0.0).of(mass, c.spacing))
    return linear, jax.jvp(lambda P, H: contact.residual(c, P, H, rate), films, by)[1]


def test_the_linear_film_is_the_derivative_of_the_residual() -> None:
    """Exactly for a Newtonian oil, to round-off, for any film and any change of it."""
    rng = np.random.default_rng(7)
    P, dP, dH = (jnp.asarray(values) for values in rng.random((3, 17, 17)))
    c = contact.bare_contact(CIRCLE, Grid.square(17, 2.0), 0.1, REAL)
    linear, exact = changes_of_the_residual(c, (P, 0.1 + P), (dP, dH))
    np.testing.assert_allclose(linear, exact, rtol=0, atol=1e-13 * float(np.abs(exact).max()))
    assert float(np.abs(exact).max()) > 1.0


@pytest.mark.parametrize(("D", "angle"), [(0.2, 0.0), (3.0, 0.0), (0.3, 35.0)])
def test_dry_contact_of_an_ellipse(D: float, angle: float) -> None:
    """The Hertz ellipsoid under the solver's kernel makes the gap zero inside, with order 2."""
    ellipse = Geometry(D, angle)
    wide, high = ellipse.extent
    errors = []
    for cells in (10, 20, 40):  # per smaller half width
        spacing = ellipse.smaller / cells
        columns, rows = (2 * round(1.1 * side / spacing) + 1 for side in (wide, high))
        grid = Grid(columns, rows, spacing)
        c = contact.bare_contact(ellipse, grid, 0.01, PLAIN)
        X, Y = grid.x[None, :], grid.y[:, None]
        H = np.asarray(FILM_THICKNESS(c, ellipse.dry_pressure(1.0, X, Y), ellipse.dry_approach(1.0)))
        errors.append(np.abs(H[ellipse.distance(X, Y) < 0.8]).mean())
    assert (np.log2(np.divide(errors[:-1], errors[1:])) > 1.8).all(), errors
    assert errors[-1] < 2e-4 * ellipse.dry_approach(1.0), errors
