"""The steady contact as results see it, and its temperatures with the section [thermal]: summary and warnings."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from ertel.case.case import Case
from ertel.case.sections import Inlet
from ertel.case.status import Status
from ertel.numerics.grid import Grid
from ertel.physics.thermal import AT_REST, INLET_FACTORS, SLOWEST, slow_excess
from ertel.results.variables import TEMPERATURES


class Heat(Protocol):
    """The heat of a contact.

    sliding: traction coefficients of the warm film along X and Y, in a/R.  peclet: numbers of both surfaces.
    iterations, converged: of the heat balance.
    """

    @property
    def inlet(self) -> Inlet: ...
    @property
    def sliding(self) -> Any: ...
    @property
    def peclet(self) -> Sequence[float]: ...
    @property
    def iterations(self) -> int: ...
    @property
    def converged(self) -> bool: ...


class SteadyGrid(Protocol):
    """The steady contact on one grid: what results take from it.

    residual, history: its maximum, at the end, and before the first and after each Newton iteration.  newton, krylov:
    iterations.  convolutions: in units of one on this grid.  outside: the load that the oil outside the grid carries.
    record: its numbers by name, those of `MEASURED`, `BUDGET` and `FRICTION`, and its work.  maps: `FIELDS` on the
    whole plane by name, with the section [thermal] also `TEMPERATURES`.  heat: None without it.
    """

    @property
    def grid(self) -> Grid: ...
    @property
    def status(self) -> Status: ...
    @property
    def residual(self) -> float: ...
    @property
    def history(self) -> Sequence[float]: ...
    @property
    def newton(self) -> int: ...
    @property
    def krylov(self) -> int: ...
    @property
    def convolutions(self) -> float: ...
    @property
    def outside(self) -> float: ...
    @property
    def record(self) -> Mapping[str, float]: ...
    @property
    def maps(self) -> Mapping[str, Any]: ...
    @property
    def heat(self) -> Heat | None: ...
    def measure(self) -> Mapping[str, float]: ...


def thermal_summary(case: Case, solution: SteadyGrid) -> dict[str, Any]:
    """The part `thermal` of a summary, in SI.

    L_t, phi_T: thermal loading, and the factor of the inlet formula.  h_c_m, h_min_m: the films with this factor.
    T_1_max_K, T_2_max_K, T_film_max_K: highest temperatures of the surfaces and of the film (mean across it).
    T_film_mean_K: that of the film on average over the contact, weighted with the pressure.  mu_sliding: traction
    coefficient of the warm film, with its inlet factor.  iterations, converged: of the heat balance, which has one
    solution, see `solvers.heat`.
    """
    heat, maps = solution.heat, solution.maps
    assert case.thermal is not None and case.scales is not None and heat is not None
    return {
        "inlet_factor": case.thermal.inlet_factor,
        "L_t": heat.inlet.L_t,
        "phi_T": heat.inlet.factor,
        "h_c_m": heat.inlet.factor * solution.record["H_c"] * case.scales.film,
        "h_min_m": heat.inlet.factor * solution.record["H_min"] * case.scales.film,
        **{f"{name}_max_K": float(np.max(maps[name])) for name in TEMPERATURES},
        "T_film_mean_K": float(np.average(maps["T_film"], weights=maps["P"])),
        "mu_sliding": float(heat.sliding[0]) * case.scales.a_over_R,
        "iterations": heat.iterations,
        "converged": heat.converged,
    }


def thermal_warnings(case: Case, heat: Heat) -> list[str]:
    """Warnings where the formulas for the temperatures are used outside their range; an empty list if they are not."""
    assert case.thermal is not None
    said, inlet = [], INLET_FACTORS[case.thermal.inlet_factor]
    if heat.inlet.L_t > inlet.largest_L_t:
        said.append(
            f"the inlet factor phi_T = {heat.inlet.factor:.3g} ({inlet.source}) is made for {inlet.valid}, and this "
            f"inlet has L_t = {heat.inlet.L_t:.3g}; its film is uncertain"
        )
    for number, peclet in enumerate(heat.peclet, 1):
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
    if not heat.converged:
        said.append(
            f"the heat balance did not converge in {heat.iterations} iterations: temperatures and thermal "
            "traction are not meaningful"
        )
    return said
