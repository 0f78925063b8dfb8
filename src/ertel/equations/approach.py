"""The closure for the approach Delta: Newton's law for the ball, or a balanced load, which is its limit.

At a new time level it is one linear equation in Delta and the load (the double integral of P):

    approach_weight * Delta + load_weight * load = value

Impact and rolling differ only in this equation, in the scales and in the entrainment speed U(T).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from ertel.numerics.bdf import Weights
from ertel.physics.dry_contact import HERTZ_LOAD
from ertel.physics.motion import Signal


class ClosureLine(NamedTuple):
    """approach_weight * Delta + load_weight * load = value; load is the double integral of P (dimensionless)."""

    approach_weight: float
    load_weight: float
    value: float

    def less(self, load: float) -> "ClosureLine":
        """The equation for the rest of the load."""
        return self._replace(value=self.value - self.load_weight * load)

    def approach(self, load: Any) -> Any:
        """Delta under a load, of the kind of the load, where Delta has a weight."""
        return (self.value - self.load_weight * load) / self.approach_weight


def rate_of_change(rates: Any, new: Any, earlier: Any) -> Any:
    """The rate of a number by backward differences, from its new value and the earlier ones, newest first."""
    return rates[0] * new + sum(w * y for w, y in zip(rates[1:], earlier, strict=False))


def balanced(load: float = 1.0, hertz_load: float = HERTZ_LOAD) -> ClosureLine:
    """The film carries a given load, in units of the Hertz load F*: steady rolling.

    hertz_load: that of the geometry, the double integral of P under F*.
    """
    return ClosureLine(0.0, 1.0 / hertz_load, load)


@dataclass(frozen=True)
class NewtonsLaw:
    """Newton's law inertia * Delta'' + F = w(T); F is the double integral of P over hertz_load, w is the applied load.

    hertz_load is that of the geometry, 2 pi/3 for a circle.  A free ball (impact) has inertia 4/5 and w = 0:
    Delta'' = -15/(8 pi) double integral of P, eq. (4) in units delta*/v0.  A rolling contact has inertia 0: a balanced
    load.  With backward differences Delta' = V and V' are both linear in the new values, so V is eliminated.
    """

    inertia: float
    load: Signal
    hertz_load: float = HERTZ_LOAD

    def line(self, T: float, rates: Weights, approaches: Sequence[float], velocities: Sequence[float]) -> ClosureLine:
        """The linear equation at time T, from BDF weights (newest first) and the earlier Delta and dDelta/dT."""
        a0 = float(rates[0])
        old = a0 * rate_of_change(rates, 0.0, approaches) + rate_of_change(rates, 0.0, velocities)
        return ClosureLine(self.inertia * a0**2, 1.0 / self.hertz_load, self.load(T) - self.inertia * old)
