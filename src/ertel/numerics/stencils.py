"""Finite differences on a node-centred grid of square cells: diffusion, upstream slope, edge values, shifts along X.

Arrays have the shape of the grid, index [Y, X].  `even` says about which of the axes Y = 0 and X = 0 fields are even.
Only one side is then stored; the axis is the first row or column.  A smooth impact needs a quarter of the plane,
rolling needs a half.  An array of one row is a line contact: nothing changes along Y.  At the end: matrices of three
diagonals, for the nodes along a line.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, tree

from ertel.numerics.bdf import lagrange
from ertel.numerics.grid import NO_SYMMETRY, Symmetry

FloatLike = Array | float  # a number, or an array where it varies
POINTS = 8  # of the interpolation between nodes


class Pair(NamedTuple):
    """A coefficient along X and along Y; `other` is None if both are the same array, to save work."""

    x: Array
    other: Array | None = None

    @property
    def y(self) -> Array:
        """The coefficient along Y."""
        return self.x if self.other is None else self.other


# -- symmetry ---------------------------------------------------------------------------------------------------------


@partial(jax.jit, static_argnames=("even", "beyond"))  # one tracing for each shape
def extended(field: Array, even: Symmetry, beyond: str = "constant") -> Array:
    """The field with one more node on every side: the mirror image across an axis, elsewhere zero or "edge".

    One row is repeated on both sides.
    """
    p = jnp.pad(field, 1, mode=beyond)
    if field.shape[0] == 1:
        p = p.at[::2].set(p[1])
    elif even.y:
        p = p.at[0].set(p[2])
    return p.at[:, 0].set(p[:, 2]) if even.x else p


def continued(field: Array, even: Symmetry) -> Array:
    """The field with one more node on every side: the mirror image across an axis, elsewhere on a parabola.

    The parabola goes through the three nodes next to the edge.  Slopes on the edge are then of second order, whatever
    the field is there.
    """
    p = extended(field, even)
    if field.shape[0] > 1:
        p = p.at[-1].set(_next(p[-2], p[-3], p[-4]))
        p = p if even.y else p.at[0].set(_next(p[1], p[2], p[3]))
    p = p.at[:, -1].set(_next(p[:, -2], p[:, -3], p[:, -4]))
    return p if even.x else p.at[:, 0].set(_next(p[:, 1], p[:, 2], p[:, 3]))


def _next(first: Array, second: Array, third: Array) -> Array:
    """The value beyond the first of three nodes."""
    return 3.0 * (first - second) + third


def unfolded(field: Array, even: Symmetry, odd: bool = False) -> Array:
    """The field on the whole plane, by NumPy or JAX as the field is an array of.

    odd: whether it changes its sign at the axis Y = 0.
    """
    xp = field.__array_namespace__()
    if even.y:
        field = xp.concatenate([-field[:0:-1] if odd else field[:0:-1], field])
    return xp.concatenate([field[:, :0:-1], field], axis=1) if even.x else field


def shown(field: Array, even: Symmetry, odd: bool = False) -> Array:
    """The field on the whole plane as it is shown: one row is a line, of one axis."""
    whole = unfolded(field, even, odd)
    return whole[0] if whole.shape[0] == 1 else whole


def folded(field: Array, even: Symmetry) -> Array:
    """The stored part of a field on the whole plane."""
    rows, columns = field.shape
    return field[rows // 2 if even.y else 0 :, columns // 2 if even.x else 0 :]


def middle(shape: tuple[int, ...], even: Symmetry) -> tuple[slice, ...]:
    """The indices of `Grid.middle` in a field of this shape."""
    before = (0 if mirror else (nodes - 1) // 4 for mirror, nodes in zip(even, shape, strict=True))
    return tuple(slice(first, first + (nodes + 1) // 2) for first, nodes in zip(before, shape, strict=True))


def beyond_middle(field: Any, even: Symmetry) -> Any:
    """The number of stored nodes outside `middle` at which a field is not zero; by NumPy or JAX."""
    return (field != 0.0).sum() - (field[middle(field.shape, even)] != 0.0).sum()


def total(field: Array, even: Symmetry) -> Array:
    """The sum over the whole plane, or over one row."""
    rows = 2.0 * jnp.sum(field, axis=0) - field[0] if even.y else jnp.sum(field, axis=0)
    return 2.0 * jnp.sum(rows) - rows[0] if even.x else jnp.sum(rows)


def integral(field: Array, spacing: FloatLike, even: Symmetry) -> Array:
    """The integral over the whole plane, each node standing for its cell; of one row, along it."""
    return total(field, even) * (spacing if field.shape[0] == 1 else spacing**2)


# -- differences ------------------------------------------------------------------------------------------------------


def diffusion(eps: Pair, f: Array, even: Symmetry = NO_SYMMETRY) -> Array:
    """d/dX(eps_x df/dX) + d/dY(eps_y df/dY) on unit spacing, conservative, second order.

    eps is averaged at the faces between nodes; f is zero beyond the edge.  The result has no meaning on the edge nodes.
    """
    return divergence(*face_fluxes(eps, f, even))


def face_fluxes(eps: Pair, f: Array, even: Symmetry = NO_SYMMETRY) -> tuple[Array, Array]:
    """eps_x df/dX on the faces across X, shape (n, n + 1), and eps_y df/dY on those across Y, shape (n + 1, n)."""
    c, p = _beyond(eps, even), extended(f, even)
    return to_x_faces(c.x) * (p[1:-1, 1:] - p[1:-1, :-1]), to_y_faces(c.y) * (p[1:, 1:-1] - p[:-1, 1:-1])


def divergence(in_X: Array, in_Y: Array) -> Array:
    """The divergence at the nodes, on unit spacing, of what is on the faces around them (`face_fluxes`)."""
    # summed in pairs, here and elsewhere, so that swapping X and Y gives the same result to the last bit
    return (in_X[:, 1:] - in_X[:, :-1]) + (in_Y[1:, :] - in_Y[:-1, :])


def to_x_faces(f: Array) -> Array:
    """The mean of two neighbours along X; f has one more node on every side (`extended`)."""
    return 0.5 * (f[1:-1, 1:] + f[1:-1, :-1])


def to_y_faces(f: Array) -> Array:
    """The mean of two neighbours along Y; f has one more node on every side."""
    return 0.5 * (f[1:, 1:-1] + f[:-1, 1:-1])


def central_slopes(f: Array, spacing: Array | float) -> tuple[Array, Array]:
    """df/dX and df/dY by central differences, zero where a neighbour is missing; shape of f."""
    along_x, along_y = f[:, 2:] - f[:, :-2], f[2:] - f[:-2]
    twice = 2.0 * spacing
    return jnp.pad(along_x, ((0, 0), (1, 1))) / twice, jnp.pad(along_y, ((1, 1), (0, 0))) / twice


def node_slopes(f: Array, spacing: Array | float, even: Symmetry = NO_SYMMETRY) -> Array:
    """grad f at the nodes by central differences, shape (2, n, n); on the edge by those of a parabola (`continued`)."""
    return jnp.stack([slope[1:-1, 1:-1] for slope in central_slopes(continued(f, even), spacing)])


def face_sum(eps: Pair, even: Symmetry = NO_SYMMETRY) -> Array:
    """Sum of the coefficient over the four faces of each cell: the diagonal of - `diffusion`."""
    c = _beyond(eps, even)
    along_y, along_x = c.y[:-2, 1:-1] + c.y[2:, 1:-1], c.x[1:-1, :-2] + c.x[1:-1, 2:]
    return (eps.x + eps.y) + 0.5 * (along_y + along_x)


def curvature(c: Pair, f: Array, even: Symmetry = NO_SYMMETRY) -> Array:
    """c_x d2f/dX2 + c_y d2f/dY2 on unit spacing; f is zero beyond the edge."""
    p = extended(f, even)
    along_x, along_y = p[1:-1, :-2] + p[1:-1, 2:], p[:-2, 1:-1] + p[2:, 1:-1]
    return c.x * (along_x - 2.0 * f) + c.y * (along_y - 2.0 * f)


def largest_around(f: Array, even: Symmetry = NO_SYMMETRY) -> Array:
    """The largest of a node's value and those of the eight nodes around it."""
    p = extended(f, even, "edge")
    rows = jnp.maximum(jnp.maximum(p[:, :-2], p[:, 1:-1]), p[:, 2:])
    return jnp.maximum(jnp.maximum(rows[:-2], rows[1:-1]), rows[2:])


def _beyond(eps: Pair, even: Symmetry) -> Pair:
    """The coefficient with one more node on every side."""
    return tree.map(partial(extended, even=even, beyond="edge"), eps)


def upstream_slope(f: Array, spacing: Array | float) -> Array:
    """df/dX from the two nodes upstream, second order (first order next to the edge, zero on it)."""
    first = f[:, 1:] - f[:, :-1]
    second = 1.5 * first[:, 1:] - 0.5 * first[:, :-1]
    return jnp.concatenate([jnp.zeros_like(f[:, :1]), first[:, :1], second], axis=1) / spacing


def inside(values: Array, even: Symmetry = NO_SYMMETRY) -> Array:
    """The values with the edge set to zero; an axis of symmetry is not an edge, and one row has its two ends only."""
    low_y, low_x = (0 if mirror else 1 for mirror in even)
    if values.shape[0] == 1:
        return jnp.pad(values[:, low_x:-1], ((0, 0), (low_x, 1)))
    return jnp.pad(values[low_y:-1, low_x:-1], ((low_y, 1), (low_x, 1)))


# -- shifts -----------------------------------------------------------------------------------------------------------


def carried_along_x(field: Array, nodes: FloatLike, smooth: Array | None = None) -> tuple[Array, Array]:
    """The field after it has moved by a number of nodes along X (to lower X if negative), and what has passed.

    field: shape (..., n).  What has passed the faces between the nodes and at both ends, shape (..., n + 1), leaves one
    cell and enters the next.

    Between nodes a polynomial through the nearest `POINTS` nodes gives the value.  Its order is high, because a wave
    that is shifted in many steps loses a little at each of them: at 8 nodes per wave 6 points lose about 2 % per
    wavelength, 8 points 0.3 %.  A shift by whole nodes is exact.  Beyond its ends the field has the value of the end;
    of the points that a polynomial takes, those beyond an end lie on the straight line through the last two nodes.

    smooth: where it is given, the flux is that of the polynomial only if all of its points are such nodes.  Elsewhere
    it is of first order: there no new extremes arise.  Points beyond an end have its value.

    Sources: Staniforth A, Cote J. Mon Weather Rev 1991;119:2206 (semi-Lagrangian transport); Leonard BP, Lock AP,
    MacVean MK. Mon Weather Rev 1996;124:2588 (flux form of any step).
    """
    n, half, whole = field.shape[-1], POINTS // 2, jnp.floor(nodes)
    first, last, shift, faces = field[..., :1], field[..., -1:], whole.astype(int), jnp.arange(n + 1)
    columns = jnp.arange(-half, n + half) - shift
    there, below, above = jnp.take(field, columns, axis=-1, mode="clip"), columns, columns - (n - 1)
    if smooth is None:
        there += jnp.minimum(below, 0) * (field[..., 1:2] - first) + jnp.maximum(above, 0) * (last - field[..., -2:-1])

    def at(f: Array, k: int) -> Array:
        return f[..., half - 1 + k : half + k + n]  # the nodes k after those upstream of the faces

    rest = nodes - whole
    weights = lagrange(half - rest, range(POINTS))
    shares = [sum(weights[: k + half]) if k <= 0 else -sum(weights[k + half :]) for k in range(1 - half, half)]
    flux = sum(share * at(there, k) for k, share in enumerate(shares, 1 - half))
    if smooth is not None:
        smooth = jnp.take(smooth, columns, axis=-1, mode="clip")
        all_smooth = jnp.stack([at(smooth, k) for k in range(1 - half, half + 1)]).all(axis=0)
        flux = jnp.where(all_smooth, flux, rest * at(there, 0))
    moved = at(there, 0)[..., 1:] - jnp.diff(flux, axis=-1)
    if smooth is None:
        moved = jnp.where(faces[:-1] < nodes, first, moved)
        moved = jnp.where(faces[:-1] - nodes > n - 1, last, moved)
    # the cells that have passed as a whole, by the sum up to each face
    up_to, before = jnp.pad(jnp.cumsum(field, axis=-1), [(0, 0)] * (field.ndim - 1) + [(1, 0)]), faces - shift
    beyond = jnp.minimum(before, 0) * first + jnp.maximum(before - n, 0) * last
    return moved, up_to - (jnp.take(up_to, before, axis=-1, mode="clip") + beyond) + flux


# -- three nodes on a line, as a matrix ------------------------------------------------------------------------------


def diagonals(change: Callable[[Array], Array], n: int) -> Array:
    """The three diagonals (3, n) of a linear map whose matrix has no others: entries (i, i - 1), (i, i) and (i, i + 1).

    Every third column is looked at together.
    """
    i, shift = jnp.arange(n), jnp.arange(-1, 2)[:, None]
    answers = jax.vmap(change)(jnp.where(i % 3 == jnp.arange(3)[:, None], 1.0, 0.0))
    return answers[(i + shift) % 3, i]


def banded_product(diagonals: Array, matrix: Array) -> Array:
    """The matrix of three diagonals times another one."""
    lower, middle, upper = diagonals[:, :, None]
    return lower * jnp.roll(matrix, 1, axis=0) + middle * matrix + upper * jnp.roll(matrix, -1, axis=0)
