"""Pictures of studies and of traction curves: Dataset of `results.study_result` -> matplotlib Figure."""

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import product

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

from ertel.plots.drawing import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    ORDERED_COLOURS,
    PURPLE,
    NoFigure,
    Panel,
    Picture,
    Scale,
    compose,
    mathtext,
)
from ertel.plots.view import CONDITIONS, case_of, name_of
from ertel.results.dataset import largest_of
from ertel.results.variables import name_in_si, with_prefix

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


# -- studies ----------------------------------------------------------------------------------------------------------


def figure(dataset: xr.Dataset) -> Figure:
    """The key numbers of a study over what varies most, with error bars where there are any.

    There is a line for each combination of the other values that vary.  Raises NoFigure where no run has any numbers.
    """
    shown = [[name for name in names if _has_numbers(dataset, name)] for names in PANELS]
    panels = [names for names in shown if names]
    if not panels:
        raise NoFigure("dataset: no run has any numbers yet, there is nothing to draw")
    picture = Picture(figsize=(max(4.8 * len(panels), 6.0), 4.0), layout="constrained", dpi=150)
    for axes, names in zip(picture.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        _draw(axes, dataset, names)
    picture.suptitle(str(dataset.attrs["title"]).replace("_", " "))
    return picture


def _has_numbers(dataset: xr.Dataset, name: str) -> bool:
    return name in dataset and largest_of(dataset[name]) > 0


def _draw(axes: Axes, dataset: xr.Dataset, names: list[str]) -> None:
    """Numbers of one unit over what varies most."""
    along = _abscissa(dataset)
    places = list(_places(dataset, along))
    shades = ORDERED_COLOURS(np.linspace(0.0, 1.0, len(places))) if len(places) > 1 else [BLUE]
    z = _scale(dataset[names[0]], max(largest_of(dataset[name]) for name in names))
    x, label = _x(axes, along)
    for name, style in zip(names, STYLES, strict=False):
        for place, colour in zip(places, shades, strict=True):
            y = dataset[name].isel(place).values * z.factor
            there = np.isfinite(y)
            if not there.any():
                continue
            bar = dataset[f"{name}_error"].isel(place).values[there] * z.factor if f"{name}_error" in dataset else None
            label_parts = [mathtext(name)] if len(names) > 1 else []
            label_parts += [_value_text(dataset[dim][index]) for dim, index in place.items()]
            axes.errorbar(
                x[there],
                y[there],
                bar,
                fmt=style,
                markersize=3.5,
                capsize=2,
                color=colour,
                label=", ".join(label_parts),
            )
    if axes.get_xscale() == "log" and len(names) > 1:
        axes.set_yscale("log")  # films are powers of speed, load and viscosity, nearly
        _name_ticks(axes.yaxis, np.array(axes.get_ylim()))
    title = "film thickness" if len(names) > 1 else dataset[names[0]].attrs["long_name"]
    axes.set(xlabel=label, ylabel=f"{title} {z.in_brackets}".rstrip())
    if 1 < len(places) * len(names) <= MOST_LINES:
        axes.legend(frameon=False, fontsize="x-small")


def _abscissa(dataset: xr.Dataset) -> xr.DataArray:
    """The quantity that varies most among the numbers that vary; a text only where there are no numbers."""
    return max((dataset[name] for name in dataset.coords), key=lambda values: (values.dtype.kind == "f", values.size))


def _places(dataset: xr.Dataset, along: xr.DataArray) -> Iterator[Place]:
    """The lines: each combination of the other values."""
    others = [str(dim) for dim in dataset.dims if dim not in along.dims]
    for indices in product(*(range(dataset.sizes[dim]) for dim in others)):
        yield dict(zip(others, indices, strict=True))


def _value_text(value: xr.DataArray) -> str:
    """One value of what varies, for the legend."""
    if value.dtype.kind != "f":
        return str(value.values)
    unit = value.attrs.get("units", "1")
    return f"{_spoken(value)} = {with_prefix(float(value), unit)}"


# -- traction curves --------------------------------------------------------------------------------------------------

CURVE_PANELS: Mapping[str, Mapping[str, str]] = {  # title: variables with their colours
    "Traction": {"mu_sliding": BLUE, "mu_rolling": ORANGE},
    "Film": {"H_c": BLUE, "H_min": ORANGE},
    "Power loss": {"power_loss": GREEN},
    "Maximum shear stress": {"tau_max": PURPLE},
}
WARM_PANELS: Mapping[str, Mapping[str, str]] = {  # with a section [thermal]
    **CURVE_PANELS,
    "Traction": {"mu_sliding": BLUE, "mu_isothermal": GREY, "mu_rolling": ORANGE},
    "Temperature": {"T_film_max": PURPLE, "T_1_max": BLUE, "T_2_max": ORANGE},
    "Inlet factor": {"phi_T": GREEN},
}


def traction_figure(dataset: xr.Dataset) -> Figure:
    """Traction coefficient, film thickness, power loss and shear stress along a traction curve.

    Raises NoFigure where there are no points yet.
    """
    if not np.isfinite(dataset["mu_rolling"]).any():
        raise NoFigure("dataset: has no points yet, there is nothing to draw")
    shown = WARM_PANELS if "phi_T" in dataset else CURVE_PANELS
    panels: list[Panel[xr.Dataset]] = [partial(_draw_curve, title=title, names=names) for title, names in shown.items()]
    half = len(panels) // 2
    return compose(dataset, [panels[:half], panels[half:]], _heading(dataset))


def _draw_curve(axes: Axes, dataset: xr.Dataset, title: str, names: Mapping[str, str]) -> None:
    """Some variables of one unit over what varies."""
    x, label = _x(axes, dataset[dataset.attrs["varies"]])
    variables = {colour: dataset[name if name in dataset else name_in_si(name)] for name, colour in names.items()}
    largest = max(largest_of(values) for values in variables.values())
    for colour, values in variables.items():
        z = _scale(values, largest, dataset.attrs["kind"])
        axes.plot(x, values * z.factor, "o-", color=colour, markersize=3.5, label=z.long_name)
    if title != "Temperature":
        axes.axhline(0.0, color="black", linewidth=0.5)
    axes.set(xlabel=label, ylabel=f"{title.lower()} {z.in_brackets}".rstrip(), title=title)
    if len(variables) > 1:
        axes.legend(frameon=False, fontsize="small")


def _heading(dataset: xr.Dataset) -> list[str]:
    """The name of the case, then its conditions apart from what varies."""
    about, varies = dataset.attrs, dataset.attrs["varies"]
    conditions = []
    if "R_m" in about:
        hidden = {"mean_speed": ["u_m_m_per_s"], "load": ["F_N", "p_h_Pa"]}.get(varies, [])
        named = [("$R$", "R_m", "m"), *CONDITIONS["rolling"]]
        conditions = [f"{symbol} = {with_prefix(about[key], unit)}" for symbol, key, unit in named if key not in hidden]
    if varies == "slide_to_roll":
        conditions += [f"$M$ = {about['M']:.4g}", f"$L$ = {about['L']:.3g}"]
    else:
        conditions.append(f"slide-to-roll {case_of(dataset).motion.slide_to_roll:.3g}")
    return [name_of(about), *conditions]


# -- axes -------------------------------------------------------------------------------------------------------------


def _scale(values: xr.DataArray, largest: float, kind: str = "") -> Scale:
    """The scale of the numbers of a study, whose symbol is their name where they have no other."""
    named = {"long_name": str(values.name), "symbol": str(values.name), "units": "1", **values.attrs}
    return Scale.of(values.assign_attrs(named), largest, kind)


def _x(axes: Axes, along: xr.DataArray) -> tuple[np.ndarray, str]:
    """The abscissae and their label."""
    if along.dtype.kind != "f":
        x = np.arange(along.size)
        axes.set_xticks(x, [str(value) for value in along.values], rotation=20)
        return x, _spoken(along)
    if _has_equal_ratios(along.values):
        axes.set_xscale("log")
        _name_ticks(axes.xaxis, along.values)
    else:
        axes.xaxis.set_major_locator(MaxNLocator(6))
    scale = _scale(along.assign_attrs(in_units_of=""), largest_of(along))
    if "symbol" in along.attrs:
        return along.values * scale.factor, scale.label
    return along.values * scale.factor, f"{_spoken(along)} {scale.in_brackets}".rstrip().replace("*", " ")


def _has_equal_ratios(x: np.ndarray) -> bool:
    """Tell whether the values were spaced by equal ratios."""
    if len(x) < 3 or not (x > 0).all():
        return False
    steps = np.diff(np.log(x))
    return bool(np.allclose(steps, steps[0]))


def _name_ticks(axis: Axis, values: np.ndarray) -> None:
    """Plain numbers 1, 2, 5, 10, ... at a logarithmic axis, over many decades powers of ten."""
    if np.max(np.abs(values)) < DECADES * np.min(np.abs(values)):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def _spoken(values: xr.DataArray) -> str:
    """The name of what varies, as it is spoken."""
    return str(values.name).replace("_", " ")
