"""The optical rig: light comes through coated glass and oil to a surface, and interferes with what came back earlier.

The layers are reduced by Fresnel's coefficients r_ij = (N_i - N_j)/(N_i + N_j) at normal incidence.  A reflection w
below an interface and a layer of thickness d is seen from above as

    (r_ij + w')/(1 + r_ij w'),    w' = w exp(2 i K N_j d),    K = 2 pi/wavelength.

This is a Moebius map of w, and a stack of layers is a product of such maps.  Seen from the glass, the oil film of
thickness h and index n over a surface that reflects r_s gives the reflection

    r = top + second z + second ratio z^2 + second ratio^2 z^3 + ...,    z = exp(2 i K n h):

the beam that turns back at the coatings, then those that went once, twice, ... through the film.  See Born M, Wolf E.
Principles of Optics, 7th ed, section 1.6; Foord CA, Wedeven LD, Westlake FJ, Cameron A. Optical elastohydrodynamics.
Proc Inst Mech Eng 1969;184:487-505.

Where the gap is not full, the oil is taken as a layer on the glass and the void as a layer of air below it, so that r_s
is the reflection of air and surface together.  The main fringes follow n h_oil + h_air whichever surface the oil is on.

A medium is a small frozen record; `index(wavelength)` gives n + ik at a wavelength in m, k > 0 where light is absorbed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from math import ceil, log, nan
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Complex = Any  # a complex array or scalar
Visibility = Callable[[Array], Array]  # the contrast of fringes, 1 to 0, at a path difference in m
OIL_INDEX = 1.48  # assumed: mineral oils have 1.47 to 1.49 at ambient pressure, squalane 1.45; better measure yours
CHROMIUM_THICKNESS = 8e-9  # m, half transparent; rigs have 5 to 20 nm
NEGLIGIBLE = 1e-6  # of the first beam through the film
AIR = 1.0  # index of what fills a gap beside the oil
PHASES = 32  # over a fringe of oil or of air
ORDERS = np.arange(PHASES) - PHASES // 2  # of these fringes
NM = 1e-9  # m
FOLDER = files("ertel.optics") / "data"


def metres(name: str, given: Any, least: float, most: float) -> float:
    """A length in m, given in m or as a quantity of pint.  Raises ValueError for anything else."""
    try:
        value = float(given.to("m").magnitude if hasattr(given, "magnitude") else given)
    except Exception:  # of pint, or because it is a text
        value = nan
    if not least <= value <= most:
        raise ValueError(f"{name} = {given}: must be a length from {least:g} to {most:g} m; plain numbers are metres")
    return value


# -- media ------------------------------------------------------------------------------------------------------------


class Medium(Protocol):
    """A refractive index: n + ik at a wavelength in m, of the wavelength's shape."""

    def index(self, wavelength: ArrayLike) -> NDArray[np.complex128]: ...


@dataclass(frozen=True)
class Constant:
    """The same index n + ik at all wavelengths."""

    n: float
    k: float = 0.0

    def index(self, wavelength: ArrayLike) -> NDArray[np.complex128]:
        """n + ik, of the shape of the wavelength."""
        return np.full(np.shape(wavelength), complex(self.n, self.k))


@dataclass(frozen=True)
class Sellmeier:
    """A transparent glass: n^2 = 1 + sum of B s/(s - C), s the square of the wavelength in um.

    B: dimensionless.  C: in um^2.
    """

    B: tuple[float, ...]
    C: tuple[float, ...]

    def index(self, wavelength: ArrayLike) -> NDArray[np.complex128]:
        """n at a wavelength in m, of its shape."""
        s = (np.asarray(wavelength, dtype=float) * 1e6) ** 2
        return np.sqrt(1.0 + sum(B * s / (s - C) for B, C in zip(self.B, self.C, strict=True))).astype(complex)


@dataclass(frozen=True)
class JohnsonChristy:
    """A metal of Johnson and Christy (1974), linear between their wavelengths.  metal: "Cr" or "Fe".

    Sources disagree on metals: Rakic (1998) has 2.88 + 4.22i for chromium at 546 nm, where this table has 3.15 + 3.33i.
    """

    metal: str

    def index(self, wavelength: ArrayLike) -> NDArray[np.complex128]:
        """n + ik at a wavelength in m, of its shape.  Raises ValueError outside 188 to 1937 nm."""
        rows, column = data_table("johnson_christy_1974.csv"), {"Cr": 1, "Fe": 3}[self.metal]
        table, n, k = rows[:, 0], rows[:, column], rows[:, column + 1]
        asked = np.asarray(wavelength, dtype=float) / NM
        if asked.size and not table[0] <= asked.min() <= asked.max() <= table[-1]:
            outside = asked.min() if asked.min() < table[0] else asked.max()
            raise ValueError(
                f"wavelength = {outside:.4g} nm: must be from {table[0]:g} to {table[-1]:g} nm, where Johnson and "
                f"Christy measured {self.metal}; give another medium"
            )
        return np.interp(asked, table, n) + 1j * np.interp(asked, table, k)


@cache
def data_table(name: str) -> NDArray[np.float64]:
    """A data file of this package by name: rows of numbers; the file names its source and its columns."""
    with (FOLDER / name).open(encoding="utf-8") as file:
        return np.loadtxt(file, delimiter=",")


CHROMIUM = JohnsonChristy("Cr")
STEEL = JohnsonChristy("Fe")  # iron stands for steel
# Schott N-BK7, data sheet of 2017, 300 to 2500 nm
BK7 = Sellmeier((1.03961212, 0.231792344, 1.01046945), (0.00600069867, 0.0200179144, 103.560653))
# Fused silica: Malitson IH. Interspecimen comparison of the refractive index of fused silica. J Opt Soc Am
# 1965;55:1205-1208, 210 to 3710 nm
SILICA = Sellmeier((0.6961663, 0.4079426, 0.8974794), (0.0684043**2, 0.1162414**2, 9.896161**2))


# -- layers -----------------------------------------------------------------------------------------------------------


Moebius = tuple[Complex, Complex, Complex, Complex]  # a, b, c, d of the map w -> (a w + b)/(c w + d)


def seen_through(indices: Sequence[Complex], thicknesses: Sequence[Complex], wavelength: ArrayLike) -> Moebius:
    """The view from the first medium of a reflection just below the last interface: the product of all maps.

    indices: n + ik of each medium, from the first through the layers to the last.  thicknesses: of the layers between
    them, in m; two fewer.  wavelength: in m.  All broadcast.
    """
    a, b, c, d = 1.0, 0.0, 0.0, 1.0
    for upper, lower, thickness in zip(indices[:-1], indices[1:], [*thicknesses, 0.0], strict=True):
        r = (upper - lower) / (upper + lower)
        turned = np.exp(4j * np.pi * lower * thickness / np.asarray(wavelength))
        a, b, c, d = (a + b * r) * turned, a * r + b, (c + d * r) * turned, c * r + d
    return a, b, c, d


def reflection(indices: Sequence[Complex], thicknesses: Sequence[Complex], wavelength: ArrayLike) -> Complex:
    """The reflected amplitude of any stack of layers at normal incidence; the arguments of `seen_through`.

    Returns
    -------
    complex array of the broadcast shape
        Its absolute square is the reflectance, at most 1 where the first medium is transparent.
    """
    _, b, _, d = seen_through(indices, thicknesses, wavelength)
    return b / d


def lorentz_lorenz(density: ArrayLike, n0: float = OIL_INDEX) -> Array:
    """The index of an oil that is compressed: (n^2 - 1)/(n^2 + 2) is in proportion to the density.

    density: rho/rho0, of any shape.  n0: index at ambient pressure.  Source: Born and Wolf, section 2.3.3.
    """
    share = np.asarray(density, dtype=float) * (n0**2 - 1.0) / (n0**2 + 2.0)
    return np.sqrt((1.0 + 2.0 * share) / (1.0 - share))


Beams = tuple[Complex, Complex, Complex]  # amplitudes: top, second, and their ratio from then on, see above


@dataclass(frozen=True)
class Fringes:
    """Reflectance over the film: mean + 2 Re sum over m of first ratio^(m-1) z^m V(m), z = exp(2 i K n h).

    V(m), the visibility, is 1 for coherent light.  It falls with the path difference of the m-th harmonic,
    m (2 n h + coatings), so that thick films are grey.

    Attributes
    ----------
    mean : array
        Reflectance without interference.
    first, ratio : complex arrays
        Of the harmonics.
    wavelength : array
        In m; it broadcasts with the others.
    coatings : array
        Optical path there and back through the coatings (m).
    """

    mean: Array
    first: Complex
    ratio: Complex
    wavelength: Array
    coatings: Array

    def reflectance(self, path: ArrayLike, visibility: Visibility | None = None) -> Array:
        """The reflected share of the light.

        path: n h in m, broadcasts with the fringes.  visibility: of coherent light if it is not given.
        """
        z = np.exp(4j * np.pi * np.asarray(path) / self.wavelength)
        if visibility is None:
            return self.mean + 2.0 * np.real(self.first * z / (1.0 - self.ratio * z))
        difference = 2.0 * np.asarray(path) + self.coatings
        wave, total = self.first * z, np.zeros(np.broadcast_shapes(np.shape(z), np.shape(self.mean)))
        largest = float(np.max(np.abs(self.ratio)))
        harmonics = 1 + (ceil(log(NEGLIGIBLE) / log(largest)) if largest > NEGLIGIBLE else 0)
        for harmonic in range(1, harmonics + 1):
            total += np.real(wave) * visibility(harmonic * difference)
            wave = wave * self.ratio * z
        return self.mean + 2.0 * total


@dataclass(frozen=True)
class Layer:
    """A coating.  thickness: in m."""

    medium: Medium
    thickness: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness", metres("thickness", self.thickness, 0.0, 1e-4))


COATINGS = (Layer(CHROMIUM, CHROMIUM_THICKNESS),)


@dataclass(frozen=True)
class Rig:
    """Glass with coatings, the oil film, and the other surface.

    Attributes
    ----------
    glass : Medium
        Where the light comes from.
    coatings : tuple of Layer
        On the glass, from the glass to the oil: chromium, and a spacer layer of silica if there is one.
    surface : Medium
        The other side of the film.
    oil_index : float
        Of the oil at ambient pressure, the same at all wavelengths.
    """

    glass: Medium = BK7
    coatings: tuple[Layer, ...] = COATINGS
    surface: Medium = STEEL
    oil_index: float = OIL_INDEX

    def __post_init__(self) -> None:
        if not 1.0 < self.oil_index < 3.0:
            raise ValueError(f"oil_index = {self.oil_index:g}: must be above 1 and below 3; oils have 1.4 to 1.7")

    def index(self, density: ArrayLike) -> Array:
        """The index of the oil at rho/rho0, of its shape, by `lorentz_lorenz`."""
        return lorentz_lorenz(density, self.oil_index)

    def beams(self, wavelength: ArrayLike, index: ArrayLike, below: Complex | None = None) -> Beams:
        """The beams that come back.

        wavelength: in m.  index: of the oil.  below: the reflection below the oil, of the surface if it is not given.
        They broadcast.
        """
        n = np.asarray(index)
        coatings = [layer.medium.index(wavelength) for layer in self.coatings]
        media = [self.glass.index(wavelength), *coatings, n]
        a, b, c, d = seen_through(media, [layer.thickness for layer in self.coatings], wavelength)
        if below is None:
            steel = self.surface.index(wavelength)
            below = (n - steel) / (n + steel)
        return b / d, below * (a * d - b * c) / d**2, -below * c / d

    def fringes(self, wavelength: ArrayLike, index: ArrayLike) -> Fringes:
        """The fringes of light of a wavelength (m) in oil of an index; they broadcast."""
        top, second, ratio = self.beams(wavelength, index)
        strength = np.abs(second) ** 2 / (1.0 - np.abs(ratio) ** 2)
        paths = [2.0 * layer.medium.index(wavelength).real * layer.thickness for layer in self.coatings]
        return Fringes(
            np.abs(top) ** 2 + strength,
            second * np.conj(top) + strength * ratio,
            ratio,
            np.asarray(wavelength, dtype=float),
            np.asarray(sum(paths, np.zeros(np.shape(wavelength)))),
        )

    def orders_beside_air(self, wavelength: float) -> NDArray[np.complex128]:
        """The orders c of the fringes of oil on the glass above a layer of air, both at ambient pressure.

        The reflectance is the sum of c[m, k] exp(2 i K (m n h_oil + k h_air)) over m and k of `ORDERS`.

        wavelength: in m.
        """
        share = np.arange(PHASES) / PHASES
        steel = self.surface.index(wavelength)
        below = reflection([self.oil_index, AIR, steel], [0.5 * wavelength * share], wavelength)
        top, second, ratio = self.beams(wavelength, self.oil_index, below)
        z = np.exp(2j * np.pi * share)[:, None]
        waves = np.exp(-2j * np.pi * ORDERS[:, None] * share) / PHASES
        return waves @ np.abs(top + second * z / (1.0 - ratio * z)) ** 2 @ waves.T


@dataclass(frozen=True)
class TwoBeams(Rig):
    """The same rig without the light that goes through the film more than once: I0 + I1 cos(4 pi n h/wavelength + phi).

    A film thickness that follows from this cosine, scaled between the darkest and the brightest fringe, is wrong by up
    to 11, 16, 20 nm with 5, 10, 15 nm of chromium in light of 550 nm.
    """

    def beams(self, wavelength: ArrayLike, index: ArrayLike, below: Complex | None = None) -> Beams:
        """The beam of the coatings and the first one through the film."""
        top, second, _ = super().beams(wavelength, index, below)
        return top, second, 0.0
