"""Pictures of studies and of traction curves: Dataset of `results.study_table` -> matplotlib Figure."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import cycle, product
from operator import attrgetter
from typing import Any, Literal, Unpack

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, NullFormatter

from ertel.plots.drawing import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    ORDERED_COLOURS,
    PURPLE,
    NoFigure,
    Panel,
    Scale,
    Sheet,
    SheetOptions,
    compose,
    mathtext,
    plain_ticks,
)
from ertel.plots.measurements import fit_figure
from ertel.plots.view import case_of, conditions_in_si, name_of
from ertel.results.convergence import SEEN, limits_of
from ertel.results.dataset import largest_of
from ertel.results.variables import KELVIN, THICKNESS, Variable, in_celsius, stored_in, with_prefix

PANEL = attrgetter("panel")
FACES = (None, "white", None, "white")  # of the markers: filled for the first number of a panel, hollow for the second
LineStyle = Literal["-", "--", "-.", ":"]
LOOKS: Sequence[tuple[str, LineStyle]] = (  # marker and line
    ("o", "-"), ("s", "--"), ("^", "-."), ("D", ":"), ("v", "-"), ("P", "--"),
)  # fmt: skip
WIDTH_OF_NAME = 1.5  # inches: of a column of the legend
DECADES = 300.0  # ratio of the ends of a logarithmic axis from which its ticks are powers of ten
MOST_NAMES = 8  # of the values of one quantity in the legend

Place = Mapping[str, int]  # of a line in the Dataset


# -- studies ----------------------------------------------------------------------------------------------------------


def figure(dataset: xr.Dataset, **options: Unpack[SheetOptions]) -> Figure:
    """The key numbers of a study over what varies most, with error bars where there are any.

    There is a line for each combination of the other values that vary: its colour says one of them, line and marker the
    others; the legend stands below the panels.  Fits, traction curves and convergence series have panels of their own.
    Raises NoFigure where no run has any numbers.
    """
    sheet = Sheet(**options)
    others = {"chi_square": fit_figure, "varies": _traction_figure, "assumed_order": _convergence_figure}
    for attribute in others.keys() & dataset.attrs.keys():
        return others[attribute](dataset, sheet)
    drawn = panels_of(dataset, PANEL).values()
    panels: list[Panel[xr.Dataset]] = [partial(_draw, names=names) for names in drawn]
    if not panels:
        raise NoFigure("dataset: no run has any numbers yet, there is nothing to draw")
    picture = compose(dataset, [panels], [str(dataset.attrs["title"]).replace("_", " ")], sheet)
    if entries := _legend(dataset):
        _add_legend(picture, entries, WIDTH_OF_NAME, sheet)
    return picture


def _add_legend(picture: Figure, entries: Sequence[Any], width: float, sheet: Sheet) -> None:
    """Put a legend below the panels, or into the last axes of a figure of the user.  width: of a column, in inches."""
    if sheet.ax is not None:
        np.ravel(np.asarray(sheet.ax, dtype=object))[-1].legend(handles=entries, frameon=False, fontsize="small")
        return
    columns, letters = max(1, int(picture.get_figwidth() // width)), 7.5 if sheet.width else 9.0
    picture.legend(handles=entries, loc="outside lower center", ncols=columns, frameon=False, fontsize=letters)
    if sheet.figsize is None:
        picture.set_figheight(picture.get_figheight() + 0.1 + 1.7 * letters / 72.0 * -(-len(entries) // columns))


def panels_of(dataset: xr.Dataset, panel: Callable[[Variable], str], cold: bool = False) -> dict[str, list[str]]:
    """The numbers that the runs have, by their panel, which a function tells.  cold: as of `stored_in`."""
    panels: dict[str, list[str]] = {}
    for name, about in stored_in(dataset, panel, cold).items():
        if largest_of(dataset[name]) > 0:
            panels.setdefault(panel(about), []).append(name)
    return panels


def _draw(axes: Axes, dataset: xr.Dataset, names: list[str]) -> None:
    """Numbers of one unit over what varies most, the second of them with hollow markers."""
    along = _abscissa(dataset)
    z = Scale.of(dataset[names[0]], max(largest_of(dataset[name]) for name in names))
    x, label = _x(axes, along)
    for name, face in zip(names, FACES, strict=False):
        for place, colour, (marker, line) in _lines(dataset, along):
            y = z.shown(dataset[name].isel(place).values)
            there = np.isfinite(y)
            if not there.any():
                continue
            bar = dataset[f"{name}_error"].isel(place).values[there] * z.factor if f"{name}_error" in dataset else None
            look = {"marker": marker, "linestyle": line, "color": colour, "markerfacecolor": face or colour}
            axes.errorbar(x[there], y[there], bar, markersize=3.5, capsize=2, **look)
    if axes.get_xscale() == "log" and len(names) > 1:
        axes.set_yscale("log")  # films are powers of speed, load and viscosity, nearly
        _name_ticks(axes.yaxis, np.array(axes.get_ylim()))
    title = "film thickness" if len(names) > 1 else dataset[names[0]].attrs["long_name"]
    axes.set(xlabel=label, ylabel=f"{title} {z.in_brackets}".rstrip())


def _factors(dataset: xr.Dataset, along: xr.DataArray) -> tuple[list[str], list[str]]:
    """The dimension that colours tell apart, the longest but that along the axis, and those that markers tell apart."""
    others = sorted((str(dim) for dim in dataset.dims if dim not in along.dims), key=lambda dim: -dataset.sizes[dim])
    return others[:1], others[1:]


def _lines(dataset: xr.Dataset, along: xr.DataArray) -> Iterator[tuple[Place, Any, tuple[str, LineStyle]]]:
    """The lines that have numbers, each a combination of the other values, with their colours, markers and styles."""
    of_colour, of_look = (
        [dict(zip(dims, each, strict=True)) for each in product(*(range(dataset.sizes[dim]) for dim in dims))]
        for dims in _factors(dataset, along)
    )
    shades = ORDERED_COLOURS(np.linspace(0.0, 1.0, len(of_colour))) if len(of_colour) > 1 else [BLUE]
    for one, shade in zip(of_colour, shades, strict=True):
        for other, look in zip(of_look, cycle(LOOKS), strict=False):
            if panels_of(dataset.isel({**one, **other}), PANEL):
                yield {**one, **other}, shade, look


def _legend(dataset: xr.Dataset) -> list[Line2D]:
    """The colours with their values, the looks with theirs, and the films; of many values not all."""
    colours, looks = _factors(dataset, _abscissa(dataset))
    of_colour, of_look = {}, {}
    for place, colour, (marker, line) in _lines(dataset, _abscissa(dataset)):
        of_colour[_values_text(dataset, place, colours)] = Line2D([], [], color=colour)
        of_look[_values_text(dataset, place, looks)] = Line2D(
            [], [], color=GREY, marker=marker, linestyle=line, markersize=3.5
        )
    films = panels_of(dataset, PANEL).get(THICKNESS, [])
    of_film = {
        mathtext(name): Line2D([], [], color="black", marker="o", markersize=3.5, markerfacecolor=face)
        for name, face in zip(films, FACES, strict=False)
    }
    groups = [group for group in (of_colour, of_look) if "" not in group] + [of_film] * (len(of_film) > 1)
    entries = []
    for group in groups:  # the first, the last and some between them
        for number in np.linspace(0, len(group) - 1, min(len(group), MOST_NAMES)).astype(int):
            label, entry = list(group.items())[number]
            entry.set_label(label)
            entries.append(entry)
    return entries


def _values_text(dataset: xr.Dataset, place: Place, dims: Sequence[str]) -> str:
    return ", ".join(_value_text(dataset[dim][place[dim]]) for dim in dims)


def _abscissa(dataset: xr.Dataset) -> xr.DataArray:
    """The quantity that varies most among the numbers that vary; a text only where there are no numbers."""
    return max((dataset[name] for name in dataset.coords), key=lambda values: (values.dtype.kind == "f", values.size))


def _value_text(value: xr.DataArray) -> str:
    """One value of what varies, for the legend."""
    if value.dtype.kind != "f":
        return str(value.values)
    shown = with_prefix(*in_celsius(float(value), value.attrs.get("units", "1")))
    return f"{_spoken(value)} = {shown.replace('degC', '°C')}"


# -- traction curves --------------------------------------------------------------------------------------------------

LINE_OF_LEGEND = 0.08  # of the height of a panel
COLOURS = (BLUE, ORANGE, PURPLE, GREEN)  # of the numbers of a panel; those without heat are grey beside those with it


def _traction_figure(dataset: xr.Dataset, sheet: Sheet) -> Figure:
    """Traction coefficient, film thickness, power loss and shear stress along a traction curve."""
    drawn = panels_of(dataset, attrgetter("curve_panel"), cold=True)
    if not drawn:
        raise NoFigure("dataset: has no points yet, there is nothing to draw")
    panels: list[Panel[xr.Dataset]] = [partial(_draw_curve, title=title, names=names) for title, names in drawn.items()]
    half = len(panels) // 2
    return compose(dataset, [panels[:half], panels[half:]], _heading(dataset), sheet)


def _draw_curve(axes: Axes, dataset: xr.Dataset, title: str, names: Sequence[str]) -> None:
    """Some variables of one unit over what varies."""
    x, label = _x(axes, dataset[dataset.attrs["varies"]])
    variables = [dataset[name] for name in names]
    largest = max(largest_of(values) for values in variables)
    colours = iter(COLOURS)
    for name, values in zip(names, variables, strict=True):
        z = Scale.of(values, largest, dataset.attrs["kind"])
        colour, line = (GREY, "o--") if f"{name}_warm" in names else (next(colours), "o-")
        axes.plot(x, z.shown(values.values), line, color=colour, markersize=3.5, label=z.long_name)
    if title != "Temperature":
        axes.axhline(0.0, color="black", linewidth=0.5)
    axes.set(xlabel=label, ylabel=f"{title.lower()} {z.in_brackets}".rstrip(), title=title)
    if title == "Traction" and dataset.attrs["varies"] == "mean_speed" and "hersey" in dataset:
        each = largest_of(dataset["hersey"]) / x.max()  # (m), over a speed on the axis
        above = axes.secondary_xaxis("top", functions=(lambda u: each * u, lambda h: h / each))
        above.set_xlabel(r"Hersey number $\eta_0 u_m/p_h$ (m)", fontsize="small")
    if len(variables) > 1:
        low, high = axes.get_ylim()
        share = LINE_OF_LEGEND * len(variables)  # above the lines, so that it never lies on one
        axes.set_ylim(low, high + share / (1.0 - share) * (high - low))
        axes.legend(loc="upper left", frameon=False, fontsize="small")


def _heading(dataset: xr.Dataset) -> list[str]:
    """The name of the case, then its conditions apart from what varies."""
    about, varies = dataset.attrs, dataset.attrs["varies"]
    hidden = {"mean_speed": ["u_m_m_per_s"], "load": ["F_N", "p_h_Pa"]}.get(varies, [])
    conditions = conditions_in_si(about, hidden)
    if varies == "slide_to_roll":
        conditions += [f"$M$ = {about['M']:.4g}", f"$L$ = {about['L']:.3g}"]
    else:
        conditions.append(f"slide-to-roll {case_of(dataset).motion.slide_to_roll:.3g}")
    if sigma := case_of(dataset).sigma:
        conditions.append(f"rms roughness {with_prefix(sigma, 'm')}")
    return [name_of(about), *conditions]


# -- convergence series -----------------------------------------------------------------------------------------------

POWERS = {"nodes": 1.0, "step": -1.0, "tolerance": -1.0 / 3.0}  # of what varies: the number of cells or steps goes so
WIDTH_OF_ORDER = 2.4  # inches: of a column of the legend


def _convergence_figure(dataset: xr.Dataset, sheet: Sheet) -> Figure:
    """The distance of the numbers of a series from their limits, over the grids, with the slope of the order."""
    if not limits_of(dataset):
        raise NoFigure("dataset: not all runs have numbers yet, there is nothing to draw")
    picture = compose(dataset, [[_draw_distances]], [str(dataset.attrs["title"]).replace("_", " ")], sheet)
    _add_legend(
        picture, sheet.own_axes(1)[0].lines if sheet.ax is not None else picture.axes[0].lines, WIDTH_OF_ORDER, sheet
    )
    return picture


def _draw_distances(axes: Axes, dataset: xr.Dataset) -> None:
    """Relative distances from the limits; of a number whose order is not seen hollow, from the finest grid."""
    along, limits = next(iter(dataset.coords.values())), limits_of(dataset)
    shades = ORDERED_COLOURS(np.linspace(0.0, 1.0, len(limits)))
    for (name, one), shade, (marker, line) in zip(limits.items(), shades, cycle(LOOKS), strict=False):
        away = np.abs(dataset[name].where(dataset[name] != one.value).values / one.value - 1.0)
        base = name.partition("_")[0]
        symbol = mathtext(name) if len(base) <= 2 or base.lower() == "delta" else _spoken(dataset[name])
        has_order = one.order >= SEEN[0]
        label = f"{symbol}, {f'order {one.order:.2f}' if has_order else 'order not seen'}"
        axes.loglog(
            along, away, marker + line, color=shade, markerfacecolor=shade if has_order else "white", label=label
        )
    slope = along.values ** -(dataset.attrs["assumed_order"] * POWERS[str(along.name)])
    middle = np.sqrt(np.prod(axes.get_ylim()) / (slope[0] * slope[-1]))
    axes.loglog(along, middle * slope, "k--", linewidth=0.8, label="slope of second order")
    axes.set_xticks(along.values, [f"{value:.3g}" for value in along.values])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set(xlabel=_spoken(along), ylabel="relative distance from the limit")
    if along.values[-1] < along.values[0]:
        axes.invert_xaxis()  # what is refined stands to the right


# -- axes -------------------------------------------------------------------------------------------------------------


def _x(axes: Axes, along: xr.DataArray) -> tuple[np.ndarray, str]:
    """The abscissae and their label."""
    if along.dtype.kind != "f":
        x = np.arange(along.size)
        axes.set_xticks(x, [str(value) for value in along.values], rotation=20)
        return x, _spoken(along)
    if _has_equal_ratios(along.values) and along.attrs.get("units") != KELVIN:
        axes.set_xscale("log")
        _name_ticks(axes.xaxis, along.values)
    else:
        axes.xaxis.set_major_locator(MaxNLocator(6))
    scale = Scale.of(along.assign_attrs(in_units_of=""), largest_of(along))
    if "symbol" in along.attrs:
        return scale.shown(along.values), scale.label
    return scale.shown(along.values), f"{_spoken(along)} {scale.in_brackets}".rstrip().replace("*", " ")


def _has_equal_ratios(x: np.ndarray) -> bool:
    """Tell whether the values were spaced by equal ratios."""
    return bool(len(x) > 2 and (x > 0).all() and np.allclose(x[1:] / x[:-1], x[1] / x[0]))


def _name_ticks(axis: Axis, values: np.ndarray) -> None:
    """Plain numbers at a logarithmic axis, over many decades powers of ten."""
    if np.max(np.abs(values)) < DECADES * np.min(np.abs(values)):
        plain_ticks(axis)
    axis.set_minor_formatter(NullFormatter())


def _spoken(values: xr.DataArray) -> str:
    """The name of what varies, as it is spoken."""
    return str(values.name).replace("_", " ")
