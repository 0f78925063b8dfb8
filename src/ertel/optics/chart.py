"""The colour chart of a rig and a light, and the picture of a film that follows from it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import map_coordinates

from ertel.optics.light import Light, encode, into_gamut, luminance
from ertel.optics.rig import Rig

Array = NDArray[np.float64]
SPACING = 4e-9  # m of the optical path n h between two colours of the chart
INDICES = 5  # of the oil: at the same path the colours hardly change with it
BLUR = 0.8  # pixels: the standard deviation of a microscope's own blur


@dataclass(frozen=True)
class Chart:
    """The colours of films, computed once for many pictures.

    Attributes
    ----------
    rig, light : Rig, Light
        The layers, and what they are lit with.
    thickest : float
        The largest film of the pictures (m); a thicker one has its colour.
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
        film = np.arange(0.0, 1e-6, SPACING)
        return 1.0 / float(np.max(luminance(self.light.colours(self.rig, film, np.full(film.shape, self._indices[0])))))

    def linear(self, film: ArrayLike, density: ArrayLike, change: ArrayLike = 0.0) -> Array:
        """Linear light of films, 1 where everything is reflected.

        Parameters
        ----------
        film, density : arrays that broadcast
            Film thickness (m) and rho/rho0 of the oil in it.
        change : array
            How much n h changes from a pixel to the next (m).  Fringes as fine as the pixels fade to the mean, and
            make no rings that are not there.

        Returns
        -------
        array of the broadcast shape and (channels,)
        """
        n = self.rig.index(density)
        film, n = np.broadcast_arrays(np.asarray(film, dtype=float), n)
        first, last = self._indices[0], self._indices[-1]
        places = [film * n / SPACING, (n - first) / (last - first) * (INDICES - 1)]
        channels = np.moveaxis(self._colours, -1, 0)
        seen = np.stack([map_coordinates(c, places, order=1, mode="nearest") for c in channels], axis=-1)
        means = self.light.mean(self.rig, self._indices)  # of films without fringes
        mean: Array = np.stack([np.interp(n, self._indices, channel) for channel in means.T], axis=-1)
        wave = 4.0 * np.pi * BLUR * np.asarray(change)[..., None] / self.light.typical
        return mean + (seen - mean) * np.exp(-0.5 * wave**2)

    def shown(self, film: ArrayLike, density: ArrayLike, change: ArrayLike = 0.0) -> Array:
        """The values for a screen, 0 to 1, in grey or sRGB: the arguments and the shape of `linear`."""
        light = self.exposure * self.linear(film, density, change)
        return encode(into_gamut(light) if light.shape[-1] == 3 else np.clip(light, 0.0, 1.0))

    def picture(self, film: Array, density: Array) -> Array:
        """The picture of a map of films whose nodes are its pixels: `shown` with the change between pixels.

        film, density : arrays of shape (rows, columns), two of each at least.
        """
        down, across = np.gradient(film * self.rig.index(density))
        return self.shown(film, density, np.hypot(down, across))
