"""The light of an interferometer: of one wavelength, seen in grey, or white, seen in colour.

A light says how bright a film of a given thickness looks: `colours(rig, film, index)`, linear, 1 where everything is
reflected, with one channel or three.  Fringes fade with the path difference, because no light is of one wavelength.
"""

from dataclasses import dataclass
from math import log, pi, sqrt
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ertel.optics.colour import STEP, Daylight, Lamp, weights
from ertel.optics.rig import Rig, Visibility

Array = NDArray[np.float64]
GREEN = 532e-9  # m
COHERENCE = 20e-6  # m, of a lamp behind a filter that lets 10 nm pass
DAYLIGHT = Daylight()
EYE = 550e-9  # m, where the eye is most sensitive


class Light(Protocol):
    """What an interferometer is lit with.

    typical: the wavelength of its fringes (m).  reach: the optical path n h (m) beyond which nothing interferes.
    """

    @property
    def typical(self) -> float: ...
    @property
    def reach(self) -> float: ...
    def colours(self, rig: Rig, film: ArrayLike, index: ArrayLike) -> Array: ...
    def mean(self, rig: Rig, index: ArrayLike) -> Array: ...


@dataclass(frozen=True)
class Monochromatic:
    """Light of one wavelength with a Gaussian line.

    Attributes
    ----------
    wavelength : float
        In m; green light of 532 nm is usual, or red of 653 nm.
    coherence : float
        Coherence length in m, at which the contrast has fallen to exp(-pi/2) = 0.21; infinite for a laser.  A line of
        full width D at half maximum has 0.664 wavelength^2/D (Goodman JW. Statistical optics. Wiley; 1985, section
        5.1), see `of_width`.
    """

    wavelength: float = GREEN
    coherence: float = COHERENCE

    def __post_init__(self) -> None:
        if not 2e-7 <= self.wavelength <= 1e-5:
            raise ValueError(f"wavelength = {self.wavelength:g} m: must be from 2e-7 to 1e-5 m; give it in metres")
        if not self.coherence > 0.0:
            raise ValueError(f"coherence = {self.coherence:g} m: must be above 0; give math.inf for a laser")

    @classmethod
    def of_width(cls, wavelength: float, width: float) -> "Monochromatic":
        """Light behind a filter of a full width at half maximum; both in m."""
        return cls(wavelength, sqrt(2.0 * log(2.0) / pi) * wavelength**2 / width)

    @property
    def typical(self) -> float:
        return self.wavelength

    @property
    def reach(self) -> float:
        return 2.0 * self.coherence  # four coherence lengths there and back: exp(-8 pi)

    def visibility(self, difference: Array) -> Array:
        """The contrast of fringes at a path difference in m, of its shape."""
        return np.exp(-0.5 * pi * (difference / self.coherence) ** 2)

    def colours(self, rig: Rig, film: ArrayLike, index: ArrayLike) -> Array:
        """The reflected share, of the broadcast shape of film (m) and index of the oil with a last axis of 1."""
        path = np.asarray(film) * np.asarray(index)
        return rig.fringes(self.wavelength, index).reflectance(path, self.visibility)[..., None]

    def mean(self, rig: Rig, index: ArrayLike) -> Array:
        """What is seen where fringes have faded, of the shape of the index with a last axis of 1."""
        return rig.fringes(self.wavelength, index).mean[..., None]


@dataclass(frozen=True)
class White:
    """White light as a person sees it, in linear sRGB, adapted to the lamp.

    The spectrum is linear between the wavelengths of the CIE's tables, every 5 nm, and the fringes are integrated over
    it in closed form: each wavelength is a triangular line 10 nm wide, whose contrast falls as a squared sinc.  So
    thick films are grey and need no finer wavelengths.
    """

    lamp: Lamp = DAYLIGHT

    @property
    def typical(self) -> float:
        return EYE

    @property
    def reach(self) -> float:
        return 50e-6  # the lines of 10 nm reach that far at the red end

    def colours(self, rig: Rig, film: ArrayLike, index: ArrayLike) -> Array:
        """Linear sRGB, of the broadcast shape of film (m) and index of the oil with a last axis of 3.

        Components may be negative: colours that no screen shows, see `colour.into_gamut`.
        """
        path = np.asarray(film) * np.asarray(index)
        shape = np.broadcast_shapes(path.shape, np.shape(index))
        found = np.zeros((*shape, 3))
        for wavelength, weight in zip(*weights(self.lamp), strict=True):
            bright = rig.fringes(wavelength, index).reflectance(path, _triangular(wavelength))
            found += bright[..., None] * weight
        return found

    def mean(self, rig: Rig, index: ArrayLike) -> Array:
        """What is seen where fringes have faded, of the shape of the index with a last axis of 3."""
        wavelengths, weight = weights(self.lamp)
        return rig.fringes(wavelengths, np.asarray(index)[..., None]).mean @ weight


def _triangular(wavelength: float) -> Visibility:
    """The contrast of fringes in a line that falls to zero at the next wavelengths of the table."""

    def visibility(difference: Array) -> Array:
        contrast: Array = np.sinc(difference * STEP / wavelength**2) ** 2
        return contrast

    return visibility
