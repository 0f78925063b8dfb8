"""Fields kept on one side of an axis: the same numbers as on the whole plane."""

import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from ertel import contact, halfspace
from ertel.contact import Rate
from ertel.grid import Grid
from ertel.lubricant import Barus, DowsonHigginson, Lubricant
from ertel.symmetry import WHOLE, Even, extended, folded, total, unfolded

OIL = Lubricant(Barus(5.0), DowsonHigginson(1.0))
every_symmetry = pytest.mark.parametrize("even", [WHOLE, Even(y=True), Even(x=True), Even(True, True)], ids=str)


def grid(even: Even = WHOLE) -> Grid:
    return Grid(17, 0.2, even=even)


def bump(even: Even, seed: int = 0) -> np.ndarray:
    """Random and even, zero on the edge, on the whole plane."""
    field = np.zeros((17, 17))
    field[1:-1, 1:-1] = np.random.default_rng(seed).random((15, 15))
    field = (field + field[::-1]) / 2 if even.y else field
    return (field + field[:, ::-1]) / 2 if even.x else field


@every_symmetry
def test_unfolding_undoes_folding(even) -> None:
    whole = bump(even)
    kept = folded(whole, even)
    assert kept.shape == grid(even).shape
    assert_allclose(unfolded(jnp.asarray(kept), even), whole)


@every_symmetry
def test_the_total_is_that_of_the_whole_plane(even) -> None:
    whole = bump(even)
    assert float(total(jnp.asarray(folded(whole, even)), even)) == pytest.approx(whole.sum(), rel=1e-14)


@every_symmetry
def test_beyond_an_axis_is_the_mirror_image(even) -> None:
    whole = jnp.asarray(bump(even))
    found, expected = extended(jnp.asarray(folded(whole, even)), even), extended(whole, WHOLE)
    rows, columns = found.shape
    assert_allclose(found, expected[-rows:, -columns:])


@every_symmetry
@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_the_deformation_is_that_of_the_whole_plane(even, dtype) -> None:
    whole = bump(even)
    expected = halfspace.displacement(halfspace.spectrum(grid()), jnp.asarray(whole))
    kept = jnp.asarray(folded(whole, even), dtype)
    found = halfspace.displacement(halfspace.spectrum(grid(even), dtype), kept, even)
    assert found.dtype == dtype
    assert_allclose(unfolded(found, even), expected, atol=1e-13 if dtype == "float64" else 1e-5)


@every_symmetry
def test_the_residual_is_that_of_the_whole_plane(even) -> None:
    """Of eq. (1), with the oil carried along where X is whole."""
    whole, U = bump(even), 0.0 if even.x else 1.0
    results = []
    for g in (grid(), grid(even)):
        c = contact.ball_on_plane(g, 0.1, OIL)
        P = jnp.asarray(folded(whole, g.even))
        H = contact.film_thickness(c, P, -0.2)
        r = contact.residual(c, P, H, Rate(3.0, 0.1 * P), U)
        results.append([unfolded(f, g.even) for f in (H, r)] + [contact.load(c, P)])
    for expected, found in zip(*results, strict=True):
        assert_allclose(found, expected, rtol=1e-11, atol=1e-11)


def test_a_symmetric_grid_is_centred() -> None:
    with pytest.raises(ValueError, match="centred"):
        Grid(17, 0.2, centre_x=-1.0, even=Even(x=True))
