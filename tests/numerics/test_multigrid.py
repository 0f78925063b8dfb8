from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

from ertel.numerics import halfspace, multigrid
from ertel.numerics.grid import NO_SYMMETRY, Grid
from ertel.numerics.multigrid import Coefficients, DeformationOperator, GridLevel
from ertel.numerics.stencils import Pair, diffusion
from ertel.physics.geometry import CIRCLE


def impact_on(grid: Grid, dt: float = 0.01) -> Coefficients:
    """Coefficients as in an impact: eps tiny in the contact, huge outside, everything stretched by 1.5/dt."""
    r = np.hypot(grid.x[None, :], grid.y[:, None])
    eps = 3e-6 + np.where(r > 1, (r**2 - 1) ** 3, 0) * 50
    free = np.pad(np.ones((grid.nodes_y - 2, grid.nodes_x - 2)), 1)
    return Coefficients(Pair(eps), np.full_like(r, 1.5 / dt), np.zeros_like(r), free)


def square(nodes: int) -> Grid:
    return Grid.square(nodes, 2.0)


def of_levels(of: Callable[..., Any], grid: Grid, c: Coefficients, *fields: np.ndarray) -> Any:
    """What a function makes of the levels of the grids and of some fields, compiled as a whole, as NumPy's arrays."""
    elastic = multigrid.deformation_operators(grid, CIRCLE.compliance, "float64")
    whole = jax.jit(lambda elastic, c, *fields: of(multigrid.hierarchy(elastic, c), *fields))
    return jax.tree.map(np.asarray, whole(elastic, c, *fields))


@jax.jit
def _contraction(elastic: tuple[DeformationOperator, ...], c: Coefficients, e: Array) -> Array:
    levels = multigrid.hierarchy(elastic, c)

    def cycle(_: int, e: Array) -> Array:
        e /= jnp.linalg.norm(e)
        return e - multigrid.v_cycle(levels, multigrid.apply(levels[0], e))

    return jnp.linalg.norm(jax.lax.fori_loop(0, 15, cycle, e))


def contraction(grid: Grid, c: Coefficients) -> float:
    """Asymptotic factor by which one V-cycle reduces the error: the power method on a random error."""
    e = np.random.default_rng(1).standard_normal(c.free.shape) * c.free
    return float(_contraction(multigrid.deformation_operators(grid, CIRCLE.compliance, "float64"), c, e))


STEPS = 0.1, 0.01, 0.001
GRIDS = [(square(nodes), dt) for nodes in (33, 65, 129) for dt in STEPS]
GRIDS += [(Grid(nodes_x, nodes_y, 0.125), 0.01) for nodes_x, nodes_y in ((65, 33), (33, 65), (65, 17))]
FINE = [(square(257), dt) for dt in STEPS]
FINE += [(Grid(nodes_x, nodes_y, 0.0625), 0.01) for nodes_x, nodes_y in ((129, 65), (65, 129), (129, 33))]


@pytest.mark.parametrize(("grid", "dt"), [*GRIDS, *(pytest.param(*fine, marks=pytest.mark.slow) for fine in FINE)])
def test_a_v_cycle_contracts_whatever_the_grid(grid: Grid, dt: float) -> None:
    assert contraction(grid, impact_on(grid, dt)) < 0.6


@pytest.mark.parametrize("ruled_by", ["diffusion", "deformation"])
def test_each_regime_alone(ruled_by: str) -> None:
    c = impact_on(square(65))
    one, zero = np.ones_like(c.free), np.zeros_like(c.free)
    eps, stretch = (one, zero) if ruled_by == "diffusion" else (zero, one)
    assert contraction(square(65), c._replace(eps=Pair(eps), stretch=stretch)) < 0.5


@pytest.mark.parametrize("dt", [0.1, 0.001])
@pytest.mark.parametrize("more", [(2, 1), (1, 2)], ids=["along X", "along Y"])
def test_a_v_cycle_contracts_where_the_oil_flows_twice_as_readily_one_way(dt: float, more: tuple[int, int]) -> None:
    c = impact_on(square(65), dt)
    assert contraction(square(65), c._replace(eps=Pair(*(share * c.eps.x for share in more)))) < 0.6


def test_cycles_end_at_the_solution_with_two_mobilities() -> None:
    """By the module's equation, with the diffusion and the deformation that are compared with plain sums elsewhere."""
    grid, rng = square(17), np.random.default_rng(3)
    c = impact_on(grid)._replace(eps=Pair(*(0.5 + rng.random((17, 17)) for _ in range(2))))
    r = rng.standard_normal((17, 17)) * c.free

    def solution(levels: Sequence[GridLevel], r: Array) -> Array:
        return jax.lax.fori_loop(
            0, 40, lambda _, e: e + multigrid.v_cycle(levels, r - multigrid.apply(levels[0], e)), jnp.zeros(r.shape)
        )

    e = jnp.asarray(of_levels(solution, grid, c, r))
    deformation = halfspace.kernel(grid, CIRCLE.compliance).displacement(e)
    left = c.stretch * deformation - diffusion(c.eps, e) / grid.spacing**2 - r
    assert np.all(e[c.free == 0] == 0)
    np.testing.assert_allclose(c.free * left, 0.0, atol=1e-11 * np.abs(r).max())


def test_held_nodes_stay_zero_and_take_no_part() -> None:
    c = impact_on(square(33))
    c.free[20:28, 5:11] = 0
    r = np.random.default_rng(0).standard_normal((33, 33)) * c.free
    e = of_levels(multigrid.v_cycle, square(33), c, r)
    assert np.all(e[c.free == 0] == 0) and np.any(e[c.free == 1] != 0)
    assert contraction(square(33), c) < 0.5


def test_the_direct_solve_solves() -> None:
    c = impact_on(square(9))
    r = np.random.default_rng(0).standard_normal((9, 9)) * c.free

    def applied(levels: Sequence[GridLevel], r: Array) -> Array:
        return multigrid.apply(levels[0], multigrid.v_cycle(levels[:1], r))

    np.testing.assert_allclose(of_levels(applied, square(9), c, r), r, atol=1e-9)


def test_restriction_is_the_transpose_of_interpolation() -> None:
    rng = np.random.default_rng(0)
    fine, coarse = rng.standard_normal((33, 33)), rng.standard_normal((17, 17))
    restricted, prolonged = np.asarray(multigrid.restrict(fine)), np.asarray(multigrid.prolong(coarse))
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
    c = impact_on(square(65))._replace(eps=Pair(np.zeros((65, 65))), stretch=np.ones((65, 65)))
    d = np.zeros((65, 65))
    d[32, 32] = 1.0

    def deformed(levels: Sequence[GridLevel], d: Array) -> list[Array]:
        return [multigrid.apply(levels[0], change) for change in (d, multigrid.spread(d))]

    alone, spread = (np.log2(np.abs(u[32, 40] / u[32, 48])) for u in of_levels(deformed, square(65), c, d))
    assert alone == pytest.approx(1, abs=0.05)
    assert spread == pytest.approx(3, abs=0.2)


def test_nothing_is_spread_to_where_diffusion_dominates() -> None:
    """There, a share of a change would leave a residual far larger than the one it removes."""
    c = impact_on(square(65))

    def changed(levels: Sequence[GridLevel]) -> tuple[Array, Array, Array]:
        smoother = levels[0].smoother
        alone = smoother.jacobi > 0
        soft = ~alone & (c.free > 0)
        return alone, soft, smoother.change(soft.astype(float))

    alone, soft, change = of_levels(changed, square(65), c)
    assert alone.any() and soft.any()
    assert np.all(change[alone] == 0.0)
    assert np.any(change[soft] != 0.0)


def test_multilevel_integration_is_near_the_sum() -> None:
    """Of the worst there is, a random field, within 0.3; of a smooth one far nearer, and more so on fine grids."""

    def both(levels: Sequence[GridLevel], field: Array) -> tuple[Array, Array]:
        fine, coarse = levels[:2]
        return fine.elasticity.displacement(field), multigrid.nearly_deformed(fine, coarse, field)

    def error(nodes: int, field: np.ndarray) -> float:
        exact, near = of_levels(both, square(nodes), impact_on(square(nodes)), field)
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
