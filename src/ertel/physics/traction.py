"""Traction: formulas to compare with.  The traction of a computed film is in `ertel.equations.friction`."""

from math import asinh, log, pi
from typing import NamedTuple

import numpy as np

from ertel.physics.checks import require_positive

# -- an Eyring oil in a film of uniform thickness ---------------------------------------------------------------------


def hertz_mean_stress(S_c: float, alpha_p_h: float) -> float:
    """Mean of tau/tau0 over a Hertz contact with a film of uniform thickness, Eyring's and Barus' laws.

    The mean of asinh(S_c exp(alpha (p - p_mean))), p_mean = 2 p_h/3, over the circle or ellipse: p = p_h s with the
    weight 2 s ds.  S_c = eta0 |u1 - u2|/(h tau0) exp(alpha p_mean).  mu is this times tau0/p_mean.

    Examples
    --------
    >>> round(hertz_mean_stress(1.0, 20.0), 4)
    2.4266
    """
    require_positive("S_c", S_c)
    node, weight = np.polynomial.legendre.leggauss(80)
    s = 0.5 * (node + 1.0)
    stress = np.arcsinh(S_c * np.exp(alpha_p_h * (s - 2.0 / 3.0)))
    return float(np.sum(weight * s * stress))


def uniform_film_traction(alpha: float, tau0: float, p_mean: float, newtonian: float) -> float:
    """mu = alpha tau0 + (tau0/p_mean) ln(2 eta0 |u1 - u2|/(h tau0)): the limit of `hertz_mean_stress` for S_c >> 1.

    newtonian: eta0 |u1 - u2|/h, Pa.  Johnson KL, Tevaarwerk JL. Proc R Soc Lond A 1977;356:215-236, in form.
    """
    return alpha * tau0 + tau0 / p_mean * log(2.0 * newtonian / tau0)


# -- Arana et al. -----------------------------------------------------------------------------------------------------


def arana_traction(limit: float, alpha: float, p_mean: float, viscosity: float, sliding: float, film: float) -> float:
    """mu = min{(2 Lambda/(alpha p_mean)) asinh[eta alpha V_s/(2 Lambda h)], Lambda}.

    It is Eyring's law with tau_E = 2 Lambda/alpha and the limit Lambda p_mean.  Arana A, Larranaga J, Ulacia I, et al.
    Proc Inst Mech Eng J 2019;233:303-316.  Their oils are `ertel.oils`' naphthenic-100, mineral-100 and pao-100.

    limit: Lambda.  alpha: ln(eta(p)/eta(0))/p at p_mean, 1/Pa.  p_mean in Pa.  viscosity: eta in Pa s at that pressure
    and the film's temperature.  sliding: V_s = |u1 - u2| in m/s.  film: central film phi_T h_c in m, with inlet shear
    heating (`ertel.physics.thermal`).
    """
    eyring = 2.0 * limit / alpha
    return min(eyring / p_mean * asinh(viscosity * sliding / (film * eyring)), limit)


# -- waviness in a sliding contact ------------------------------------------------------------------------------------


class SlidingWaviness(NamedTuple):
    """Ripples in a sliding contact over those of the undeformed surface, complex: modulus and phase."""

    clearance: complex
    pressure: complex


def hooke_waviness(
    wavelength: float, film: float, E_prime: float, effective_viscosity: float, lag: float, bulk_modulus: float
) -> SlidingWaviness:
    """Ripples of clearance and of pressure (Pa/m) under sliding over the amplitude of the waviness: linear theory.

        clearance = (1 - i C Q)/(1 - i Q - i C Q),    pressure = (w E'/4) i Q/(1 - i Q - i C Q)
        Q = (12/pi^2) eta_eff (v - u) wavelength^2/(E' h^3),    C = h E' w/(4 B),    w = 2 pi/wavelength

    Hooke CJ. Proc Inst Mech Eng J 2006;220:259-275.  effective_viscosity: dtau/d(shear rate) in the contact, for
    Eyring's law eta/(1 + B^2)^{1/2}, Pa s.  lag: v - u, speed of the waviness minus mean speed of the oil, m/s.
    bulk_modulus: of the oil, B in Pa (infinite: an oil that is not compressible).
    """
    w = 2.0 * pi / wavelength
    Q = 12.0 / pi**2 * effective_viscosity * lag * wavelength**2 / (E_prime * film**3)
    C = film * E_prime * w / (4.0 * bulk_modulus)
    below = 1.0 - 1j * Q - 1j * C * Q
    return SlidingWaviness((1.0 - 1j * C * Q) / below, 0.25 * w * E_prime * 1j * Q / below)
