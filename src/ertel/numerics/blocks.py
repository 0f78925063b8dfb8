"""Functions that treat all points alike, computed for a few points at a time."""

from collections.abc import Callable
from math import prod
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

BLOCK = 256  # points; 128 to 512 are equally fast, all at once takes twice the time


def in_blocks(function: Callable[..., Any], shape: tuple[int, ...], *fields: Any) -> Any:
    """What a function gives that treats all points alike, computed for `BLOCK` points at a time on a CPU.

    Many arrays for each point then stay in the cache, and an iteration ends where its block has converged.  shape: of
    the points, the last axes of every array in the fields and in what the function gives.
    """
    points = prod(shape)
    if points <= BLOCK or jax.default_backend() != "cpu":
        return function(*fields)
    filled = -points % BLOCK

    def split(field: Array) -> Array:
        lead = field.shape[: field.ndim - len(shape)]
        line = jnp.pad(field.reshape(*lead, points), [*[(0, 0)] * len(lead), (0, filled)], mode="edge")
        return jnp.moveaxis(line.reshape(*lead, -1, BLOCK), -2, 0)

    def joined(blocks: Array) -> Array:
        lead = blocks.shape[1:-1]
        return jnp.moveaxis(blocks, 0, -2).reshape(*lead, -1)[..., :points].reshape(*lead, *shape)

    return jax.tree.map(joined, jax.lax.map(lambda block: function(*block), jax.tree.map(split, fields)))
