"""The kind of a run as its Dataset tells it, and the figures that it therefore has; `ertel.plots` draws them.

A steady contact has its grids in place of steps in time.  A line contact has no maps.  A run whose asperities touch has
their pressure, a steady one with [thermal] its temperatures.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

MADE_BY = "ertel, with Matplotlib"  # in the files of pictures and movies: who drew them
FIGURES_OF_MAPS = ("film", "pressure", "asperities", "oil", "maps")  # which a line contact does not have
FIGURES_IN_TIME = ("overview", *FIGURES_OF_MAPS, "profiles", "history", "friction", "front", "spacetime", "stress")
FIGURES_STEADY = ("overview", *FIGURES_OF_MAPS, "midlines", "convergence", "friction", "temperature", "stress")


def is_line(about: Mapping[str, Any]) -> bool:
    """Whether a run is one of a line contact.

    about: its summary, or the attributes of its Dataset; they have no radius_ratio of a circle.
    """
    return about.get("radius_ratio") == 0


def is_steady(dataset: "xr.Dataset") -> bool:
    """Return whether a Dataset holds a steady contact, on its grids, and not a run in time.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a run.

    Returns
    -------
    bool
        Whether it has the dimension `grid`.
    """
    return "grid" in dataset.dims


def figures_of(dataset: "xr.Dataset") -> tuple[str, ...]:
    """The names of the figures that a run has, see `ertel.plots`.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a run.

    Returns
    -------
    tuple of str
        In the order in which they are shown.
    """
    names = FIGURES_STEADY if is_steady(dataset) else FIGURES_IN_TIME
    needed = {"asperities": "P_asperity", "temperature": "T_across"}
    left_out = {name for name, variable in needed.items() if variable not in dataset}
    left_out |= set(FIGURES_OF_MAPS) if is_line(dataset.attrs) else set()
    return tuple(name for name in names if name not in left_out)
