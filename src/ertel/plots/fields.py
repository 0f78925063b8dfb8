"""Panels of film thickness, pressure and friction: as maps over the surface, and as profiles along the mid-line."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ertel.plots.drawing import BLUE, FLAT, GREY, ORANGE, ORDERED_COLOURS, PURPLE, NoFigure, Scale, Values
from ertel.plots.measurements import draw_measured
from ertel.plots.view import LOADED, View
from ertel.results.alignment import NOT_FULL
from ertel.results.profiles import events_of

# of a flow along x, and against it; the same in maps that are turned
ARROWS = ("\N{RIGHTWARDS ARROW}\N{LEFTWARDS ARROW}", "\N{DOWNWARDS ARROW}\N{UPWARDS ARROW}")
MINUS = "\N{MINUS SIGN}"
FLATTEST = 0.15  # height over width of a map that has equal scales along both sides
LEAST_ENLARGED = 1.2  # below it a flat map stays as it is
SEEN = 0.1  # of the largest power loss: less does not count where a map ends
NODES = 301  # along the side of a map, for smooth contour lines of the roughness
STYLES: Mapping[float, Literal["-", ":"]] = {1.0: "-", -1.0: ":"}  # of the lines round hills and round valleys
BAND = 0.14  # height of the roughness at the bottom of a profile, as a share of what lies above
FOOT = BAND / (1.0 + BAND)  # the same as a share of all
BAND_NODES = 1001  # along the roughness
MOST_PROFILES = 14  # about so many lines through time


# -- over the surface -------------------------------------------------------------------------------------------------


def levels(top: float, steps: int = 10) -> Values:
    """Equal steps of a round number from zero to `top` or a little above."""
    return np.asarray(MaxNLocator(steps).tick_values(0.0, top))


def draw_film_map(axes: Axes, view: View) -> None:
    """Film thickness, with contour lines at equal steps as an interferometer shows them, and the edge of the oil."""
    top = view.limits.top if view.limits else view.largest("H", _top_of_film)
    is_steady = all(each.frame is None for each in (view, view.beside) if each)
    z, film = view.scale("H", top / 2), view.map("H")
    _draw_map(axes, view, film, z, levels(top * z.factor, 16 if is_steady else 10), "YlGnBu_r")
    gap = (film, view.map("void"))
    draw_edge_of_oil(axes, view, *((each.T for each in gap) if view.is_turned else gap))
    draw_legend(axes, _draw_roughness(axes, view), view.is_turned)


def _top_of_film(view: View) -> float:
    """The film up to which a map has colours."""
    return 1.75 * float(view.dataset["H_c"].values[-1]) if view.frame is None else 1.5 * view.film_inside()


def draw_pressure_map(axes: Axes, view: View) -> None:
    """Pressure, with contour lines at equal steps."""
    top = view.limits.top if view.limits else view.largest("P")
    z = view.scale("P", max(top, 0.01))  # p_h*: something to divide if unloaded
    _draw_map(axes, view, view.map("P"), z, levels(max(top, 0.01) * z.factor), "YlOrRd")
    draw_legend(axes, _draw_roughness(axes, view), view.is_turned)


def draw_asperity_map(axes: Axes, view: View) -> None:
    """Pressure of asperities that touch, with contour lines at equal steps."""
    if "P_asperity" not in view.dataset:
        raise NoFigure("asperities: none touch in this run; give surfaces.asperities")
    top = max(view.largest("P_asperity"), 1e-6)  # something to divide where none touch yet
    z = view.scale("P_asperity", top)
    _draw_map(axes, view, view.map("P_asperity"), z, levels(top * z.factor), "OrRd")


def draw_oil_map(axes: Axes, view: View) -> None:
    """The part of the gap that is filled with oil; the rest is void."""
    z = Scale(1.0, r"$h_\mathrm{oil}/h$", "", "oil in the gap")
    _draw_map(axes, view, view.map("oil") / view.map("H"), z, levels(1.0), "Blues")


def draw_stress_map(axes: Axes, view: View) -> None:
    """Size of the shear stress in the middle of the film, with contour lines at equal steps."""
    field = xr.apply_ufunc(np.hypot, view.map("tau_x"), view.map("tau_y"))
    largest = view.largest("tau_x", lambda each: float(np.hypot(each.values("tau_x"), each.values("tau_y")).max()))
    top = max(largest, 1e-9)  # something to divide where there is no friction
    z = replace(view.scale("tau_x", top), symbol=r"$\tau_\mathrm{m}$", long_name="shear stress")
    _draw_map(axes, view, field, z, levels(top * z.factor), "BuPu", "loss")


def draw_loss_map(axes: Axes, view: View) -> None:
    """Power loss per area, with contour lines at equal steps."""
    top = max(view.largest("loss"), 1e-9)
    z = replace(view.scale("loss", top), symbol="")
    _draw_map(axes, view, view.map("loss"), z, levels(top * z.factor), "YlOrBr", "loss")


def _draw_map(
    axes: Axes, view: View, field: xr.DataArray, z: Scale, steps: Values, colours: str, shown_where: str = "P"
) -> None:
    """Draw a field with contour lines at `steps` (as shown), and the direction of the flow.

    Along x the map ends where `shown_where`, "P" or "loss", does; along y it reaches as far as suits the shape of the
    contact.  That of a contact that is long along y is turned by a quarter; a very flat map is enlarged across, and its
    axis says so.  Values above the highest step have its colour.  In a movie the colour bar of the first map stays.
    """
    side = view.limits.side if view.limits else view.largest("X", partial(_side, name=shown_where))
    top = side * view.stretch
    cut = field.sel(X=slice(-side, side), Y=slice(-top, top)) * z.factor
    cut = cut.T if view.is_turned else cut
    y, x = (cut[name].values * view.across.factor for name in cut.dims)
    shown = cut.values
    half_x, half_y = (x[1] - x[0]) / 2, (y[1] - y[0]) / 2
    edges = (x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y)  # of the cells around the nodes
    image = axes.imshow(shown, colours, vmin=0, vmax=steps[-1], extent=edges, origin="lower", interpolation="bilinear")
    axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    if shown.min() < steps[-1] and shown.max() > steps[1]:
        axes.contour(x, y, shown, levels=steps[1:], colors="black", linewidths=0.4, alpha=0.6)
    wide, tall = (view.axis_label(axis) for axis in ("yx" if view.is_turned else "xy"))
    shape = axes.get_data_ratio()
    enlarged = FLATTEST / shape if shape < FLATTEST / LEAST_ENLARGED else 1.0
    axes.set(xlabel=wide, ylabel=f"{tall},\n{enlarged:.2g} x enlarged" if enlarged > 1.0 else tall, aspect=enlarged)
    if shape < FLAT:
        axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    if view.is_turned:
        axes.invert_yaxis()
    extend = "max" if view.limits or shown.max() > steps[-1] else "neither"
    place = "bottom" if shape < FLAT else "right"
    if view.limits is None or len(axes.figure.axes) == 1:
        axes.figure.colorbar(image, ax=axes, label=z.label, extend=extend, location=place)
    heading = z.long_name.removesuffix(" per area").capitalize()
    axes.set_title(f"{heading}, a line every {steps[1]:.3g} {z.unit}")
    if flow := flow_in(view):
        axes.text(0.02, 0.97, flow, transform=axes.transAxes, va="top", fontsize="small")


def flow_in(view: View) -> str:
    """The direction of the flow in a map, "" without one."""
    return f"flow {ARROWS[view.is_turned][int(view.flow < 0)]}" if view.flow else ""


def _side(view: View, name: str) -> float:
    """The distance from the centre up to which a map is shown along x."""
    profile = view.map(name).max("Y")
    if name == "loss":
        profile = profile.where(profile > SEEN * profile.max(), 0.0)
    return view.extent(profile["X"].values, profile.values)


def _draw_roughness(axes: Axes, view: View) -> list[Line2D]:
    """Draw lines at half the height of the roughness, solid round hills and dotted round valleys; none if smooth.

    Returns the lines for the legend.
    """
    across = view.across.factor
    x, y = np.linspace(*axes.get_xlim(), NODES), np.linspace(*axes.get_ylim(), NODES)
    places = (x[None, :] / across, y[:, None] / across)
    height = view.roughness(*(places[::-1] if view.is_turned else places))
    half = float(np.abs(height).max()) / 2
    z, lines = view.scale("H", half), []
    for sign, style in STYLES.items():
        if (sign * height).max() > half:
            axes.contour(x, y, height, levels=[sign * half], colors=PURPLE, linewidths=1.0, linestyles=style)
            label = f"roughness {sign * half * z.factor:+.3g} {z.unit}".replace("-", MINUS)
            lines.append(Line2D([], [], color=PURPLE, linewidth=1.0, linestyle=style, label=label))
    return lines


def draw_edge_of_oil(axes: Axes, view: View, film: xr.DataArray, void: xr.DataArray) -> None:
    """Draw a line where the gap stops being full, with its name.

    Nothing where all or nothing is full.  film, void: the gap and the part of it without oil, over the same places.
    """
    missing = void - NOT_FULL * film
    y, x = (missing[name].values * view.across.factor for name in missing.dims)
    (left, right), (low, high) = axes.get_xlim(), sorted(axes.get_ylim())
    columns, rows = (left <= x) & (x <= right), (low <= y) & (y <= high)
    seen = missing.values[np.ix_(rows, columns)]
    if seen.min() < 0.0 < seen.max():
        edge = axes.contour(x[columns], y[rows], seen, levels=[0.0], colors=ORANGE, linewidths=1.0)
        if view.case.layer is not None:
            axes.clabel(edge, fmt="edge of the full film", fontsize="small")
        else:
            side, along = (0.02, "left") if view.flow < 0 else (0.98, "right")
            axes.text(side, 0.03, "cavity", transform=axes.transAxes, ha=along, fontsize="small", color=ORANGE)


def draw_legend(axes: Axes, lines: Sequence[Line2D], is_turned: bool = False) -> None:
    """Name the lines of a map in its corner; of one that is turned, at the inlet."""
    if lines:
        place: Literal["upper right", "lower left"] = "upper right" if is_turned else "lower left"
        axes.legend(handles=lines, loc=place, fontsize="small", framealpha=0.85, handlelength=1.5)


# -- a run in time ----------------------------------------------------------------------------------------------------


def draw_film_profiles(axes: Axes, view: View) -> None:
    """Film along the mid-line through time, the chosen moment in black."""
    top = view.largest("H", lambda each: 2.0 * each.film_inside())
    rough = _draw_profiles(axes, view, "H", view.scale("H", top / 2), top)
    _draw_oil_below(axes, view, view.scale("H", top / 2))
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, FOOT if rough else 0.0), edgecolor="none", fontsize="small")


def draw_pressure_profiles(axes: Axes, view: View) -> None:
    """Pressure along the mid-line through time, the chosen moment in black."""
    top = view.largest("P", lambda each: float(each.midlines("P").max()))
    _draw_profiles(axes, view, "P", view.scale("P", top), 1.35 * top)
    if view.geometry.is_line:
        dry = view.geometry.dry_pressure(view.value("F"), view.x, 0.0) * view.scale("P", top).factor
        axes.plot(view.x * view.across.factor, dry, color=GREY, linewidth=1.5, linestyle=":", label="dry contact")
    axes.legend(loc="upper center", frameon=False, fontsize="small")


def _draw_profiles(axes: Axes, view: View, name: str, z: Scale, top: float) -> bool:
    """Draw lines of the maps that carry load, coloured by time and dashed in the rebound, and the roughness below.

    With what is measured.  Returns whether there is any roughness.
    """
    values = view.midlines(name) * z.factor
    T, x, loaded = view.dataset["frame"].values, view.x * view.across.factor, _loaded(view)
    time = view.scale("time")
    shown = loaded[:: max(1, round(len(loaded) / MOST_PROFILES))]
    first = -view.largest("time", lambda each: -_since_zero(each, 0))
    end = view.largest("time", lambda each: _since_zero(each, -1))
    colours = ScalarMappable(Normalize(first * time.factor, end * time.factor), ORDERED_COLOURS)
    last = events_of(view.dataset).get("max-approach", len(T)) + 1  # a run until then may have one map after it
    for frame in shown[shown != view.frame]:
        style, width = ("--", 0.8) if frame > last else ("-", 1.2)
        colour = colours.to_rgba(time.shown(T[frame]))
        axes.plot(x, values[frame], color=colour, linestyle=style, linewidth=width)
    axes.plot(x, values[view.frame], color="black", linewidth=2.0, label=view.moment)
    if shown[-1] > last:
        axes.plot([], [], color=GREY, linestyle="--", linewidth=0.8, label="rebound")
    rough = _draw_roughness_below(axes, view, view.x, top * z.factor)
    draw_measured(axes, view, name, z)
    side = view.extent(view.x, view.midline("P")) * view.across.factor
    axes.set(xlim=(-side, min(side, x[-1])), xlabel=view.axis_label("x"), ylabel=z.label)
    axes.figure.colorbar(colours, ax=axes, label=time.label)
    return rough


def draw_along_x(axes: Axes, view: View, name: str) -> None:
    """Shear stress or power loss of a line contact, along x."""
    z = view.scale(name, max(view.largest(name, lambda each: float(np.abs(each.values(name)).max())), 1e-9))
    axes.plot(view.x * view.across.factor, view.values(name) * z.factor, color=BLUE)
    axes.axhline(0.0, color="black", linewidth=0.5)
    side = view.largest("X", lambda each: each.extent(each.x, np.abs(each.values(name)))) * view.across.factor
    words = z.long_name.partition(" in ")[0]
    axes.set(xlabel=view.axis_label("x"), ylabel=f"{words} {z.in_brackets}", title=words.capitalize())
    axes.set_xlim(max(-side, view.x[0] * view.across.factor), min(side, view.x[-1] * view.across.factor))


def _draw_oil_below(axes: Axes, view: View, z: Scale) -> None:
    """Fill the part of the gap of a line contact that has oil, where it is not full; a map shows its edge."""
    if view.geometry.is_line and np.any(view.values("void")):
        x, oil = view.x * view.across.factor, view.values("oil") * z.factor
        axes.fill_between(x, oil, color=BLUE, alpha=0.2, linewidth=0.0, label="oil in the gap")


def _since_zero(view: View, number: int) -> float:
    """The time of one of the maps that carry load, in t0 from t = 0."""
    return float(view.dataset["frame"].values[_loaded(view)[number]]) - view.scale("time").zero


def _loaded(view: View) -> NDArray[np.intp]:
    """The maps that carry load."""
    P = view.midlines("P")
    return np.flatnonzero(P.max(axis=1) >= LOADED * P.max())


# -- a steady contact -------------------------------------------------------------------------------------------------


def draw_section(axes: Axes, view: View, along: str) -> None:
    """Film and pressure of a steady contact through the centre along "x", the flow, or "y", with the Hertz pressure."""
    middle = {} if view.geometry.is_line else {"Y" if along == "x" else "X": 0.0}
    section = view.dataset[[name for name in ("H", "P", "P_asperity") if name in view.dataset]]
    section = section.sel(middle, method="nearest")
    x, H, P = (np.asarray(section[name].values) for name in (along.upper(), "H", "P"))
    central, across = float(view.dataset["H_c"].values[-1]), view.across.factor
    geometry, load = view.geometry, float(view.dataset["load"].values[-1])
    dry = geometry.dry_pressure(load / geometry.hertz_load, *((x, 0 * x) if along == "x" else (0 * x, x)))
    h = view.scale("H", view.largest("H", lambda each: float(each.dataset["H_c"].values[-1])))
    p = view.scale("P", view.largest("P"))
    right = axes.twinx()
    right.plot(x * across, dry * p.factor, color=GREY, linewidth=0.8, linestyle="--")
    right.plot(x * across, P * p.factor, color=ORANGE)
    if "P_asperity" in section:
        carried = section["P_asperity"].values * p.factor
        right.fill_between(x * across, carried, color=ORANGE, alpha=0.25, linewidth=0.0, label="of asperities")
    axes.plot(x * across, H * h.factor, color=BLUE)
    _draw_oil_below(axes, view, h)
    draw_measured(axes, view, "H", h, along)
    draw_measured(right, view, "P", p, along, ORANGE)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", fontsize="small", framealpha=0.85)
    if right.get_legend_handles_labels()[0]:
        right.legend(loc="upper right", fontsize="small", framealpha=0.85)
    widest = np.atleast_2d(view.values("P")).max(axis=0)
    side = view.extent(view.x, widest) * (1.0 if along == "x" else view.stretch) * across
    axes.set(xlim=(-side, min(side, x[-1] * across)), xlabel=view.axis_label(along))
    axes.set_title(f"Through the centre, {'along' if along == 'x' else 'across'} the flow (dashed: Hertz)")
    rough = _draw_roughness_below(axes, view, x, 4.0 * central * h.factor, along)
    _set_height(right, 1.1 * max(float(P.max()), float(dry.max())) * p.factor, rough)
    for scaled, z, colour in ((axes, h, BLUE), (right, p, ORANGE)):
        scaled.set_ylabel(z.label, color=colour)
        scaled.tick_params(axis="y", colors=colour)
    axes.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 5, 10]))


# -- roughness below a profile ----------------------------------------------------------------------------------------


def _draw_roughness_below(axes: Axes, view: View, x: Values, top: float, along: str = "x") -> bool:
    """Show the roughness through the centre below a profile that reaches up to `top`; whether there is any.

    x: the positions of the profile (a*) along "x" or "y".  The heights fill a band below zero, with their range.
    """
    place = np.linspace(x[0], x[-1], BAND_NODES)
    zero = np.zeros_like(place)
    height = view.roughness(*((place, zero) if along == "x" else (zero, place)))
    low, high = float(height.min()), float(height.max())
    rough = low < 0.0 or high > 0.0
    _set_height(axes, top, rough)
    if not rough:
        return False
    share = (height - low) / (high - low) if high > low else np.ones_like(height)
    shown = FOOT * (0.1 + 0.85 * share)  # in shares of the height of the axes
    where = axes.get_xaxis_transform()
    axes.fill_between(place * view.across.factor, 0.0, shown, transform=where, color=PURPLE, alpha=0.4, linewidth=0.0)
    z = view.scale("H", max(abs(low), abs(high)))
    bounds = [f"{round(bound * z.factor, 4):.3g}".replace("-", MINUS) for bound in sorted({low, high})]
    text = f"roughness {' to '.join(bounds)} {z.unit}"
    axes.text(0.5, FOOT / 2, text, transform=axes.transAxes, fontsize="small", ha="center", va="center")
    axes.axhline(0.0, color="black", linewidth=0.5)
    return True


def _set_height(axes: Axes, top: float, rough: bool) -> None:
    """Limit a profile to zero and `top`, with room below for the roughness where there is any."""
    axes.set_ylim(0.0, top or 1.0)
    if rough:
        axes.set_yticks([tick for tick in axes.get_yticks() if 0.0 <= tick <= top])
        axes.set_ylim(-BAND * top, top)
