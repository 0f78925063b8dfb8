"""The flow of a thinning oil on the grid: its limit, order, derivative and symmetry, and overlapping surfaces."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

from ertel.equations.contact import NEWTONIAN_FLOW, Contact, bare_contact, mobility, traceable
from ertel.equations.shear import shear
from ertel.equations.thinning import ThinningFlow
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.integrals import Plane
from ertel.numerics.stencils import divergence, folded, node_slopes, unfolded
from ertel.physics.fluidity import Fluidity, ReeEyring
from ertel.physics.geometry import CIRCLE
from ertel.physics.lubricant import DowsonHigginson, Lubricant, Roelands

OIL = Lubricant(Roelands(5.0, 0.67, 5.0), DowsonHigginson(1.6))
EYRING, STIFF = ReeEyring(0.05), ReeEyring(1e12)


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, compiled, whose results are arrays of NumPy: what is done with them needs no compilation."""
    program = jax.jit(function)
    return lambda *arguments: jax.tree.map(np.asarray, program(*arguments))


GAIN = compiled(lambda c, P, H: c.flow.gain(c, P, H))
SLOPE = compiled(lambda c, P, H, dP, dH: jax.jvp(partial(c.flow.gain, c), (P, H), (dP, dH))[1])
MOBILITIES = compiled(lambda c, P, H: c.flow.mobilities(c, P, H))
DETAILS = compiled(lambda c, P, H, sliding, plane: c.flow.details(c, P, H, sliding, plane))
LEFT = compiled(lambda details, spacing: divergence(*details.fluxes) / spacing)
MOBILITY = compiled(mobility)
SHEAR = compiled(shear)


def thinning(grid: Grid, law: Fluidity = EYRING, sliding: float = 1.0) -> Contact:
    """A contact with stresses in the units of the film, in which sliding and gradient thin the oil by several times."""
    return replace(bare_contact(CIRCLE, grid, 0.4, OIL), flow=ThinningFlow(traceable(law), 1.0, 1.0, sliding))


def fields(grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """A pressure that vanishes on the edge, even in both directions, and a film."""
    X, Y = grid.x[None, :], grid.y[:, None]
    P = np.asarray(np.cos(np.pi / 4 * X) ** 2 * np.cos(np.pi / 4 * Y) ** 2 * (1.0 + 0.3 * X**2))
    return P, np.asarray(0.3 + 0.1 * X**2 + 0.2 * Y**2)


def square_grid(nodes: int) -> Grid:
    return Grid(nodes, nodes, 4.0 / (nodes - 1))


def test_an_oil_that_does_not_thin_is_newtonian():
    grid = square_grid(33)
    c, (P, H) = thinning(grid, STIFF), fields(grid)
    plain = replace(c, flow=NEWTONIAN_FLOW)
    newtonian = GAIN(plain, P, H)
    inner = np.s_[1:-1, 1:-1]
    assert_allclose(GAIN(c, P, H)[inner], newtonian[inner], rtol=0, atol=1e-12 * float(np.abs(newtonian).max()))
    for thin in MOBILITIES(c, P, H):
        for along in (thin.x, thin.y):
            assert_allclose(along, MOBILITY(c, P, H), rtol=1e-12)
    thin, plain = (DETAILS(each, P, H, 0.7, Plane.of(grid)) for each in (c, plain))
    assert_allclose(thin.heat, plain.heat, rtol=1e-11, atol=1e-12 * float(np.abs(plain.heat).max()))
    assert_allclose(thin.stress, plain.stress, rtol=1e-11, atol=1e-12 * float(np.abs(plain.stress).max()))


@pytest.mark.parametrize("sliding", [0.0, 1.0])
def test_the_flow_is_of_second_order(sliding: float):
    """Differences between grids fall by four; thinning is strong here."""
    values = []
    for nodes in (33, 65, 129):
        grid = square_grid(nodes)
        inner = slice((nodes - 1) // 32, -1, (nodes - 1) // 32)
        values.append(np.asarray(GAIN(thinning(grid, sliding=sliding), *fields(grid)))[inner, inner])
    coarse, fine = (np.abs(a - b).max() for a, b in pairwise(values))
    assert 3.5 < coarse / fine < 4.6
    grid = square_grid(33)
    plain = np.asarray(GAIN(replace(thinning(grid), flow=NEWTONIAN_FLOW), *fields(grid)))[1:-1, 1:-1]
    assert np.abs(values[0]).max() > 1.5 * np.abs(plain).max()


def test_the_derivative_is_that_of_the_flow():
    grid = square_grid(33)
    c, (P, H) = thinning(grid), fields(grid)
    dP, dH = P * np.sin(3.0 * P), 0.1 * np.cos(4.0 * H)
    slope = SLOPE(c, P, H, dP, dH)
    step = 1e-6
    difference = (GAIN(c, P + step * dP, H + step * dH) - GAIN(c, P - step * dP, H - step * dH)) / (2 * step)
    assert_allclose(slope[1:-1, 1:-1], difference[1:-1, 1:-1], rtol=0, atol=1e-7 * float(np.abs(slope).max()))


def test_half_a_plane_and_a_quarter_of_it_are_enough():
    """For the flow and its details; the stress across the sliding changes its sign at the axis along it."""
    grid = square_grid(33)
    P, H = fields(grid)
    inner = np.s_[1:-1, 1:-1]

    def on_part(field: np.ndarray, even: Symmetry) -> np.ndarray:
        """The gain on part of the plane, unfolded, without the edge."""
        return np.asarray(unfolded(field, even))[inner]

    gain = np.asarray(GAIN(thinning(grid), P, H))[inner]
    even = Symmetry(True, True)
    quarter = GAIN(thinning(replace(grid, even=even)), folded(P, even), folded(H, even))
    assert_allclose(on_part(quarter, even), gain, rtol=0, atol=1e-12 * np.abs(gain).max())
    even = Symmetry(True, False)
    half = replace(grid, even=even)
    whole = DETAILS(thinning(grid), P, H, 0.7, Plane.of(grid))
    part = DETAILS(thinning(half), folded(P, even), folded(H, even), 0.7, Plane.of(half))
    gain = np.asarray(LEFT(whole, grid.spacing))[inner]
    assert_allclose(on_part(LEFT(part, grid.spacing), even), gain, rtol=0, atol=1e-12 * np.abs(gain).max())
    for found, expected, odd in [(part.stress[0], whole.stress[0], False), (part.stress[1], whole.stress[1], True)]:
        assert_allclose(unfolded(found, even, odd)[inner], expected[inner], atol=1e-9 * float(np.abs(expected).max()))
    assert float(np.abs(whole.stress[1]).max()) > 1e-3 * float(np.abs(whole.stress[0]).max())
    assert_allclose(unfolded(part.heat, even), whole.heat, atol=1e-9 * float(np.abs(whole.heat).max()))
    assert float(Plane.of(half).total(part.heat)) == pytest.approx(float(Plane.of(grid).total(whole.heat)), rel=1e-9)
    assert_allclose(gain, GAIN(thinning(grid, sliding=0.7), P, H)[inner], rtol=1e-7)
    for found, expected in zip(whole.mobility, MOBILITIES(thinning(grid, sliding=0.7), P, H).tangent, strict=True):
        assert_allclose(found, expected, rtol=1e-7)


def test_the_secant_mobility_is_that_along_the_gradient():
    """In pure rolling the integral of zeta^2 phi across the film; sliding thins the oil further."""
    grid = square_grid(33)
    (P, H), rolling = fields(grid), thinning(grid, sliding=0.0)
    size = np.asarray(H * np.hypot(*node_slopes(P, grid.spacing)))
    z, weight = (both[:, None, None] for both in np.polynomial.legendre.leggauss(40))
    factor = 12.0 * np.sum(weight / 2 * (z / 2) ** 2 * EYRING.fluidity(np.abs(z) / 2 * size, 0.0), axis=0)
    secant, tangent = MOBILITIES(rolling, P, H)
    plain = MOBILITY(rolling, P, H)
    assert_allclose(secant.x / plain, np.where(size > 0.0, factor, 1.0), rtol=1e-6)
    assert factor.max() > 2.0 and np.all(tangent.x + tangent.y >= (1.0 - 1e-9) * 2.0 * secant.x)
    slid = np.asarray(MOBILITIES(thinning(grid), P, H).secant.x)
    assert np.all(slid >= (1.0 - 1e-9) * np.asarray(secant.x))
    along_x = rolling.lambda_bar * OIL.viscosity(P) / (12.0 * H)
    gradient = H * np.stack(node_slopes(P, grid.spacing))
    film = SHEAR(EYRING, P, np.stack([along_x, 0.0 * along_x]), gradient)
    assert_allclose(slid / plain * size**2, 12.0 * (film.flux * gradient).sum(axis=0), rtol=1e-9, atol=1e-14)


def test_the_edge_thins_the_oil_by_no_gradient_of_its_own():
    """A uniform pressure that fills the grid: the mobility on the edge is that inside."""
    grid = square_grid(33)
    same = np.ones((33, 33))
    for along in DETAILS(thinning(grid), same, 0.3 * same, 1.0, Plane.of(grid)).mobility:
        assert_allclose(along, along[16, 16], rtol=1e-12)


def test_nothing_flows_where_the_surfaces_overlap():
    grid = square_grid(33)
    c, (P, H) = thinning(grid), fields(grid)
    H = np.where(np.hypot(*np.meshgrid(grid.x, grid.y)) < 0.5, -0.1, H)
    gain, slope = GAIN(c, P, H), SLOPE(c, P, H, P, H)
    assert np.all(np.isfinite(gain)) and np.all(np.isfinite(slope))
    assert np.all(np.asarray(gain)[14:19, 14:19] == 0)
