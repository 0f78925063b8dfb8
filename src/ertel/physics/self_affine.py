"""The shape "self-affine": a random surface whose roughness looks alike on all scales between two wavelengths."""

from dataclasses import dataclass
from functools import lru_cache
from math import inf
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ertel.physics.band_limit import kept_share, smooth_step
from ertel.physics.registry import SHAPES
from ertel.physics.units import POSITION, RMS, WIDTH, Amount, Bounds, Meaning, Quantity, plain

Array = Any  # NumPy arrays that broadcast

PERIOD = 8.0  # longest waves, where no period is given
MOST_WAVES = 1024  # of the shortest wavelength in a period
SERIES = 12  # kept in memory: some surfaces on the grids of a hierarchy
SEED = Bounds(ge=0, le=2**63 - 1, whole=True)


@SHAPES.register("self-affine")
@dataclass(frozen=True)
class SelfAffine:
    """A random isotropic surface with the power spectrum q^(-2 (1 + hurst)) of wave numbers q, made from a seed.

    It is a sum of cosines of all directions with wavelengths from `shortest` to `longest` and random phases, so it is
    the same on every grid; the spectrum is flat above the wavelength `rolloff`.  See Persson BNJ, Albohr O, Tartaglino
    U, Volokitin AI, Tosatti E. J Phys Condens Matter 2005;17:R1-R62.  `rms` is that of a whole period, by
    which the surface repeats itself along x and y.
    """

    rms: Annotated[Amount, RMS, Meaning("root mean square of its heights")]
    hurst: Annotated[float, Bounds(gt=0, le=1), Meaning("Hurst exponent; 1: smooth hills, near 0: jagged ones", 0.8)]
    shortest: Annotated[Amount, WIDTH, Meaning("shortest wavelength", "20 um")]
    longest: Annotated[Amount, WIDTH, Meaning("longest wavelength", "200 um")]
    rolloff: Annotated[
        Amount | None,
        WIDTH,
        Meaning("wavelength above which the spectrum is flat; left out: as the longest", "100 um"),
    ] = None
    seed: Annotated[int, SEED, Meaning("number from which the surface is made; another one gives another surface")] = 0
    period: Annotated[
        Amount | None, WIDTH, Meaning("length after which it repeats itself; left out: 8 times the longest", "2 mm")
    ] = None
    front: Annotated[
        Amount, POSITION, Meaning("x up to which it reaches at T = 0; left out: it is everywhere", -1.5)
    ] = inf
    ramp: Annotated[
        Amount | None, WIDTH, Meaning("length behind the front over which it grows; goes with front", 0.5)
    ] = None

    def __post_init__(self) -> None:
        if (self.ramp is None) != (self.front == inf):
            said, other = ("front", "ramp") if self.ramp is None else ("ramp", "front")
            raise ValueError(f"{said} = {getattr(self, said)}: needs {other}, with which it grows smoothly")
        if not any(isinstance(value, Quantity) for value in vars(self).values()):
            self._check()

    def _check(self) -> None:
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
        series, period = _series(self, shortest), plain(self._period)
        along = np.exp(2j * np.pi / period * np.asarray(X)[..., None] * series.along)
        across = np.exp(2j * np.pi / period * np.asarray(Y)[..., None] * series.across)
        found = _sum(across @ series.amplitudes, along)
        if self.front == inf:
            return found
        return found * smooth_step((plain(self.front) - X) / plain(self.ramp or 0.0))


def _sum(across: NDArray[np.complex128], along: NDArray[np.complex128]) -> NDArray[np.float64]:
    """The real sum over the waves, the last axis of both; on a grid, Y (n, 1) and X (1, n), a product of matrices."""
    if across.ndim == along.ndim == 3 and across.shape[1] == along.shape[0] == 1:
        return np.asarray((across[:, 0] @ along[0].T).real)
    return np.asarray(np.einsum("...m,...m->...", across, along).real)


class _Series(NamedTuple):
    """The complex amplitudes (across, along) of the waves, by their numbers in a period along Y and along X."""

    amplitudes: NDArray[np.complex128]
    along: NDArray[np.int64]
    across: NDArray[np.int64]


@lru_cache(maxsize=SERIES)
def _series(surface: SelfAffine, shortest: float) -> _Series:
    """The waves of a surface of which a grid keeps those above a wavelength."""
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
    return _Series(waves[np.ix_(rows, columns)], along[columns], across[rows])


def _phases(seed: int, most: int) -> NDArray[np.float64]:
    """Random phases from 0 to 1, in rows of wave numbers 0 to most and columns of -most to most.

    They are read off the bits of a generator whose stream NumPy promises to keep, one stream for each row, from the
    middle outwards: a wave has the same phase whatever the shortest and the longest one are.
    """
    bits = [np.random.PCG64([seed, row]).random_raw(2 * most + 1) for row in range(most + 1)]
    outwards = (np.array(bits, dtype=np.uint64) >> np.uint64(11)) * 2.0**-53
    return np.concatenate([outwards[:, 2::2][:, ::-1], outwards[:, :1], outwards[:, 1::2]], axis=1)
