import itertools

import jax.numpy as jnp
import numpy as np
import pytest
from made_up import even_fields, every_symmetry
from numpy.typing import NDArray
from scipy.integrate import dblquad

from ertel.numerics import halfspace
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.stencils import folded, unfolded
from ertel.physics import hertz
from ertel.physics.geometry import CIRCLE


def direct_sum(K: NDArray[np.float64], P: NDArray[np.float64]) -> NDArray[np.float64]:
    """The slow plain twin of the FFT."""
    i, j = (np.arange(n) for n in P.shape)
    result = np.empty_like(P)
    for y in i:
        for x in j:
            result[y, x] = np.sum(K[np.ix_(abs(i - y), abs(j - x))] * P)
    return result


def displaced(grid: Grid, P: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(halfspace.kernel(grid, CIRCLE.compliance).displacement(jnp.asarray(P)))


@every_symmetry
@pytest.mark.parametrize(("nodes_x", "nodes_y"), [(33, 9), (17, 25)])
@pytest.mark.parametrize(("dtype", "error"), [("float64", 1e-12), ("float32", 1e-5)])
def test_fft_equals_the_direct_sum(
    even: Symmetry, nodes_x: int, nodes_y: int, dtype: str, error: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    grid, P = Grid(nodes_x, nodes_y, 0.2, even=even), np.pad(even_fields(even, nodes_y - 2, nodes_x - 2), 1)
    expected = CIRCLE.compliance * direct_sum(halfspace.love_coefficients(nodes_y, nodes_x, grid.spacing), P)
    kept = jnp.asarray(folded(P, even), dtype)
    assert kept.shape == grid.shape
    found = _kernel_below(0, grid, dtype, monkeypatch).displacement(kept)
    assert found.dtype == dtype
    np.testing.assert_allclose(unfolded(found, even), expected, rtol=error)


@every_symmetry
@pytest.mark.parametrize(("nodes_x", "nodes_y"), [(65, 17), (65, 1)])
@pytest.mark.parametrize(("dtype", "error"), [("float64", 3e-15), ("float32", 2e-6)])
def test_products_equal_transforms_to_round_off(
    even: Symmetry, nodes_x: int, nodes_y: int, dtype: str, error: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also of a complex field, and by waves that alternate from node to node."""
    even = even._replace(y=False) if nodes_y == 1 else even
    grid, P = Grid(nodes_x, nodes_y, 0.2, even=even), even_fields(even, 2, max(nodes_y - 2, 1), nodes_x - 2) - 0.5
    P = np.pad(P, ((0, 0), (int(nodes_y > 1),) * 2, (1, 1)))
    kept = jnp.asarray(folded(P[0], even), dtype) + 1j * jnp.asarray(folded(P[1], even), dtype)
    transforms, products = (_kernel_below(most, grid, dtype, monkeypatch) for most in (0, 1025))
    expected, found = transforms.displacement(kept), products.displacement(kept)
    assert found.dtype == expected.dtype == jnp.result_type(dtype, "complex64")
    np.testing.assert_allclose(found, expected, rtol=0, atol=error * np.abs(expected).max())
    np.testing.assert_array_equal(products.alternating(), transforms.alternating())


def test_the_spectra_of_a_grid_and_its_coarser_ones_are_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also of 4097²; one too few to be kept, and a steady film computes all of them again and again."""
    grids = [Grid.square(nodes, 1.0) for nodes in range(9, 9 + 2 * len(Grid.square(4097, 1.0).hierarchy()), 2)]
    asked, coefficients = [], halfspace.love_coefficients
    monkeypatch.setattr(halfspace, "love_coefficients", lambda *a: asked.append(a) or coefficients(*a))
    halfspace._unit_spectrum.cache_clear()
    for grid in [*grids, *grids]:
        halfspace.kernel(grid)
    assert len(asked) == len(grids)


def _kernel_below(most: int, grid: Grid, dtype: str, monkeypatch: pytest.MonkeyPatch) -> halfspace.Kernel:
    """With products on grids of so many nodes a side."""
    monkeypatch.setattr(halfspace, "PRODUCTS", {"cpu": most})
    kernel = halfspace.kernel(grid, CIRCLE.compliance, dtype)
    assert isinstance(kernel, halfspace.ProductKernel if most else halfspace.TransformKernel)
    return kernel


@pytest.mark.parametrize(("i", "j"), [(0, 1), (1, 1), (3, 2), (0, 7)])
def test_a_coefficient_is_the_integral_over_its_cell(i: int, j: int) -> None:
    h = 0.25
    integral, _ = dblquad(
        lambda y, x: 1 / np.hypot(x, y), (j - 0.5) * h, (j + 0.5) * h, (i - 0.5) * h, (i + 0.5) * h, epsabs=1e-13
    )
    K = halfspace.love_coefficients(8, 8, h)
    assert K[i, j] == pytest.approx(integral, rel=1e-10)


def test_own_cell_and_far_cells_in_closed_form() -> None:
    K = halfspace.love_coefficients(1000, 1000, 0.01)
    assert K[0, 0] == pytest.approx(0.01 * 4 * np.arcsinh(1.0), rel=1e-14)
    # seen from far away a cell is a point, and its first correction h^2/(24 r^3) is known
    far = 0.01 * (1 / 999 + 1 / (24 * 999**3))
    assert K[0, 999] == pytest.approx(far, rel=1e-11)
    assert K[999, 0] == pytest.approx(far, rel=1e-11)


@pytest.mark.parametrize("seed", range(4))
def test_the_operator_is_symmetric_and_positive(seed: int) -> None:
    grid = Grid.square(33, 2.0)
    P, Q = np.pad(np.random.default_rng(seed).random((2, 31, 31)) - 0.5, ((0, 0), (1, 1), (1, 1)))
    assert np.sum(Q * displaced(grid, P)) == pytest.approx(np.sum(P * displaced(grid, Q)), rel=1e-11)
    assert np.sum(P * displaced(grid, P)) > 0


def hertz_errors(samples: int) -> tuple[float, float]:
    """Root mean square error inside the contact on the finest grid, and its order.

    Each cell gets the mean of samples x samples values of Hertz' pressure in it.
    """
    errors, spacings = [], []
    for nodes in (65, 129, 257, 513):
        grid = Grid.square(nodes, 1.5)
        offset = ((np.arange(samples) + 0.5) / samples - 0.5) * grid.spacing
        x = (grid.x[:, None] + offset).ravel()
        P = hertz.pressure(np.hypot(x[None, :], x[:, None]))
        P = P.reshape(nodes, samples, nodes, samples).mean(axis=(1, 3))
        r = np.hypot(grid.x[None, :], grid.y[:, None])
        error = displaced(grid, P) - hertz.displacement(r)
        errors.append(np.sqrt(np.mean(error[r < 0.9] ** 2)))
        spacings.append(grid.spacing)
    return errors[-1], float(np.polyfit(np.log(spacings), np.log(errors), 1)[0])


@pytest.mark.parametrize(("samples", "largest", "order"), [(8, 1e-5, 2.05), (1, 1e-3, 1.5)])
def test_hertz_pressure_gives_hertz_displacement(samples: int, largest: float, order: float) -> None:
    """P = sqrt(1 - r^2) makes H = 0 inside with Delta = 1; with cell means the error falls with h^2.

    Taken at the nodes, the square root at r = 1 leaves h^1.5: a property of Hertz' pressure, not of the operator.
    """
    error, found = hertz_errors(samples)
    assert error < largest
    assert found == pytest.approx(order, abs=0.2)


def test_a_smooth_pressure_is_second_order_everywhere() -> None:
    values = []
    for nodes in (33, 65, 129, 257):
        grid = Grid.square(nodes, 2.0)
        r2 = grid.x[None, :] ** 2 + grid.y[:, None] ** 2
        u = displaced(grid, np.exp(-3 * r2))
        values.append(u[:: (nodes - 1) // 32, :: (nodes - 1) // 32])
    differences = [np.abs(b - a).max() for a, b in itertools.pairwise(values)]
    orders = np.log2(np.divide(differences[:-1], differences[1:]))
    assert orders[0] < orders[1] < 2.05
    assert orders[1] > 1.9
