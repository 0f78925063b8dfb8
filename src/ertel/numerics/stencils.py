"""Finite differences on a node-centred grid of square cells: diffusion, upstream slope, edge values.

Arrays have the shape of the grid, index [Y, X].  `even` says about which axes only one side is stored (`symmetry`).
"""

from functools import partial
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, tree

from ertel.numerics.grid import WHOLE, Even
from ertel.numerics.symmetry import extended


class Pair(NamedTuple):
    """A coefficient along X and along Y; `other` is None if both are the same array, to save work."""

    x: Array
    other: Array | None = None

    @classmethod
    def of(cls, x: Array, y: Array) -> "Pair":
        """The pair of two arrays."""
        return cls(x, None if y is x else y)

    @property
    def y(self) -> Array:
        """The coefficient along Y."""
        return self.x if self.other is None else self.other


def diffusion(eps: Pair, f: Array, even: Even = WHOLE) -> Array:
    """d/dX(eps_x df/dX) + d/dY(eps_y df/dY) on unit spacing, conservative, second order.

    eps is averaged at the faces between nodes; f is zero beyond the edge.  The result has no meaning on the edge nodes.
    """
    c, p = _beyond(eps, even), extended(f, even)
    in_X = 0.5 * (c.x[1:-1, 1:] + c.x[1:-1, :-1]) * (p[1:-1, 1:] - p[1:-1, :-1])
    in_Y = 0.5 * (c.y[1:, 1:-1] + c.y[:-1, 1:-1]) * (p[1:, 1:-1] - p[:-1, 1:-1])
    # summed in pairs, here and elsewhere, so that swapping X and Y gives the same result to the last bit
    total: Array = (in_X[:, 1:] - in_X[:, :-1]) + (in_Y[1:, :] - in_Y[:-1, :])
    return total


def to_x_faces(f: Array) -> Array:
    """The mean of two neighbours along X; f has one more node on every side (`symmetry.extended`)."""
    return 0.5 * (f[1:-1, 1:] + f[1:-1, :-1])


def to_y_faces(f: Array) -> Array:
    """The mean of two neighbours along Y; f has one more node on every side."""
    return 0.5 * (f[1:, 1:-1] + f[:-1, 1:-1])


def central_slopes(f: Array, spacing: Array | float) -> tuple[Array, Array]:
    """df/dX and df/dY by central differences, zero where a neighbour is missing; shape of f."""
    along_x, along_y = f[:, 2:] - f[:, :-2], f[2:] - f[:-2]
    twice = 2.0 * spacing
    return jnp.pad(along_x, ((0, 0), (1, 1))) / twice, jnp.pad(along_y, ((1, 1), (0, 0))) / twice


def face_sum(eps: Pair, even: Even = WHOLE) -> Array:
    """Sum of the coefficient over the four faces of each cell: the diagonal of - `diffusion`."""
    c = _beyond(eps, even)
    along_y, along_x = c.y[:-2, 1:-1] + c.y[2:, 1:-1], c.x[1:-1, :-2] + c.x[1:-1, 2:]
    total: Array = (eps.x + eps.y) + 0.5 * (along_y + along_x)
    return total


def curvature(c: Pair, f: Array, even: Even = WHOLE) -> Array:
    """c_x d2f/dX2 + c_y d2f/dY2 on unit spacing; f is zero beyond the edge."""
    p = extended(f, even)
    along_x, along_y = p[1:-1, :-2] + p[1:-1, 2:], p[:-2, 1:-1] + p[2:, 1:-1]
    total: Array = c.x * (along_x - 2.0 * f) + c.y * (along_y - 2.0 * f)
    return total


def largest_around(f: Array, even: Even = WHOLE) -> Array:
    """The largest of a node's value and those of the eight nodes around it."""
    p = extended(f, even, "edge")
    rows = jnp.maximum(jnp.maximum(p[:, :-2], p[:, 1:-1]), p[:, 2:])
    return jnp.maximum(jnp.maximum(rows[:-2], rows[1:-1]), rows[2:])


def _beyond(eps: Pair, even: Even) -> Pair:
    """The coefficient with one more node on every side."""
    found: Pair = tree.map(partial(extended, even=even, beyond="edge"), eps)
    return found


def upstream_slope(f: Array, spacing: Array | float) -> Array:
    """df/dX from the two nodes upstream, second order (first order next to the edge, zero on it)."""
    first = f[:, 1:] - f[:, :-1]
    second = 1.5 * first[:, 1:] - 0.5 * first[:, :-1]
    return jnp.concatenate([jnp.zeros_like(f[:, :1]), first[:, :1], second], axis=1) / spacing


def edged(values: Array, edge: Array, even: Even = WHOLE) -> Array:
    """The values inside, and `edge` on the edge, where alone it is not zero."""
    return inside(values, even) + edge


def inside(values: Array, even: Even = WHOLE) -> Array:
    """The values with the edge set to zero; an axis of symmetry is not an edge."""
    low_y, low_x = (0 if mirror else 1 for mirror in even)
    return jnp.pad(values[low_y:-1, low_x:-1], ((low_y, 1), (low_x, 1)))
