"""The dry elliptical contact: its shape and its constants from the ratio of the radii of curvature.

The bodies have the reduced radii R_x and R_y along the principal axes x and y.  The contact is an ellipse with the half
width b along x and b/kappa along y.  Both coordinates are in units b, displacements in b^2/R_x, pressure in p_h, so the
gap of the undeformed surfaces is X^2/2 + D Y^2/2 with D = R_x/R_y.

E and F are the complete elliptic integrals of second and first kind with the modulus squared 1 - kappa^2.  They are
computed in Carlson's symmetric form, which holds on both sides of the circle.

Source: Johnson KL. Contact Mechanics. Cambridge 1985, section 4.2.  Scaling by b: Biboulet N, Houpert L. Proc IMechE J
2010;224:777-787.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import exp, log, pi

LEAST_RATIO, LARGEST_RATIO = 1 / 100, 100.0  # of the radii; beyond, the contact is a line in all but name


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
