"""Richardson's extrapolation: what two grids tell of the error, for a method of second order."""

from collections.abc import Sequence
from typing import NamedTuple


class Extrapolation(NamedTuple):
    """A value on the finest grid, an estimate of its error there, and the value extrapolated to zero spacing."""

    value: float
    error: float
    extrapolated: float


def extrapolate(coarse: float, fine: float) -> Extrapolation:
    """From the values on a grid and on that of half its spacing: the error falls with the square of the spacing."""
    step = (fine - coarse) / 3
    return Extrapolation(fine, abs(step), fine + step)


def expected(values: Sequence[float]) -> float:
    """The value on the next grid from those on the coarser ones (coarsest first): its change falls fourfold."""
    *earlier, last = values[-2:]
    return last + sum(last - e for e in earlier) / 4
