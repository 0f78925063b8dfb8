"""The flow of the film, with the arrays of NumPy and of JAX."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from ertel.physics.rheology import Newtonian


def test_newtonian_flow_is_the_cube_of_the_film_and_stops_where_surfaces_overlap() -> None:
    H = np.array([-0.1, 0.0, 0.5, 2.0])
    along_x, along_y = Newtonian().mobility(np.full(4, 1.2), np.full(4, 3.0), H, 0.25)
    assert along_x is along_y
    np.testing.assert_allclose(along_x, [0.0, 0.0, 1.2 * 0.125 / 0.75, 1.2 * 8 / 0.75])


def test_the_law_goes_through_the_transformations_of_jax() -> None:
    def mobility(H: jax.Array) -> jax.Array:
        along_x, along_y = Newtonian().mobility(1.0, 1.0, H, 0.5)
        assert along_x is along_y
        return along_x

    value, change = jax.jvp(jax.jit(mobility), (jnp.asarray([0.3, -1.0]),), (jnp.ones(2),))
    assert np.asarray(value) == pytest.approx([2 * 0.3**3, 0.0])
    assert np.asarray(change) == pytest.approx([6 * 0.3**2, 0.0])
