"""Refractive indices of the media of an optical rig, n + ik over the wavelength.

A medium is a small frozen record; `index(wavelength)` gives n + ik at a wavelength in m, k > 0 where light is absorbed.
"""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

NM = 1e-9  # m
FOLDER = files("ertel.optics") / "data"


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
        known, values = _johnson_christy(self.metal)
        asked = np.asarray(wavelength, dtype=float) / NM
        if asked.size and not known[0] <= asked.min() <= asked.max() <= known[-1]:
            outside = asked.min() if asked.min() < known[0] else asked.max()
            raise ValueError(
                f"wavelength = {outside:.4g} nm: must be from {known[0]:g} to {known[-1]:g} nm, where Johnson and "
                f"Christy measured {self.metal}; give another medium"
            )
        return np.interp(asked, known, values.real) + 1j * np.interp(asked, known, values.imag)


@cache
def table(name: str) -> NDArray[np.float64]:
    """A data file of this package by name: rows of numbers; the file names its source and its columns."""
    with (FOLDER / name).open(encoding="utf-8") as file:
        return np.loadtxt(file, delimiter=",")


def _johnson_christy(metal: str) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Wavelengths in nm and indices of "Cr" or "Fe"."""
    rows = table("johnson_christy_1974.csv")
    column = {"Cr": 1, "Fe": 3}[metal]
    return rows[:, 0], rows[:, column] + 1j * rows[:, column + 1]


CHROMIUM = JohnsonChristy("Cr")
STEEL = JohnsonChristy("Fe")  # iron stands for steel
# Schott N-BK7, data sheet of 2017, 300 to 2500 nm
BK7 = Sellmeier((1.03961212, 0.231792344, 1.01046945), (0.00600069867, 0.0200179144, 103.560653))
# Fused silica: Malitson IH. Interspecimen comparison of the refractive index of fused silica. J Opt Soc Am
# 1965;55:1205-1208, 210 to 3710 nm
SILICA = Sellmeier((0.6961663, 0.4079426, 0.8974794), (0.0684043**2, 0.1162414**2, 9.896161**2))
