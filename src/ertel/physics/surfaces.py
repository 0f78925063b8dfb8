"""Surface features: waviness, rings, a bump or a cavity, each moving with its own surface.

Heights are in units a^2/R, positive = metal towards the film (the gap is X^2/2 + Y^2/2 - roughness, eq. 3); lengths in
units a.  A shape is a function of position on its surface; a `Feature` is a shape on surface 1 or 2.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sin
from typing import Any, Protocol

import numpy as np

from ertel.physics.motion import Motion, Surface

Array = Any  # NumPy arrays that broadcast


class Shape(Protocol):
    """A height over the position on a surface.

    It may have a property `even`, whether it is even in Y and in X: then half or a quarter of the plane is computed;
    and a property `size`, its smallest width in units a, which the grid has to resolve.
    """

    def height(self, X: Array, Y: Array) -> Array: ...


@dataclass(frozen=True)
class Waviness:
    """amplitude cos(2 pi X/wavelength_x + phase_x) cos(2 pi Y/wavelength_y + phase_y).

    An infinite wavelength leaves its factor out: transverse ridges have wavelength_y = inf, longitudinal ones
    wavelength_x = inf.  The wave reaches up to X = front on its surface and grows to full height over the `ramp` behind
    it, so that it can enter a contact that was smooth; an infinite front covers all.
    """

    amplitude: float
    wavelength_x: float
    wavelength_y: float = inf
    phase_x: float = 0.0
    phase_y: float = 0.0
    front: float = inf
    ramp: float = 0.0

    def height(self, X: Array, Y: Array) -> Array:
        along = np.cos(2 * np.pi * X / self.wavelength_x + self.phase_x)
        across = np.cos(2 * np.pi * Y / self.wavelength_y + self.phase_y)
        return self.amplitude * along * across * self._presence(X)

    @property
    def size(self) -> float:
        """The shorter wavelength (a)."""
        return min(self.wavelength_x, self.wavelength_y)

    @property
    def even(self) -> tuple[bool, bool]:
        return _stands(self.phase_y), _stands(self.phase_x) and self.front == inf

    def _presence(self, X: Array) -> Array:
        """1 well behind the front, 0 before it, a half cosine between."""
        if self.front == inf:
            return 1.0
        behind = np.clip((self.front - X) / max(self.ramp, 1e-12), 0.0, 1.0)
        return (1.0 - np.cos(np.pi * behind)) / 2


@dataclass(frozen=True)
class RingWaviness:
    """amplitude cos(2 pi r/wavelength + phase), r the distance from (X, Y)."""

    amplitude: float
    wavelength: float
    phase: float = 0.0
    X: float = 0.0
    Y: float = 0.0

    @property
    def size(self) -> float:
        """The wavelength (a)."""
        return self.wavelength

    @property
    def even(self) -> tuple[bool, bool]:
        return self.Y == 0, self.X == 0

    def height(self, X: Array, Y: Array) -> Array:
        r = np.hypot(X - self.X, Y - self.Y)
        return self.amplitude * np.cos(2 * np.pi * r / self.wavelength + self.phase)


@dataclass(frozen=True)
class Spot:
    """A bump (height > 0) or a cavity (height < 0) of the given radius at (X, Y) on its surface.

    height cos(pi r/(2.4 radius)) exp(-2 (r/(1.2 radius))^2): the shape of Mourier L, Mazuyer D, Lubrecht AA, Donnet C.
    Transient increase of film thickness in micro-textured EHL contacts. Tribol Int 2006;39:1745-1756.
    """

    height_at_centre: float
    radius: float
    X: float = 0.0
    Y: float = 0.0

    @property
    def size(self) -> float:
        """The diameter (a)."""
        return 2 * self.radius

    @property
    def even(self) -> tuple[bool, bool]:
        return self.Y == 0, self.X == 0

    def height(self, X: Array, Y: Array) -> Array:
        r = np.hypot(X - self.X, Y - self.Y) / (1.2 * self.radius)
        return self.height_at_centre * np.cos(np.pi / 2 * r) * np.exp(-2 * r**2)


@dataclass(frozen=True)
class Feature:
    """A shape on surface 1 or 2, with which it moves; at T = 0 the surface's coordinates are those of the contact."""

    shape: Shape
    surface: Surface = 1


def _stands(phase: float) -> bool:
    """Whether cos(k x + phase) is even to rounding."""
    return abs(sin(phase)) < 1e-15


def even(features: Sequence[Feature]) -> tuple[bool, bool]:
    """Whether all features are even in Y, and in X (as long as they do not move)."""
    each = [getattr(feature.shape, "even", (False, False)) for feature in features]
    return all(y for y, _ in each), all(x for _, x in each)


def height(features: Sequence[Feature], motion: Motion, T: float, X: Array, Y: Array) -> Array:
    """All features together at time T, over the contact's own coordinates X, Y (arrays that broadcast)."""
    total = np.zeros(np.broadcast_shapes(np.shape(X), np.shape(Y)))
    for feature in features:
        total = total + feature.shape.height(X - motion.travel(feature.surface, T), Y)
    return total
