"""Panels that show a run through time: motion, load, film thickness, pressure, places."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter

from ertel.physics import hertz
from ertel.plots import stored
from ertel.plots.drawing import BLUE, GREEN, GREY, LOADED, ORANGE, NoFigure, Values, lateral, named, scale
from ertel.plots.moments import LAST, Profiles
from ertel.results import fronts

Lines = Mapping[str, tuple[str, str, str]]  # variable: label, colour, style


def draw_motion(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Approach, load and speed of an impact through time, as shares of those of the dry impact."""
    lines = {
        "Delta": (r"approach $\delta/\delta^*$", BLUE, "-"),
        "F": ("load $F/F^*$", ORANGE, "-"),
        "V": ("speed $v/v_0$", GREY, "-."),
    }
    shares = dataset.assign(Delta=dataset["Delta"] / stored.geometry(dataset).dry_approach(1.0))
    draw_series(axes, shares, p, lines, 1.0)
    axes.axhline(0.0, color="black", linewidth=0.5)
    axes.set(ylabel="share of the dry impact's", ylim=(-1.1, 1.35))
    axes.legend(loc="upper left", edgecolor="none", ncols=3, columnspacing=1.0, handlelength=1.5, fontsize="small")


def draw_drive(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Load and entrainment of a rolling contact and its approach through time, as shares of the static contact's."""
    lines = {
        "Delta": (r"approach $\delta R/a^2$", BLUE, "-"),
        "F": ("load of the film", ORANGE, "-"),
        "U": ("entrainment", GREEN, "--"),
        "w": ("applied load", "black", ":"),
    }
    lines = {name: line for name, line in lines.items() if name in dataset}
    draw_series(axes, dataset, p, lines, 1.0)
    low, high = (function([dataset[name].values for name in lines]) for function in (np.min, np.max))
    span = max(high - min(low, 0.0), 0.1)
    axes.set(ylabel="share of the static contact's", ylim=(min(low, 0.0) - 0.05 * span, high + 0.3 * span))
    axes.legend(loc="upper left", edgecolor="none", ncols=2, columnspacing=1.0, fontsize="small")


def draw_film_history(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Central and minimum film thickness through time, over decades where the film falls by as much."""
    z = scale(dataset, "H_c", float(dataset["H_c"].min()))
    lines = {"H_c": (named(dataset, "H_c"), BLUE, "-"), "H_min": (named(dataset, "H_min"), ORANGE, "-")}
    draw_series(axes, dataset, p, lines, z.factor)
    axes.set(ylabel=f"film thickness ({z.unit})")
    axes.legend(loc="upper right", edgecolor="none", fontsize="small")
    films = [dataset[name].values * z.factor for name in lines]
    if np.max(films[0]) < 5.0 * np.min(films[0]):
        axes.set(ylim=(0.0, 1.35 * np.max(films)))
        return
    low = 0.6 * float(films[1][films[1] > 0].min(initial=films[1].max()))  # a film may vanish on a coarse grid
    axes.set(yscale="log", ylim=(low, None))
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())


def draw_pressure_history(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Central and maximum pressure through time."""
    z = scale(dataset, "P_max", float(dataset["P_max"].max()))
    lines = {"P_max": (named(dataset, "P_max"), ORANGE, "-"), "P_c": (named(dataset, "P_c"), BLUE, "-")}
    draw_series(axes, dataset, p, lines, z.factor)
    axes.set(ylabel=f"pressure ({z.unit})", ylim=(0.0, 1.3 * float(dataset["P_max"].max()) * z.factor))
    axes.legend(loc="upper left", edgecolor="none", fontsize="small")


def draw_front(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """The front of an impact, where the film is thinnest, and the edge of the dry contact, through time."""
    across, T = lateral(dataset), dataset["time"].values
    loaded = dataset["P_max"].values > LOADED * float(dataset["P_max"].max())
    X_min = np.hypot(dataset["X_min"].values, dataset["Y_min"].values)
    front = np.where(loaded & (X_min > 0), X_min, np.nan)
    dry = _dry_edge(dataset, T)
    time = scale(dataset, "time", 1.0)
    axes.plot(T * time.factor, dry * across.factor, color=GREY, linestyle="--", label="edge of the dry contact")
    lines = {"X_min": ("front: place of the minimum film thickness", GREEN, "-")}
    draw_series(axes, dataset, p, lines, across.factor, front)
    axes.set(ylabel=f"distance from the centre ({across.unit})", ylim=(0.0, 1.25 * across.factor))
    axes.legend(loc="upper left", edgecolor="none", fontsize="small")


def _dry_edge(dataset: xr.Dataset, T: Values) -> Values:
    """The edge of the dry contact in a*, nan without contact."""
    since_touch = T + stored.start_approach(dataset)
    dry = hertz.contact_radius(since_touch / stored.geometry(dataset).dry_approach(1.0))
    return np.where(dry > 0, dry, np.nan)


def draw_front_speed(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """The speed at which the front of an impact goes outwards up to maximum approach, and that of the dry contact."""
    try:
        front = fronts.front(dataset)
    except ValueError as error:
        raise NoFigure(f"the front has no speed: {error}") from error
    z, time = scale(dataset, "U", float(np.median(front.speed))), scale(dataset, "time", 1.0)
    T = np.linspace(front.T[0], front.T[-1], 400)
    dry = np.gradient(_dry_edge(dataset, T), T)
    axes.plot(T * time.factor, dry * z.factor, color=GREY, linestyle="--", label="edge of the dry contact")
    axes.plot(front.T * time.factor, front.speed * z.factor, color=GREEN, label="front: place of the minimum film")
    if p.moment != LAST:
        axes.axvline(p.time * time.factor, color="black", linewidth=0.8, linestyle=":")
    top = 3.0 * float(np.median(front.speed)) * z.factor  # the first touch is faster without end
    end = float(dataset["time"][-1]) * time.factor
    axes.set(xlabel=time.label, ylabel=f"speed ({z.unit})", xlim=(0.0, end), ylim=(0.0, top))
    axes.legend(loc="upper right", edgecolor="none", fontsize="small")


def draw_minimum_film(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Place of the minimum film thickness of a rolling contact through time: a side lobe, the exit, a feature."""
    across = lateral(dataset)
    lines = {"X_min": ("along the flow", BLUE, "-"), "Y_min": ("to the side", ORANGE, "--")}
    draw_series(axes, dataset, p, {name: line for name, line in lines.items() if name in dataset}, across.factor)
    axes.axhline(0.0, color="black", linewidth=0.5)
    axes.set(ylabel=f"place of the minimum film ({across.unit})", ylim=(-1.3 * across.factor, 1.7 * across.factor))
    axes.legend(loc="upper left", edgecolor="none", ncols=2, fontsize="small")


def draw_series(
    axes: Axes, dataset: xr.Dataset, p: Profiles, lines: Lines, factor: float, values: Values | None = None
) -> None:
    """Lines over time, and a dotted one at the moment that the maps show."""
    time = scale(dataset, "time", 1.0)
    T = dataset["time"].values * time.factor
    for name, (label, colour, style) in lines.items():
        shown = dataset[name].values if values is None else values
        axes.plot(T, shown * factor, color=colour, linestyle=style, label=label)
    if p.moment != LAST:
        axes.axvline(p.time * time.factor, color="black", linewidth=0.8, linestyle=":")
    axes.set(xlabel=time.label, xlim=(0.0, T[-1]) if T[-1] > 0 else None)
