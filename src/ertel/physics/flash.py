"""Flash temperature: how much the surfaces of a sliding contact are hotter than their bodies.

    T(x) = (pi rho c k |u|)^{-1/2} * integral of q(x') |x - x'|^{-1/2} dx' over all x' upstream of x

q is the heat flux into the body, in W/m^2, and u the speed of its surface through the contact.  Heat flows into the
depth only, so that the speed must be high: Peclet number |u| a rho c/(2 k) above about 5 (Blok H. Proc Inst Mech Eng
General Discussion on Lubrication 1937;2:222-235; Carslaw HS, Jaeger JC. Conduction of heat in solids. Oxford; 1959).
From a surface at rest heat flows to all sides: T = 1/(2 pi k) * double integral of q/distance.

The moving kernel is singular at x' = x.  It is integrated exactly over every cell, with q linear between the nodes.
"""

from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from ertel.physics.thermal import Solid
from ertel.physics.units import require_positive

Real = NDArray[np.float64]
SLOWEST = 5.0  # Peclet number below which heat that flows along the surface counts
AT_REST = 4.0 / pi  # Peclet number of a circle with uniform heat that is as hot in its middle at rest as by the formula


def peclet_number(solid: Solid, speed: float, half_width: float) -> float:
    """|u| a rho c/(2 k): speed in m/s, half width of the heated strip in m."""
    return abs(speed) * half_width * solid.density * solid.heat_capacity / (2.0 * solid.conductivity)


def slow_excess(peclet: float) -> float:
    """By what share a temperature rise is too high where a surface is slow.

    Below AT_REST the surface counts as one at rest; above it, heat that flows along the surface is left out.  Compared
    with 2 q a/[k (4 + pi Pe)^{1/2}], the highest temperature of a circle with uniform heat, which joins both limits
    (Tian X, Kennedy FE. J Tribol 1994;116:167-174).

    Examples
    --------
    >>> round(slow_excess(SLOWEST), 2)
    0.12
    """
    ratio = peclet / AT_REST
    return sqrt(1.0 + min(ratio, 1.0 / ratio if ratio > 0 else 0.0)) - 1.0


def moving_source_weights(nodes: int, spacing: float) -> Real:
    """Weights of the kernel x^{-1/2}: the integral at node i is the sum over j <= i of weights[i - j] q[j].

    (4/3) spacing^{1/2} [(m + 1)^{3/2} - 2 m^{3/2} + |m - 1|^{3/2}] for m >= 1, and 4/3 spacing^{1/2} for m = 0: exact
    where q is linear between nodes and zero before the first.  Second order where q is smooth.  Shape (nodes,).
    """
    m = np.arange(nodes, dtype=float)
    weights = (m + 1.0) ** 1.5 - 2.0 * m**1.5 + np.abs(m - 1.0) ** 1.5
    weights[0] = 1.0
    return np.asarray(4.0 / 3.0 * sqrt(spacing) * weights)


def response(solid: Solid, speed: float, nodes: int, spacing: float) -> Real:
    """The matrix K with T = q @ K.T along X: temperature rise (K) from the heat flux (W/m^2), shape (nodes, nodes).

    speed: of the surface along X, m/s, with its sign.  spacing in m.  Raises ValueError for speed = 0: from a surface
    at rest heat flows away to all sides, and the formula does not hold.
    """
    require_positive("|speed|", abs(speed))
    weights = moving_source_weights(nodes, spacing) / (sqrt(pi * abs(speed)) * solid.effusivity)
    lag = np.arange(nodes)[:, None] - np.arange(nodes)[None, :]
    matrix = np.where(lag >= 0, weights[np.abs(lag)], 0.0)
    return matrix if speed > 0 else np.asarray(matrix.T)


def flash_temperature(heat: Real, solid: Solid, speed: float, spacing: float) -> Real:
    """Temperature rise of a moving surface, in K.

    heat: flux into the body in W/m^2, shape (..., n), index along X last.  The other arguments as in `response`.
    """
    found: Real = heat @ response(solid, speed, heat.shape[-1], spacing).T
    return found
