"""Colours as a person and a screen have them: spectra to linear sRGB, gamut and coding.

Spectra are summed with the CIE 1931 functions of the 2 degree observer every 5 nm.  sRGB is that of IEC 61966-2-1.
"""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ertel.optics.media import NM, table

Array = NDArray[np.float64]
STEP = 5e-9  # m, between the wavelengths of the table
TO_SRGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])  # of X, Y, Z
WHITE = np.array([0.9505, 1.0, 1.0890])  # X, Y, Z of sRGB 1, 1, 1
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # Y of linear sRGB
SECOND_RADIATION = 1.438776877e-2  # m K, hc/k: CODATA 2018


class Lamp(Protocol):
    """Relative spectral power at wavelengths in m, of their shape."""

    def power(self, wavelength: Array) -> Array: ...


@dataclass(frozen=True)
class Daylight:
    """The standard illuminant D65, zero outside 380 to 780 nm."""

    def power(self, wavelength: Array) -> Array:
        """Relative power, 100 at 560 nm."""
        rows = table("cie_1931_d65.csv")
        return np.interp(np.asarray(wavelength) / NM, rows[:, 0], rows[:, 4], left=0.0, right=0.0)


@dataclass(frozen=True)
class BlackBody:
    """A glowing filament by Planck's law.  temperature: in K; a halogen lamp has about 3200 K."""

    temperature: float

    def power(self, wavelength: Array) -> Array:
        """Relative power per wavelength, 1 at 560 nm."""
        return self._planck(np.asarray(wavelength)) / self._planck(np.asarray(560 * NM))

    def _planck(self, wavelength: Array) -> Array:
        share = wavelength / (560 * NM)
        return share**-5.0 / np.expm1(SECOND_RADIATION / (wavelength * self.temperature))


def observer() -> tuple[Array, Array]:
    """Wavelengths in m, every 5 nm, and the colour-matching functions X, Y, Z at them, of shape (81, 3)."""
    rows = table("cie_1931_d65.csv")
    return rows[:, 0] * NM, rows[:, 1:4]


def weights(lamp: Lamp) -> tuple[Array, Array]:
    """How much each wavelength of a lamp adds to linear sRGB, for an eye that has adapted to the lamp.

    X, Y and Z are divided by those of the lamp itself, so that a surface that reflects everything is white (1, 1, 1)
    under any lamp.

    Returns
    -------
    wavelengths : array of shape (81,)
        In m.
    weights : array of shape (81, 3)
        Their sum over the wavelengths is 1 in each channel, to the four digits of sRGB's matrix.
    """
    wavelengths, functions = observer()
    seen = lamp.power(wavelengths)[:, None] * functions
    return wavelengths, (seen / seen.sum(axis=0) * WHITE) @ TO_SRGB.T


def into_gamut(linear: ArrayLike) -> Array:
    """Linear sRGB without components below 0 or above 1.

    A colour that a screen cannot show is mixed with the grey of its own luminance, just enough: it keeps brightness and
    hue, and loses saturation.  A luminance above 1 is white.

    linear : array of shape (..., 3).
    """
    colours = np.asarray(linear, dtype=float)
    grey = np.clip(colours @ LUMINANCE, 0.0, 1.0)[..., None]
    excess = colours - grey
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(excess > 0.0, (1.0 - grey) / excess, np.where(excess < 0.0, -grey / excess, np.inf))
    inside: Array = np.clip(grey + np.minimum(room.min(axis=-1, keepdims=True), 1.0) * excess, 0.0, 1.0)
    return inside


def encode(linear: ArrayLike) -> Array:
    """The values that a screen is sent for linear light of 0 to 1, by the curve of sRGB; of the same shape."""
    light = np.asarray(linear, dtype=float)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055)


def luminance(linear: ArrayLike) -> Any:
    """The luminance of linear light (..., channels): of sRGB with three channels, of grey with one."""
    light = np.asarray(linear, dtype=float)
    return light @ LUMINANCE if light.shape[-1] == 3 else light[..., 0]
