"""Film thickness formulas for steady rolling, for comparison and for extrapolation.

All formulas are for fully flooded, isothermal, Newtonian contacts with smooth surfaces.  `films` evaluates them for a
circular or an elliptical contact.  `starved_share` is the part of a flooded film that a thin layer of oil leaves.

=========  ========================================================================================================
symbol     meaning, in every formula here
=========  ========================================================================================================
E'         2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2
R          reduced radius along the flow, Rx (Chittenden: R_e); the one across the flow is Ry (R_s); at an angle theta
           to the axes 1/R_e = cos^2/Rx + sin^2/Ry, 1/R_s = sin^2/Rx + cos^2/Ry (`FlowDirection`)
U          eta0 u_m/(E' R) with the *mean* speed u_m = (u1 + u2)/2; Moes uses the sum of the speeds: twice this U
G, W, W'   alpha E'; F/(E' R^2); load per unit length/(E' R) of a line contact
M, L       W (2U)^{-3/4}, G (2U)^{1/4}
=========  ========================================================================================================

Formulas in M and L give H in units a^2/R.  Moes' own unit is (2U)^{1/2} R, so H_Moes = H (3M/2)^{2/3}.  Formulas in
U, G, W give h/R as published; a^2/R^2 = (3W/2)^{2/3}.  In both groups a is the radius of the dry *circular* contact
with the radius R under the load F.  `films` gives all in the scales of the contact itself.
"""

from math import cbrt, cos, exp, log, pi, radians, sin, sqrt
from typing import NamedTuple

from ertel.physics.geometry import HertzEllipse, hertz_ellipse
from ertel.physics.scales import HamrockDowson, Parameters
from ertel.physics.units import require_not_negative, require_positive

BALL = 1.03  # ellipticity of a ball by Hamrock and Dowson's fit k = 1.03 (Ry/Rx)^0.64; the exact value is 1
CLOSE = 0.1  # an asymptote holds if it is within this relative distance of the Nijenbanning-Venner-Moes formula

ROLLING_EXPONENT = 2.7  # g of `starved_share`, within 0.02 of ertel's films at M = 200, L = 10; published: 2 to 5
IMPACT_EXPONENT = 2.2  # within 2 % at maximum approach, M = 200 and 1000, L = 10

NVM = "Nijenbanning-Venner-Moes"
SOURCES = {
    NVM: "Nijenbanning G, Venner CH, Moes H. Wear 1994;176:217-229",
    "Hamrock-Dowson": "Hamrock BJ, Dowson D. J Lubr Technol 1977;99:264-276",
    "Chittenden et al.": "Chittenden RJ, Dowson D, Dunn JF, Taylor CM. Proc R Soc Lond A 1985;397:245-294",
    "Dowson-Higginson": "Dowson D. Proc Inst Mech Eng 1967-68;182(3A):151-167",
    "Chevalier et al.": "Chevalier F, Lubrecht AA, Cann PME, Colin F, Dalmaz G. J Tribol 1998;120:126-133",
    "Dowson-Toyoda": "Dowson D, Toyoda S. Proc 5th Leeds-Lyon Symp on Tribology 1979:60-65",
}


def moes_unit(M: float) -> float:
    """Moes' unit of film thickness (2U)^{1/2} R in units a^2/R: H/H_Moes = (3M/2)^{-2/3}."""
    require_positive(M=M)
    return 1.0 / cbrt(1.5 * M) ** 2


def isoviscous_rigid(M: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness of the isoviscous-rigid regime: M -> 0, L = 0.

    radius_ratio: Rx/Ry, the reduced radius along the flow over the reduced radius across it, at most 1 (1: a ball).
    """
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 145.0 * (1.0 + 0.796 * D ** (14 / 15)) ** (-15 / 7) / D / M**2


def piezoviscous_rigid(M: float, L: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness of the piezoviscous-rigid regime: M small, L large."""
    require_not_negative(L=L)
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 1.29 * (1.0 + 0.691 * D) ** (-2 / 3) * L ** (2 / 3)


def isoviscous_elastic(M: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness of the isoviscous-elastic regime: M large, L = 0; for a ball 0.438 lambda_bar^{3/5}."""
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 3.18 * _elliptic(D) ** (-14 / 25) * D ** (-1 / 15) * M ** (-2 / 15)


def piezoviscous_elastic(M: float, L: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness of the piezoviscous-elastic regime: M and L large; for a ball 0.952 (L/M)^{3/4}."""
    require_not_negative(L=L)
    D = _checked_ratio(radius_ratio)
    return moes_unit(M) * 1.48 * _elliptic(D) ** (-7 / 20) * D ** (-1 / 24) * M ** (-1 / 12) * L**0.75


def nijenbanning_venner_moes(M: float, L: float, radius_ratio: float = 1.0) -> float:
    """Central film thickness H_c (a^2/R) for all M > 0 and L >= 0, interpolated between the four asymptotes.

    Nijenbanning G, Venner CH, Moes H. Film thickness in elastohydrodynamically lubricated elliptic contacts.
    Wear 1994;176:217-229.  radius_ratio = Rx/Ry <= 1: a ball (1), or a contact that is wide across the flow.  For a
    ball the formula is between 7 % above and 14 % below converged solutions with the Barus law, M = 20 to 1000, L = 0
    to 10 (the tests check this).

    Examples
    --------
    >>> round(nijenbanning_venner_moes(M=200, L=10), 4)  # fine grids give 0.1005
    0.0902
    """
    require_not_negative(L=L)
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
    U, G, W = _checked(parameters, ellipticity=ellipticity)
    return 2.69 * U**0.67 * G**0.53 * W**-0.067 * (1.0 - 0.61 * exp(-0.73 * ellipticity))


def hamrock_dowson_minimum(parameters: HamrockDowson, ellipticity: float = BALL) -> float:
    """Minimum film thickness h_min/R = 3.63 U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 k)).

    Source and range: see `hamrock_dowson_central`.
    """
    U, G, W = _checked(parameters, ellipticity=ellipticity)
    return 3.63 * U**0.68 * G**0.49 * W**-0.073 * (1.0 - exp(-0.68 * ellipticity))


def chittenden_central(parameters: HamrockDowson, radius_ratio: float = 1.0) -> float:
    """Central film thickness h_c/R = 4.31 U^0.68 G^0.49 W^-0.073 {1 - exp[-1.23 (Ry/Rx)^{2/3}]}.

    Chittenden RJ, Dowson D, Dunn JF, Taylor CM. A theoretical analysis of the isothermal elastohydrodynamic lubrication
    of concentrated contacts, I and II. Proc R Soc Lond A 1985;397:245-269, 271-294.  radius_ratio: R_e/R_s, the
    radius along the flow over that across it; below one the flow is along the minor axis of the ellipse, above one
    along the major axis.  For flow at an angle to the axes R is R_e (`FlowDirection`).  Other sources print 4.30
    and 1.30 for the first and the last constant.
    """
    U, G, W = _checked(parameters, radius_ratio=radius_ratio)
    return 4.31 * U**0.68 * G**0.49 * W**-0.073 * _kept(radius_ratio)


def chittenden_minimum(parameters: HamrockDowson, radius_ratio: float = 1.0) -> float:
    """Minimum film thickness h_min/R = 3.68 U^0.68 G^0.49 W^-0.073 {1 - exp[-0.67 (Ry/Rx)^{2/3}]}.

    Source and radius_ratio: see `chittenden_central`.
    """
    U, G, W = _checked(parameters, radius_ratio=radius_ratio)
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


def line_contact(parameters: HamrockDowson, radius_ratio: float = 1.0) -> HamrockDowson:
    """U, G, W' of the line contact that has the radius, speed and Hertz pressure of a point contact.

    p_h/E' is b/(pi beta R) in the point contact with b^3 = 3 kappa beta F R/(2 E'), and (W'/(2 pi))^{1/2} in the line
    contact: W' = (2/pi) (3 kappa beta W/2)^{2/3}/beta^2.
    """
    U, G, W = _checked(parameters)
    e = hertz_ellipse(radius_ratio)
    return HamrockDowson(U, G, 2.0 / pi * (cbrt(1.5 * e.kappa * e.beta * W) / e.beta) ** 2)


class FlowDirection(NamedTuple):
    """The contact as the flow sees it: R_x/R_e, and R_e/R_s, both of the radii along and across the flow."""

    curvature: float
    radius_ratio: float

    @classmethod
    def at(cls, radius_ratio: float, angle: float) -> "FlowDirection":
        """For R_x/R_y and the angle (degrees) from x to the flow: Euler's theorem for the curvature."""
        if radius_ratio == 1.0 or angle % 180.0 == 0.0:
            return cls(1.0, radius_ratio)
        if angle % 90.0 == 0.0:
            return cls(radius_ratio, 1.0 / radius_ratio)
        c2, s2 = cos(radians(angle)) ** 2, sin(radians(angle)) ** 2
        along, across = c2 + radius_ratio * s2, s2 + radius_ratio * c2
        return cls(along, across / along)

    def moes(self, parameters: Parameters) -> tuple[float, float]:
        """M and L with the radius along the flow."""
        root = sqrt(sqrt(self.curvature))
        return parameters.M * self.curvature * root, parameters.L * root

    def ugw(self, ugw: HamrockDowson) -> HamrockDowson:
        """U, G, W with the radius along the flow."""
        return HamrockDowson(ugw.U * self.curvature, ugw.G, ugw.W * self.curvature**2)


def expected_film(parameters: Parameters, angle: float = 0.0) -> float:
    """A central film thickness to be expected in rolling, in the contact's own a^2/R, for all ellipses and angles.

    It is the formula of Nijenbanning, Venner and Moes.  Where the flow is along the longer axis, for which it was not
    made, it is that of a ball with the radius along the flow, less what Chittenden's formula says of the side leakage.
    """
    flow = FlowDirection.at(parameters.radius_ratio, angle)
    M, L = flow.moes(parameters)
    wide = min(flow.radius_ratio, 1.0)
    left = _kept(flow.radius_ratio) / _kept(wide)
    return left * nijenbanning_venner_moes(M, L, wide) / moes_unit(M) * _own_unit(parameters, flow)


def _kept(radius_ratio: float) -> float:
    """Chittenden's factor of the side leakage."""
    return 1.0 - exp(-1.23 * radius_ratio ** (-2 / 3))


def _own_unit(parameters: Parameters, flow: FlowDirection) -> float:
    """Moes' unit with the radius along the flow, (2 U_e)^{1/2} R_e, in the contact's own a^2/R."""
    e = parameters.ellipse
    return 1.0 / (sqrt(flow.curvature) * cbrt(1.5 * e.kappa * e.beta * parameters.M) ** 2)


def starved_share(r: float, exponent: float = ROLLING_EXPONENT) -> float:
    """The film over the flooded one, R = r/(1 + r^g)^(1/g), g: exponent.

    Chevalier F, Lubrecht AA, Cann PME, Colin F, Dalmaz G. Film thickness in starved EHL point contacts. J Tribol
    1998;120:126-133, for circular rolling contacts at maximum pressures where the oil hardly flows to the sides.
    r: the oil that enters over what the flooded film takes, layer/(rho_c H_c), rho_c: the density in the contact over
    that at ambient pressure; above zero.
    """
    require_positive(r=r)
    return (1.0 + r**-exponent) ** (-1.0 / exponent)


class FormulaFilm(NamedTuple):
    """Result of one formula for one contact.

    central, minimum: film thickness in a^2/R, None if the formula does not give it.  valid: the formula's range, in
    words.  inside: whether the contact is in that range, None if the source gives no bounds.
    """

    name: str
    central: float | None
    minimum: float | None
    source: str
    valid: str
    inside: bool | None

    def starved(self, oil: float) -> "FormulaFilm":
        """The central film on a layer of oil (a^2/R, at the density in the contact); the minimum falls by less."""
        assert self.central is not None
        valid = f"R = r/(1 + r^g)^(1/g), g = {ROLLING_EXPONENT} (published: 2 to 5), r = layer/(rho_c H_c flooded)"
        film = self.central * starved_share(oil / self.central)
        return FormulaFilm(f"{self.name}, starved", film, None, SOURCES["Chevalier et al."], valid, self.inside)


def films(parameters: Parameters, ugw: HamrockDowson | None = None, angle: float = 0.0) -> list[FormulaFilm]:
    """All formulas for a contact, in its own a^2/R.

    ugw: U, G, W with the radius R_x; the formulas in U, G, W need it, with G > 0.  angle: from the axis x of the
    ellipse to the flow, in degrees.  A formula that was not made for flow along the longer axis, or for flow at an
    angle to the axes, is left out or marked as outside its range.
    """
    flow = FlowDirection.at(parameters.radius_ratio, angle)
    (M, L), D = flow.moes(parameters), flow.radius_ratio
    along_an_axis = parameters.radius_ratio == 1.0 or angle % 90.0 == 0.0
    of_ugw = _films_of_ugw(ugw, parameters.ellipse, flow, along_an_axis) if ugw is not None and ugw.G > 0 else []
    if D > 1.0:
        return of_ugw
    unit, joined = _own_unit(parameters, flow) / moes_unit(M), nijenbanning_venner_moes(M, L, D)
    asymptotes = {
        "isoviscous, rigid": (isoviscous_rigid(M, D), "M small, L = 0"),
        "isoviscous, elastic": (isoviscous_elastic(M, D), "M large, L = 0"),
    }
    if L > 0:
        asymptotes |= {
            "piezoviscous, rigid": (piezoviscous_rigid(M, L, D), "M small, L large"),
            "piezoviscous, elastic": (piezoviscous_elastic(M, L, D), "M and L large"),
        }

    def of_moes(name: str, film: float, valid: str, inside: bool) -> FormulaFilm:
        return FormulaFilm(name, film * unit, None, SOURCES[NVM], valid, inside and along_an_axis)

    regimes = [of_moes(name, film, at, abs(film / joined - 1.0) < CLOSE) for name, (film, at) in asymptotes.items()]
    return [of_moes(NVM, joined, "all M and L; Barus' law; flow along the shorter axis", True), *of_ugw, *regimes]


def _films_of_ugw(ugw: HamrockDowson, e: HertzEllipse, flow: FlowDirection, along_an_axis: bool) -> list[FormulaFilm]:
    """The formulas of Hamrock and Dowson, of Chittenden, and of the line contact with the same Hertz pressure."""
    at = flow.ugw(ugw)
    unit = flow.curvature * cbrt(1.5 * e.kappa * e.beta * ugw.W) ** 2  # the contact's own a^2/R over R_e
    k = BALL * flow.radius_ratio**-0.64

    def film(
        name: str, central: float | None, minimum: float | None, valid: str, inside: bool | None = None
    ) -> FormulaFilm:
        c, m = (value if value is None else value / unit for value in (central, minimum))
        return FormulaFilm(name, c, m, SOURCES[name], valid, inside)

    hard = 8e-13 <= at.U <= 5.1e-11 and 2300 <= at.G <= 6800 and 1 <= k <= 8.1 and along_an_axis
    hamrock_dowson = hamrock_dowson_central(at, k), hamrock_dowson_minimum(at, k)
    chittenden = chittenden_central(at, flow.radius_ratio), chittenden_minimum(at, flow.radius_ratio)
    results = [
        film("Hamrock-Dowson", *hamrock_dowson, "U = 8e-13 to 5e-11, G = 2300 to 6800, k = 1 to 8", hard),
        film("Chittenden et al.", *chittenden, "piezoviscous, elastic; flow at any angle to the axes"),
    ]
    if flow.radius_ratio > 1.0 or not along_an_axis:
        return results
    line = line_contact(at, flow.radius_ratio)
    long = 1e-13 <= line.U <= 1e-11 and 2500 <= line.G <= 5000 and 3e-5 <= line.W <= 3e-4
    same, range_ = "line contact of the same p_h", "U = 1e-13 to 1e-11, G = 2500 to 5000, W' = 3e-5 to 3e-4"
    return [
        *results,
        film("Dowson-Higginson", None, dowson_higginson_minimum(line), f"{same}: {range_}", long),
        film("Dowson-Toyoda", dowson_toyoda_central(line), None, same),
    ]


def _elliptic(D: float) -> float:
    return 1.0 + 0.006 * log(D) + 0.63 * D ** (4 / 7)


def _checked(parameters: HamrockDowson, **others: float) -> HamrockDowson:
    require_positive(**parameters._asdict(), **others)
    return parameters


def _checked_ratio(radius_ratio: float) -> float:
    if not 0.0 < radius_ratio <= 1.0:
        raise ValueError(f"radius_ratio = {radius_ratio}: must be above 0 and at most 1 (slender along the flow)")
    return radius_ratio
