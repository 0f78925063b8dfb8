"""The geometry of two touching bodies: gap, constants of the dry Hertz contact, pressure of the oil far from it.

The bodies have the reduced radii R_x and R_y along the principal axes x and y, and D = R_x/R_y.  The dry contact is an
ellipse with the half width b along x and b/kappa along y; for a circle D = kappa = 1.  Everything is dimensionless:
lengths along the surface in a = b, displacement and approach in a^2/R with R = R_x, pressure in p_h.  X points along
the direction of entrainment, Y across it.  This module is the only source of these constants.

Cylinders with parallel axes touch along a line: D = 0, nothing changes along Y, and integrals are those along X.

E and F are the complete elliptic integrals of second and first kind with the modulus squared 1 - kappa^2.  They are
computed in Carlson's symmetric form, which holds on both sides of the circle.

Source: Johnson KL. Contact Mechanics. Cambridge 1985, section 4.2.  Scaling by b: Biboulet N, Houpert L. Proc IMechE J
2010;224:777-787.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import cbrt, copysign, cos, exp, hypot, log, pi, radians, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ertel.physics import hertz

Array = Any  # a NumPy or JAX array
Floats = NDArray[np.float64]
RIGHT = 90.0  # degrees: an angle of whole multiples of it is along a principal axis
LEAST_RATIO, LARGEST_RATIO = 1 / 100, 100.0  # of the radii; beyond, the contact is a line in all but name

HERTZ_LOAD = 2.0 * pi / 3.0  # double integral of sqrt(1 - r^2): the dry load that carries Delta = 1 on a circle
SHARE_OF_DEFORMATION = 8.0 / 5.0  # weight of a rate of H that falls as 1/r: 1/H^3 against r/(2 H^3), H = r^2/2
LINE_LOAD = pi / 2.0  # integral of sqrt(1 - x^2): the dry load of a line contact
_z, _w = np.polynomial.legendre.leggauss(64)
PLACES = (1.0 + _z) / 2.0, _w / 2.0  # from 0 to 1, and weights
FREE_BALL_INERTIA = 4.0 / 5.0  # m delta*/(F* t0^2) in the scales of an impact: m v0^2/2 = (2/5) F* delta*


@dataclass(frozen=True)
class HertzEllipse:
    """The constants of a dry elliptical contact, all dimensionless; `hertz_ellipse` makes it.

    radius_ratio: D = R_x/R_y.  kappa: half width along x over half width along y; below one where the contact is wide
    across x.  E, F: elliptic integrals.
    """

    radius_ratio: float
    kappa: float
    E: float
    F: float

    @property
    def beta(self) -> float:
        """beta = b E'/(pi p_h R_x), the size of the contact for its pressure: 1 for a circle, 4/pi for a line."""
        return 4.0 / pi * self.E / (1.0 + self.radius_ratio)

    @property
    def compliance(self) -> float:
        """The displacement is this factor times the double integral of P/distance; 2/pi^2 for a circle."""
        return (1.0 + self.radius_ratio) / (2.0 * pi * self.E)

    @property
    def approach(self) -> float:
        """The dry approach in units b^2/R_x; 1 for a circle."""
        return (1.0 + self.radius_ratio) * self.F / (2.0 * self.E)

    @property
    def load(self) -> float:
        """Double integral of the dry pressure; 2 pi/3 for a circle."""
        return 2.0 * pi / (3.0 * self.kappa)

    @property
    def contact_time(self) -> float:
        """The duration of the dry impact in t0 = b^2/(R_x v0)."""
        return hertz.CONTACT_TIME * self.approach

    def front_speed(self, A: float) -> float:
        """The speed dA/dT of the edge of the dry impact, where it is at A."""
        return float(hertz.front_speed(A)) / self.approach


@lru_cache
def hertz_ellipse(radius_ratio: float) -> HertzEllipse:
    """The constants for D = R_x/R_y.  Raises ValueError unless 1/100 <= D <= 100.

    Examples
    --------
    >>> ellipse = hertz_ellipse(0.2)  # a contact that is wide across x
    >>> round(ellipse.kappa, 6), round(ellipse.approach, 6)
    (0.345999, 1.335315)
    """
    if not LEAST_RATIO <= radius_ratio <= LARGEST_RATIO:
        raise ValueError(f"radius_ratio = {radius_ratio}: must be from 1/100 to 100 (R_x/R_y)")
    if radius_ratio == 1.0:
        return HertzEllipse(1.0, 1.0, pi / 2, pi / 2)
    # SciPy is imported here, because circular contacts do not need it and its import is slow
    from scipy.optimize import brentq
    from scipy.special import elliprf, elliprg

    # the root lies between the circle and kappa = D, on either side
    end = log(radius_ratio)
    kappa = exp(brentq(lambda s: log(_radius_ratio(exp(s)) / radius_ratio), min(end, 0.0), max(end, 0.0), xtol=1e-15))
    m = kappa**2
    return HertzEllipse(radius_ratio, kappa, 2.0 * float(elliprg(0.0, m, 1.0)), float(elliprf(0.0, m, 1.0)))


def _radius_ratio(kappa: float) -> float:
    """D = kappa^2 (F - E)/(E - kappa^2 F), both differences in Carlson's form, so that none is of large numbers."""
    from scipy.special import elliprd

    m = kappa**2
    return float(elliprd(0.0, m, 1.0) / elliprd(0.0, 1.0, m))


@dataclass(frozen=True)
class Geometry:
    """Two bodies with the reduced radii R_x and R_y along the principal axes x and y, near their point of contact.

    radius_ratio: D = R_x/R_y, from 1/100 to 100; 1 for a circle.  angle: from the axis x to the direction of
    entrainment, in degrees.  In the methods X and Y broadcast.
    """

    radius_ratio: float = 1.0
    angle: float = 0.0

    @cached_property
    def hertz(self) -> HertzEllipse:
        """The constants of the dry contact."""
        return hertz_ellipse(self.radius_ratio)

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
        return 1.0

    @property
    def free_inertia(self) -> float:
        """m delta/(F* t0^2) of a free body whose impact has these scales: (4/5) Delta_H.

        It follows from m v0^2/2 = (2/5) F* delta* with the dry approach delta* = Delta_H b^2/R_x.
        """
        return FREE_BALL_INERTIA * self.hertz.approach

    @property
    def even(self) -> tuple[bool, bool]:
        """Whether the gap is even in Y and in X: in both where the entrainment is along a principal axis."""
        along_an_axis = self.angle % RIGHT == 0
        return along_an_axis, along_an_axis

    @property
    def extent(self) -> tuple[float, float]:
        """The reach of the dry contact under F* along X and along Y: half the sides of the rectangle around it."""
        c, s = self._direction
        wide = 1.0 / self.hertz.kappa
        return hypot(c, s * wide), hypot(s, c * wide)

    @property
    def smaller(self) -> float:
        """The smaller half width of the dry contact under F*."""
        return min(1.0, 1.0 / self.hertz.kappa)

    def gap(self, X: Array, Y: Array) -> Array:
        """The gap between the undeformed surfaces when they just touch, x^2/2 + D y^2/2."""
        x, y = self._axes(X, Y)
        return x**2 / 2 + self.radius_ratio * y**2 / 2

    def dry_pressure(self, load: float, X: Array, Y: Array) -> Array:
        """Hertz pressure under a load in units of F*: sqrt(s^2 - x^2 - kappa^2 y^2) with s = load^(1/3)."""
        x, y = self._axes(X, Y)
        below = float(load ** (1 / 3)) ** 2 - (x**2 + (self.hertz.kappa * y) ** 2)
        xp = below.__array_namespace__()
        return xp.sqrt(xp.maximum(below, 0.0))

    def grown(self, load: float) -> float:
        """Size and pressure of the dry contact under a load (F*), over those under F*: load^(1/3)."""
        return cbrt(load)

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
class HertzLine:
    """The constants of a dry line contact, as those of `HertzEllipse`; loads are per length.

    reach: Lambda, the length of the contact over its half width b.  A half plane has no finite approach: that of a
    contact of finite length is taken, delta = (b^2/R) (1/4 + ln(2 Lambda)/2).  In the middle of a line load of length l
    on a half space the displacement is that of a half plane which is at rest at the distance l.

    Source: Lundberg G. Elastische Beruehrung zweier Halbraeume. Forsch Ing 1939;10:201.
    """

    reach: float

    beta = 4.0 / pi
    compliance = 1.0 / pi
    load = LINE_LOAD
    kappa = 0.0  # the half width over an infinite one

    @property
    def approach(self) -> float:
        """The dry approach in units b^2/R."""
        return 0.25 + log(2.0 * self.reach) / 2.0

    @property
    def inertia(self) -> float:
        """m delta/(F* t0^2) of a free body whose impact has these scales: m v0^2/2 = inertia/2 F* b^2/R."""
        return self.approach - 1.0 / 8.0

    @property
    def contact_time(self) -> float:
        """The duration of the dry impact in t0 = b^2/(R v0): some 3.1 times the approach."""
        s, weight = PLACES  # A = 1 - s^2 takes the root out of the speed at the end
        return float(np.sum(weight * 4.0 * s / [self.front_speed(1.0 - each**2) for each in s]))

    def front_speed(self, A: float) -> float:
        """The speed dA/dT of the edge of the dry impact, where it is at A: by the energy that is stored,

        (dDelta/dT)^2 = 1 - A^4 (1 - ln A/(2 inertia)),    Delta = A^2 (approach - ln A/2)
        """
        inertia = self.inertia
        return sqrt(1.0 - A**4 * (1.0 - log(A) / (2.0 * inertia))) / (A * (2.0 * inertia - 0.25 - log(A)))


@dataclass(frozen=True)
class LineContact(Geometry):
    """Two cylinders with parallel axes across the flow; see `HertzLine` for reach.  Y has no influence."""

    radius_ratio: float = 0.0
    length_ratio: float = 100.0

    @cached_property
    def hertz(self) -> HertzLine:  # type: ignore[override]
        return HertzLine(self.length_ratio)

    @property
    def reach(self) -> float:
        return self.length_ratio

    @property
    def free_inertia(self) -> float:
        return self.hertz.inertia

    @property
    def extent(self) -> tuple[float, float]:
        """The half width, and half the length."""
        return 1.0, self.length_ratio / 2.0

    @property
    def smaller(self) -> float:
        return 1.0

    def dry_pressure(self, load: float, X: Array, Y: Array) -> Array:
        """Hertz pressure under a load in units of F*: sqrt(load - x^2)."""
        below = load - X**2 + 0.0 * Y
        xp = below.__array_namespace__()
        return xp.sqrt(xp.maximum(below, 0.0))

    def grown(self, load: float) -> float:
        """See `Geometry.grown`: load^(1/2)."""
        return sqrt(load)

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
