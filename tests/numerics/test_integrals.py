"""Integrals over grids and along their edges: exact for polynomials of low degree, the same on a part of the plane."""

from math import pi

import jax
import numpy as np
import pytest
from jax import Array
from made_up import every_symmetry

from ertel.numerics.grid import NO_SYMMETRY, Grid, Symmetry
from ertel.numerics.integrals import Disc, Plane
from ertel.numerics.stencils import Pair, divergence, folded

W = 1.6  # half width of the rectangle


def plane(even: Symmetry, nodes: int = 17) -> tuple[Plane, np.ndarray, np.ndarray]:
    """The rectangle, and X and Y of its kept nodes."""
    grid = Grid(nodes, nodes, 2 * W / (nodes - 1), even=even)
    X, Y = np.meshgrid(grid.kept_x, grid.kept_y)
    return Plane.of(grid), X, Y


@every_symmetry
def test_linear_and_quadratic_fields_on_a_plane(even: Symmetry) -> None:
    space, X, Y = plane(even)
    f = X**2 / 2 + Y**2

    @jax.jit
    def integrals(one: Pair, linear: Array, f: Array) -> tuple[Array, ...]:
        slopes, out = space.total(space.of_slopes(one, f, f)), space.around(-space.flow_out(one, f))
        return space.total(linear), slopes, out, space.around(space.edge(one.x))

    one = np.ones_like(f)
    total, slopes, out, edge = map(float, integrals(Pair(one, one), 3 + np.abs(X) + np.abs(Y), f))
    assert total == pytest.approx(4 * W**2 * (3 + W), rel=1e-14)
    # second order in the slopes of f, exact in what flows out: 4 w (w + 2 w) through the four sides
    h2 = space.spacing**2
    inside = 4 * W**2 * (W**2 / 3 + 4 * W**2 / 3 - h2 * (1 + 4) / 12)
    assert slopes == pytest.approx(inside, rel=1e-13)
    assert out == pytest.approx(4 * W**2 * 3, rel=1e-13)
    assert edge == pytest.approx(8 * W, rel=1e-14)


def test_nothing_flows_out_of_a_cavity_at_the_edge() -> None:
    space, X, _ = plane(NO_SYMMETRY)
    pressure = np.where(np.abs(X) < W - 1.5 * space.spacing, 1.0, 0.0)
    pressure[[0, 1, -2, -1]] = 0.0
    one = Pair(np.ones_like(pressure), np.ones_like(pressure))
    assert np.abs(jax.jit(Plane.flow_out)(space, one, pressure)).max() == 0.0


def test_what_flows_along_x_enters_on_one_side_and_leaves_on_the_other() -> None:
    for even in (NO_SYMMETRY, Symmetry(y=True)):
        space, X, _ = plane(even)
        through = jax.jit(lambda space, f: space.around(space.along_x(f)))
        assert float(through(space, 5 + X)) == pytest.approx(4 * W**2, rel=1e-13)


@every_symmetry
def test_what_leaves_through_the_outermost_faces_is_what_the_cells_within_lose(even: Symmetry) -> None:
    """Of any flow; each side counts as often as it stands on the whole plane."""
    space, X, _ = plane(even)
    random = np.random.default_rng(4)
    on_x, on_y = (random.random(np.add(X.shape, more)) for more in ((0, 1), (1, 0)))
    for axis, field in ((even.x, on_x.T), (even.y, on_y)):
        field[0] = -field[1] if axis else field[0]  # the flow is odd about an axis

    @jax.jit
    def both(space: Plane, on_x: Array, on_y: Array) -> tuple[Array, Array]:
        return space.inner(divergence(on_x, on_y) / space.spacing), space.leaving(on_x, on_y)

    lost, leaving = both(space, on_x, on_y)
    assert float(leaving.sum()) == pytest.approx(float(lost), rel=1e-12)
    uniform = both(space, np.ones_like(on_x), np.zeros_like(on_y))[1]
    side = 2 * W - space.spacing
    assert float(np.maximum(uniform, 0.0).sum()) == pytest.approx(side * (1 + even.x), rel=1e-12)


@pytest.mark.parametrize("even", [Symmetry(y=True), Symmetry(x=True), Symmetry(True, True)], ids=str)
def test_a_part_of_the_plane_gives_what_the_whole_gives(even: Symmetry) -> None:
    whole, X, Y = plane(NO_SYMMETRY)
    f, g = np.exp(-(X**2) - 2 * Y**2) + 1, np.cos(X) * np.cosh(Y)
    part, *_ = plane(even)

    @jax.jit
    def terms(space: Plane, c: Pair) -> tuple[Array, ...]:
        slopes, out = space.total(space.of_slopes(c, c.x, c.y)), space.around(space.flow_out(c, c.y))
        return space.total(c.x), slopes, out, *space.push(c.x, c.y)

    found = []
    for space, (a, b) in ((whole, (f, g)), (part, (folded(f, even), folded(g, even)))):
        found.append([float(term) for term in terms(space, Pair(a, a + b))])
    assert found[1] == pytest.approx(found[0], rel=1e-13, abs=1e-13)


def test_a_disc() -> None:
    """Second order inside, on an uneven grid; a cubic field's slope at the edge is exact."""

    @jax.jit
    def integrals(space: Disc, f: Array, g: Array, cubic: Array, c: Pair) -> tuple[Array, Array, Array]:
        return space.total(f), space.total(space.of_slopes(c, f, g)), space.around(space.flow_out(c, cubic))

    errors = []
    for nodes in (21, 41, 81):
        r = 2 * np.linspace(0, 1, nodes) ** 1.5
        total, slopes, out = map(float, integrals(Disc.of(r), np.exp(-(r**2)), r**2, r**3, Pair(1 + r**2)))
        of_f = total - pi * (1 - np.exp(-4))
        # int (1 + r^2) (-2 r exp(-r^2)) 2 r 2 pi r dr = -4 pi int_0^4 (1 + u) u exp(-u) du / 1
        u = np.linspace(0, 4, 20001)
        slopes += 4 * pi * np.trapezoid((1 + u) * u * np.exp(-u), u)
        errors.append([of_f, slopes])
        assert out == pytest.approx(-4 * pi * 5 * 12, rel=1e-12)
    orders = np.log2(np.abs(np.divide(errors[:-1], errors[1:])))
    assert np.all(orders > 1.9), orders
