"""Richardson extrapolation: the error estimate from two grids, for a second-order method."""

from collections.abc import Sequence
from typing import NamedTuple


class Extrapolation(NamedTuple):
    """A value on the finest grid, an estimate of its error there, and the value extrapolated to zero spacing."""

    value: float
    error: float
    extrapolated: float


def extrapolate(coarse: float, fine: float) -> Extrapolation:
    """Extrapolation from a grid and the grid with half its spacing; the error is proportional to spacing squared."""
    step = (fine - coarse) / 3
    return Extrapolation(fine, abs(step), fine + step)


def expected(values: Sequence[float]) -> float:
    """The expected value on the next finer grid, from the values so far (coarsest first): the change falls fourfold."""
    *earlier, last = values[-2:]
    return last + sum(last - e for e in earlier) / 4
