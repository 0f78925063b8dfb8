"""Gauss-Lobatto points across a film, from -1/2 to 1/2 with both ends, and what is done with values there.

Values at n points stand for the polynomial of degree n - 1 through them.  Integrals are exact up to degree 2 n - 3, so
that those of products of derivatives are, too.  All arrays have the points as their first axis, followed by two axes of
the grid.
"""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.tree_util import register_dataclass
from numpy.polynomial import legendre
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@register_dataclass
@dataclass(frozen=True)
class Lobatto:
    """n points and their matrices.

    z, weights: shape (n, 1, 1).  stiffness: the integrals of the products of two derivatives, (n, n); its rows have the
    sum zero.  cumulative: the integrals from -1/2 to each point, (n, n), the last row being the weights.
    """

    z: Array
    weights: Array
    stiffness: Array
    cumulative: Array

    @classmethod
    def of(cls, points: int) -> "Lobatto":
        """The points by their number, at least 3.

        Examples
        --------
        >>> from ertel.numerics.programs import double_precision
        >>> with double_precision():
        ...     print(Lobatto.of(3).weights.ravel() * 6)
        [1. 4. 1.]
        """
        top = np.eye(points)[-1]  # the Legendre polynomial of degree n - 1
        x = np.concatenate([[-1.0], np.sort(legendre.legroots(legendre.legder(top)).real), [1.0]])
        x = (x - x[::-1]) / 2  # symmetric to the last bit, so that a point in the middle is at 0
        weights = 2.0 / (points * (points - 1) * legendre.legval(x, top) ** 2)
        of_values = np.linalg.inv(legendre.legvander(x, points - 1))  # Legendre coefficients
        slopes = np.stack([legendre.legval(x, legendre.legder(column)) for column in of_values.T], axis=1)
        integrals = np.stack([legendre.legval(x, legendre.legint(column, lbnd=-1)) for column in of_values.T], axis=1)
        stiffness = 2.0 * slopes.T @ (weights[:, None] * slopes)
        column = (points, 1, 1)
        return cls(*jax.device_put((x.reshape(column) / 2, weights.reshape(column) / 2, stiffness, integrals / 2)))

    def integral(self, f: Array) -> Array:
        """The integral across the film."""
        return jnp.sum(self.weights * f, axis=0)

    def from_below(self, f: Array) -> Array:
        """The integral from the lower end to each point."""
        return jnp.tensordot(self.cumulative, f, 1)

    def stiff(self, f: Array) -> Array:
        """The stiffness times the values: minus the weighted second derivative, plus the slopes at the ends."""
        return jnp.tensordot(self.stiffness, f, 1)
