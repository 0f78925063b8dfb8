"""Panels that show a run through time, and the convergence of a steady contact on its grids."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.ticker import LogLocator, MaxNLocator

from ertel.physics import hertz
from ertel.plots.drawing import BLUE, GREEN, GREY, ORANGE, ORDERED_COLOURS, NoFigure, Values, plain_ticks
from ertel.plots.view import LOADED, WIDEST, View
from ertel.results import fronts
from ertel.results.profiles import LAST, events_of

PALE_BLUE = "#0072B255"
Look = tuple[str, str, str]  # label, colour and style of a line


def _draw_series(axes: Axes, view: View, lines: Iterable[tuple[Values, Look]], factor: float = 1.0) -> None:
    """Draw lines over time, and a dotted one at the moment that the maps show."""
    time = view.scale("time")
    T = time.shown(view.dataset["time"].values)
    for values, (label, colour, style) in lines:
        axes.plot(T, values * factor, color=colour, linestyle=style, label=label)
    if view.moment != LAST:
        axes.axvline(time.shown(view.time), color="black", linewidth=0.8, linestyle=":")
    axes.set(xlabel=time.label, xlim=(time.shown(0.0), T[-1]) if T[-1] > time.shown(0.0) else None)


def _integral(values: Values, T: Values) -> Values:
    """The integral over time from the beginning, by trapezia."""
    return np.append(0.0, np.cumsum(np.diff(T) * (values[1:] + values[:-1]) / 2))


def _stored(view: View, looks: Mapping[str, Look]) -> list[tuple[Values, Look]]:
    """The variables with the looks of their lines."""
    return [(view.dataset[name].values, look) for name, look in looks.items()]


# -- motion and place -------------------------------------------------------------------------------------------------


def draw_motion(axes: Axes, view: View) -> None:
    """Approach, load and speed or entrainment through time, as shares of those of the dry impact or static contact."""
    is_impact, approach = view.dataset.attrs["kind"] == "impact", view.dataset["Delta"].values
    if is_impact:
        first = approach / view.geometry.dry_approach(1.0), (r"approach $\delta/\delta^*$", BLUE, "-")
        looks = {"F": ("load $F/F^*$", ORANGE, "-"), "V": ("speed $v/v_0$", GREY, "-.")}
        axes.set(ylabel="share of the dry impact's", ylim=(-1.1, 1.2))
    else:
        first = approach, (r"approach $\delta R/a^2$", BLUE, "-")
        looks = {"F": ("load of the film", ORANGE, "-"), "U": ("entrainment", GREEN, "--")}
        looks |= {"w": ("applied load", "black", ":")}
        axes.set(ylabel="share of the static contact's")
    _draw_series(axes, view, [first, *_stored(view, looks)])
    axes.axhline(0.0, color="black", linewidth=0.5)
    axes.legend(loc="best", edgecolor="none", fontsize="small")


def draw_place(axes: Axes, view: View) -> None:
    """Place of the minimum film thickness through time; of an impact its front, with the edge of the dry contact."""
    data, across = view.dataset, view.across
    if data.attrs["kind"] != "impact":
        looks = {"X_min": ("along the flow", BLUE, "-"), "Y_min": ("to the side", ORANGE, "--")}
        looks = {name: look for name, look in looks.items() if name in data}
        _draw_series(axes, view, _stored(view, looks), across.factor)
        axes.axhline(0.0, color="black", linewidth=0.5)
        axes.set(ylabel=f"place of the minimum film ({across.unit})", ylim=(-1.3 * across.factor, 1.7 * across.factor))
        axes.legend(loc="upper left", edgecolor="none", ncols=2, fontsize="small")
        return
    loaded = data["P_max"].values > LOADED * float(data["P_max"].max())
    X_min = fronts.distance_of_minimum(data)
    front = np.where(loaded & (X_min > 0), X_min, np.nan)
    lines = [
        (_dry_edge(view, data["time"].values), ("edge of the dry contact", GREY, "--")),
        (front, ("front: place of the minimum film thickness", GREEN, "-")),
    ]
    _draw_series(axes, view, lines, across.factor)
    axes.set(ylabel=f"distance from the centre ({across.unit})", ylim=(0.0, 1.25 * across.factor))
    axes.legend(loc="upper left", edgecolor="none", fontsize="small")


def _dry_edge(view: View, T: Values) -> Values:
    """The edge of the dry contact in a*, nan without contact; that of a line by its speed, with A = 1 - s^2."""
    since_touch, line = T + view.case.schedule.start_approach, view.geometry.hertz
    if not view.geometry.is_line:
        dry = hertz.contact_radius(since_touch / view.geometry.dry_approach(1.0))
        return np.where(dry > 0, dry, np.nan)
    s = np.linspace(0.0, 1.0, 801)
    middle = (s[1:] + s[:-1]) / 2
    steps = np.diff(s) * 2.0 * middle / [line.front_speed(1.0 - each**2) for each in middle]
    before = np.abs(since_touch - line.contact_time / 2)  # the maximum, or after it: the rebound is the same
    return np.interp(before, np.append(0.0, np.cumsum(steps)), 1.0 - s**2, right=np.nan)


def draw_front_speed(axes: Axes, view: View) -> None:
    """Speed at which the front of an impact moves outwards up to maximum approach, and that of the dry contact."""
    if view.dataset.attrs["kind"] != "impact":
        raise NoFigure("front: a rolling contact has none; it belongs to an impact")
    try:
        front = fronts.front(view.dataset)
    except ValueError as error:
        raise NoFigure(f"the front has no speed: {error}") from error
    usual = float(np.median(front.speed))
    z, time = view.scale("U", usual), view.scale("time")
    T = np.linspace(front.T[0], front.T[-1], 400)
    dry = np.gradient(_dry_edge(view, T), T)
    axes.plot(time.shown(T), dry * z.factor, color=GREY, linestyle="--", label="edge of the dry contact")
    axes.plot(time.shown(front.T), front.speed * z.factor, color=GREEN, label="front")
    _draw_series(axes, view, [])
    axes.set(ylabel=f"speed ({z.unit})", ylim=(0.0, 3.0 * usual * z.factor))  # the first touch is faster without end
    axes.legend(loc="upper right", edgecolor="none", fontsize="small")


# -- film, pressure, friction -----------------------------------------------------------------------------------------


def draw_film_history(axes: Axes, view: View) -> None:
    """Central and minimum film thickness through time."""
    z = view.scale("H_c", view.largest("H_c", lambda each: float(each.dataset["H_c"].min())))
    looks = {"H_c": (view.legend("H_c"), BLUE, "-"), "H_min": (view.legend("H_min"), ORANGE, "-")}
    _draw_series(axes, view, _stored(view, looks), z.factor)
    axes.set(ylabel=f"film thickness ({z.unit})")
    axes.legend(loc="best", edgecolor="none", fontsize="small")
    films, beside = ([each.dataset[name].values for name in looks] if each else [] for each in (view, view.beside))
    limit_films(axes, [film * z.factor for film in films], beside)


def limit_films(axes: Axes, films: Sequence[Values], beside: Sequence[Values] = ()) -> None:
    """Show films through time from zero, or over decades where one of them, or of those beside, falls fivefold."""
    top = max(float(film.max()) for film in films)
    if all(film.max() < 5.0 * film.min() for film in (*films, *beside)):
        axes.set(ylim=(0.0, 1.35 * top))
        return
    low = 0.6 * min(float(film[film > 0].min(initial=top)) for film in films)  # a film may vanish on a coarse grid
    axes.set(yscale="log", ylim=(low, None))
    plain_ticks(axes.yaxis)


def draw_film_through_time(axes: Axes, view: View) -> None:
    """Film along the mid-line, time upwards, where there is pressure; of an impact with the edge of the dry contact.

    What is frozen into the film moves with the mean speed of the surfaces, as the dotted lines do.
    """
    data, across, time = view.dataset, view.across, view.scale("time")
    P, T, history = view.midlines("P"), data["frame"].values, data["time"].values
    loaded = LOADED * P.max() <= P  # all of it where nothing carries load
    top = 1.5 * view.film_inside()
    z = view.scale("H", top / 2)
    film = np.where(loaded, view.midlines("H"), np.nan) * z.factor
    x, shades = view.x * across.factor, Normalize(0.0, top * z.factor)
    image = axes.pcolormesh(x, time.shown(T), film, cmap="YlGnBu_r", norm=shades, rasterized=True)
    axes.figure.colorbar(image, ax=axes, label=z.label, extend="max")
    if data.attrs["kind"] == "impact":
        edge, names = _dry_edge(view, history) * across.factor, ["edge of the dry contact", "_"]
        axes.plot(np.transpose([edge, -edge]), time.shown(history), "k--", linewidth=0.8, label=names)
    moved = _integral(data["U"].values, history)
    if np.any(moved):
        starts = np.arange(-WIDEST - moved.max(), WIDEST - moved.min(), 0.5) * across.factor
        paths = starts + moved[:, None] * across.factor
        names = ["path with the mean speed", *["_"] * (len(starts) - 1)]
        axes.plot(paths, time.shown(history), "k:", linewidth=0.8, label=names)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower left", fontsize="small")
    if view.moment != LAST:
        axes.axhline(time.shown(view.time), color="black", linewidth=0.4)
    side = view.extent(view.x, P.max(axis=0)) * across.factor
    span = time.shown(T[loaded.any(axis=1)][[0, -1]])
    axes.set(xlim=(-side, side), ylim=span, xlabel=view.axis_label("x"), ylabel=time.label)
    axes.set_title("Film along the middle through time")


def draw_pressure_history(axes: Axes, view: View) -> None:
    """Central and maximum pressure through time; the last spike of a rebound, of the grid, is cut off."""
    data, T = view.dataset, view.scale("time").shown(view.dataset["time"].values)
    end = _end(data)
    top = float(data["P_max"][:end].max())
    z = view.scale(
        "P_max", view.largest("P_max", lambda each: float(each.dataset["P_max"][: _end(each.dataset)].max()))
    )
    looks = {"P_max": (view.legend("P_max"), ORANGE, "-"), "P_c": (view.legend("P_c"), BLUE, "-")}
    _draw_series(axes, view, _stored(view, looks), z.factor)
    if data["P_max"].size > end and data["P_max"][end:].max() > data["P_max"][end - 1]:
        axes.axvspan(T[end - 1], T[-1], color=GREY, alpha=0.25, linewidth=0.0, label="spike of the grid")
    axes.set(ylabel=f"pressure ({z.unit})", ylim=(0.0, 1.45 * top * z.factor))
    axes.legend(loc="upper left", edgecolor="none", fontsize="small")


def _end(data: xr.Dataset) -> int:
    """The number of steps up to the last one that carries load; all of a rolling contact."""
    if data.attrs["kind"] != "impact":
        return data.sizes["time"]
    return int(np.append(0, np.flatnonzero(_loaded(data))).max()) + 1


def draw_coefficients(axes: Axes, view: View) -> None:
    """Traction and rolling resistance through time, each with its own axis, while the film carries load."""
    data = view.dataset
    sliding = [(axes, "mu_sliding", BLUE)] if view.slides else []
    for place, name, colour in (*sliding, (axes.twinx() if view.slides else axes, "mu_rolling", ORANGE)):
        values = data[name].where(_loaded(data))
        z = view.scale(name, float(np.abs(values).max()))
        _draw_series(place, view, [(values.values, (z.long_name, colour, "-"))], z.factor)
        bottom, top = min(1.2 * float(values.min()) * z.factor, 0.0), max(1.2 * float(values.max()) * z.factor, 0.0)
        place.set_ylim(bottom, top if top > bottom else 1.0)
        place.set_ylabel(z.label, color=colour)
        place.tick_params(axis="y", colors=colour)
    axes.set_title("Coefficients of friction")


def _loaded(data: xr.Dataset) -> xr.DataArray:
    return data["F"] > LOADED * data["F"].max()


def draw_power(axes: Axes, view: View) -> None:
    """Power loss through time; that of a rebound, which has a tooth for every cell, pale behind its mean."""
    values = view.dataset["power_loss"].values
    top = max(view.largest("power_loss", lambda each: float(each.dataset["power_loss"].max())), 1e-9)
    z = replace(view.scale("power_loss", top), symbol="")
    mean = _without_teeth(view, values)
    lines: list[tuple[Values, Look]] = [(values, (z.long_name, BLUE, "-"))]
    if mean is not None:
        lines = [(values, ("teeth of the grid", PALE_BLUE, "-")), (mean, ("mean over a cell", BLUE, "-"))]
    _draw_series(axes, view, lines, z.factor)
    if mean is not None:
        axes.legend(loc="upper right", edgecolor="none", fontsize="small")
    axes.set(ylabel=z.label, ylim=(0.0, 1.2 * top * z.factor), title="Power loss")


def _without_teeth(view: View, power: Values) -> Values | None:
    """The power loss of an impact, in the rebound its mean over the time in which the front passes a cell.

    None where there is no rebound.
    """
    data, T = view.dataset, view.dataset["time"].values
    turn = events_of(data).get("max-approach")
    late = T > (np.inf if turn is None else float(data["frame"][turn]))
    front = float(fronts.distance_of_minimum(data)[late].max(initial=0.0))
    if data.attrs["kind"] != "impact" or late.sum() < 3 or not front:
        return None
    begin, x = float(T[late][0]), data["r" if view.is_radial else "X"].values
    half = 0.5 * (T[-1] - begin) * float(x[1] - x[0]) / front
    lost = _integral(power, T)
    before, after = np.maximum(T - half, begin), np.minimum(T + half, T[-1])
    with np.errstate(invalid="ignore", divide="ignore"):  # before the rebound
        mean = (np.interp(after, T, lost) - np.interp(before, T, lost)) / (after - before)
    return np.where(late, mean, power)


# -- the grids of a steady contact ------------------------------------------------------------------------------------


def draw_convergence(axes: Axes, view: View) -> None:
    """Maximum residual against the Newton iterations, on every grid of a steady contact."""
    histories, names = view.dataset["history"].values, _grid_names(view)
    shades = ORDERED_COLOURS(np.linspace(0.9, 0.0, len(names)))
    for name, colour, history in zip(names, shades, histories, strict=True):
        residuals = history[np.isfinite(history)]
        axes.semilogy(np.arange(len(residuals)), residuals, "o-", color=colour, markersize=3.5, label=name)
    axes.axhline(view.case.solver.tolerance, color="black", linewidth=0.8, linestyle=":", label="tolerance")
    axes.set(xlabel="Newton iteration", ylabel="maximum residual", title="Convergence on each grid")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.yaxis.set_major_locator(LogLocator(numticks=8))
    axes.legend(loc="best", frameon=False, fontsize="small", title="nodes", title_fontsize="small")


def draw_grids(axes: Axes, view: View) -> None:
    """Films of a steady contact on every grid with their estimated errors, and extrapolated to zero spacing."""
    names = _grid_names(view)
    z, place, top = view.scale("H_c", float(view.dataset["H_c"].values[-1])), np.arange(len(names) + 1), 0.0
    for name, colour, marker in (("H_c", BLUE, "o"), ("H_min", ORANGE, "s")):
        shown, errors, (*_, limit) = z.factor * np.transpose(view.on_grids(name))
        axes.errorbar(
            place[:-1], shown, errors, color=colour, marker=marker, markersize=4.0, capsize=4.0, label=view.legend(name)
        )
        axes.plot(place[-1:], [limit], marker, color=colour, markerfacecolor="white")
        axes.axhline(limit, color=colour, linewidth=0.8, linestyle="--")
        top = max(top, float(np.nanmax([*shown, limit])))
    axes.set_xticks(place, [*names, "∞"])
    axes.set(xlabel="nodes (∞: extrapolated)", ylabel=f"film thickness ({z.unit})", ylim=(0.0, 1.4 * top))
    axes.set_title("Film on each grid with its error estimate")
    axes.legend(loc="upper left", frameon=False, fontsize="small")


def _grid_names(view: View) -> list[str]:
    """The nodes of every grid: 65², or 65 x 97; 65 of a line contact."""
    grids = [int(nodes) for nodes in view.dataset["grid"].values]
    if view.geometry.is_line:
        return [str(nodes) for nodes in grids]
    X, Y = view.dataset.sizes["X"], view.dataset.sizes["Y"]
    return [f"{n}²" if X == Y else f"{n} x {round((n - 1) * (Y - 1) / (X - 1)) + 1}" for n in grids]
