"""A run as an instrument shows it: the light along a line, and values whose zero, scale or place is not known.

An interferometer measures the optical path n h and an intensity, in arbitrary units, of a place whose zero it does not
know.  What is shown is

    factor computed(x - centre) + offset + tilt (x - mean x)

with the unknown parts for which the squares of the differences from the measured values are smallest.  The factor is
the gain of an intensity, or n/n_assumed of a film that was computed with an assumed index of the oil.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

Values = NDArray[np.float64]
FACTORS, LEVELS = ("index", "gain"), ("offset", "background")  # one of each, by the quantity
SHIFTS = 401  # of the centre that are tried before the best is refined
LEAST = 1e-3  # of the ratio of measured to computed values: a factor is above zero, or fringes would be inverted
PLACES = 8001  # along a line, where its light is computed: fringes are finer than the grid
NOT_FULL = 0.01  # void, as a share of the gap, from which on the gap is not full


class Optics(Protocol):
    """A rig and its light, such as `optics.Interferometer`."""

    def intensity(self, film: Values, density: Values, void: Values) -> Values: ...


def light_along(line: xr.Dataset, case: Any, optics: Optics) -> xr.DataArray:
    """The light that comes back along a line: intensity as the optics give it, over x or y in m.

    line: see `results.profiles.profile`, in SI.  case: of the run.  Films are interpolated by a cubic spline, pressure
    and void linearly.
    """
    axis = str(line["h"].dims[0])
    there, h, p = (np.asarray(line[name].values) for name in (axis, "h", "p"))
    void = np.maximum(h - line["h_oil"].values, 0.0) if "h_oil" in line else np.zeros_like(h)
    x = np.linspace(there[0], there[-1], PLACES)
    density = np.asarray(case.lubricant.density(np.interp(x, there, p) / case.scales.p_h), dtype=np.float64)
    film = np.maximum(CubicSpline(there, h)(x), 0.0)
    missing = np.minimum(np.interp(x, there, np.where(void > NOT_FULL * h, void, 0.0)), film)
    about = {"long_name": "intensity", "symbol": "I", "units": "1"}
    place = {axis: (axis, x, line[axis].attrs)}
    return xr.DataArray(optics.intensity(film, density, missing), place, (axis,), attrs=about)


@dataclass(frozen=True, eq=False)
class Unaligned:
    """Measured values over x, (n,), their weights 1/sigma, and the names of what is not known."""

    x: Values
    values: Values
    weight: Values
    names: Collection[str]

    def shown(self, computed: Values) -> "Shown":
        """Computed values as the instrument shows them."""
        ways = {name: computed for name in FACTORS} | {name: np.ones_like(self.x) for name in LEVELS}
        ways["tilt"] = self.x - self.x.mean()
        names = [name for name in ways if name in self.names]
        factor = names[0] if names and names[0] in FACTORS else ""
        shapes = np.reshape([ways[name] for name in names], (len(names), len(self.x))).T
        scale = np.abs(shapes).max(axis=0)
        A, b = shapes / scale * self.weight[:, None], (self.values - (0.0 if factor else computed)) * self.weight
        shares = np.linalg.lstsq(A, b)[0]
        if factor and shares[0] < (least := LEAST * float(np.abs(self.values).max())):
            shares = np.array([least, *np.linalg.lstsq(A[:, 1:], b - least * A[:, 0])[0]])
        parts = dict(zip(names, (shares / scale).tolist(), strict=True))
        size = parts.get(factor, 1.0)
        line = shapes @ (shares / scale) - (size * computed if factor else 0.0)
        return Shown(parts, size, size * computed + line, (self.values - line) / size)

    def best_centre(self, there: Values, values: Values) -> float:
        """The shift that leaves the smallest squares, as far as the run reaches, which has these values there."""
        low, high = self.x.max() - there[-1], self.x.min() - there[0]
        if low >= high:  # the run is shorter than the measurement, of which the caller tells
            return 0.0

        def squares(centre: float) -> float:
            shown = self.shown(np.interp(self.x - centre, there, values))
            return float(np.sum((self.weight * (self.values - shown.values)) ** 2))

        tried = np.linspace(low, high, SHIFTS)
        best, step = tried[np.argmin([squares(each) for each in tried])], (high - low) / (SHIFTS - 1)
        bounds = max(low, best - step), min(high, best + step)
        return float(minimize_scalar(squares, bounds=bounds, options={"xatol": 1e-6 * step}).x)


@dataclass(frozen=True, eq=False)
class Shown:
    """Values as an instrument shows them.

    parts: what was found, by name.  factor: that of them, or 1.  values: computed ones with these parts.  measured: the
    measured ones without them.
    """

    parts: Mapping[str, float]
    factor: float
    values: Values
    measured: Values
