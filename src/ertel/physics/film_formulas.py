"""Film thickness formulas for steady rolling, to compare with and to extrapolate from.

All are for fully flooded, isothermal, Newtonian contacts of smooth surfaces.  `films` lists what they say of a
circular contact.

=========  ========================================================================================================
symbol     meaning, in every formula here
=========  ========================================================================================================
E'         2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2
R          reduced radius along the flow, Rx (Chittenden: R_e); across it Ry (R_s)
U          eta0 u_m/(E' R) with the *mean* speed u_m = (u1 + u2)/2; Moes' own U is that of the sum, twice as much
G, W, W'   alpha E'; F/(E' R^2); load per length/(E' R) of a line contact
M, L       W (2U)^{-3/4}, G (2U)^{1/4}
=========  ========================================================================================================

Formulas of M and L give H in units a^2/R (Moes' unit is (2U)^{1/2} R: H_Moes = H (3M/2)^{2/3}), those of U, G, W give
h/R as published; (3W/2)^{2/3} is a^2/R^2.  In both a is the radius of the dry *circular* contact of R under the load F.
"""

from math import cbrt, exp, log, pi
from typing import NamedTuple

from ertel.physics.scales import HamrockDowson, Parameters, require_not_negative, require_positive

BALL = 1.03  # Hamrock and Dowson's ellipticity of a ball: their fit k = 1.03 (Ry/Rx)^0.64 is not one there
CLOSE = 0.1  # how near an asymptote has to be to the formula that joins them to be said to hold

SOURCES = {
    "Nijenbanning-Venner-Moes": "Nijenbanning G, Venner CH, Moes H. Wear 1994;176:217-229",
    "Hamrock-Dowson": "Hamrock BJ, Dowson D. J Lubr Technol 1977;99:264-276",
    "Chittenden et al.": "Chittenden RJ, Dowson D, Dunn JF, Taylor CM. Proc R Soc Lond A 1985;397:245-294",
    "Dowson-Higginson": "Dowson D. Proc Inst Mech Eng 1967-68;182(3A):151-167",
    "Dowson-Toyoda": "Dowson D, Toyoda S. Proc 5th Leeds-Lyon Symp on Tribology 1979:60-65",
}


def moes_unit(M: float) -> float:
    """(2U)^{1/2} R in units a^2/R, that is H / H_Moes = (3M/2)^{-2/3}."""
    require_positive("M", M)
    return 1.0 / cbrt(1.5 * M) ** 2


def isoviscous_rigid(M: float, radius_ratio: float = 1.0) -> float:
    """Central film where neither elasticity nor pressure on viscosity count: M -> 0, L = 0.

    radius_ratio: Rx/Ry, the reduced radius along the flow over that across it, at most 1 (1: a ball).
    """
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 145.0 * (1.0 + 0.796 * D ** (14 / 15)) ** (-15 / 7) / D / M**2


def piezoviscous_rigid(M: float, L: float, radius_ratio: float = 1.0) -> float:
    """Central film where viscosity rises with pressure and the bodies are stiff: M small, L large."""
    require_not_negative("L", L)
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 1.29 * (1.0 + 0.691 * D) ** (-2 / 3) * L ** (2 / 3)


def isoviscous_elastic(M: float, radius_ratio: float = 1.0) -> float:
    """Central film of soft bodies, M -> infinity at L = 0; for a ball 0.438 lambda_bar^{3/5}."""
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 3.18 * _elliptic(D) ** (-14 / 25) * D ** (-1 / 15) * M ** (-2 / 15)


def piezoviscous_elastic(M: float, L: float, radius_ratio: float = 1.0) -> float:
    """Central film of the elastohydrodynamic contact proper, M and L large; for a ball 0.952 (L/M)^{3/4}."""
    require_not_negative("L", L)
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 1.48 * _elliptic(D) ** (-7 / 20) * D ** (-1 / 24) * M ** (-1 / 12) * L**0.75


def nijenbanning_venner_moes(M: float, L: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness H_c (a^2/R) for all M > 0 and L >= 0, from its four asymptotes.

    Nijenbanning G, Venner CH, Moes H. Film thickness in elastohydrodynamically lubricated elliptic contacts.
    Wear 1994;176:217-229.  radius_ratio = Rx/Ry <= 1: a ball, or wide across the flow.  For a ball 7 % above to 14 %
    below converged solutions with Barus' law, M = 20 to 1000, L = 0 to 10 (the test holds it to that).

    Examples
    --------
    >>> round(nijenbanning_venner_moes(M=200, L=10), 4)  # 0.1005 computed on fine grids
    0.0902
    """
    require_not_negative("L", L)
    unit, D = moes_unit(M), _checked_ratio(radius_ratio)
    RI, EI = isoviscous_rigid(M, D) / unit, isoviscous_elastic(M, D) / unit
    RP, EP = piezoviscous_rigid(M, L, D) / unit, piezoviscous_elastic(M, L, D) / unit
    limit = 1.8 / D
    isoviscous = RI**1.5 + (EI**-4 + limit**-4) ** (-3 / 8)
    if L == 0:
        return unit * isoviscous ** (2 / 3)
    s = 1.5 * (1.0 + exp(-1.2 * EI / EP))
    return unit * (isoviscous ** (2 * s / 3) + (RP**-8 + EP**-8) ** (-s / 8)) ** (1 / s)


def hamrock_dowson_central(parameters: HamrockDowson, ellipticity: float = BALL) -> float:
    """Central film h_c/R = 2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 k)).

    Hamrock BJ, Dowson D. Isothermal elastohydrodynamic lubrication of point contacts, part III. J Lubr Technol
    1977;99:264-276.  Fitted to 34 computed contacts: k = 1 to 8, U = 8e-13 to 5e-11, G = 2300 to 6800, W over a
    decade.  ellipticity: k, the contact's half width across the flow over that along it.
    """
    U, G, W = _checked(parameters)
    require_positive("ellipticity", ellipticity)
    return 2.69 * U**0.67 * G**0.53 * W**-0.067 * (1.0 - 0.61 * exp(-0.73 * ellipticity))


def hamrock_dowson_minimum(parameters: HamrockDowson, ellipticity: float = BALL) -> float:
    """Minimum film h_min/R = 3.63 U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 k)); source as for the central film."""
    U, G, W = _checked(parameters)
    require_positive("ellipticity", ellipticity)
    return 3.63 * U**0.68 * G**0.49 * W**-0.073 * (1.0 - exp(-0.68 * ellipticity))


def chittenden_central(parameters: HamrockDowson, radius_ratio: float = 1.0) -> float:
    """Central film h_c/R = 4.31 U^0.68 G^0.49 W^-0.073 {1 - exp[-1.23 (Ry/Rx)^{2/3}]}.

    Chittenden RJ, Dowson D, Dunn JF, Taylor CM. A theoretical analysis of the isothermal elastohydrodynamic lubrication
    of concentrated contacts, I and II. Proc R Soc Lond A 1985;397:245-269, 271-294.  Flow along either axis of the
    ellipse: radius_ratio = Rx/Ry below one, along the minor axis; above one, along the major axis.
    """
    U, G, W = _checked(parameters)
    require_positive("radius_ratio", radius_ratio)
    return 4.31 * U**0.68 * G**0.49 * W**-0.073 * (1.0 - exp(-1.23 * radius_ratio ** (-2 / 3)))


def chittenden_minimum(parameters: HamrockDowson, radius_ratio: float = 1.0) -> float:
    """Minimum film h_min/R = 3.68 U^0.68 G^0.49 W^-0.073 {1 - exp[-0.67 (Ry/Rx)^{2/3}]}; as for the central film."""
    U, G, W = _checked(parameters)
    require_positive("radius_ratio", radius_ratio)
    return 3.68 * U**0.68 * G**0.49 * W**-0.073 * (1.0 - exp(-0.67 * radius_ratio ** (-2 / 3)))


def dowson_higginson_minimum(parameters: HamrockDowson) -> float:
    """Minimum film of a line contact, h_min/R = 2.65 U^0.7 G^0.54 W'^-0.13.  W stands for W'.

    Dowson D. Elastohydrodynamics. Proc Inst Mech Eng 1967-68;182(3A):151-167, after Dowson and Higginson's book (1966);
    from solutions with U = 1e-13 to 1e-11, G = 2500 and 5000, W' = 3e-5 to 3e-4.
    """
    U, G, W = _checked(parameters)
    return 2.65 * U**0.7 * G**0.54 * W**-0.13


def dowson_toyoda_central(parameters: HamrockDowson) -> float:
    """Central film of a line contact, h_c/R = 3.06 U^0.69 G^0.56 W'^-0.10.  W stands for W'.

    Dowson D, Toyoda S. A central film thickness formula for elastohydrodynamic line contacts. Proc 5th Leeds-Lyon
    Symposium on Tribology (1978), 1979:60-65.
    """
    U, G, W = _checked(parameters)
    return 3.06 * U**0.69 * G**0.56 * W**-0.10


def line_contact(parameters: HamrockDowson) -> HamrockDowson:
    """U, G, W' of the line contact with the radius, the speed and the Hertz pressure of a circular one.

    p_h/E' = a/(pi R) of the circle, (W'/(2 pi))^{1/2} of the line: W' = (2/pi) (3W/2)^{2/3}.
    """
    U, G, W = _checked(parameters)
    return HamrockDowson(U, G, 2.0 / pi * cbrt(1.5 * W) ** 2)


class Film(NamedTuple):
    """What a formula says of a circular contact: films in a^2/R, None where it has none.

    valid: what it is for, in words.  inside: whether the contact is so, None where the source gives no bounds.
    """

    name: str
    central: float | None
    minimum: float | None
    source: str
    valid: str
    inside: bool | None


def films(parameters: Parameters, ugw: HamrockDowson | None = None) -> list[Film]:
    """Every formula for a circular contact, side by side; those of U, G, W only where these are given (and G > 0)."""
    M, L = parameters.M, parameters.L
    name, joined = "Nijenbanning-Venner-Moes", nijenbanning_venner_moes(M, L)
    found = [Film(name, joined, None, SOURCES[name], "all M and L; Barus' law", True)]
    if ugw is not None and ugw.G > 0:
        found += _films_of_ugw(ugw)
    asymptotes = {
        "isoviscous, rigid": (isoviscous_rigid(M), "M small, L = 0"),
        "isoviscous, elastic": (isoviscous_elastic(M), "M large, L = 0"),
    }
    if L > 0:
        asymptotes |= {
            "piezoviscous, rigid": (piezoviscous_rigid(M, L), "M small, L large"),
            "piezoviscous, elastic": (piezoviscous_elastic(M, L), "M and L large"),
        }
    for regime, (film, valid) in asymptotes.items():
        found.append(Film(regime, film, None, SOURCES[name], valid, abs(film / joined - 1.0) < CLOSE))
    return found


def _films_of_ugw(ugw: HamrockDowson) -> list[Film]:
    """Hamrock and Dowson's, Chittenden's, and those of the line contact with the same Hertz pressure."""
    unit, line = cbrt(1.5 * ugw.W) ** 2, line_contact(ugw)

    def film(name: str, central: float | None, minimum: float | None, valid: str, inside: bool | None = None) -> Film:
        c, m = (value if value is None else value / unit for value in (central, minimum))
        return Film(name, c, m, SOURCES[name], valid, inside)

    hard = 8e-13 <= ugw.U <= 5.1e-11 and 2300 <= ugw.G <= 6800
    long = 1e-13 <= line.U <= 1e-11 and 2500 <= line.G <= 5000 and 3e-5 <= line.W <= 3e-4
    ranges = "U = 8e-13 to 5e-11, G = 2300 to 6800", "U = 1e-13 to 1e-11, G = 2500 to 5000, W' = 3e-5 to 3e-4"
    same = "line contact of the same p_h"
    hamrock_dowson = hamrock_dowson_central(ugw), hamrock_dowson_minimum(ugw)
    chittenden = chittenden_central(ugw), chittenden_minimum(ugw)
    return [
        film("Hamrock-Dowson", *hamrock_dowson, ranges[0], hard),
        film("Chittenden et al.", *chittenden, "piezoviscous, elastic"),
        film("Dowson-Higginson", None, dowson_higginson_minimum(line), f"{same}: {ranges[1]}", long),
        film("Dowson-Toyoda", dowson_toyoda_central(line), None, same),
    ]


def _elliptic(D: float) -> float:
    return 1.0 + 0.006 * log(D) + 0.63 * D ** (4 / 7)


def _checked(parameters: HamrockDowson) -> HamrockDowson:
    for name, value in parameters._asdict().items():
        require_positive(name, value)
    return parameters


def _checked_ratio(radius_ratio: float) -> float:
    if not 0.0 < radius_ratio <= 1.0:
        raise ValueError(
            f"radius_ratio = {radius_ratio}: must be above zero and not above one (slender along the flow)"
        )
    return radius_ratio
