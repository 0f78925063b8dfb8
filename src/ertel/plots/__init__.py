"""Pictures of a run: Dataset to matplotlib Figure.  Nothing is shown, nothing is saved.

    ertel.plots.overview(result.dataset, at="max-approach").savefig("impact.png")

`interferogram` shows any run in SI as an experimenter sees it, `animation` a run in time.

A run in time has overview, film, pressure, maps, profiles, history and friction, and an impact front; a steady contact
overview, film, pressure, maps, midlines, convergence and friction.  `at` chooses the moment of a run in time: a time in
t0 (the map next to it is drawn) or an event, "max-approach" or "end"; by default maximum approach, or the last map
where there is none.

Every function raises `NoFigure`, a ValueError, where there is nothing to draw yet, and for a figure or a moment that
the run has not.
"""

import xarray as xr
from matplotlib.figure import Figure

from ertel.plots import steady, transient
from ertel.plots.drawing import BLUE, GREEN, GREY, ORANGE, ORDERED_COLOURS, At, Draw, Figures, NoFigure
from ertel.plots.interferograms import animation, interferogram
from ertel.results.variables import is_steady

__all__ = [
    "BLUE",
    "GREEN",
    "GREY",
    "NAMES",
    "ORANGE",
    "ORDERED_COLOURS",
    "NoFigure",
    "animation",
    "convergence",
    "figure_of",
    "figures_of",
    "film",
    "friction",
    "front",
    "history",
    "interferogram",
    "maps",
    "midlines",
    "overview",
    "pressure",
    "profiles",
]


NAMES = tuple(
    dict.fromkeys((*transient.FIGURES, *transient.MORE_FIGURES, *steady.STEADY_FIGURES, *steady.MORE_STEADY_FIGURES))
)


def figures_of(dataset: xr.Dataset) -> Figures:
    """The figures that show all of a run, by name: functions of the Dataset and of `at`."""
    return steady.STEADY_FIGURES if is_steady(dataset) else transient.FIGURES


def figure_of(dataset: xr.Dataset, name: str) -> Draw:
    """One figure by its name, also one that shows a part of another: a function of the Dataset and of `at`."""
    more = steady.MORE_STEADY_FIGURES if is_steady(dataset) else transient.MORE_FIGURES
    known = {**figures_of(dataset), **more}
    if name not in known:
        run = "a steady contact" if is_steady(dataset) else "a run in time"
        raise NoFigure(f"{name}: {run} has no such figure; it has {', '.join(known)}")
    return known[name]


def _draw(name: str, dataset: xr.Dataset, at: At) -> Figure:
    return figure_of(dataset, name)(dataset, at)


def overview(dataset: xr.Dataset, at: At = None) -> Figure:
    """The run on one page."""
    return _draw("overview", dataset, at)


def film(dataset: xr.Dataset, at: At = None) -> Figure:
    """Film thickness over the surface, with contour lines at equal steps as an interferometer shows them."""
    return _draw("film", dataset, at)


def pressure(dataset: xr.Dataset, at: At = None) -> Figure:
    """Pressure over the surface, with contour lines at equal steps."""
    return _draw("pressure", dataset, at)


def maps(dataset: xr.Dataset, at: At = None) -> Figure:
    """Film thickness and pressure over the surface."""
    return _draw("maps", dataset, at)


def profiles(dataset: xr.Dataset, at: At = None) -> Figure:
    """Film thickness and pressure along the mid-line of a run in time, the moment `at` in black."""
    return _draw("profiles", dataset, at)


def history(dataset: xr.Dataset, at: At = None) -> Figure:
    """Motion, film thickness, pressure and the place of the minimum film thickness of a run in time."""
    return _draw("history", dataset, at)


def front(dataset: xr.Dataset, at: At = None) -> Figure:
    """The front of an impact, where the film is thinnest, through time: its place and its speed."""
    return _draw("front", dataset, at)


def midlines(dataset: xr.Dataset, at: At = None) -> Figure:
    """Film thickness and pressure through the centre of a steady contact, along the flow and across it."""
    return _draw("midlines", dataset, at)


def convergence(dataset: xr.Dataset, at: At = None) -> Figure:
    """Convergence of Newton's iteration on every grid of a steady contact, and the film thickness on every grid."""
    return _draw("convergence", dataset, at)


def friction(dataset: xr.Dataset, at: At = None) -> Figure:
    """Shear stress and power loss over the surface, of a run in time also the coefficients of friction through time.

    The shear stress is that in the middle of the film; it is left out where the surfaces do not slide.
    """
    return _draw("friction", dataset, at)
