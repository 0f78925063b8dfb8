"""The picture of a study: Dataset of `results.study_result` -> matplotlib Figure."""

from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

from ertel.plots.drawing import BLUE, ORDERED_COLOURS, UNITS, NoFigure, Picture, mathtext
from ertel.plots.traction import has_equal_ratios
from ertel.results.report import largest_of
from ertel.results.variables import PREFIXES, exponent, with_prefix

PANELS = (  # numbers that are drawn together, in SI or not
    ("h_c", "h_min", "H_c", "H_min"),
    ("p_max", "P_max"),
    ("mu_sliding",),
    ("restitution",),
)
STYLES = ("o-", "s--", "o-", "s--")
DECADES = 300.0  # ratio of the ends of a logarithmic axis from which its ticks are powers of ten
MOST_LINES = 12  # with a name in the legend

Place = Mapping[str, int]  # of a line in the Dataset


def figure(dataset: xr.Dataset) -> Figure:
    """The key numbers of a study over what varies most, with error bars where there are any.

    There is a line for each combination of the other values that vary.  Raises NoFigure where no run has any numbers.
    """
    shown = [[name for name in names if _has_numbers(dataset, name)] for names in PANELS]
    panels = [names for names in shown if names]
    if not panels:
        raise NoFigure("dataset: no run has any numbers yet, there is nothing to draw")
    found = Picture(figsize=(max(4.8 * len(panels), 6.0), 4.0), layout="constrained", dpi=150)
    for axes, names in zip(found.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        _draw(axes, dataset, names)
    found.suptitle(str(dataset.attrs["title"]).replace("_", " "))
    return found


def _has_numbers(dataset: xr.Dataset, name: str) -> bool:
    return name in dataset and largest_of(dataset[name]) > 0


def _draw(axes: Axes, dataset: xr.Dataset, names: list[str]) -> None:
    """Numbers of one unit over what varies most."""
    along = _abscissa(dataset)
    places = list(_places(dataset, along))
    shades = ORDERED_COLOURS(np.linspace(0.0, 1.0, len(places))) if len(places) > 1 else [BLUE]
    factor, unit = _unit(dataset[names[0]], max(largest_of(dataset[name]) for name in names))
    x, label = _x(axes, along)
    for name, style in zip(names, STYLES, strict=False):
        for place, colour in zip(places, shades, strict=True):
            y = dataset[name].isel(place).values * factor
            there = np.isfinite(y)
            if not there.any():
                continue
            bar = dataset[f"{name}_error"].isel(place).values[there] * factor if f"{name}_error" in dataset else None
            said = [mathtext(name)] if len(names) > 1 else []
            said += [_said(dataset[dim][index]) for dim, index in place.items()]
            axes.errorbar(
                x[there], y[there], bar, fmt=style, markersize=3.5, capsize=2, color=colour, label=", ".join(said)
            )
    if axes.get_xscale() == "log" and len(names) > 1:
        axes.set_yscale("log")  # films are powers of speed, load and viscosity, nearly
        _name_ticks(axes.yaxis, np.array(axes.get_ylim()))
    title = "film thickness" if len(names) > 1 else dataset[names[0]].attrs["long_name"]
    axes.set(xlabel=label, ylabel=f"{title} ({unit})" if unit else title)
    if 1 < len(places) * len(names) <= MOST_LINES:
        axes.legend(frameon=False, fontsize="x-small")


def _abscissa(dataset: xr.Dataset) -> xr.DataArray:
    """What varies most among the numbers that vary; a text only where there are no numbers."""
    return max((dataset[name] for name in dataset.coords), key=lambda values: (values.dtype.kind == "f", values.size))


def _places(dataset: xr.Dataset, along: xr.DataArray) -> Iterator[Place]:
    """The lines: each combination of the other values."""
    others = [str(dim) for dim in dataset.dims if dim not in along.dims]
    for indices in product(*(range(dataset.sizes[dim]) for dim in others)):
        yield dict(zip(others, indices, strict=True))


def _x(axes: Axes, along: xr.DataArray) -> tuple[np.ndarray, str]:
    """The abscissae and their label."""
    if along.dtype.kind != "f":
        x = np.arange(along.size)
        axes.set_xticks(x, [str(value) for value in along.values], rotation=20)
        return x, _spoken(along)
    unit = along.attrs.get("units", "1")
    power = 0 if unit == "1" or "/" in unit or unit == "K" else exponent(largest_of(along))
    if has_equal_ratios(along.values):
        axes.set_xscale("log")
        _name_ticks(axes.xaxis, along.values)
    else:
        axes.xaxis.set_major_locator(MaxNLocator(6))
    shown = f" ({PREFIXES[power]}{unit.replace('*', ' ')})" if unit != "1" else ""
    return along.values / 10**power, _spoken(along) + shown


def _name_ticks(axis: Axis, values: np.ndarray) -> None:
    """Plain numbers 1, 2, 5, 10, ... at a logarithmic axis, over many decades powers of ten."""
    if np.max(np.abs(values)) < DECADES * np.min(np.abs(values)):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def _spoken(values: xr.DataArray) -> str:
    """The name of what varies, as it is spoken."""
    return str(values.name).replace("_", " ")


def _said(value: xr.DataArray) -> str:
    """One value of what varies, for the legend."""
    if value.dtype.kind != "f":
        return str(value.values)
    unit = value.attrs.get("units", "1")
    return f"{_spoken(value)} = {with_prefix(float(value), unit)}"


def _unit(values: xr.DataArray, largest: float) -> tuple[float, str]:
    """The factor and the unit with which numbers are shown."""
    unit = values.attrs["units"]
    if unit != "1":
        power = 0 if "/" in unit else exponent(largest)
        return 10.0**-power, PREFIXES[power] + unit
    own = values.attrs.get("in_units_of", "")
    return 1.0, UNITS.get(own, own)
