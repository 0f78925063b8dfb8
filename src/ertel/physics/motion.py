"""The motion of a contact: applied load w(T), entrainment speed U(T), slide-to-roll ratio, and inertia of the ball.

Impact and rolling differ only in the motion and in the scales:

    impact     w = 0, U = 0, inertia 4/5: a free ball in the scales of its dry impact
    rolling    w = 1, U = 1, inertia 0: the film force balances the load at all times

Mixed cases are possible: impact on a moving track, a loaded ball that bounces, start-up, stop, reversal.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import copysign, cos, inf, pi, sin
from typing import Annotated, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from ertel.physics import units
from ertel.physics.geometry import FREE_BALL_INERTIA
from ertel.physics.units import Amount, Mark, Meaning, Quantity, plain

Surface = Literal[1, 2]


class Signal(Protocol):
    """A quantity that may vary with time T (in t0): its value, its integral from 0 to T, its bounds from 0 to `until`.

    knots: the times at which the slope jumps, rising.  shortest_period: infinite if the signal does not repeat.
    """

    def __call__(self, T: float) -> float: ...
    def integral(self, T: float) -> float: ...
    def range(self, until: float) -> tuple[float, float]: ...

    def knots(self) -> tuple[float, ...]:
        return ()

    def shortest_period(self) -> float:
        return inf


@dataclass(frozen=True)
class Polyline(Signal):
    """Linear interpolation between points (T, value), T increasing; constant before the first and after the last."""

    points: tuple[tuple[Amount, Amount], ...]

    NAMES: ClassVar[tuple[str, str]] = ("T", "value")
    MARKS: ClassVar[tuple[Mark, Mark]] = (units.TIME, units.FINITE)

    def __post_init__(self) -> None:
        x, value = self.NAMES
        needed = f"must be [{x}, {value}] with rising {x}"
        places = [place for place, _ in self.points if not isinstance(place, Quantity)]  # SI is checked when scaled
        if not self.points:
            raise ValueError(f"points: are none; {needed}")
        for first, second in pairwise(places):
            if not second > first:
                raise ValueError(f"points: {x} = {second} comes after {x} = {first}; {needed}")

    @cached_property
    def _plain(self) -> tuple[tuple[float, float], ...]:
        return tuple((plain(T), plain(value)) for T, value in self.points)

    def __call__(self, T: float) -> float:
        (_, first), *others = self._plain
        times, values = zip(*self._plain, strict=True)
        return float(np.interp(T, times, values)) if others else first

    def integral(self, T: float) -> float:
        # the trapezium rule is exact between 0, the points and T
        knots = sorted({0.0, T, *(t for t, _ in self._plain if min(0.0, T) < t < max(0.0, T))}, reverse=bool(T < 0))
        return sum((late - early) * (self(early) + self(late)) / 2 for early, late in pairwise(knots))

    def range(self, until: float) -> tuple[float, float]:
        values = [self(0.0), self(until), *(v for T, v in self._plain if 0.0 < T < until)]
        return min(values), max(values)

    def knots(self) -> tuple[float, ...]:
        return tuple(T for T, _ in self._plain) if len(self.points) > 1 else ()


@dataclass(frozen=True)
class Track(Polyline):
    """The oil on a track: linear between points (y, thickness), y increasing; constant beyond them."""

    NAMES: ClassVar[tuple[str, str]] = ("y", "thickness")
    MARKS: ClassVar[tuple[Mark, Mark]] = (units.POSITION, units.LAYER)

    def across(self, Y: NDArray[np.float64]) -> NDArray[np.float64]:
        """The thickness at all Y at once."""
        places, layers = np.transpose(self._plain)
        return np.asarray(np.interp(Y, places, layers))

    @property
    def extremes(self) -> tuple[float, float]:
        """The least and the largest thickness."""
        layers = [layer for _, layer in self._plain]
        return min(layers), max(layers)

    @property
    def is_even(self) -> bool:
        """Whether it is the same on both sides of Y = 0."""
        places, layers = np.transpose(self._plain)
        return len(places) == 1 or bool(np.allclose(places, -places[::-1]) and np.allclose(layers, layers[::-1]))


@dataclass(frozen=True)
class Oscillation(Signal):
    """mean + amplitude sin(2 pi T/period + phase); period in t0, phase in radians."""

    mean: Annotated[float, units.FINITE, Meaning("mean value", 1)]
    amplitude: Annotated[float, units.FINITE, Meaning("largest deviation from the mean", 0.2)]
    period: Annotated[Amount, units.DURATION, Meaning("period", 4)]
    phase: Annotated[float, units.FINITE, Meaning("phase at T = 0, in radians")] = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.period, Quantity) and not self.period > 0:
            raise ValueError(f"period = {self.period}: must be above zero")

    def __call__(self, T: float) -> float:
        return self.mean + self.amplitude * sin(2 * pi * T / plain(self.period) + self.phase)

    def integral(self, T: float) -> float:
        turns = 2 * pi / plain(self.period)
        return self.mean * T + self.amplitude / turns * (cos(self.phase) - cos(turns * T + self.phase))

    def range(self, until: float) -> tuple[float, float]:
        return self.mean - abs(self.amplitude), self.mean + abs(self.amplitude)

    def shortest_period(self) -> float:
        return plain(self.period)


def reversed_sign(signal: Signal) -> Signal:
    """The signal times -1."""
    if isinstance(signal, Oscillation):
        return replace(signal, mean=-signal.mean, amplitude=-signal.amplitude)
    if isinstance(signal, Polyline):
        return Polyline(tuple((T, -plain(value)) for T, value in signal.points))
    raise ValueError(f"{signal!r}: its sign cannot be changed")


def constant(value: float) -> Signal:
    """A value that does not change."""
    return Polyline(((0.0, value),))


@dataclass(frozen=True)
class Motion:
    """Load, entrainment, inertia and sliding of the two bodies.

    Parameters
    ----------
    load : Signal
        Applied load w(T), in units of the Hertzian load F*.
    entrainment : Signal
        Mean speed of the surfaces U(T), in units a/t0 (rolling: u_m).
    inertia : float
        m (a^2/R)/(F* t0^2) in w - F = inertia * Delta''; not negative.  With 0 the load is balanced at all times.
    slide_to_roll : float
        (u1 - u2)/u_m, constant in time.
    """

    load: Signal
    entrainment: Signal
    inertia: float
    slide_to_roll: float = 0.0

    @cached_property
    def flows(self) -> bool:
        """Whether the entrainment speed is non-zero at any time."""
        return any(self.entrainment.range(inf))

    def flow_at(self, T: float) -> float:
        """U at time T; where the surfaces rest a zero with the sign of U before, whose flow left the rupture."""
        U = self.entrainment(T)
        earlier = (self.entrainment(time) for time in np.linspace(T, 0.0, 1001).tolist()) if U == 0.0 else ()
        return copysign(U, next((before for before in earlier if before), U))

    def sliding(self, T: float) -> float:
        """The sliding speed u1 - u2 at time T, in units a/t0."""
        return self.slide_to_roll * self.entrainment(T)

    def next_knot(self, T: float) -> float:
        """The first time after T at which the slope of the load or of the entrainment jumps; infinite if none."""
        return min((knot for knot in (*self.load.knots(), *self.entrainment.knots()) if knot > T), default=inf)

    @property
    def shortest_period(self) -> float:
        """The shorter period of the load and the entrainment; infinite if neither oscillates."""
        return min(self.load.shortest_period(), self.entrainment.shortest_period())

    def travel(self, surface: Surface, T: float) -> float:
        """Distance that a surface has moved along X since T = 0, in units a."""
        share = 1.0 + (0.5 if surface == 1 else -0.5) * self.slide_to_roll
        return share * self.entrainment.integral(T)


FREE_BALL = Motion(load=constant(0.0), entrainment=constant(0.0), inertia=FREE_BALL_INERTIA)
STEADY_ROLLING = Motion(load=constant(1.0), entrainment=constant(1.0), inertia=0.0)
