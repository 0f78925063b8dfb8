"""The oil outside the grid: the pressure at the grid's edge, and its load and deformation, from `physics.far_field`."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ertel.equations.state import State
from ertel.numerics import bdf
from ertel.numerics.grid import Grid
from ertel.physics.far_field import NEAREST, ContactMotion, far_pressure, rigid_pressure
from ertel.physics.geometry import CIRCLE, Geometry

Floats = NDArray[np.float64]

# Gauss points from 0 to 1 and their weights, along each piece of the edge and outwards
_points, _weights = np.polynomial.legendre.leggauss(8)
PLACES, WEIGHTS = (_points + 1) / 2, _weights / 2
SMALL_SPEED = 1e-3  # difference of V, by which the change with V is found
NEWEST = 2  # levels from which the motion of the new level is predicted: with more, the oil outside overshoots


class Surroundings(NamedTuple):
    """The oil around the grid at one time.

    edge: P on the edge nodes and zero on the others.  load: double integral of P outside.  uplift: the deformation that
    it causes at the centre, taken as uniform.
    """

    edge: Any
    load: Any
    uplift: Any


UNCHANGED = Surroundings(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Outside:
    """The oil outside a grid: the places at which its pressure is taken.

    A gap that changes its curvature presses and sucks on the edge of the grid.  Farther out this is left out, because
    the parabola ends somewhere: up to 50 a, at a rate of 3 % in t0 and lambda_bar = 0.02, it carries 0.2 % of the load.

    X, Y: the nodes of the grid.  is_edge: which of them are on the edge.  far: X, Y and area of the quadrature points
    outside, shape (3, n).
    """

    X: Floats
    Y: Floats
    is_edge: NDArray[np.bool_]
    far: Floats
    lambda_bar: float
    geometry: Geometry

    def at(self, motion: ContactMotion) -> Surroundings:
        """The oil around the grid for a given motion."""
        nodes, X, Y, areas = self._around
        edge, outside = np.zeros(self.is_edge.shape), areas.shape[1]
        bending = motion.bending * (np.arange(len(X)) < len(X) - outside)
        P = far_pressure(X, Y, motion._replace(bending=bending), self.lambda_bar, self.geometry)
        edge[nodes] = P[:-outside]
        return Surroundings(edge, *(areas @ P[-outside:]).tolist())

    def change(self, motion: ContactMotion) -> Surroundings:
        """The change of the oil around the grid per change of V."""
        ends = (self.at(motion._replace(velocity=motion.velocity + more)) for more in (0.0, SMALL_SPEED))
        return Surroundings(*((there - here) / SMALL_SPEED for here, there in zip(*ends, strict=True)))

    def at_first(self, motion: ContactMotion) -> Floats:
        """P on the grid while the surfaces are apart."""
        return rigid_pressure(self.X, self.Y, motion, self.lambda_bar, self.geometry)

    def guess(self, motion: ContactMotion) -> Floats:
        """A guess of P on the grid where it is far from the contact, zero elsewhere."""
        where, P = self.is_edge | (self.geometry.distance(self.X, self.Y) >= NEAREST), np.zeros(self.is_edge.shape)
        P[where] = far_pressure(self.X[where], self.Y[where], motion, self.lambda_bar, self.geometry)
        return P

    @cached_property
    def _around(self) -> tuple[tuple[NDArray[np.int64], ...], Floats, Floats, Floats]:
        """The constants of every step: indices of the edge nodes; X and Y of these and of points outside, in one array.

        And for the points outside the weights of their pressure in the load and in the uplift, shape (2, n).
        """
        edge, (X, Y, area) = np.nonzero(self.is_edge), self.far
        weights = np.stack([area, self.geometry.compliance * area * self.geometry.influence(np.hypot(X, Y))])
        return edge, np.append(self.X[edge], X), np.append(self.Y[edge], Y), weights


def around_grid(grid: Grid, lambda_bar: float, geometry: Geometry = CIRCLE) -> Outside:
    """The oil outside a rectangle or one row, which ends half a cell beyond the edge nodes."""
    X, Y = np.meshgrid(grid.kept_x, grid.kept_y)
    left, right, low, high = grid.x[0], grid.x[-1], grid.y[0], grid.y[-1]
    half = grid.spacing / 2
    if grid.nodes_y == 1:
        is_edge, ends = (left == X) | (right == X), np.array([[left - half], [right + half]])
        far = np.stack([ends / PLACES, 0.0 * ends / PLACES, abs(ends) * WEIGHTS / PLACES**2])
        return Outside(X, Y, is_edge, far.reshape(3, -1), lambda_bar, geometry)
    is_edge = (left == X) | (right == X) | (low == Y) | (high == Y)
    corners = [left - half, right + half, low - half, high + half]
    return Outside(X, Y, is_edge, beyond_rectangle(*corners), lambda_bar, geometry)


def around_circle(r: Floats, lambda_bar: float) -> Outside:
    """The oil outside a radial grid with nodes r."""
    far = r[-1] / PLACES
    area = 2 * np.pi * far**3 * WEIGHTS / r[-1]
    return Outside(
        r, np.zeros_like(r), np.arange(len(r)) == len(r) - 1, np.stack([far, 0 * far, area]), lambda_bar, CIRCLE
    )


def beyond_rectangle(left: float, right: float, low: float, high: float) -> Floats:
    """X, Y and area of quadrature points outside a rectangle around the origin, shape (3, n).

    Each lies on a ray from the origin through a point of the edge, 1/u times as far.  The pieces of the edge end at
    X = 0, a little upstream of where the oil that is entrained ruptures.
    """
    pieces = [((side, low), (side, high)) for side in (left, right)]
    pieces += [((start, side), (end, side)) for side in (low, high) for start, end in ((left, 0.0), (0.0, right))]
    s = u = PLACES  # along the piece, and outwards
    points = []
    for (x0, y0), (x1, y1) in pieces:
        X, Y = ((1 - s) * x0 + s * x1)[:, None] / u, ((1 - s) * y0 + s * y1)[:, None] / u
        area = abs(x0 * y1 - x1 * y0) * WEIGHTS[:, None] * WEIGHTS / u**3
        points.append(np.stack([X.ravel(), Y.ravel(), area.ravel()]))
    return np.concatenate(points, axis=1)


def predicted(levels: Sequence[State], T: float, hertz_load: float, entrainment: float) -> ContactMotion:
    """The motion at the next level, from the last levels (newest first); hertz_load: F* in a^2 p_h."""
    newest = levels[:NEWEST]
    weights = bdf.interpolation_weights(T, [level.T for level in newest])
    numbers = [(level.approach, level.velocity, (level.load + level.outside) / hertz_load) for level in newest]
    approach, velocity, load = (weights @ numbers).tolist()
    return ContactMotion(approach, velocity, load, entrainment)
