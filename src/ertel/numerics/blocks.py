"""Functions that treat all points alike, computed for a few points at a time."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, lax

BLOCK = 256  # points; 128 to 512 are equally fast, all at once takes twice the time


def in_blocks(function: Callable[..., Any], chosen: Array, others: Any, *fields: Any) -> Any:
    """At the points chosen what a function gives that treats all points alike, elsewhere what `others` has.

    On a CPU the points chosen are gathered and computed `BLOCK` at a time: many arrays for each point then stay in the
    cache, an iteration ends where its block has converged, and the other points cost nothing.  chosen: bool, of the
    shape of the points, the last axes of every array in the fields, in `others` and in what the function gives.
    """

    def where(values: Array, other: Array) -> Array:
        return jnp.where(chosen, values, other)

    points = chosen.size
    if points <= BLOCK or jax.default_backend() != "cpu":
        return jax.tree.map(where, function(*fields), others)
    blocks = -(-points // BLOCK)
    places = jnp.nonzero(chosen.ravel(), size=blocks * BLOCK, fill_value=0)[0].reshape(blocks, BLOCK)
    count = jnp.cumsum(chosen.ravel())
    fields = jax.tree.map(_in_line(chosen.ndim), fields)

    def block(number: Array) -> Any:
        own = [jax.tree.map(lambda field: field[..., places[number]], field) for field in fields]
        nothing = jax.tree.map(lambda part: jnp.zeros(part.shape, part.dtype), jax.eval_shape(function, *own))
        return lax.cond(number * BLOCK < count[-1], lambda: function(*own), lambda: nothing)

    def back(found: Array, other: Array) -> Array:
        line = jnp.moveaxis(found, 0, -2).reshape(*found.shape[1:-1], -1)
        return where(line[..., jnp.maximum(count - 1, 0)].reshape(other.shape), other)

    return jax.tree.map(back, lax.map(block, jnp.arange(blocks)), others)


def _in_line(axes: int) -> Callable[[Array], Array]:
    """The last axes as one."""
    return lambda field: field.reshape(*field.shape[: field.ndim - axes], -1)
