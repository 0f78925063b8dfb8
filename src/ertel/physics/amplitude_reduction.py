"""Amplitude reduction of waviness: what a contact leaves of a wave A_i cos(2 pi x/Lx) cos(2 pi y/Ly), A_d/A_i."""

from math import exp

import numpy as np
from numpy.typing import ArrayLike, NDArray

LINE_NABLA = 0.6076  # nabla1/nabla2 of the same wavelength, contact half width and alpha_bar lambda_bar


def ratio_left(nabla2: ArrayLike, ratio: float = 1.0) -> NDArray[np.float64]:
    """A_d/A_i = 1/(1 + 0.15 n + 0.015 n^2), n = f(r) nabla2, eq. (15): waviness cos(2 pi x/Lx) cos(2 pi y/Ly).

    nabla2: eq. (16) with the shorter of both wavelengths, see `Parameters.nabla2`, of any shape.  ratio: r = Lx/Ly, x
    along the rolling; f = exp(1 - 1/r) above one, otherwise 1: isotropic and transverse waves (r = 0) have the same
    curve, longitudinal ones (infinite r) f = e.  f by Venner CH, Lubrecht AA. Proc IMechE J 2005;219:303-312 (the
    paper's [20]), as it is cited since, not seen in that text.
    """
    if not ratio >= 0:
        raise ValueError(f"ratio = {ratio}: must not be negative")
    n = np.asarray(nabla2, dtype=float) * (exp(1.0 - 1.0 / ratio) if ratio > 1 else 1.0)
    return np.asarray(1.0 / (1.0 + 0.15 * n + 0.015 * n**2))


def in_line_contact(nabla2: ArrayLike) -> NDArray[np.float64]:
    """A_d/A_i = 1/(1 + 0.125 nabla1 + 0.04 nabla1^2): transverse waviness in a line contact under pure rolling.

    Venner CH, Couhier F, Lubrecht AA, Greenwood JA. Proc Leeds-Lyon 1996 (1997:103-112) for nabla1 = (wavelength/b)
    M^{3/4}/L^{1/2} with the line contact's M and L; the coefficients as they are cited since, not seen in that text.
    There alpha_bar lambda_bar = (3 pi^2/8)/sqrt(2 pi) L/M^{3/2}, so nabla1 = 0.608 nabla2 = 1.215 (wavelength/b)/
    sqrt(alpha_bar lambda_bar).
    """
    n = LINE_NABLA * np.asarray(nabla2, dtype=float)
    return np.asarray(1.0 / (1.0 + 0.125 * n + 0.04 * n**2))
