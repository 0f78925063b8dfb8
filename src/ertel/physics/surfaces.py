"""Surface features: waviness, rings, a bump or a cavity, and rough surfaces.  Each moves with its own surface.

Heights are in units a^2/R and lengths in units a.  A positive height is material that protrudes into the film: the gap
is X^2/2 + Y^2/2 - roughness, eq. (3).  A shape is a function of position on its surface; a `Feature` is a shape on
surface 1 or 2.  In a `Case` sizes may also be quantities in SI; they are converted before `heights` is called.

A user's own shape is a frozen dataclass with a method `heights(X, Y)` and a name (`ertel.shapes.register`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import inf, sin
from typing import Annotated, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ertel.physics import units
from ertel.physics.motion import Motion, Surface
from ertel.physics.registry import SHAPES
from ertel.physics.units import Amount, Bounds, Meaning, Quantity, explained, plain

CELLS_KEPT = 4.0  # in the shortest wave of a rough surface of which a grid loses nothing; of two cells nothing is left
CELLS_IN_WAVE = 16.0  # wanted across a wavelength, or the diameter of a spot
PERIOD = 8.0  # longest waves, where no period is given
MOST_WAVES = 1024  # of the shortest wavelength in a period
SERIES = 12  # kept in memory: some surfaces on the grids of a hierarchy
SEED = Bounds(ge=0, le=2**63 - 1, whole=True)

Array = Any  # NumPy arrays that broadcast
Front = Annotated[Amount, units.POSITION, Meaning("x up to which it reaches at T = 0; left out: everywhere", -1.5)]


class Shape(Protocol):
    """A height as a function of position on a surface.

    It may have more properties.  `even` says whether it is even in Y and in X; if so, only a half or a quarter of
    the plane is computed.  `size` is the width of its finest detail (a); ertel warns if the grid does not resolve it.
    `axisymmetric` says whether its height depends only on the distance from (0, 0).  A rough surface also has a method
    `heights_above(shortest, X, Y)`: its heights without the waves shorter than `shortest` (a), which a grid cannot
    show.
    """

    def heights(self, X: Array, Y: Array) -> Array: ...


@SHAPES.register("waviness")
@explained
@dataclass(frozen=True)
class Waviness:
    """amplitude cos(2 pi X/wavelength_x + phase_x) cos(2 pi Y/wavelength_y + phase_y).

    An infinite wavelength removes its factor: transverse ridges have wavelength_y = inf, longitudinal ridges have
    wavelength_x = inf.  The wave extends up to X = front on its surface and reaches full height over the distance
    `ramp` behind the front, so that it can enter a smooth contact.  With an infinite front it covers the whole surface.
    """

    amplitude: Annotated[Amount, units.HEIGHT, Meaning("half the height from valley to peak")]
    wavelength_x: Annotated[Amount, units.WIDTH, Meaning("wavelength along x; left out: ridges along x", 0.5)] = inf
    wavelength_y: Annotated[Amount, units.WIDTH, Meaning("wavelength along y; left out: ridges along y", 0.5)] = inf
    phase_x: Annotated[float, units.FINITE, Meaning("phase along x, in radians")] = 0.0
    phase_y: Annotated[float, units.FINITE, Meaning("phase along y, in radians")] = 0.0
    front: Front = inf
    ramp: Annotated[
        Amount | None, units.WIDTH, Meaning("length behind the front over which they grow; left out: at once", 0.5)
    ] = None

    def __post_init__(self) -> None:
        if self.wavelength_x == self.wavelength_y == inf:
            raise ValueError("wavelength_x: missing; needed: wavelength_x or wavelength_y, or both")
        if self.ramp is not None and self.front == inf:
            raise ValueError(f"ramp = {self.ramp}: needs front, behind which the wave grows")

    def heights(self, X: Array, Y: Array) -> Array:
        along = np.cos(2 * np.pi * X / plain(self.wavelength_x) + self.phase_x)
        across = np.cos(2 * np.pi * Y / plain(self.wavelength_y) + self.phase_y)
        return plain(self.amplitude) * along * across * self._presence(X)

    @property
    def size(self) -> float:
        """The shorter wavelength (a)."""
        return min(plain(self.wavelength_x), plain(self.wavelength_y))

    @property
    def even(self) -> tuple[bool, bool]:
        return _is_cosine(self.phase_y), _is_cosine(self.phase_x) and self.front == inf

    @property
    def is_uniform_along_y(self) -> bool:
        """Whether the heights are the same at all Y."""
        return self.wavelength_y == inf

    @property
    def is_ridges_along_x(self) -> bool:
        """Whether the height is constant along X, so that motion along X does not change it."""
        return self.wavelength_x == inf and self.front == inf

    def _presence(self, X: Array) -> Array:
        """1 well behind the front, 0 ahead of it, a half cosine in between."""
        if self.front == inf:
            return 1.0
        behind = np.clip((plain(self.front) - X) / max(plain(self.ramp or 0.0), 1e-12), 0.0, 1.0)
        return (1.0 - np.cos(np.pi * behind)) / 2


class _AroundAPoint:
    """A shape that is the same in all directions from (x, y)."""

    x: Amount
    y: Amount

    @property
    def even(self) -> tuple[bool, bool]:
        return plain(self.y) == 0, plain(self.x) == 0

    @property
    def axisymmetric(self) -> bool:
        return plain(self.x) == plain(self.y) == 0

    def _distance(self, X: Array, Y: Array) -> Array:
        return np.hypot(X - plain(self.x), Y - plain(self.y))


@SHAPES.register("rings")
@explained
@dataclass(frozen=True)
class RingWaviness(_AroundAPoint):
    """amplitude cos(2 pi r/wavelength + phase), where r is the distance from (x, y)."""

    amplitude: Annotated[Amount, units.HEIGHT, Meaning("half the height from valley to peak")]
    wavelength: Annotated[Amount, units.WIDTH, Meaning("distance from ring to ring")]
    phase: Annotated[float, units.FINITE, Meaning("phase in the middle, in radians")] = 0.0
    x: Annotated[Amount, units.POSITION, Meaning("their middle along x at T = 0")] = 0.0
    y: Annotated[Amount, units.POSITION, Meaning("their middle along y")] = 0.0

    @property
    def size(self) -> float:
        """The wavelength (a)."""
        return plain(self.wavelength)

    def heights(self, X: Array, Y: Array) -> Array:
        r = self._distance(X, Y)
        return plain(self.amplitude) * np.cos(2 * np.pi * r / plain(self.wavelength) + self.phase)


@SHAPES.register("spot")
@explained
@dataclass(frozen=True)
class Spot(_AroundAPoint):
    """A bump (height > 0) or a cavity (depth > 0, or height < 0) of the given radius at (x, y) on its surface.

    height cos(pi r/(2.4 radius)) exp(-2 (r/(1.2 radius))^2): the shape of Mourier L, Mazuyer D, Lubrecht AA, Donnet C.
    Transient increase of film thickness in micro-textured EHL contacts. Tribol Int 2006;39:1745-1756.
    """

    radius: Annotated[Amount, units.WIDTH, Meaning("its radius")]
    height: Annotated[Amount | None, units.HEIGHT, Meaning("height of a bump, in place of depth")] = None
    depth: Annotated[Amount | None, units.HEIGHT, Meaning("depth of a cavity", "200 nm")] = None
    x: Annotated[Amount, units.POSITION, Meaning("its middle along x at T = 0")] = 0.0
    y: Annotated[Amount, units.POSITION, Meaning("its middle along y")] = 0.0

    def __post_init__(self) -> None:
        if (self.height is None) == (self.depth is None):
            complaint = "missing" if self.height is None else "is given together with depth"
            raise ValueError(f"height: {complaint}; allowed: height (negative: a cavity); or depth")

    @property
    def size(self) -> float:
        """The diameter (a)."""
        return 2 * plain(self.radius)

    def heights(self, X: Array, Y: Array) -> Array:
        r = self._distance(X, Y) / (1.2 * plain(self.radius))
        at_centre = -plain(self.depth) if self.depth is not None else plain(self.height or 0.0)
        return at_centre * np.cos(np.pi / 2 * r) * np.exp(-2 * r**2)


@dataclass(frozen=True)
class Feature:
    """A shape on a surface.  It moves with that surface, whose coordinates are the contact's at T = 0.

    Parameters
    ----------
    shape : Shape
        The heights: `Waviness`, `Spot`, ..., or a record of one's own.
    surface : 1 or 2
        The surface.
    """

    shape: Shape
    surface: Surface = 1


def _is_cosine(phase: float) -> bool:
    """Whether cos(k x + phase) is even, to round-off."""
    return abs(sin(phase)) < 1e-15


def even(features: Sequence[Feature]) -> tuple[bool, bool]:
    """Whether all features are even in Y and whether all are even in X (while they do not move)."""
    each = [getattr(feature.shape, "even", (False, False)) for feature in features]
    return all(y for y, _ in each), all(x for _, x in each)


def axisymmetric(features: Sequence[Feature]) -> bool:
    """Whether all features are the same in all directions from (0, 0) (while they do not move)."""
    return all(getattr(feature.shape, "axisymmetric", False) for feature in features)


def height(features: Sequence[Feature], motion: Motion, T: float, X: Array, Y: Array, shortest: float = 0.0) -> Array:
    """Sum of all features at time T at the contact's coordinates X, Y (arrays that broadcast).

    shortest: of rough surfaces, waves shorter than this (a) are left out.
    """
    total = np.zeros(np.broadcast_shapes(np.shape(X), np.shape(Y)))
    for feature in features:
        shape: Any = feature.shape
        along = X - motion.travel(feature.surface, T)
        total = total + (shape.heights_above(shortest, along, Y) if has_waves(shape) else shape.heights(along, Y))
    return total


def has_waves(shape: Shape) -> bool:
    """Whether a shape is a rough surface, of whose waves a grid leaves out the shortest."""
    return hasattr(shape, "heights_above")


# -- rough surfaces ---------------------------------------------------------------------------------------------------


def smooth_step(share: Array) -> Array:
    """From 0 where share <= 0 to 1 where share >= 1, with two continuous derivatives: s^3 (10 - 15 s + 6 s^2)."""
    s = np.clip(share, 0.0, 1.0)
    return s**3 * (10.0 + s * (6.0 * s - 15.0))


def kept_share(cutoff_over_wavelength: Array) -> Array:
    """The share of the height of a wave that is left by a cutoff.

    All of a wave at least as long as the cutoff, nothing of one shorter than half of it, a smooth step in the wave
    number in between.  A cutoff of four cells of a grid leaves nothing that the grid would mistake for a longer wave,
    and does not touch waves of four cells and more: a surface that the grid resolves is the surface itself, so the
    order of the discretisation is not changed.
    """
    return smooth_step(2.0 - np.asarray(cutoff_over_wavelength))


@SHAPES.register("self-affine")
@explained
@dataclass(frozen=True)
class SelfAffine:
    """A random isotropic surface with the power spectrum q^(-2 (1 + hurst)) of wave numbers q, made from a seed.

    It is a sum of cosines of all directions with wavelengths from `shortest` to `longest` and random phases, so it is
    the same on every grid; the spectrum is flat above the wavelength `rolloff`.  See Persson BNJ, Albohr O, Tartaglino
    U, Volokitin AI, Tosatti E. J Phys Condens Matter 2005;17:R1-R62.  `rms` is that of a whole period, by
    which the surface repeats itself along x and y.
    """

    rms: Annotated[Amount, units.RMS, Meaning("root mean square of its heights")]
    hurst: Annotated[float, Bounds(gt=0, le=1), Meaning("Hurst exponent; 1: smooth hills, near 0: jagged ones", 0.8)]
    shortest: Annotated[Amount, units.WIDTH, Meaning("shortest wavelength", "20 um")]
    longest: Annotated[Amount, units.WIDTH, Meaning("longest wavelength", "200 um")]
    rolloff: Annotated[
        Amount | None,
        units.WIDTH,
        Meaning("wavelength above which the spectrum is flat; left out: as the longest", "100 um"),
    ] = None
    seed: Annotated[int, SEED, Meaning("number from which the surface is made; another one gives another surface")] = 0
    period: Annotated[
        Amount | None,
        units.WIDTH,
        Meaning("length after which it repeats itself; left out: 8 times the longest", "2 mm"),
    ] = None
    front: Front = inf
    ramp: Annotated[
        Amount | None, units.WIDTH, Meaning("length behind the front over which it grows; goes with front", 0.5)
    ] = None

    def __post_init__(self) -> None:
        if (self.ramp is None) != (self.front == inf):
            given, missing = ("front", "ramp") if self.ramp is None else ("ramp", "front")
            raise ValueError(f"{given} = {getattr(self, given)}: needs {missing}, with which it grows smoothly")
        if any(isinstance(value, Quantity) for value in vars(self).values()):
            return
        shortest, longest = plain(self.shortest), plain(self.longest)
        rolloff, period = plain(self.rolloff or longest), plain(self._period)
        if not shortest < longest:
            raise ValueError(f"shortest = {shortest:g} a: must be below longest, {longest:g} a")
        if not shortest <= rolloff <= longest:
            raise ValueError(
                f"rolloff = {rolloff:g} a: must be from shortest, {shortest:g} a, to longest, {longest:g} a"
            )
        if period < longest:
            raise ValueError(f"period = {period:g} a: must be at least longest, {longest:g} a")
        if period > MOST_WAVES * shortest:
            raise ValueError(
                f"shortest = {shortest:g} a: is too short for a period of {period:g} a; must be at least "
                f"{period / MOST_WAVES:g} a"
            )

    @property
    def size(self) -> float:
        """The shortest wavelength (a)."""
        return plain(self.shortest)

    @property
    def _period(self) -> Amount:
        return PERIOD * plain(self.longest) if self.period is None else self.period

    def heights(self, X: Array, Y: Array) -> Array:
        return self.heights_above(0.0, X, Y)

    def heights_above(self, shortest: float, X: Array, Y: Array) -> Array:
        """The heights without waves shorter than `shortest` (a)."""
        amplitudes, waves_along, waves_across = _series(self, shortest)
        wave_number = 2j * np.pi / plain(self._period)
        along = np.exp(wave_number * np.asarray(X)[..., None] * waves_along)
        across = np.exp(wave_number * np.asarray(Y)[..., None] * waves_across)
        heights = _sum(across @ amplitudes, along)
        if self.front == inf:
            return heights
        return heights * smooth_step((plain(self.front) - X) / plain(self.ramp or 0.0))


def _sum(across: NDArray[np.complex128], along: NDArray[np.complex128]) -> NDArray[np.float64]:
    """The real sum over the waves, the last axis of both; on a grid, Y (n, 1) and X (1, n), a product of matrices."""
    if across.ndim == along.ndim == 3 and across.shape[1] == along.shape[0] == 1:
        return np.asarray((across[:, 0] @ along[0].T).real)
    return np.asarray(np.einsum("...m,...m->...", across, along).real)


@lru_cache(maxsize=SERIES)
def _series(surface: SelfAffine, shortest: float) -> tuple[NDArray[np.complex128], Array, Array]:
    """The waves of a surface of which a grid keeps those above a wavelength.

    Their complex amplitudes (across, along), and their numbers in a period along X and along Y.
    """
    period, rolloff = plain(surface._period), plain(surface.rolloff or surface.longest)
    most = int(period / plain(surface.shortest) * (1 + 1e-12))
    along, across = np.arange(-most, most + 1), np.arange(most + 1)
    number = np.hypot(along, across[:, None])  # of waves in a period
    inside = (number * plain(surface.shortest) <= period * (1 + 1e-12)) & (
        number * plain(surface.longest) >= period * (1 - 1e-12)
    )
    inside[0, along <= 0] = False  # the same waves as those on the other side
    flat = np.maximum(number, period / rolloff)
    squares = np.where(inside, flat ** (-2.0 * (1.0 + surface.hurst)), 0.0)
    heights = plain(surface.rms) * np.sqrt(2.0 * squares / squares.sum())
    waves = heights * np.exp(2j * np.pi * _phases(surface.seed, most)) * kept_share(number * shortest / period)
    rows, columns = waves.any(axis=1), waves.any(axis=0)
    return waves[np.ix_(rows, columns)], along[columns], across[rows]


def _phases(seed: int, most: int) -> NDArray[np.float64]:
    """Random phases from 0 to 1, in rows of wave numbers 0 to most and columns of -most to most.

    They are read off the bits of a generator whose stream NumPy promises to keep, one stream for each row, from the
    middle outwards: a wave has the same phase whatever the shortest and the longest one are.
    """
    bits = [np.random.PCG64([seed, row]).random_raw(2 * most + 1) for row in range(most + 1)]
    outwards = (np.array(bits, dtype=np.uint64) >> np.uint64(11)) * 2.0**-53
    return np.concatenate([outwards[:, 2::2][:, ::-1], outwards[:, :1], outwards[:, 1::2]], axis=1)
