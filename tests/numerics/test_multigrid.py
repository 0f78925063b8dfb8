import itertools
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jax import Array

from ertel.numerics import halfspace, multigrid
from ertel.numerics.grid import NO_SYMMETRY, Grid
from ertel.numerics.multigrid import Coefficients, DeformationOperator, GridLevel
from ertel.numerics.stencils import Pair
from ertel.physics.geometry import CIRCLE


def impact_on(grid: Grid, dt: float = 0.01, depth: float = 3e-6) -> Coefficients:
    """Coefficients as in an impact: eps tiny in the contact, huge outside, everything stretched by 1.5/dt."""
    r = np.hypot(grid.x[None, :], grid.y[:, None])
    eps = depth + np.where(r > 1, (r**2 - 1) ** 3, 0) * 50
    free = np.pad(np.ones((grid.nodes_y - 2, grid.nodes_x - 2)), 1)
    stretch, local = np.full_like(r, 1.5 / dt), np.zeros_like(r)
    return Coefficients(Pair(eps), stretch, local, free)


def impact_like(nodes: int, dt: float = 0.01, depth: float = 3e-6) -> Coefficients:
    """The same on a square."""
    return impact_on(Grid.square(nodes, 2.0), dt, depth)


def of_levels(of: Callable[..., Any], nodes: int, c: Coefficients, *fields: np.ndarray) -> Any:
    """What a function makes of the levels of the grids and of some fields, compiled as a whole, as NumPy's arrays."""
    elastic = multigrid.deformation_operators(Grid.square(nodes, 2.0), CIRCLE.compliance, "float64")
    whole = jax.jit(lambda elastic, c, *fields: of(multigrid.hierarchy(elastic, c), *fields))
    return jax.tree.map(np.asarray, whole(elastic, c, *fields))


@jax.jit
def contraction(elastic: tuple[DeformationOperator, ...], c: Coefficients, e: Array) -> Array:
    """Asymptotic factor by which one V-cycle reduces the error: the power method on a random error."""
    levels = multigrid.hierarchy(elastic, c)

    def cycle(_: int, e: Array) -> Array:
        e /= jnp.linalg.norm(e)
        return e - multigrid.v_cycle(levels, multigrid.apply(levels[0], e))

    return jnp.linalg.norm(jax.lax.fori_loop(0, 15, cycle, e))


def contraction_on(grid: Grid, c: Coefficients) -> float:
    e = np.random.default_rng(1).standard_normal(c.free.shape) * c.free
    return float(contraction(multigrid.deformation_operators(grid, CIRCLE.compliance, "float64"), c, e))


def contraction_of(nodes: int, c: Coefficients) -> float:
    return contraction_on(Grid.square(nodes, 2.0), c)


FINE = [pytest.param(257, dt, marks=pytest.mark.slow) for dt in (0.1, 0.01, 0.001)]


@pytest.mark.parametrize(("nodes", "dt"), [*((n, dt) for n in (33, 65, 129) for dt in (0.1, 0.01, 0.001)), *FINE])
def test_a_v_cycle_contracts_whatever_the_grid(nodes: int, dt: float) -> None:
    assert contraction_of(nodes, impact_like(nodes, dt)) < 0.6


@pytest.mark.parametrize("finer", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("nodes_x", "nodes_y"), [(65, 33), (33, 65), (65, 17)])
def test_a_v_cycle_contracts_on_a_rectangle(nodes_x: int, nodes_y: int, finer: int) -> None:
    grid = Grid(finer * (nodes_x - 1) + 1, finer * (nodes_y - 1) + 1, 4.0 / (32 * finer))
    assert contraction_on(grid, impact_on(grid)) < 0.6


@pytest.mark.parametrize("ruled_by", ["diffusion", "deformation"])
def test_each_regime_alone(ruled_by: str) -> None:
    nodes = 65
    c = impact_like(nodes)
    one = np.ones_like(c.free)
    c = (
        c._replace(eps=Pair(one), stretch=0 * one)
        if ruled_by == "diffusion"
        else c._replace(eps=Pair(0 * one), stretch=one)
    )
    assert contraction_of(nodes, c) < 0.5


@pytest.mark.parametrize("dt", [0.1, 0.001])
@pytest.mark.parametrize("more", ["along X", "along Y"])
def test_a_v_cycle_contracts_where_the_oil_flows_twice_as_readily_one_way(dt: float, more: str) -> None:
    c = impact_like(65, dt)
    pair = (2 * c.eps.x, c.eps.x) if more == "along X" else (c.eps.x, 2 * c.eps.x)
    assert contraction_of(65, c._replace(eps=Pair(*pair))) < 0.6


def test_the_solution_with_two_mobilities_is_that_of_the_matrix() -> None:
    """The plain twin: flux by flux in loops, the deformation by its coefficients, solved by elimination."""
    nodes, rng = 17, np.random.default_rng(3)
    c = impact_like(nodes)._replace(eps=Pair(*(0.5 + rng.random((nodes, nodes)) for _ in range(2))))
    h = 4.0 / (nodes - 1)
    eps_x, eps_y, stretch, free = (np.asarray(f) for f in (c.eps.x, c.eps.y, c.stretch, c.free))
    K = CIRCLE.compliance * halfspace.love_coefficients(nodes, nodes, h)
    matrix = np.zeros((nodes, nodes, nodes, nodes))
    for i, j in itertools.product(range(1, nodes - 1), repeat=2):
        for (k, m), eps in (((i, j - 1), eps_x), ((i, j + 1), eps_x), ((i - 1, j), eps_y), ((i + 1, j), eps_y)):
            face = (eps[i, j] + eps[k, m]) / 2 / h**2
            matrix[i, j, i, j] += face
            matrix[i, j, k, m] -= face
        for k, m in itertools.product(range(1, nodes - 1), repeat=2):
            matrix[i, j, k, m] += stretch[i, j] * K[abs(i - k), abs(j - m)]
    inner = free.ravel() > 0
    matrix = matrix.reshape(nodes**2, nodes**2)[np.ix_(inner, inner)]
    r = rng.standard_normal((nodes, nodes)) * free
    expected = np.zeros(nodes**2)
    expected[inner] = np.linalg.solve(matrix, r.ravel()[inner])
    elastic = multigrid.deformation_operators(Grid.square(nodes, 2.0), CIRCLE.compliance, "float64")

    @jax.jit
    def solution(c: Coefficients) -> Array:
        levels = multigrid.hierarchy(elastic, c)
        return jax.lax.fori_loop(
            0, 40, lambda _, e: e + multigrid.v_cycle(levels, r - multigrid.apply(levels[0], e)), jnp.zeros(r.shape)
        )

    e = solution(c)
    np.testing.assert_allclose(np.asarray(e).ravel(), expected, atol=1e-10 * np.abs(expected).max())


def test_held_nodes_stay_zero_and_take_no_part() -> None:
    nodes = 33
    c = impact_like(nodes)
    hole = np.ones((nodes, nodes))
    hole[20:28, 5:11] = 0
    c = c._replace(free=c.free * hole)
    r = np.random.default_rng(0).standard_normal((nodes, nodes)) * c.free
    e = of_levels(multigrid.v_cycle, nodes, c, r)
    assert np.all(e[c.free == 0] == 0) and np.any(e[c.free == 1] != 0)
    assert contraction_of(nodes, c) < 0.5


def test_the_direct_solve_solves() -> None:
    c = impact_like(9)
    r = np.random.default_rng(0).standard_normal((9, 9)) * c.free

    def applied(levels: Sequence[GridLevel], r: Array) -> Array:
        return multigrid.apply(levels[0], multigrid.v_cycle(levels[:1], r))

    np.testing.assert_allclose(of_levels(applied, 9, c, r), r, atol=1e-9)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 1000))
def test_restriction_is_the_transpose_of_interpolation(seed: int) -> None:
    rng = np.random.default_rng(seed)
    fine, coarse = rng.standard_normal((33, 33)), rng.standard_normal((17, 17))
    restricted = np.asarray(multigrid.restrict(jnp.asarray(fine)))
    prolonged = np.asarray(multigrid.prolong(jnp.asarray(coarse)))
    assert 4 * np.sum(restricted * coarse) == pytest.approx(np.sum(fine * prolonged), abs=1e-10)


def test_transfers_keep_linear_functions() -> None:
    x, X = Grid.square(33, 2.0).x, Grid.square(17, 2.0).x
    plane, coarse_plane = (jnp.asarray(2 * a[None, :] - a[:, None] + 3) for a in (x, X))
    np.testing.assert_allclose(np.asarray(multigrid.prolong(coarse_plane)), np.asarray(plane), atol=1e-14)
    inner = np.s_[1:-1, 1:-1]
    restricted = np.asarray(multigrid.restrict(plane))
    np.testing.assert_allclose(restricted[inner], np.asarray(coarse_plane)[inner], atol=1e-14)


def test_a_spread_change_deforms_only_nearby() -> None:
    """The dipole's displacement falls with the third power of the distance, the monopole's with the first."""
    c = impact_like(65)._replace(eps=Pair(np.zeros((65, 65))), stretch=np.ones((65, 65)))
    d = np.zeros((65, 65))
    d[32, 32] = 1.0

    def deformed(levels: Sequence[GridLevel], d: Array) -> list[Array]:
        return [multigrid.apply(levels[0], change) for change in (d, multigrid.spread(d))]

    alone, spread = (np.log2(np.abs(u[32, 40] / u[32, 48])) for u in of_levels(deformed, 65, c, d))
    assert alone == pytest.approx(1, abs=0.05)
    assert spread == pytest.approx(3, abs=0.2)


def test_nothing_is_spread_to_where_diffusion_dominates() -> None:
    """There, a share of a change would leave a residual far larger than the one it removes."""
    c = impact_like(65)

    def changed(levels: Sequence[GridLevel]) -> tuple[Array, Array, Array]:
        smoother = levels[0].smoother
        alone = smoother.jacobi > 0
        soft = ~alone & (c.free > 0)
        return alone, soft, smoother.change(soft.astype(float))

    alone, soft, change = of_levels(changed, 65, c)
    assert alone.any() and soft.any()
    assert np.all(change[alone] == 0.0)
    assert np.any(change[soft] != 0.0)


def test_multilevel_integration_is_near_the_sum() -> None:
    """Of the worst there is, a random field, within 0.3; of a smooth one far nearer, and more so on fine grids."""

    def both(levels: Sequence[GridLevel], field: Array) -> tuple[Array, Array]:
        fine, coarse = levels[:2]
        return fine.elasticity.displacement(field), multigrid.nearly_deformed(fine, coarse, field)

    def error(nodes: int, field: np.ndarray) -> float:
        exact, near = of_levels(both, nodes, impact_like(nodes), field)
        return float(np.linalg.norm(near - exact) / np.linalg.norm(exact))

    def bump(nodes: int) -> np.ndarray:
        x = Grid.square(nodes, 2.0).x[1:-1]
        return np.pad(np.exp(-4 * (x[None, :] ** 2 + x[:, None] ** 2)), 1)

    for nodes in (33, 129):
        assert error(nodes, np.pad(np.random.default_rng(0).standard_normal((nodes - 2, nodes - 2)), 1)) < 0.3
    assert error(33, bump(33)) < 20.0 / 33**2
    assert error(129, bump(129)) < error(33, bump(33)) / 6


def test_smooth_prolongation_is_exact_for_cubics_inside() -> None:
    x = np.linspace(-1, 1, 9)
    fine = np.linspace(-1, 1, 17)
    found = np.asarray(jax.jit(multigrid.prolong_smooth)(x[None, :] ** 3 + x[:, None] ** 2))
    np.testing.assert_allclose(found[2:-2, 2:-2], (fine[None, :] ** 3 + fine[:, None] ** 2)[2:-2, 2:-2], atol=1e-12)


def test_lowest_mean_is_a_bound_that_sees_the_neighbourhood() -> None:
    lowest_mean = jax.jit(lambda field: multigrid.lowest_mean(field, NO_SYMMETRY, 2))
    field = np.ones((33, 33))
    field[16, 16] = -100.0
    least = np.asarray(lowest_mean(field))
    assert np.all(least <= field)
    assert np.all(least[14:19, 14:19] < 0) and np.all(least[:8] > 0)
    np.testing.assert_allclose(np.asarray(lowest_mean(np.ones((33, 33))))[4:-4, 4:-4], 1.0)
