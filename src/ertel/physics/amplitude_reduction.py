"""Amplitude reduction A_d/A_i of the waviness A_i cos(2 pi x/Lx) cos(2 pi y/Ly) in a contact.

A_i is the initial amplitude and A_d the deformed amplitude.
"""

from math import exp, hypot

import numpy as np
from numpy.typing import ArrayLike, NDArray


def ratio_left(nabla2: ArrayLike, ratio: float = 1.0) -> NDArray[np.float64]:
    """A_d/A_i = 1/(1 + 0.15 n + 0.015 n^2) with n = f(r) nabla2, eq. (15), for cos(2 pi x/Lx) cos(2 pi y/Ly).

    f = exp(1 - 1/r) for r > 1 and f = 1 otherwise.  Isotropic and transverse waves (r = 0) therefore have the same
    curve, and longitudinal waves (infinite r) have f = e.

    Source of f: Venner CH, Lubrecht AA. Proc IMechE J 2005;219:303-312 (the paper's reference [20]).  f is taken from
    later citations; the original text was not checked.

    Parameters
    ----------
    nabla2 : array or number
        Eq. (16) with the shorter of the two wavelengths (see `Parameters.nabla2`), of any shape.
    ratio : float
        r = Lx/Ly with x in the rolling direction.

    Returns
    -------
    array
        A_d/A_i, of the shape of nabla2.

    Raises
    ------
    ValueError
        If the ratio is negative.
    """
    if not ratio >= 0:
        raise ValueError(f"ratio = {ratio}: must not be negative")
    n = np.asarray(nabla2, dtype=float) * (exp(1.0 - 1.0 / ratio) if ratio > 1 else 1.0)
    return np.asarray(1.0 / (1.0 + 0.15 * n + 0.015 * n**2))


def lambda_ratio(film: float, *sigma: float) -> float:
    """Film thickness over the rms roughness of both surfaces together, Lambda = h/sqrt(sigma_1^2 + sigma_2^2).

    Above about 3 the surfaces are apart, below 1 much of the load is on their summits: Tallian TE. On competing failure
    modes in rolling contact. ASLE Trans 1967;10:418-439.

    Parameters
    ----------
    film : float
        Film thickness of the smooth contact, mostly the minimum one.
    *sigma : float
        Rms roughness of the surfaces, in the same unit.

    Returns
    -------
    float
        Lambda.

    Raises
    ------
    ValueError
        A roughness is negative, or all are zero.
    """
    together = hypot(*sigma)
    if not (together > 0 and min(sigma) >= 0):
        raise ValueError(f"sigma = {', '.join(f'{each:g}' for each in sigma)}: must not be negative, and not all zero")
    return film / together
