"""Closed forms with which tests and validation scripts compare: sheared films, traction, temperatures, Moes' scales.

Symbols of Eyring's flow, in one dimension: B = eta (u1 - u2)/(h tau0), sliding; Sigma = h |dp/dx|/(2 tau0), pressure
gradient.  The exact flow in two dimensions, of any law, is in `ertel.equations.shear`.
"""

from math import asinh, log, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ertel.physics.dry_contact import hertz_ellipse
from ertel.physics.scales import Parameters
from ertel.physics.thermal import Solid, response

Real = NDArray[np.float64]

# -- the flow of an oil of Eyring's kind ------------------------------------------------------------------------------


def eyring_stress(B: ArrayLike, Sigma: ArrayLike) -> Real:
    """Mid-plane stress over tau0 with the gradient along the sliding: asinh(B Sigma/sinh Sigma).

    Conry TF, Wang S, Cusano C. J Tribol 1987;109:648-654.
    """
    sliding, gradient = np.asarray(B, dtype=float), np.asarray(Sigma, dtype=float)
    return np.asarray(np.arcsinh(sliding / _sinh_ratio(gradient)))


def eyring_flow_factor(B: ArrayLike, Sigma: ArrayLike) -> Real:
    """The factor of the Poiseuille flux h^3 |dp/dx|/(12 eta), with the gradient along the sliding.

    3 (Sigma cosh Sigma - sinh Sigma)/Sigma^3 (1 + B^2 Sigma^2/sinh^2 Sigma)^{1/2}; source as `eyring_stress`.
    """
    sliding, gradient = np.asarray(B, dtype=float), np.asarray(Sigma, dtype=float)
    large = np.maximum(gradient, 0.1)
    closed = 3.0 * (large * np.cosh(large) - np.sinh(large)) / large**3
    series = 1.0 + gradient**2 / 10.0 + gradient**4 / 280.0 + gradient**6 / 15120.0  # the difference would be lost
    rest = np.where(gradient > 0.1, closed, series)
    return np.asarray(rest * np.sqrt(1.0 + (sliding / _sinh_ratio(gradient)) ** 2))


def _sinh_ratio(x: Real) -> Real:
    """sinh(x)/x."""
    positive = np.maximum(np.abs(x), 1e-30)
    return np.asarray(np.sinh(positive) / positive)


# -- traction: an Eyring oil in a film of uniform thickness, and the formula of Arana et al. --------------------------


def hertz_mean_stress(S_c: float, alpha_p_h: float) -> float:
    """Mean of tau/tau0 over a Hertz contact with a film of uniform thickness, Eyring's and Barus' laws.

    The mean of asinh(S_c exp(alpha (p - p_mean))), p_mean = 2 p_h/3, over the circle or ellipse: p = p_h s with the
    weight 2 s ds.  S_c = eta0 |u1 - u2|/(h tau0) exp(alpha p_mean).  mu is this times tau0/p_mean.
    """
    node, weight = np.polynomial.legendre.leggauss(80)
    s = 0.5 * (node + 1.0)
    stress = np.arcsinh(S_c * np.exp(alpha_p_h * (s - 2.0 / 3.0)))
    return float(np.sum(weight * s * stress))


def arana_traction(limit: float, alpha: float, p_mean: float, viscosity: float, sliding: float, film: float) -> float:
    """mu = min{(2 Lambda/(alpha p_mean)) asinh[eta alpha V_s/(2 Lambda h)], Lambda}: Eyring's law with a limit.

    Arana A, Larranaga J, Ulacia I, et al. Proc Inst Mech Eng J 2019;233:303-316.  Their oils are `ertel.oils`'
    naphthenic-100, mineral-100 and pao-100.

    limit: Lambda.  alpha: ln(eta(p)/eta(0))/p at p_mean, 1/Pa.  p_mean in Pa.  viscosity: eta in Pa s at that pressure
    and the film's temperature.  sliding: V_s = |u1 - u2| in m/s.  film: central film phi_T h_c in m, with inlet shear
    heating (`ertel.physics.thermal`).
    """
    eyring = 2.0 * limit / alpha
    return min(eyring / p_mean * asinh(viscosity * sliding / (film * eyring)), limit)


# -- temperatures in the film -----------------------------------------------------------------------------------------


def mean_rise(stress: float, sliding: float, film: float, conductivity: float) -> float:
    """Mean rise across the film above the mean of its walls, tau |u1 - u2| h/(12 k), in K.

    Conduction across the film only, heat released uniformly.  stress in Pa, sliding in m/s, film in m; also arrays.
    """
    return stress * sliding * film / (12.0 * conductivity)


def flash_temperature(heat: Real, solid: Solid, speed: float, spacing: float) -> Real:
    """Rise of a moving surface in K.  heat: into the body, W/m^2, along X last; the rest as in `thermal.response`."""
    return np.asarray(heat @ response(solid, speed, heat.shape[-1], spacing).T)


class Nahme(NamedTuple):
    """A sheared film that heats itself: largest beta (T - T_wall), and effective viscosity over that at the walls."""

    largest_rise: float
    viscosity: float


def nahme(number: float) -> Nahme:
    """Shear between walls of one temperature with eta = eta_wall exp(-beta (T - T_wall)), in closed form.

    number: Na = eta_wall beta (u1 - u2)^2/k.  theta_max = ln(1 + Na/8); tau h/(eta_wall |u1 - u2|) = asinh(s)/(s (1 +
    s^2)^{1/2}), s^2 = Na/8.  Nahme R. Ing Arch 1940;11:191-209.
    """
    s = sqrt(number / 8.0)
    return Nahme(log(1.0 + number / 8.0), asinh(s) / (s * sqrt(1.0 + s**2)) if s > 0 else 1.0)


# -- Moes' parameters -------------------------------------------------------------------------------------------------


def parameters_from_ugw(U: float, G: float, W: float, radius_ratio: float = 1.0) -> Parameters:
    """lambda_bar and alpha_bar from Hamrock and Dowson's parameters by Moes' M = W (2U)^{-3/4}, L = G (2U)^{1/4}."""
    return Parameters.from_moes(W * (2 * U) ** -0.75, G * (2 * U) ** 0.25, hertz_ellipse(radius_ratio))
