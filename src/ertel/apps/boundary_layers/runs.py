"""The runs of the paper's figures: impacts and rolling contacts, smooth and over waves.

Each function that makes a `Task` stands for one run: figures list the tasks that they need, and find the result of a
task by its name.
"""

from collections.abc import Callable, Mapping, Sequence
from math import ceil, inf
from typing import Any, Literal

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from ertel import (
    Case,
    Feature,
    Parameters,
    RingWaviness,
    Waviness,
    fronts,
    parse_case,
    respond,
    respond_in_rolling,
    respond_linearly,
    simulate,
    waves,
)
from ertel.apps.boundary_layers.plans import (
    LOADS,
    SHOWN_LOAD,
    L,
    Moes,
    Plan,
    Wavelengths,
    impact_seconds,
    marching_seconds,
    rolling_seconds,
)
from ertel.runs.tasks import Task

Results = Mapping[str, Any]  # task name -> result
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


# -- impacts ----------------------------------------------------------------------------------------------------------


def smooth_impact(M: float, L: float, solver: Mapping[str, Any], interval: float) -> xr.Dataset:
    """A smooth impact up to maximum approach.

    solver: the section [solver] of a case file.  interval: between maps (t0).  Raises RuntimeError where the run fails.
    """
    source = {"contact": {"M": M, "L": L}, "solver": dict(solver), "output": {"interval": interval}}
    return _completed(parse_case(source), f"M = {M}, L = {L}")


def _completed(case: Case, name: str) -> xr.Dataset:
    result = simulate(case)
    if not result.status.ok:
        raise RuntimeError(f"{name}: {result.status.value}; {result.status.advice}")
    return result.dataset


def radial_task(M: float, L: float, plan: Plan) -> Task:
    """A smooth impact by the radial method."""
    nodes = plan.smooth.radial_nodes
    solver = {"method": "radial", "nodes": nodes, "half_width": 4.0}
    arguments = float(M), float(L), solver, INTERVAL
    return Task(f"smooth_M{M:g}_L{L:g}_{nodes}", smooth_impact, arguments, plan.smooth.radial_seconds)


def radial_tasks(plan: Plan) -> list[Task]:
    """The smooth impacts of Figs. 1, 2 and 4."""
    return [radial_task(M, L, plan) for M in LOADS]


def radial_runs(results: Results, plan: Plan) -> dict[int, xr.Dataset]:
    """M -> smooth impact by the radial method."""
    return {M: results[task.name] for M, task in zip(LOADS, radial_tasks(plan), strict=True)}


def plane_task(plan: Plan) -> Task:
    """One of the smooth impacts by the 2-D method."""
    nodes = plan.smooth.plane_nodes
    arguments = SHOWN_LOAD, L, {"nodes": nodes, "half_width": plan.smooth.plane_half_width}, NO_MAPS
    return Task(f"smooth_2d_M{SHOWN_LOAD}_{nodes}", smooth_impact, arguments, plan.smooth.plane_seconds)


def smooth_tasks(plan: Plan) -> list[Task]:
    """The smooth impacts by the radial method, and the one by the 2-D method."""
    return [*radial_tasks(plan), plane_task(plan)]


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
    features = [[Feature(SHAPES[shape](A, length))] for A, (shape, _, length) in zip(heights, shapes, strict=True)]
    data = (respond_linearly if linear else respond)(case, features)
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


def _moes(case: Moes) -> str:
    return f"M{case[0]:g}_L{case[1]:g}"


def _isotropic(wavelengths: Wavelengths) -> tuple[Wave, ...]:
    return tuple(("isotropic", HEIGHT, wavelength) for wavelength in wavelengths)


def _impact_task(name: str, case: Moes, shapes: Sequence[Wave], nodes: int, *options: Any) -> Task:
    seconds = impact_seconds(len(shapes) + 1, nodes)
    return Task(f"{name}_{nodes}", wavy_impact, (*case, tuple(shapes), nodes, *options), seconds)


def waves_task(plan: Plan, case: Moes, nodes: int) -> Task:
    """An impact over the isotropic waves of Figs. 5 and 6."""
    return _impact_task(f"waves_{_moes(case)}", case, _isotropic(plan.waves.impacts[case]), nodes)


def waves_tasks(plan: Plan) -> list[Task]:
    """For each M, L: the smooth impact by the radial method, and the waves on both grids."""
    tasks = [radial_task(*case, plan) for case in plan.waves.impacts]
    return tasks + [waves_task(plan, case, nodes) for case in plan.waves.impacts for nodes in plan.waves.grids]


def check_tasks(plan: Plan) -> dict[str, Task]:
    """The checks on the coarse grid: other heights of the waves, the tangent-linear response, shorter time steps."""
    case, nodes = plan.waves.shown, plan.waves.grids[0]
    usual = _isotropic(plan.waves.impacts[case])
    others = [("isotropic", height, plan.waves.impacts[case][0]) for height in CHECKED]
    seconds = marching_seconds(plan.waves.marched[-1])
    return {
        "heights": _impact_task("waves_heights", case, others, nodes),
        "linear": _impact_task("waves_linear", case, usual[:1], nodes, USUAL, True),
        "steps": _impact_task("waves_steps", case, usual, nodes, USUAL, False, SHORTER**3),
        "marched": Task(f"waves_marched_{nodes}", marched_rolling, plan.waves.marched, seconds),
    }


def shapes_task(plan: Plan, case: Moes, nodes: int) -> Task:
    """An impact over the transverse waves and the rings of Fig. 7."""
    shapes = [(shape, HEIGHT, length) for length in plan.beyond.shaped[case] for shape in ("transverse", "rings")]
    return _impact_task(f"shapes_{_moes(case)}", case, shapes, nodes)


def oil_task(case: Moes, oil: str, wavelengths: Wavelengths, nodes: int) -> Task:
    """An impact over isotropic waves with one of the oils of Fig. 8."""
    return _impact_task(f"{oil.replace(', ', '_')}_{_moes(case)}", case, _isotropic(wavelengths), nodes, oil)


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
    data = respond_in_rolling(
        parse_case(_rolling_source(M, L, "steady", nodes)), [[Feature(shape)] for shape in shapes]
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
    data = _completed(rough, f"rolling, M = {M}, L = {L}, wavelength {wavelength}")
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
    speed = float(fronts.front(smooth_impact(M, L, solver, NO_MAPS)).speed_at(X))
    p = Parameters.from_moes(M, L)
    local = Parameters(p.lambda_bar * speed / X**4, p.alpha_bar * X)
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
    films = [_completed(case, f"rolling over ridges, M = {M:g}, L = {L:g}")["H"].squeeze() for case in (rough, smooth)]
    change = films[0] - films[1]
    crest, trough = change.sel(X=0.0, method="nearest").interp(Y=[0.0, wavelength / 2], method="cubic").values
    return float(abs(trough - crest)) / (2 * height)


def rolled_wavelengths(plan: Plan, case: Moes, nodes: int) -> Wavelengths:
    """The wavelengths of a rolling contact of Fig. 6, or that of its check on the grid of the check."""
    lengths = plan.waves.rolling.get(case, ())
    return lengths if lengths and nodes in plan.waves.rolling_grids else (plan.waves.marched[2],)


def rolling_task(plan: Plan, case: Moes, nodes: int) -> Task:
    """A rolling contact over the isotropic waves of Fig. 6."""
    lengths = rolled_wavelengths(plan, case, nodes)
    seconds = rolling_seconds(len(lengths), nodes)
    return Task(f"rolling_{_moes(case)}_{nodes}", rolling_response, (*case, lengths, nodes), seconds)


def rolling_tasks(plan: Plan) -> list[Task]:
    """Each rolling contact on both grids, and the contact of the check on its grid."""
    M, L, _, nodes = plan.waves.marched
    contacts = [(case, grid) for grid in plan.waves.rolling_grids for case in plan.waves.rolling]
    return [rolling_task(plan, *contact) for contact in dict.fromkeys([*contacts, ((M, L), nodes)])]


def twin_task(twin: tuple[float, float, float, float], nodes: int) -> Task:
    """A rolling twin of an impact: M, L, wavelength and place."""
    M, L, wavelength, X = twin
    name = f"twin_M{M:g}_L{L:g}_{wavelength:g}_at_{X:g}_{nodes}"
    return Task(name, rolling_twin, (*twin, nodes), 10.0 + rolling_seconds(1, nodes))


def straight_task(kind: Literal["transverse", "longitudinal"], rolling: tuple[float, float, float], nodes: int) -> Task:
    """A rolling contact over the transverse waves or the longitudinal ridges of Fig. 7: M, L and wavelength."""
    M, L, wavelength = rolling
    case, seconds = f"M{M:g}_L{L:g}_{wavelength:g}_{nodes}", rolling_seconds(1, nodes)
    if kind == "longitudinal":
        return Task(f"ridges_{case}", ridged_rolling, (*rolling, nodes), seconds)
    return Task(f"transverse_{case}", rolling_response, (M, L, (wavelength,), nodes, inf), seconds)
