"""What a run says: restitution, warnings about resolution and domain, and the summary."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ertel import dataset, hertz
from ertel.case import Case
from ertel.status import Status

CELLS_IN_FRONT = 10.0  # wanted across sqrt(alpha_bar lambda_bar dA/dT), the length of the front's pressure sweep
FRONT_POSITION = 0.9  # where the front is looked at: the films of interest lie inside
EDGE_SHARE = 1e-3  # of the load that the outermost tenth of the domain may carry
GAP_SHARE = 3.0  # initial gap in units of the trapped film, below which the shape depends on it


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
    said = [_film_warning(data), _front_warning(case, data), _gap_warning(case), _edge_warning(data)]
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


def _edge_warning(data: xr.Dataset) -> str:
    if data.sizes["frame"] == 0:
        return ""
    share = edge_load(data)
    if share <= EDGE_SHARE:
        return ""
    return (
        f"{share:.1%} of the load at the largest map sits in the outermost tenth of the domain: "
        "a larger solver.half_width is wanted"
    )


def edge_load(data: xr.Dataset) -> float:
    """Largest share of the load, over the maps in the loaded phase, that the outermost tenth of the domain carries."""
    P = data["P"].values
    if "r" in data.coords:
        r = data["r"].values
        weight, outside = np.gradient(r) * r, r > 0.9 * r[-1]
    else:
        x, y = np.abs(data["X"].values), np.abs(data["Y"].values)
        weight, outside = np.ones(P.shape[1:]), (x[None, :] > 0.9 * x[-1]) | (y[:, None] > 0.9 * y[-1])
    load = (P * weight).reshape(len(P), -1).sum(axis=1)
    edge = (P * weight * outside).reshape(len(P), -1).sum(axis=1)
    loaded = load > 0.1 * load.max()
    return float((edge[loaded] / load[loaded]).max()) if load.max() > 0 else 0.0


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
