"""Integrals of fields over a grid and along its edge, of second order.

A space knows where its nodes are; fields have the shape of its arrays, and `edge` makes one line of the values on the
edge.  `Plane` is a rectangle of square cells, `Disc` a radial grid.  Both end at the outermost nodes.  A plane of one
row is a line: its integrals are those along X, and its edge has two ends.
"""

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.tree_util import register_dataclass

from ertel.numerics.bdf import derivative_weights
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.stencils import Pair, inside

SLOPE = (11 / 6, -3.0, 3 / 2, -1 / 3)  # weights of the nodes from the edge inwards for the slope towards the edge


@register_dataclass
@dataclass(frozen=True)
class Plane:
    """A rectangle.

    x, y: the kept nodes, of shape (n_x,) and (n_y, 1).  centre: the number of the node there.  wx, wy: the weights of
    the kept columns and rows; an even axis counts for both of its sides.
    """

    x: Array
    y: Array
    centre: int
    wx: Array
    wy: Array
    spacing: float
    even: Symmetry = field(metadata={"static": True})

    @classmethod
    def of(cls, grid: Grid) -> "Plane":
        """The rectangle of a grid."""
        along_y, along_x = (_weights(n, even) * grid.spacing for n, even in zip(grid.shape, grid.even, strict=True))
        along_y = np.ones(1) if grid.nodes_y == 1 else along_y
        row, column = (int(np.abs(axis).argmin()) for axis in (grid.kept_y, grid.kept_x))
        x, y, wx, wy = jax.device_put((grid.kept_x, grid.kept_y[:, None], along_x, along_y))
        return cls(x, y, row * grid.shape[1] + column, wx, wy, grid.spacing, grid.even)

    def total(self, f: Array) -> Array:
        """The double integral of a field, by products: XLA sums a whole field in three times as long."""
        return self.wy @ (f @ self.wx)

    def of_slopes(self, c: Pair, f: Array, g: Array) -> Array:
        """c_x df/dX dg/dX + c_y df/dY dg/dY at the nodes; its `total` is the sum over the faces between the nodes."""
        in_y, in_x = (0.5 * (k[1:] + k[:-1]) * (a[1:] - a[:-1]) for k, a in ((c.y, f), (c.x.T, f.T)))
        return self.across_faces(in_x.T, in_y, g) / self.spacing

    def across_faces(self, on_x: Array, on_y: Array, g: Array) -> Array:
        """a_x dg/dX + a_y dg/dY at the nodes; on_x: a_x between neighbours along X, on_y: a_y along Y.

        Each face gives half to the node on either side of it.  So `total` is the sum over the faces.
        """
        in_y, in_x = on_y * (g[1:] - g[:-1]), on_x.T * (g.T[1:] - g.T[:-1])
        return (_to_nodes(in_y) + _to_nodes(in_x).T) / self.spacing

    def push(self, c: Array, f: Array) -> Array:
        """The double integral of c grad f, shape (2,), for fields c and f that are even about an even axis."""
        in_y, in_x = (0.5 * (k[1:] + k[:-1]) * (a[1:] - a[:-1]) for k, a in ((c, f), (c.T, f.T)))
        along_x = 0.0 if self.even.x else jnp.sum(in_x * self.wy)
        along_y = 0.0 if self.even.y else jnp.sum(in_y * self.wx)
        return jnp.stack([along_x, along_y])

    def edge(self, f: Array) -> Array:
        """The values on the edge, one line."""
        return self._line(f, f, 0)

    def flow_out(self, c: Pair, f: Array) -> Array:
        """- c df/dn on the edge, n pointing outwards; third order, so that it does not dominate the error.

        Zero where f is zero on the edge and beside it, in a cavity.
        """
        lines = [self._line(f, f, depth) for depth in range(len(SLOPE))]
        slope = sum(weight * line for weight, line in zip(SLOPE, lines, strict=True))
        empty = (lines[0] == 0.0) & (lines[1] == 0.0)
        return jnp.where(empty, 0.0, -self._line(c.x, c.y, 0) * slope / self.spacing)

    def along_x(self, f: Array) -> Array:
        """f n_x on the edge, n pointing outwards."""
        low = -f[:, 0] if not self.even.x else f[:0, 0]
        ends = jnp.zeros(self.wx.size * len(self._sides_along_x))
        return jnp.concatenate([f[:, -1], low, ends])

    def inner(self, f: Array) -> Array:
        """The double integral over the cells of the nodes within the edge, which end halfway to it."""
        return self.total(inside(f, self.even))

    def leaving(self, on_x: Array, on_y: Array) -> Array:
        """Flow outwards through the outermost faces of those cells, one number for each face.

        on_x, on_y: what flows to higher X through the faces across X, shape (n, n + 1), and to higher Y through those
        across Y, shape (n + 1, n), as in `stencils.face_fluxes`.
        """
        within = inside(jnp.ones((self.wy.size, self.wx.size)), self.even)
        rows, columns = self.wy * within.max(axis=1), self.wx * within.max(axis=0)
        ends = [(1.0, -1.0), (2.0, 0.0)]  # at high and low X or Y, without and with an axis
        high_x, low_x = ends[self.even.x]
        parts = [high_x * rows * on_x[:, -2], low_x * rows * on_x[:, 1]]
        if self.wy.size > 1:
            high_y, low_y = ends[self.even.y]
            parts += [high_y * columns * on_y[-2], low_y * columns * on_y[1]]
        return jnp.concatenate(parts)

    def around(self, line: Array) -> Array:
        """The integral along the edge of a line from `edge`, `flow_out` or `along_x`."""
        across = (2.0,) if self.even.x else (1.0, 1.0)
        weights = [*(side * self.wy for side in across), *(side * self.wx for side in self._sides_along_x)]
        return jnp.sum(jnp.concatenate(weights) * line)

    def _line(self, f_x: Array, f_y: Array, depth: int) -> Array:
        """The sides at high and low X, then at high and low Y; a side across an even axis is left out."""
        lines = [f_x[:, -1 - depth], *([] if self.even.x else [f_x[:, depth]])]
        lines += [f_y[-1 - depth], f_y[depth]][: len(self._sides_along_x)] if self.wy.size > 1 else []
        return jnp.concatenate(lines)

    @property
    def _sides_along_x(self) -> tuple[float, ...]:
        """The sides at high and low Y, and for how many each counts; one row has none."""
        return () if self.wy.size == 1 else (2.0,) if self.even.y else (1.0, 1.0)


def _to_nodes(between: Array) -> Array:
    """The mean of the two values beside each node along the first axis; at the ends the only one."""
    if between.shape[0] == 0:  # of one row
        return jnp.zeros((1, *between.shape[1:]))
    return 0.5 * (jnp.concatenate([between[:1], between]) + jnp.concatenate([between, between[-1:]]))


def _weights(nodes: int, even: bool) -> np.ndarray:
    """The trapezium rule on unit spacing over the whole axis, of which one side is kept where it is even."""
    weights = np.full(nodes, 2.0 if even else 1.0)
    weights[0] = 1.0 if even else 0.5
    weights[-1] /= 2.0
    return weights


@register_dataclass
@dataclass(frozen=True)
class Disc:
    """A disc with nodes at r, from 0 outwards; fields have shape (n,).  The methods are those of `Plane`.

    weights: of the double integral.  faces: 2 pi r/(difference of r) halfway between the nodes.  slope: weights of the
    last four nodes, outermost first, for the derivative along r at the edge.
    """

    weights: Array
    faces: Array
    slope: Array
    length: float

    @classmethod
    def of(cls, r: np.ndarray) -> "Disc":
        """The disc of a radial grid."""
        h = np.diff(r)
        faces = np.pi * (r[1:] + r[:-1]) / h
        slope = derivative_weights(r[:-5:-1].tolist())
        weights, faces, slope = jax.device_put((disc_weights(r), faces, slope))
        return cls(weights, faces, slope, float(2 * np.pi * r[-1]))

    def total(self, f: Array) -> Array:
        return jnp.sum(self.weights * f)

    def of_slopes(self, c: Pair, f: Array, g: Array) -> Array:
        half = self.faces * 0.25 * (c.x[1:] + c.x[:-1]) * jnp.diff(f) * jnp.diff(g)
        return (jnp.pad(half, (0, 1)) + jnp.pad(half, (1, 0))) / self.weights

    def edge(self, f: Array) -> Array:
        return f[-1:]

    def flow_out(self, c: Pair, f: Array) -> Array:
        return -c.x[-1:] * jnp.sum(self.slope * f[:-5:-1])

    def along_x(self, f: Array) -> Array:
        return jnp.zeros(1)

    def around(self, line: Array) -> Array:
        return self.length * line[0]


Space = Plane | Disc


def disc_weights(r: np.ndarray) -> np.ndarray:
    """Weights of 2 pi integral of f r dr, exact for f linear between the nodes r."""
    h = np.diff(r)
    falling, rising = h * (2 * r[:-1] + r[1:]) / 6, h * (r[:-1] + 2 * r[1:]) / 6
    return np.asarray(2 * np.pi * (np.pad(falling, (0, 1)) + np.pad(rising, (1, 0))))
