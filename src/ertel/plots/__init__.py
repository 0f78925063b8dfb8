"""Pictures of a run: Dataset to matplotlib Figure.  Nothing is shown, nothing is saved.

    ertel.plots.overview(result.dataset, at="max-approach").savefig("impact.png")

`interferogram` shows any run in SI as an experimenter sees it, `animation` a run in time; `movie` shows the film or the
pressure of a run in time.

A run in time has overview, film, pressure, oil, maps, profiles, history, friction, spacetime and stress, and an impact
front; a steady contact overview, film, pressure, oil, maps, midlines, convergence, friction and stress, and with
[thermal] temperature. A line contact has no maps: film, pressure, oil, maps, interferograms and movies are refused.
`at` chooses the moment of a run in time: a time in t0, or with its unit, "95 us" (the map next to it is drawn, and the
title says its time), or an event, "max-approach" or "end"; by default maximum approach, of a rolling contact the
thinnest film where it is thinner than at both ends of the run, or else the last map.

`ax=` draws into axes of your own; `columns=1` or `columns=2` makes a figure of 85 or 170 mm for print,
`figsize=` one of another size; `title=False` leaves headings out; see `Sheet`.

Every function raises `NoFigure`, a ValueError, where there is nothing to draw yet, and for a figure or a moment that
the run does not have.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Unpack

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ertel.plots import drawing, fields, histories, stresses, temperatures
from ertel.plots.drawing import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    ORDERED_COLOURS,
    NoFigure,
    Sheet,
    SheetOptions,
    Values,
    compose,
)
from ertel.plots.interferograms import animation, interferogram, interferogram_of
from ertel.plots.measurements import Overlay, measured, measured_view
from ertel.plots.movies import movie
from ertel.plots.view import WIDEST, View, of_two
from ertel.results.figures import FIGURES_OF_MAPS, figures_of, is_line, is_steady
from ertel.results.profiles import At

__all__ = [
    "BLUE", "GREEN", "GREY", "NAMES", "ORANGE", "ORDERED_COLOURS", "NoFigure", "Sheet", "animation", "asperities",
    "comparison", "convergence", "draw", "film", "friction", "front", "history", "interferogram", "maps", "measured",
    "midlines", "movie", "names_of", "oil", "overview", "pressure", "profiles", "side_by_side", "spacetime", "stress",
    "temperature",
]  # fmt: skip

Rows = Sequence[Sequence[Callable[[Axes, View], None]]]
ALONG_THE_FLOW, ACROSS_THE_FLOW = (partial(fields.draw_section, along=axis) for axis in "xy")


def _friction_rows(view: View) -> Rows:
    """Shear stress where the surfaces slide, and power loss; coefficients of a run in time where something moves."""
    stress, loss = fields.draw_stress_map, fields.draw_loss_map
    if view.geometry.is_line:
        stress, loss = (partial(fields.draw_along_x, name=name) for name in ("tau_x", "loss"))
    over_the_surface = [stress, loss] if view.slides else [loss]
    if view.frame is None:
        return [over_the_surface]
    moves = view.slides or np.any(view.dataset["U"])
    through_time = [histories.draw_coefficients, histories.draw_power] if moves else [histories.draw_power]
    return [over_the_surface, through_time] if view.slides else [[*over_the_surface, *through_time]]


def _overview_rows(view: View) -> Rows:
    """Maps of film and pressure, their profiles, and how the run went; of a line contact the film through time."""
    if view.geometry.is_line and view.frame is None:
        return [[ALONG_THE_FLOW, histories.draw_grids, histories.draw_convergence]]
    if view.geometry.is_line:
        return [
            [fields.draw_film_profiles, histories.draw_film_through_time, histories.draw_film_history],
            [fields.draw_pressure_profiles, histories.draw_pressure_history, histories.draw_motion],
        ]
    touches = [fields.draw_asperity_map] if "P_asperity" in view.dataset else []  # in place of how it was computed
    if view.frame is None:
        return [
            [fields.draw_film_map, ALONG_THE_FLOW, histories.draw_grids],
            [fields.draw_pressure_map, ACROSS_THE_FLOW, *(touches or [histories.draw_convergence])],
        ]
    return [
        [fields.draw_film_map, fields.draw_film_profiles, histories.draw_film_history],
        [fields.draw_pressure_map, fields.draw_pressure_profiles, *(touches or [histories.draw_motion])],
    ]


PANELS: Mapping[str, Rows | Callable[[View], Rows]] = {  # of each figure
    "overview": _overview_rows,
    "film": [[fields.draw_film_map]],
    "pressure": [[fields.draw_pressure_map]],
    "asperities": [[fields.draw_asperity_map]],
    "oil": [[fields.draw_oil_map]],
    "maps": [[fields.draw_film_map, fields.draw_pressure_map]],
    "profiles": [[fields.draw_film_profiles, fields.draw_pressure_profiles]],
    "midlines": lambda view: [[ALONG_THE_FLOW, ACROSS_THE_FLOW][: 2 - view.geometry.is_line]],
    "history": [
        [histories.draw_motion, histories.draw_film_history],
        [histories.draw_place, histories.draw_pressure_history],
    ],
    "convergence": [[histories.draw_convergence, histories.draw_grids]],
    "friction": _friction_rows,
    "temperature": [[temperatures.draw_across, temperatures.draw_along]],
    "front": [[histories.draw_place, histories.draw_front_speed]],
    "spacetime": [[histories.draw_film_through_time]],
    "stress": stresses.rows,
}
ASKED = ("stress",)  # it is computed when it is drawn, and drawn when it is asked for
PARTS_IN_TIME = ("film", "pressure", "asperities", "oil", "front", "spacetime", *ASKED)  # of another figure
PARTS_STEADY = ("oil", "maps", *ASKED)
NAMES = tuple(PANELS)
LOOKS = ((BLUE, "-"), (ORANGE, "--"))  # of two runs
OVERLAID = ("profiles", "midlines")  # figures that show measured profiles


def names_of(dataset: xr.Dataset) -> tuple[str, ...]:
    """The names of the figures that together show all of a run."""
    parts = PARTS_STEADY if is_steady(dataset) else PARTS_IN_TIME
    return tuple(name for name in figures_of(dataset) if name not in parts)


def draw(
    dataset: xr.Dataset, name: str, at: At = None, measured: Overlay = None, **sheet: Unpack[SheetOptions]
) -> Figure:
    """One figure of a run by its name, one of `NAMES`.

    Parameters
    ----------
    dataset : xarray.Dataset
        A run.
    name : str
        The name of the figure.
    at : float, str or Quantity, optional
        The moment of a run in time: a time in t0 or with its unit, or an event.  Left out, that of what is measured.
    measured : Measurement or several of them, optional
        Measured profiles of film or pressure, drawn on those of the run.
    **sheet
        Axes or a size, and whether there is a title: ax, figsize, columns, title, see `Sheet`.

    Raises
    ------
    NoFigure
        The run does not have this figure or this moment, or there is nothing to draw yet.
    """
    _require(dataset, name)
    return _draw(measured_view(dataset, at, measured), name, Sheet(**sheet))


def _require(dataset: xr.Dataset, name: str) -> None:
    if name not in (found := figures_of(dataset)):
        run = "a steady contact" if is_steady(dataset) else "a run in time"
        run = "a line contact" if is_line(dataset.attrs) and name in FIGURES_OF_MAPS else run
        raise NoFigure(f"{name}: {run} has no such figure; it has {', '.join(found)}")


def _draw(view: View, name: str, sheet: Sheet) -> Figure:
    rows = PANELS[name]
    if view.measured and name not in OVERLAID:
        raise NoFigure(f"{name}: does not show what is measured; {' and '.join(OVERLAID)} do")
    across = [each.measurement.name for each in view.measured if each.measurement.along == "y"]
    if name == "profiles" and across and not view.is_radial:
        raise NoFigure(f"measured: {across[0]} is along y; {name} are along x")
    outcome = view.friction if name == "friction" and view.frame is None else view.outcome
    return compose(view, rows(view) if callable(rows) else rows, [*view.title, *outcome], sheet)


def side_by_side(
    runs: Sequence[xr.Dataset], name: str, at: Sequence[At] = (None, None), **sheet: Unpack[SheetOptions]
) -> list[Figure]:
    """The same figure of two runs, with the same units, colours and limits of axes.

    Parameters
    ----------
    runs : sequence of xarray.Dataset
        Two runs; they are drawn in SI where both have SI scales.
    name : str
        The name of the figure, one of `NAMES`, or "interferogram" in green light.
    at : sequence of float, str or Quantity
        The moments of runs in time.
    **sheet
        A size, and whether there is a title: figsize, columns, title, see `Sheet`.

    Raises
    ------
    NoFigure
        A run does not have this figure or this moment, or there is nothing to draw yet.
    """
    pair, size, is_optical = of_two(runs, at), Sheet(**sheet), name == "interferogram"
    for run in () if is_optical else runs:
        _require(run, name)
    figures = [interferogram_of(view, size) if is_optical else _draw(view, name, size) for view in pair]
    drawing.share_limits(figures)
    return figures


def comparison(
    runs: Sequence[xr.Dataset], names: Sequence[str], at: At = None, **sheet: Unpack[SheetOptions]
) -> Figure:
    """The film and pressure of two runs along the mid-line, and of two runs in time the minimum film through time.

    Parameters
    ----------
    runs : sequence of xarray.Dataset
        Two runs; they are drawn in SI where both have SI scales.
    names : sequence of str
        Their names, for the legend.
    at : float or str, optional
        The moment of runs in time, as for other pictures.
    **sheet
        Axes or a size: ax, figsize, columns, see `Sheet`.

    Raises
    ------
    NoFigure
        A run has no such moment or no map.
    """
    views = of_two(runs, (at, at))
    panels = [("X", "H"), ("X", "P")]
    if all(view.frame is not None for view in views):
        panels.append(("time", "H_min"))
    return compose(views, [[partial(_compare, names=names, x=x, y=y) for x, y in panels]], [], Sheet(**sheet))


def _compare(axes: Axes, views: tuple[View, View], names: Sequence[str], x: str, y: str) -> None:
    """Draw one variable of two runs over another."""
    scales = [view.scale(y, view.largest(y, lambda each: float(_curve(each, y).max()))) for view in views]
    for view, z, name, (colour, line) in zip(views, scales, names, LOOKS, strict=True):
        axes.plot(view.scale(x).shown(_curve(view, x)), _curve(view, y) * z.factor, line, color=colour, label=name)
    view, z = views[0], scales[0]
    axes.set(xlabel=view.scale(x).label, ylabel=z.label)
    if y == "H":  # far outside the film is much thicker than in the middle
        middle = view.largest("H", lambda each: float(np.interp(0.0, each.x, each.midline("H"))))
        axes.set_ylim(0.0, 3.0 * z.factor * middle)
        axes.legend(loc="upper center", frameon=False, fontsize="small")
    if x == "time":
        histories.limit_films(axes, [np.asarray(line.get_ydata()) for line in axes.lines])
    if x == "X":
        side = view.across.factor * view.largest("X", lambda each: min(WIDEST, float(np.abs(each.x).max())))
        axes.set(xlim=(-side, side), xlabel=view.axis_label("x"))


def _curve(view: View, name: str) -> Values:
    """A variable along the mid-line, or through time."""
    if name == "X":
        return view.x
    return view.midline(name) if name in ("H", "P") else np.asarray(view.dataset[name].values)


def overview(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """The run on one page."""
    return draw(dataset, "overview", at, **sheet)


def film(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """Film thickness over the surface, with contour lines at equal steps as an interferometer shows them."""
    return draw(dataset, "film", at, **sheet)


def pressure(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """Pressure over the surface, with contour lines at equal steps."""
    return draw(dataset, "pressure", at, **sheet)


def asperities(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """Pressure of asperities over the surface, where they touch."""
    return draw(dataset, "asperities", at, **sheet)


def oil(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """The part of the gap that is filled with oil; the rest is void, in a cavity or beside a thin layer of oil."""
    return draw(dataset, "oil", at, **sheet)


def maps(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """Film thickness and pressure over the surface."""
    return draw(dataset, "maps", at, **sheet)


def profiles(dataset: xr.Dataset, at: At = None, measured: Overlay = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """Film thickness and pressure along the mid-line of a run in time, the moment `at` in black."""
    return draw(dataset, "profiles", at, measured, **sheet)


def history(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """Motion, film thickness, pressure and the place of the minimum film thickness of a run in time."""
    return draw(dataset, "history", at, **sheet)


def front(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """The front of an impact, where the film is thinnest, through time: its place and its speed."""
    return draw(dataset, "front", at, **sheet)


def spacetime(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """Film thickness along the mid-line through time: waves that are frozen into the film, and where they go."""
    return draw(dataset, "spacetime", at, **sheet)


def midlines(dataset: xr.Dataset, at: At = None, measured: Overlay = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """Film thickness and pressure through the centre of a steady contact, along the flow and across it."""
    return draw(dataset, "midlines", at, measured, **sheet)


def convergence(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """Convergence of the Newton iteration on every grid of a steady contact, and the film thickness on every grid."""
    return draw(dataset, "convergence", at, **sheet)


def friction(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """Shear stress and power loss over the surface, of a run in time also the coefficients of friction through time.

    The shear stress is that in the middle of the film; it is left out where the surfaces do not slide.
    """
    return draw(dataset, "friction", at, **sheet)


def temperature(dataset: xr.Dataset, at: At = None, **sheet: Unpack[SheetOptions]) -> Figure:
    """The temperature across the film of a steady contact at y = 0, in the shape of the film, and of both surfaces."""
    return draw(dataset, "temperature", at, **sheet)


def stress(dataset: xr.Dataset, at: At = None, body: int = 1, **sheet: Unpack[SheetOptions]) -> Figure:
    """The von Mises stress below the surface of body 1 or 2 in the section y = 0, and the stresses over the depth."""
    _require(dataset, "stress")
    view = View.of(dataset, at)
    return compose(view, stresses.rows(view, body), [*view.title, *view.outcome], Sheet(**sheet))
