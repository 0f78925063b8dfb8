"""Blocks of points: the same values as all points at once."""

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.testing import assert_array_equal

from ertel.numerics.blocks import BLOCK, in_blocks

SHAPE = (3, BLOCK - 50)  # no whole number of blocks


def turned(number: Array, vector: Array) -> dict[str, Array]:
    return {"vector": vector[::-1] * number, "number": number + vector[0], "steps": jnp.full(number.shape, 1)}


def test_blocks_give_what_all_points_give() -> None:
    draw = np.random.default_rng(0)
    fields = jnp.asarray(draw.normal(size=SHAPE)), jnp.asarray(draw.normal(size=(2, *SHAPE)))
    found, expected = jax.jit(lambda *fields: in_blocks(turned, SHAPE, *fields))(*fields), turned(*fields)
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        assert_array_equal(found[name], values)


def test_an_iteration_ends_where_its_block_has_converged() -> None:
    def halvings(number: Array) -> Array:
        _, count = jax.lax.while_loop(
            lambda state: jnp.max(state[0]) > 1.0, lambda state: (state[0] / 2.0, state[1] + 1), (number, 0)
        )
        return jnp.full(number.shape, count)

    number = jnp.ones(2 * BLOCK).at[-1].set(8.0)
    found = in_blocks(halvings, number.shape, number)
    expected = np.repeat([0, 3] if jax.default_backend() == "cpu" else [3, 3], BLOCK)
    assert_array_equal(found, expected)
