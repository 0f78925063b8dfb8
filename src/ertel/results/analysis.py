"""What a run says: restitution, error estimates and the summary; the front, the film behind it, and waves."""

from collections.abc import Callable, Mapping, Sequence
from math import cbrt
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline, RectBivariateSpline
from scipy.optimize import least_squares

from ertel.model.approach import HERTZ_LOAD
from ertel.model.case import Case
from ertel.model.state import GridSolution, Rolling
from ertel.model.status import Status
from ertel.physics import film_formulas
from ertel.physics.film_formulas import Film
from ertel.physics.scales import HamrockDowson, Parameters
from ertel.results import diagnostics, variables


def at_max_approach(data: xr.Dataset) -> xr.Dataset:
    """The maps at maximum approach.  Raises ValueError where the run has not come so far."""
    found = np.flatnonzero(data["event"].values == variables.EVENTS.index("max-approach"))
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


def summary(
    case: Case,
    data: xr.Dataset,
    max_approach: Mapping[str, float] | None,
    work: Mapping[str, float],
    status: Status,
) -> dict[str, Any]:
    """The outcome of a run in time as plain data: parameters, values, work, status.

    Of an impact: the values at maximum approach, F in units of the dry maximum load, and the restitution.  Of rolling:
    the values at the last time, as in `steady_summary`, and T; their errors need a second run, see `with_error`.
    All dimensionless; physical cases add the same in SI under `si`.
    """
    said = diagnostics.warnings(case, data)
    if case.kind == "rolling":
        last = {
            name: float(data[name][-1])
            for name in ("time", "F", *variables.MEASURED)
            if name in data and len(data.time)
        }
        measured = {"T": last.pop("time", None), **dict.fromkeys(variables.MEASURED), **last}
        F = measured.pop("F", None)
        measured["load"] = None if F is None else F * HERTZ_LOAD
        return _rolling_summary(case, measured, {}, work, status, said)
    reached = None if max_approach is None else {key: float(max_approach[key]) for key in variables.AT_MAXIMUM}
    content: dict[str, Any] = {
        "kind": case.kind,
        "method": case.solver.method,
        **_parameters(case),
        "max_approach": reached,
        "restitution": restitution(data),
        **work,
        "status": status.value,
        "warnings": said,
    }
    si = variables.si_summary(case, reached)
    return content if si is None else {**content, "si": si}


def steady_summary(
    case: Case, solutions: Sequence[GridSolution], work: Mapping[str, float], status: Status
) -> dict[str, Any]:
    """The outcome of a steady run as plain data: parameters, values on the finest grid, their errors, work, status.

    H_c_error, H_min_error estimate the discretisation error, H_c_extrapolated, H_min_extrapolated are without it; None
    where there are no two grids.  Counts are those of all grids, convolutions in units of one on the finest.
    work: compilations, wall_s.
    """
    rolling = Rolling(tuple(solutions))
    counts = {
        "residual": rolling.finest.residual,
        "newton_iterations": sum(s.newton for s in solutions),
        "krylov_iterations": sum(s.krylov for s in solutions),
        "convolutions": round(rolling.convolutions, 1),
    }
    estimates: dict[str, float] = {}
    if len(solutions) > 1 and all(s.status.ok for s in solutions[-2:]):
        for name in variables.FILMS:
            found = rolling.extrapolate(name)
            estimates |= {f"{name}_error": found.error, f"{name}_extrapolated": found.extrapolated}
    values = rolling.finest.measure()
    measured = {"nodes": rolling.finest.grid.nodes, **{name: values[name] for name in variables.MEASURED}}
    said = diagnostics.steady_warnings(case, solutions)
    return _rolling_summary(case, measured, estimates, {**counts, **work}, status, said)


def _rolling_summary(
    case: Case,
    measured: Mapping[str, float | None],
    estimates: Mapping[str, float],
    work: Mapping[str, float],
    status: Status,
    said: list[str],
) -> dict[str, Any]:
    names = [f"{name}_{what}" for what in ("error", "extrapolated") for name in variables.FILMS]
    content: dict[str, Any] = {
        "kind": case.kind,
        "method": case.solver.method,
        **_parameters(case),
        **measured,
        **work,
        "status": status.value,
        **{name: estimates.get(name) for name in names},
        "warnings": said,
    }
    return _with_si(case, content)


def _with_si(case: Case, content: Mapping[str, Any]) -> dict[str, Any]:
    """A rolling contact's summary with its values in SI; approach_m is Delta, delta_m its scale."""
    if case.scales is None:
        return dict(content)
    values = {
        key: content[key] for key in content if key.startswith(variables.FILMS) or key in ("T", *variables.MEASURED)
    }
    approach = variables.in_si({"Delta": values.pop("Delta")}, case.scales)["delta_m"]
    si = {**variables.scales_of(case), "approach_m": approach, **variables.in_si(values, case.scales)}
    return {**content, "si": si}


def _parameters(case: Case) -> dict[str, float]:
    p = case.parameters
    return {"M": p.M, "L": p.L, "lambda_bar": p.lambda_bar, "alpha_bar": p.alpha_bar}


def films(case: Case, load: float = 1.0, entrainment: float = 1.0) -> list[Film]:
    """What the formulas say of a rolling contact with a load w (F*) and a speed U (u_m), in the case's own a^2/R.

    Empty where there is no load or no speed, in which they have no meaning.
    """
    speed = abs(entrainment)
    if load <= 0 or speed == 0:
        return []
    p = case.parameters
    at = Parameters.from_moes(p.M * load * speed**-0.75, p.L * speed**0.25)
    ugw = variables.ugw_of(case) if case.scales else None
    found = film_formulas.films(at, ugw and HamrockDowson(ugw.U * speed, ugw.G, ugw.W * load))
    unit = cbrt(load) ** 2  # the formulas' a^2 is that of the load w

    def own(film: float | None) -> float | None:
        return None if film is None else film * unit

    return [film._replace(central=own(film.central), minimum=own(film.minimum)) for film in found]


def with_error(case: Case, fine: Mapping[str, Any], coarse: Mapping[str, Any]) -> dict[str, Any]:
    """The summary of a run in time with the discretisation errors that a run on the half grid tells.

    For a method of second order the error is a third of the difference, and the value without it, `extrapolated`, lies
    as much beyond the fine one (Richardson).  Of an impact under `error_estimate`, at maximum approach, None where one
    of the runs did not reach it; of rolling as in `steady_summary`, at the last time.
    """
    if case.kind == "impact":
        return {**fine, "error_estimate": error_estimate(fine, coarse)}
    found: dict[str, float] = {}
    for name in variables.FILMS:
        step = (fine[name] - coarse[name]) / 3
        found |= {f"{name}_error": abs(step), f"{name}_extrapolated": fine[name] + step}
    return _with_si(case, {**fine, **found})


def error_estimate(fine: Mapping[str, Any], coarse: Mapping[str, Any]) -> dict[str, Any] | None:
    """Discretisation error of H_c, H_min and Delta at maximum approach, see `with_error`."""
    if fine["max_approach"] is None or coarse["max_approach"] is None:
        return None
    estimate = {}
    for name, key in {"H_c": "H_c", "H_min": "H_min", "Delta_max": "Delta"}.items():
        value, half = fine["max_approach"][key], coarse["max_approach"][key]
        step = (value - half) / 3
        estimate[name] = {"value": value, "half_grid": half, "error": abs(step), "extrapolated": value + step}
    return estimate


# -- the front of an impact, and what it leaves behind -----------------------------------------------------------------

Values = NDArray[np.float64]
FrontDefinition = Literal["film", "slope", "half-hertz"]

SMALLEST_FRONT = 0.1  # a*: before, there is a bell of pressure and no contact yet
LOADED_FRONT = 0.02  # of the largest pressure: where there is less, the film is only a gap
FRONT_WINDOW = 0.06  # t0 to both sides, over which a parabola gives the front's speed
SPEED_EXPONENT = 0.67  # of the film in the speed: Hamrock and Dowson's, and the paper's


class Front(NamedTuple):
    """Where the contact's front is while it advances: times T, positions A (a*), speeds dA/dT (a*/t0), each (n,)."""

    T: Values
    A: Values
    speed: Values

    def passed(self, X: ArrayLike) -> Values:
        """When the front passed X, of any shape; nan where it did not."""
        X = np.asarray(X, dtype=float)
        reached = np.maximum.accumulate(self.A)  # round-off may set it back near the end
        inside = (X >= reached[0]) & (X <= reached[-1])
        return np.where(inside, np.interp(X, reached, self.T), np.nan)

    def speed_at(self, X: ArrayLike) -> Values:
        """The front's speed dA/dT when it passed X, of any shape; nan where it did not."""
        return np.interp(self.passed(X), self.T, self.speed)


def front(data: xr.Dataset, by: FrontDefinition = "film") -> Front:
    """Position and speed of an impact's front up to maximum approach, radial or 2-D (there along Y = 0).

    by "film": the place of the least film, at every step.  "slope": where the pressure falls most steeply outwards, on
    every map.  "half-hertz": from the place where the pressure is half of Hertz' largest at the same approach,
    sqrt(Delta), as Hertz' is at sqrt(3)/2 of its radius; on every map.  From maps it takes an interval (`Output`) of
    0.05 t0 or less.  The speed is that of a parabola for A^2, which behaves as Delta, fitted to the neighbours in time.

    Raises ValueError where there are too few times, as without maps in the course of time.
    """
    turning = float(at_max_approach(data)["frame"]) if "frame" in data.dims else float(data["frame"])
    T, A = _front_by_film(data) if by == "film" else _front_by_pressure(data, _FALLS[by])
    found = (T <= turning) & np.isfinite(A) & (A > SMALLEST_FRONT)
    T, A = T[found], A[found]
    first = int(np.argmin(A)) if len(A) else 0  # before, the pressure only gathers
    T, A = T[first:], A[first:]
    if len(T) < 4:
        raise ValueError(f'dataset: has too few times to see its front by "{by}"; keep maps more often')
    fits = [_parabola(T, A**2, t) for t in T]
    radius = np.sqrt([square for square, _ in fits])
    return Front(T, radius, np.array([rate for _, rate in fits]) / (2 * radius))


def _front_by_film(data: xr.Dataset) -> tuple[Values, Values]:
    loaded = data["P_max"].values > LOADED_FRONT * float(data["P_max"].max())
    return data["time"].values, np.where(loaded, data["X_min"].values, np.nan)


def _front_by_pressure(data: xr.Dataset, fall: Callable[[Values, Values, float], float]) -> tuple[Values, Values]:
    if "frame" not in data.dims:
        raise ValueError('dataset: has one map only; by = "film" needs none')
    T = data["frame"].values
    approach = np.interp(T, data["time"].values, data["Delta"].values)
    r, P = _outwards(data["P"])
    return T, np.array([fall(r, p, delta) for p, delta in zip(P, approach, strict=True)])


def _outwards(field: xr.DataArray) -> tuple[Values, Values]:
    """Radius (n,) and field (..., n) along a radius: the half line Y = 0, X >= 0 of a 2-D run."""
    if "r" in field.dims:
        return np.asarray(field["r"].values), np.asarray(field.values)
    half = field.sel(Y=0.0, method="nearest").isel(X=field["X"].values >= 0)
    return np.asarray(half["X"].values), np.asarray(half.values)


def _steepest_fall(r: Values, P: Values, approach: float) -> float:
    slope, middle = np.diff(P) / np.diff(r), (r[1:] + r[:-1]) / 2
    i = int(np.argmin(slope))
    return np.nan if i in (0, len(slope) - 1) else _vertex(middle[i - 1 : i + 2], slope[i - 1 : i + 2])


def _half_hertz(r: Values, P: Values, approach: float) -> float:
    half = np.sqrt(max(approach, 0.0)) / 2
    above = np.flatnonzero(P > half)
    if half == 0.0 or above.size == 0 or above[-1] == len(r) - 1:
        return np.nan
    i = int(above[-1])
    place = np.interp(half, P[[i + 1, i]], r[[i + 1, i]])
    return float(place * 2 / np.sqrt(3))


_FALLS: Mapping[str, Callable[[Values, Values, float], float]] = {"slope": _steepest_fall, "half-hertz": _half_hertz}


def _vertex(x: Values, y: Values) -> float:
    """Where the parabola through three points is extreme."""
    (a, b), (c, d) = np.diff(x), np.diff(y)
    curvature, slope = (d / b - c / a) / (a + b), c / a
    return float(x[0] + a / 2 - slope / (2 * curvature)) if curvature else float(x[1])


def _parabola(T: Values, values: Values, t: float) -> tuple[float, float]:
    """Value and rate at t of the parabola fitted to the neighbours of t in time, to five of them at least."""
    near = np.argsort(np.abs(T - t))[: max(5, int(np.count_nonzero(np.abs(T - t) <= FRONT_WINDOW)))]
    _, rate, value = np.polyfit(T[near] - t, values[near], min(2, len(near) - 1))
    return float(value), float(rate)


def fit_half_base(T: ArrayLike, A: ArrayLike, smallest: float = 0.5) -> float:
    """t* of the paper's parabola A = sqrt(1 - T^2/t*^2), eq. (22), by least squares of A^2 where A > smallest.

    T: time from the maximum; A: contact radius as a share of the largest; both (n,).
    """
    T, A = np.asarray(T, dtype=float), np.asarray(A, dtype=float)
    squares = T[A > smallest] ** 2
    return float(np.sqrt(squares @ squares / (squares @ (1 - A[A > smallest] ** 2))))


class Trace(NamedTuple):
    """What the front left behind: film H at maximum approach and speed of the front when it passed, at X, each (n,)."""

    X: Values
    H: Values
    speed: Values


def film_behind_front(data: xr.Dataset, front: Front, X: ArrayLike) -> Trace:
    """The film at maximum approach against the front's speed, where the front passed (the other X are left out)."""
    X = np.asarray(X, dtype=float)
    r, H = _outwards((at_max_approach(data) if "frame" in data.dims else data)["H"])
    speed = front.speed_at(X)
    passed = np.isfinite(speed)
    return Trace(X[passed], np.interp(X[passed], r, H), speed[passed])


def fit_power(trace: Trace, exponent: float = SPEED_EXPONENT) -> float:
    """C of H = C v^exponent by least squares of the logarithms; the paper fits on 0.75 < X < 0.95 (Fig. 4)."""
    return float(np.exp(np.mean(np.log(trace.H / trace.speed**exponent))))


def film_from_speed(
    parameters: Parameters,
    speed: ArrayLike,
    A: ArrayLike = 1.0,
    formula: Callable[[float, float], float] = film_formulas.nijenbanning_venner_moes,
) -> Values:
    """Film (a*^2/R) that a steady film formula gives where the front ran at `speed`, with nothing fitted.

    The front drags oil in as rolling at u_m = da/dt does: lambda_bar -> lambda_bar v.  With A, the radius that the
    contact had then, Hertz' radius and pressure are those of that moment too: lambda_bar v/A^4, alpha_bar A, and the
    film scales back with A^2.  formula: H of M and L, in units a^2/R.  Shapes broadcast.
    """

    def at(v: float, radius: float) -> float:
        local = Parameters(parameters.lambda_bar * v / radius**4, parameters.alpha_bar * radius)
        return formula(local.M, local.L) * radius**2

    return np.asarray(np.vectorize(at, otypes=[float])(speed, A))


class Deviation(NamedTuple):
    """Of a prediction from the truth, relative: mean (which side it errs on), root mean square, worst."""

    mean: float
    rms: float
    worst: float


def deviation(predicted: ArrayLike, true: ArrayLike) -> Deviation:
    """How far a prediction is off, relative to the truth, both (n,)."""
    off = np.asarray(predicted, dtype=float) / np.asarray(true, dtype=float) - 1
    return Deviation(float(off.mean()), float(np.sqrt(np.mean(off**2))), float(np.abs(off).max()))


# -- waviness in an impact ---------------------------------------------------------------------------------------------


class Wave(NamedTuple):
    """A complete wave of dH: its amplitude (max - min)/2, its place X halfway between crest and trough, its ends."""

    amplitude: float
    X: float
    start: float
    end: float


def waves(X: ArrayLike, dH: ArrayLike, edge: float = 1.0) -> list[Wave]:
    """The complete waves of dH along 0 < X < edge, from the centre outwards.

    A wave is what lies between a zero of dH and the next but one: one crest and one trough.  It is complete when both
    zeros lie inside; neighbours overlap by a half.  Zeros and extremes are those of the cubic spline through the nodes,
    so that crests between nodes are not cut off.

    X : (n,) rising, in a*.  dH : (n,), along Y = 0.  edge: of the contact, 1 or the place of the front.
    """
    spline = CubicSpline(np.asarray(X, dtype=float), np.asarray(dH, dtype=float))
    slope = spline.derivative()
    zeros, turns = (_inside(s.roots(extrapolate=False), edge) for s in (spline, slope))
    return [_wave(spline, turns, start, end) for start, end in zip(zeros, zeros[2:], strict=False)]


def _inside(places: Values, edge: float) -> Values:
    return np.sort(places[(places > 0) & (places < edge)])


def _wave(spline: CubicSpline, turns: Values, start: float, end: float) -> Wave:
    extremes = turns[(turns > start) & (turns < end)]
    values = spline(extremes)
    high, low = int(np.argmax(values)), int(np.argmin(values))
    amplitude = (values[high] - values[low]) / 2
    return Wave(float(amplitude), float(extremes[high] + extremes[low]) / 2, float(start), float(end))


def last_wave(X: ArrayLike, dH: ArrayLike, edge: float = 1.0) -> Wave:
    """The last complete wave inside the contact, whose amplitude is the paper's A_d; see `waves`.

    Raises ValueError where no complete wave lies inside.
    """
    found = waves(X, dH, edge)
    if not found:
        raise ValueError(f"dH: no complete wave lies inside |X| < {edge}; take a shorter wavelength")
    return found[-1]


def local_nabla2(parameters: Parameters, wavelength: float, speed: ArrayLike, A: ArrayLike = 1.0) -> Values:
    """nabla2 of eq. (16) with the front's speed when it passed, lambda_bar -> lambda_bar dA/dT: the global one/sqrt(v).

    With A, the radius that the contact had then, Hertz' radius and pressure are those of that moment too, as in
    `film_from_speed`: lambda_bar v/A^4, alpha_bar A, wavelength/A, which makes sqrt(A/v) of 1/sqrt(v).

    wavelength in a*; speed in a*/t0, A in a*, of shapes that broadcast.  `Parameters.nabla2` is the global one.
    """
    ratio = np.asarray(A, dtype=float) / np.asarray(speed, dtype=float)
    return np.asarray(parameters.nabla2(wavelength) * np.sqrt(ratio))


def ridge_amplitude(X: ArrayLike, Y: ArrayLike, dH: ArrayLike, wavelength: float, r: ArrayLike) -> Values:
    """Amplitude (n,) that is left of ridges cos(2 pi X/wavelength) where a front runs along them, at radii r (n,).

    Along X = 0 a front that runs outwards meets a crest lengthwise, along X = wavelength/2 a trough: half of what dH
    differs between the two, at the same distance from the centre, as the front passes both at the same moment.  Where
    r < wavelength/2 there is no trough, and nan.

    X, Y : (n,) rising, in a*.  dH : (Y, X).  r in a*.
    """
    field = RectBivariateSpline(np.asarray(Y, dtype=float), np.asarray(X, dtype=float), np.asarray(dH, dtype=float))
    r, aside = np.asarray(r, dtype=float), wavelength / 2
    trough = np.sqrt(np.where(r > aside, r**2 - aside**2, np.nan))
    known = np.isfinite(trough)
    amplitude = np.full(r.shape, np.nan)
    amplitude[known] = np.abs(field.ev(trough[known], aside) - field.ev(r[known], 0.0)) / 2
    return amplitude


class Reduction(NamedTuple):
    """A_d/A_i = 1/(1 + linear nabla2 + quadratic nabla2^2), of the form of eq. (15)."""

    linear: float
    quadratic: float

    def ratio(self, nabla2: ArrayLike) -> Values:
        """A_d/A_i, of the shape of nabla2."""
        n = np.asarray(nabla2, dtype=float)
        return np.asarray(1.0 / (1.0 + self.linear * n + self.quadratic * n**2))


def fit_reduction(nabla2: ArrayLike, ratio: ArrayLike, error: ArrayLike = 1.0) -> Reduction:
    """The curve of the form of eq. (15) through A_d/A_i, by least squares of the ratios in units of their errors.

    nabla2, ratio : (n,), two points at least.  error: of the ratios, of a shape that broadcasts.
    """
    n, A, bar = (np.asarray(values, dtype=float) for values in (nabla2, ratio, error))
    found = least_squares(lambda c: (Reduction(*c).ratio(n) - A) / bar, [0.15, 0.015], bounds=(0.0, np.inf))
    return Reduction(*map(float, found.x))
