"""Film thickness formulas of line contacts in steady rolling, for comparison and as the expected film.

M and L are those of a line contact (`line_scales`), U has the mean speed, and W is the load per length over E' R.
Moes' unit of film thickness is (2U)^(1/2) R, so that H_Moes = H 8 M/pi with H in units b^2/R.  The ranges are those in
which ertel's own films agree with a formula as its text says.
"""

from math import exp, pi, sqrt

from ertel.physics.film_formulas import FormulaFilm, dowson_higginson_minimum, dowson_toyoda_central
from ertel.physics.line_scales import LineParameters
from ertel.physics.scales import HamrockDowson

ROELANDS_M = 10.0, 400.0  # in which the formulas in U, G, W were compared with ertel's films
ROELANDS_L = 5.0, 22.0
MOES = "Moes H. Lubrication and beyond. University of Twente; 2000"
SOURCES = {
    "Moes": MOES,
    "Dowson-Higginson": "Dowson D. Proc Inst Mech Eng 1967-68;182(3A):151-167",
    "Dowson-Toyoda": "Dowson D, Toyoda S. Proc 5th Leeds-Lyon Symp on Tribology 1979:60-65",
    "Masjedi-Khonsari": "Masjedi M, Khonsari MM. J Tribol 2012;134:011503",
}


def moes_line(M: float, L: float) -> float:
    """Moes' fit of the central film, in his unit, for all M > 0 and L >= 0 and Barus' law.

    Against ertel's films: Barus -9 to +1 %, Roelands -8 to +59 %, the more the higher M; of L = 0 it is the minimum
    film, -4 to +3 %.
    """
    rigid, elastic = 2.45 / M, 2.05 * M**-0.2
    s = (7.0 + 8.0 * exp(-2.0 * elastic / rigid)) / 5.0
    isoviscous = (rigid ** (7 / 3) + elastic ** (7 / 3)) ** (3 / 7)
    if not L:
        return float(isoviscous)
    piezoviscous = ((1.05 * L ** (2 / 3)) ** -3.5 + (2.08 * L**0.75 * M**-0.125) ** -3.5) ** (-2 / 7)
    return float((isoviscous**s + piezoviscous**s) ** (1.0 / s))


def expected_line_film(parameters: LineParameters) -> float:
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


def line_films(parameters: LineParameters, ugw: HamrockDowson | None = None) -> list[FormulaFilm]:
    """All formulas for a line contact, in b^2/R.

    ugw: U, G, W; the formulas in U, G, W need it, with G > 0.
    """
    M, L = parameters.M, parameters.L
    moes = expected_line_film(parameters)
    least, most = (moes, None) if L else (None, moes)  # of an isoviscous oil it is the minimum
    found = [FormulaFilm("Moes", least, most, MOES, "all M and L; Barus' law", True)]
    if ugw is None or not ugw.G > 0:
        return found
    unit = 8.0 * ugw.W / pi  # b^2/R over R
    inside = ROELANDS_M[0] <= M <= ROELANDS_M[1] and ROELANDS_L[0] <= L <= ROELANDS_L[1]
    valid = "Roelands' law, M = 10 to 400, L = 5 to 22: over ertel's film, less one, "

    def film(name: str, central: float | None, minimum: float | None, differ: str) -> FormulaFilm:
        c, m = (value if value is None else value / unit for value in (central, minimum))
        return FormulaFilm(name, c, m, SOURCES[name], valid + differ, inside)

    return [
        *found,
        film("Dowson-Higginson", None, dowson_higginson_minimum(ugw), "-8 to +5 %"),
        film("Masjedi-Khonsari", masjedi_khonsari_central(ugw), None, "-11 to +1 %"),
        film("Dowson-Toyoda", dowson_toyoda_central(ugw), None, "+7 to +38 %"),
    ]
