"""Estimates of a physical contact without a run: film thickness by formula, mean shear stress of a Newtonian oil."""

from math import cbrt, inf

import numpy as np

from ertel.case.case import Case

LARGEST_NEWTONIAN_STRESS = 6e6  # Pa: the stress at which squalane begins to thin (Liu et al. 2023, see the library)
_PLACES = np.polynomial.legendre.leggauss(64)


def film(case: Case) -> float:
    """The expected central film thickness (m), an impact's by its scale; infinite for a dimensionless case."""
    return case.film_scale * case.scales.film if case.scales else inf


def largest_pressure(case: Case) -> float:
    """The maximum Hertz pressure (Pa) at the largest load, an impact's without oil; zero for a dimensionless case."""
    if case.scales is None:
        return 0.0
    load = 1.0 if case.starts_apart else case.motion.load.range(inf)[1]
    return float(case.scales.p_h * cbrt(load))


def newtonian_stress(case: Case) -> float:
    """The mean shear stress (Pa) that sliding gives a Newtonian oil; zero without sliding and for a dimensionless case.

    eta u_s/h with the film of a formula, and the mean over the contact of the viscosity at the Hertz pressure:

        2 integral from 0 to 1 of eta(p_h s) s ds,      p = p_h s at the radius sqrt(1 - s^2)
    """
    sliding = abs(case.motion.slide_to_roll) * max(map(abs, case.motion.entrainment.range(inf)))
    if case.scales is None or case.oil.eta0 is None or not sliding:
        return 0.0
    z, weight = _PLACES
    s = (1.0 + z) / 2.0
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        growth = float(np.sum(weight * s * case.oil.viscosity_law.viscosity(largest_pressure(case) * s)))
    stress = growth * case.oil.eta0 * sliding * case.scales.front_speed / film(case)
    return stress if stress >= 0.0 else inf  # beyond the pole of a modulus law
