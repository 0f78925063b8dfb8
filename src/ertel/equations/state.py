"""The state at one time, and the interface of a solution method."""

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from ertel.case.status import Status
from ertel.numerics import bdf

Array = Any
Outcome = TypeVar("Outcome")
LOWEST: Mapping[str, float] = {"P": 0.0}  # bounds that hold between time levels too


class Work(NamedTuple):
    """Iterations, and convolutions counted by the nodes of the finest grid."""

    newton: int = 0
    krylov: int = 0
    convolutions: float = 0.0

    def plus(self, other: "Work") -> "Work":
        """The sum of both."""
        return Work(self.newton + other.newton, self.krylov + other.krylov, self.convolutions + other.convolutions)


NO_WORK = Work()


@dataclass(frozen=True)
class State:
    """The contact at one time: T in t0, approach in delta*, velocity dDelta/dT, fields of shape (n, n) or (n,) by name.

    The fields are P, H and others that a method needs to go on.  load, outside: the double integral of P on the grid
    and outside it.  status, work, error, record: of the step that made this state: its outcome, its work, how far the
    film is from its prediction (relative), and its numbers by name (those of `Method.measure` and of
    `account`).
    """

    T: float
    approach: float
    velocity: float
    fields: Mapping[str, Array]
    status: Status = Status.CONVERGED
    work: Work = NO_WORK
    outside: float = 0.0
    load: float = 0.0
    error: float = 0.0
    record: Mapping[str, float] = field(default_factory=dict)

    @property
    def P(self) -> Array:
        """The pressure."""
        return self.fields["P"]

    @property
    def H(self) -> Array:
        """The film thickness."""
        return self.fields["H"]


def combined(weights: bdf.Weights, values: Sequence[Array]) -> Array:
    """The weighted sum of values at several times, numbers or arrays."""
    return sum(w * value for w, value in zip(weights, values, strict=True))


def interpolated(levels: Sequence[State], T: float) -> State:
    """The state at a time between or after the levels, by polynomial interpolation; bounded fields stay bounded."""
    weights = bdf.interpolation_weights(T, [level.T for level in levels])
    fields = {
        name: combined(weights, [np.asarray(level.fields[name]) for level in levels]) for name in levels[0].fields
    }
    approach, velocity, load, outside = (
        float(combined(weights, [getattr(level, name) for level in levels]))
        for name in ("approach", "velocity", "load", "outside")
    )
    return State(
        T,
        approach,
        velocity,
        {name: field.clip(LOWEST[name]) if name in LOWEST else field for name, field in fields.items()},
        outside=outside,
        load=load,
    )


def padded(levels: Sequence[State]) -> list[State]:
    """Three levels, the oldest repeated: one shape, so one compilation, whatever the history."""
    return [*levels, *[levels[-1]] * 2][:3]


Stepping = Generator[Any, Any, State]  # yields the problems of a step, is sent their solutions, returns the new state


def solved(course: Generator[Any, Any, Outcome], solve: Callable[[Any], Any]) -> Outcome:
    """The return value of a generator of problems, with each problem solved when it is yielded."""
    try:
        problem = next(course)
        while True:
            problem = course.send(solve(problem))
    except StopIteration as end:
        outcome: Outcome = end.value
        return outcome


class Method(Protocol):
    """A way to step a contact forward in time.

    coordinates: axes of the fields in order, by name, in units a*.
    """

    coordinates: Mapping[str, Any]

    def start(self) -> State:
        """The state at T = 0."""
        ...

    def attempt(self, levels: Sequence[State], step: float) -> Stepping:
        """One step on from one to three levels, newest first; the new state has its error and its record."""
        ...

    def solve(self, problem: Any) -> Any:
        """The solution of a problem that `attempt` yields."""
        ...

    def advance(self, levels: Sequence[State], step: float) -> State:
        """One step on from one to three levels, newest first, its problems solved by this method."""
        return solved(self.attempt(levels, step), self.solve)

    def measure(self, level: State) -> dict[str, float]:
        """F (in units of the Hertz load F*) and the key values of `measure.measure`.

        If the contact is axisymmetric, the extremes lie on rings: X_min, X_P_max are their radii, Y_min, Y_P_max are 0.
        """
        ...

    def friction(self, level: State) -> Any:
        """The `account.Friction` of a level; its maps are of the shape of the fields."""
        ...

    def whole(self, field: Array, odd: bool = False) -> Array:
        """A field on all nodes of `coordinates`: a level may keep one side of an axis of symmetry only.

        odd: whether the field changes its sign at the axis Y = 0.
        """
        ...
