from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import solve_banded

from ertel.numerics import multigrid
from ertel.numerics.grid import Grid
from ertel.numerics.line_smoother import SHORT, LineSmoother, factorise, line_smoother, solve_lines
from ertel.numerics.multigrid import Coefficients, DeformationOperator
from ertel.numerics.stencils import Pair
from ertel.physics.geometry import CIRCLE


def rolling_on(nodes: int) -> tuple[Grid, Coefficients]:
    """Coefficients as in rolling: eps tiny in the contact, large outside, nothing free downstream of it."""
    grid = Grid(nodes, nodes, 6.0 / (nodes - 1), -1.5)
    x, y = grid.x[None, :], grid.y[:, None]
    r = np.hypot(x, y)
    eps = 1e-5 + np.where(r > 1, (r**2 - 1) ** 3, 0) * 5
    free = np.pad(((x < 0.5) | (r < 1))[1:-1, 1:-1].astype(float), 1)
    return grid, Coefficients(Pair(eps), np.ones_like(r), np.zeros_like(r), free)


@jax.jit
def contraction(elastic: tuple[DeformationOperator, ...], c: Coefficients, e: jax.Array) -> jax.Array:
    """The asymptotic factor by which one V-cycle alone reduces the error."""
    levels = multigrid.hierarchy(elastic, c, lambda e, c: line_smoother(e, c, 0.0, 1.0))

    def cycle(_: int, e: jax.Array) -> jax.Array:
        e /= jnp.linalg.norm(e)
        return e - multigrid.v_cycle(levels, multigrid.apply(levels[0], e))

    return jnp.linalg.norm(jax.lax.fori_loop(0, 15, cycle, e))


def one_mobility(eps: np.ndarray) -> Pair:
    return Pair(eps)


def twice_along_x(eps: np.ndarray) -> Pair:
    return Pair(2 * eps, eps)


def twice_along_y(eps: np.ndarray) -> Pair:
    return Pair(eps, 2 * eps)


def hardly_above_the_deformation(eps: np.ndarray) -> Pair:
    """The mobility jumps from nothing to a value at which Jacobi would amplify short waves."""
    eps = np.where(eps > 1e-3, 0.1 * (6.0 / 64) ** 2, 1e-11)
    return Pair(eps, eps)


def thinned_by_sliding(share: float, eps: np.ndarray) -> Pair:
    """Mobilities of a gear: along X as large as the deformation there, along Y a twelfth of it."""
    inside = share * (6.0 / 64) ** 2
    return Pair(np.maximum(eps, inside), np.maximum(eps, inside / 12))


@pytest.mark.parametrize(
    ("nodes", "mobility"),
    [
        (33, one_mobility),
        *((65, mobility) for mobility in (twice_along_x, twice_along_y, hardly_above_the_deformation)),
        *((65, partial(thinned_by_sliding, share)) for share in (0.05, 0.2, 0.4)),
        *(pytest.param(nodes, one_mobility, marks=pytest.mark.slow) for nodes in (65, 129)),
    ],
)
def test_a_v_cycle_contracts(nodes: int, mobility: Callable[[np.ndarray], Pair]) -> None:
    """Whatever the grid, and the mobilities of the two directions."""
    grid, c = rolling_on(nodes)
    e = np.random.default_rng(1).standard_normal(c.free.shape) * c.free
    elastic = multigrid.deformation_operators(grid, CIRCLE.compliance, "float64")
    assert float(contraction(elastic, c._replace(eps=mobility(c.eps.x)), e)) < 0.8


def test_a_uniform_change_has_no_slope() -> None:
    """What the bands of a line leave out must not make a drift of a uniform mass."""
    (elastic,) = multigrid.deformation_operators(Grid(5, 5, 0.1), CIRCLE.compliance, "float64")[:1]
    one = np.ones((5, 5))

    @jax.jit
    def smoother_and_balance(c: Coefficients) -> tuple[LineSmoother, jax.Array]:
        smoother = line_smoother(elastic, c, 0.0, 1.0)
        return smoother, smoother.balance(jnp.ones((5, 5)))

    smoother, balance = smoother_and_balance(Coefficients(Pair(0 * one), 0 * one, one, one))
    assert smoother.factors.rest is None  # the matrix as it is
    factors = jax.tree.map(np.asarray, smoother.factors)
    row_sums = (1.0 + sum(factors.rows)) / factors.scale  # rows were scaled to a diagonal of one
    assert float(row_sums[2, 2]) == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(balance, 0.0, atol=1e-12)


# -- the systems of the lines ------------------------------------------------------------------------------------------

Bands = tuple[np.ndarray, np.ndarray, np.ndarray]  # lower, diagonal, upper


@jax.jit
def solved(bands: Bands, b: jax.Array) -> jax.Array:
    return solve_lines(factorise(*bands), b)


def dominant(seed: int, lines: int, n: int) -> Bands:
    """Random matrices whose diagonal outweighs the rest of its row."""
    rng = np.random.default_rng(seed)
    lower, upper = rng.uniform(-1, 1, (2, lines, n))
    diagonal = rng.choice([-1, 1], (lines, n)) * (np.abs(lower) + np.abs(upper) + rng.uniform(0.1, 1, (lines, n)))
    return lower, diagonal, upper


def reference(bands: Bands, b: np.ndarray) -> np.ndarray:
    rows = []
    for lower, diagonal, upper, right in zip(*(np.asarray(band) for band in bands), b, strict=True):
        banded = np.stack([np.r_[0.0, upper[:-1]], diagonal, np.r_[lower[1:], 0.0]])
        rows.append(solve_banded((1, 1), banded, right))
    return np.array(rows)


LENGTHS = 2, 3, SHORT, SHORT + 1, 2 * SHORT, 2 * SHORT + 1, 129, 257, 300  # each is compiled


@pytest.mark.parametrize("n", [*LENGTHS, *(pytest.param(n, marks=pytest.mark.slow) for n in range(4, 300, 7))])
def test_lines_of_many_lengths_are_solved(n: int) -> None:
    for seed in range(4):
        bands, b = dominant(seed, 3, n), np.random.default_rng(seed).standard_normal((3, n))
        np.testing.assert_allclose(np.asarray(solved(bands, b)), reference(bands, b), rtol=1e-9, atol=1e-9)


def test_lines_of_the_grids_are_halved_until_they_are_short() -> None:
    factors = jax.jit(factorise)(*dominant(1, 2, 513))
    halved = []
    while factors.rest is not None:
        halved.append(factors.odd.lower.shape[1])
        factors = factors.rest
    assert halved == [256, 128, 64, 32] and factors.rows.lower.shape[1] == SHORT


@pytest.mark.parametrize("size", [1e-30, 1e30])
def test_single_precision_is_kept_whatever_the_size(size: float) -> None:
    """Diagonals that differ by twelve orders, as diffusion inside and outside a contact does."""
    bands = dominant(3, 4, 129)
    rows = 10.0 ** np.random.default_rng(4).uniform(-6, 6, (4, 129))
    b = np.random.default_rng(5).standard_normal((4, 129)) * rows
    single = tuple((band * rows).astype("float32") for band in bands)
    x = solved(single, (b * size).astype("float32"))
    assert x.dtype == jnp.float32
    expected = reference(bands, b / rows)
    np.testing.assert_allclose(np.asarray(x, float) / size, expected, atol=2e-5 * np.abs(expected).max())
