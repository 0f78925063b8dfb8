"""The constants of the dry Hertz contact: of an ellipse, and of a line.  Dimensionless, scaled as in `geometry`.

E and F are the complete elliptic integrals of second and first kind with the modulus squared 1 - kappa^2.  They are
computed in Carlson's symmetric form, which holds on both sides of the circle.

Source: Johnson KL. Contact Mechanics. Cambridge 1985, section 4.2.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import exp, log, pi, sqrt

import numpy as np

from ertel.physics import hertz
from ertel.physics.units import require_positive

LINE_LOAD = pi / 2.0  # integral of sqrt(1 - x^2): the dry load of a line contact
_z, _w = np.polynomial.legendre.leggauss(64)
PLACES = (1.0 + _z) / 2.0, _w / 2.0  # from 0 to 1, and weights
FREE_BALL_INERTIA = 4.0 / 5.0  # m delta*/(F* t0^2) in the scales of an impact: m v0^2/2 = (2/5) F* delta*
LEAST_RATIO, LARGEST_RATIO = 1 / 100, 100.0  # of the radii; beyond, the contact is a line in all but name
HERTZ_LOAD = 2.0 * pi / 3.0  # double integral of sqrt(1 - r^2): the dry load that carries Delta = 1 on a circle


@dataclass(frozen=True)
class HertzEllipse:
    """The constants of a dry elliptical contact, all dimensionless; `hertz_ellipse` makes it.

    radius_ratio: D = R_x/R_y.  kappa: half width along x over half width along y; below one where the contact is wide
    across x.  E, F: elliptic integrals.  reach and across are those of `HertzLine`, without a meaning here.
    """

    radius_ratio: float
    kappa: float
    E: float
    F: float

    reach = across = 1.0

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
    def wide(self) -> float:
        """The half width along y in units b."""
        return 1.0 / self.kappa

    @property
    def inertia(self) -> float:
        """m delta/(F* t0^2) of a free body whose impact has these scales: m v0^2/2 = (2/5) F* delta*."""
        return FREE_BALL_INERTIA * self.approach

    @property
    def contact_time(self) -> float:
        """The duration of the dry impact in t0 = b^2/(R_x v0)."""
        return hertz.CONTACT_TIME * self.approach

    def front_speed(self, A: float) -> float:
        """The speed dA/dT of the edge of the dry impact, where it is at A."""
        return float(hertz.front_speed(A)) / self.approach


CIRCULAR = HertzEllipse(1.0, 1.0, pi / 2, pi / 2)


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
        return CIRCULAR
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
class HertzLine:
    """The constants of a dry line contact, as those of `HertzEllipse`; loads are per length.

    reach: Lambda, the length of the contact over its half width b.  A half plane has no finite approach: that of a
    contact of finite length is taken, delta = (b^2/R) (1/4 + ln(2 Lambda)/2).  In the middle of a line load of length l
    on a half space the displacement is that of a half plane which is at rest at the distance l.

    Source: Lundberg G. Elastische Beruehrung zweier Halbraeume. Forsch Ing 1939;10:201.
    """

    reach: float

    radius_ratio = 0.0
    beta = 4.0 / pi
    compliance = 1.0 / pi
    load = LINE_LOAD
    kappa = 0.0  # the half width over an infinite one

    def __post_init__(self) -> None:
        require_positive(length_ratio=self.reach)

    @property
    def across(self) -> float:
        """The length in units b: areas, loads and amounts of oil belong to all of it."""
        return self.reach

    @property
    def wide(self) -> float:
        """Half of the length in units b."""
        return self.reach / 2.0

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


DryContact = HertzEllipse | HertzLine


def dry_contact(radius_ratio: float, length_ratio: float = 100.0) -> DryContact:
    """The constants for D = R_x/R_y; of a line for 0, with its length over its half width."""
    return HertzLine(length_ratio) if radius_ratio == 0.0 else hertz_ellipse(radius_ratio)
