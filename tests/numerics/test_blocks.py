"""Blocks of points: the same values as all points at once."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array
from numpy.testing import assert_array_equal

from ertel.numerics.programs import BLOCK, in_blocks

SHAPE = (3, BLOCK - 50)  # no whole number of blocks


def turned(number: Array, vector: Array) -> dict[str, Array]:
    return {"vector": vector[::-1] * number, "number": number + vector[0], "steps": jnp.full(number.shape, 1)}


@pytest.mark.parametrize("share", [0.0, 0.1, 0.7, 1.0])
def test_blocks_give_what_all_points_give(share: float) -> None:
    """At the points chosen, and what is given at the others; forward and in several directions at once."""
    draw = np.random.default_rng(0)
    fields = jnp.asarray(draw.normal(size=SHAPE)), jnp.asarray(draw.normal(size=(2, *SHAPE)))
    changes = jnp.asarray(draw.normal(size=(2, *SHAPE))), jnp.asarray(draw.normal(size=(2, 2, *SHAPE)))
    chosen = jnp.asarray(draw.uniform(size=SHAPE) < share)

    def others(number: Array, vector: Array) -> dict[str, Array]:
        return {"vector": 2.0 * vector, "number": number, "steps": jnp.zeros(SHAPE, int)}

    def in_parts(*fields: Array) -> dict[str, Array]:
        return in_blocks(turned, chosen, others(*fields), *fields)

    def at_once(*fields: Array) -> dict[str, Array]:
        return jax.tree.map(partial(jnp.where, chosen), turned(*fields), others(*fields))

    for of in (lambda f: f(*fields), lambda f: jax.vmap(lambda *change: jax.jvp(f, fields, change)[1])(*changes)):
        found, expected = jax.jit(lambda of=of: of(in_parts))(), of(at_once)
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
    found = in_blocks(halvings, number > 0.0, jnp.zeros(number.shape, int), number)
    expected = np.repeat([0, 3] if jax.default_backend() == "cpu" else [3, 3], BLOCK)
    assert_array_equal(found, expected)
