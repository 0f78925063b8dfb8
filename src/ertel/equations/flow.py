"""The rate of change of the mass following the mean flow: squeeze and wedge as one term.

    Dm/DT = dm/dT + U dm/dX,    m = rho H

U is the same everywhere, so all oil moves by the same distance s = integral of U dT.  The oil that is at X now was at
X - s before, and backward differences along its way need nothing but the earlier masses, moved downstream:

    Dm/DT = w0 m(X, T) + w1 m(X - s1, T1) + w2 m(X - s2, T2)

* impact: the oil stays, s = 0.  This is the squeeze term.
* rolling in time: the oil comes from upstream.  Waves that ride with it are carried without loss.
* steady rolling: the oil's past is the same film upstream, s1 = h, s2 = 2 h on a grid of spacing h.  This is the wedge,
  by the second-order upstream difference U (3 m(X) - 4 m(X - h) + m(X - 2 h))/(2 h).

A run in time starts from a film that is steady (rolling) or without pressure (impact).  The rate of that film is its
steady rate, and only what has changed since follows the oil.  So a steady film stays as it is whatever the step.
All quantities are dimensionless; U in a/t0.
"""

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from ertel.numerics.bdf import Weights
from ertel.numerics.stencils import shifted_along_x, upstream_slope

Number = Array | float


class Rate(NamedTuple):
    """The rate of change of the mass m following the flow: new * m + past + wedge * (slope of m from upstream).

    new: weight of the mass at the node now.  past: the known part, from the earlier masses, shape (n, n) or a number.
    wedge: the entrainment speed U >= 0 where the film is steady, so that its past is the film upstream; else None.
    """

    new: Number
    past: Number
    wedge: Number | None = None

    def of(self, mass: Array, spacing: Number) -> Array:
        """The rate of a mass, shape (n, n)."""
        in_time = self.new * mass + self.past
        return in_time if self.wedge is None else in_time + self.wedge * upstream_slope(mass, spacing)


def steady_rate(entrainment: Number) -> Rate:
    """The rate in a steady film; X points downstream (entrainment >= 0)."""
    return Rate(0.0, 0.0, entrainment)


class Flow(NamedTuple):
    """The movement of the oil in one time step.

    entrainment: U at the new time.  distances: by which the oil has moved in this step and in the one before, newest
    first, in nodes.  start: the mass of the film from which the run started, shape (n, n).
    """

    entrainment: Number
    distances: Sequence[Number]
    start: Array


def rate_in_time(weights: Weights | Array, masses: Sequence[Array] | Array, flow: Flow | None, spacing: Number) -> Rate:
    """The rate at the new time by backward differences along the flow.

    weights: for the new and the earlier times, newest first.  masses: at the earlier times, each of shape (n, n).
    flow: None where the oil stays.
    """
    if flow is None:
        return Rate(weights[0], sum(w * m for w, m in zip(weights[1:], masses, strict=True)))
    changes = [mass - flow.start for mass in masses]
    past = followed(weights[1:], changes, flow.distances) - weights[0] * flow.start
    return Rate(weights[0], past + wedge(flow.start, flow.entrainment, spacing))


def followed(weights: Weights | Array, masses: Sequence[Array], distances: Sequence[Number]) -> Array:
    """The weighted sum of earlier masses, each moved to where its oil is now.

    The oldest is moved step by step, as the newer ones were: what the interpolation takes from a wave is then the same
    in all of them, and the differences in time are not disturbed by it.
    """
    *newer, oldest = zip(weights, masses, distances, strict=True)
    moved = shifted_along_x(oldest[0] * oldest[1], oldest[2])
    for weight, mass, distance in reversed(newer):
        moved = shifted_along_x(weight * mass + moved, distance)
    return moved


def wedge(mass: Array, entrainment: Number, spacing: Number) -> Array:
    """The rate of change of a steady film: U dm/dX from upstream, for either sign of U."""
    downstream = upstream_slope(mass, spacing)
    upstream = -upstream_slope(mass[:, ::-1], spacing)[:, ::-1]
    return entrainment * jnp.where(jnp.asarray(entrainment) >= 0, downstream, upstream)
