"""Pictures of a run: Dataset -> matplotlib Figure.  Nothing is shown, nothing is saved.

    ertel.plotting.overview(result.dataset).savefig("impact.png")

FIGURES draw a run in time, impact or rolling, STEADY_FIGURES a steady contact; `figures_of` knows which.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from ertel.physics import hertz
from ertel.results.plots.drawing import (
    BLUE,
    GREEN,
    GREY,
    LOADED,
    ORANGE,
    ORDERED_COLOURS,
    Figures,
    Panel,
    Values,
    axis_label,
    compose,
    draw_film,
    draw_flow,
    draw_pressure,
    extent,
    figure_of,
    film_inside,
    lateral,
    map_of,
    named,
    scale,
    title,
)
from ertel.results.plots.steady import STEADY_FIGURES
from ertel.results.variables import EVENTS

MAXIMUM, LAST = "maximum approach", "last map"


# -- what is drawn ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Profiles:
    """Film and pressure along the mid-line through time: P, H of shape (frames, x), dimensionless."""

    x: Values
    T: Values
    P: Values
    H: Values
    chosen: int  # the frame of maximum approach, or the last where there is none
    moment: str  # what it is: MAXIMUM or LAST


def profiles_of(dataset: xr.Dataset) -> Profiles:
    """The mid-line: Y = 0 of a map, or a radius and its mirror image.  Raises ValueError where there is no map yet."""
    T = np.asarray(dataset["frame"].values)
    if not len(T):
        raise ValueError("dataset: has no maps yet, there is nothing to draw")
    at_maximum = np.flatnonzero(dataset["event"].values == EVENTS.index("max-approach"))
    chosen, moment = (int(at_maximum[0]), MAXIMUM) if len(at_maximum) else (len(T) - 1, LAST)
    if "r" in dataset:
        x, P, H = (_mirrored(dataset[name].values, odd=name == "r") for name in ("r", "P", "H"))
    else:
        x = np.asarray(dataset["X"].values)
        P, H = (dataset[name].sel(Y=0.0, method="nearest").values for name in ("P", "H"))
    return Profiles(x, T, P, H, chosen, moment)


def _mirrored(values: Values, odd: bool) -> Values:
    left = values[..., :0:-1]
    return np.concatenate([-left if odd else left, values], axis=-1)


# -- panels ------------------------------------------------------------------------------------------


def draw_film_map(axes: Axes, dataset: xr.Dataset) -> None:
    """Film thickness at the chosen moment, with contour lines at equal steps as an interferometer shows them."""
    p = profiles_of(dataset)
    P, H = p.P[p.chosen], p.H[p.chosen]
    field, side = map_of(dataset, "H", p.chosen), extent(p.x, P)
    draw_film(axes, dataset, field, side, 1.5 * film_inside(p.x, P, H))
    draw_flow(axes, _entrainment(dataset, p.T[p.chosen]))


def draw_pressure_map(axes: Axes, dataset: xr.Dataset) -> None:
    """Pressure at the chosen moment, with contour lines at equal steps."""
    p = profiles_of(dataset)
    draw_pressure(axes, dataset, map_of(dataset, "P", p.chosen), extent(p.x, p.P[p.chosen]))
    draw_flow(axes, _entrainment(dataset, p.T[p.chosen]))


def _entrainment(dataset: xr.Dataset, T: float) -> float:
    """U at T; zero of a run that does not tell (an impact without flow)."""
    return float(np.interp(T, dataset["time"].values, dataset["U"].values)) if "U" in dataset else 0.0


def draw_film_profiles(axes: Axes, dataset: xr.Dataset) -> None:
    """Film along the mid-line through time, the chosen moment in black."""
    p = profiles_of(dataset)
    top = 2.0 * film_inside(p.x, p.P[p.chosen], p.H[p.chosen])
    z = scale(dataset, "H", top / 2)
    _draw_profiles(axes, dataset, p, p.H * z.factor)
    axes.set(ylim=(0.0, top * z.factor), ylabel=z.label)
    axes.legend(loc="lower center", frameon=False, fontsize="small")


def draw_pressure_profiles(axes: Axes, dataset: xr.Dataset) -> None:
    """Pressure along the mid-line through time, the chosen moment in black."""
    p = profiles_of(dataset)
    z = scale(dataset, "P", float(p.P.max()))
    _draw_profiles(axes, dataset, p, p.P * z.factor)
    axes.set(ylim=(0.0, 1.25 * float(p.P.max()) * z.factor), ylabel=z.label)
    axes.legend(loc="upper center", frameon=False, ncols=2, fontsize="small")


def _draw_profiles(axes: Axes, dataset: xr.Dataset, p: Profiles, values: Values) -> None:
    """Lines of the maps that carry load, coloured by time; those of the rebound are dashed."""
    time, across = scale(dataset, "time", 1.0), lateral(dataset)
    loaded = np.flatnonzero(p.P.max(axis=1) > LOADED * p.P.max())
    shown = loaded[:: max(1, round(len(loaded) / 14))]
    colours = ScalarMappable(Normalize(p.T[loaded[0]] * time.factor, p.T[loaded[-1]] * time.factor), ORDERED_COLOURS)
    x = p.x * across.factor
    for frame in shown[shown != p.chosen]:
        style, width = ("--", 0.8) if frame > p.chosen else ("-", 1.2)
        colour = colours.to_rgba(p.T[frame] * time.factor)
        axes.plot(x, values[frame], color=colour, linestyle=style, linewidth=width)
    axes.plot(x, values[p.chosen], color="black", linewidth=2.0, label=p.moment)
    if shown[-1] > p.chosen:
        axes.plot([], [], color=GREY, linestyle="--", linewidth=0.8, label="rebound")
    side = extent(p.x, p.P[p.chosen]) * across.factor
    axes.set(xlim=(-side, min(side, x[-1])), xlabel=axis_label(dataset, "x"))
    figure_of(axes).colorbar(colours, ax=axes, label=time.label)


def draw_motion(axes: Axes, dataset: xr.Dataset) -> None:
    """Approach, load and speed of an impact through time, as shares of those of the dry impact."""
    lines = {
        "Delta": (r"approach $\delta/\delta^*$", BLUE, "-"),
        "F": ("load $F/F^*$", ORANGE, "-"),
        "V": ("speed $v/v_0$", GREY, "-."),
    }
    _draw_series(axes, dataset, lines, 1.0)
    axes.axhline(0.0, color="black", linewidth=0.5)
    axes.set(ylabel="share of the dry impact's", ylim=(-1.1, 1.35))
    axes.legend(loc="upper left", frameon=False, ncols=3, columnspacing=1.0, handlelength=1.5, fontsize="small")


def draw_drive(axes: Axes, dataset: xr.Dataset) -> None:
    """What drives a rolling contact, load and entrainment, and how it answers, as shares of the static contact's."""
    lines = {
        "Delta": (r"approach $\delta R/a^2$", BLUE, "-"),
        "F": ("load of the film", ORANGE, "-"),
        "U": ("entrainment", GREEN, "--"),
        "w": ("applied load", "black", ":"),
    }
    lines = {name: line for name, line in lines.items() if name in dataset}
    _draw_series(axes, dataset, lines, 1.0)
    low, high = (function([dataset[name].values for name in lines]) for function in (np.min, np.max))
    span = max(high - min(low, 0.0), 0.1)
    axes.set(ylabel="share of the static contact's", ylim=(min(low, 0.0) - 0.05 * span, high + 0.3 * span))
    axes.legend(loc="upper left", frameon=False, ncols=2, columnspacing=1.0, fontsize="small")


def draw_film_history(axes: Axes, dataset: xr.Dataset) -> None:
    """Central and least film thickness through time, over decades where the film falls by as much."""
    z = scale(dataset, "H_c", float(dataset["H_c"].min()))
    lines = {"H_c": (named(dataset, "H_c"), BLUE, "-"), "H_min": (named(dataset, "H_min"), ORANGE, "-")}
    _draw_series(axes, dataset, lines, z.factor)
    axes.set(ylabel=f"film thickness ({z.unit})")
    axes.legend(loc="upper right", frameon=False, fontsize="small")
    films = [dataset[name].values * z.factor for name in lines]
    if np.max(films[0]) < 5.0 * np.min(films[0]):
        axes.set(ylim=(0.0, 1.35 * np.max(films)))
        return
    low = 0.6 * float(films[1][films[1] > 0].min(initial=films[1].max()))  # a film may vanish on a coarse grid
    axes.set(yscale="log", ylim=(low, None))
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())


def draw_pressure_history(axes: Axes, dataset: xr.Dataset) -> None:
    """Central and largest pressure through time."""
    z = scale(dataset, "P_max", float(dataset["P_max"].max()))
    lines = {"P_max": (named(dataset, "P_max"), ORANGE, "-"), "P_c": (named(dataset, "P_c"), BLUE, "-")}
    _draw_series(axes, dataset, lines, z.factor)
    axes.set(ylabel=f"pressure ({z.unit})", ylim=(0.0, 1.3 * float(dataset["P_max"].max()) * z.factor))
    axes.legend(loc="upper left", frameon=False, fontsize="small")


def draw_front(axes: Axes, dataset: xr.Dataset) -> None:
    """The front of an impact, where the film is thinnest, beside the edge of the dry contact."""
    across, T = lateral(dataset), dataset["time"].values
    loaded = dataset["P_max"].values > LOADED * float(dataset["P_max"].max())
    X_min = np.hypot(dataset["X_min"].values, dataset["Y_min"].values)
    front = np.where(loaded & (X_min > 0), X_min, np.nan)
    touch = -json.loads(dataset.attrs["case"])["time"]["start_approach"]
    dry = np.where(hertz.contact_radius(T - touch) > 0, hertz.contact_radius(T - touch), np.nan)
    time = scale(dataset, "time", 1.0)
    axes.plot(T * time.factor, dry * across.factor, color=GREY, linestyle="--", label="edge of the dry contact")
    _draw_series(axes, dataset, {"X_min": ("front: place of the least film", GREEN, "-")}, across.factor, front)
    axes.set(ylabel=f"distance from the centre ({across.unit})", ylim=(0.0, 1.25 * across.factor))
    axes.legend(loc="upper left", frameon=False, fontsize="small")


def draw_least_film(axes: Axes, dataset: xr.Dataset) -> None:
    """Where the film of a rolling contact is thinnest, through time: in a side lobe, at the exit, at a feature."""
    across = lateral(dataset)
    lines = {"X_min": ("along the flow", BLUE, "-"), "Y_min": ("to the side", ORANGE, "--")}
    _draw_series(axes, dataset, {name: line for name, line in lines.items() if name in dataset}, across.factor)
    axes.axhline(0.0, color="black", linewidth=0.5)
    axes.set(ylabel=f"place of the least film ({across.unit})", ylim=(-1.3 * across.factor, 1.7 * across.factor))
    axes.legend(loc="upper left", frameon=False, ncols=2, fontsize="small")


Lines = Mapping[str, tuple[str, str, str]]  # variable: label, colour, style


def _draw_series(axes: Axes, dataset: xr.Dataset, lines: Lines, factor: float, values: Values | None = None) -> None:
    time = scale(dataset, "time", 1.0)
    T = dataset["time"].values * time.factor
    for name, (label, colour, style) in lines.items():
        shown = dataset[name].values if values is None else values
        axes.plot(T, shown * factor, color=colour, linestyle=style, label=label)
    p = profiles_of(dataset)
    if p.moment == MAXIMUM:
        axes.axvline(p.T[p.chosen] * time.factor, color="black", linewidth=0.8, linestyle=":")
    axes.set(xlabel=time.label, xlim=(0.0, T[-1]) if T[-1] > 0 else None)


# -- figures ----------------------------------------------------------------------------------------------------------


def maps(dataset: xr.Dataset) -> Figure:
    """Film and pressure over the surface, at maximum approach or at last."""
    return _of_run(dataset, [[draw_film_map, draw_pressure_map]])


def profiles(dataset: xr.Dataset) -> Figure:
    """Film and pressure along the mid-line through time."""
    return _of_run(dataset, [[draw_film_profiles, draw_pressure_profiles]])


def history(dataset: xr.Dataset) -> Figure:
    """What moves the bodies, film thickness, pressure and the place of the least film through time."""
    rolling = dataset.attrs["kind"] == "rolling"
    motion, place = (draw_drive, draw_least_film) if rolling else (draw_motion, draw_front)
    return _of_run(dataset, [[motion, draw_film_history], [place, draw_pressure_history]])


def overview(dataset: xr.Dataset) -> Figure:
    """The run on one page: maps, profiles and histories."""
    motion = draw_drive if dataset.attrs["kind"] == "rolling" else draw_motion
    film: list[Panel] = [draw_film_map, draw_film_profiles, draw_film_history]
    return _of_run(dataset, [film, [draw_pressure_map, draw_pressure_profiles, motion]])


def _of_run(dataset: xr.Dataset, rows: list[list[Panel]]) -> Figure:
    dataset = dataset.load()
    p, time = profiles_of(dataset), scale(dataset, "time", 1.0)
    moment = f"{p.moment} at {time.symbol} = {p.T[p.chosen] * time.factor:.3g} {time.unit}"
    return compose(dataset, rows, [*title(dataset), moment])


FIGURES: Figures = {"overview": overview, "maps": maps, "profiles": profiles, "history": history}


def figures_of(dataset: xr.Dataset) -> Figures:
    """The figures that a run can be drawn in, by name."""
    return STEADY_FIGURES if dataset.attrs["method"] == "steady" else FIGURES
