"""What all pictures share: units and labels, colours, maps with contour lines, figures made of panels.

A run of a physical case is drawn in SI with fitting prefixes, a dimensionless one in units a*, a*^2/R, p_h*, t0 (of a
rolling contact, whose scales are those of its load, without the star).
Colours are told apart by everybody (Okabe and Ito's; for what is ordered, maps whose lightness is).
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Protocol

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ertel.plots import stored
from ertel.results.variables import PREFIXES, exponent, unit_of, with_prefix

Values = NDArray[np.float64]
Panel = Callable[[Axes, xr.Dataset], None]
At = float | str | None  # a time in t0, an event, or None: maximum approach, or the last map

BLUE, ORANGE, GREEN, PURPLE, GREY = "#0072B2", "#D55E00", "#009E73", "#CC2F8E", "#777777"
FILM_COLOURS, PRESSURE_COLOURS = "YlGnBu_r", "YlOrRd"
ORDERED_COLOURS = LinearSegmentedColormap.from_list("ordered", colormaps["viridis"](np.linspace(0.0, 0.88, 256)))
UNITS = {
    "a*": "$a^*$", "a*^2/R": "$a^{*2}/R$", "p_h*": "$p_h^*$", "F*": "$F^*$", "a*/t0": "$a^*/t_0$", "t0": "$t_0$",
    "a": "$a$", "a^2/R": "$a^2/R$", "p_h": "$p_h$", "F": "$F$", "u_m": "$u_m$",
    "a*/R": "$a^*/R$", "p_h* a*/R": r"$p_h^*\, a^*/R$", "p_h* a*^2/(R t0)": r"$p_h^*\, a^{*2}/(R t_0)$",
    "a/R": "$a/R$", "p_h a/R": r"$p_h\, a/R$", "p_h u_m a/R": r"$p_h\, u_m\, a/R$",
    "F* a*^2/(R t0)": r"$F^* a^{*2}/(R\,t_0)$", "F u_m a/R": r"$F u_m\, a/R$",
}  # fmt: skip
CONDITIONS = {  # by kind, for the heading of a physical case: symbol, attribute of the Dataset, unit
    "impact": (("$v_0$", "v0_m_per_s", "m/s"), ("$p_h^*$", "p_h_Pa", "Pa")),
    "rolling": (("$u_m$", "u_m_m_per_s", "m/s"), ("$F$", "F_N", "N"), ("$p_h$", "p_h_Pa", "Pa")),
}
SHOWN = {"W/m2": (1e-6, "W/mm²"), "1": (1.0, "")}  # SI units that are shown otherwise than with a prefix
MARGIN, WIDEST = 1.3, 2.0  # of what is shown round the contact, at most so many half widths from its centre
GREEK = "Delta|delta|^mu|^tau"
LONG = 2.0  # ratio of the sides from which a map is long
LOADED = 0.02  # of the maximum pressure: where there is less, the film carries nothing to speak of


# -- units and labels -------------------------------------------------------------------------------------------------


class NoFigure(ValueError):
    """A run has no such figure, no such moment, or nothing to draw yet."""


class Draw(Protocol):
    """Draws a run; `at` is a time in t0 or an event."""

    def __call__(self, dataset: xr.Dataset, at: At = None) -> Figure: ...


Figures = Mapping[str, Draw]


@dataclass(frozen=True)
class Scale:
    """How a dimensionless variable is shown: times a factor, under a label."""

    factor: float
    symbol: str
    unit: str
    long_name: str

    @property
    def label(self) -> str:
        """Name, symbol and unit for an axis."""
        parts = self.long_name, self.symbol, f"({self.unit})" if self.unit else ""
        return " ".join(part for part in parts if part)


def scale(dataset: xr.Dataset, name: str, maximum: float) -> Scale:
    """The scale of a variable: SI with the prefix that fits `maximum` (dimensionless), or the dimensionless units."""
    attributes = dataset[name].attrs
    if "si_factor" not in attributes:
        unit = unit_of(dataset.attrs["kind"], attributes.get("in_units_of", ""))
        return Scale(1.0, mathtext(attributes["symbol"]), UNITS.get(unit, unit), attributes["long_name"])
    power = exponent(abs(maximum) * attributes["si_factor"])
    share, unit = SHOWN.get(attributes["si_units"]) or (10.0**-power, PREFIXES[power] + attributes["si_units"])
    factor = attributes["si_factor"] * share
    return Scale(factor, mathtext(attributes["si_name"]), unit, attributes["long_name"])


def mathtext(symbol: str) -> str:
    """H_min as $H_\\mathrm{min}$, Delta as a Greek letter."""
    base, _, index = re.sub(GREEK, r"\\\g<0>", symbol).partition("_")
    return f"${base}_\\mathrm{{{index}}}$" if index else f"${base}$"


def named(dataset: xr.Dataset, name: str) -> str:
    """A variable for a legend: its long name and its symbol."""
    shown = scale(dataset, name, 1.0)
    return f"{shown.long_name} {shown.symbol}"


def lateral(dataset: xr.Dataset) -> Scale:
    """The scale of distances along the surface."""
    return scale(dataset, "r" if "r" in dataset else "X", 1.0)


def is_physical(dataset: xr.Dataset) -> bool:
    """Whether the run has SI scales."""
    return "si_factor" in dataset["H"].attrs


def axis_label(dataset: xr.Dataset, axis: str) -> str:
    """Label of a distance along "x" or "y"."""
    return f"${axis if is_physical(dataset) else axis.upper()}$ ({lateral(dataset).unit})"


def title(dataset: xr.Dataset) -> list[str]:
    """The name of a run, then its conditions."""
    a = dataset.attrs
    name = str(a["title"]).partition(", M = ")[0].replace("_", " ")  # the conditions say M and L of a case without name
    conditions = [f"{name[:1].upper()}{name[1:]}", f"$M$ = {a['M']:.4g}", f"$L$ = {a['L']:.3g}"]
    if "radius_ratio" in a:
        conditions.append(f"$R_x/R_y$ = {a['radius_ratio']:.3g}")
    if a.get("entrainment_angle"):
        conditions.append(f"angle {a['entrainment_angle']:.3g}°")
    if a["kind"] == "rolling" and (sliding := stored.slide_to_roll(dataset)):
        conditions.append(f"slide-to-roll {sliding:.3g}")
    if not is_physical(dataset):
        return conditions
    driven = [f"{symbol} = {with_prefix(a[name], unit)}" for symbol, name, unit in CONDITIONS[a["kind"]]]
    return [conditions[0], f"$R$ = {with_prefix(a['R_m'], 'm')}", *driven, *conditions[1:]]


# -- maps -------------------------------------------------------------------------------------------------------------


def levels(top: float, steps: int = 10) -> Values:
    """Equal steps of a round number from zero to `top` or a little above."""
    return np.asarray(MaxNLocator(steps).tick_values(0.0, top))


@dataclass(frozen=True)
class Field:
    """A variable over the surface: values (y, x), all dimensionless."""

    x: Values
    y: Values
    values: Values


def map_of(dataset: xr.Dataset, name: str, frame: int | None = None) -> Field:
    """A field of one frame, or the steady one; a radial profile is turned round the centre."""
    values = np.asarray((dataset[name] if frame is None else dataset[name].isel(frame=frame)).values)
    if "r" not in dataset:
        return Field(np.asarray(dataset["X"].values), np.asarray(dataset["Y"].values), values)
    r = np.asarray(dataset["r"].values)
    x = np.linspace(-r[-1], r[-1], 601)
    return Field(x, x, np.interp(np.hypot(x[:, None], x[None, :]), r, values))


def extent(dataset: xr.Dataset, x: Values, P: Values) -> float:
    """How far from the centre a profile along x is shown."""
    return min(MARGIN * reach(x, P), WIDEST * stored.geometry(dataset).extent[0])


def side_of(dataset: xr.Dataset, frame: int | None = None) -> float:
    """How far from the centre a map is shown along x."""
    field = map_of(dataset, "P", frame)
    return extent(dataset, field.x, field.values.max(axis=0))


def stretch(dataset: xr.Dataset) -> float:
    """How many times as far the dry contact reaches along y as along x."""
    along, across = stored.geometry(dataset).extent
    return across / along


def reach(x: Values, P: Values) -> float:
    """How far from the centre a profile carries pressure."""
    loaded = x[LOADED * P.max() < P]
    farthest = float(np.abs(loaded).max()) if len(loaded) else float(x.max())
    return max(farthest, 0.2 * float(x.max()))  # something to see even at first touch


def film_inside(dataset: xr.Dataset, x: Values, P: Values, H: Values) -> float:
    """The maximum film thickness well inside the contact, of a profile along x."""
    return float(H[np.abs(x) < 0.8 * min(reach(x, P), stored.geometry(dataset).extent[0])].max())


def draw_map(axes: Axes, dataset: xr.Dataset, field: Field, side: float, z: Scale, steps: Values, colours: str) -> None:
    """Colours and contour lines at `steps` (as shown) up to `side` from the centre along x.

    Along y as far as suits the shape of the contact.  What is above the highest step has its colour.
    """
    across = lateral(dataset)
    columns, rows = np.abs(field.x) <= side, np.abs(field.y) <= side * stretch(dataset)
    x, y, shown = (
        field.x[columns] * across.factor,
        field.y[rows] * across.factor,
        field.values[np.ix_(rows, columns)] * z.factor,
    )
    limits = Normalize(0.0, steps[-1])
    image = axes.pcolormesh(x, y, shown, cmap=colours, norm=limits, shading="gouraud", rasterized=True)
    if shown.min() < steps[-1] and shown.max() > steps[1]:
        axes.contour(x, y, shown, levels=steps[1:], colors="black", linewidths=0.4, alpha=0.6)
    axes.set(xlabel=axis_label(dataset, "x"), ylabel=axis_label(dataset, "y"), aspect="equal")
    _thin_ticks(axes, stretch(dataset))
    extend = "max" if shown.max() > steps[-1] else "neither"
    figure_of(axes).colorbar(image, ax=axes, label=z.label, extend=extend)


def _thin_ticks(axes: Axes, stretch: float) -> None:
    """Few ticks on the short axis of a long map."""
    short = axes.xaxis if stretch > 1 else axes.yaxis
    if max(stretch, 1 / stretch) > LONG:
        short.set_major_locator(MaxNLocator(1, min_n_ticks=1))


def head_map(axes: Axes, dataset: xr.Dataset, what: str, z: Scale, steps: Values) -> None:
    """What a map shows and how far its lines are apart, above it; in two lines where the map is narrow."""
    narrow = "\n" if stretch(dataset) > LONG else " "
    axes.set_title(f"{what},{narrow}a line every {steps[1]:.3g} {z.unit}")


def draw_film(axes: Axes, dataset: xr.Dataset, field: Field, side: float, top: float, lines: int = 10) -> None:
    """Film thickness with about so many contour lines at equal steps up to `top`, as an interferometer shows them."""
    z = scale(dataset, "H", top / 2)
    steps = levels(top * z.factor, lines)
    draw_map(axes, dataset, field, side, z, steps, FILM_COLOURS)
    head_map(axes, dataset, "Film thickness", z, steps)


def draw_pressure(axes: Axes, dataset: xr.Dataset, field: Field, side: float) -> None:
    """Pressure with contour lines at equal steps."""
    top = max(float(field.values.max()), 0.01)  # p_h*: something to divide where the contact carries nothing
    z = scale(dataset, "P", top)
    steps = levels(top * z.factor)
    draw_map(axes, dataset, field, side, z, steps, PRESSURE_COLOURS)
    head_map(axes, dataset, "Pressure", z, steps)


def draw_flow(axes: Axes, direction: float) -> None:
    """An arrow the way the surfaces carry the oil; none where they stand still."""
    if direction == 0.0:
        return
    start, end = (0.04, 0.2) if direction > 0 else (0.2, 0.04)
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.5, "shrinkA": 0, "shrinkB": 0}
    place = {"xycoords": "axes fraction", "textcoords": "axes fraction"}
    axes.annotate("", (end, 0.91), (start, 0.91), arrowprops=arrow, **place)  # type: ignore[arg-type]
    axes.text(0.12, 0.94, "flow", transform=axes.transAxes, ha="center", fontsize="small")


# -- figures ----------------------------------------------------------------------------------------------------------


def figure_of(axes: Axes) -> Figure:
    """The figure that axes stand in."""
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    return figure


class Picture(Figure):
    """A Figure that a notebook shows without pyplot."""

    def _repr_png_(self) -> bytes:
        png = BytesIO()
        self.savefig(png, format="png")
        return png.getvalue()


def compose(dataset: xr.Dataset, rows: list[list[Panel]], heading: list[str]) -> Figure:
    """A figure of rows of panels; heading: a name and what is said of it, on as many lines as it takes."""
    width = max(5.0 * len(rows[0]), 6.0)
    figure = Picture(figsize=(width, width / len(rows[0]) * 0.8 * len(rows) + 0.4), layout="constrained", dpi=150)
    figure.get_layout_engine().set(w_pad=0.12, h_pad=0.1)  # type: ignore[union-attr, call-arg]
    for panels, line in zip(rows, figure.subplots(len(rows), len(rows[0]), squeeze=False), strict=True):
        for draw, axes in zip(panels, line, strict=True):
            draw(axes, dataset)
    figure.suptitle(_wrapped(heading, round(10 * width)), fontsize="medium")
    return figure


def _wrapped(parts: list[str], width: int) -> str:
    """Parts side by side, on a new line where one would be longer than `width` characters."""
    first, *rest = parts
    lines = [f"{first}: "]
    for number, part in enumerate(rest, 1):
        text = part + (",  " if number < len(rest) else "")
        seen = len(re.sub(r"\\mathrm|[${}_^\\]", "", lines[-1] + text))
        lines = [*lines, text] if seen > width else [*lines[:-1], lines[-1] + text]
    return "\n".join(line.rstrip() for line in lines)
