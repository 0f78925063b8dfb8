"""Film thickness formulas for steady rolling, for comparison and for extrapolation.

All formulas are for fully flooded, isothermal, Newtonian contacts with smooth surfaces.  `films` evaluates them for a
circular contact.

=========  ========================================================================================================
symbol     meaning, in every formula here
=========  ========================================================================================================
E'         2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2
R          reduced radius along the flow, Rx (Chittenden: R_e); the one across the flow is Ry (R_s)
U          eta0 u_m/(E' R) with the *mean* speed u_m = (u1 + u2)/2; Moes uses the sum of the speeds: twice this U
G, W, W'   alpha E'; F/(E' R^2); load per unit length/(E' R) of a line contact
M, L       W (2U)^{-3/4}, G (2U)^{1/4}
=========  ========================================================================================================

Formulas in M and L give H in units a^2/R.  Moes' own unit is (2U)^{1/2} R, so H_Moes = H (3M/2)^{2/3}.  Formulas in
U, G, W give h/R as published; a^2/R^2 = (3W/2)^{2/3}.  In both groups a is the radius of the dry *circular* contact
with the radius R under the load F.
"""

from math import cbrt, exp, log, pi
from typing import NamedTuple

from ertel.physics.scales import HamrockDowson, Parameters, require_not_negative, require_positive

BALL = 1.03  # ellipticity of a ball by Hamrock and Dowson's fit k = 1.03 (Ry/Rx)^0.64; the exact value is 1
CLOSE = 0.1  # an asymptote holds if it is within this relative distance of the Nijenbanning-Venner-Moes formula

SOURCES = {
    "Nijenbanning-Venner-Moes": "Nijenbanning G, Venner CH, Moes H. Wear 1994;176:217-229",
    "Hamrock-Dowson": "Hamrock BJ, Dowson D. J Lubr Technol 1977;99:264-276",
    "Chittenden et al.": "Chittenden RJ, Dowson D, Dunn JF, Taylor CM. Proc R Soc Lond A 1985;397:245-294",
    "Dowson-Higginson": "Dowson D. Proc Inst Mech Eng 1967-68;182(3A):151-167",
    "Dowson-Toyoda": "Dowson D, Toyoda S. Proc 5th Leeds-Lyon Symp on Tribology 1979:60-65",
}


def moes_unit(M: float) -> float:
    """Moes' unit of film thickness (2U)^{1/2} R in units a^2/R: H/H_Moes = (3M/2)^{-2/3}."""
    require_positive("M", M)
    return 1.0 / cbrt(1.5 * M) ** 2


def isoviscous_rigid(M: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness of the isoviscous-rigid regime: M -> 0, L = 0.

    radius_ratio: Rx/Ry, the reduced radius along the flow over the reduced radius across it, at most 1 (1: a ball).
    """
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 145.0 * (1.0 + 0.796 * D ** (14 / 15)) ** (-15 / 7) / D / M**2


def piezoviscous_rigid(M: float, L: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness of the piezoviscous-rigid regime: M small, L large."""
    require_not_negative("L", L)
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 1.29 * (1.0 + 0.691 * D) ** (-2 / 3) * L ** (2 / 3)


def isoviscous_elastic(M: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness of the isoviscous-elastic regime: M large, L = 0; for a ball 0.438 lambda_bar^{3/5}."""
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 3.18 * _elliptic(D) ** (-14 / 25) * D ** (-1 / 15) * M ** (-2 / 15)


def piezoviscous_elastic(M: float, L: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness of the piezoviscous-elastic regime: M and L large; for a ball 0.952 (L/M)^{3/4}."""
    require_not_negative("L", L)
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 1.48 * _elliptic(D) ** (-7 / 20) * D ** (-1 / 24) * M ** (-1 / 12) * L**0.75


def nijenbanning_venner_moes(M: float, L: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness H_c (a^2/R) for all M > 0 and L >= 0, interpolated between the four asymptotes.

    Nijenbanning G, Venner CH, Moes H. Film thickness in elastohydrodynamically lubricated elliptic contacts.
    Wear 1994;176:217-229.  radius_ratio = Rx/Ry <= 1: a ball (1), or a contact that is wide across the flow.  For a
    ball the formula is between 7 % above and 14 % below converged solutions with Barus' law, M = 20 to 1000, L = 0 to
    10 (the tests check this).

    Examples
    --------
    >>> round(nijenbanning_venner_moes(M=200, L=10), 4)  # fine grids give 0.1005
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
    """Central film thickness h_c/R = 2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 k)).

    Hamrock BJ, Dowson D. Isothermal elastohydrodynamic lubrication of point contacts, part III. J Lubr Technol
    1977;99:264-276.  The formula is fitted to 34 computed contacts: k = 1 to 8, U = 8e-13 to 5e-11, G = 2300 to 6800,
    W over one decade.  ellipticity: k, the contact's half width across the flow over its half width along the flow.
    """
    U, G, W = _checked(parameters)
    require_positive("ellipticity", ellipticity)
    return 2.69 * U**0.67 * G**0.53 * W**-0.067 * (1.0 - 0.61 * exp(-0.73 * ellipticity))


def hamrock_dowson_minimum(parameters: HamrockDowson, ellipticity: float = BALL) -> float:
    """Minimum film thickness h_min/R = 3.63 U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 k)).

    Source and range: see `hamrock_dowson_central`.
    """
    U, G, W = _checked(parameters)
    require_positive("ellipticity", ellipticity)
    return 3.63 * U**0.68 * G**0.49 * W**-0.073 * (1.0 - exp(-0.68 * ellipticity))


def chittenden_central(parameters: HamrockDowson, radius_ratio: float = 1.0) -> float:
    """Central film thickness h_c/R = 4.31 U^0.68 G^0.49 W^-0.073 {1 - exp[-1.23 (Ry/Rx)^{2/3}]}.

    Chittenden RJ, Dowson D, Dunn JF, Taylor CM. A theoretical analysis of the isothermal elastohydrodynamic lubrication
    of concentrated contacts, I and II. Proc R Soc Lond A 1985;397:245-269, 271-294.  The flow is along one axis of the
    ellipse: the minor axis if radius_ratio = Rx/Ry is below one, the major axis if it is above one.
    """
    U, G, W = _checked(parameters)
    require_positive("radius_ratio", radius_ratio)
    return 4.31 * U**0.68 * G**0.49 * W**-0.073 * (1.0 - exp(-1.23 * radius_ratio ** (-2 / 3)))


def chittenden_minimum(parameters: HamrockDowson, radius_ratio: float = 1.0) -> float:
    """Minimum film thickness h_min/R = 3.68 U^0.68 G^0.49 W^-0.073 {1 - exp[-0.67 (Ry/Rx)^{2/3}]}.

    Source and radius_ratio: see `chittenden_central`.
    """
    U, G, W = _checked(parameters)
    require_positive("radius_ratio", radius_ratio)
    return 3.68 * U**0.68 * G**0.49 * W**-0.073 * (1.0 - exp(-0.67 * radius_ratio ** (-2 / 3)))


def dowson_higginson_minimum(parameters: HamrockDowson) -> float:
    """Minimum film thickness of a line contact, h_min/R = 2.65 U^0.7 G^0.54 W'^-0.13.  The field W holds W'.

    Dowson D. Elastohydrodynamics. Proc Inst Mech Eng 1967-68;182(3A):151-167, after Dowson and Higginson's book (1966).
    The formula is fitted to solutions with U = 1e-13 to 1e-11, G = 2500 and 5000, W' = 3e-5 to 3e-4.
    """
    U, G, W = _checked(parameters)
    return 2.65 * U**0.7 * G**0.54 * W**-0.13


def dowson_toyoda_central(parameters: HamrockDowson) -> float:
    """Central film thickness of a line contact, h_c/R = 3.06 U^0.69 G^0.56 W'^-0.10.  The field W holds W'.

    Dowson D, Toyoda S. A central film thickness formula for elastohydrodynamic line contacts. Proc 5th Leeds-Lyon
    Symposium on Tribology (1978), 1979:60-65.
    """
    U, G, W = _checked(parameters)
    return 3.06 * U**0.69 * G**0.56 * W**-0.10


def line_contact(parameters: HamrockDowson) -> HamrockDowson:
    """U, G, W' of the line contact that has the radius, speed and Hertz pressure of a circular contact.

    p_h/E' is a/(pi R) in the circular contact and (W'/(2 pi))^{1/2} in the line contact: W' = (2/pi) (3W/2)^{2/3}.
    """
    U, G, W = _checked(parameters)
    return HamrockDowson(U, G, 2.0 / pi * cbrt(1.5 * W) ** 2)


class Film(NamedTuple):
    """Result of one formula for a circular contact.

    central, minimum: film thickness in a^2/R, None if the formula does not give it.  valid: the formula's range, in
    words.  inside: whether the contact is in that range, None if the source gives no bounds.
    """

    name: str
    central: float | None
    minimum: float | None
    source: str
    valid: str
    inside: bool | None


def films(parameters: Parameters, ugw: HamrockDowson | None = None) -> list[Film]:
    """All formulas for a circular contact.  The formulas in U, G, W need `ugw` with G > 0."""
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
    """The formulas of Hamrock and Dowson, of Chittenden, and of the line contact with the same Hertz pressure."""
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
