import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_banded

from ertel.numerics import tridiagonal
from ertel.numerics.tridiagonal import SHORT

Bands = tuple[jax.Array, jax.Array, jax.Array]  # lower, diagonal, upper


@jax.jit
def solved(bands: Bands, b: jax.Array) -> jax.Array:
    return tridiagonal.solve_lines(tridiagonal.factorise(*bands), b)


def dominant(seed: int, lines: int, n: int) -> Bands:
    """Random matrices whose diagonal outweighs the rest of its row."""
    rng = np.random.default_rng(seed)
    lower, upper = rng.uniform(-1, 1, (2, lines, n))
    diagonal = rng.choice([-1, 1], (lines, n)) * (np.abs(lower) + np.abs(upper) + rng.uniform(0.1, 1, (lines, n)))
    return jnp.asarray(lower), jnp.asarray(diagonal), jnp.asarray(upper)


def reference(bands: Bands, b: np.ndarray) -> np.ndarray:
    rows = []
    for lower, diagonal, upper, right in zip(*(np.asarray(band) for band in bands), b, strict=True):
        banded = np.stack([np.r_[0.0, upper[:-1]], diagonal, np.r_[lower[1:], 0.0]])
        rows.append(solve_banded((1, 1), banded, right))
    return np.array(rows)


@settings(max_examples=12, deadline=None)  # each length is compiled
@given(st.integers(0, 10**6), st.integers(2, 300))
def test_lines_of_any_length_are_solved(seed: int, n: int) -> None:
    bands, b = dominant(seed, 3, n), np.random.default_rng(seed).standard_normal((3, n))
    x = solved(bands, jnp.asarray(b))
    np.testing.assert_allclose(np.asarray(x), reference(bands, b), rtol=1e-9, atol=1e-9)


def test_lines_of_the_grids_are_halved_until_they_are_short() -> None:
    factors = tridiagonal.factorise(*dominant(1, 2, 513))
    assert [h.odd.lower.shape[1] for h in factors.halvings] == [256, 128, 64, 32]
    assert factors.rest.lower.shape[1] == SHORT


@pytest.mark.parametrize("size", [1e-30, 1e30])
def test_single_precision_is_kept_whatever_the_size(size: float) -> None:
    """Diagonals that differ by twelve orders, as diffusion inside and outside a contact does."""
    bands = dominant(3, 4, 129)
    rows = 10.0 ** np.random.default_rng(4).uniform(-6, 6, (4, 129))
    b = np.random.default_rng(5).standard_normal((4, 129)) * rows
    single = tuple(jnp.asarray(band * rows, "float32") for band in bands)
    x = solved(single, jnp.asarray(b * size, "float32"))
    assert x.dtype == jnp.float32
    expected = reference(bands, b / rows)
    np.testing.assert_allclose(np.asarray(x, float) / size, expected, atol=2e-5 * np.abs(expected).max())
