"""The geometry of two touching bodies: their undeformed gap and the dimensionless constants of the dry Hertz contact.

A geometry is a record with the fields and methods of `Geometry`.  It is the model's only source of them.  Everything
is dimensionless: lengths along the surface in a, displacement and approach in a^2/R, pressure in p_h.  X points along
the direction of entrainment, Y across it.  For an ellipse, a is its half width b along the first principal axis and R
is the reduced radius R_x along that axis (`ellipse`).
"""

from dataclasses import dataclass
from functools import cached_property
from math import cos, hypot, pi, radians, sin
from typing import Any, Protocol

from ertel.physics.ellipse import HertzEllipse, hertz_ellipse

Array = Any  # a NumPy or JAX array
RIGHT = 90.0  # degrees: an angle of whole multiples of it is along a principal axis

HERTZ_LOAD = 2.0 * pi / 3.0  # double integral of sqrt(1 - r^2): the dry load that carries Delta = 1
COMPLIANCE = 2.0 / pi**2  # factor in eq. (3): the displacement is this times the double integral of P/distance
FREE_BALL_INERTIA = 4.0 / 5.0  # m delta*/(F* t0^2) in the scales of an impact: m v0^2/2 = (2/5) F* delta*


class Geometry(Protocol):
    """Two bodies near their point of contact.

    hertz_load: double integral of the dry pressure under the load F*.  compliance: the displacement is this factor
    times the double integral of P/distance.  free_inertia: m delta/(F* t0^2) of a free body whose impact has these
    scales.  even: two values, whether the gap is even in Y and whether it is even in X.  extent: how far the dry
    contact under F* reaches along X and along Y.  smaller: the smaller half width of that contact.
    """

    @property
    def hertz_load(self) -> float: ...

    @property
    def compliance(self) -> float: ...

    @property
    def free_inertia(self) -> float: ...

    @property
    def even(self) -> tuple[bool, bool]: ...

    @property
    def extent(self) -> tuple[float, float]: ...

    @property
    def smaller(self) -> float: ...

    def gap(self, X: Array, Y: Array) -> Array:
        """The gap between the undeformed surfaces when they just touch; X and Y broadcast."""
        ...

    def dry_pressure(self, load: float, X: Array, Y: Array) -> Array:
        """Hertz pressure under a load given in units of F*."""
        ...

    def dry_approach(self, load: float) -> float:
        """Hertz approach under a load given in units of F*."""
        ...

    def distance(self, X: Array, Y: Array) -> Array:
        """Distance from the centre in units of the dry contact's size under F*: one on its edge."""
        ...

    def far_flow(self, velocity: Array, entrainment: float, X: Array, Y: Array) -> Array:
        """P H^2/lambda_bar far out, where H is the rigid gap: exact by Reynolds' equation of constant viscosity."""
        ...


@dataclass(frozen=True)
class Circle:
    """A ball on a plane, or two bodies with the same reduced radius in all directions."""

    hertz_load: float = HERTZ_LOAD
    compliance: float = COMPLIANCE
    free_inertia: float = FREE_BALL_INERTIA
    even: tuple[bool, bool] = (True, True)
    extent: tuple[float, float] = (1.0, 1.0)
    smaller: float = 1.0

    def gap(self, X: Array, Y: Array) -> Array:
        """X^2/2 + Y^2/2."""
        return X**2 / 2 + Y**2 / 2

    def dry_pressure(self, load: float, X: Array, Y: Array) -> Array:
        """sqrt(A^2 - r^2) in a circle of radius A = load^(1/3)."""
        below = self.dry_approach(load) - (X**2 + Y**2)
        xp = below.__array_namespace__()
        return xp.sqrt(xp.maximum(below, 0.0))

    def dry_approach(self, load: float) -> float:
        """A^2."""
        return float((load ** (1 / 3)) ** 2)

    def distance(self, X: Array, Y: Array) -> Array:
        """r."""
        return (X**2 + Y**2) ** 0.5

    def far_flow(self, velocity: Array, entrainment: float, X: Array, Y: Array) -> Array:
        """V/4 - U X/5."""
        return velocity / 4 - entrainment * X / 5


CIRCLE = Circle()


@dataclass(frozen=True)
class Ellipse:
    """Two bodies with the reduced radii R_x and R_y along the principal axes x and y.

    radius_ratio: D = R_x/R_y, from 1/100 to 100.  angle: from the axis x to the direction of entrainment, in degrees.
    """

    radius_ratio: float
    angle: float = 0.0

    @cached_property
    def hertz(self) -> HertzEllipse:
        """The constants of the dry contact."""
        return hertz_ellipse(self.radius_ratio)

    @property
    def hertz_load(self) -> float:
        """2 pi/(3 kappa)."""
        return self.hertz.load

    @property
    def compliance(self) -> float:
        """(1 + D)/(2 pi E)."""
        return self.hertz.compliance

    @property
    def free_inertia(self) -> float:
        """(4/5) Delta_H, from m v0^2/2 = (2/5) F* delta* with the dry approach delta* = Delta_H b^2/R_x."""
        return FREE_BALL_INERTIA * self.hertz.approach

    @property
    def even(self) -> tuple[bool, bool]:
        """Even in both where the entrainment is along a principal axis."""
        along_an_axis = self.angle % RIGHT == 0
        return along_an_axis, along_an_axis

    @property
    def extent(self) -> tuple[float, float]:
        """Half the sides of the rectangle around the ellipse."""
        c, s = self._direction
        wide = 1.0 / self.hertz.kappa
        return hypot(c, s * wide), hypot(s, c * wide)

    @property
    def smaller(self) -> float:
        """The smaller half width."""
        return min(1.0, 1.0 / self.hertz.kappa)

    def gap(self, X: Array, Y: Array) -> Array:
        """x^2/2 + D y^2/2."""
        x, y = self._axes(X, Y)
        return x**2 / 2 + self.radius_ratio * y**2 / 2

    def dry_pressure(self, load: float, X: Array, Y: Array) -> Array:
        """sqrt(s^2 - x^2 - kappa^2 y^2) with s = load^(1/3)."""
        x, y = self._axes(X, Y)
        below = float(load ** (1 / 3)) ** 2 - (x**2 + (self.hertz.kappa * y) ** 2)
        xp = below.__array_namespace__()
        return xp.sqrt(xp.maximum(below, 0.0))

    def dry_approach(self, load: float) -> float:
        """Delta_H s^2."""
        return self.hertz.approach * float((load ** (1 / 3)) ** 2)

    def distance(self, X: Array, Y: Array) -> Array:
        """sqrt(x^2 + kappa^2 y^2)."""
        x, y = self._axes(X, Y)
        return (x**2 + (self.hertz.kappa * y) ** 2) ** 0.5

    def far_flow(self, velocity: Array, entrainment: float, X: Array, Y: Array) -> Array:
        """V/(2 (1 + D)) - U cos(angle) x/(3 + 2 D) - U sin(angle) D y/(2 + 3 D)."""
        (x, y), (c, s), D = self._axes(X, Y), self._direction, self.radius_ratio
        along = c * x / (3 + 2 * D) + s * D * y / (2 + 3 * D)
        return velocity / (2 * (1 + D)) - entrainment * along

    def _axes(self, X: Array, Y: Array) -> tuple[Array, Array]:
        """Coordinates along the principal axes."""
        c, s = self._direction
        return c * X - s * Y, s * X + c * Y

    @property
    def _direction(self) -> tuple[float, float]:
        """Cosine and sine of the angle, exact along the principal axes."""
        exact = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
        return exact.get(self.angle % 360.0) or (cos(radians(self.angle)), sin(radians(self.angle)))


def geometry(radius_ratio: float = 1.0, angle: float = 0.0) -> Geometry:
    """The geometry for R_x/R_y and the angle of entrainment (degrees): a circle, or an ellipse."""
    return CIRCLE if radius_ratio == 1.0 else Ellipse(radius_ratio, angle)
