"""The summary of a run as plain data: values, restitution, error estimates, work, warnings."""

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any

import numpy as np
import xarray as xr

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.numerics.grid import extrapolate
from ertel.results import balances, diagnostics
from ertel.results.dataset import SteadyGrid
from ertel.results.parameters import parameters_of, scale_values
from ertel.results.variables import AT_MAXIMUM, FILMS, FRICTION, MEASURED, TEMPERATURES, values_in_si, with_coefficients

# share of a maximum by which the pressure may fall to the next nodes; below, P_max changes by some per cent
NARROW = 0.1
LIGHT = 0.01  # of the largest load, from which an impact counts as contact
EXTREMES = {"H_min": np.argmin, "P_max": np.argmax}
PLACES = {"H_min": ("X_min", "Y_min"), "P_max": ("X_P_max", "Y_P_max")}


def restitution(data: xr.Dataset) -> float | None:
    """Coefficient of restitution: speed after the impact over speed before; None until the ball has left.

    The ball is free when the load is gone: F below 1e-8 of the dry maximum.
    """
    if data.sizes["time"] == 0:
        return None
    V, F = float(data["V"][-1]), float(data["F"][-1])
    return -V if V < 0 and F < 1e-8 else None


def _contact(data: xr.Dataset) -> dict[str, float | None]:
    """Restitution, the time in which the load is above `LIGHT` of its largest value, and that value; None before."""
    e = restitution(data)
    if e is None:
        return dict.fromkeys(("restitution", "contact_time", "F_max"))
    T, F = data["time"].values, data["F"].values
    above = np.flatnonzero(F > LIGHT * F.max())
    ends = [max(above[0] - 1, 0), above[0]], [above[-1] + 1, above[-1]]  # the lighter side first
    start, end = (float(np.interp(LIGHT * F.max(), F[pair], T[pair])) for pair in ends)
    return {"restitution": e, "contact_time": end - start, "F_max": float(F.max())}


def impact_summary(
    case: Case,
    data: xr.Dataset,
    max_approach: Mapping[str, float] | None,
    work: Mapping[str, float],
    status: Status,
) -> dict[str, Any]:
    """The outcome of an impact as plain data: parameters, values at maximum approach, restitution, work, status.

    `extremes` has the thinnest film and the highest pressure of the whole run, see `extremes`.
    `budgets` has those of mass, momentum and energy, see `balances.in_time`.
    The values at maximum approach are under `max_approach`; but T and F they also stand where those of rolling do, None
    before it.  They have the power loss and, where the surfaces move along X, the coefficients of
    `equations.account`.
    All is dimensionless, F in units of the dry maximum load; physical cases add the same in SI under `si`.  The
    coefficients are plain numbers in a physical case, and in units a/R in a dimensionless one, where a/R is not known.

    Parameters
    ----------
    case : Case
        The case of the run.
    data : xarray.Dataset
        The run so far, see `dataset.assemble`.
    max_approach : mapping or None
        The scalars at maximum approach; None before it.
    work : mapping
        Counts of steps and iterations, compilations, wall_s.
    status : Status
        How the run ended.
    """
    status, vanished = _judged(status, data)
    names = (*AT_MAXIMUM, *(FRICTION if case.motion.flows else ("power_loss",)))
    reached = None
    if max_approach is not None and max_approach["T"] < vanished:
        values = {name: float(max_approach[name]) for name in names}
        reached = _without_zero(with_coefficients(values, case.scales))
    top = _without_zero({name: (reached or {}).get(name) for name in names if name not in ("T", "F")})
    contact = _contact(data)
    content: dict[str, Any] = {
        **_heading(case),
        **top,
        "max_approach": reached,
        **contact,
        **_over_time(case, data, status),
        **work,
        "status": status.value,
    }
    content["warnings"] = diagnostics.impact_warnings(case, data) + _account_warnings(case, data, content["budgets"])
    if case.scales is None:
        return content
    whole = {name: contact[name] for name in ("contact_time", "F_max")}
    si = {
        **_numbers_in_si(case, top if reached else {}),
        **values_in_si(whole, case.scales),
        "max_approach": reached and values_in_si(reached, case.scales),
    }
    return {**content, "si": {**si, **_parts_in_si(case, content)}}


def rolling_summary(case: Case, data: xr.Dataset, work: Mapping[str, float], status: Status) -> dict[str, Any]:
    """The outcome of rolling in time: T and the values at the last time, otherwise as in `steady_summary`.

    `extremes` and `budgets` are as in `impact_summary`.
    The errors of the films need other runs, see `errors.with_error`.  Parameters as in `impact_summary`.
    """
    status, vanished = _judged(status, data)
    is_film = status is not Status.FILM_VANISHED
    names = ("F", *MEASURED, *FRICTION) if is_film else ()
    last = {name: float(data[name][-1]) for name in ("time", *names) if name in data and len(data.time)}
    values = {"T": last.pop("time", None), **dict.fromkeys((*MEASURED, *FRICTION)), **last}
    F = values.pop("F", None)
    values["load"] = None if F is None else F * case.geometry.hertz_load
    parts = _over_time(case, data, status)
    warnings = diagnostics.rolling_warnings(case, data)
    if is_film:
        warnings += _account_warnings(case, data, parts["budgets"])
    elif vanished == inf:
        warnings = [diagnostics.no_film(case)]
    return _rolling_summary(case, _without_zero(values), {}, {**parts, **work}, status, warnings)


def steady_summary(
    case: Case, solutions: Sequence[SteadyGrid], work: Mapping[str, float], status: Status
) -> dict[str, Any]:
    """The outcome of a steady run as plain data: parameters, values on the finest grid, errors, work, status, warnings.

    H_c_error and H_min_error estimate the discretisation error, H_c_extrapolated and H_min_extrapolated are without it;
    None with fewer than two grids.  `budgets` has the rates on the finest grid, see `balances.steady`.
    mu_sliding, mu_rolling and power_loss are those of `equations.account`; mu_sliding_y is there where it is not zero.
    In a physical case the coefficients are plain numbers; in a dimensionless one, where a/R is not known, they are
    multiples of it.
    `thermal` is there with a section [thermal], see `thermal_summary`.
    Counts are those of all grids, convolutions in units of one on the finest.  A run without a result has no values, no
    friction and no balances.

    Parameters
    ----------
    case : Case
        The case of the run.
    solutions : sequence of SteadyGrid
        The solutions on all grids, coarsest first.
    work : mapping
        compilations, wall_s.
    status : Status
        How the run ended.
    """
    finest = solutions[-1]
    grid = finest.grid
    nodes = {"nodes": grid.nodes_x, **({} if grid.nodes_y == grid.nodes_x else {"nodes_y": grid.nodes_y})}
    counts = {
        "residual": finest.residual,
        "newton_iterations": sum(s.record["newton_iterations"] for s in solutions),
        "krylov_iterations": sum(s.record["krylov_iterations"] for s in solutions),
        "convolutions": round(sum(s.record["convolutions"] * s.grid.size / grid.size for s in solutions), 1),
        **work,
    }
    warnings = diagnostics.steady_warnings(case, solutions)
    if diagnostics.steady_failure(case, finest):
        values = {**nodes, **_without_zero(dict.fromkeys((*MEASURED, *FRICTION)))}
        return _rolling_summary(case, values, {}, {"budgets": {}, **counts}, status, warnings)
    record = with_coefficients(finest.record, case.scales)
    terms = balances.steady(case, record, record["load"] / case.geometry.hertz_load)
    warnings += [*diagnostics.balance_warnings(case, terms), *diagnostics.friction_warnings(case, record["mu_sliding"])]
    parts: dict[str, Any] = {"budgets": terms}
    if finest.heat is not None:
        parts["thermal"] = thermal_summary(case, finest)
        warnings += diagnostics.thermal_warnings(case, finest.heat)
    values = {**nodes, **_without_zero({name: record[name] for name in (*MEASURED, *FRICTION)})}
    return _rolling_summary(case, values, _estimates(case, solutions), {**parts, **counts}, status, warnings)


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


def _estimates(case: Case, solutions: Sequence[SteadyGrid]) -> dict[str, float]:
    """Errors and extrapolated values of the films; empty without two grids that converged.

    On a layer of oil a film changes irregularly from grid to grid where the meniscus is in the contact.
    """
    if len(solutions) < 2 or not all(s.status.ok for s in solutions[-2:]):
        return {}
    estimates: dict[str, float] = {}
    for name in FILMS:
        *coarser, coarse, fine = (s.measure()[name] for s in solutions)
        film = extrapolate(coarse, fine, *(coarser[-1:] if case.layer else ()))
        estimates |= {f"{name}_error": film.error, f"{name}_extrapolated": film.extrapolated}
    return estimates


def _judged(status: Status, data: xr.Dataset) -> tuple[Status, float]:
    """The status of a run in time, and the time at which its film vanished, infinite where it did not."""
    gone = data["time"].values[data["H_min"].values <= 0.0] if data.sizes["time"] else np.zeros(0)
    return (status.of_film(0.0), float(gone[0])) if gone.size else (status, inf)


def _over_time(case: Case, data: xr.Dataset, status: Status) -> dict[str, Any]:
    """The extremes and the balances of a run in time, as far as its film is one."""
    return {
        "extremes": {} if status is Status.FILM_VANISHED else extremes(data),
        "budgets": {} if status.failed else balances.in_time(case, data),
    }


def _account_warnings(case: Case, data: xr.Dataset, terms: balances.Balances) -> list[str]:
    """The warnings about the balances and the friction of a run in time."""
    largest = float(np.abs(data["mu_sliding"]).max()) if data.sizes["time"] else 0.0
    return [*diagnostics.balance_warnings(case, terms), *diagnostics.friction_warnings(case, largest)]


def _without_zero(values: Mapping[str, float | None]) -> dict[str, float | None]:
    """The values without a traction coefficient along y that is zero: most contacts have the symmetry."""
    return {name: value for name, value in values.items() if value or name != "mu_sliding_y"}


def _heading(case: Case) -> dict[str, Any]:
    return {"kind": case.kind, "method": case.solver.method, **parameters_of(case)}


def _rolling_summary(
    case: Case,
    values: Mapping[str, float | None],
    estimates: Mapping[str, float],
    parts: Mapping[str, Any],
    status: Status,
    warnings: list[str],
) -> dict[str, Any]:
    names = [f"{name}_{ending}" for ending in ("error", "extrapolated") for name in FILMS]
    content = {**_heading(case), **values, **parts, "status": status.value}
    return with_si(case, {**content, **{name: estimates.get(name) for name in names}, "warnings": warnings})


# -- in SI ------------------------------------------------------------------------------------------------------------


def with_si(case: Case, content: Mapping[str, Any]) -> dict[str, Any]:
    """A rolling contact's summary with its values in SI."""
    if case.scales is None:
        return dict(content)
    names = ("T", *MEASURED, *FRICTION)
    values = {name: content[name] for name in content if name.startswith(FILMS) or name in names}
    return {**content, "si": {**_numbers_in_si(case, values), **_parts_in_si(case, content)}}


def _numbers_in_si(case: Case, values: Mapping[str, float | None]) -> dict[str, Any]:
    """The scales and the values; approach_m is Delta, delta_m that of the dry contact."""
    assert case.scales is not None
    converted = values_in_si(values, case.scales)
    return {
        **scale_values(case),
        **{"approach_m" if name == "delta_m" else name: converted[name] for name in converted},
    }


def _parts_in_si(case: Case, content: Mapping[str, Any]) -> dict[str, Any]:
    """Extremes and balances, as far as a summary has them; names end with their unit: h_min_m, t_s, x_m, y_m."""
    assert case.scales is not None
    parts: dict[str, Any] = {"budgets": balances.terms_in_si(case, content["budgets"])}
    if "extremes" in content:
        parts["extremes"] = {
            name: values_in_si({name: one["value"], **{key: one[key] for key in ("T", "X", "Y")}}, case.scales)
            for name, one in content["extremes"].items()
        }
    return parts


def attributes(summary: Mapping[str, Any]) -> dict[str, str | int | float]:
    """The attributes of a Dataset that tell the outcome: the plain values, and the imbalance of every balance."""
    imbalances = {f"{name}_imbalance": terms["imbalance"] for name, terms in summary["budgets"].items()}
    return {key: value for key, value in {**summary, **imbalances}.items() if isinstance(value, str | int | float)}


# -- extremes ---------------------------------------------------------------------------------------------------------


def extremes(data: xr.Dataset) -> dict[str, dict[str, Any]]:
    """The smallest H_min and the largest P_max over all steps; empty before the first step.

    By name: `value` (dimensionless), `T` (t0), `X` and `Y` (a*), and `note`, empty or what is to be said of the value.
    """
    if data.sizes["time"] == 0:
        return {}
    content = {}
    for name, extreme in EXTREMES.items():
        step = data.isel(time=int(extreme(data[name].values)))
        X, Y = (float(step[place]) for place in PLACES[name])
        note = _note_on_peak(float(step["P_fall"])) if name == "P_max" else ""
        content[name] = {"value": float(step[name]), "T": float(step["time"]), "X": X, "Y": Y, "note": note}
    return content


def _note_on_peak(fall: float) -> str:
    if fall <= NARROW:
        return ""
    return f"it depends on the grid: the peak is few nodes wide, {fall:.0%} lower at the next nodes"
