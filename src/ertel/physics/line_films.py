"""Film thickness formulas of line contacts in steady rolling, for comparison and as the expected film.

M and L are those of a line contact (`line_scales`), U has the mean speed, and W is the load per length over E' R.
Moes' unit of film thickness is (2U)^(1/2) R, so that H_Moes = H 8 M/pi with H in units b^2/R.  The ranges are those in
which ertel's own films agree with a formula as its text says (validation/contacts/line_formulas.md); they depend on the
laws of the oil.
"""

from math import exp, pi, sqrt
from typing import NamedTuple

from ertel.physics.film_formulas import FormulaFilm, dowson_higginson_minimum, dowson_toyoda_central
from ertel.physics.lubricant import Lubricant
from ertel.physics.registry import DENSITY_LAWS, VISCOSITY_LAWS
from ertel.physics.scales import HamrockDowson, Parameters

MOES = "Moes H. Lubrication and beyond. University of Twente; 2000"
SOURCES = {
    "Moes": MOES,
    "Dowson-Higginson": "Dowson D. Proc Inst Mech Eng 1967-68;182(3A):151-167",
    "Masjedi-Khonsari": "Masjedi M, Khonsari MM. J Tribol 2012;134:011503",
    "Dowson-Toyoda": "Dowson D, Toyoda S. Proc 5th Leeds-Lyon Symp on Tribology 1979:60-65",
}


class ComparedFilms(NamedTuple):
    """Films of ertel that the formulas were compared with: the law, the ranges of M and L.

    differ: each formula over the film, less one, in the order of `SOURCES`.
    """

    law: str
    M: tuple[float, float]
    L: tuple[float, float]
    differ: tuple[str, ...]

    def covers(self, at: Parameters) -> bool:
        return self.M[0] <= at.M <= self.M[1] and self.L[0] <= at.L <= self.L[1]

    def text(self, name: str) -> str:
        differ = dict(zip(SOURCES, self.differ, strict=False)).get(name, "not compared")
        (M_0, M_1), (L_0, L_1) = self.M, self.L
        where = f"M = {M_0:g} to {M_1:g}, L = {L_0:g}" + (f" to {L_1:g}" if L_1 > L_0 else "")
        return f"{self.law}, {where}: over ertel's film, less one, {differ}"


COMPARED = {  # by the names of the viscosity law and of the density law
    ("roelands", "dowson-higginson"): ComparedFilms(
        "Roelands' law", (10, 400), (5, 22), ("+4 to +59 %", "-8 to +5 %", "-11 to +1 %", "+7 to +38 %")
    ),
    ("barus", "incompressible"): ComparedFilms(
        "Barus' law, incompressible", (10, 50), (5, 15), ("-9 to +5 %", "-10 to 0 %", "-27 to -19 %", "-7 to +1 %")
    ),
    ("isoviscous", "incompressible"): ComparedFilms("isoviscous, minimum film", (3, 400), (0, 0), ("-4 to +2 %",)),
}


def moes_line(M: float, L: float) -> float:
    """Moes' fit of the central film, in his unit, for all M > 0 and L >= 0 and Barus' law; of L = 0 the minimum film.

    `COMPARED` has how far it is from ertel's films.  Those of a Roelands oil it exceeds, the more the higher M.
    """
    rigid, elastic = 2.45 / M, 2.05 * M**-0.2
    s = (7.0 + 8.0 * exp(-2.0 * elastic / rigid)) / 5.0
    isoviscous = (rigid ** (7 / 3) + elastic ** (7 / 3)) ** (3 / 7)
    if not L:
        return float(isoviscous)
    piezoviscous = ((1.05 * L ** (2 / 3)) ** -3.5 + (2.08 * L**0.75 * M**-0.125) ** -3.5) ** (-2 / 7)
    return float((isoviscous**s + piezoviscous**s) ** (1.0 / s))


def expected_line_film(parameters: Parameters) -> float:
    """A central film thickness to be expected in rolling, in b^2/R: that of Moes' fit."""
    return moes_line(parameters.M, parameters.L) * pi / (8.0 * parameters.M)


def regime_of_line(M: float, L: float) -> str:
    """The regime on Johnson's chart of g_V = W^(3/2) G U^(-1/2) and g_E = W U^(-1/2), by name.

    Johnson KL. Regimes of elastohydrodynamic lubrication. J Mech Eng Sci 1970;12:9-16, with the films h W/(R U) that
    Hamrock gives for its regimes (Fundamentals of fluid film lubrication. NASA RP-1255; 1991).
    """
    g_E, g_V = sqrt(2.0) * M, sqrt(2.0) * M**1.5 * L
    soft = max((4.9, "isoviscous, rigid"), (3.10 * g_E**0.8, "isoviscous, elastic"))
    hard = min((1.05 * g_V ** (2 / 3), "piezoviscous, rigid"), (1.654 * g_V**0.54 * g_E**0.06, "piezoviscous, elastic"))
    return max(soft, hard)[1]


def masjedi_khonsari_central(parameters: HamrockDowson) -> float:
    """Central film thickness of a line contact, h_c/R = 2.691 U^0.705 G^0.556 W^-0.135.

    Masjedi M, Khonsari MM. Film thickness and asperity load formulas for line-contact EHL with provision for surface
    roughness. J Tribol 2012;134:011503; its part for smooth surfaces.
    """
    U, G, W = parameters
    return float(2.691 * U**0.705 * G**0.556 * W**-0.135)


def starved(film: FormulaFilm, oil: float) -> FormulaFilm:
    """The central film on a layer of oil (b^2/R, at the density in the contact): nothing leaks to the sides."""
    assert film.central is not None
    valid = "the film is the layer, up to the flooded film"
    return film._replace(name=f"{film.name}, starved", central=min(film.central, oil), minimum=None, valid=valid)


def line_films(parameters: Parameters, lubricant: Lubricant, ugw: HamrockDowson | None = None) -> list[FormulaFilm]:
    """All formulas for a line contact, in b^2/R; inside: where they were compared with films of such an oil.

    ugw: U, G, W; the formulas in U, G, W need it, with G > 0.
    """
    laws = VISCOSITY_LAWS.name_of(lubricant.viscosity_law), DENSITY_LAWS.name_of(lubricant.density_law)
    compared = COMPARED.get(laws)

    def film(name: str, central: float | None, minimum: float | None, made_for: str = "") -> FormulaFilm:
        text = compared.text(name) if compared else f"not compared with films of such an oil ({', '.join(laws)})"
        inside = compared is not None and compared.covers(parameters)
        return FormulaFilm(name, central, minimum, SOURCES[name], f"{made_for}{text}", inside)

    moes = expected_line_film(parameters)
    least, most = (moes, None) if parameters.L else (None, moes)  # of an isoviscous oil it is the minimum
    found = [film("Moes", least, most, "made for all M and L, Barus' law; ")]
    if ugw is None or not ugw.G > 0:
        return found
    unit = 8.0 * ugw.W / pi  # b^2/R over R
    return [
        *found,
        film("Dowson-Higginson", None, dowson_higginson_minimum(ugw) / unit),
        film("Masjedi-Khonsari", masjedi_khonsari_central(ugw) / unit, None),
        film("Dowson-Toyoda", dowson_toyoda_central(ugw) / unit, None),
    ]
