"""The names of the figures that a run has; `ertel.plots` draws them."""

from typing import TYPE_CHECKING

from ertel.results.variables import is_line, is_steady

if TYPE_CHECKING:
    import xarray as xr

MADE_BY = "ertel, with Matplotlib"  # in the files of pictures and movies: who drew them
FIGURES_IN_TIME = (
    "overview", "film", "pressure", "asperities", "oil", "maps", "profiles", "history", "friction", "front",
    "spacetime", "stress",
)  # fmt: skip
FIGURES_STEADY = (
    "overview", "film", "pressure", "asperities", "oil", "maps", "midlines", "convergence", "friction", "stress",
)  # fmt: skip
FIGURES_OF_MAPS = ("film", "pressure", "asperities", "oil", "maps")  # which a line contact does not have


def figures_of(dataset: "xr.Dataset") -> tuple[str, ...]:
    """The names of the figures that a run has, see `ertel.plots`."""
    names = FIGURES_STEADY if is_steady(dataset) else FIGURES_IN_TIME
    left_out = {"asperities"} if "P_asperity" not in dataset else set()
    left_out |= set(FIGURES_OF_MAPS) if is_line(dataset.attrs) else set()
    return tuple(name for name in names if name not in left_out)
