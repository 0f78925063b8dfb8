"""One time level, and what a method of solution must be able to do."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from ertel.model.measure import measure
from ertel.model.status import Status
from ertel.numerics.grid import Grid
from ertel.numerics.richardson import Extrapolation, extrapolate
from ertel.numerics.symmetry import unfolded

Array = Any


class Level(NamedTuple):
    """The contact at one time.  T in t0, approach in delta*, velocity dDelta/dT; P, H of shape (n, n) or (n,)."""

    T: float
    approach: float
    velocity: float
    P: Array
    H: Array


class Attempt(NamedTuple):
    """A new level, how well it went, and the work it took."""

    level: Level
    status: Status
    newton: int
    krylov: int
    convolutions: float


class Method(Protocol):
    """A way to step a contact forward in time."""

    @property
    def coordinates(self) -> Mapping[str, Any]:
        """Axes of P and H in order, by name, in units a*."""
        ...

    def start(self) -> Attempt:
        """The level at T = 0, and the work it took."""
        ...

    def advance(self, levels: Sequence[Level], step: float) -> Attempt:
        """One step on from one to three levels, newest first."""
        ...

    def measure(self, level: Level) -> dict[str, float]:
        """F (in units of Hertz' load F*), P_c, P_max, H_c, H_min, X_min, Y_min."""
        ...

    def whole(self, field: Array) -> Array:
        """A field of a level on all nodes of `coordinates`: a level may keep one side of an axis of symmetry only."""
        ...

    def film_error(self, H: Array, H_predicted: Array, P: Array) -> float:
        """How far a film is from its prediction, relative, root mean square over the load that P carries."""
        ...


@dataclass(frozen=True)
class GridSolution:
    """The steady contact on one grid: fields of its shape, approach in a^2/R, how it ended, and the work it took.

    history: the largest residual before the first and after each Newton iteration.  convolutions: on this grid.
    """

    grid: Grid
    P: Array
    H: Array
    approach: float
    residual: float
    status: Status
    newton: int
    krylov: int
    convolutions: float
    history: tuple[float, ...] = ()

    def measure(self) -> dict[str, float]:
        """Films, pressures and load, see `measure.measure`, and Delta."""
        return {"Delta": self.approach, **measure(self.grid, self.P, self.H)}

    def whole(self, field: Array) -> Array:
        """P or H on the whole plane, shape (nodes, nodes): the grid may keep one side of an axis of symmetry only."""
        return unfolded(field, self.grid.even)


@dataclass(frozen=True)
class Rolling:
    """The solutions on all grids, coarsest first."""

    solutions: tuple[GridSolution, ...]

    @property
    def finest(self) -> GridSolution:
        return self.solutions[-1]

    @property
    def convolutions(self) -> float:
        """The work on all grids, in convolutions on the finest."""
        return sum(s.convolutions * (s.grid.nodes / self.finest.grid.nodes) ** 2 for s in self.solutions)

    def extrapolate(self, name: str) -> Extrapolation:
        """A quantity of `measure` by Richardson's extrapolation: the error falls with the square of the spacing."""
        return extrapolate(*(s.measure()[name] for s in self.solutions[-2:]))
