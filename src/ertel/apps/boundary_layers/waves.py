"""Waviness in impact and in rolling: the runs of Figs. 5 and 6, and Fig. 5."""

from collections.abc import Mapping, Sequence
from math import ceil

import xarray as xr
from matplotlib.axes import Axes
from pandas import DataFrame
from scipy.interpolate import CubicSpline

from ertel import (
    Case,
    Feature,
    Parameters,
    Waviness,
    fronts,
    parse_case,
    plots,
    respond,
    respond_in_rolling,
    respond_linearly,
    simulate,
    waves,
)
from ertel.apps.boundary_layers.page import Drawn
from ertel.apps.boundary_layers.plans import Plan, impact_seconds, marching_seconds, rolling_seconds
from ertel.apps.boundary_layers.smooth import (
    NO_MAPS,
    Results,
    new_figure,
    radial_name,
    radial_task,
    smooth_impact,
)
from ertel.runs.tasks import Task

HEIGHT = 0.01  # A_i in units of the trapped film sqrt(L/M): small
CHECKED = (0.005, 0.02, 0.05)  # other heights: A_d/A_i should not depend on the height
SHORTER = 2  # in the check of the time steps each usual step is so many steps
HALF_WIDTH, START = 1.5, -0.5  # of the impacts with waves: half width of the grid (a*), and Delta_0
STEP_ERROR = 5e-5  # tolerance of a time step; the local error is of third order in the step

# -- runs -------------------------------------------------------------------------------------------------------------


def impact_case(M: float, L: float, nodes: int, oil: Mapping[str, str] | None = None, finer: float = 1.0) -> Case:
    """A smooth impact.  oil: the section [lubricant] of a case file; finer: divides the tolerance of a time step."""
    solver = {"nodes": nodes, "half_width": HALF_WIDTH, "tolerance": 1e-4}
    time = {"start_approach": START, "tolerance": STEP_ERROR / finer}
    return parse_case({"contact": {"M": M, "L": L}, "lubricant": oil or {}, "solver": solver, "time": time})


def wave_name(height: float, wavelength: float) -> str:
    """Coordinate of a wave in the result of `wavy_impact`."""
    return f"height {height:g}, wavelength {wavelength:g}"


def wavy_impact(
    M: float,
    L: float,
    waves: Sequence[tuple[float, float]],
    nodes: int,
    linear: bool = False,
    finer: float = 1.0,
) -> xr.Dataset:
    """The response of an impact to isotropic waves at maximum approach, along Y = 0.

    Parameters
    ----------
    waves : sequence of (height, wavelength)
        Height A_i in units of the trapped film, and wavelength (a*), of each wave.
    linear : bool
        The tangent-linear response, see `ertel.respond`.
    finer : float
        See `impact_case`.

    Returns
    -------
    xarray.Dataset
        H (X) of the smooth impact, and for each `wave_name` dH/A_i and the shape of the wave (wave, X).

    Raises
    ------
    RuntimeError
        A run failed.
    """
    case = impact_case(M, L, nodes, finer=finer)
    heights = [share * case.parameters.trapped_film for share, _ in waves]
    shapes = [Waviness(A, wave, wave) for A, (_, wave) in zip(heights, waves, strict=True)]
    response = respond_linearly if linear else respond
    data = response(case, [[Feature(shape)] for shape in shapes])
    if data.attrs["status"] != "converged":
        raise RuntimeError(f"M = {M}, L = {L}, {nodes} nodes: {data.attrs['status']}")
    line = data[["H", "dH"]].assign(shape=data["roughness"]).drop_vars("roughness").sel(Y=0.0, method="nearest")
    scale, names = xr.DataArray(heights, dims="wave"), [wave_name(*wave) for wave in waves]
    relative = line.assign(dH=line["dH"] / scale, shape=line["shape"] / scale)
    return relative.assign_coords(wave=names).drop_attrs().load()


def rolling_response(
    M: float, L: float, wavelengths: Sequence[float], nodes: int, across: float | None = None
) -> tuple[float, ...]:
    """A_d/A_i at the centre of a rolling contact over passing waves, to first order in their height.

    across: wavelength along Y, infinite for transverse waves; by default that along X.  Raises RuntimeError where a
    solve fails.
    """
    case = parse_case({"contact": {"kind": "rolling", "M": M, "L": L}, "solver": {"method": "steady", **_grid(nodes)}})
    shapes = [Waviness(1.0, wavelength, across or wavelength) for wavelength in wavelengths]
    data = respond_in_rolling(case, [[Feature(shape)] for shape in shapes])
    if data.attrs["status"] != "converged":
        raise RuntimeError(f"rolling over waves, M = {M}, L = {L}, {nodes} nodes: {data.attrs['status']}")
    return tuple(data["dH_amplitude"].interp(X=0.0, Y=0.0).values.tolist())


def _grid(nodes: int) -> dict[str, float]:
    return {"nodes": nodes, "half_width": 1.75, "inlet": 2.25}


def marched_rolling(M: float, L: float, wavelength: float, nodes: int) -> float:
    """The same ratio by time steps, over waves of finite height: the check of `rolling_response`.

    The waves enter behind a front that starts upstream of the contact.  The run ends when they have passed the centre
    by 1 a and three wavelengths.  A step is one cell long.  Raises RuntimeError where the run fails.
    """
    start, grid = -1.5, _grid(nodes)
    step = 2 * grid["half_width"] / (nodes - 1)
    until = step * ceil((-start + 1.0 + 3 * wavelength) / step)
    source = {
        "contact": {"kind": "rolling", "M": M, "L": L},
        "solver": {"method": "transient", "tolerance": 1e-4, **grid},
        "time": {"until": until, "step": step},
        "output": {"interval": until},
    }
    height = HEIGHT * parse_case(source).film_scale
    wave = {"shape": "waviness", "amplitude": height, "wavelength_x": wavelength, "wavelength_y": wavelength}
    result = simulate(parse_case({**source, "roughness": [{**wave, "front": start, "ramp": wavelength}]}))
    if not result.status.ok:
        raise RuntimeError(f"rolling, M = {M}, L = {L}, wavelength {wavelength}: {result.status.value}")
    film = CubicSpline(result.dataset["time"].values, result.dataset["H_c"].values)
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


# -- tasks and their names --------------------------------------------------------------------------------------------


def impact_name(M: float, L: float, nodes: int) -> str:
    """Name of the task that is a `wavy_impact` with the waves of Figs. 5 and 6."""
    return f"waves_M{M:g}_L{L:g}_{nodes}"


def check_name(kind: str, plan: Plan) -> str:
    """Name of one of the `check_tasks`: "heights", "linear", "steps" or "marched"."""
    return f"waves_{kind}_{plan.waves.grids[0]}"


def rolling_name(M: float, L: float, nodes: int) -> str:
    """Name of the task that is a `rolling_response` to isotropic waves."""
    return f"rolling_M{M:g}_L{L:g}_{nodes}"


def twin_name(M: float, L: float, wavelength: float, X: float, nodes: int) -> str:
    """Name of the task that is a `rolling_twin`."""
    return f"twin_M{M:g}_L{L:g}_{wavelength:g}_at_{X:g}_{nodes}"


def impact_tasks(plan: Plan) -> list[Task]:
    """For each M, L: the smooth impact by the radial method, and the waves on both grids."""
    tasks = []
    for (M, L), wavelengths in plan.waves.impacts.items():
        tasks.append(radial_task(M, L, plan))
        for nodes in plan.waves.grids:
            arguments = M, L, tuple((HEIGHT, wavelength) for wavelength in wavelengths), nodes
            seconds = impact_seconds(len(wavelengths) + 1, nodes)
            tasks.append(Task(impact_name(M, L, nodes), wavy_impact, arguments, seconds))
    return tasks


def check_tasks(plan: Plan) -> list[Task]:
    """Checks on the coarse grid: other heights of the waves, the tangent-linear response, shorter time steps."""
    M, L, nodes = *plan.waves.shown, plan.waves.grids[0]
    wavelengths = plan.waves.impacts[M, L]
    usual = tuple((HEIGHT, wavelength) for wavelength in wavelengths)
    others = tuple((height, wavelengths[0]) for height in CHECKED)
    several, one = impact_seconds(len(usual) + 1, nodes), impact_seconds(2, nodes)
    heights, marching = impact_seconds(len(others) + 1, nodes), marching_seconds(plan.waves.marched[-1])
    return [
        Task(check_name("heights", plan), wavy_impact, (M, L, others, nodes), heights),
        Task(check_name("linear", plan), wavy_impact, (M, L, usual[:1], nodes, True), one),
        Task(check_name("steps", plan), wavy_impact, (M, L, usual, nodes, False, SHORTER**3), several),
        Task(check_name("marched", plan), marched_rolling, plan.waves.marched, marching),
    ]


def rolling_tasks(plan: Plan) -> list[Task]:
    """Each rolling contact on both grids, and the contact of the check on its grid."""
    waves = plan.waves
    M, L, wavelength, nodes = waves.marched
    runs = {(*case, nodes): lengths for nodes in waves.rolling_grids for case, lengths in waves.rolling.items()}
    runs.setdefault((M, L, nodes), (wavelength,))
    return [
        Task(rolling_name(M, L, nodes), rolling_response, (M, L, own, nodes), rolling_seconds(len(own), nodes))
        for (M, L, nodes), own in runs.items()
    ]


def twin_tasks(plan: Plan) -> list[Task]:
    """Each rolling twin on both grids."""
    return [
        Task(twin_name(*twin, nodes), rolling_twin, (*twin, nodes), 10.0 + rolling_seconds(1, nodes))
        for twin in plan.waves.twins
        for nodes in plan.waves.twin_grids
    ]


# -- Fig. 5 -----------------------------------------------------------------------------------------------------------


def deformed_waves(results: Results, plan: Plan) -> Drawn:
    """Fig. 5: dH(X, 0)/A_i at maximum impact, inside and outside the contact."""
    (M, L), nodes = plan.waves.shown, plan.waves.grids[1]
    wavelengths = plan.waves.impacts[M, L]
    fine, edge = results[impact_name(M, L, nodes)], float(fronts.front(results[radial_name(M, L, plan)]).A[-1])
    responses = {wavelength: fine.sel(wave=wave_name(HEIGHT, wavelength)) for wavelength in wavelengths}
    last = {wavelength: last_wave(response, edge) for wavelength, response in responses.items()}
    figure, panels = new_figure(len(wavelengths), 1)
    figure.set_size_inches(8.0, 2.4 * len(wavelengths))
    for wavelength, axes in zip(wavelengths, panels, strict=True):
        _draw_waves(axes, responses[wavelength], last[wavelength], edge)
        axes.set_ylabel(f"$\\Lambda$ = {wavelength:g}")
    panels[0].legend(loc="lower left", frameon=True, fontsize="x-small", ncols=3)
    panels[-1].set_xlabel("$X$ ($a^*$)")
    caption = (
        f"dH(X, 0)/A_i at maximum impact, M = {M:g}, L = {L:g}, roughness A_i cos(2 pi X/Lambda) cos(2 pi Y/Lambda) "
        f"with a crest at the centre, A_i = {HEIGHT} sqrt(L/M), {nodes} nodes per side.  The vertical lines mark the "
        "minimum film.  The deformation of the waves rises with their distance from the centre and with their "
        "wavelength, and the waves are shifted outwards.  Outside the contact they keep their amplitude."
    )
    profiles = {f"dH/A_i, wavelength {wavelength:g}": response["dH"] for wavelength, response in responses.items()}
    data = DataFrame({"X": fine["X"].values, "H": fine["H"].values} | {n: dH.values for n, dH in profiles.items()})
    return Drawn(figure, caption, {"dH": data}, {f"Last complete waves, {nodes} nodes per side": _last_waves(last)})


def _draw_waves(axes: Axes, response: xr.Dataset, wave: waves.Wave, edge: float) -> None:
    X = response["X"].values
    shape = -response["shape"].values
    axes.plot(X, shape, color=plots.GREY, linewidth=0.7, linestyle=":", label="undeformed: $-\\mathcal{R}/A_i$")
    axes.plot(X, response["dH"].values, color=plots.BLUE, label="$dH/A_i$")
    axes.axvspan(wave.start, wave.end, color=plots.ORANGE, alpha=0.2, label="last complete wave")
    for side in (-edge, edge):
        axes.axvline(side, color="black", linewidth=0.7)
    axes.set(xlim=(-HALF_WIDTH, HALF_WIDTH), ylim=(-1.15, 1.15))


def _last_waves(last: Mapping[float, waves.Wave]) -> DataFrame:
    return DataFrame(
        {"wavelength (a*)": f"{wavelength:g}", "X": f"{wave.X:.3f}", "A_d/A_i": f"{wave.amplitude:.3f}"}
        for wavelength, wave in last.items()
    )


def last_wave(response: xr.Dataset, edge: float) -> waves.Wave:
    """The last complete wave inside the edge, of one wave's dH/A_i (X)."""
    return waves.last_wave(response["X"].values, response["dH"].values, edge)
