"""One time level, and what a method of solution must be able to do."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from ertel.model.status import Status

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
