"""The outcome of a run as plain data: values, restitution, error estimates, balances, work, warnings.

Last comes the error of a run in grid, time and domain together, from runs on the half grid that differ in one of them.
`comparisons` gives the cases of these runs; they cost about 1.2 times the run: 1/4 of its nodes, 1/4 in 1.4 times as
many steps, and 9/16.
"""

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import hypot, inf, isfinite
from typing import Any

import numpy as np
import xarray as xr

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.numerics.grid import Grid
from ertel.numerics.lobatto import Lobatto
from ertel.physics.motion import first_touch
from ertel.results import balances, diagnostics
from ertel.results.dataset import SteadyGrid, names_over
from ertel.results.friction import film_over_roughness, friction_warnings, touch_warnings
from ertel.results.numbers import ERRORS
from ertel.results.parameters import parameters_of, scale_values, values_in_si
from ertel.results.profiles import moment_of
from ertel.results.stress import stress_numbers
from ertel.results.variables import (
    COEFFICIENT,
    FILMS,
    START_APPROACH,
    TOUCH,
    VARIABLES,
    names_where,
    with_coefficients,
)

# share of a maximum by which the pressure may fall to the next nodes; below, P_max changes by some per cent
NARROW = 0.1
LIGHT = 0.01  # of the largest load, from which an impact counts as contact
FASTEST = 1.01  # speed of a ball that leaves, over that with which it came: above, the run is wrong
UNLOADED = 1e-8  # of the dry maximum load, below which the ball is free
EXTREMES = {"H_min": (np.argmin, "X_min", "Y_min"), "P_max": (np.argmax, "X_P_max", "Y_P_max")}  # and their places
Values = Mapping[str, float | None]


def impact_summary(
    case: Case, data: xr.Dataset, max_approach: Mapping[str, float] | None, work: Mapping[str, float], status: Status
) -> dict[str, Any]:
    """The outcome of an impact as plain data: parameters, values at maximum approach, restitution, work, status.

    The values are those of `VARIABLES` with `at_moment`, T and F among them; all are None before maximum approach and
    where the run failed.  They have the power loss and, where the surfaces move along X, the coefficients of friction
    of `equations.account`.
    `T_touch` is T at t = 0, the first touch of the undeformed bodies; times in SI count from there.
    `extremes` has the thinnest film and the highest pressure of the whole run, see `extremes`.
    `budgets` has those of mass, momentum and energy, see `balances.in_time`.
    A finished run has the stresses in body 1 at maximum approach, see `stress.stress_numbers`.
    All is dimensionless, F in units of the dry maximum load; physical cases add the same in SI under `si`.  The
    coefficients are plain numbers in a physical case, and in units a/R in a dimensionless one, where a/R is not known.

    data: the run so far, see `dataset.assemble`.  max_approach: the scalars at maximum approach; None before it.  work:
    counts of steps and iterations, compilations, wall_s.
    """
    status, vanished = _judged(status, data)
    flows = case.motion.flows
    there = ["T", *(name for name in _of_moment(data) if flows or VARIABLES[name].scale != COEFFICIENT)]
    values: Values = dict.fromkeys(there)
    if max_approach is not None and vanished == inf and not status.failed:
        values = with_coefficients({name: max_approach[name] for name in there if name in max_approach}, case.scales)
    over_time = _over_time(case, data, status)
    warnings = [*diagnostics.impact_warnings(case, data), *_faster(case, data)]
    warnings += [] if status.failed else _account_warnings(case, data, over_time)
    touch = first_touch(data["time"].values, data["Delta"].values, case.schedule.start_approach)
    stresses = _stresses(case, data, status) if max_approach is not None else {}
    content = {TOUCH: touch, **values, **stresses, **_contact(case, data, status), **over_time, **work}
    return _summary(case, content, status, warnings)


def rolling_summary(case: Case, data: xr.Dataset, work: Mapping[str, float], status: Status) -> dict[str, Any]:
    """The outcome of rolling in time: T and the values at the last time, otherwise as in `steady_summary`.

    `extremes` and `budgets` are as in `impact_summary`.
    The errors of the films need other runs, see `with_error`.  Parameters as in `impact_summary`.
    """
    status, vanished = _judged(status, data)
    values: dict[str, float | None] = dict.fromkeys(("T", *_of_moment(data)))
    over_time, warnings = _over_time(case, data, status), diagnostics.rolling_warnings(case, data)
    if data.sizes["time"]:
        values["T"] = float(data["time"][-1])
    if not status.failed:
        warnings += _account_warnings(case, data, over_time)
        if data.sizes["time"]:
            values |= {name: float(data[name][-1]) for name in values if name in data}
    elif status is Status.FILM_VANISHED and vanished == inf:
        warnings = [diagnostics.no_film(case)]
    load = values.pop("F")
    values["load"] = None if load is None else load * case.geometry.hertz_load
    return _summary(case, {**values, **_stresses(case, data, status), **over_time, **work}, status, warnings)


def steady_summary(
    case: Case, solutions: Sequence[SteadyGrid], work: Mapping[str, float], status: Status
) -> dict[str, Any]:
    """The outcome of a steady run as plain data: parameters, values on the finest grid, errors, work, status, warnings.

    H_c_error and H_min_error estimate the discretisation error, H_c_extrapolated and H_min_extrapolated are without it;
    None with fewer than two grids.  `budgets` has the rates on the finest grid, see `balances.steady`.
    mu_sliding, mu_rolling and power_loss are those of `equations.account`; mu_sliding_y is there where it is not zero.
    In a physical case the coefficients are plain numbers; in a dimensionless one, where a/R is not known, they are
    multiples of it.
    The numbers of `heat_numbers` are there with a section [thermal], and `thermal` about their computing; those of
    `stress.stress_numbers` of a finished run.
    Counts are those of all grids, convolutions in units of one on the finest.  A run without a result has no values, no
    friction and no balances.

    solutions: on all grids, coarsest first.  work: compilations, wall_s.
    """
    finest = solutions[-1]
    grid = finest.grid
    across = case.method.space.across(case.solver)
    counts = {
        "nodes": grid.nodes,
        **({} if across in (1, grid.nodes) else {"nodes_y": across}),
        "residual": finest.residual,
        **{name: sum(s.record[name] for s in solutions) for name in ("newton_iterations", "krylov_iterations")},
        "convolutions": round(sum(s.record["convolutions"] * s.grid.size / grid.size for s in solutions), 1),
        **work,
    }
    values, parts, warnings = steady_values(case, solutions)
    if status.ok and values["H_c"] is not None:
        values |= stress_numbers(case, {**finest.maps, **grid.coordinates})
    return _summary(case, {**counts, **values, **parts}, status, warnings)


def steady_values(case: Case, solutions: Sequence[SteadyGrid]) -> tuple[dict[str, Any], dict[str, Any], list[str]]:
    """The values of a steady contact on the finest grid, None without a solution; errors, balances, heat; warnings."""
    finest, there = solutions[-1], names_over(case, "step", "grid")
    record, warnings = with_coefficients(finest.record, case.scales), diagnostics.steady_warnings(case, solutions)
    values: dict[str, Any] = {name: record[name] for name in _of_moment(record) if name in there}
    if diagnostics.steady_failure(case, finest):
        return dict.fromkeys(values), {"budgets": {}}, warnings
    parts: dict[str, Any] = {"budgets": balances.steady(case, record, record["load"] / case.geometry.hertz_load)}
    warnings += diagnostics.balance_warnings(case, parts["budgets"])
    warnings += friction_warnings(case, record["mu_sliding"])
    for name, film in diagnostics.film_errors(case, solutions).items():
        parts |= {f"{name}_error": film.error, f"{name}_extrapolated": film.extrapolated}
    if (heat := finest.heat) is not None:
        values |= heat_numbers(case, finest)
        watts = dict(zip(("released", "into_body_1", "into_body_2", "with_the_oil"), heat.balance, strict=True))
        about = {"iterations": heat.iterations, "converged": heat.converged, "heat_W": watts}
        parts["thermal"] = {"inlet": case.thermal.inlet, **about}  # type: ignore[union-attr]
        warnings += diagnostics.thermal_warnings(case, heat)
    return values, parts, warnings


def _place_of_largest(T: Any, grid: Grid) -> list[float]:
    """zeta, Y and X of the largest value of a field across the film, shape (points, n_y, n_x)."""
    axes = np.ravel(Lobatto.of(len(T)).z), grid.kept_y, grid.x
    return [float(axis[i]) for axis, i in zip(axes, np.unravel_index(np.argmax(T), T.shape), strict=True)]


def heat_numbers(case: Case, solution: SteadyGrid) -> dict[str, float | None]:
    """The numbers of a steady contact with heat; coefficients are plain numbers, temperatures in K.

    L_t: thermal loading.  T_1_max, T_2_max, T_film_max: highest temperatures of the surfaces and of the film (mean
    across it).  T_film_mean: that of the film on average over the contact, weighted with the pressure.  T_max, X_T_max,
    Y_T_max (in a), zeta_T_max: the highest temperature of the oil, and its place.  They are None where they have not
    converged.
    With a formula of the inlet besides: phi_T, its factor.  H_c_warm, H_min_warm: the films on the grid with that
    factor; as shown they are extrapolated.  mu_sliding_warm, power_loss_warm: traction and power loss of that film.
    """
    heat, maps = solution.heat, solution.maps
    assert case.scales is not None
    assert case.thermal is not None
    quick = {} if case.thermal.is_solved else {"mu_sliding_warm": float(heat.sliding[0]) * case.scales.a_over_R}
    warm = {
        **quick,
        **{f"{name}_max": float(np.max(maps[name])) for name in ("T_1", "T_2", "T_film")},
        "T_film_mean": float(np.average(maps["T_film"], weights=maps["P"])),
        "T_max": case.thermal.temperature + float(np.max(heat.T)),
        **dict(zip(("zeta_T_max", "Y_T_max", "X_T_max"), _place_of_largest(heat.T, solution.grid), strict=True)),
    }
    found = warm if heat.converged else dict.fromkeys(warm)
    if quick:
        films = {f"{name}_warm": heat.inlet.factor * solution.record[name] for name in FILMS}
        less = (
            (solution.record["mu_sliding"] - float(heat.sliding[0])) * case.motion.load(0.0) * case.motion.sliding(0.0)
        )
        found |= {**films, "phi_T": heat.inlet.factor, "power_loss_warm": solution.record["power_loss"] - less}
    return {"L_t": heat.inlet.L_t, **found}


def _stresses(case: Case, data: xr.Dataset, status: Status) -> dict[str, float]:
    """The stresses of a finished run in time, at the moment of its values."""
    return stress_numbers(case, data.isel(frame=moment_of(data).frame)) if status.ok else {}


def _of_moment(there: Container[Any]) -> list[str]:
    """The names of the values of a summary that are there."""
    return [name for name in names_where(lambda variable: variable.at_moment) if name in there]


def _contact(case: Case, data: xr.Dataset, status: Status) -> dict[str, float | None]:
    """Restitution, the time in which the load is above `LIGHT` of its largest value, and that value.

    The coefficient of restitution is the speed after the impact over that before; all is None until the ball has left,
    and where the run failed or the ball is too fast.
    """
    T, V, F, Delta = (data[name].values for name in ("time", "V", "F", "Delta"))
    left = len(T) and V[-1] < 0 and (F[-1] < UNLOADED or Delta[-1] < data.attrs[START_APPROACH])
    if status.failed or not left or list(_faster(case, data)):
        return dict.fromkeys(names_where(lambda variable: variable.of_impact))
    above = np.flatnonzero(F > LIGHT * F.max())
    ends = [max(above[0] - 1, 0), above[0]], [min(above[-1] + 1, len(T) - 1), above[-1]]  # the lighter side first
    start, end = (float(np.interp(LIGHT * F.max(), F[pair], T[pair])) for pair in ends)
    return {"restitution": -float(V[-1]), "contact_time": end - start, "F_max": float(F.max())}


def _faster(case: Case, data: xr.Dataset) -> Iterator[str]:
    """A warning if a ball to which nothing adds energy is faster at the end than when it came."""
    alone = case.motion.load.is_constant and not case.motion.flows
    if alone and data.sizes["time"] and data["V"][-1] < -FASTEST:
        yield (
            f"the ball leaves {-float(data['V'][-1]):.3g} times as fast as it came, so the run has no restitution: its "
            "first film pressed on it; use a lower time.start_approach, and a finer grid"
        )


def _judged(status: Status, data: xr.Dataset) -> tuple[Status, float]:
    """The status of a run in time, and the time at which its film vanished, infinite where it did not."""
    gone = data["time"].values[data["H_min"].values <= 0.0]
    if not gone.size:
        return status, inf
    return status if status.failed else Status.FILM_VANISHED, float(gone[0])


def _over_time(case: Case, data: xr.Dataset, status: Status) -> dict[str, Any]:
    """The extremes and the balances of a run in time; empty where it failed."""
    if status.failed:
        return {"extremes": {}, "budgets": {}}
    return {"extremes": extremes(data), "budgets": balances.in_time(case, data)}


def _account_warnings(case: Case, data: xr.Dataset, over_time: Mapping[str, Any]) -> list[str]:
    """The warnings about the balances and the friction of a run in time."""
    largest = float(np.abs(data["mu_sliding"].values).max(initial=0.0))
    return [*diagnostics.balance_warnings(case, over_time["budgets"]), *friction_warnings(case, largest)]


def _summary(case: Case, content: Mapping[str, Any], status: Status, warnings: list[str]) -> dict[str, Any]:
    """The summary, with None for errors that are not known.

    A traction coefficient along y that is zero is left out: most contacts have the symmetry.
    """
    warnings = [*warnings, *touch_warnings(case, content)]
    heading = {"kind": case.kind, "method": case.solver.method, **parameters_of(case), **dict.fromkeys(ERRORS)}
    known = {name: value for name, value in content.items() if value or name != "mu_sliding_y"}
    known |= film_over_roughness(case, content)
    return with_si(case, {**heading, **_finite(known), "status": status.value, "warnings": warnings})


def _finite(content: Any) -> Any:
    """Plain data with None in the place of what is not a number: JSON has none."""
    if isinstance(content, Mapping):
        return {key: _finite(value) for key, value in content.items()}
    return None if isinstance(content, float) and not isfinite(content) else content


def with_si(case: Case, content: Mapping[str, Any]) -> dict[str, Any]:
    """A summary with the scales of a physical case, its values, extremes and balances in SI.

    Names end with their unit: h_min_m, t_s, x_m, y_m.  approach_m is Delta, delta_m that of the dry contact.
    """
    if case.scales is None:
        return dict(content)
    converted = partial(values_in_si, scales=case.scales, zero=content.get(TOUCH) or 0.0)
    si: dict[str, Any] = {**scale_values(case), **converted(content)}
    si |= {"approach_m": si.pop("delta_m"), "delta_m": scale_values(case)["delta_m"]}
    si["budgets"] = balances.terms_in_si(case, content["budgets"])
    if "extremes" in content:
        extreme = content["extremes"].items()
        si["extremes"] = {name: converted({**one, name: one["value"]}) for name, one in extreme}
    return {**content, "si": si}


def attributes(summary: Mapping[str, Any]) -> dict[str, str | int | float]:
    """The attributes of a Dataset that tell the outcome: the plain values, and the imbalance of every balance."""
    imbalances = {f"{name}_imbalance": terms["imbalance"] for name, terms in summary["budgets"].items()}
    return {key: value for key, value in {**summary, **imbalances}.items() if isinstance(value, str | int | float)}


def extremes(data: xr.Dataset) -> dict[str, dict[str, Any]]:
    """The smallest H_min and the largest P_max over all steps; empty before the first step.

    By name: `value` (dimensionless), `T` (t0), `X` and `Y` (a*; a line contact has X alone), and `note`, empty or what
    is to be said of the value.
    """
    content = {}
    for name, (extreme, x, y) in EXTREMES.items() if data.sizes["time"] else ():
        step = data.isel(time=int(extreme(data[name].values)))
        places = {"value": name, "T": "time", "X": x, "Y": y}
        values = {key: float(step[variable]) for key, variable in places.items() if variable in data}
        fall, note = float(step["P_fall"]), ""
        if name == "P_max" and fall > NARROW:
            note = f"it depends on the grid: the peak is few nodes wide, {fall:.0%} lower at the next nodes"
        content[name] = {**values, "note": note}
    return content


# -- the error in grid, time and domain --------------------------------------------------------------------------------

SMALLER_STEPS = 0.5**0.5  # of the run for the error in time: half the error of second order
WIDER_DOMAIN = 1.5  # of the run for the error of the domain
ORDERS = {"restitution": 1.0}  # in the spacing, where they are not 2; seen are 1.3 to 2.2


def comparisons(case: Case) -> Mapping[str, Case]:
    """The cases by the part of the error that they tell: "grid", "time" (not if steady), "domain"."""
    half = case.on_half_grid()
    cases = {"grid": half, "domain": replace(half, solver=half.method.space.wider(half.solver, WIDER_DOMAIN))}
    if case.time is not None:
        cases["time"] = replace(half, time=case.time.with_steps(SMALLER_STEPS))
    return cases


def error_estimate(name: str, fine: float, others: Mapping[str, float]) -> dict[str, Any]:
    """The error of a value from the same value of other runs: the size of its parts, and the value with them added.

    grid: on the half grid.  time: there in smaller steps, by sqrt(1/2).  domain: there on a domain 1.5 times as wide.
    The error is of second order in the spacing, see `ORDERS`, and in the step, and of third order in 1/width: the oil
    outside carries a share 1/width^2 of the load, and its far field misses 1/width.  The parts are independent of each
    other as far as they cancel; where they have one sign the error reaches to the extrapolated value.
    """
    half = others["grid"]
    parts = {"grid": (fine - half) / (2.0 ** ORDERS.get(name, 2.0) - 1.0)}
    for name, factor in (("time", SMALLER_STEPS**2), ("domain", WIDER_DOMAIN**-3)):
        if name in others:
            parts[name] = (others[name] - half) / (1 - factor)
    dominant = max(parts, key=lambda name: abs(parts[name]))
    extrapolated = fine + sum(parts.values())
    error = max(abs(extrapolated - fine), hypot(*parts.values()))
    return {"value": fine, "error": error, "extrapolated": extrapolated, **parts, "dominant": dominant}


def with_error(case: Case, fine: Mapping[str, Any], others: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The summary of a run with the errors that other runs tell, of all its numbers with `has_error` in `VARIABLES`.

    The films also have theirs as H_c_error, H_c_extrapolated, ...; all errors with their parts are under
    `error_estimate`.  Those of an impact hold at maximum approach and, restitution, contact time and largest load, for
    the whole of it.  `error_estimate` is None where one of the runs did not reach maximum approach.

    fine: the summary of the run.  others: those of the other runs, by their part as in `comparisons`.
    """
    if any(summary["H_c"] is None for summary in (fine, *others.values())):
        return {**fine, "error_estimate": None}
    estimates = {}
    for name in names_where(lambda variable: variable.has_error):
        known: list[Any] = [summary.get(name) for summary in (fine, *others.values())]
        if all(known) and len(set(known)) > 1:  # else it is given, or zero
            estimates[name] = error_estimate(name, known[0], dict(zip(others, known[1:], strict=True)))
    content = {**fine, "error_estimate": estimates}
    for name in FILMS:
        content |= {f"{name}_{ending}": estimates[name][ending] for ending in ("error", "extrapolated")}
    return with_si(case, content | film_over_roughness(case, content))
