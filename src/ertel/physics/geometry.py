"""The geometry of two touching bodies: their undeformed gap and the dimensionless constants of the dry Hertz contact.

A geometry is a record with the fields and methods of `Geometry`.  It is the model's only source of them.  Everything
is dimensionless: lengths along the surface in a, displacement and approach in a^2/R, pressure in p_h.
"""

from dataclasses import dataclass
from math import pi
from typing import Any, Protocol

Array = Any  # a NumPy or JAX array

HERTZ_LOAD = 2.0 * pi / 3.0  # double integral of sqrt(1 - r^2): the dry load that carries Delta = 1
COMPLIANCE = 2.0 / pi**2  # factor in eq. (3): the displacement is this times the double integral of P/distance
FREE_BALL_INERTIA = 4.0 / 5.0  # m delta*/(F* t0^2) in the scales of an impact: m v0^2/2 = (2/5) F* delta*


class Geometry(Protocol):
    """Two bodies near their point of contact.

    hertz_load: double integral of the dry pressure at Delta = 1.  compliance: the displacement is this factor times the
    double integral of P/distance.  even: two values, whether the gap is even in Y and whether it is even in X.
    """

    @property
    def hertz_load(self) -> float: ...

    @property
    def compliance(self) -> float: ...

    @property
    def even(self) -> tuple[bool, bool]: ...

    def gap(self, X: Array, Y: Array) -> Array:
        """The gap between the undeformed surfaces when they just touch; X and Y broadcast."""
        ...

    def dry_pressure(self, load: float, X: Array, Y: Array) -> Array:
        """Hertz pressure under a load given in units of F*."""
        ...

    def dry_approach(self, load: float) -> float:
        """Hertz approach under a load given in units of F*."""
        ...


@dataclass(frozen=True)
class Circle:
    """A ball on a plane, or two bodies with the same reduced radius in all directions."""

    hertz_load: float = HERTZ_LOAD
    compliance: float = COMPLIANCE
    even: tuple[bool, bool] = (True, True)

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


CIRCLE = Circle()
