"""The runs of the figures of line contacts: impacts of cylinders, smooth and over waves, and rolling at their fronts.

Rolling "at A" has the speed, the size and the pressure of the dry impact as the edge of its contact passes A:
lambda_bar v/A^4 and alpha_bar A, with v = dA/dT of the dry impact.  Nothing of the lubricated impact enters.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import xarray as xr

import ertel
from boundary_layers.plans import LINE_L, Moes, Plan
from boundary_layers.runs import HEIGHT, OILS, SOFT, USUAL, completed, task, wave_name
from boundary_layers.tasks import Task
from ertel import Case, Waviness, parse_case

HALF_WIDTH = 1.5  # b, of the impacts
INTERVAL = 0.02  # t0 between maps
KEPT = ["H", "P", "left", "X_min", "P_max", "Delta", "F", "event"]
ROLLING = {"half_width": 1.75, "inlet": 2.25}  # b, from M = 50 on: the films are thin and their inlets short
SHORT_INLETS = 50.0  # M
HIGH, FINER = 200.0, 2  # above this M the impacts have so many times the cells
SHAPE = "transverse"
OTHERS = ((60.0, LINE_L, "Barus, incompressible"), (60.0, 0.0, SOFT))  # M, L, oil of Fig. 7 beside the usual ones


def line_case(
    kind: str, M: float, L: float, oil: str = USUAL, length: float = 100.0, **sections: Mapping[str, Any]
) -> Case:
    """The case of a line contact.  oil: key of `OILS`; length: in half widths; sections as in a case file."""
    contact = {"kind": kind, "M": M, "L": L, "radius_ratio": 0, "length_ratio": length}
    return parse_case({"contact": contact, "lubricant": OILS[oil], **sections})


def line_impact(M: float, L: float, oil: str, nodes: int, interval: float) -> xr.Dataset:
    """A smooth impact up to maximum approach; `left` is the oil rho H.  Raises RuntimeError where the run fails."""
    solver = {"nodes": nodes, "half_width": HALF_WIDTH}
    case = line_case("impact", M, L, oil, solver=solver, output={"interval": interval})
    data = completed(case, f"cylinder, M = {M}, L = {L}, {oil}").dataset
    return data.assign(left=data["oil"] * case.lubricant.density(data["P"]))[KEPT]


def line_waves(M: float, L: float, wavelengths: Sequence[float], nodes: int) -> xr.Dataset:
    """The response of an impact to waves at rest, at maximum approach.

    H (X) of the smooth impact, X_min and P_max over time, and for each `wave_name` dH/A_i and the shape (wave, X).
    Raises RuntimeError where a run fails.
    """
    case = line_case("impact", M, L, solver={"nodes": nodes, "half_width": HALF_WIDTH})
    height = HEIGHT * case.parameters.trapped_film
    data = ertel.respond(case, [[ertel.Feature(Waviness(height, length))] for length in wavelengths])
    if data.attrs["status"] != "converged":
        raise RuntimeError(f"cylinder over waves, M = {M}, L = {L}, {nodes} nodes: {data.attrs['status']}")
    data = data.assign(dH=data["dH"] / height, shape=data["roughness"] / height).drop_vars("roughness")
    names = [wave_name(SHAPE, HEIGHT, length) for length in wavelengths]
    return data[["H", "dH", "shape", "X_min", "P_max"]].assign_coords(wave=names)


def rolling_at(M: float, L: float, A: float, oil: str, nodes: int) -> Case:
    """Rolling at A, where A is a place of the edge in the dry impact (b*)."""
    impact = line_case("impact", M, L, oil)
    p, speed = impact.parameters, impact.geometry.hertz.front_speed(A)
    local = type(p)(p.lambda_bar * speed / A**4, p.alpha_bar * A)
    domain = ROLLING if local.M >= SHORT_INLETS else {}
    return line_case("rolling", local.M, local.L, oil, solver={"method": "steady", "nodes": nodes, **domain})


def rolled_oil(M: float, L: float, oil: str, places: Sequence[float], nodes: int) -> tuple[float, ...]:
    """The oil rho H that steady rolling leaves at each place A (b*^2/R): A^2 times its flow, extrapolated over grids.

    Raises RuntimeError where a run fails.
    """

    def left(A: float) -> float:
        result = completed(rolling_at(M, L, A, oil, nodes), f"rolling at {A}, M = {M}, L = {L}, {oil}")
        coarse, fine = result.dataset["inflow"].values[-2:]
        return float(A**2 * (fine + (fine - coarse) / 3))

    return tuple(map(left, places))


def rolled_waves(M: float, L: float, A: float, wavelengths: Sequence[float], nodes: int) -> tuple[float, ...]:
    """A_d/A_i in the middle of rolling at A over waves, to first order in their height; wavelengths in b*.

    Raises RuntimeError where a solve fails.
    """
    waves = [[ertel.Feature(Waviness(1.0, length / A))] for length in wavelengths]
    data = ertel.respond_in_rolling(rolling_at(M, L, A, USUAL, nodes), waves)
    if data.attrs["status"] != "converged":
        raise RuntimeError(f"rolling over waves at {A}, M = {M}, L = {L}, {nodes} nodes: {data.attrs['status']}")
    return tuple(data["dH_amplitude"].interp(X=0.0).values.tolist())


# -- the runs of the figures ------------------------------------------------------------------------------------------


def smooth_runs(plan: Plan) -> dict[float, Task]:
    """The runs of Figs. 1 to 4: smooth impacts by M, on the finer grid."""
    return {M: _impacts((float(M), LINE_L, USUAL), plan)[1] for M in plan.lines.loads}


def wave_runs(plan: Plan) -> dict[Moes, list[Task]]:
    """The runs of Fig. 5: impacts over waves by M and L, on both grids."""
    lines = plan.lines
    return {
        case: [_task(line_waves, (*case, lengths, nodes), 2.0 + len(lengths)) for nodes in lines.impact_grids]
        for case, lengths in lines.waves.items()
    }


def reduction_runs(plan: Plan) -> dict[str, Any]:
    """The runs of Fig. 6: those of Fig. 5, and rolling at places A by M and L, on both grids."""
    lines = plan.lines
    rolling = {
        case: {
            A: [_task(rolled_waves, (*case, A, lengths, nodes), 1.0 + len(lengths)) for nodes in lines.rolling_grids]
            for A in lines.wave_places
        }
        for case, lengths in lines.waves.items()
    }
    return {"waves": wave_runs(plan), "rolling": rolling}


def law_runs(plan: Plan) -> dict[str, Any]:
    """The runs of Fig. 7: by M, L and oil impacts on both grids, and rolling at the places."""
    lines, nodes = plan.lines, plan.lines.rolling_grids[1]
    cases = [*((float(M), LINE_L, USUAL) for M in lines.loads), *OTHERS]
    return {
        "impacts": {case: _impacts(case, plan) for case in cases},
        "rolled": {
            case: _task(rolled_oil, (*case, lines.law_places, nodes), 1.5 * len(lines.law_places)) for case in cases
        },
    }


def _impacts(case: tuple[float, float, str], plan: Plan) -> list[Task]:
    """A smooth impact on both grids."""
    finer = FINER if case[0] > HIGH else 1
    grids = [finer * (nodes - 1) + 1 for nodes in plan.lines.impact_grids]
    return [_task(line_impact, (*case, nodes, INTERVAL), 15.0) for nodes in grids]


def _task(function: Any, arguments: tuple[Any, ...], seconds: float) -> Task:
    """A run.  seconds: that it takes on 1025 nodes after the start (measured, one core)."""
    nodes = max(each for each in arguments if isinstance(each, int))
    return task(function, arguments, 4.0 + seconds * (nodes / 1025) ** 2)
