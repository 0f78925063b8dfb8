"""Pictures of a run in time, impact or rolling: Dataset to matplotlib Figure."""

from collections.abc import Mapping
from functools import partial
from typing import Protocol

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from ertel.plots.drawing import (
    GREY,
    LOADED,
    ORDERED_COLOURS,
    At,
    Figures,
    NoFigure,
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
    scale,
    side_of,
    title,
)
from ertel.plots.friction import draw_coefficients, draw_loss, draw_power, draw_stress, slides
from ertel.plots.histories import (
    draw_drive,
    draw_film_history,
    draw_front,
    draw_front_speed,
    draw_minimum_film,
    draw_motion,
    draw_pressure_history,
)
from ertel.plots.moments import Profiles, entrainment, heading, profiles_of
from ertel.plots.roughness import FOOT, draw_band, draw_contours


class MomentPanel(Protocol):
    """Draws a run in time at the moment that p has chosen."""

    def __call__(self, axes: Axes, dataset: xr.Dataset, p: Profiles) -> None: ...


MOTION: Mapping[str, MomentPanel] = {"impact": draw_motion, "rolling": draw_drive}
PLACE: Mapping[str, MomentPanel] = {"impact": draw_front, "rolling": draw_minimum_film}

# -- panels -----------------------------------------------------------------------------------------------------------


def draw_film_map(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Film thickness at the chosen moment, with contour lines at equal steps as an interferometer shows them."""
    P, H = p.P[p.chosen], p.H[p.chosen]
    top = 1.5 * film_inside(dataset, p.x, P, H)
    draw_film(axes, dataset, map_of(dataset, "H", p.chosen), side_of(dataset, p.chosen), top)
    draw_contours(axes, dataset, p.time)
    draw_flow(axes, entrainment(dataset, p.time))


def draw_pressure_map(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Pressure at the chosen moment, with contour lines at equal steps."""
    draw_pressure(axes, dataset, map_of(dataset, "P", p.chosen), side_of(dataset, p.chosen))
    draw_contours(axes, dataset, p.time)
    draw_flow(axes, entrainment(dataset, p.time))


def draw_stress_map(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Shear stress at the chosen moment, with contour lines at equal steps."""
    draw_stress(axes, dataset, p.chosen)
    draw_flow(axes, entrainment(dataset, p.time))


def draw_loss_map(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Power loss per area at the chosen moment, with contour lines at equal steps."""
    draw_loss(axes, dataset, p.chosen)
    draw_flow(axes, entrainment(dataset, p.time))


def draw_film_profiles(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Film along the mid-line through time, the chosen moment in black."""
    top = 2.0 * film_inside(dataset, p.x, p.P[p.chosen], p.H[p.chosen])
    z = scale(dataset, "H", top / 2)
    rough = _draw_profiles(axes, dataset, p, p.H * z.factor, top * z.factor)
    axes.set(ylabel=z.label)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, FOOT if rough else 0.0), edgecolor="none", fontsize="small")


def draw_pressure_profiles(axes: Axes, dataset: xr.Dataset, p: Profiles) -> None:
    """Pressure along the mid-line through time, the chosen moment in black."""
    z = scale(dataset, "P", float(p.P.max()))
    _draw_profiles(axes, dataset, p, p.P * z.factor, 1.25 * float(p.P.max()) * z.factor)
    axes.set(ylabel=z.label)
    axes.legend(loc="upper center", frameon=False, ncols=2, fontsize="small")


def _draw_profiles(axes: Axes, dataset: xr.Dataset, p: Profiles, values: Values, top: float) -> bool:
    """Lines of the maps that carry load, coloured by time and dashed in the rebound, the chosen moment in black, and
    the roughness below; whether there is any.
    """
    time, across = scale(dataset, "time", 1.0), lateral(dataset)
    loaded = np.flatnonzero(p.P.max(axis=1) > LOADED * p.P.max())
    shown = loaded[:: max(1, round(len(loaded) / 14))]
    colours = ScalarMappable(Normalize(p.T[loaded[0]] * time.factor, p.T[loaded[-1]] * time.factor), ORDERED_COLOURS)
    x = p.x * across.factor
    last = len(p.T) if p.turning is None else p.turning + 1  # a run until maximum approach may have a map after it
    for frame in shown[shown != p.chosen]:
        style, width = ("--", 0.8) if frame > last else ("-", 1.2)
        colour = colours.to_rgba(p.T[frame] * time.factor)
        axes.plot(x, values[frame], color=colour, linestyle=style, linewidth=width)
    axes.plot(x, values[p.chosen], color="black", linewidth=2.0, label=p.moment)
    if shown[-1] > last:
        axes.plot([], [], color=GREY, linestyle="--", linewidth=0.8, label="rebound")
    rough = draw_band(axes, dataset, p.time, p.x, top)
    side = extent(dataset, p.x, p.P[p.chosen]) * across.factor
    axes.set(xlim=(-side, min(side, x[-1])), xlabel=axis_label(dataset, "x"))
    figure_of(axes).colorbar(colours, ax=axes, label=time.label)
    return rough


# -- figures ----------------------------------------------------------------------------------------------------------


def film(dataset: xr.Dataset, at: At = None) -> Figure:
    """Film thickness over the surface."""
    return _of_run(dataset, [[draw_film_map]], at)


def pressure(dataset: xr.Dataset, at: At = None) -> Figure:
    """Pressure over the surface."""
    return _of_run(dataset, [[draw_pressure_map]], at)


def maps(dataset: xr.Dataset, at: At = None) -> Figure:
    """Film thickness and pressure over the surface."""
    return _of_run(dataset, [[draw_film_map, draw_pressure_map]], at)


def profiles(dataset: xr.Dataset, at: At = None) -> Figure:
    """Film thickness and pressure along the mid-line through time."""
    return _of_run(dataset, [[draw_film_profiles, draw_pressure_profiles]], at)


def history(dataset: xr.Dataset, at: At = None) -> Figure:
    """Motion of the bodies, film thickness, pressure and the place of the minimum film thickness through time."""
    kind = dataset.attrs["kind"]
    return _of_run(dataset, [[MOTION[kind], draw_film_history], [PLACE[kind], draw_pressure_history]], at)


def front(dataset: xr.Dataset, at: At = None) -> Figure:
    """The front of an impact through time: its place and its speed."""
    if dataset.attrs["kind"] != "impact":
        raise NoFigure("front: a rolling contact has none; it belongs to an impact")
    return _of_run(dataset, [[draw_front, draw_front_speed]], at)


def overview(dataset: xr.Dataset, at: At = None) -> Figure:
    """The run on one page: maps, profiles and histories."""
    motion = MOTION[dataset.attrs["kind"]]
    above: list[MomentPanel] = [draw_film_map, draw_film_profiles, draw_film_history]
    return _of_run(dataset, [above, [draw_pressure_map, draw_pressure_profiles, motion]], at)


def friction(dataset: xr.Dataset, at: At = None) -> Figure:
    """Shear stress, where the surfaces slide, and power loss over the surface; coefficients and power through time."""
    through_time: list[MomentPanel] = [draw_coefficients, draw_power] if np.any(dataset["U"]) else [draw_power]
    rows = [[draw_stress_map, draw_loss_map], through_time] if slides(dataset) else [[draw_loss_map, *through_time]]
    return _of_run(dataset, rows, at)


def _of_run(dataset: xr.Dataset, rows: list[list[MomentPanel]], at: At) -> Figure:
    dataset = dataset.load()
    p = profiles_of(dataset, at)
    panels: list[list[Panel]] = [[partial(draw, p=p) for draw in row] for row in rows]
    return compose(dataset, panels, [*title(dataset), *heading(dataset, p)])


FIGURES: Figures = {"overview": overview, "maps": maps, "profiles": profiles, "history": history, "friction": friction}
MORE_FIGURES: Figures = {"film": film, "pressure": pressure, "front": front}  # the first two: parts, for a notebook
