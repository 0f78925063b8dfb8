"""Back from fringes to films: the film along a profile of intensity, by unwrapping its phase."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ertel.physics.optics.rig import Rig

Array = NDArray[np.float64]
ON_FRINGE = np.arccos(1.0 - 2.0 * 0.08)  # rad, within 8 % of the contrast from the darkest or the brightest
BESIDE = np.arccos(1.0 - 2.0 * 0.2)  # rad, 20 % from there the fringe has been left, whatever the noise


@dataclass(frozen=True)
class Phases:
    """The phases 4 pi n h/wavelength at which a rig reflects a given share: middle + spread and middle - spread.

    |top + w|^2 of a Moebius map of w = exp(i phase) is solved for the phase: A cos(phase) + B sin(phase) = E.
    """

    middle: Array
    spread: Array

    @classmethod
    def of(cls, reflectance: Array, rig: Rig, wavelength: float, index: Array) -> "Phases":
        """Of any shape.  A reflectance that the rig does not reach is taken as the nearest that it does."""
        top, second, ratio = rig.beams(wavelength, index)
        far = second - top * ratio  # r = (top + far z)/(1 - ratio z)
        coefficient = 2.0 * (np.conj(top) * far + reflectance * ratio)
        constant = reflectance * (1.0 + np.abs(ratio) ** 2) - np.abs(top) ** 2 - np.abs(far) ** 2
        share = np.clip(constant / np.abs(coefficient), -1.0, 1.0)
        return cls(-np.angle(coefficient), np.arccos(share))

    def at(self, points: slice, side: int, order: float) -> Array:
        """The phases of some points, on a side of the middle and of an order."""
        return self.middle[points] + side * self.spread[points] + 2.0 * np.pi * order


def film_of_intensity(
    intensity: ArrayLike,
    rig: Rig,
    wavelength: float,
    start: float,
    density: ArrayLike = 1.0,
    limits: tuple[float, float] | None = None,
) -> Array:
    """The film thickness along a profile of monochromatic intensity.

    Every intensity belongs to two phases in each period, exactly, with all beams of the rig.  The film begins with the
    phase nearest to `start`.  It passes to the other branch at every bright and dark fringe, that is where the
    intensity comes within 8 % of the contrast to the brightest or the darkest.  Where the intensity turns earlier, the
    film itself turns round, and stays on its branch.

    Parameters
    ----------
    intensity : array of shape (points,)
        Of fringes with full contrast (coherent light), in any unit; see `limits`.
    rig : Rig
        The layers.  With `TwoBeams` the profile is taken as a cosine.
    wavelength : float
        In m.
    start : float
        The film thickness at the first point (m), known to better than half the distance to the next possible film: an
        eighth of wavelength/n is enough half way between a bright and a dark fringe.
    density : array
        rho/rho0 of the oil along the profile; the index follows from it.
    limits : (float, float), optional
        Intensities of the darkest and the brightest fringe of oil at ambient pressure; left out: the intensity is the
        reflectance itself.

    Returns
    -------
    array of shape (points,)
        Film thickness (m).

    Raises ValueError if the profile is no row of finite numbers or begins on a bright or dark fringe.

    Limits: there must be eight points at least from a fringe to the next like it, and noise with a standard deviation
    of 1 % of the contrast at most.  Where the film turns round on a bright or dark fringe itself (within the 8 %), the
    two branches meet, and the way on cannot be told from the intensity; it is then taken to go on as before.  The same
    holds for a flat film of that thickness.  An error e of the intensity, as a share of the contrast, moves the film by
    about wavelength e/(2 pi n), and by wavelength sqrt(e)/(2 pi n) on a bright or dark fringe.
    """
    measured = np.asarray(intensity, dtype=float)
    if measured.ndim != 1 or len(measured) < 3 or not np.isfinite(measured).all():
        raise ValueError(
            f"intensity of shape {measured.shape}: must be a profile of at least 3 finite numbers; cut the gaps out"
        )
    index = np.broadcast_to(rig.index(density), measured.shape)
    reflectance = measured if limits is None else _calibrated(measured, rig, wavelength, limits)
    phases = Phases.of(reflectance, rig, wavelength, index)
    if _from_fringe(phases.spread)[0] < ON_FRINGE:
        raise ValueError(
            f"intensity[0] = {measured[0]:.4g}: is on a bright or dark fringe, where the film may grow or fall; "
            "begin the profile beside it"
        )
    length = wavelength / (4.0 * np.pi * index)  # m per radian
    return length * _unwrapped(phases, start / length[0])


def _calibrated(intensity: Array, rig: Rig, wavelength: float, limits: tuple[float, float]) -> Array:
    """The reflectance that belongs to an intensity between those of a dark and a bright fringe."""
    dark, bright = limits
    if not dark < bright:
        raise ValueError(
            f"limits = ({dark:g}, {bright:g}): the dark fringe must be darker than the bright one; swap them"
        )
    path = np.linspace(0.0, wavelength / 2.0, 2001)
    reflectance = rig.fringes(wavelength, rig.oil_index).reflectance(path)
    low, high = float(reflectance.min()), float(reflectance.max())
    return low + (intensity - dark) / (bright - dark) * (high - low)


def _from_fringe(spread: Array) -> Array:
    """How far the phase is from the nearest bright or dark fringe, in rad."""
    return np.minimum(spread, np.pi - spread)


def _unwrapped(phases: Phases, start: float) -> Array:
    """The phase along the profile: middle + side spread + 2 pi order, on one side between two fringes.

    start: the phase at the first point, about.
    """
    sides = np.array([-1, 1])
    first = phases.middle[0] + sides * phases.spread[0]
    orders = np.round((start - first) / (2.0 * np.pi))
    chosen = int(np.argmin(np.abs(first + 2.0 * np.pi * orders - start)))
    side, order, begin = int(sides[chosen]), float(orders[chosen]), 0
    phase = np.empty(len(phases.spread))
    for turn in _fringes_passed(phases.spread):
        phase[begin:turn] = phases.at(slice(begin, turn), side, order)
        order += side * (phases.spread[turn] > np.pi / 2)  # from pi on one side to pi on the other, a period on
        side, begin = -side, turn
    phase[begin:] = phases.at(slice(begin, None), side, order)
    return phase


def _fringes_passed(spread: Array) -> list[int]:
    """The first point behind every bright or dark fringe."""
    distance, passed, nearest = _from_fringe(spread), [], -1
    for point, here in enumerate(distance):
        if nearest >= 0 and here > BESIDE:
            passed.append(_behind(distance, nearest))
            nearest = -1
        elif here < (distance[nearest] if nearest >= 0 else ON_FRINGE):
            nearest = point
    return passed if nearest < 0 else [*passed, _behind(distance, nearest)]


def _behind(distance: Array, nearest: int) -> int:
    """Whether the point nearest to a fringe is behind it, or the next one is: so that the steps are more even."""
    if nearest + 1 >= len(distance):
        return nearest
    before, here, after = distance[nearest - 1 : nearest + 2]
    return nearest if abs(before - after - 2.0 * here) > abs(before - after + 2.0 * here) else nearest + 1
