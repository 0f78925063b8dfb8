"""What a steady run with the section [thermal] says of its temperatures: maps, a part of the summary, warnings."""

from typing import Any

import numpy as np

from ertel.case.case import Case
from ertel.equations import heat
from ertel.equations.heat import Heated
from ertel.equations.state import GridSolution
from ertel.physics.flash import AT_REST, SLOWEST, slow_excess
from ertel.physics.thermal import INLET_FACTORS
from ertel.results.variables import TEMPERATURES


def temperature_maps(case: Case, s: GridSolution | None, nothing: np.ndarray) -> dict[str, np.ndarray]:
    """T_1, T_2 and T_film in K on the whole plane of the grid; `nothing` for each where there is no solution yet.

    Empty without the section.
    """
    if case.thermal is None:
        return {}
    if s is None:
        return dict.fromkeys(TEMPERATURES, nothing)
    found = heat.of_solution(case, s)
    return {name: np.asarray(s.whole(getattr(found, name))) for name in TEMPERATURES}


def thermal_summary(case: Case, s: GridSolution) -> tuple[dict[str, Any], list[str]]:
    """The part `thermal` of a summary, in SI, and its warnings; both empty without the section.

    L_t, phi_T: thermal loading, and the factor of the inlet formula.  h_c_m, h_min_m: the films with this factor.
    T_1_max_K, T_2_max_K, T_film_max_K: highest temperatures of the surfaces and of the film (mean across it).
    T_film_mean_K: that of the film on average over the contact, weighted with the pressure.  mu_sliding: traction
    coefficient of the warm film, with its inlet factor.  iterations, converged: of the heat balance, which has one
    solution, see `physics.warming`.
    """
    if case.thermal is None or case.scales is None:
        return {}, []
    found, films = heat.of_solution(case, s), s.measure()
    weight = np.asarray(s.whole(s.P))
    content = {
        "inlet_factor": case.thermal.inlet_factor,
        "L_t": found.inlet.L_t,
        "phi_T": found.inlet.factor,
        "h_c_m": found.inlet.factor * films["H_c"] * case.scales.film,
        "h_min_m": found.inlet.factor * films["H_min"] * case.scales.film,
        **{f"{name}_max_K": float(np.max(getattr(found, name))) for name in TEMPERATURES},
        "T_film_mean_K": float(np.average(s.whole(found.T_film), weights=weight)),
        "mu_sliding": float(found.sliding[0]) * case.scales.a_over_R,
        "iterations": found.iterations,
        "converged": found.converged,
    }
    return content, thermal_warnings(case, found)


def thermal_warnings(case: Case, found: Heated) -> list[str]:
    """Where the formulas for the temperatures are used outside their range; an empty list if they are not."""
    assert case.thermal is not None
    said, inlet = [], INLET_FACTORS[case.thermal.inlet_factor]
    if found.inlet.L_t > inlet.largest_L_t:
        said.append(
            f"the inlet factor phi_T = {found.inlet.factor:.3g} ({inlet.source}) is made for {inlet.valid}, and this "
            f"inlet has L_t = {found.inlet.L_t:.3g}; its film is uncertain"
        )
    for number, peclet in enumerate(found.peclet, 1):
        if slow_excess(peclet) > slow_excess(SLOWEST):
            said.append(
                f"surface {number} moves slowly, with a Peclet number of {peclet:.2g}: "
                + (
                    "it counts as at rest"
                    if peclet < AT_REST
                    else f"below {SLOWEST:g} heat also flows along the surface"
                )
                + f", and its temperature rise is about {slow_excess(peclet):.0%} too high"
            )
    if not found.converged:
        said.append(
            f"the heat balance did not converge in {found.iterations} iterations: temperatures and thermal "
            "traction mean nothing"
        )
    return said
