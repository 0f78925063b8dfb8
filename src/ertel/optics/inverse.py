"""Back from fringes to films: the film along a profile of intensity, by unwrapping its phase."""

import warnings

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ertel.optics.fringe_orders import Nodes, likeliest, phase_on
from ertel.optics.rig import Rig

Array = NDArray[np.float64]
ON_FRINGE = 0.57  # rad from the brightest or the darkest phase: 8 % of the contrast
CERTAIN = 10.0  # log of the odds from which on a film is not doubtful: high, because a film is not a random walk


class DoubtfulFilm(UserWarning):
    """Another film is nearly as likely at some points.

    Attributes
    ----------
    points : array of bool
        Where, along the profile.
    odds : float
        Log of how much likelier the film is than the other one where that is least.
    """

    def __init__(self, points: NDArray[np.bool_], odds: float):
        where = np.flatnonzero(points)
        super().__init__(
            f"the film is doubtful at {len(where)} of {len(points)} points, from {where[0]} to {where[-1]}: another "
            f"film, that turns where this one passes a fringe or the reverse, is only {np.exp(odds):.0f} times less "
            "likely (four of five films with this warning are right); compare with a profile that crosses this one"
        )
        self.points, self.odds = points, odds


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
    phase nearest to `start`.  At every bright or dark fringe it passes to the other branch, or turns and stays on its
    branch: the smooth film that is the likeliest with the noise of the profile, see `fringe_orders`.

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

    Raises
    ------
    ValueError
        The profile is not a row of finite numbers, or begins on a bright or dark fringe.

    Warns
    -----
    DoubtfulFilm
        Another film is nearly as likely; the warning says where.

    Notes
    -----
    Limits: there must be eight points at least from a fringe to the next like it.  A film that lies flat on a fringe,
    or has a kink there, does not tell its way.  Of 500 made films balls, wedges and dimples were all right, and a
    quarter of the wavy and kinked ones was wrong; 94 of 100 films without a warning were right, and 81 of 100 with one
    (`validation/optics`).  An error e of the intensity, as
    a share of the contrast, moves the film by about wavelength e/(2 pi n), and by wavelength sqrt(e)/(2 pi n) on a
    bright or dark fringe.
    """
    measured = np.asarray(intensity, dtype=float)
    if measured.ndim != 1 or len(measured) < 3 or not np.isfinite(measured).all():
        raise ValueError(
            f"intensity of shape {measured.shape}: must be a profile of at least 3 finite numbers; cut the gaps out"
        )
    index = np.broadcast_to(rig.index(density), measured.shape)
    reflectance = measured if limits is None else _calibrated(measured, rig, wavelength, limits)
    middle, cosine, weight = _phases(reflectance, rig, wavelength, index)
    nodes = Nodes.of(cosine, weight)
    if 1.0 - abs(nodes.cosine[0]) - 1.5 * nodes.noise[0] < 1.0 - np.cos(ON_FRINGE):
        raise ValueError(
            f"intensity[0] = {measured[0]:.4g}: is on a bright or dark fringe, or no further from it than the noise, "
            "where the film may grow or fall; begin the profile beside it"
        )
    length = wavelength / (4.0 * np.pi * index)  # m per radian
    return length * _unwrapped(middle, cosine, nodes, start / length[0])


def _phases(reflectance: Array, rig: Rig, wavelength: float, index: Array) -> tuple[Array, Array, Array]:
    """The phases 4 pi n h/wavelength at which a rig reflects a given share: middle + spread and middle - spread.

    |top + w|^2 of a Moebius map of w = exp(i phase) is solved for the phase: A cos(phase) + B sin(phase) = E.  They are
    the middle, the cosine of the spread, beyond -1 and 1 where the rig does not reach the reflectance, and the weight
    of its errors, so that they are those of the reflectance, up to a factor.
    """
    top, second, ratio = rig.beams(wavelength, index)
    far = second - top * ratio  # r = (top + far z)/(1 - ratio z)
    coefficient = 2.0 * (np.conj(top) * far + reflectance * ratio)
    constant = reflectance * (1.0 + np.abs(ratio) ** 2) - np.abs(top) ** 2 - np.abs(far) ** 2
    size = np.abs(coefficient)
    cosine = constant / size
    slope = (1.0 + np.abs(ratio) ** 2 - 2.0 * cosine * np.real(np.conj(coefficient) * ratio) / size) / size
    first = coefficient.flat[0]  # the middle hardly changes along a profile, and must not jump by a period
    return -np.angle(first) - np.angle(coefficient / first), cosine, np.mean(slope) / slope


def _calibrated(intensity: Array, rig: Rig, wavelength: float, limits: tuple[float, float]) -> Array:
    """The reflectance that belongs to an intensity between those of a dark and a bright fringe."""
    dark, bright = limits
    if not dark < bright:
        raise ValueError(f"limits = ({dark:g}, {bright:g}): the dark fringe must be darker than the bright one")
    path = np.linspace(0.0, wavelength / 2.0, 2001)
    reflectance = rig.fringes(wavelength, rig.oil_index).reflectance(path)
    low, high = float(reflectance.min()), float(reflectance.max())
    return low + (intensity - dark) / (bright - dark) * (high - low)


def _unwrapped(middle: Array, cosine: Array, nodes: Nodes, start: float) -> Array:
    """The phase along the profile.  start: the phase at the first point, about.  Warns as `film_of_intensity`."""
    spread = np.arccos(np.clip(cosine, -1.0, 1.0))
    orders = 2 * np.round(0.5 * (start - middle[0]) / np.pi).astype(int) + np.arange(-2, 3)
    nearest = int(orders[np.argmin(np.abs(middle[0] + phase_on(orders, spread[0]) - start))])
    branch, odds = likeliest(nodes, cosine, nearest)
    if (doubtful := odds < CERTAIN).any():
        warnings.warn(DoubtfulFilm(doubtful, float(odds.min())), stacklevel=3)
    return middle + phase_on(branch, spread)
