"""Waviness at rest under a sliding oil: its ripples in the middle of a contact, computed and by Hooke's linear theory.

The ripple of the film over a fine wave exp(i k X) of small height has three parts: a wave of the same length, which
Hooke's theory describes; waves that start in the inlet and ride with the oil, here with the frequency zero; and slow
changes of the whole contact.  The first is told from the others by its length.
"""

from math import inf, pi
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from ertel.case.case import Case
from ertel.physics.surfaces import Feature, Waviness

STEP = 1e-3  # relative, of the pressure, for the bulk modulus
NEAR = 1e-5  # relative, of the stress, for its slope


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


def pair(wavelength: float) -> list[list[Feature]]:
    """Ridges across the flow on surface 1, as a cosine and a sine of unit height: for `respond_in_rolling`."""
    return [[Feature(Waviness(1.0, wavelength, phase_x=phase), 1)] for phase in (0.0, -pi / 2)]


def ripples(data: xr.Dataset, first: int, wavelength: float) -> SlidingWaviness:
    """The ripples of clearance (a share of the height of waves at rest) and pressure (p_h R/a^2) at the centre.

    data: of `respond_in_rolling`, steady, with the `pair` whose cosine is the wave number `first`.  wavelength: in a.
    By least squares beside what is slow, as it varies with X.
    """
    line = data.sel(Y=0.0, method="nearest").sel(X=slice(-wavelength, wavelength))
    x = line["X"].values
    wave, slow = np.exp(2j * pi / wavelength * x), np.ones_like(x)
    parts = np.stack([wave, x * wave, slow, x * slow], axis=1)
    real = [(line[f"{name}_amplitude"] * np.cos(line[f"{name}_phase"])).values for name in ("dH", "dP")]
    clearance, pressure = (np.linalg.lstsq(parts, each[first] + 1j * each[first + 1])[0][0] for each in real)
    return SlidingWaviness(complex(-clearance), complex(-pressure))


class Centre(NamedTuple):
    """What Hooke's theory takes from the middle of a contact."""

    film: float  # m
    pressure: float  # Pa
    viscosity: float  # d(stress)/d(shear rate), Pa s
    newtonian: float  # eta at that pressure, Pa s
    bulk_modulus: float  # of the oil, Pa
    lag: float  # speed of the waviness, which is at rest, minus the oil's mean speed, m/s


def centre(case: Case, data: xr.Dataset) -> Centre:
    """The middle of the steady film of a case in SI.  Raises ValueError unless surface 1 is at rest."""
    scales, speed = case.scales, case.contact.mean_speed
    if scales is None or speed is None or case.motion.slide_to_roll != -2.0:
        raise ValueError(f"slide_to_roll = {case.motion.slide_to_roll}: must be -2, surface 1 at rest, in SI")
    at = data.sel(X=0.0, Y=0.0, method="nearest")
    h, p = float(at["H"]) * scales.film, float(at["P"]) * scales.p_h
    eta = (case.oil.eta0 or 0.0) * float(case.oil.viscosity_law.viscosity(p))
    law, newtonian = case.oil.fluidity_law, 2.0 * eta * abs(speed) / h
    stress = brentq(lambda tau: float(law.fluidity(tau, p)) * tau - newtonian, 0.0, newtonian, rtol=1e-12)
    less, same, more = (float(law.fluidity(stress * (1.0 + change), p)) for change in (-NEAR, 0.0, NEAR))
    slope = same + (more - less) / (2.0 * NEAR)  # d(fluidity * stress)/d(stress): small gradients along the sliding
    less, more = (float(case.oil.density_law.density(p * (1.0 + sign * STEP))) for sign in (-1.0, 1.0))
    bulk_modulus = (more + less) * STEP * p / (more - less) if more > less else inf  # rho dp/drho
    return Centre(h, p, eta / slope, eta, bulk_modulus, -speed)


def hooke(case: Case, at: Centre, wavelength: float) -> SlidingWaviness:
    """Hooke's ripples in the units of `ripples`."""
    assert case.scales is not None
    length, E_prime = wavelength * case.scales.a, case.scales.E_prime
    found = hooke_waviness(length, at.film, E_prime, at.viscosity, at.lag, at.bulk_modulus)
    return SlidingWaviness(found.clearance, found.pressure * case.scales.film / case.scales.p_h)


def hooke_number(case: Case, at: Centre, wavelength: float) -> float:
    """Hooke's Q of `hooke_waviness`, without its sign."""
    assert case.scales is not None
    length = wavelength * case.scales.a
    return 12 / pi**2 * at.viscosity * abs(at.lag) * length**2 / (case.scales.E_prime * at.film**3)
