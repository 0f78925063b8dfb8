"""What a run says: restitution, warnings about resolution and domain, and the summary."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ertel import dataset, hertz
from ertel.case import Case
from ertel.closure import HERTZ_LOAD
from ertel.status import Status

CELLS_IN_FRONT = 10.0  # wanted across sqrt(alpha_bar lambda_bar dA/dT), the length of the front's pressure sweep
FRONT_POSITION = 0.9  # where the front is looked at: the films of interest lie inside
MISSING_SHARE = 2e-3  # of the dry maximum load that the oil outside the domain may carry, in the mean over time
GAP_SHARE = 3.0  # initial gap in units of the trapped film, below which the shape depends on it


def at_max_approach(data: xr.Dataset) -> xr.Dataset:
    """The maps at maximum approach.  Raises ValueError where the run has not come so far."""
    found = np.flatnonzero(data["event"].values == dataset.EVENTS.index("max-approach"))
    if found.size == 0:
        raise ValueError("dataset: has no map at maximum approach, the run ended before it")
    return data.isel(frame=int(found[0]))


def restitution(data: xr.Dataset) -> float | None:
    """Speed after the impact over speed before, once the film has opened again; None before that.

    The ball is free when the load is gone: F below 1e-8 of the dry maximum.
    """
    if data.sizes["time"] == 0:
        return None
    V, F = float(data["V"][-1]), float(data["F"][-1])
    return -V if V < 0 and F < 1e-8 else None


def warnings(case: Case, data: xr.Dataset) -> list[str]:
    """What a careful colleague would say about a run: front not resolved, domain too small, gap too small."""
    said = [_film_warning(data), _front_warning(case, data), _gap_warning(case), _domain_warning(data)]
    return [sentence for sentence in said if sentence]


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


def summary(
    case: Case,
    data: xr.Dataset,
    max_approach: Mapping[str, float] | None,
    work: Mapping[str, float],
    status: Status,
) -> dict[str, Any]:
    """The outcome of a run as plain data: parameters, values at maximum approach, restitution, work, status.

    All dimensionless, F in units of the dry maximum load; physical cases add the same in SI under `si`.
    """
    p = case.parameters
    reached = None if max_approach is None else {key: float(max_approach[key]) for key in dataset.AT_MAXIMUM}
    content: dict[str, Any] = {
        "kind": case.kind,
        "lambda_bar": p.lambda_bar,
        "alpha_bar": p.alpha_bar,
        "M": p.M,
        "L": p.L,
        "max_approach": reached,
        "restitution": restitution(data),
        **work,
        "status": status.value,
        "warnings": warnings(case, data),
    }
    si = dataset.si_summary(case, reached)
    return content if si is None else {**content, "si": si}


def error_estimate(fine: Mapping[str, Any], coarse: Mapping[str, Any]) -> dict[str, Any] | None:
    """Discretisation error of H_c, H_min and Delta at maximum approach, from summaries on a grid and on its half.

    For a method of second order the error is a third of the difference, and the value without it, `extrapolated`, lies
    as much beyond the fine one (Richardson).  None where one of the runs did not reach its maximum.
    """
    if fine["max_approach"] is None or coarse["max_approach"] is None:
        return None
    estimate = {}
    for name, key in {"H_c": "H_c", "H_min": "H_min", "Delta_max": "Delta"}.items():
        value, half = fine["max_approach"][key], coarse["max_approach"][key]
        step = (value - half) / 3
        estimate[name] = {"value": value, "half_grid": half, "error": abs(step), "extrapolated": value + step}
    return estimate
