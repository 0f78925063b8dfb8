"""The laws of the paper: its asymptotes of the dry impact, the film behind the front, amplitudes in line contacts.

The asymptotes measure time from maximum approach.  The paper uses t* for three different times.  Here `t_star` is half
the contact time in (20) and half the base of the parabola in (14), (22)-(24).
"""

from collections.abc import Callable, Mapping
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ertel import Parameters, formulas, fronts, hertz, line_formulas

Values = NDArray[np.float64]
FrontDefinition = Literal["film", "slope", "half-hertz"]

HALF_BASE = 1.35  # half the base of the parabola (22) that fits the impact best; the paper's t* = 2.7 is the full base
SPEED_EXPONENT = 0.67  # of the film in the speed: Hamrock and Dowson's, and the paper's
LINE_NABLA = 0.6076  # nabla1/nabla2 of the same wavelength, contact half width and alpha_bar lambda_bar
# Venner CH, Couhier F, Lubrecht AA, Greenwood JA. Proc Leeds-Lyon 1996 (1997:103-112), eq. (5)
LINE_1997 = 0.17, 0.03
LINE_REFIT = 0.125, 0.04  # a later fit, as quoted in the later literature; where it was first given is not known here


def johnson_radius(T: ArrayLike, t_star: float = hertz.HALF_CONTACT_TIME) -> Values:
    """Contact radius A = sqrt(cos(pi T/(2 t_star))), eq. (20), T from maximum approach; zero for |T| > t_star."""
    share = np.minimum(np.abs(np.asarray(T, dtype=float) / t_star), 1.0)
    return np.asarray(np.sqrt(np.cos(np.pi / 2 * share)))


def parabola_radius(T: ArrayLike, t_star: float = HALF_BASE) -> Values:
    """Contact radius A = sqrt(1 - T^2/t_star^2), eqs. (14), (22), T from maximum approach; zero for |T| > t_star."""
    return np.asarray(np.sqrt(np.maximum(1 - (np.asarray(T, dtype=float) / t_star) ** 2, 0.0)))


def parabola_front_speed(A: ArrayLike, t_star: float = HALF_BASE) -> Values:
    """Speed dA/dT = sqrt(1 - A^2)/(A t_star) of the advancing edge at A, by eq. (23); compare `hertz.front_speed`."""
    A = np.asarray(A, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(A >= 0, np.sqrt(1 - A**2) / (A * t_star), np.nan)


def linear_front_speed(T: ArrayLike, t_star: float = HALF_BASE) -> Values:
    """Speed dA/dT of the edge near maximum approach, eq. (24): v/v* = t_star dA/dT = -T/t_star, T from the maximum."""
    return -np.asarray(T, dtype=float) / t_star**2


def front(data: xr.Dataset, by: FrontDefinition = "film") -> fronts.Front:
    """Position and speed of the front of an impact, see `ertel.fronts.front`.

    by: its definition.  "film": the place of the minimum film thickness, at every step.  "slope": where the pressure
    falls most steeply outwards, on every map.  "half-hertz": from the place where the pressure is half of the Hertz
    maximum at the same approach, sqrt(Delta), of a line contact under the same load, sqrt(F), as the Hertz pressure is
    at sqrt(3)/2 of its radius; on every map.  The definitions on maps need an interval of 0.05 t0 or less.
    """
    return fronts.front(data, None if by == "film" else _by_pressure(data, _FALLS[by]))


def _by_pressure(data: xr.Dataset, fall: Callable[[Values, Values, float], float]) -> tuple[Values, Values]:
    if "frame" not in data.dims:
        raise ValueError('dataset: has one map only; by = "film" needs none')
    T = data["frame"].values
    squares = np.interp(T, data["time"].values, data["F" if data.attrs.get("radius_ratio") == 0 else "Delta"].values)
    r, P = outwards(data["P"])
    return T, np.array([fall(r, *each) for each in zip(P, np.sqrt(np.maximum(squares, 0.0)), strict=True)])


def outwards(field: xr.DataArray) -> tuple[Values, Values]:
    """Radius (n,) and field (..., n) along a radius: of a 2-D run and a line contact X >= 0, there on Y = 0."""
    if "r" in field.dims:
        return np.asarray(field["r"].values), np.asarray(field.values)
    middle = field.sel(Y=0.0, method="nearest") if "Y" in field.dims else field
    half = middle.isel(X=field["X"].values >= 0)
    return np.asarray(half["X"].values), np.asarray(half.values)


def _steepest_fall(r: Values, P: Values, highest: float) -> float:
    slope, middle = np.diff(P) / np.diff(r), (r[1:] + r[:-1]) / 2
    i = int(np.argmin(slope))
    if i in (0, len(slope) - 1):
        return np.nan
    (a, b), (c, d) = np.diff(middle[i - 1 : i + 2]), np.diff(slope[i - 1 : i + 2])  # of the parabola through three
    curvature, rise = (d / b - c / a) / (a + b), c / a
    return float(middle[i - 1] + a / 2 - rise / (2 * curvature)) if curvature else float(middle[i])


def _half_hertz(r: Values, P: Values, highest: float) -> float:
    half = highest / 2
    above = np.flatnonzero(P > half)
    if half == 0.0 or above.size == 0 or above[-1] == len(r) - 1:
        return np.nan
    i = int(above[-1])
    place = np.interp(half, P[[i + 1, i]], r[[i + 1, i]])
    return float(place * 2 / np.sqrt(3))


_FALLS: Mapping[str, Callable[[Values, Values, float], float]] = {"slope": _steepest_fall, "half-hertz": _half_hertz}


def fit_half_base(T: ArrayLike, A: ArrayLike, smallest: float = 0.5) -> float:
    """Half base t* of the paper's parabola A = sqrt(1 - T^2/t*^2), eq. (22), by least squares of A^2.

    Parameters
    ----------
    T, A : array_like, shape (n,)
        Time from the maximum, in any unit, and contact radius as a share of its maximum.
    smallest : float
        Only points with A > smallest are used.
    """
    T, A = np.asarray(T, dtype=float), np.asarray(A, dtype=float)
    squares = T[A > smallest] ** 2
    return float(np.sqrt(squares @ squares / (squares @ (1 - A[A > smallest] ** 2))))


class Trace(NamedTuple):
    """Film thickness H at X (a*) at maximum approach (a*^2/R), and the speed of the front when it passed X."""

    X: Values
    H: Values
    speed: Values


def film_behind_front(data: xr.Dataset, front: fronts.Front, X: ArrayLike) -> Trace:
    """Film thickness at maximum approach and the speed of the front that left it.

    Parameters
    ----------
    data : xarray.Dataset
        An impact, or its map at maximum approach.
    front : Front
        Its front, see `front`.
    X : array_like, shape (n,)
        Places (a*); those that the front did not pass are left out of the result.
    """
    X = np.asarray(X, dtype=float)
    r, H = outwards((fronts.at_max_approach(data) if "frame" in data.dims else data)["H"])
    speed = front.speed_at(X)
    passed = np.isfinite(speed)
    return Trace(X[passed], np.interp(X[passed], r, H), speed[passed])


def fit_power(trace: Trace, exponent: float = SPEED_EXPONENT) -> float:
    """Coefficient C of H = C v^exponent by least squares of the logarithms; the paper: 0.75 < X < 0.95 (Fig. 4)."""
    return float(np.exp(np.mean(np.log(trace.H / trace.speed**exponent))))


def film_from_speed(
    parameters: Parameters,
    speed: ArrayLike,
    A: ArrayLike = 1.0,
    formula: Callable[[float, float], float] | None = None,
) -> Values:
    """Film thickness (a*^2/R) of a steady formula for rolling where the front passed at `speed`; nothing is fitted.

    The front entrains oil as rolling at u_m = da/dt: lambda_bar -> lambda_bar v.  With A, the radius of the
    contact at that time, the Hertz radius and pressure are those of that time too: lambda_bar v/A^4, alpha_bar A, and
    the film scales back with A^2.

    Parameters
    ----------
    parameters : Parameters
        Those of the impact.
    speed, A : array_like
        Speed of the front (a*/t0) and radius of the contact (a*), of shapes that broadcast.
    formula : callable
        Film thickness in a^2/R from M and L; left out, that of Nijenbanning, Venner and Moes, of a line contact Moes'.
    """

    def at(v: float, radius: float) -> float:
        local = type(parameters)(parameters.lambda_bar * v / radius**4, parameters.alpha_bar * radius)
        if formula is None and local.radius_ratio == 0:
            return line_formulas.expected_line_film(local) * radius**2
        return (formula or formulas.nijenbanning_venner_moes)(local.M, local.L) * radius**2

    return np.asarray(np.vectorize(at, otypes=[float])(speed, A))


class Deviation(NamedTuple):
    """Relative deviation of a prediction from the truth: mean (with its sign), root mean square, maximum."""

    mean: float
    rms: float
    worst: float


def deviation(predicted: ArrayLike, true: ArrayLike) -> Deviation:
    """Relative deviation of a prediction from the truth, both of shape (n,)."""
    off = np.asarray(predicted, dtype=float) / np.asarray(true, dtype=float) - 1
    return Deviation(float(off.mean()), float(np.sqrt(np.mean(off**2))), float(np.abs(off).max()))


def in_line_contact(nabla2: ArrayLike, coefficients: tuple[float, float] = LINE_1997) -> Values:
    """A_d/A_i = 1/(1 + c1 nabla1 + c2 nabla1^2): transverse waviness in a line contact under pure rolling.

    nabla1 = (wavelength/b) M^{3/4}/L^{1/2} with the line contact's M and L (source as `LINE_1997`).  A line contact has
    alpha_bar lambda_bar = (3 pi^2/8)/sqrt(2 pi) L/M^{3/2}.  Therefore nabla1 = 0.608 nabla2 = 1.215
    (wavelength/b)/sqrt(alpha_bar lambda_bar).

    Parameters
    ----------
    nabla2 : array or number
        As in `ertel.amplitude_reduction.ratio_left`.
    coefficients : pair of floats
        c1 and c2: those published first, `LINE_1997`, or those of the later fit, `LINE_REFIT`.

    Returns
    -------
    array
        A_d/A_i, of the shape of nabla2.
    """
    n, (linear, quadratic) = LINE_NABLA * np.asarray(nabla2, dtype=float), coefficients
    return np.asarray(1.0 / (1.0 + linear * n + quadratic * n**2))
