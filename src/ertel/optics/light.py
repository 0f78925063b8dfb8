"""The light of an interferometer and its colours: lamps, spectra to linear sRGB, and what a film looks like.

A light says how bright a film of a given thickness looks: `colours(rig, film, index)`, linear, 1 where everything is
reflected, with one channel or three.  Fringes fade with the path difference, because no light is of one wavelength.

Spectra are summed with the CIE 1931 functions of the 2 degree observer every 5 nm.  sRGB is that of IEC 61966-2-1.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from math import inf, log, pi, sqrt
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ertel.optics.rig import NM, ORDERS, Rig, Visibility, data_table, metres

Array = NDArray[np.float64]
GREEN = 532e-9  # m
COHERENCE = 20e-6  # m, of a lamp behind a filter that lets 10 nm pass
EYE = 550e-9  # m, where the eye is most sensitive
STEP = 5e-9  # m, between the wavelengths of the table
TO_SRGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])  # of X, Y, Z
WHITE = np.array([0.9505, 1.0, 1.0890])  # X, Y, Z of sRGB 1, 1, 1
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # Y of linear sRGB
SECOND_RADIATION = 1.438776877e-2  # m K, hc/k: CODATA 2018


# -- lamps and colours ------------------------------------------------------------------------------------------------


class Lamp(Protocol):
    """Relative spectral power at wavelengths in m, of their shape."""

    def power(self, wavelength: Array) -> Array: ...


@dataclass(frozen=True)
class Daylight:
    """The standard illuminant D65, zero outside 380 to 780 nm."""

    def power(self, wavelength: Array) -> Array:
        """Relative power, 100 at 560 nm."""
        rows = data_table("cie_1931_d65.csv")
        return np.interp(np.asarray(wavelength) / NM, rows[:, 0], rows[:, 4], left=0.0, right=0.0)


@dataclass(frozen=True)
class BlackBody:
    """A glowing filament by Planck's law.  temperature: in K; a halogen lamp has about 3200 K."""

    temperature: float

    def power(self, wavelength: Array) -> Array:
        """Relative power per wavelength, 1 at 560 nm."""
        share, exponent = np.asarray(wavelength) / (560 * NM), SECOND_RADIATION / (560 * NM * self.temperature)
        return share**-5.0 * np.expm1(exponent) / np.expm1(exponent / share)


def observer() -> tuple[Array, Array]:
    """Wavelengths in m, every 5 nm, and the colour-matching functions X, Y, Z at them, of shape (81, 3)."""
    rows = data_table("cie_1931_d65.csv")
    return rows[:, 0] * NM, rows[:, 1:4]


def weights(lamp: Lamp) -> tuple[Array, Array]:
    """The share of each wavelength of a lamp in linear sRGB, for an eye that has adapted to the lamp.

    X, Y and Z are divided by those of the lamp itself, so that a surface that reflects everything is white (1, 1, 1)
    under any lamp: the sum over the wavelengths is 1 in each channel, to the four digits of sRGB's matrix.  The
    wavelengths (m) have the shape (81,), the weights (81, 3).
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
    return np.clip(grey + np.minimum(room.min(axis=-1, keepdims=True), 1.0) * excess, 0.0, 1.0)


def encode(linear: ArrayLike) -> Array:
    """The values that a screen is sent for linear light of 0 to 1, by the curve of sRGB; of the same shape."""
    light = np.asarray(linear, dtype=float)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055)


# -- lights -----------------------------------------------------------------------------------------------------------


class Line(NamedTuple):
    """A spectral line.  wavelength: in m.  weight: in each channel.  visibility: of its fringes."""

    wavelength: float
    weight: Array
    visibility: Visibility


class Light(Protocol):
    """The light of an interferometer, as a sum of lines; a light inherits from this.

    typical: the wavelength of its fringes (m).  reach: the optical path n h (m) beyond which nothing interferes.
    """

    @property
    def typical(self) -> float: ...
    @property
    def reach(self) -> float: ...
    @property
    def lines(self) -> Sequence[Line]: ...

    def colours(self, rig: Rig, film: ArrayLike, index: ArrayLike) -> Array:
        """Linear light, of the broadcast shape of film (m) and index of the oil with a last axis of the channels.

        Components of sRGB may be negative: colours that no screen shows, see `into_gamut`.
        """
        path = np.asarray(film) * np.asarray(index)
        return self._sum(lambda line: rig.fringes(line.wavelength, index).reflectance(path, line.visibility))

    def mean(self, rig: Rig, index: ArrayLike) -> Array:
        """The mean where fringes have faded, of the shape of the index with a last axis of the channels."""
        return self._sum(lambda line: rig.fringes(line.wavelength, index).mean)

    def _sum(self, bright: Callable[[Line], Array]) -> Array:
        return sum((bright(line)[..., None] * line.weight for line in self.lines), np.zeros(()))


@dataclass(frozen=True)
class Monochromatic(Light):
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
        object.__setattr__(self, "wavelength", metres("wavelength", self.wavelength, 2e-7, 1e-5))
        object.__setattr__(self, "coherence", metres("coherence", self.coherence, 1e-9, inf))  # of a laser: inf

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

    @property
    def lines(self) -> Sequence[Line]:
        return [Line(self.wavelength, np.ones(1), self.visibility)]


@dataclass(frozen=True)
class White(Light):
    """White light as a person sees it, in linear sRGB, adapted to the lamp.

    The spectrum is linear between the wavelengths of the CIE's tables, every 5 nm, and the fringes are integrated over
    it in closed form: each wavelength is a triangular line 10 nm wide, whose contrast falls as a squared sinc.  So
    thick films are grey and need no finer wavelengths.
    """

    lamp: Lamp = Daylight()
    typical: ClassVar[float] = EYE
    reach: ClassVar[float] = 50e-6  # the lines of 10 nm reach that far at the red end

    @property
    def lines(self) -> Sequence[Line]:
        return [Line(w, weight, partial(_triangular, w)) for w, weight in zip(*weights(self.lamp), strict=True)]


def _triangular(wavelength: float, difference: Array) -> Array:
    """The contrast of fringes in a line that falls to zero at the next wavelengths of the table."""
    return np.sinc(difference * STEP / wavelength**2) ** 2


# -- the colour chart of a rig and a light, and the picture of a film that follows from it -----------------------------

SPACING = 4e-9  # m of the optical path n h between two colours of the chart
INDICES = 5  # of the oil: at the same path the colours hardly change with it
FAINT = 3e-4  # share of the light: fainter orders of fringes beside air are left out
BLUR = 0.8  # pixels: the standard deviation of a microscope's own blur


def _between(table: Array, row: Array, column: Array) -> Array:
    """Entries of a table (rows, columns, channels) at places between them; beyond it those at its edge."""
    from scipy.ndimage import map_coordinates  # here: it takes long to import

    places, channels = np.array([row.ravel(), column.ravel()]), np.moveaxis(table, -1, 0)
    found = np.stack([map_coordinates(each, places, order=1, mode="nearest") for each in channels], axis=-1)
    return found.reshape(*row.shape, -1)


@dataclass(frozen=True)
class Chart:
    """The colours of films, computed once for many pictures.

    Attributes
    ----------
    rig, light : Rig, Light
        The layers, and what they are lit with.
    thickest : float
        The largest gap of the pictures (m); a thicker one has its colour.
    density : float
        The largest rho/rho0 of the pictures.
    """

    rig: Rig
    light: Light
    thickest: float
    density: float = 1.0

    @cached_property
    def _indices(self) -> Array:
        return np.linspace(self.rig.oil_index, float(self.rig.index(max(self.density, 1.0))) + 1e-6, INDICES)

    @cached_property
    def _colours(self) -> Array:
        """Linear colours over path and index, (paths, INDICES, channels)."""
        end = min(self.thickest * self._indices[-1], self.light.reach)
        path = SPACING * np.arange(int(end / SPACING) + 2)[:, None]
        return self.light.colours(self.rig, path / self._indices, self._indices)

    @cached_property
    def exposure(self) -> float:
        """The factor of linear light with which the brightest film between 0 and 1 um is as bright as white."""
        light = self.light.colours(self.rig, np.arange(0.0, 1e-6, SPACING), self._indices[0])
        return 1.0 / float(np.max(light @ LUMINANCE if light.shape[-1] == 3 else light))

    @cached_property
    def _beside_air(self) -> list[tuple[int, int, Array]]:
        """The orders m of the oil and k of the air, and their linear light over the path m n h_oil + k h_air.

        The light has the shape (channels, paths); paths from -x to x in steps of SPACING.
        """
        lines, n = self.light.lines, self.rig.oil_index
        of_lines = np.array([self.rig.orders_beside_air(line.wavelength) for line in lines])
        bright = (np.abs(of_lines).max(axis=0) > FAINT) & (ORDERS[:, None] >= 0)
        oil, air = (ORDERS[each] for each in np.nonzero(bright))
        shares = of_lines[:, bright] * np.where(oil > 0, 2.0, 1.0)  # those of -m, -k are conjugate
        end = min(float((n * oil + np.abs(air)).max()) * self.thickest, self.light.reach)
        path = SPACING * np.arange(-int(end / SPACING) - 1, int(end / SPACING) + 2)
        light: Array = np.zeros(())
        for line, share in zip(lines, shares, strict=True):
            wave = np.exp(4j * np.pi * path / line.wavelength)
            contrast = line.visibility(2.0 * path + oil[:, None] * self.rig.fringes(line.wavelength, n).coatings)
            light = light + (np.real(share[:, None] * wave) * contrast)[:, None] * line.weight[:, None]
        return list(zip(oil.tolist(), air.tolist(), light, strict=True))

    def _above_air(self, path: Array, air: Array, change: Array, air_change: Array) -> Array:
        """Linear light of oil above layers of air (m), where `path` is that through both; 1-D arrays, see `linear`."""
        light: Array = np.zeros(())
        for m, k, channels in self._beside_air:
            place = (m * path + (k - m) * air) / SPACING + channels.shape[1] // 2
            order = [np.interp(place, np.arange(channels.shape[1]), channel) for channel in channels]
            light = light + np.stack(order, axis=-1) * self._fading(m * change + (k - m) * air_change)
        return light

    def _fading(self, change: ArrayLike) -> Array:
        """The contrast that pixels leave of fringes whose path changes so much, with a last axis of 1."""
        wave: Array = 4.0 * np.pi * BLUR * np.hypot(np.real(change), np.imag(change))[..., None] / self.light.typical
        return np.exp(-0.5 * wave**2)

    def linear(
        self,
        film: ArrayLike,
        density: ArrayLike,
        change: ArrayLike = 0.0,
        void: ArrayLike = 0.0,
        void_change: ArrayLike = 0.0,
    ) -> Array:
        """Linear light of films, 1 where everything is reflected.

        Parameters
        ----------
        film, density : arrays that broadcast
            Thickness of the gap (m) and rho/rho0 of the oil in it.
        change : array
            How much the optical path changes from a pixel to the next (m), as a complex number down and across.
            Fringes as fine as the pixels fade to the mean, and make no rings that are not there.
        void, void_change : arrays
            The part of the gap that is not filled (m), and its change: a layer of air between the other surface and
            the oil, which is on the glass at ambient pressure.

        Returns
        -------
        array of the broadcast shape and (channels,)
        """
        n = self.rig.index(density)
        film, n = np.broadcast_arrays(np.asarray(film, dtype=float), n)
        first, last = self._indices[0], self._indices[-1]
        seen = _between(self._colours, film * n / SPACING, (n - first) / (last - first) * (INDICES - 1))
        means = self.light.mean(self.rig, self._indices)  # of films without fringes
        mean: Array = np.stack([np.interp(n, self._indices, channel) for channel in means.T], axis=-1)
        light: Array = mean + (seen - mean) * self._fading(change)
        air, *changes = (np.broadcast_to(each, film.shape) for each in (void, change, void_change))
        if np.any(partly := air > 0.0):
            path = (film - air) * self.rig.oil_index + air
            light[partly] = self._above_air(*(each[partly] for each in (path, air, *changes)))
        return light

    def shown(self, film: ArrayLike, density: ArrayLike, *others: ArrayLike, **named: ArrayLike) -> Array:
        """The values for a screen, 0 to 1, in grey or sRGB: the arguments and the shape of `linear`."""
        light = self.exposure * self.linear(film, density, *others, **named)
        return encode(into_gamut(light) if light.shape[-1] == 3 else np.clip(light, 0.0, 1.0))

    def picture(self, film: Array, density: Array, void: ArrayLike = 0.0) -> Array:
        """The picture of a map of films whose nodes are its pixels: `shown` with the change between pixels.

        film, density, void : arrays of shape (rows, columns), two of each at least.
        """
        void = np.broadcast_to(void, film.shape)
        path = (film - void) * self.rig.index(density) + void
        down, across = np.gradient(np.array([path, void]), axis=(1, 2))
        change, void_change = down + 1j * across
        return self.shown(film, density, change, void, void_change)


@dataclass(frozen=True)
class Interferometer:
    """A rig and its light before a detector of intensity.

    Attributes
    ----------
    rig, light : Rig, Light
        The layers, and what they are lit with.
    """

    rig: Rig = field(default_factory=Rig)
    light: Light = field(default_factory=Monochromatic)

    def intensity(self, film: Array, density: Array, void: ArrayLike = 0.0) -> Array:
        """The share of the light that comes back, of white light its luminance.

        film, density, void : as of `Chart.linear`; of the shape of the film.
        """
        chart = Chart(self.rig, self.light, float(np.max(film)), float(np.max(density)))
        light = chart.linear(film, density, void=void)
        return light @ LUMINANCE if light.shape[-1] == 3 else light[..., 0]
