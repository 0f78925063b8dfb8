"""The picture of two runs: film and pressure along the mid-line, and the films through time."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ertel.plots.drawing import BLUE, ORANGE, UNITS, WIDEST, At, Picture, Values, is_physical, mathtext
from ertel.plots.moments import profiles_of
from ertel.results.variables import PREFIXES, VARIABLES, exponent, is_steady

LOOKS = ((BLUE, "-"), (ORANGE, "--"))


class Curve(NamedTuple):
    """One line of a run, dimensionless, and what one unit of x and of y is in SI; 1 where that is not wanted."""

    name: str
    x: Values
    y: Values
    factors: tuple[float, float]


def figure(runs: Sequence[xr.Dataset], names: Sequence[str], at: At = None) -> Figure:
    """Film and pressure of two runs along the mid-line, and of two runs in time the minimum film through time.

    In SI where both runs are.  at: the moment of runs in time, as for other pictures.  Raises NoFigure, a ValueError,
    where a run has no such moment or no map.
    """
    in_si = all(is_physical(run) for run in runs)
    panels = [("X", "H"), ("X", "P")]
    if not any(is_steady(run) for run in runs):
        panels.append(("time", "H_min"))
    found = Picture(figsize=(4.8 * len(panels), 4.2), layout="constrained", dpi=150)
    for axes, (x, y) in zip(found.subplots(1, len(panels)), panels, strict=True):
        curves = [_curve(run, name, x, y, at, in_si) for run, name in zip(runs, names, strict=True)]
        _draw(axes, curves, x, y, in_si)
    found.legend(*found.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=2, frameon=False)
    return found


def _curve(run: xr.Dataset, name: str, x: str, y: str, at: At, in_si: bool) -> Curve:
    factors = [float(run[key].attrs["si_factor"]) if in_si else 1.0 for key in (_stored(run, x), y)]
    if x == "time":
        along, values = run["time"].values, run[y].values
    elif is_steady(run):
        along, values = run["X"].values, run[y].sel(Y=0.0, method="nearest").values
    else:
        profiles = profiles_of(run, at)
        along, values = profiles.x, getattr(profiles, y)[profiles.chosen]
    return Curve(name, np.asarray(along), np.asarray(values), (factors[0], factors[1]))


def _stored(run: xr.Dataset, axis: str) -> str:
    return "r" if axis == "X" and "r" in run else axis


def _draw(axes: Axes, curves: Sequence[Curve], x: str, y: str, in_si: bool) -> None:
    shown = []
    for number, name in enumerate((x, y)):
        largest = max(float(np.abs((c.x, c.y)[number]).max(initial=0.0)) * c.factors[number] for c in curves)
        shown.append(_scale(name, largest, in_si))
    (of_x, label_x), (of_y, label_y) = shown
    for curve, (colour, line) in zip(curves, LOOKS, strict=True):
        values = curve.x * curve.factors[0] * of_x, curve.y * curve.factors[1] * of_y
        axes.plot(*values, line, color=colour, label=curve.name)
    axes.set(xlabel=label_x, ylabel=label_y)
    if y == "H":
        axes.set_ylim(0.0, 3.0 * max(_inside(c) * c.factors[1] * of_y for c in curves))
    if x == "X":
        side = max(_side(c) * c.factors[0] * of_x for c in curves)
        axes.set_xlim(-side, side)


def _side(curve: Curve) -> float:
    """How far from the centre a curve is shown."""
    return min(WIDEST, float(np.abs(curve.x).max()))


def _inside(curve: Curve) -> float:
    """The film in the middle: far outside it is much thicker."""
    return float(np.interp(0.0, curve.x, curve.y))


def _scale(name: str, largest: float, in_si: bool) -> tuple[float, str]:
    """The factor with which a variable is shown, and its label."""
    variable = VARIABLES[name]
    if not in_si:
        unit = UNITS.get(variable.unit, variable.unit)
        return 1.0, _label(name, variable.symbol, unit)
    power = exponent(largest)
    unit = PREFIXES[power] + variable.si_units
    return 10.0**-power, _label(name, variable.si_name, unit)


def _label(name: str, symbol: str, unit: str) -> str:
    return f"{'' if name == 'X' else VARIABLES[name].long_name} {mathtext(symbol)} ({unit})".strip()
