"""Back from fringes to films: the film along a profile of intensity, by unwrapping its phase."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ertel.physics.optics.rig import Rig

Array = NDArray[np.float64]
BESIDE, ON_FRINGE = 0.93, 0.57  # rad from the brightest or the darkest phase: 20 % and 8 % of the contrast
ENOUGH = 15  # points beside a fringe from which the way of the phase is told
CLEARLY = 1.3  # times as smooth is the way of a film that turns on a fringe as that of one that goes on


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
        first = coefficient.flat[0]  # the middle hardly changes along a profile, and must not jump by a period
        return cls(-np.angle(first) - np.angle(coefficient / first), np.arccos(share))

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
    phase nearest to `start`.  At every bright or dark fringe it passes to the other branch; or, where that makes the
    phase smoother, it turns and stays on its branch, or passes, turns and passes back.  Where the intensity turns away
    from fringes, the film itself turns.

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
    of 1 % of the contrast at most.  With so much noise about one film in ten that turns on a fringe itself is taken to
    go on, and is wrong from there; with 0.3 % none is.  A film that lies flat on a fringe does not tell its way.  An
    error e of the intensity, as a share of the contrast, moves the film by about wavelength e/(2 pi n), and by
    wavelength sqrt(e)/(2 pi n) on a bright or dark fringe.
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
    """The first point behind every bright or dark fringe that the film passes."""
    distance, passed = _from_fringe(spread), []
    near = np.flatnonzero(np.diff(np.concatenate([[False], distance < BESIDE, [False]])))  # begin, end, begin, ...
    for begin, end in near.reshape(-1, 2):
        if distance[begin:end].min() < ON_FRINGE:
            passed += _passages(distance, begin, end)
    return passed


def _passages(distance: Array, begin: int, end: int) -> list[int]:
    """The points behind one fringe, near it: one, none where the film turns, or two where it comes back."""
    once = [_behind(distance, begin, end)]
    if end - begin < ENOUGH:
        return once
    on = begin + np.flatnonzero(distance[begin:end] < ON_FRINGE)
    middle = max(on[0] + int(distance[on[0] : on[-1] + 1].argmax()), begin + 1)
    twice = [_behind(distance, begin, middle), _behind(distance, middle, end)]
    back = min([], twice, key=lambda passed: _roughness(distance, begin, end, passed))
    clearly = CLEARLY * _roughness(distance, begin, end, back) < _roughness(distance, begin, end, once)
    return back if clearly else once


def _behind(distance: Array, begin: int, end: int) -> int:
    """The first point behind the fringe: the nearest to it, or the next, so that the steps are more even."""
    nearest = begin + int(distance[begin:end].argmin())
    if not 0 < nearest < len(distance) - 1:
        return nearest
    uneven = distance[nearest - 1] - distance[nearest + 1]
    return nearest if abs(uneven + 2.0 * distance[nearest]) < abs(uneven - 2.0 * distance[nearest]) else nearest + 1


def _roughness(distance: Array, begin: int, end: int, passed: list[int]) -> float:
    """How far the phase is from a parabola, as the intensity shows it."""
    points, way = np.arange(begin, end), distance[begin:end].copy()
    for point in passed:
        way[points >= point] *= -1.0
    parabola = np.polynomial.Polynomial.fit(points, way, 2, w=np.maximum(np.sin(distance[begin:end]), 0.1))
    return float(np.sum((np.cos(way) - np.cos(parabola(points))) ** 2))
