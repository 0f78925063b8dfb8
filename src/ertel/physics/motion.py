"""The motion of a contact: load w(T), entrainment U(T), sliding speed, curvature c(T) of the gap, inertia of the ball.

Impact and rolling differ only in the motion and in the scales:

    impact     w = 0, U = 0, inertia 4/5: a free ball in the scales of its dry impact
    rolling    w = 1, U = 1, inertia 0: the film force balances the load at all times

Mixed cases are possible: impact on a moving track, a loaded ball that bounces, start-up, stop, reversal.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import copysign, cos, inf, pi
from typing import Annotated, Any, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from ertel.physics import units
from ertel.physics.dry_contact import FREE_BALL_INERTIA
from ertel.physics.units import Amount, Mark, Meaning, Quantity, plain

Surface = Literal[1, 2]
Floats = NDArray[np.float64]

SAMPLES = 401  # of a motion in time
# Gauss points from 0 to 1: exact for the product of two cubics, and to 1e-12 for a sixteenth of a sine's period
_points, _weights = np.polynomial.legendre.leggauss(4)
PLACES, WEIGHTS, PARTS = (_points + 1) / 2, _weights / 2, 16


class Signal(Protocol):
    """A quantity that may vary with time T (in t0): its value, its integral from 0 to T, its bounds from 0 to `until`.

    at: the values at many times.  knots: the times at which the slope jumps, rising; a time step ends on each.
    breaks: the times between which the signal is a smooth function.  shortest_period: infinite if the signal does not
    repeat.
    """

    def at(self, times: Floats) -> Floats: ...
    def range(self, until: float) -> tuple[float, float]: ...

    def __call__(self, T: float) -> float:
        return float(self.at(np.asarray(T)))

    def integral(self, T: float) -> float:
        low, high = min(0.0, T), max(0.0, T)
        turns = np.arange(low, high, self.shortest_period() / PARTS) if self.shortest_period() < inf else ()
        edges = np.unique([low, high, *turns, *(place for place in self.breaks() if low < place < high)])
        lengths = np.diff(edges)
        values = self.at(edges[:-1, None] + lengths[:, None] * PLACES)
        return copysign(1.0, T) * float(lengths @ (values @ WEIGHTS))

    def knots(self) -> tuple[float, ...]:
        return ()

    def breaks(self) -> tuple[float, ...]:
        return self.knots()

    def shortest_period(self) -> float:
        return inf

    @property
    def is_constant(self) -> bool:
        least, most = self.range(inf)
        return least == most


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
    def _plain(self) -> tuple[Floats, Floats]:
        places, values = np.array([[plain(part) for part in point] for point in self.points], dtype=float).T
        return places, values

    def at(self, times: Floats) -> Floats:
        return np.asarray(np.interp(times, *self._plain))

    def integral(self, T: float) -> float:
        return super().integral(T) if len(self.points) > 1 else self(0.0) * T

    def range(self, until: float) -> tuple[float, float]:
        places, values = self._plain
        values = np.append(values[(places > 0.0) & (places < until)], [self(0.0), self(until)])
        return float(values.min()), float(values.max())

    def knots(self) -> tuple[float, ...]:
        return self.breaks()

    def breaks(self) -> tuple[float, ...]:
        return tuple(self._plain[0].tolist()) if len(self.points) > 1 else ()


@dataclass(frozen=True)
class Smooth(Polyline):
    """A smooth curve through many points (T, value), T increasing; constant before the first and after the last.

    For signals that are sampled: measured, computed from a gear or a cam, or values of a function.  The curve has a
    continuous slope, is monotone wherever the points are, and passes no higher and no lower than they do, so that a
    load above zero stays above zero.  A run takes the steps that the film needs, whatever the number of points; of a
    `Polyline`, whose slope jumps, every point ends a step.  At the first and the last point the slope jumps.

    Source: Fritsch FN, Butland J. SIAM J Sci Stat Comput 1984;5:300 (PCHIP).
    """

    @cached_property
    def _curve(self) -> Any:
        # SciPy is imported here, because its import is slow
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(*self._plain)

    def at(self, times: Floats) -> Floats:
        places, _ = self._plain
        return np.asarray(self._curve(np.clip(times, places[0], places[-1]))) if len(places) > 1 else super().at(times)

    def knots(self) -> tuple[float, ...]:
        places = self.breaks()
        return (places[0], places[-1]) if places else ()


@dataclass(frozen=True)
class Track(Polyline):
    """The oil on a track: linear between points (y, thickness), y increasing; constant beyond them."""

    NAMES: ClassVar[tuple[str, str]] = ("y", "thickness")
    MARKS: ClassVar[tuple[Mark, Mark]] = (units.POSITION, units.LAYER)

    def across(self, Y: NDArray[np.float64]) -> NDArray[np.float64]:
        """The thickness at all Y at once."""
        return self.at(Y)

    @property
    def extremes(self) -> tuple[float, float]:
        """The least and the largest thickness."""
        _, layers = self._plain
        return float(layers.min()), float(layers.max())

    @property
    def is_even(self) -> bool:
        """Whether it is the same on both sides of Y = 0."""
        places, layers = self._plain
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

    def at(self, times: Floats) -> Floats:
        return self.mean + self.amplitude * np.sin(2 * pi * times / plain(self.period) + self.phase)

    def integral(self, T: float) -> float:
        turns = 2 * pi / plain(self.period)
        return self.mean * T + self.amplitude / turns * (cos(self.phase) - cos(turns * T + self.phase))

    def range(self, until: float) -> tuple[float, float]:
        return self.mean - abs(self.amplitude), self.mean + abs(self.amplitude)

    def shortest_period(self) -> float:
        return plain(self.period)


@dataclass(frozen=True)
class Product(Signal):
    """The product of two signals; its range is where it must lie, and may be wider than its values."""

    first: Signal
    second: Signal

    def at(self, times: Floats) -> Floats:
        return self.first.at(times) * self.second.at(times)

    def integral(self, T: float) -> float:
        return self.first(0.0) * self.second.integral(T) if self.first.is_constant else super().integral(T)

    def range(self, until: float) -> tuple[float, float]:
        ends = [one * other for one in self.first.range(until) for other in self.second.range(until)]
        return min(ends), max(ends)

    def knots(self) -> tuple[float, ...]:
        return tuple(sorted({*self.first.knots(), *self.second.knots()}))

    def breaks(self) -> tuple[float, ...]:
        return (*self.first.breaks(), *self.second.breaks())

    def shortest_period(self) -> float:
        return min(self.first.shortest_period(), self.second.shortest_period())


class SlidingRatio(Product):
    """The sliding speed that a slide-to-roll ratio, the first signal, makes of the entrainment speed."""


def constant(value: float) -> Signal:
    """A value that does not change."""
    return Polyline(((0.0, value),))


NO_SLIDING, SAME_GAP = constant(0.0), constant(1.0)


def reversed_sign(signal: Signal) -> Signal:
    """The signal times -1."""
    return Product(constant(-1.0), signal)


@dataclass(frozen=True)
class Motion:
    """Load, entrainment, inertia and sliding of the two bodies, and the curvature of the gap between them.

    Parameters
    ----------
    load : Signal
        Applied load w(T), in units of the Hertzian load F*.
    entrainment : Signal
        Mean speed of the surfaces U(T), in units a/t0 (rolling: u_m).
    inertia : float
        m (a^2/R)/(F* t0^2) in w - F = inertia * Delta''; not negative.  With 0 the load is balanced at all times.
    sliding : Signal
        The sliding speed u1 - u2, in units a/t0.
    curvature : Signal
        c(T) = R/R(T), by which the smooth gap is multiplied.
    """

    load: Signal
    entrainment: Signal
    inertia: float
    sliding: Signal = NO_SLIDING
    curvature: Signal = SAME_GAP

    @property
    def slide_to_roll(self) -> float:
        """(u1 - u2)/u_m at T = 0, infinite where surfaces slide that do not entrain."""
        if isinstance(self.sliding, SlidingRatio):
            return self.sliding.first(0.0)
        sliding, entrainment = self.sliding(0.0), self.entrainment(0.0)
        return sliding / entrainment if sliding and entrainment else copysign(inf, sliding) if sliding else 0.0

    @cached_property
    def flows(self) -> bool:
        """Whether the entrainment speed is non-zero at any time."""
        return any(self.entrainment.range(inf))

    @cached_property
    def slides(self) -> bool:
        """Whether the sliding speed is non-zero at any time."""
        return any(self.sliding.range(inf))

    @property
    def keeps_ratio(self) -> bool:
        """Whether the sliding speed is the same share of the entrainment speed at all times."""
        return not self.slides or (isinstance(self.sliding, SlidingRatio) and self.sliding.first.is_constant)

    @cached_property
    def bends(self) -> bool:
        """Whether the smooth gap is ever another one than that of the case."""
        return self.curvature.range(inf) != (1.0, 1.0)

    @property
    def signals(self) -> tuple[Signal, ...]:
        """All that may vary in time."""
        return self.load, self.entrainment, self.sliding, self.curvature

    def moment(self, T: float) -> tuple[float, float, float]:
        """Load, entrainment and curvature at time T, on which the film of that moment depends."""
        return self.load(T), self.entrainment(T), self.curvature(T)

    def moments(self, until: float) -> list[tuple[float, float, float]]:
        """Those of many times from 0 to `until`."""
        times = np.linspace(0.0, until, SAMPLES)
        varied = (self.load.at(times), self.entrainment.at(times), self.curvature.at(times))
        return [*zip(*(values.tolist() for values in varied), strict=True)]

    def flow_at(self, T: float) -> float:
        """U at time T; where the surfaces rest a zero with the sign of U before, whose flow left the rupture."""
        U = self.entrainment(T)
        earlier = self.entrainment.at(np.linspace(T, 0.0, 1001)).tolist() if U == 0.0 else ()
        return copysign(U, next((before for before in earlier if before), U))

    def next_knot(self, T: float) -> float:
        """The first time after T at which the slope of a signal jumps; infinite if none."""
        return min((knot for signal in self.signals for knot in signal.knots() if knot > T), default=inf)

    @property
    def shortest_period(self) -> float:
        """The shortest period of a signal; infinite if none oscillates."""
        return min(signal.shortest_period() for signal in self.signals)

    def travel(self, surface: Surface, T: float) -> float:
        """Distance that a surface has moved along X since T = 0, in units a."""
        return self.entrainment.integral(T) + (0.5 if surface == 1 else -0.5) * self.sliding.integral(T)


FREE_BALL = Motion(load=constant(0.0), entrainment=constant(0.0), inertia=FREE_BALL_INERTIA)
STEADY_ROLLING = Motion(load=constant(1.0), entrainment=constant(1.0), inertia=0.0)


def first_touch(T: Any, Delta: Any, start_approach: float) -> float:
    """T at which the undeformed bodies of an impact touch, Delta = 0.

    Interpolated linearly between the steps.  Until the ball is there, and where the oil stops it before, it is the T at
    which a ball that keeps its speed would be there.
    """
    for n in range(1, len(T)):
        if Delta[n - 1] < 0.0 <= Delta[n]:
            return float(T[n] - Delta[n] * (T[n] - T[n - 1]) / (Delta[n] - Delta[n - 1]))
    return -start_approach
