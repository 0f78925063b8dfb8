"""Fields that are even about Y = 0 or X = 0.  Only one side is stored; the axis is the first row or column.

A smooth impact needs a quarter of the plane, rolling needs a half.
"""

from functools import partial

import jax
import jax.numpy as jnp
from jax import Array

from ertel.numerics.grid import Even


@partial(jax.jit, static_argnames=("even", "beyond"))  # one tracing for each shape
def extended(field: Array, even: Even, beyond: str = "constant") -> Array:
    """The field with one more node on every side: the mirror image across an axis, elsewhere zero or "edge"."""
    p = jnp.pad(field, 1, mode=beyond)
    if even.y:
        p = p.at[0].set(p[2])
    return p.at[:, 0].set(p[:, 2]) if even.x else p


def unfolded(field: Array, even: Even, odd: bool = False) -> Array:
    """The field on the whole plane, by NumPy or JAX as the field is an array of.

    odd: whether it changes its sign at the axis Y = 0.
    """
    xp = field.__array_namespace__()
    if even.y:
        field = xp.concatenate([-field[:0:-1] if odd else field[:0:-1], field])
    return xp.concatenate([field[:, :0:-1], field], axis=1) if even.x else field


def folded(field: Array, even: Even) -> Array:
    """The stored part of a field on the whole plane."""
    rows, columns = field.shape
    return field[rows // 2 if even.y else 0 :, columns // 2 if even.x else 0 :]


def total(field: Array, even: Even) -> Array:
    """The sum over the whole plane."""
    rows = 2.0 * jnp.sum(field, axis=0) - field[0] if even.y else jnp.sum(field, axis=0)
    return 2.0 * jnp.sum(rows) - rows[0] if even.x else jnp.sum(rows)
