"""The contact front of an impact, and the film that it leaves behind."""

from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ertel.results.parameters import geometry_of
from ertel.results.profiles import events_of

Values = NDArray[np.float64]

SMALLEST_FRONT = 0.1  # a*: before, there is a bell of pressure and no contact yet
LOADED_FRONT = 0.02  # of the maximum pressure: where there is less, the film is only a gap
FRONT_WINDOW = 0.06  # delta*/v0 to both sides: window of the parabola that gives the speed of the front


def at_max_approach(data: xr.Dataset) -> xr.Dataset:
    """The maps of an impact at maximum approach.

    Raises ValueError where the run ended before maximum approach.
    """
    events = events_of(data)
    if "max-approach" not in events:
        raise ValueError("dataset: has no map at maximum approach, the run ended before it")
    return data.isel(frame=events["max-approach"])


class Front(NamedTuple):
    """The advancing front of the contact: times T (t0), positions A (a*), speeds dA/dT (a*/t0), each of shape (n,)."""

    T: Values
    A: Values
    speed: Values

    def passed(self, X: ArrayLike) -> Values:
        """T (t0) at which the front passed X (a*), of any shape; nan where it did not."""
        X = np.asarray(X, dtype=float)
        reached = np.maximum.accumulate(self.A)  # round-off may set it back near the end
        inside = (X >= reached[0]) & (X <= reached[-1])
        return np.where(inside, np.interp(X, reached, self.T), np.nan)

    def speed_at(self, X: ArrayLike) -> Values:
        """Speed of the front dA/dT (a*/t0) when it passed X (a*), of any shape; nan where it did not."""
        return np.interp(self.passed(X), self.T, self.speed)


def front(data: xr.Dataset, places: tuple[Values, Values] | None = None) -> Front:
    """Position and speed of the front of an impact up to maximum approach.

    The speed is that of a parabola for A^2, which behaves as Delta, fitted to the neighbours in time.

    Parameters
    ----------
    data : xarray.Dataset
        An impact, radial, of a line contact, or in the plane.
    places : pair of arrays (n,), optional
        Times and positions of the front by a definition of one's own, nan where there is none; left out: the place of
        the minimum film thickness, at every step.

    Raises
    ------
    ValueError
        If there are too few times, for example because too few maps were kept.
    """
    turning = float(at_max_approach(data)["frame"]) if "frame" in data.dims else float(data["frame"])
    T, A = places or _front_by_film(data)
    advancing = (T <= turning) & np.isfinite(A) & (A > SMALLEST_FRONT)
    T, A = T[advancing], A[advancing]
    first = int(np.argmin(A)) if len(A) else 0  # before, the pressure only gathers
    T, A = T[first:], A[first:]
    if len(T) < 4:
        raise ValueError("dataset: has too few times to see its front; keep maps more often")
    window = FRONT_WINDOW * geometry_of(data.attrs).dry_approach(1.0)
    squares, rates = np.transpose([_parabola(T, A**2, t, window) for t in T])
    radius = np.sqrt(squares)
    return Front(T, radius, rates / (2 * radius))


def _front_by_film(data: xr.Dataset) -> tuple[Values, Values]:
    loaded = data["P_max"].values > LOADED_FRONT * float(data["P_max"].max())
    return data["time"].values, np.where(loaded, distance_of_minimum(data), np.nan)


def distance_of_minimum(data: xr.Dataset) -> Values:
    """The distance of the minimum film thickness from the centre (a*) at every step, (n,)."""
    return np.hypot(data["X_min"].values, data["Y_min"].values if "Y_min" in data else 0.0)


def _parabola(T: Values, values: Values, t: float, window: float) -> tuple[float, float]:
    """Value and rate at t of a parabola fitted to at least five neighbours of t in time."""
    near = np.argsort(np.abs(T - t))[: max(5, int(np.count_nonzero(np.abs(T - t) <= window)))]
    _, rate, value = np.polyfit(T[near] - t, values[near], min(2, len(near) - 1))
    return float(value), float(rate)
