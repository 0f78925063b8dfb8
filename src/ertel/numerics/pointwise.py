"""Vectors and tensors of two dimensions at every node of a field.

A vector has the shape (2, ...): along X and along Y.  A symmetric tensor is a tuple of its components xx, xy, yy; a
matrix of xx, xy, yx, yy.
"""

import jax.numpy as jnp
from jax import Array

Tensor = tuple[Array, Array, Array]
Matrix = tuple[Array, Array, Array, Array]
TINY = 1e-150  # length of a vector that stands for zero


def dot(a: Array, b: Array) -> Array:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1]


def square(a: Array) -> Array:
    """The square of the length."""
    return dot(a, a)


def length(a: Array) -> Array:
    """The length, at least `TINY`, so that it can divide."""
    return jnp.sqrt(jnp.maximum(square(a), TINY**2))


def times(tensor: Tensor, a: Array) -> Array:
    """The product of a symmetric tensor and a vector."""
    xx, xy, yy = tensor
    return jnp.stack([xx * a[0] + xy * a[1], xy * a[0] + yy * a[1]])


def divided(tensor: Tensor, a: Array) -> Array:
    """The vector whose product with the symmetric tensor is a."""
    xx, xy, yy = tensor
    determinant = xx * yy - xy**2
    return jnp.stack([yy * a[0] - xy * a[1], xx * a[1] - xy * a[0]]) / determinant


def product(matrix: Matrix, a: Array) -> Array:
    """The product of a matrix and a vector."""
    xx, xy, yx, yy = matrix
    return jnp.stack([xx * a[0] + xy * a[1], yx * a[0] + yy * a[1]])


def transposed(matrix: Matrix) -> Matrix:
    """The transpose."""
    return matrix[0], matrix[2], matrix[1], matrix[3]
