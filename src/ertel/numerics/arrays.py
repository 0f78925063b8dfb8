"""Arrays: double precision, functions computed in blocks, and vectors and tensors at every node of a field.

JAX computes in single precision unless it is told otherwise, and that setting belongs to the user.  So every public
function that computes does it in JAX's own block for double precision, which holds for one thread::

    @double_precision()
    def simulate(case): ...
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, lax

BLOCK = 256  # points; 128 to 512 are equally fast, all at once takes twice the time
Tensor = tuple[Array, Array, Array]
Matrix = tuple[Array, Array, Array, Array]
TINY = 1e-150  # length of a vector that stands for zero

# JAX before 0.8 has it elsewhere
_enable_x64: Any = jax.enable_x64 if hasattr(jax, "enable_x64") else import_module("jax.experimental").enable_x64


@contextmanager
def double_precision() -> Iterator[None]:
    """Let JAX compute in double precision in this block, and in this thread only; also a decorator."""
    with _enable_x64(True):
        yield


def require_double() -> None:
    """Raise RuntimeError where JAX would silently round to single precision."""
    if jnp.result_type(float) != jnp.float64:
        raise RuntimeError(
            "JAX computes in single precision here, and ertel needs double: call this in a block "
            "`with ertel.numerics.arrays.double_precision():`, or set JAX_ENABLE_X64=1"
        )


# -- points that are all treated alike --------------------------------------------------------------------------------


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


# -- vectors, of shape (2, ...): along X and along Y; symmetric tensors, a tuple of xx, xy, yy; matrices xx, xy, yx, yy


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
