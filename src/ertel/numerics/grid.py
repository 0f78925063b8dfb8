"""A uniform node-centred grid on a rectangle, its coarser grids, and extrapolation from one to the next."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LARGEST_COARSEST = 17  # maximum nodes per side of the coarsest grid, which is solved directly
SMALLEST_COARSEST = 5
LARGEST_RECTANGLE = 4 * LARGEST_COARSEST**2  # maximum nodes of a rectangular coarsest grid, solved by a dense matrix
COARSE_ENOUGH = 9  # nodes per side; a coarser grid costs more compile time than it saves
LEAST = 0.02  # of a value whose order is not regular: its least error on the second grid; each finer one has half of it
FEW = 170  # a grid with at most this many stored nodes is solved by a dense matrix: one grid less to compile


class Symmetry(NamedTuple):
    """Whether fields are even in Y (rows) and in X (columns).  Even fields are stored for Y >= 0 or X >= 0 only."""

    y: bool = False
    x: bool = False


NO_SYMMETRY = Symmetry()


@dataclass(frozen=True)
class Grid:
    """A grid of nodes_x times nodes_y nodes around (centre_x, centre_y), each in a square cell of side `spacing`.

    Arrays on it have shape (nodes_y, nodes_x); one row is a line contact, in which nothing changes along Y.  If fields
    are even, only one side of the axis is stored (see `stencils`), and `shape` is smaller.  x and y always cover the
    whole plane.
    """

    nodes_x: int
    nodes_y: int
    spacing: float
    centre_x: float = 0.0
    centre_y: float = 0.0
    even: Symmetry = NO_SYMMETRY

    def __post_init__(self) -> None:
        if (self.even.y and self.centre_y) or (self.even.x and self.centre_x):
            raise ValueError(f"even = {self.even}: the grid must be centred on the axis of symmetry")

    @classmethod
    def square(cls, nodes: int, half_width: float) -> "Grid":
        """The grid over [-half_width, half_width]^2, with a node at the centre when `nodes` is odd."""
        return cls(nodes, nodes, 2.0 * half_width / (nodes - 1))

    @property
    def nodes(self) -> int:
        """Number of nodes along X; on a square grid also along Y."""
        return self.nodes_x

    @property
    def size(self) -> int:
        """Number of nodes of the whole plane."""
        return self.nodes_x * self.nodes_y

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of arrays on the grid: the stored part of (nodes_y, nodes_x)."""
        half_y, half_x = (self.nodes_y + 1) // 2, (self.nodes_x + 1) // 2
        return half_y if self.even.y else self.nodes_y, half_x if self.even.x else self.nodes_x

    @cached_property
    def kept_x(self) -> NDArray[np.float64]:
        """X of the columns of an array on the grid."""
        return self.x[self.nodes_x - self.shape[1] :]

    @cached_property
    def kept_y(self) -> NDArray[np.float64]:
        """Y of the rows of an array on the grid."""
        return self.y[self.nodes_y - self.shape[0] :]

    @cached_property
    def x(self) -> NDArray[np.float64]:
        """X of the nodes, shape (nodes_x,)."""
        return _axis(self.nodes_x, self.spacing, self.centre_x)

    @cached_property
    def y(self) -> NDArray[np.float64]:
        """Y of the nodes, shape (nodes_y,)."""
        return _axis(self.nodes_y, self.spacing, self.centre_y)

    @property
    def coordinates(self) -> dict[str, NDArray[np.float64]]:
        """The axes of a field on the whole plane in order, by name; of one row X alone."""
        return {"X": self.x} if self.nodes_y == 1 else {"Y": self.y, "X": self.x}

    def middle(self) -> "Grid":
        """The nodes in the middle of this grid: half as many cells a side, of the same size (`stencils.middle`)."""
        nodes_x, nodes_y = ((nodes - 1) // 2 + 1 for nodes in (self.nodes_x, self.nodes_y))
        return replace(self, nodes_x=nodes_x, nodes_y=nodes_y)

    def coarser(self) -> "Grid":
        """Every second node of this grid."""
        return replace(self.middle(), spacing=2.0 * self.spacing)

    def hierarchy(self) -> tuple["Grid", ...]:
        """This grid and its coarser grids, down to the coarsest useful one that has nodes on the axes of symmetry."""
        grids = [self]
        factor = 4 if any(self.even) else 2
        while (last := grids[-1]).shape[0] * last.shape[1] > FEW:
            coarser = last.coarser()
            odd = (last.nodes_x - 1) % factor or (last.nodes_y - 1) % factor
            if odd or min(coarser.nodes_x, coarser.nodes_y) < COARSE_ENOUGH:
                break
            grids.append(coarser)
        return tuple(grids)

    @property
    def halvings(self) -> int:
        """Number of times that every second node can be left out, down to a few; also of one row, without multigrid."""
        if self.nodes_y > 1:
            return len(self.hierarchy()) - 1
        cells, count = (self.nodes_x - 1) // (2 if any(self.even) else 1), 0
        while cells % 2 == 0 and cells >= 2 * (COARSE_ENOUGH - 1):
            cells, count = cells // 2, count + 1
        return count


def _axis(nodes: int, spacing: float, centre: float) -> NDArray[np.float64]:
    # coordinates are counted from the middle, so that a symmetric grid is symmetric to the last bit
    offsets = np.arange(nodes, dtype=np.float64) - (nodes - 1) / 2
    return np.asarray(centre + offsets * spacing, dtype=np.float64)


def is_allowed(nodes: int) -> bool:
    """Whether multigrid can coarsen a grid with this number of nodes in one direction."""
    odd = nodes >= SMALLEST_COARSEST and nodes % 2 == 1
    return odd and Grid(nodes, nodes, 1.0).hierarchy()[-1].nodes <= LARGEST_COARSEST


def allowed_nodes(at_least: float) -> int:
    """The smallest allowed number of nodes per side that is not below `at_least` (see `check_nodes`)."""
    nodes = max(ceil(at_least), SMALLEST_COARSEST)
    while not is_allowed(nodes):
        nodes += 1
    return nodes


def check_nodes(nodes: int) -> None:
    """Raise ValueError unless multigrid can coarsen a grid with this number of nodes in one direction."""
    if not is_allowed(nodes):
        allowed = sorted({c * 2**k + 1 for c in range(SMALLEST_COARSEST - 1, LARGEST_COARSEST) for k in range(12)})
        below = max((n for n in allowed if n <= nodes), default=allowed[0])
        above = min((n for n in allowed if n > nodes), default=allowed[-1])
        raise ValueError(
            f"nodes = {nodes}: must be 2^k c + 1 with a coarsest grid of {SMALLEST_COARSEST} to {LARGEST_COARSEST} "
            f"nodes a side, so that multigrid can coarsen it; the nearest are {below} and {above}"
        )


def nodes_across(nodes: int, ratio: float) -> int:
    """Nodes for a side that is `ratio` times as long as one with `nodes`, or a little longer; the spacing is the same.

    Multigrid can coarsen both sides equally often, down to a few nodes on the shorter one, and the middle is a node of
    every grid.
    """
    cells = nodes - 1
    needed = max(ratio * cells, COARSE_ENOUGH - 1)

    def units(unit: int) -> int:
        return ceil(needed / unit - 1e-6)

    def is_too_fine(unit: int) -> bool:
        """Whether the coarsest grid has too many nodes, with half a unit as its spacing."""
        long = min(cells, needed) / unit >= COARSE_ENOUGH - 1
        return long or (2 * cells / unit + 1) * (2 * units(unit) + 1) > LARGEST_RECTANGLE

    unit = 2
    while cells % (2 * unit) == 0 and is_too_fine(unit):
        unit *= 2
    return 1 + unit * units(unit)


def check_coarsening(grid: Grid) -> None:
    """Raise ValueError unless multigrid can coarsen the grid in both directions, and equally often.

    One row, which is solved directly, may have as many nodes as the side of a square.
    """
    check_nodes(grid.nodes_x)
    coarsest = grid.hierarchy()[-1]
    if grid.nodes_y > 1 and coarsest.size > LARGEST_RECTANGLE:
        raise ValueError(
            f"nodes = {grid.nodes_x} x {grid.nodes_y}: the coarsest grid that multigrid can make has "
            f"{coarsest.nodes_x} x {coarsest.nodes_y} nodes; must be {LARGEST_RECTANGLE} at most, so take 2^k + 1 "
            "nodes or sides less different"
        )


# -- Richardson extrapolation: the error estimate from two grids, for a second-order method ---------------------------


class Extrapolation(NamedTuple):
    """A value on the finest grid, an estimate of its error there, and the value extrapolated to zero spacing."""

    value: float
    error: float
    extrapolated: float


def extrapolate(coarse: float, fine: float, coarsest: float | None = None) -> Extrapolation:
    """Extrapolation from a grid and the grid with half its spacing; the error is proportional to spacing squared.

    coarsest: the value on a grid before: the error is at least what the change from it lets expect.
    """
    step, expected = (fine - coarse) / 3, 0.0 if coarsest is None else (coarse - coarsest) / 12
    return Extrapolation(fine, max(abs(step), abs(expected)), fine + step)


def on_grids(values: Sequence[float], regular: bool = True) -> list[Extrapolation]:
    """Values on grids, coarsest first and each with half the spacing, with their errors; the coarsest has none.

    From the third grid on the error is at least what the change of the grid before lets expect: two grids may agree by
    chance, a minimum over nodes among others.  regular: whether the order is; where not, it is at least `LEAST`, too.
    """
    found = [Extrapolation(values[0], nan, nan)]
    for k in range(1, len(values)):
        one = extrapolate(values[k - 1], values[k], values[k - 2] if k > 1 else None)
        least = 0.0 if regular else LEAST / 2 ** (k - 1) * abs(values[k])
        found.append(one._replace(error=max(one.error, least)))
    return found


def expected_next(values: Sequence[float]) -> float:
    """The expected value on the next finer grid, from the values so far (coarsest first): the change falls fourfold."""
    *earlier, last = values[-2:]
    return last + sum(last - e for e in earlier) / 4
