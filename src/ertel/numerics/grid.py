"""A uniform node-centred grid on a rectangle, and its coarser companions."""

from dataclasses import dataclass, replace
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Even(NamedTuple):
    """Whether fields are even in Y (rows) and in X (columns), and so kept for Y >= 0, X >= 0 only."""

    y: bool = False
    x: bool = False


WHOLE = Even()


LARGEST_COARSEST = 17  # nodes per side that the direct solve on the coarsest grid is meant for
SMALLEST_COARSEST = 5
COARSE_ENOUGH = 9  # a grid coarser than this costs more to compile than it helps
FEW = 170  # nodes kept on a grid, that are solved at once with a dense matrix: one grid less to compile


@dataclass(frozen=True)
class Grid:
    """nodes x nodes centres of square cells around (centre_x, centre_y), spacing apart; lengths in units a*.

    Arrays on it have shape (nodes, nodes), first index Y, second index X, but where fields are even only the side from
    the axis on is kept (see `symmetry`): then `shape` is smaller.  x and y are those of the whole plane.
    """

    nodes: int
    spacing: float
    centre_x: float = 0.0
    centre_y: float = 0.0
    even: Even = WHOLE

    def __post_init__(self) -> None:
        if (self.even.y and self.centre_y) or (self.even.x and self.centre_x):
            raise ValueError(f"even = {self.even}: the grid must be centred on the axis of symmetry")

    @classmethod
    def square(cls, nodes: int, half_width: float) -> "Grid":
        """The grid over [-half_width, half_width]^2, with a node at the centre when `nodes` is odd."""
        return cls(nodes, 2.0 * half_width / (nodes - 1))

    @property
    def shape(self) -> tuple[int, int]:
        """Of arrays on the grid: what is kept of (nodes, nodes)."""
        half = (self.nodes + 1) // 2
        return half if self.even.y else self.nodes, half if self.even.x else self.nodes

    @property
    def kept_x(self) -> NDArray[np.float64]:
        """X of the columns of an array on the grid."""
        return self.x[self.nodes - self.shape[1] :]

    @property
    def kept_y(self) -> NDArray[np.float64]:
        """Y of the rows of an array on the grid."""
        return self.y[self.nodes - self.shape[0] :]

    @property
    def x(self) -> NDArray[np.float64]:
        """X of the nodes, shape (nodes,)."""
        return self._axis(self.centre_x)

    @property
    def y(self) -> NDArray[np.float64]:
        """Y of the nodes, shape (nodes,)."""
        return self._axis(self.centre_y)

    def _axis(self, centre: float) -> NDArray[np.float64]:
        # counted from the middle, so that a symmetric grid is symmetric to the last bit
        offsets = np.arange(self.nodes, dtype=np.float64) - (self.nodes - 1) / 2
        return np.asarray(centre + offsets * self.spacing, dtype=np.float64)

    def coarser(self) -> "Grid":
        """Every second node of this grid."""
        return replace(self, nodes=(self.nodes - 1) // 2 + 1, spacing=2.0 * self.spacing)

    def hierarchy(self) -> tuple["Grid", ...]:
        """This grid and its coarser ones, down to the last that is not trivial and has the axes of symmetry, if any."""
        grids = [self]
        factor = 4 if any(self.even) else 2
        while (last := grids[-1]).shape[0] * last.shape[1] > FEW and (last.nodes - 1) % factor == 0:
            if (coarser := last.coarser()).nodes < COARSE_ENOUGH:
                break
            grids.append(coarser)
        return tuple(grids)


def is_allowed(nodes: int) -> bool:
    """Whether a grid of nodes x nodes can be coarsened down to a trivial one."""
    odd = nodes >= SMALLEST_COARSEST and nodes % 2 == 1
    return odd and Grid(nodes, 1.0).hierarchy()[-1].nodes <= LARGEST_COARSEST


def allowed_nodes(at_least: float) -> int:
    """The smallest number of nodes a side, not below `at_least`, that multigrid can coarsen (see `check_nodes`)."""
    nodes = max(ceil(at_least), SMALLEST_COARSEST)
    while not is_allowed(nodes):
        nodes += 1
    return nodes


def check_nodes(nodes: int) -> None:
    """Raise ValueError unless a grid of nodes x nodes can be coarsened down to a trivial one."""
    if not is_allowed(nodes):
        below, above = _neighbours(nodes)
        raise ValueError(
            f"nodes = {nodes}: must be 2^k c + 1 with a coarsest grid of {SMALLEST_COARSEST} to {LARGEST_COARSEST} "
            f"nodes a side, so that multigrid can coarsen it; the nearest are {below} and {above}"
        )


def _neighbours(nodes: int) -> tuple[int, int]:
    """The nearest allowed counts at or below and above `nodes`."""
    allowed = sorted({c * 2**k + 1 for c in range(SMALLEST_COARSEST - 1, LARGEST_COARSEST) for k in range(12)})
    below = [n for n in allowed if n <= nodes] or allowed[:1]
    above = [n for n in allowed if n > nodes] or allowed[-1:]
    return below[-1], above[0]
