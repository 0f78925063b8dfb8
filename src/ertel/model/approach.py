"""What fixes the approach Delta: Newton's law for the ball, of which a balanced load is the limit, or a given motion.

At a new time level every closure is one line in Delta and the load, the double integral of P:

    approach_weight * Delta + load_weight * load = value

Impact and rolling differ in this line, in the scales and in the entrainment U(T), and in nothing else.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from ertel.numerics.bdf import Weights
from ertel.physics.geometry import HERTZ_LOAD
from ertel.physics.motion import Motion, Signal


class ClosureLine(NamedTuple):
    """approach_weight * Delta + load_weight * load = value, load the double integral of P (dimensionless)."""

    approach_weight: float
    load_weight: float
    value: float


class Closure(Protocol):
    """The law for Delta, discretised at one new time level."""

    def line(self, T: float, rates: Weights, approaches: Sequence[float], velocities: Sequence[float]) -> ClosureLine:
        """The line at time T, from BDF weights (newest first) and the earlier Delta and dDelta/dT."""
        ...

    def velocity(self, T: float, rates: Weights, approach: float, approaches: Sequence[float]) -> float:
        """dDelta/dT at time T once Delta is known."""
        ...


def _rate(rates: Weights, new: float, earlier: Sequence[float]) -> float:
    return float(rates[0] * new + sum(w * y for w, y in zip(rates[1:], earlier, strict=False)))


def balanced(load: float = 1.0) -> ClosureLine:
    """The film carries the load, given in units of Hertz' F*: steady rolling."""
    return ClosureLine(0.0, 1.0 / HERTZ_LOAD, load)


@dataclass(frozen=True)
class NewtonsLaw:
    """inertia * Delta'' + F = w(T), F the double integral of P over 2 pi/3, w the applied load.

    The free ball of an impact: inertia 4/5, w = 0, that is Delta'' = -15/(8 pi) double integral of P, eq. (4) in units
    delta*/v0.  Rolling: inertia 0, a balanced load.  With backward differences Delta' = V and V' are both linear in the
    new values, so V drops out.
    """

    inertia: float
    load: Signal

    @classmethod
    def of(cls, motion: Motion) -> "NewtonsLaw":
        return cls(motion.inertia, motion.load)

    def line(self, T: float, rates: Weights, approaches: Sequence[float], velocities: Sequence[float]) -> ClosureLine:
        a0 = float(rates[0])
        old = a0 * _rate(rates, 0.0, approaches) + _rate(rates, 0.0, velocities)
        return ClosureLine(self.inertia * a0**2, 1.0 / HERTZ_LOAD, self.load(T) - self.inertia * old)

    def velocity(self, T: float, rates: Weights, approach: float, approaches: Sequence[float]) -> float:
        return _rate(rates, approach, approaches)


@dataclass(frozen=True)
class PrescribedApproach:
    """A test rig's motion Delta = motion(T), T in units t0."""

    motion: Callable[[float], float]

    def line(self, T: float, rates: Weights, approaches: Sequence[float], velocities: Sequence[float]) -> ClosureLine:
        return ClosureLine(1.0, 0.0, self.motion(T))

    def velocity(self, T: float, rates: Weights, approach: float, approaches: Sequence[float]) -> float:
        return _rate(rates, approach, approaches)
