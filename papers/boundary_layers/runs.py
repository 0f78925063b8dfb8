"""The runs of the paper's figures: impacts and rolling contacts, smooth, over waves and on layers of oil.

The runs of a figure are a `Task`, or a list or a table of runs: by what they are about, M and L, an oil, a shape, and
then by grids.  It is drawn from the same with the results in place of the tasks.  This module imports no matplotlib:
every process that computes runs imports it.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import ceil, inf
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

import ertel
from boundary_layers import theory, waves
from boundary_layers.plans import LOADS, SHOWN_LOAD, L, Moes, Plan, Wavelengths
from boundary_layers.tasks import Task
from ertel import Case, RingWaviness, Waviness, parse_case

Wave = tuple[str, float, float]  # key of SHAPES, height A_i in units of the trapped film, wavelength (a*)

INTERVAL = 0.01  # t0 between maps
NO_MAPS = 10.0  # t0: longer than the impact
HEIGHT = 0.01  # A_i in units of the trapped film sqrt(L/M): small
CHECKED = (0.005, 0.02, 0.05)  # other heights: A_d/A_i should not depend on the height
SHORTER = 2  # in the check of the time steps each usual step is so many steps
HALF_WIDTH, START = 1.5, -0.5  # of the impacts with waves: half width of the grid (a*), and Delta_0
STEP_ERROR = 5e-5  # tolerance of a time step; the local error is of third order in the step
SHAPES: Mapping[str, Callable[[float, float], Waviness | RingWaviness]] = {  # of height and wavelength
    "isotropic": lambda height, wavelength: Waviness(height, wavelength, wavelength),
    "transverse": lambda height, wavelength: Waviness(height, wavelength),
    "rings": lambda height, wavelength: RingWaviness(height, wavelength),
}
USUAL, SOFT = "Roelands, compressible", "isoviscous"
OILS: Mapping[str, Mapping[str, str]] = {  # the section [lubricant] of a case file
    USUAL: {},
    "Roelands, incompressible": {"density": "incompressible"},
    "Barus, incompressible": {"viscosity": "barus", "density": "incompressible"},
    SOFT: {"viscosity": "isoviscous", "density": "incompressible"},
}
LAYERS = (0.25, 0.5, 0.7, 1.0, 1.5, 2.0, 4.0)  # of oil, over that in the centre of the flooded contact
LAYERS_HALF_WIDTH = 3.0  # a*, of the impacts on layers: the thickest one leaves the edge dry


def tasks_in(runs: Any) -> Iterator[Task]:
    """All tasks of some runs."""
    if isinstance(runs, Task):
        yield runs
    else:
        for each in runs.values() if isinstance(runs, Mapping) else runs:
            yield from tasks_in(each)


def in_place(runs: Any, results: Mapping[str, Any]) -> Any:
    """The runs with the result of each task in its place.  results: by the names of the tasks."""
    if isinstance(runs, Task):
        return results[runs.name]
    if isinstance(runs, Mapping):
        return {key: in_place(each, results) for key, each in runs.items()}
    return [in_place(each, results) for each in runs]


# -- impacts ----------------------------------------------------------------------------------------------------------


def smooth_impact(M: float, L: float, solver: Mapping[str, Any], interval: float) -> xr.Dataset:
    """A smooth impact up to maximum approach.

    solver: the section [solver] of a case file.  interval: between maps (t0).  Raises RuntimeError where the run fails.
    """
    source = {"contact": {"M": M, "L": L}, "solver": dict(solver), "output": {"interval": interval}}
    return completed(parse_case(source), f"M = {M}, L = {L}").dataset


def completed(case: Case, name: str) -> ertel.Result:
    """The result of a run.  Raises RuntimeError with the name where it fails."""
    result = ertel.simulate(case)
    if not result.status.ok:
        raise RuntimeError(f"{name}: {result.status.value}; {result.status.advice}")
    return result


def wavy_impact(
    M: float, L: float, shapes: Sequence[Wave], nodes: int, oil: str = USUAL, linear: bool = False, finer: float = 1.0
) -> xr.Dataset:
    """The response of an impact to waves at maximum approach, along Y = 0.

    Parameters
    ----------
    shapes : sequence of (shape, height, wavelength)
        The waves, see `Wave`.
    oil : str
        Key of `OILS`.
    linear : bool
        The tangent-linear response, see `ertel.respond`.
    finer : float
        Divides the tolerance of a time step.

    Returns
    -------
    xarray.Dataset
        H (X) of the smooth impact, X_min and P_max over time, and for each `wave_name` dH/A_i and the shape of the wave
        (wave, X), and `along` (wave, X): the amplitude of transverse waves where the front ran along their ridges, see
        `waves.ridge_amplitude`, nan for the other shapes.

    Raises
    ------
    RuntimeError
        A run failed.
    """
    solver = {"nodes": nodes, "half_width": HALF_WIDTH, "tolerance": 1e-4}
    time = {"start_approach": START, "tolerance": STEP_ERROR / finer}
    case = parse_case({"contact": {"M": M, "L": L}, "lubricant": OILS[oil], "solver": solver, "time": time})
    heights = [height * case.parameters.trapped_film for _, height, _ in shapes]
    features = [
        [ertel.Feature(SHAPES[shape](A, length))] for A, (shape, _, length) in zip(heights, shapes, strict=True)
    ]
    data = (ertel.respond_linearly if linear else ertel.respond)(case, features)
    if data.attrs["status"] != "converged":
        raise RuntimeError(f"M = {M}, L = {L}, {oil}, {nodes} nodes: {data.attrs['status']}")
    scale, X, Y = xr.DataArray(heights, dims="wave"), data["X"].values, data["Y"].values
    data = data.assign(dH=data["dH"] / scale, shape=data["roughness"] / scale)
    along = [
        waves.ridge_amplitude(X, Y, dH, length, X) if shape == "transverse" else np.full(len(X), np.nan)
        for (shape, _, length), dH in zip(shapes, data["dH"].values, strict=True)
    ]
    line = data[["H", "dH", "shape", "X_min", "Y_min", "P_max"]].drop_vars("roughness").sel(Y=0.0, method="nearest")
    with_ridges = line.assign(along=(("wave", "X"), np.stack(along)))
    return with_ridges.assign_coords(wave=[wave_name(*wave) for wave in shapes]).drop_attrs().load()


def wave_name(shape: str, height: float, wavelength: float) -> str:
    """The coordinate of a wave in the result of `wavy_impact`."""
    return f"{shape}, height {height:g}, wavelength {wavelength:g}"


# -- rolling contacts -------------------------------------------------------------------------------------------------


def _rolling_source(M: float, L: float, method: str, nodes: int) -> dict[str, Any]:
    solver = {"method": method, "nodes": nodes, "half_width": 1.75, "inlet": 2.25}
    return {"contact": {"kind": "rolling", "M": M, "L": L}, "solver": solver}


def rolling_response(
    M: float, L: float, wavelengths: Sequence[float], nodes: int, across: float | None = None
) -> tuple[float, ...]:
    """A_d/A_i at the centre of a rolling contact over passing waves, to first order in their height.

    across: wavelength along Y, infinite for transverse waves; by default that along X.  Raises RuntimeError where a
    solve fails.
    """
    shapes = [Waviness(1.0, wavelength, across or wavelength) for wavelength in wavelengths]
    data = ertel.respond_in_rolling(
        parse_case(_rolling_source(M, L, "steady", nodes)), [[ertel.Feature(shape)] for shape in shapes]
    )
    if data.attrs["status"] != "converged":
        raise RuntimeError(f"rolling over waves, M = {M}, L = {L}, {nodes} nodes: {data.attrs['status']}")
    return tuple(data["dH_amplitude"].interp(X=0.0, Y=0.0).values.tolist())


def marched_rolling(M: float, L: float, wavelength: float, nodes: int) -> float:
    """The same ratio by time steps, over waves of finite height: the check of `rolling_response`.

    The waves enter behind a front that starts upstream of the contact.  The run ends when they have passed the centre
    by 1 a and three wavelengths.  A step is one cell long.  Raises RuntimeError where the run fails.
    """
    source, start = _rolling_source(M, L, "transient", nodes), -1.5
    step = 2 * source["solver"]["half_width"] / (nodes - 1)
    until = step * ceil((-start + 1.0 + 3 * wavelength) / step)
    source["solver"]["tolerance"] = 1e-4
    source |= {"time": {"until": until, "step": step}, "output": {"interval": until}}
    height = HEIGHT * parse_case(source).film_scale
    wave = {"shape": "waviness", "amplitude": height, "wavelength_x": wavelength, "wavelength_y": wavelength}
    rough = parse_case({**source, "roughness": [{**wave, "front": start, "ramp": wavelength}]})
    data = completed(rough, f"rolling, M = {M}, L = {L}, wavelength {wavelength}").dataset
    film = CubicSpline(data["time"].values, data["H_c"].values)
    turns = film.derivative().roots(extrapolate=False)
    extremes = film(turns[turns > until - wavelength])  # those of the last period, between the steps too
    return float(extremes.max() - extremes.min()) / 2 / height


def rolling_twin(M: float, L: float, wavelength: float, X: float, nodes: int) -> tuple[float, float]:
    """Rolling at the parameters of an impact's front as it passes X: nabla2, and A_d/A_i.

    The surfaces roll with the speed v of the front.  The Hertz contact is that of the impact at this moment, of radius
    X: lambda_bar v/X^4, alpha_bar X, wavelength/X.
    """
    solver = {"method": "radial", "nodes": 401, "half_width": 4.0}
    speed = float(theory.front(smooth_impact(M, L, solver, NO_MAPS)).speed_at(X))
    p = ertel.Parameters.from_moes(M, L)
    local = ertel.Parameters(p.lambda_bar * speed / X**4, p.alpha_bar * X)
    [ratio] = rolling_response(local.M, local.L, (wavelength / X,), nodes)
    return local.nabla2(wavelength / X), ratio


def ridged_rolling(M: float, L: float, wavelength: float, nodes: int) -> float:
    """A_d/A_i of longitudinal ridges under rolling: half the difference in dH between the central crest and a trough.

    Such ridges do not change along their direction of motion, so that the contact is steady.  Raises RuntimeError where
    a run fails.
    """
    source = _rolling_source(M, L, "steady", nodes)
    smooth = parse_case(source)
    height = HEIGHT * smooth.film_scale
    ridges = {"shape": "waviness", "amplitude": height, "wavelength_y": wavelength}
    rough = parse_case({**source, "roughness": [ridges]})
    name = f"rolling over ridges, M = {M:g}, L = {L:g}"
    on_ridges, without = (completed(case, name).dataset["H"].squeeze() for case in (rough, smooth))
    change = on_ridges - without
    crest, trough = change.sel(X=0.0, method="nearest").interp(Y=[0.0, wavelength / 2], method="cubic").values
    return float(abs(trough - crest)) / (2 * height)


def starved_films(kind: str, M: float, L: float, nodes: int) -> tuple[float, ...]:
    """The oil in the centre on each of `LAYERS`, over that of the flooded contact, an impact's at maximum approach.

    Impacts by the radial method, rolling steady.  Raises RuntimeError where a run fails.
    """
    solver = {"method": "radial", "half_width": LAYERS_HALF_WIDTH} if kind == "impact" else {"method": "steady"}
    data = {"contact": {"kind": kind, "M": M, "L": L}, "solver": {**solver, "nodes": nodes}}

    def oil_in_centre(layer: Mapping[str, float]) -> float:
        case = parse_case({**data, "lubricant": layer})
        summary = completed(case, f"{kind}, M = {M:g}, L = {L:g}, {layer}").summary
        return float(case.lubricant.density(summary["P_c"]) * summary["H_c"])

    flooded = oil_in_centre({})
    return tuple(oil_in_centre({"layer": r * flooded}) / flooded for r in LAYERS)


# -- the runs of the figures ------------------------------------------------------------------------------------------


def radial_runs(plan: Plan) -> dict[str, Any]:
    """The runs of Figs. 1 and 4: smooth impacts by the radial method, by M."""
    return {"radial": {M: _radial(plan, (M, L)) for M in LOADS}}


def smooth_runs(plan: Plan) -> dict[str, Any]:
    """The runs of Figs. 2 and 3: the same, and one by the 2-D method."""
    solver = {"nodes": plan.plane_nodes, "half_width": plan.plane_half_width}
    plane = task(smooth_impact, (SHOWN_LOAD, L, solver, NO_MAPS), plan.plane_seconds)
    return {**radial_runs(plan), "plane": plane}


def wave_runs(plan: Plan) -> dict[str, Any]:
    """The runs of Fig. 5: impacts by M and L, smooth by the radial method, and over isotropic waves on both grids."""
    waves = {case: _impacts(case, _isotropic(lengths), plan.impact_grids) for case, lengths in plan.impacts.items()}
    return {"smooth": {case: _radial(plan, case) for case in plan.impacts}, "waves": waves}


def reduction_runs(plan: Plan) -> dict[str, Any]:
    """The runs of Fig. 6: those of Fig. 5, rolling over isotropic waves, rolling twins of impacts, and checks."""
    rolling = {case: _rolling(case, lengths, plan.rolling_grids) for case, lengths in plan.rolling.items()}
    twins = {twin: _on_grids(rolling_twin, twin, plan.twin_grids, 7.0, start=15.0) for twin in plan.twins}
    return {**wave_runs(plan), "rolling": rolling, "twins": twins, "checks": _checks(plan)}


def _checks(plan: Plan) -> dict[str, list[Task]]:
    """Other heights of the waves, the tangent-linear response, shorter time steps, and rolling by steps."""
    case, grids = plan.shown, plan.impact_grids[:1]
    usual = _isotropic(plan.impacts[case])
    others = [("isotropic", height, plan.impacts[case][0]) for height in CHECKED]
    *marched, wavelength, nodes = plan.marched
    seconds = 5.0 + 190.0 * (nodes / 513) ** 3  # its step is a cell long
    return {
        "heights": _impacts(case, others, grids),
        "linear": _impacts(case, usual[:1], grids, USUAL, True),
        "steps": _impacts(case, usual, grids, USUAL, False, SHORTER**3),
        "marched": [task(marched_rolling, plan.marched, seconds)],
        "not marched": _rolling(marched, (wavelength,), (nodes,)),
    }


def shape_runs(plan: Plan) -> dict[str, Any]:
    """The runs of Fig. 7 by shape, M, L and wavelength: impacts over transverse waves and rings, and rolling."""
    impacts, rolling, grids = {}, {}, plan.straight_grids
    for case, lengths in plan.shaped.items():
        shapes = [(shape, HEIGHT, length) for length in lengths for shape in ("transverse", "rings")]
        impacts[case] = _impacts(case, shapes, plan.beyond_grids)
    for *contact, length in plan.straight:
        rolling["transverse", *contact, length] = _on_grids(rolling_response, (*contact, (length,)), grids, 7.0, inf)
        rolling["longitudinal", *contact, length] = _on_grids(ridged_rolling, (*contact, length), grids, 7.0)
    return {"impacts": impacts, "rolling": rolling}


def oil_runs(plan: Plan) -> dict[tuple[str, Moes, Wavelengths], list[Task]]:
    """The runs of Fig. 8: impacts over isotropic waves by oil, M and L, wavelengths."""
    impacts = [(oil, *impact) for impact in plan.oils.items() for oil in OILS if oil != SOFT]
    impacts += [(SOFT, (M, 0), lengths) for M, lengths in plan.soft.items()]
    return {
        (oil, case, lengths): _impacts(case, _isotropic(lengths), plan.beyond_grids, oil)
        for oil, case, lengths in impacts
    }


def starved_runs(plan: Plan) -> dict[tuple[str, float, float], list[Task]]:
    """The runs of Fig. 9: contacts on layers of oil, by kind, M and L."""
    contacts = [(kind, float(M), float(L)) for kind, cases in plan.starved.items() for M, L in cases]
    seconds = plan.starved_seconds
    return {each: _on_grids(starved_films, each, plan.starved_grids, 0.0, start=seconds) for each in contacts}


def _radial(plan: Plan, case: Moes) -> Task:
    """A smooth impact by the radial method."""
    solver = {"method": "radial", "nodes": plan.radial_nodes, "half_width": 4.0}
    return task(smooth_impact, (float(case[0]), float(case[1]), solver, INTERVAL), plan.radial_seconds)


def _isotropic(wavelengths: Wavelengths) -> tuple[Wave, ...]:
    return tuple(("isotropic", HEIGHT, wavelength) for wavelength in wavelengths)


def _impacts(case: Moes, shapes: Sequence[Wave], grids: Sequence[int], *options: Any) -> list[Task]:
    seconds = 18.0 * (len(shapes) + 1)  # in lockstep with the smooth impact
    return _on_grids(wavy_impact, (*case, tuple(shapes)), grids, seconds, *options)


def _rolling(case: Sequence[float], wavelengths: Wavelengths, grids: Sequence[int]) -> list[Task]:
    return _on_grids(rolling_response, (*case, wavelengths), grids, 4.0 + 3.0 * len(wavelengths))


def _on_grids(
    function: Callable[..., Any], arguments: Sequence[Any], grids: Sequence[int], seconds: float,
    *options: Any, start: float = 5.0,
) -> list[Task]:  # fmt: skip
    """A run on each grid.  seconds: that it takes on 513 nodes after the start (measured, one core)."""
    return [task(function, (*arguments, nodes, *options), start + seconds * (nodes / 513) ** 2) for nodes in grids]


def task(function: Callable[..., Any], arguments: tuple[Any, ...], seconds: float) -> Task:
    """A run under the name of its function and arguments: figures share it."""
    return Task(re.sub(r"[^\w.-]+", "_", f"{function.__name__}{arguments}").strip("_"), function, arguments, seconds)
