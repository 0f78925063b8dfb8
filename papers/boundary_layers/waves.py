"""Waviness in an impact: complete waves, their local operating parameter and amplitude, and the reduction curve."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline, RectBivariateSpline
from scipy.optimize import least_squares

from ertel import Parameters

Values = NDArray[np.float64]


class Wave(NamedTuple):
    """A complete wave of dH: amplitude (max - min)/2 (a*^2/R), place X halfway between crest and trough, ends (a*)."""

    amplitude: float
    X: float
    start: float
    end: float


def waves(X: ArrayLike, dH: ArrayLike, edge: float = 1.0) -> list[Wave]:
    """The complete waves of dH along 0 < X < edge, from the centre outwards.

    A wave reaches from a zero of dH to the next but one: one crest and one trough.  It is complete when both zeros lie
    inside; neighbours overlap by a half.  Zeros and extremes are those of the cubic spline through the nodes, so that
    crests between nodes are not cut off.

    Parameters
    ----------
    X : array_like, shape (n,)
        Positions along Y = 0, rising, in a*.
    dH : array_like, shape (n,)
        Film thickness with the waviness less the smooth one.
    edge : float
        Edge of the contact in a*: 1, or the place of the front.
    """
    spline = CubicSpline(np.asarray(X, dtype=float), np.asarray(dH, dtype=float))
    slope = spline.derivative()
    roots = (s.roots(extrapolate=False) for s in (spline, slope))
    zeros, turns = (np.sort(places[(places > 0) & (places < edge)]) for places in roots)
    return [_wave(spline, turns, start, end) for start, end in zip(zeros, zeros[2:], strict=False)]


def _wave(spline: CubicSpline, turns: Values, start: float, end: float) -> Wave:
    extremes = turns[(turns > start) & (turns < end)]
    values = spline(extremes)
    high, low = int(np.argmax(values)), int(np.argmin(values))
    amplitude = (values[high] - values[low]) / 2
    return Wave(float(amplitude), float(extremes[high] + extremes[low]) / 2, float(start), float(end))


def last_wave(X: ArrayLike, dH: ArrayLike, edge: float = 1.0) -> Wave:
    """The last complete wave inside the contact; its amplitude is the paper's A_d.  Arguments as in `waves`.

    Raises ValueError where no complete wave lies inside.
    """
    complete = waves(X, dH, edge)
    if not complete:
        raise ValueError(f"dH: no complete wave lies inside |X| < {edge}; take a shorter wavelength")
    return complete[-1]


def local_nabla2(parameters: Parameters, wavelength: float, speed: ArrayLike, A: ArrayLike = 1.0) -> Values:
    """Operating parameter nabla2 of eq. (16) with the speed of the front when it passed.

    lambda_bar -> lambda_bar v makes it the global one, `Parameters.nabla2`, over sqrt(v).  With A, the radius of the
    contact at that time, the Hertz radius and pressure are those of that time too, as in `theory.film_from_speed`:
    lambda_bar v/A^4, alpha_bar A, wavelength/A, which makes sqrt(A/v) of 1/sqrt(v).

    Parameters
    ----------
    parameters : Parameters
        Those of the impact.
    wavelength : float
        In a*.
    speed, A : array_like
        Speed of the front (a*/t0) and radius of the contact (a*), of shapes that broadcast.
    """
    ratio = np.asarray(A, dtype=float) / np.asarray(speed, dtype=float)
    return np.asarray(parameters.nabla2(wavelength) * np.sqrt(ratio))


def ridge_amplitude(X: ArrayLike, Y: ArrayLike, dH: ArrayLike, wavelength: float, r: ArrayLike) -> Values:
    """Remaining amplitude of ridges cos(2 pi X/wavelength) where the front moves along them.

    An outward moving front follows a crest along X = 0 and a trough along X = wavelength/2.  The amplitude
    is half the difference of dH between the two at the same distance from the centre, which the front passes at the
    same moment.

    Parameters
    ----------
    X, Y : array_like, shape (n,)
        Positions, rising, in a*.
    dH : array_like, shape (Y, X)
        Film thickness with the ridges less the smooth one.
    wavelength : float
        In a*.
    r : array_like, shape (m,)
        Distances from the centre in a*.

    Returns
    -------
    array, shape (m,)
        The amplitude; nan where r < wavelength/2, where there is no trough.
    """
    field = RectBivariateSpline(np.asarray(Y, dtype=float), np.asarray(X, dtype=float), np.asarray(dH, dtype=float))
    r, aside = np.asarray(r, dtype=float), wavelength / 2
    trough = np.sqrt(np.where(r > aside, r**2 - aside**2, np.nan))
    inside = np.isfinite(trough)
    amplitude = np.full(r.shape, np.nan)
    amplitude[inside] = np.abs(field.ev(trough[inside], aside) - field.ev(r[inside], 0.0)) / 2
    return amplitude


class Reduction(NamedTuple):
    """The curve A_d/A_i = 1/(1 + linear nabla2 + quadratic nabla2^2), of the form of eq. (15)."""

    linear: float
    quadratic: float

    def ratio(self, nabla2: ArrayLike) -> Values:
        """A_d/A_i, of the shape of nabla2."""
        n = np.asarray(nabla2, dtype=float)
        return np.asarray(1.0 / (1.0 + self.linear * n + self.quadratic * n**2))


def fit_reduction(nabla2: ArrayLike, ratio: ArrayLike, error: ArrayLike = 1.0) -> Reduction:
    """The curve of the form of eq. (15) by least squares of the ratios, in units of their errors.

    Parameters
    ----------
    nabla2, ratio : array_like, shape (n,)
        Operating parameter and A_d/A_i, two points at least.
    error : array_like
        Errors of the ratios, of a shape that broadcasts.
    """
    n, A, bar = (np.asarray(values, dtype=float) for values in (nabla2, ratio, error))
    fit = least_squares(lambda c: (Reduction(*c).ratio(n) - A) / bar, [0.15, 0.015], bounds=(0.0, np.inf))
    return Reduction(*map(float, fit.x))
