"""The dry contact: static Hertz contact and impact of an elastic ball.

Everything is dimensionless: lengths along the surface in a, pressure in p_h, normal displacement and approach in
delta* = a^2/R, time T in t0 = delta*/v0, loads in F* (see `scales`).  a, p_h, delta*, F* belong to the dry impact at
maximum approach.  All functions take numbers or arrays of any shape and return the same shape.

At any time in the dry impact the contact is Hertzian with radius A = a(t)/a* and approach Delta = A^2.  The ball's
energy gives (dDelta/dT)^2 = 1 - Delta^{5/2}.  With x = Delta^{5/2} the time from first touch is an incomplete beta
function, T = (2/5) B(x; 2/5, 1/2).  SciPy also inverts it, so the exact motion needs no integration in time.  SciPy is
imported inside the functions that need it, because the scales of an impact do not need it and its import is slow.
"""

from math import gamma, pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ertel.physics.units import require_positive

Values = NDArray[np.float64]

CONTACT_TIME = 0.8 * gamma(0.4) * gamma(0.5) / gamma(0.9)  # 2.943275 t0: dry impact from first touch to separation
HALF_CONTACT_TIME = CONTACT_TIME / 2  # from first touch to maximum approach


def pressure(r: ArrayLike, A: float = 1.0) -> Values:
    """Hertzian pressure P = sqrt(A^2 - r^2), zero outside the contact of radius A."""
    require_positive(A=A)
    return _root(A**2 - np.square(np.asarray(r, dtype=float)))


def displacement(r: ArrayLike, A: float = 1.0) -> Values:
    """Elastic displacement of the surfaces under the Hertzian pressure: the double integral of eq. (3) for `pressure`.

    It is A^2 - r^2/2 inside the contact and (A^2/pi) [(2 - s^2) asin(1/s) + sqrt(s^2 - 1)] outside, with s = r/A
    (Johnson, Contact Mechanics, 1985, section 3.4).
    """
    require_positive(A=A)
    s = np.abs(np.asarray(r, dtype=float)) / A
    outer = np.maximum(s, 1.0)
    outside = ((2 - outer**2) * np.arcsin(1 / outer) + np.sqrt(outer**2 - 1)) / pi
    return np.asarray(A**2 * np.where(s < 1, 1 - s**2 / 2, outside))


def gap(r: ArrayLike, A: float = 1.0) -> Values:
    """Dry gap H = -A^2 + r^2/2 + displacement: zero inside the contact, positive outside."""
    require_positive(A=A)
    s = np.maximum(np.abs(np.asarray(r, dtype=float)) / A, 1.0)
    return np.asarray(A**2 / pi * ((s**2 - 2) * np.arccos(1 / s) + np.sqrt(s**2 - 1)))


def load(approach: ArrayLike) -> Values:
    """Load F = Delta^{3/2} in units of the maximum load F*; zero while the bodies are separated (Delta < 0)."""
    return _root(approach) ** 3


def time_at(approach: ArrayLike) -> Values:
    """Time T from first touch at which the approaching ball reaches Delta <= 1; nan for Delta > 1, never reached.

    T = int_0^Delta dy/sqrt(1 - y^{5/2}).  Before first touch (Delta < 0) the ball moves freely and T = Delta.
    """
    from scipy.special import betainc

    Delta = np.asarray(approach, dtype=float)
    x = np.maximum(Delta, 0.0) ** 2.5
    return np.where(Delta < 0, Delta, HALF_CONTACT_TIME * betainc(0.4, 0.5, np.where(x <= 1, x, np.nan)))


def approach(T: ArrayLike) -> Values:
    """Exact approach Delta(T) of the dry impact, T from first touch; |dDelta/dT| = 1 before and after contact."""
    from scipy.special import betaincinv

    T = np.asarray(T, dtype=float)
    touched = np.minimum(T, CONTACT_TIME - T)  # the rebound mirrors the approach
    x: Values = betaincinv(0.4, 0.5, np.clip(touched / HALF_CONTACT_TIME, 0.0, 1.0))
    return np.where(touched < 0, touched, x**0.4)


def velocity(T: ArrayLike) -> Values:
    """Exact dDelta/dT of the dry impact, T from first touch: 1 before, 0 at maximum approach, -1 after separation."""
    from scipy.special import betaincinv

    early = 1 - np.asarray(T, dtype=float) / HALF_CONTACT_TIME
    # 1 - Delta^{5/2} by the mirrored beta function: 1 - approach(T)**2.5 loses digits near maximum approach
    energy = betaincinv(0.5, 0.4, np.minimum(np.abs(early), 1.0))
    return np.asarray(np.sign(early) * np.sqrt(energy))


def contact_radius(T: ArrayLike) -> Values:
    """Exact contact radius A(T) = sqrt(Delta) of the dry impact, T from first touch; zero while separated."""
    return _root(approach(T))


def front_speed(A: ArrayLike) -> Values:
    """Exact speed dA/dT = sqrt(1 - A^5)/(2 A) of the contact edge when it passes A (units a*/t0).

    It goes to infinity as 1/(2A) at first touch and tends to (sqrt(5)/2) sqrt(1 - A) near maximum approach.  It is nan
    outside 0 <= A <= 1, which the edge never reaches.
    """
    A = np.asarray(A, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(A >= 0, np.sqrt(1 - A**5) / (2 * A), np.nan)


def _root(value: ArrayLike) -> Values:
    return np.asarray(np.sqrt(np.maximum(value, 0.0)))
