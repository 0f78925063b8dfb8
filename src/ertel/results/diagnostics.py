"""How far a run may be trusted: warnings where grid, domain, inlet or initial gap fall short, each with its mend."""

from collections.abc import Sequence
from math import inf

import numpy as np
import xarray as xr

from ertel.model.case import Case
from ertel.model.state import GridSolution, Rolling
from ertel.physics import hertz
from ertel.physics.geometry import HERTZ_LOAD
from ertel.physics.surfaces import RingWaviness, Shape, Spot, Waviness
from ertel.results import variables

CELLS_IN_FRONT = 10.0  # wanted across sqrt(alpha_bar lambda_bar dA/dT), the length of the front's pressure sweep
FRONT_POSITION = 0.9  # where the front is looked at: the films of interest lie inside
MISSING_SHARE = 2e-3  # of the dry maximum load that the oil outside the domain may carry, in the mean over time
GAP_SHARE = 3.0  # initial gap in units of the trapped film, below which the shape depends on it
INLET_PRESSURE = 0.02  # p_h, half way to the edge upstream: what may be missing of a rolling contact's inlet
LARGE_ERROR = 0.1  # of a film: its estimated discretisation error from which it is said to be uncertain
CELLS_IN_WAVE = 16.0  # wanted across a wavelength, or the diameter of a spot


def warnings(case: Case, data: xr.Dataset) -> list[str]:
    """What a careful colleague would say about a run in time: what the grid, the domain or the gap do not give."""
    said = [_film_warning(data)]
    if case.kind == "impact":
        said += [_front_warning(case, data), _gap_warning(case), _domain_warning(data)]
    else:
        said += [_centre_warning(case)]
        if data.sizes["frame"]:
            said += [_inlet_warning(case, data["P"].isel(frame=-1), float(data["frame"][-1]))]
    return [sentence for sentence in (*said, _roughness_warning(case)) if sentence]


def steady_warnings(case: Case, solutions: Sequence[GridSolution]) -> list[str]:
    """What a careful colleague would say about a steady contact."""
    finest = solutions[-1]
    said = [_overlap_warning(finest), _error_warning(case, solutions), _spike_warning(solutions)]
    P = xr.DataArray(np.asarray(finest.whole(finest.P)), {"Y": finest.grid.y, "X": finest.grid.x}, ("Y", "X"))
    said += [_inlet_warning(case, P, 0.0), _centre_warning(case), _roughness_warning(case)]
    return [sentence for sentence in said if sentence]


def _inlet_warning(case: Case, P: xr.DataArray, T: float) -> str:
    """Half way to the edge upstream the edge's P = 0 is hardly felt.

    With M = 10 to 1000, L = 0 to 10 and the edge at 2.75 and 4.5 the films were thinner than with the edge at 9, by 0.2
    to 0.7 of the pressure there (p_h) where that is above 0.02.
    """
    s = case.solver
    upstream = -(s.inlet or s.half_width) if case.motion.entrainment(T) >= 0 else s.inlet or s.half_width
    half_way = float(P.sel(Y=0.0, method="nearest").sel(X=upstream / 2, method="nearest"))
    if half_way <= INLET_PRESSURE:
        return ""
    return (
        f"half way to the edge of the grid upstream the pressure is still {half_way:.2g} p_h: the films are too thin "
        f"by some {0.4 * half_way:.0%}, which their error estimate does not know; a larger solver.half_width is wanted"
    )


def _overlap_warning(finest: GridSolution) -> str:
    least = float(finest.H.min())
    if least > 0.0:
        return ""
    return (
        f"the surfaces overlap, H = {least:.3g} somewhere: the grid does not resolve the film; take more solver.nodes"
    )


def _error_warning(case: Case, solutions: Sequence[GridSolution]) -> str:
    if len(solutions) < 2:
        return "there is no error estimate, which takes a coarser grid: solver.nodes = 65 or more would do"
    if not solutions[-2].status.ok:
        return f"there is no error estimate: the grid of {solutions[-2].grid.nodes} nodes before did not converge"
    rolling = Rolling(tuple(solutions))
    found = {name: rolling.extrapolate(name) for name in variables.FILMS}
    shares = {name: e.error / abs(e.value) for name, e in found.items() if e.value}
    worst = max(shares, key=lambda name: shares[name])
    if shares[worst] <= LARGE_ERROR:
        return ""
    return (
        f"{worst} is uncertain by about {shares[worst]:.0%} on this grid; take more solver.nodes, "
        f"for example {2 * case.solver.nodes - 1}"
    )


def _spike_warning(solutions: Sequence[GridSolution]) -> str:
    if len(solutions) < 2:
        return ""
    coarse, fine = (s.measure()["P_max"] for s in solutions[-2:])
    if abs(fine - coarse) <= LARGE_ERROR * fine:
        return ""
    return (
        f"the pressure spike is not resolved, P_max goes from {coarse:.3g} to {fine:.3g}; the films do not depend on it"
    )


def _centre_warning(case: Case) -> str:
    s = case.solver
    cells = (s.inlet or s.half_width) * (s.nodes - 1) / (2 * s.half_width)
    if abs(cells - round(cells)) < 1e-6:
        return ""
    return (
        "the contact's centre is no node of this grid, H_c and P_c are those of the nearest; solver.inlet = 3/4 of "
        "the grid's length makes it one"
    )


def _roughness_warning(case: Case) -> str:
    spacing = 2 * case.solver.half_width / (case.solver.nodes - 1)
    sizes = [_size(feature.shape) for feature in case.roughness]
    cells = min(sizes, default=inf) / spacing
    if cells >= CELLS_IN_WAVE:
        return ""
    return (
        f"the finest roughness, {min(sizes):.3g} a wide, lies on {cells:.1f} cells, about {CELLS_IN_WAVE:.0f} are "
        f"wanted; solver.nodes = {(case.solver.nodes - 1) * CELLS_IN_WAVE / cells:.0f} or more would do"
    )


def _size(shape: Shape) -> float:
    """The width of a shape (a), infinite where it is not known."""
    match shape:
        case Waviness():
            return min(shape.wavelength_x, shape.wavelength_y)
        case RingWaviness():
            return shape.wavelength
        case Spot():
            return 2 * shape.radius
    return inf


def _film_warning(data: xr.Dataset) -> str:
    gone = np.flatnonzero(data["H_min"].values <= 0.0)
    if gone.size == 0:
        return ""
    first = data.isel(time=gone[0])
    return (
        f"the film vanishes on this grid, first at T = {float(first['time']):.4g}, X = {float(first['X_min']):.3g}: "
        "H_min means nothing from there on; more solver.nodes are wanted"
    )


def front_length(case: Case) -> float:
    """sqrt(alpha_bar lambda_bar dA/dT) in units a*, at the front position 0.9 with the dry contact's front speed."""
    p = case.parameters
    return float(np.sqrt(max(p.alpha_bar, 1.0) * p.lambda_bar * hertz.front_speed(FRONT_POSITION)))


def _front_warning(case: Case, data: xr.Dataset) -> str:
    axis = data["X"] if "X" in data.coords else data["r"]
    near = int(np.abs(axis.values - FRONT_POSITION).argmin())
    spacing = float(axis[near + 1] - axis[near])
    cells = front_length(case) / spacing
    if cells >= CELLS_IN_FRONT:
        return ""
    needed = (case.solver.nodes - 1) * CELLS_IN_FRONT / cells
    return (
        f"the front's pressure sweep sqrt(alpha_bar lambda_bar dA/dT) = {front_length(case):.3g} a* is resolved by "
        f"{cells:.1f} cells at X = {FRONT_POSITION}, about {CELLS_IN_FRONT:.0f} are wanted: H_min is uncertain; "
        f"solver.nodes = {needed:.0f} or more would do"
    )


def _gap_warning(case: Case) -> str:
    gap, film = -case.time.start_approach, case.parameters.trapped_film
    if gap >= GAP_SHARE * film:
        return ""
    return (
        f"the initial gap {gap:.3g} is comparable with the trapped film {film:.3g} (units a*^2/R): the film's shape "
        f"depends on it; time.start_approach = {-GAP_SHARE * film:.3g} or below removes this"
    )


def _domain_warning(data: xr.Dataset) -> str:
    if data.sizes["frame"] == 0:
        return ""
    share = float(missing_load(data).mean())
    if share <= MISSING_SHARE:
        return ""
    return (
        f"the oil outside the domain would carry about {share:.1%} of the dry maximum load in the mean over time: "
        "approach and load are off by about as much; a larger solver.half_width is wanted"
    )


def missing_load(data: xr.Dataset) -> xr.DataArray:
    """Load that the oil outside the domain would carry, in units of the dry maximum load, at each map.

    Far out the gap is r^2/2 and squeezed oil carries P ~ r^-4.  From P half way to the edge at w, where the
    edge's P = 0 is hardly felt, the rest is the integral of 2 pi r P beyond w: pi P(w/2) (w/2)^4 / w^2.
    """
    along = data["P"].isel(Y=data.sizes["Y"] // 2) if "Y" in data.dims else data["P"]
    axis = "X" if "X" in data.dims else "r"
    w = float(data[axis][-1])
    half_way = along.interp({axis: w / 2})
    return np.pi * half_way * (w / 2) ** 4 / w**2 / HERTZ_LOAD
