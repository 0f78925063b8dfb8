"""Film thickness formulas for steady rolling, to compare with and to extrapolate from.

Formulas of M and L give H in units a^2/R (Moes' unit is (2U)^{1/2} R: H_Moes = H (3M/2)^{2/3}), those of Hamrock and
Dowson's U, G, W give h/R as published.  All are for fully flooded, isothermal, Newtonian contacts of smooth surfaces.
"""

from math import cbrt, exp, log

from ertel.scales import HamrockDowson, require_not_negative, require_positive

BALL = 1.03  # Hamrock and Dowson's ellipticity of a ball: their fit k = 1.03 (Ry/Rx)^0.64 is not one there


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
    """Central film thickness H_c (a^2/R with R along the flow) for all M > 0 and L >= 0, from its four asymptotes.

    Nijenbanning G, Venner CH, Moes H. Film thickness in elastohydrodynamically lubricated elliptic contacts.
    Wear 1994;176:217-229.  Barus, incompressible.  radius_ratio = Rx/Ry <= 1.

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
    1977;99:264-276.  ellipticity: k, the contact's half width across the flow over that along it.
    """
    U, G, W = _checked(parameters)
    require_positive("ellipticity", ellipticity)
    return 2.69 * U**0.67 * G**0.53 * W**-0.067 * (1.0 - 0.61 * exp(-0.73 * ellipticity))


def hamrock_dowson_minimum(parameters: HamrockDowson, ellipticity: float = BALL) -> float:
    """Minimum film h_min/R = 3.63 U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 k)); source as for the central film."""
    U, G, W = _checked(parameters)
    require_positive("ellipticity", ellipticity)
    return 3.63 * U**0.68 * G**0.49 * W**-0.073 * (1.0 - exp(-0.68 * ellipticity))


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
