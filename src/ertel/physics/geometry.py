"""The geometry of two touching bodies: gap, constants of the dry Hertz contact, pressure of the oil far from it.

The bodies have the reduced radii R_x and R_y along the principal axes x and y, and D = R_x/R_y.  The dry contact is an
ellipse with the half width b along x and b/kappa along y; for a circle D = kappa = 1.  Everything is dimensionless:
lengths along the surface in a = b, displacement and approach in a^2/R with R = R_x, pressure in p_h.  X points along
the direction of entrainment, Y across it.  This module is the only source of these constants.

Cylinders with parallel axes touch along a line: D = 0, nothing changes along Y, and integrals are those along X.

Source: Johnson KL. Contact Mechanics. Cambridge 1985, section 4.2.  Scaling by b: Biboulet N, Houpert L. Proc IMechE J
2010;224:777-787.
"""

from dataclasses import dataclass
from functools import cached_property
from math import cbrt, copysign, cos, hypot, log, pi, radians, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ertel.physics.dry_contact import DryContact, dry_contact

Array = Any  # a NumPy or JAX array
Floats = NDArray[np.float64]
RIGHT = 90.0  # degrees: an angle of whole multiples of it is along a principal axis

SHARE_OF_DEFORMATION = 8.0 / 5.0  # weight of a rate of H that falls as 1/r: 1/H^3 against r/(2 H^3), H = r^2/2


@dataclass(frozen=True)
class Geometry:
    """Two bodies with the reduced radii R_x and R_y along the principal axes x and y, near their point of contact.

    radius_ratio: D = R_x/R_y, from 1/100 to 100; 1 for a circle.  angle: from the axis x to the direction of
    entrainment, in degrees.  In the methods X and Y broadcast.
    """

    radius_ratio: float = 1.0
    angle: float = 0.0

    @cached_property
    def hertz(self) -> DryContact:
        """The constants of the dry contact."""
        return dry_contact(self.radius_ratio)

    @property
    def hertz_load(self) -> float:
        """Double integral of the dry pressure under the load F*, 2 pi/(3 kappa)."""
        return self.hertz.load

    @property
    def compliance(self) -> float:
        """The displacement is this factor times the double integral of P/distance: (1 + D)/(2 pi E)."""
        return self.hertz.compliance

    @property
    def is_line(self) -> bool:
        """Whether the bodies touch along a line."""
        return self.radius_ratio == 0.0

    @property
    def reach(self) -> float:
        """The distance at which a line load displaces nothing; without meaning for a point contact."""
        return self.hertz.reach

    @property
    def even(self) -> tuple[bool, bool]:
        """Whether the gap is even in Y and in X: in both where the entrainment is along a principal axis."""
        along_an_axis = self.angle % RIGHT == 0
        return along_an_axis, along_an_axis

    @property
    def extent(self) -> tuple[float, float]:
        """The reach of the dry contact under F* along X and along Y: half the sides of the rectangle around it."""
        (c, s), wide = self._direction, self.hertz.wide
        return hypot(c, s * wide), hypot(s, c * wide)

    @property
    def smaller(self) -> float:
        """The smaller half width of the dry contact under F*."""
        return min(1.0, self.hertz.wide)

    def gap(self, X: Array, Y: Array) -> Array:
        """The gap between the undeformed surfaces when they just touch, x^2/2 + D y^2/2."""
        x, y = self._axes(X, Y)
        return x**2 / 2 + self.radius_ratio * y**2 / 2

    def bent(self, X: Array, Y: Array) -> Array:
        """The speed with which the bodies would part, at each place, for the same oil as where the parabola grows by 1.

        2 ((1 + 2 D) x^2/2 + (2 + D) D y^2/2)/(3 (1 + D)), which is the parabola itself for a circle; exact by Reynolds'
        equation of constant viscosity, as `far_flow`.
        """
        (x, y), D = self._axes(X, Y), self.radius_ratio
        return ((1 + 2 * D) * x**2 + (2 + D) * D * y**2) / (3 * (1 + D))

    def dry_pressure(self, load: float, X: Array, Y: Array) -> Array:
        """Hertz pressure under a load in units of F*: sqrt(s^2 - x^2 - kappa^2 y^2) with s = load^(1/3)."""
        x, y = self._axes(X, Y)
        below = float(load ** (1 / 3)) ** 2 - (x**2 + (self.hertz.kappa * y) ** 2)
        xp = below.__array_namespace__()
        return xp.sqrt(xp.maximum(below, 0.0))

    def grown(self, load: float, curvature: float = 1.0) -> tuple[float, float]:
        """Size and pressure of the dry contact of radius R/c under a load (F*), over those of R and F*."""
        return cbrt(load / curvature), cbrt(load * curvature**2)

    def dry_approach(self, load: float) -> float:
        """Hertz approach under a load in units of F*: Delta_H s^2 with s = load^(1/3)."""
        return self.hertz.approach * float((load ** (1 / 3)) ** 2)

    def influence(self, r: Floats) -> Floats:
        """The displacement at a distance by a force, over the compliance: 1/r."""
        return 1.0 / r

    def circle(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        """X and Y of points all around at the distances r, shape (n, m), and the length around, shape (n,)."""
        angle = (np.arange(64) + 0.5) * np.pi / 32
        return r[:, None] * np.cos(angle), r[:, None] * np.sin(angle), 2.0 * np.pi * r

    def rising(self, r: Floats, load_rate: float) -> Floats:
        """The speed that acts like the rate of the deformation at a distance, by a load that grows.

        The deformation is that by the load as a point force.  load_rate: in F*/t0.
        """
        return SHARE_OF_DEFORMATION * load_rate * self.compliance * self.hertz_load * self.influence(r)

    def dry_load_rate(self, approach: float, velocity: float) -> float:
        """The rate of the load of a dry contact, which is proportional to Delta^(3/2)."""
        full = self.hertz.approach
        return 1.5 * velocity * (max(approach, 0.0) / full) ** 0.5 / full

    def distance(self, X: Array, Y: Array) -> Array:
        """Distance from the centre, one on the edge of the dry contact under F*: sqrt(x^2 + kappa^2 y^2)."""
        x, y = self._axes(X, Y)
        return (x**2 + (self.hertz.kappa * y) ** 2) ** 0.5

    def far_flow(self, velocity: Array, entrainment: float, X: Array, Y: Array) -> Array:
        """P H^2/lambda_bar far out, where H is the rigid gap: exact by Reynolds' equation of constant viscosity.

        V/(2 (1 + D)) - U cos(angle) x/(3 + 2 D) - U sin(angle) D y/(2 + 3 D); V/4 - U X/5 for a circle.  The gap is
        full all around: see `ruptured_flow`.
        """
        (x, y), (c, s), D = self._axes(X, Y), self._direction, self.radius_ratio
        wedge = entrainment * c * x / (3 + 2 * D) + entrainment * s * D * y / (2 + 3 * D)
        return velocity / (2 * (1 + D)) - wedge

    def ruptured_flow(
        self, velocity: Floats, entrainment: float, X: Floats, Y: Floats, constant: Floats, held: bool = False
    ) -> Floats:
        """The same where the oil ruptures behind the contact, not above zero there.

        constant: the gap less the parabola.  held: whether V leaves the rupture in its place; at rest it is where
        the flow left it: the sign of the zero is that of U before.
        """
        flow = self.far_flow(0.0 if held else velocity, entrainment, X, Y)
        if entrainment == 0.0 and not held:
            return flow
        from ertel.physics.rupture import rupture  # imports SciPy, which an impact does not need

        (x, y), (c, s), r = self._axes(X, Y), self._direction, np.hypot(X, Y)
        angle = np.arctan2(y, x) + (0.0 if copysign(1.0, entrainment) > 0.0 else pi)  # seen from the other side
        table, across, k = rupture(self.radius_ratio, c, s), abs(entrainment) * r, constant / r**2
        flow += across * table.correction(np.zeros_like(r) if held else velocity / across, angle, k)
        return table.squeezed(np.maximum(flow, 0.0), velocity, angle) if held else flow

    def _axes(self, X: Array, Y: Array) -> tuple[Array, Array]:
        """Coordinates along the principal axes."""
        c, s = self._direction
        return (c * X - s * Y, s * X + c * Y) if s else (c * X, c * Y)

    @property
    def _direction(self) -> tuple[float, float]:
        """Cosine and sine of the angle, exact along the principal axes."""
        exact = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
        return exact.get(self.angle % 360.0) or (cos(radians(self.angle)), sin(radians(self.angle)))


CIRCLE = Geometry()


@dataclass(frozen=True)
class LineContact(Geometry):
    """Two cylinders with parallel axes across the flow; see `HertzLine` for reach.  Y has no influence."""

    radius_ratio: float = 0.0
    length_ratio: float = 100.0

    @cached_property
    def hertz(self) -> DryContact:
        return dry_contact(0.0, self.length_ratio)

    def dry_pressure(self, load: float, X: Array, Y: Array) -> Array:
        """Hertz pressure under a load in units of F*: sqrt(load - x^2)."""
        below = load - X**2 + 0.0 * Y
        xp = below.__array_namespace__()
        return xp.sqrt(xp.maximum(below, 0.0))

    def grown(self, load: float, curvature: float = 1.0) -> tuple[float, float]:
        """See `Geometry.grown`."""
        return sqrt(load / curvature), sqrt(load * curvature)

    def dry_approach(self, load: float) -> float:
        """Hertz approach under a load in units of F*: load (kappa - ln(load)/4) with the approach kappa under F*."""
        return load * (self.hertz.approach - log(load) / 4.0) if load > 0.0 else 0.0

    def ruptured_flow(
        self, velocity: Floats, entrainment: float, X: Floats, Y: Floats, constant: Floats, held: bool = False
    ) -> Floats:
        """P H^2/lambda_bar far out, not above zero where the oil ruptures; held: V leaves the rupture in the middle."""
        flow = self.far_flow(velocity, entrainment, X, Y)
        if not held:
            return flow
        return np.where(copysign(1.0, entrainment) * X < 0.0, np.maximum(flow, 0.0), 0.0)

    def influence(self, r: Floats) -> Floats:
        """The displacement at a distance by a line load, over the compliance: ln(reach/r)."""
        return np.log(self.reach / r)

    def circle(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        """Both points at each distance."""
        X = r[:, None] * np.array([-1.0, 1.0])
        return X, 0.0 * X, np.full_like(r, 2.0)

    def rising(self, r: Floats, load_rate: float) -> Floats:
        """See `Geometry.rising`: a rate (ln(reach/r) + 3/4) of H acts like a speed, where H = r^2/2."""
        return load_rate * self.compliance * self.hertz_load * (self.influence(r) + 0.75)

    def dry_load_rate(self, approach: float, velocity: float) -> float:
        """The rate of the load of a dry contact."""
        if approach <= 0.0:
            return 0.0
        full = load = self.hertz.approach
        for _ in range(ROUNDS):
            load = approach / (full - log(load) / 4.0)
        return velocity / (full - (log(load) + 1.0) / 4.0)


ROUNDS = 20  # to find the load of a dry line contact; each leaves a tenth


def geometry(radius_ratio: float = 1.0, angle: float = 0.0, length_ratio: float = 100.0) -> Geometry:
    """The geometry for R_x/R_y and the angle of entrainment (degrees); `CIRCLE`, whose angle has no meaning, for 1.

    It is a line for 0, of that length over its half width.
    """
    if radius_ratio == 0.0:
        return LineContact(length_ratio=length_ratio)
    return CIRCLE if radius_ratio == 1.0 else Geometry(radius_ratio, angle)
