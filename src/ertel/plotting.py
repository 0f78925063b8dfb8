"""Pictures of a run: Dataset -> matplotlib Figure.  Nothing is shown, nothing is saved.

    ertel.plotting.overview(result.dataset).savefig("impact.png")

A run of a physical case is drawn in SI with fitting prefixes, a dimensionless one in units a*, a*^2/R, p_h*, t0.
Colours are told apart by everybody (Okabe and Ito's; for what is ordered, maps whose lightness is).
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from ertel import hertz
from ertel.dataset import EVENTS, PREFIXES, exponent, with_prefix

Values = NDArray[np.float64]

BLUE, ORANGE, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#777777"
FILM_COLOURS, PRESSURE_COLOURS = "YlGnBu_r", "YlOrRd"
TIME_COLOURS = LinearSegmentedColormap.from_list("time", colormaps["viridis"](np.linspace(0.0, 0.88, 256)))
UNITS = {"a*": "$a^*$", "a*^2/R": "$a^{*2}/R$", "p_h*": "$p_h^*$", "t0": "$t_0$", "F*": "$F^*$"}
MARGIN = 1.3  # of what is shown round the contact


# -- what is drawn ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scale:
    """How a dimensionless variable is shown: times a factor, under a label."""

    factor: float
    symbol: str
    unit: str
    long_name: str

    @property
    def label(self) -> str:
        return f"{self.long_name} {self.symbol} ({self.unit})" if self.unit else f"{self.long_name} {self.symbol}"


def scale(dataset: xr.Dataset, name: str, largest: float) -> Scale:
    """The scale of a variable: SI with the prefix that fits `largest` (dimensionless), or the dimensionless units."""
    attributes = dataset[name].attrs
    if "si_factor" not in attributes:
        unit = attributes.get("in_units_of", "")
        return Scale(1.0, _mathtext(attributes["symbol"]), UNITS.get(unit, unit), attributes["long_name"])
    power = exponent(abs(largest) * attributes["si_factor"])
    unit = PREFIXES[power] + attributes["si_units"]
    factor = attributes["si_factor"] / 10**power
    return Scale(factor, _mathtext(attributes["si_name"]), unit, attributes["long_name"])


def _mathtext(symbol: str) -> str:
    """H_min as $H_\\mathrm{min}$, Delta as a Greek letter."""
    base, _, index = symbol.replace("Delta", r"\Delta").replace("delta", r"\delta").partition("_")
    return f"${base}_\\mathrm{{{index}}}$" if index else f"${base}$"


@dataclass(frozen=True)
class Profiles:
    """Film and pressure along the mid-line through time: P, H of shape (frames, x), dimensionless."""

    x: Values
    T: Values
    P: Values
    H: Values
    maximum: int  # the frame of maximum approach, or the last where that was not reached


def profiles_of(dataset: xr.Dataset) -> Profiles:
    """The mid-line: Y = 0 of a map, or a radius and its mirror image.  Raises ValueError where there is no map yet."""
    T = np.asarray(dataset["frame"].values)
    if not len(T):
        raise ValueError("dataset: has no maps yet, there is nothing to draw")
    at_maximum = np.flatnonzero(dataset["event"].values == EVENTS.index("max-approach"))
    maximum = int(at_maximum[0]) if len(at_maximum) else len(T) - 1
    if "r" in dataset:
        x, P, H = (_mirrored(dataset[name].values, odd=name == "r") for name in ("r", "P", "H"))
    else:
        x = np.asarray(dataset["X"].values)
        P, H = (dataset[name].sel(Y=0.0, method="nearest").values for name in ("P", "H"))
    return Profiles(x, T, P, H, maximum)


def _mirrored(values: Values, odd: bool) -> Values:
    left = values[..., :0:-1]
    return np.concatenate([-left if odd else left, values], axis=-1)


def map_of(dataset: xr.Dataset, name: str, frame: int) -> tuple[Values, Values]:
    """X (the same as Y) and a field of one frame over it; a radial profile is turned round the centre."""
    values = np.asarray(dataset[name].isel(frame=frame).values)
    if "r" not in dataset:
        return np.asarray(dataset["X"].values), values
    r = np.asarray(dataset["r"].values)
    x = np.linspace(-r[-1], r[-1], 601)
    return x, np.interp(np.hypot(x[:, None], x[None, :]), r, values)


def _loaded_radius(p: Profiles) -> float:
    """How far from the centre the film carries pressure at the maximum."""
    loaded = p.x[p.P[p.maximum] > 0.02 * p.P[p.maximum].max()]
    reach = float(np.abs(loaded).max()) if len(loaded) else float(p.x.max())
    return max(reach, 0.2 * float(p.x.max()))  # something to see even at first touch


def _largest_inside(p: Profiles, H: Values) -> float:
    """The largest film well inside the contact."""
    return float(H[np.abs(p.x) < 0.8 * _loaded_radius(p)].max())


# -- panels -----------------------------------------------------------------------------------------------------------


def draw_film_map(axes: Axes, dataset: xr.Dataset) -> None:
    """Film thickness at maximum approach, with contour lines at equal steps as an interferometer shows them."""
    p = profiles_of(dataset)
    x, H = map_of(dataset, "H", p.maximum)
    top = 1.5 * _largest_inside(p, p.H[p.maximum])
    z = scale(dataset, "H", top / 2)
    levels = np.asarray(MaxNLocator(10).tick_values(0.0, top * z.factor))
    _draw_map(axes, dataset, p, x, H, z, levels, FILM_COLOURS)
    step = levels[1] - levels[0]
    axes.set_title(f"Film thickness, a line every {step:.3g} {z.unit}")


def draw_pressure_map(axes: Axes, dataset: xr.Dataset) -> None:
    """Pressure at maximum approach, with contour lines at equal steps."""
    p = profiles_of(dataset)
    x, P = map_of(dataset, "P", p.maximum)
    z = scale(dataset, "P", float(P.max()))
    levels = np.asarray(MaxNLocator(10).tick_values(0.0, float(P.max()) * z.factor))
    _draw_map(axes, dataset, p, x, P, z, levels, PRESSURE_COLOURS)
    axes.set_title(f"Pressure, a line every {levels[1] - levels[0]:.3g} {z.unit}")


def _draw_map(
    axes: Axes, dataset: xr.Dataset, p: Profiles, x: Values, values: Values, z: Scale, levels: Values, colours: str
) -> None:
    """Colours and contour lines round the contact; what is above the highest level has its colour."""
    across = _lateral(dataset)
    inside = np.abs(x) <= MARGIN * _loaded_radius(p)
    along, shown = x[inside] * across.factor, values[np.ix_(inside, inside)] * z.factor
    limits = Normalize(0.0, levels[-1])
    image = axes.pcolormesh(along, along, shown, cmap=colours, norm=limits, shading="gouraud", rasterized=True)
    axes.contour(along, along, shown, levels=levels[1:], colors="black", linewidths=0.4, alpha=0.6)
    x_name, y_name = ("$x$", "$y$") if _is_physical(dataset) else ("$X$", "$Y$")
    axes.set(xlabel=f"{x_name} ({across.unit})", ylabel=f"{y_name} ({across.unit})", aspect="equal")
    extend = "max" if shown.max() > levels[-1] else "neither"
    _figure(axes).colorbar(image, ax=axes, label=z.label, extend=extend)


def draw_film_profiles(axes: Axes, dataset: xr.Dataset) -> None:
    """Film along the mid-line through time, the maximum approach in black."""
    p = profiles_of(dataset)
    top = 2.0 * _largest_inside(p, p.H[p.maximum])
    z = scale(dataset, "H", top / 2)
    _draw_profiles(axes, dataset, p, p.H * z.factor)
    axes.set(ylim=(0.0, top * z.factor), ylabel=z.label)
    axes.legend(loc="lower center", frameon=False, fontsize="small")


def draw_pressure_profiles(axes: Axes, dataset: xr.Dataset) -> None:
    """Pressure along the mid-line through time, the maximum approach in black."""
    p = profiles_of(dataset)
    z = scale(dataset, "P", float(p.P.max()))
    _draw_profiles(axes, dataset, p, p.P * z.factor)
    axes.set(ylim=(0.0, 1.25 * float(p.P.max()) * z.factor), ylabel=z.label)
    axes.legend(loc="upper center", frameon=False, ncols=2, fontsize="small")


def _draw_profiles(axes: Axes, dataset: xr.Dataset, p: Profiles, values: Values) -> None:
    """Lines of the maps that carry load, coloured by time; those of the rebound are dashed."""
    time, across = scale(dataset, "time", 1.0), _lateral(dataset)
    loaded = np.flatnonzero(p.P.max(axis=1) > 0.02 * p.P.max())
    shown = loaded[:: max(1, round(len(loaded) / 14))]
    colours = ScalarMappable(Normalize(p.T[loaded[0]] * time.factor, p.T[loaded[-1]] * time.factor), TIME_COLOURS)
    x = p.x * across.factor
    for frame in shown[shown != p.maximum]:
        style, width = ("--", 0.8) if frame > p.maximum else ("-", 1.2)
        colour = colours.to_rgba(p.T[frame] * time.factor)
        axes.plot(x, values[frame], color=colour, linestyle=style, linewidth=width)
    axes.plot(x, values[p.maximum], color="black", linewidth=2.0, label=_moment(dataset))
    if shown[-1] > p.maximum:
        axes.plot([], [], color=GREY, linestyle="--", linewidth=0.8, label="rebound")
    reach = MARGIN * _loaded_radius(p) * across.factor
    axes.set(xlim=(-reach, reach), xlabel=f"{'$x$' if _is_physical(dataset) else '$X$'} ({across.unit})")
    _figure(axes).colorbar(colours, ax=axes, label=time.label)


def draw_motion(axes: Axes, dataset: xr.Dataset) -> None:
    """Approach, load and speed through time, as shares of those of the dry impact."""
    lines = {
        "Delta": (r"approach $\delta/\delta^*$", BLUE, "-"),
        "F": ("load $F/F^*$", ORANGE, "-"),
        "V": ("speed $v/v_0$", GREY, "-."),
    }
    _draw_series(axes, dataset, lines, 1.0)
    axes.axhline(0.0, color="black", linewidth=0.5)
    axes.set(ylabel="share of the dry impact's", ylim=(-1.1, 1.35))
    axes.legend(loc="upper left", frameon=False, ncols=3, columnspacing=1.0, handlelength=1.5, fontsize="small")


def draw_film_history(axes: Axes, dataset: xr.Dataset) -> None:
    """Central and least film thickness through time."""
    z = scale(dataset, "H_c", float(dataset["H_c"].min()))
    lines = {"H_c": (_named(dataset, "H_c"), BLUE, "-"), "H_min": (_named(dataset, "H_min"), ORANGE, "-")}
    _draw_series(axes, dataset, lines, z.factor)
    H_min = dataset["H_min"].values * z.factor
    low = 0.6 * float(H_min[H_min > 0].min(initial=H_min.max()))  # a film may vanish on a coarse grid
    axes.set(yscale="log", ylabel=f"film thickness ({z.unit})", ylim=(low, None))
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.legend(loc="upper right", frameon=False, fontsize="small")


def draw_pressure_history(axes: Axes, dataset: xr.Dataset) -> None:
    """Central and largest pressure through time."""
    z = scale(dataset, "P_max", float(dataset["P_max"].max()))
    lines = {"P_max": (_named(dataset, "P_max"), ORANGE, "-"), "P_c": (_named(dataset, "P_c"), BLUE, "-")}
    _draw_series(axes, dataset, lines, z.factor)
    axes.set(ylabel=f"pressure ({z.unit})", ylim=(0.0, None))
    axes.legend(loc="upper left", frameon=False, fontsize="small")


def draw_front(axes: Axes, dataset: xr.Dataset) -> None:
    """The front, where the film is thinnest, beside the edge of the dry contact."""
    across, T = _lateral(dataset), dataset["time"].values
    loaded = dataset["P_max"].values > 0.02 * float(dataset["P_max"].max())
    X_min = dataset["X_min"].values
    front = np.where(loaded & (X_min > 0), X_min, np.nan)
    touch = -json.loads(dataset.attrs["case"])["time"]["start_approach"]
    dry = np.where(hertz.contact_radius(T - touch) > 0, hertz.contact_radius(T - touch), np.nan)
    time = scale(dataset, "time", 1.0)
    axes.plot(T * time.factor, dry * across.factor, color=GREY, linestyle="--", label="edge of the dry contact")
    _draw_series(axes, dataset, {"X_min": ("front: place of the least film", GREEN, "-")}, across.factor, front)
    axes.set(ylabel=f"distance from the centre ({across.unit})", ylim=(0.0, 1.25 * across.factor))
    axes.legend(loc="upper left", frameon=False, fontsize="small")


Lines = Mapping[str, tuple[str, str, str]]  # variable: label, colour, style


def _draw_series(axes: Axes, dataset: xr.Dataset, lines: Lines, factor: float, values: Values | None = None) -> None:
    time = scale(dataset, "time", 1.0)
    T = dataset["time"].values * time.factor
    for name, (label, colour, style) in lines.items():
        shown = dataset[name].values if values is None else values
        axes.plot(T, shown * factor, color=colour, linestyle=style, label=label)
    p = profiles_of(dataset)
    if _moment(dataset) == MAXIMUM:
        axes.axvline(p.T[p.maximum] * time.factor, color="black", linewidth=0.8, linestyle=":")
    axes.set(xlabel=time.label, xlim=(0.0, T[-1]))


MAXIMUM = "maximum approach"


def _moment(dataset: xr.Dataset) -> str:
    return MAXIMUM if EVENTS.index("max-approach") in dataset["event"].values else "last map"


def _named(dataset: xr.Dataset, name: str) -> str:
    named = scale(dataset, name, 1.0)
    return f"{named.long_name} {named.symbol}"


def _lateral(dataset: xr.Dataset) -> Scale:
    return scale(dataset, "r" if "r" in dataset else "X", 1.0)


def _is_physical(dataset: xr.Dataset) -> bool:
    return "si_factor" in dataset["H"].attrs


def _figure(axes: Axes) -> Figure:
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    return figure


# -- figures ----------------------------------------------------------------------------------------------------------

Panel = Callable[[Axes, xr.Dataset], None]


def maps(dataset: xr.Dataset) -> Figure:
    """Film and pressure over the surface at maximum approach."""
    return _compose(dataset, [[draw_film_map, draw_pressure_map]])


def profiles(dataset: xr.Dataset) -> Figure:
    """Film and pressure along the mid-line through time."""
    return _compose(dataset, [[draw_film_profiles, draw_pressure_profiles]])


def history(dataset: xr.Dataset) -> Figure:
    """Approach, load, film thickness, pressure and front through time."""
    return _compose(dataset, [[draw_motion, draw_film_history], [draw_front, draw_pressure_history]])


def overview(dataset: xr.Dataset) -> Figure:
    """The impact on one page: maps at maximum approach, profiles and histories."""
    film: list[Panel] = [draw_film_map, draw_film_profiles, draw_film_history]
    return _compose(dataset, [film, [draw_pressure_map, draw_pressure_profiles, draw_motion]])


FIGURES: Mapping[str, Callable[[xr.Dataset], Figure]] = {
    "overview": overview,
    "maps": maps,
    "profiles": profiles,
    "history": history,
}


def _compose(dataset: xr.Dataset, rows: list[list[Panel]]) -> Figure:
    dataset = dataset.load()
    figure = Figure(figsize=(5.0 * len(rows[0]), 4.0 * len(rows) + 0.4), layout="constrained", dpi=150)
    figure.get_layout_engine().set(w_pad=0.12, h_pad=0.1)  # type: ignore[union-attr, call-arg]
    for panels, line in zip(rows, figure.subplots(len(rows), len(rows[0]), squeeze=False), strict=True):
        for draw, axes in zip(panels, line, strict=True):
            draw(axes, dataset)
    figure.suptitle(_title(dataset), fontsize="medium")
    return figure


def _title(dataset: xr.Dataset) -> str:
    """What it is and when: name, conditions, the moment of the maps."""
    a, p = dataset.attrs, profiles_of(dataset)
    name = str(a["title"]).replace("_", " ")
    time = scale(dataset, "time", 1.0)
    conditions = [f"$M$ = {a['M']:.4g}", f"$L$ = {a['L']:.3g}"]
    if _is_physical(dataset):
        conditions = [
            f"$R$ = {with_prefix(a['R_m'], 'm')}",
            f"$v_0$ = {with_prefix(a['v0_m_per_s'], 'm/s')}",
            f"$p_h^*$ = {with_prefix(a['p_h_Pa'], 'Pa')}",
            *conditions,
        ]
    moment = f"{_moment(dataset)} at {time.symbol} = {p.T[p.maximum] * time.factor:.3g} {time.unit}"
    return f"{name[:1].upper()}{name[1:]}:  {',  '.join(conditions)};  {moment}"
