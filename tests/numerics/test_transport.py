"""Fields carried along X: exact cases, direction, ends, and what a wave loses."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from ertel.numerics import transport
from ertel.numerics.transport import POINTS

carried = jax.jit(transport.carried)

NODES = np.arange(65.0)
MIDDLE = slice(24, 41)  # far enough from the ends


@given(st.integers(-20, 20), st.integers(0, 10**6))
def test_a_shift_by_whole_nodes_is_exact(shift: int, seed: int) -> None:
    field = np.random.default_rng(seed).random((3, 65))
    moved = np.asarray(carried(jnp.asarray(field), float(shift)))
    assert_array_equal(moved, field[:, np.clip(np.arange(65) - shift, 0, 64)])


@given(st.floats(-15.0, 15.0))
def test_polynomials_are_carried_exactly(shift: float) -> None:
    def polynomial(x: np.ndarray) -> np.ndarray:
        t = (x - 32) / 16
        return 1 + t - 2 * t**3 + t ** (POINTS - 1)

    moved = np.asarray(carried(jnp.asarray(polynomial(NODES))[None], shift))[0]
    assert_allclose(moved[MIDDLE], polynomial(NODES - shift)[MIDDLE], atol=1e-11)


@given(st.floats(-9.0, 9.0), st.integers(0, 10**6))
def test_both_directions_are_treated_alike(shift: float, seed: int) -> None:
    field = jnp.asarray(np.random.default_rng(seed).random((2, 65)))
    assert_allclose(carried(field[:, ::-1], -shift)[:, ::-1], carried(field, shift), atol=1e-13)


def test_beyond_its_ends_the_field_keeps_the_value_of_the_end() -> None:
    field = jnp.asarray(np.linspace(2.0, 3.0, 65))[None]
    assert_allclose(carried(field, 100.0), 2.0)
    assert_allclose(carried(field, -100.0), 3.0)


@given(st.floats(0.0, 1.0), st.floats(0.0, np.pi))
def test_no_wave_grows(shift: float, per_node: float) -> None:
    """So that no number of steps makes it unstable."""
    wave = np.stack([np.cos(per_node * NODES), np.sin(per_node * NODES)])
    found = np.asarray(carried(jnp.asarray(wave), shift))[:, MIDDLE]
    assert np.hypot(*found).max() <= 1 + 1e-12


@pytest.mark.parametrize("step", [0.1, 0.3, 0.5, 0.8])
def test_a_wave_of_eight_nodes_loses_less_than_half_a_percent_per_wavelength(step: float) -> None:
    wave = np.stack([np.cos(np.pi / 4 * NODES), np.sin(np.pi / 4 * NODES)])
    kept = np.hypot(*np.asarray(carried(jnp.asarray(wave), step))[:, MIDDLE]).mean()
    assert 1 - kept ** (8 / step) < 0.005
