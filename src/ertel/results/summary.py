"""The summary of a run as plain data: values, restitution, error estimates, work, warnings, film formulas."""

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any

import numpy as np
import xarray as xr

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.equations import account
from ertel.equations.friction import coefficients
from ertel.equations.state import GridSolution, Rolling
from ertel.numerics.grid import Extrapolation
from ertel.results import budgets, diagnostics, errors, variables
from ertel.results.extremes import extremes, in_si
from ertel.results.parameters import parameters_of, scales_of
from ertel.results.temperatures import thermal_summary

OWN_NAMES = {"delta_m": "approach_m"}  # in SI, beside the scales, of which delta_m is one
TIMED = ("t_s", "f_N")  # of the values at maximum approach: those that rolling has in another sense, or not at all


def restitution(data: xr.Dataset) -> float | None:
    """Coefficient of restitution: speed after the impact over speed before; None until the ball has left.

    The ball is free when the load is gone: F below 1e-8 of the dry maximum.
    """
    if data.sizes["time"] == 0:
        return None
    V, F = float(data["V"][-1]), float(data["F"][-1])
    return -V if V < 0 and F < 1e-8 else None


def impact_summary(
    case: Case,
    data: xr.Dataset,
    max_approach: Mapping[str, float] | None,
    work: Mapping[str, float],
    status: Status,
) -> dict[str, Any]:
    """The outcome of an impact as plain data: parameters, values at maximum approach, restitution, work, status.

    `extremes` has the thinnest film and the highest pressure of the whole run, see `extremes.extremes`.
    `budgets` has those of mass, momentum and energy, see `budgets.in_time`.
    The values at maximum approach are under `max_approach`; but T and F they also stand where those of rolling do, None
    before it.  They have the power loss and, where the surfaces move along X, the coefficients of
    `equations.friction`.
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
    names = (*variables.AT_MAXIMUM, *(variables.FRICTION if case.motion.flows else ("power_loss",)))
    status, gone = _judged(status, data)
    if max_approach is not None and max_approach["T"] >= gone:
        max_approach = None
    reached = None
    if max_approach is not None:
        values = {key: float(max_approach[key]) for key in names}
        reached = _said(variables.with_coefficients(values, case.scales))
    found = {} if status.failed else budgets.in_time(case, data)
    top = {name: reached.get(name) if reached else None for name in names if name not in ("T", "F")}
    content: dict[str, Any] = {
        **_heading(case),
        **_said(top),
        "max_approach": reached,
        "restitution": restitution(data),
        "extremes": {} if status is Status.FILM_VANISHED else extremes(data),
        "budgets": found,
        **work,
        "status": status.value,
        "warnings": [*diagnostics.impact_warnings(case, data), *_accounts_warnings(case, data, found)],
    }
    si = si_summary(case, reached)
    return content if si is None else {**content, "si": {**si, **_parts_in_si(case, content)}}


def rolling_summary(
    case: Case,
    data: xr.Dataset,
    work: Mapping[str, float],
    status: Status,
) -> dict[str, Any]:
    """The outcome of rolling in time: T and the values at the last time, otherwise as in `steady_summary`.

    `extremes` and `budgets` are as in `impact_summary`.
    The errors of the films need a second run, see `rolling_with_error`.  Parameters as in `impact_summary`.
    """
    status, gone = _judged(status, data)
    names = ("time", *(() if status is Status.FILM_VANISHED else ("F", *variables.MEASURED, *variables.FRICTION)))
    last = {name: float(data[name][-1]) for name in names if name in data and len(data.time)}
    known = (*variables.MEASURED, *variables.FRICTION)
    measured = {"T": last.pop("time", None), **dict.fromkeys(known), **last}
    F = measured.pop("F", None)
    measured["load"] = None if F is None else F * case.geometry.hertz_load
    found = {} if status.failed else budgets.in_time(case, data)
    vanished = status is Status.FILM_VANISHED
    said = [diagnostics.no_film(case)] if vanished and gone == inf else diagnostics.rolling_warnings(case, data)
    said += [] if vanished else _accounts_warnings(case, data, found)
    counts = {"extremes": {} if vanished else extremes(data), "budgets": found, **work}
    return _rolling_summary(case, _said(measured), {}, counts, status, said)


def steady_summary(
    case: Case, solutions: Sequence[GridSolution], work: Mapping[str, float], status: Status
) -> dict[str, Any]:
    """The outcome of a steady run as plain data: parameters, values on the finest grid, errors, work, status, warnings.

    H_c_error and H_min_error estimate the discretisation error, H_c_extrapolated and H_min_extrapolated are without it;
    None with fewer than two grids.  `budgets` has the rates on the finest grid, see `budgets.steady`.
    mu_sliding, mu_rolling and power_loss are those of `equations.friction`; mu_sliding_y is there where it is not zero.
    In a physical case the coefficients are plain numbers; in a dimensionless one, where a/R is not known, they are
    multiples of it.
    `thermal` is there with a section [thermal], see `temperatures.thermal_summary`.
    Counts are those of all grids, convolutions in units of one on the finest.

    Parameters
    ----------
    case : Case
        The case of the run.
    solutions : sequence of GridSolution
        The solutions on all grids, coarsest first.
    work : mapping
        compilations, wall_s.
    status : Status
        How the run ended.
    """
    rolling = Rolling(tuple(solutions))
    if diagnostics.steady_failure(case, rolling.finest):
        return _failed_summary(case, rolling, work, status)
    estimates: dict[str, float] = {}
    if len(solutions) > 1 and all(s.status.ok for s in solutions[-2:]):
        for name in variables.FILMS:
            error = _error_of(rolling.extrapolate(name))
            estimates |= {f"{name}_{what}": value for what, value in error.items()}
    values = rolling.finest.measure()
    rates, friction = account.steady(case, rolling.finest)
    mu = variables.with_coefficients(coefficients(friction), case.scales)
    found = {**{name: values[name] for name in variables.MEASURED}, **_said(mu)}
    measured = {**_nodes(rolling), **found}
    terms = budgets.steady(case, rates, values["load"] / case.geometry.hertz_load)
    warmth, uncertain = thermal_summary(case, rolling.finest)
    said = [*diagnostics.steady_warnings(case, solutions), *diagnostics.budget_warnings(case, terms)]
    said += [*diagnostics.friction_warnings(case, found["mu_sliding"] or 0.0), *uncertain]
    parts = {"budgets": terms, **({"thermal": warmth} if warmth else {}), **_counts(rolling), **work}
    return _rolling_summary(case, measured, estimates, parts, status, said)


def _failed_summary(case: Case, rolling: Rolling, work: Mapping[str, float], status: Status) -> dict[str, Any]:
    """The summary of a steady run without a result: no film, no friction, no budgets."""
    measured = {**_nodes(rolling), **dict.fromkeys((*variables.MEASURED, *variables.FRICTION))}
    parts = {"budgets": {}, **_counts(rolling), **work}
    said = diagnostics.steady_warnings(case, rolling.solutions)
    return _rolling_summary(case, _said(measured), {}, parts, status, said)


def _nodes(rolling: Rolling) -> dict[str, float | None]:
    grid = rolling.finest.grid
    across = {} if grid.nodes_y == grid.nodes_x else {"nodes_y": grid.nodes_y}
    return {"nodes": grid.nodes_x, **across}


def _counts(rolling: Rolling) -> dict[str, float]:
    """The work on all grids."""
    return {
        "residual": rolling.finest.residual,
        "newton_iterations": sum(s.newton for s in rolling.solutions),
        "krylov_iterations": sum(s.krylov for s in rolling.solutions),
        "convolutions": round(rolling.convolutions, 1),
    }


def _judged(status: Status, data: xr.Dataset) -> tuple[Status, float]:
    """The status of a run in time, and the time at which its film vanished, infinite where it did not."""
    gone = data["time"].values[data["H_min"].values <= 0.0] if data.sizes["time"] else np.zeros(0)
    return (status.of_film(0.0), float(gone[0])) if gone.size else (status, inf)


def _accounts_warnings(case: Case, data: xr.Dataset, found: budgets.Budgets) -> list[str]:
    """The warnings of the budgets and of the friction of a run in time."""
    largest = float(np.abs(data["mu_sliding"]).max()) if data.sizes["time"] else 0.0
    return [*diagnostics.budget_warnings(case, found), *diagnostics.friction_warnings(case, largest)]


def _said(values: Mapping[str, float | None]) -> dict[str, float | None]:
    """The values without a traction coefficient along y that is zero: most contacts have the symmetry."""
    return {name: value for name, value in values.items() if value or name != "mu_sliding_y"}


def _rolling_summary(
    case: Case,
    measured: Mapping[str, float | None],
    estimates: Mapping[str, float],
    work: Mapping[str, Any],
    status: Status,
    said: list[str],
) -> dict[str, Any]:
    names = [f"{name}_{what}" for what in ("error", "extrapolated") for name in variables.FILMS]
    content: dict[str, Any] = {
        **_heading(case),
        **measured,
        **work,
        "status": status.value,
        **{name: estimates.get(name) for name in names},
        "warnings": said,
    }
    return _with_si(case, content)


def _with_si(case: Case, content: Mapping[str, Any]) -> dict[str, Any]:
    """A rolling contact's summary with its values in SI; approach_m is Delta, delta_m that of the dry contact."""
    if case.scales is None:
        return dict(content)
    names = ("T", *variables.MEASURED, *variables.FRICTION)
    values = {key: content[key] for key in content if key.startswith(variables.FILMS) or key in names}
    approach = variables.in_si({"Delta": values.pop("Delta")}, case.scales)["delta_m"]
    si: dict[str, Any] = {**scales_of(case), "approach_m": approach, **variables.in_si(values, case.scales)}
    return {**content, "si": {**si, **_parts_in_si(case, content)}}


def _parts_in_si(case: Case, content: Mapping[str, Any]) -> dict[str, Any]:
    """Extremes and budgets in SI, as far as a summary has them."""
    assert case.scales is not None
    found = {"extremes": in_si(content["extremes"], case.scales)} if "extremes" in content else {}
    return {**found, "budgets": budgets.in_si(case, content["budgets"])}


def attributes(summary: Mapping[str, Any]) -> dict[str, str | int | float]:
    """What the attributes of a Dataset say of the outcome: the plain values, and the imbalance of every budget."""
    found = {f"{name}_imbalance": terms["imbalance"] for name, terms in summary["budgets"].items()}
    return {key: value for key, value in {**summary, **found}.items() if isinstance(value, str | int | float)}


def si_summary(case: Case, max_approach: Mapping[str, float | None] | None) -> dict[str, object] | None:
    """An impact's summary in SI: the scales and the values at maximum approach; None for a dimensionless case.

    Names end with their unit: t_s, delta_m, f_N, p_c_Pa, p_max_Pa, h_c_m, h_min_m, x_min_m, y_min_m, power_loss_W; the
    coefficients mu_sliding and mu_rolling have none.
    """
    if case.scales is None:
        return None
    values = None if max_approach is None else variables.in_si(max_approach, case.scales)
    own = {
        "approach_m" if key == "delta_m" else key: value for key, value in (values or {}).items() if key not in TIMED
    }
    return {**scales_of(case), **own, "max_approach": values}


def _heading(case: Case) -> dict[str, Any]:
    return {"kind": case.kind, "method": case.solver.method, **parameters_of(case)}


def impact_with_error(fine: Mapping[str, Any], others: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """An impact's summary with the errors at maximum approach that other runs tell, see `errors.estimate`.

    They are under `error_estimate`: None where one of the runs did not reach maximum approach.
    """
    reached = {part: summary["max_approach"] for part, summary in others.items()}
    if fine["max_approach"] is None or None in reached.values():
        return {**fine, "error_estimate": None}
    found = {
        name: errors.estimate(fine["max_approach"][key], {part: values[key] for part, values in reached.items()})
        for name, key in {"H_c": "H_c", "H_min": "H_min", "Delta_max": "Delta"}.items()
    }
    return {**fine, **_ends(found), "error_estimate": {name: estimate.data() for name, estimate in found.items()}}


def rolling_with_error(case: Case, fine: Mapping[str, Any], others: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The summary of rolling with the errors of the films, steady or at the last time, that other runs tell.

    `error_estimate` has their parts, see `errors.estimate`.
    """
    found = {
        name: errors.estimate(fine[name], {part: summary[name] for part, summary in others.items()})
        for name in variables.FILMS
    }
    parts = {name: estimate.data() for name, estimate in found.items()}
    return _with_si(case, {**fine, **_ends(found), "error_estimate": parts})


def _ends(found: Mapping[str, errors.Estimate]) -> dict[str, float]:
    """Error and extrapolated value of the films."""
    whats = ("error", "extrapolated")
    return {f"{name}_{what}": getattr(found[name], what) for name in variables.FILMS for what in whats}


def _error_of(found: Extrapolation) -> dict[str, float]:
    return {"error": found.error, "extrapolated": found.extrapolated}
