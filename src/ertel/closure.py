"""What fixes the approach Delta: Newton's law for the ball, a given load, or a prescribed motion.

At a new time level every closure is one line in Delta and the load F = double integral of P:

    approach_weight * Delta + load_weight * F = value

Impact and rolling differ in this line, in the scales and in the entrainment U(T), and in nothing else.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi
from typing import NamedTuple, Protocol

from ertel.bdf import Weights

HERTZ_LOAD = 2.0 * pi / 3.0  # double integral of sqrt(1 - r^2): the dry load that carries Delta = 1
NEWTON = 15.0 / (8.0 * pi)  # Delta'' + NEWTON * F = 0 with the time unit delta*/v0 (the paper's eq. 4, corrected)


class ClosureLine(NamedTuple):
    """approach_weight * Delta + load_weight * F = value, F the double integral of P (dimensionless)."""

    approach_weight: float
    load_weight: float
    value: float


STATIC_LOAD = ClosureLine(0.0, 1.0, HERTZ_LOAD)  # steady rolling: the film and its elasticity balance the load


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


@dataclass(frozen=True)
class NewtonsLaw:
    """The free ball: Delta'' = -15/(8 pi) F, eq. (4) in units delta*/v0.

    With backward differences Delta' = V and V' = -15/(8 pi) F are both linear in the new values, so V drops out.
    """

    def line(self, T: float, rates: Weights, approaches: Sequence[float], velocities: Sequence[float]) -> ClosureLine:
        a0 = float(rates[0])
        old_V = _rate(rates, 0.0, velocities)
        old_Delta = _rate(rates, 0.0, approaches)
        return ClosureLine(1.0, NEWTON / a0**2, -old_V / a0**2 - old_Delta / a0)

    def velocity(self, T: float, rates: Weights, approach: float, approaches: Sequence[float]) -> float:
        return _rate(rates, approach, approaches)


FREE_BALL = NewtonsLaw()


@dataclass(frozen=True)
class PrescribedApproach:
    """A test rig's motion Delta = motion(T), T in units t0."""

    motion: Callable[[float], float]

    def line(self, T: float, rates: Weights, approaches: Sequence[float], velocities: Sequence[float]) -> ClosureLine:
        return ClosureLine(1.0, 0.0, self.motion(T))

    def velocity(self, T: float, rates: Weights, approach: float, approaches: Sequence[float]) -> float:
        return _rate(rates, approach, approaches)
