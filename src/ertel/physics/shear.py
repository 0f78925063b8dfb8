"""Closed forms for the flow of an oil of Eyring's kind, and the law of small pressure gradients for any oil.

Symbols: B = eta (u1 - u2)/(h tau0), sliding; Sigma = h |dp/dx|/(2 tau0), pressure gradient; one dimension.  The exact
flow in two dimensions, of any law, is in `ertel.equations.shear`; these serve to check it.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ertel.physics.fluidity import Array, Fluidity

Real = NDArray[np.float64]


def eyring_stress(B: ArrayLike, Sigma: ArrayLike) -> Real:
    """Mid-plane stress over tau0 with the gradient along the sliding: asinh(B Sigma/sinh Sigma).

    Conry TF, Wang S, Cusano C. A Reynolds-Eyring equation for elastohydrodynamic lubrication in line contacts. J Tribol
    1987;109:648-654.

    Examples
    --------
    >>> round(float(eyring_stress(10, 2)), 6)
    2.408634
    """
    sliding, gradient = np.asarray(B, dtype=float), np.asarray(Sigma, dtype=float)
    return np.asarray(np.arcsinh(sliding / _sinh_ratio(gradient)))


def eyring_flow_factor(B: ArrayLike, Sigma: ArrayLike) -> Real:
    """The factor of the Poiseuille flux h^3 |dp/dx|/(12 eta), with the gradient along the sliding.

    3 (Sigma cosh Sigma - sinh Sigma)/Sigma^3 (1 + B^2 Sigma^2/sinh^2 Sigma)^{1/2}; source as `eyring_stress`.

    Examples
    --------
    >>> round(float(eyring_flow_factor(10, 2)), 6)
    8.191172
    """
    sliding, gradient = np.asarray(B, dtype=float), np.asarray(Sigma, dtype=float)
    large = np.maximum(gradient, 0.1)
    closed = 3.0 * (large * np.cosh(large) - np.sinh(large)) / large**3
    series = 1.0 + gradient**2 / 10.0 + gradient**4 / 280.0 + gradient**6 / 15120.0  # the difference would be lost
    rest = np.where(gradient > 0.1, closed, series)
    return np.asarray(rest * np.sqrt(1.0 + (sliding / _sinh_ratio(gradient)) ** 2))


def small_gradient_mobility(law: Fluidity, stress: Array, pressure: Array, step: float = 1e-5) -> tuple[Array, Array]:
    """Flow factors along and across the sliding where h |grad p| is far below the mid-plane stress.

    Along: d(phi tau)/dtau; across: phi.  For Eyring's law cosh(x) and sinh(x)/x with x = tau_m/tau0 (Ehret P, Dowson D,
    Taylor CM. Proc R Soc Lond A 1998;454:763-787).  In pure rolling both are 1: thinning by the gradient is missing.
    stress: |tau_m| > 0 in Pa, of any shape.  step: relative, of the difference that gives the slope.
    """
    less, more = (law.fluidity(stress * (1.0 + sign * step), pressure) for sign in (-1.0, 1.0))
    across = law.fluidity(stress, pressure)
    return across + (more - less) / (2.0 * step), across


def _sinh_ratio(x: Real) -> Real:
    """sinh(x)/x."""
    positive = np.maximum(np.abs(x), 1e-30)
    return np.asarray(np.sinh(positive) / positive)
