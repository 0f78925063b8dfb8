"""Film and pressure under the pointer on the maps of a picture.

The process that draws makes a `Readout` beside the picture; the process of the app then answers at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ertel.results.variables import unit_of, with_prefix

if TYPE_CHECKING:  # imported in the process that draws
    from matplotlib.figure import Figure

    from ertel.plots.view import View

MOST_NODES = 128  # along a side of a map
NAMES = {"x": "X", "y": "X", "h": "H", "p": "P"}  # the variables that have their units


@dataclass(frozen=True)
class Readout:
    """Film and pressure on a regular grid, and the maps of a picture that show them.

    boxes: left, right, lower and upper edge of each map, in shares of the picture, then as x and y.  is_turned: x is
    downwards, y to the right.  x, y: of the nodes.  fields: film and pressure, (y, x).  units: of x, y, film, pressure,
    by their symbols; in SI all values are in SI.
    """

    boxes: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]]
    is_turned: bool
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    fields: Sequence[NDArray[np.float32]]
    units: dict[str, str]
    in_si: bool

    def at(self, across: float, down: float) -> str:
        """Position, film and pressure at a place of the picture, in shares of its sides; empty beside the maps."""
        for (left, right, low, high), edges in self.boxes:
            share, up = (across - left) / (right - left), (1.0 - down - low) / (high - low)
            if 0.0 <= share <= 1.0 and 0.0 <= up <= 1.0:
                place = edges[0] + share * (edges[1] - edges[0]), edges[2] + up * (edges[3] - edges[2])
                x, y = place[::-1] if self.is_turned else place
                return self._text(x, y, *(self._between_nodes(field, x, y) for field in self.fields))
        return ""

    def _between_nodes(self, field: NDArray[np.float32], x: float, y: float) -> float:
        row = int(np.clip(np.searchsorted(self.y, y), 1, len(self.y) - 1))
        along_x = [np.interp(x, self.x, each) for each in field[row - 1 : row + 1]]
        return float(np.interp(y, self.y[row - 1 : row + 1], along_x))

    def _text(self, *values: float) -> str:
        named = zip(self.units.items(), values, strict=True)
        if self.in_si:
            return ",  ".join(f"{symbol} = {with_prefix(value, unit)}" for (symbol, unit), value in named)
        return ",  ".join(f"{symbol.upper()} = {value:.3g} {unit}" for (symbol, unit), value in named)


def readout_of(figure: "Figure", view: "View") -> Readout | None:
    """The readout of a figure that is drawn; None where it has no maps over the surface."""
    maps = [axes for axes in figure.axes if axes.get_aspect() != "auto" and axes.get_label() != "<colorbar>"]
    if not maps:
        return None
    about = {symbol: view.variable(name).attrs for symbol, name in NAMES.items()}
    one = {symbol: each.get("si_factor", 1.0) for symbol, each in about.items()}
    boxes = [axes.get_position().get_points().T.ravel() for axes in maps]
    edges = [np.array([*axes.get_xlim(), *axes.get_ylim()]) / view.across.factor for axes in maps]
    sides = dict(zip("YX" if view.is_turned else "XY", np.abs(edges).reshape(-1, 2, 2).max(axis=(0, 2)), strict=True))
    fields = [view.map(name).sel({axis: slice(-side, side) for axis, side in sides.items()}) for name in ("H", "P")]
    every = {axis: slice(None, None, -(-nodes // MOST_NODES)) for axis, nodes in fields[0].sizes.items()}
    film, pressure = (each.isel(every) for each in fields)
    kind = view.dataset.attrs["kind"]
    units = {symbol: each.get("si_units") or unit_of(kind, each["in_units_of"]) for symbol, each in about.items()}
    return Readout(
        [(box, edge * one["x"]) for box, edge in zip(boxes, edges, strict=True)],
        view.is_turned,
        film["X"].values * one["x"],
        film["Y"].values * one["x"],
        [(each.values * one[symbol]).astype(np.float32) for symbol, each in (("h", film), ("p", pressure))],
        units,
        view.in_si,
    )
