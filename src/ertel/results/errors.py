"""The error of a run in grid, time and domain together, from runs on the half grid that differ in one of them.

`comparisons` gives the cases of these runs; their summaries complete that of the run itself.  Together they cost about
1.2 times the run: 1/4 of its nodes, 1/4 in 1.4 times as many steps, and 9/16.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import hypot
from typing import Any

from ertel.case import definition
from ertel.case.case import Case
from ertel.case.sections import Solver, Time
from ertel.numerics.grid import allowed_nodes, extrapolate
from ertel.physics.units import Quantity
from ertel.results.summary import with_si
from ertel.results.variables import FILMS

SMALLER_STEPS = 0.5**0.5  # of the run for the error in time: half the error of second order
WIDER_DOMAIN = 1.5  # of the run for the error of the domain


# -- the runs ---------------------------------------------------------------------------------------------------------


def comparisons(case: Case) -> Mapping[str, Case]:
    """The cases by the part of the error that they tell: "grid", "time" (not if steady), "domain"."""
    half = case.on_half_grid()
    cases = {"grid": half, "domain": replace(half, solver=wider(half.solver))}
    if case.time is not None:
        cases["time"] = replace(half, time=in_smaller_steps(case.time))
    return cases


def in_smaller_steps(time: Time) -> Time:
    """Steps smaller by sqrt(1/2); of those that a tolerance controls, the size goes as its cube root."""
    step = time.step
    if step is None:
        return replace(time, tolerance=time.tolerance * SMALLER_STEPS**3)
    smaller = replace(step, value=SMALLER_STEPS * step.value) if isinstance(step, Quantity) else SMALLER_STEPS * step
    return replace(time, step=smaller)


def wider(solver: Solver) -> Solver:
    """The domain 1.5 times as wide, at the same spacing: as near as grids allow."""
    if solver.method == "radial":
        width = WIDER_DOMAIN * solver.half_width
        cells = (solver.nodes - 1) * definition.extent(width) / definition.extent(solver.half_width)
        return replace(solver, half_width=width, nodes=round(cells) + 1)
    spacing = 2 * solver.half_width / (solver.nodes - 1)
    nodes = allowed_nodes(WIDER_DOMAIN * (solver.nodes - 1) + 1)
    inlet = solver.inlet and solver.inlet + spacing * ((nodes - solver.nodes) * solver.inlet // (2 * solver.half_width))
    across = solver.half_width_y and WIDER_DOMAIN * solver.half_width_y
    return replace(solver, nodes=nodes, half_width=spacing * (nodes - 1) / 2, half_width_y=across, inlet=inlet)


# -- the error --------------------------------------------------------------------------------------------------------


def error_estimate(fine: float, others: Mapping[str, float]) -> dict[str, Any]:
    """The error of a value from the same value of other runs: the size of its parts, and the value with them added.

    grid: on the half grid.  time: there in smaller steps, by sqrt(1/2).  domain: there on a domain 1.5 times as wide.
    The last two are left out where they do not apply.  The error is of second order in the spacing and in the step, and
    of third order in 1/width: the oil outside carries a share 1/width^2 of the load, and its far field misses 1/width.
    """
    half = others["grid"]
    parts = {"grid": extrapolate(half, fine).extrapolated - fine}
    if "time" in others:
        parts["time"] = (others["time"] - half) / (1 - SMALLER_STEPS**2)
    if "domain" in others:
        parts["domain"] = (others["domain"] - half) / (1 - WIDER_DOMAIN**-3)
    dominant = max(parts, key=lambda name: abs(parts[name]))
    error, extrapolated = hypot(*parts.values()), fine + sum(parts.values())
    return {"value": fine, "error": error, "extrapolated": extrapolated, **parts, "dominant": dominant}


def with_error(case: Case, fine: Mapping[str, Any], others: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The summary of a run with the errors of its films that other runs tell, and their parts under `error_estimate`.

    Those of an impact hold at maximum approach, and there is that of Delta too; `error_estimate` is None where one of
    the runs did not reach it.

    Parameters
    ----------
    case : Case
        The case of the run.
    fine : mapping
        The summary of the run.
    others : mapping
        The summaries of the other runs, see `error_estimate`.
    """
    values, compared, names = fine, others, {name: name for name in FILMS}
    if case.starts_apart:
        values, compared = fine["max_approach"], {part: summary["max_approach"] for part, summary in others.items()}
        names["Delta_max"] = "Delta"
        if values is None or None in compared.values():
            return {**fine, "error_estimate": None}
    estimates = {
        name: error_estimate(values[key], {part: other[key] for part, other in compared.items()})
        for name, key in names.items()
    }
    content = dict(fine)
    for name in FILMS:
        content |= {f"{name}_{ending}": estimates[name][ending] for ending in ("error", "extrapolated")}
    content["error_estimate"] = estimates
    return content if case.starts_apart else with_si(case, content)
