"""Back from fringes to films: the film along a profile of intensity, by unwrapping its phase."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ertel.physics.optics.rig import Rig

Array = NDArray[np.float64]
FLAT = 0.02  # of the contrast: nearer to an extreme the direction of the film cannot be told


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
    phase nearest to `start`, and continues from point to point with the phase nearest to the straight continuation of
    the last two.  So it passes from the one branch to the other at bright and dark fringes, and stays on its branch
    where the film itself turns between them.

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

    Limits: at least eight points from a fringe to the next like it.  Where the film turns round on a bright or dark
    fringe itself, within about 2 % of the contrast, the two branches meet, and the way on cannot be told from the
    intensity; the same holds for noise on a flat film there.  Steps of more than a quarter of wavelength/n between two
    points lose the count.  An error e of the intensity, as a share of the contrast, moves the film by
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
    if min(phases.spread[0], np.pi - phases.spread[0]) < np.arccos(1.0 - 2.0 * FLAT):
        raise ValueError(
            f"intensity[0] = {measured[0]:.4g}: is on a bright or dark fringe, where the film may grow or fall; "
            "begin the profile beside it"
        )
    return _follow(phases, wavelength / (4.0 * np.pi * index), start)


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


def _follow(phases: Phases, length: Array, start: float) -> Array:
    """The films of the phases, each the nearest to the continuation of the last two.  length: m per radian, points."""
    film = np.empty(len(length))
    expected = start
    for point in range(len(length)):
        films = length[point] * (phases.middle[point] + phases.spread[point] * np.array([-1.0, 1.0]))
        period = 2.0 * np.pi * length[point]
        films += period * np.round((expected - films) / period)
        film[point] = films[np.argmin(np.abs(films - expected))]
        expected = 2.0 * film[point] - film[point - 1] if point else film[0]
    return film
