"""Film thickness formulas for steady rolling, for comparison and for extrapolation.

All formulas are for fully flooded, isothermal, Newtonian contacts with smooth surfaces.  `films` evaluates them for a
circular or an elliptical contact, and says of each whether the contact is inside its range.  `regime_of` names the
regime.  `starved_share` is the part of a flooded film that a thin layer of oil leaves.

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

Ranges.  With these models a film depends on M, L and the ellipticity alone: U, G, W enter by M and L (Moes).  So the
range of a formula fitted to computed contacts is that of their M, L and k, in the regime for which it was made.

Regimes are those of Hamrock's map of g_V and g_E, which is Johnson's chart for ellipses (`regime_of`).  Its film of the
piezoviscous-rigid regime is not among `films`: for M = 5, L = 22 it is a quarter of ertel's, which is 0.9 of
Nijenbanning's.
"""

from collections.abc import Sequence
from math import atan, cbrt, exp, log, pi, sqrt
from typing import NamedTuple

from ertel.physics.dry_contact import DryContact, hertz_ellipse
from ertel.physics.scales import FlowDirection, HamrockDowson, Parameters
from ertel.physics.units import require_not_negative, require_positive

HARD = (12.0, 1000.0), (3.0, 14.5), (1.0, 8.1)  # M, L and k of `hamrock_dowson_central`
SOFT = (70.0, 1300.0), (1.0, 6.1)  # M and k of `soft_film`
LONG = (1e-13, 1e-11), (2500.0, 5000.0), (3e-5, 3e-4)  # U, G and W' of `dowson_higginson_minimum`
MOST_SLENDER = 8.0  # R_e/R_s, up to which Chittenden's film was compared with ertel's
BALL = 1.03  # ellipticity of a ball by Hamrock and Dowson's fit k = 1.03 (Ry/Rx)^0.64; the exact value is 1
CLOSE = 0.1  # an asymptote holds if it is within this relative distance of the Nijenbanning-Venner-Moes formula, and a
# line contact's film if Chittenden's formula has less than this leak to the sides

ROLLING_EXPONENT = 2.7  # g of `starved_share`, within 0.02 of ertel's films at M = 200, L = 10; published: 2 to 5
IMPACT_EXPONENT = 2.2  # within 2 % at maximum approach, M = 200 and 1000, L = 10

REGIMES = {
    "isoviscous, rigid": "M small, L = 0",
    "isoviscous, elastic": "M large, L = 0",
    "piezoviscous, rigid": "M small, L large",
    "piezoviscous, elastic": "M and L large",
}
NVM = "Nijenbanning-Venner-Moes"
SOURCES = {
    NVM: "Nijenbanning G, Venner CH, Moes H. Wear 1994;176:217-229",
    "Hamrock-Dowson": "Hamrock BJ, Dowson D. J Lubr Technol 1977;99:264-276",
    "Hamrock-Dowson, soft": "Hamrock BJ, Dowson D. J Lubr Technol 1978;100:236-245, by M",
    "Brewe et al., rigid": "Brewe DE, Hamrock BJ, Taylor CM. J Lubr Technol 1979;101:231-239",
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
    unit, D = moes_unit(M), radius_ratio
    RI, EI, RP, EP = (film / unit for film in asymptotes(M, L, D).values())
    limit = 1.8 / D
    isoviscous = RI**1.5 + (EI**-4 + limit**-4) ** (-3 / 8)
    if L == 0:
        return unit * isoviscous ** (2 / 3)
    s = 1.5 * (1.0 + exp(-1.2 * EI / EP))
    return unit * (isoviscous ** (2 * s / 3) + (RP**-8 + EP**-8) ** (-s / 8)) ** (1 / s)


def asymptotes(M: float, L: float, radius_ratio: float = 1.0) -> dict[str, float]:
    """The central films (a^2/R) of the four regimes by their names, for rx/ry <= 1."""
    D = radius_ratio
    films = isoviscous_rigid(M, D), isoviscous_elastic(M, D), piezoviscous_rigid(M, L, D), piezoviscous_elastic(M, L, D)
    return dict(zip(REGIMES, films, strict=True))


def regime_of(M: float, L: float, radius_ratio: float = 1.0) -> str:
    """The regime on the map of g_V and g_E: that with the thickest minimum film.

    h/R (W/U)^2 is that of `rigid_film` and `soft_film`, in the piezoviscous-rigid regime (Jeng, Hamrock, Brewe 1987)
    141 g_V^0.375 (1 - exp(-0.0387 Ry/Rx)), and in the piezoviscous-elastic one 3.42 g_V^0.49 g_E^0.17
    (1 - exp(-0.68 k)).  Esfahanian M, Hamrock BJ. Tribol Trans 1991;34:628-632.  radius_ratio: Rx/Ry; above 1, for
    which the map was not made, as of a ball.
    """
    D, (g_V, g_E) = min(radius_ratio, 1.0), regime_numbers(M, L)
    k, hat = BALL * D**-0.64, 4.0 * M**2 / moes_unit(M)
    isoviscous = rigid_film(M, D) * hat, soft_film(M, k)[1] * hat
    rigid = 141.0 * g_V**0.375 * (1.0 - exp(-0.0387 / D))
    films = *isoviscous, rigid, 3.42 * g_V**0.49 * g_E**0.17 * (1.0 - exp(-0.68 * k))
    return max(zip(films, REGIMES, strict=True))[1]


def regime_numbers(M: float, L: float) -> tuple[float, float]:
    """Viscosity parameter g_V = G W^3/U^2 = 4 L M^3 and elasticity parameter g_E = W^{8/3}/U^2 = 4 M^{8/3}."""
    return 4.0 * L * M**3, 4.0 * cbrt(M) ** 8


def rigid_film(M: float, radius_ratio: float = 1.0) -> float:
    """Central and minimum film (a^2/R) of rigid bodies with an isoviscous oil, by computed films.

    h/R (W/U)^2 = 128 q (0.131 atan(q/2) + 1.683)^2/(1 + 2/(3 q))^2, q = Ry/Rx.  Brewe DE, Hamrock BJ, Taylor CM. J Lubr
    Technol 1979;101:231-239, in the form of Hamrock and Dowson's maps (5th Leeds-Lyon Symp 1979:22-27).  Kapitza, with
    P = 0 beyond the thinnest place, has pi/2 in place of the bracket.  For a ball with M = 0.3 and 1, L = 0, ertel's
    films (65 nodes) are 4 % below; `isoviscous_rigid` is 18 % above.
    """
    q = 1.0 / _checked_ratio(radius_ratio)
    rigid = 128.0 * q * (0.131 * atan(q / 2.0) + 1.683) ** 2 / (1.0 + 2.0 / (3.0 * q)) ** 2
    return moes_unit(M) * rigid / (4.0 * M**2)


def soft_film(M: float, ellipticity: float = BALL) -> tuple[float, float]:
    """Central and minimum film (a^2/R) of soft bodies with an isoviscous oil.

    h/R (W/U)^2 = 11.15 g_E^0.67 (1 - 0.72 exp(-0.28 k)) and 8.70 g_E^0.67 (1 - 0.85 exp(-0.31 k)).  Hamrock BJ, Dowson
    D. J Lubr Technol 1978;100:236-245 (with U^0.64 W^-0.22 and U^0.65 W^-0.21), in the form of their maps (5th
    Leeds-Lyon Symp 1979:22-27).  17 computed contacts, U = 5e-9 to 5e-8, W = 2e-4 to 2e-3, k = 1 to 6: M = 70 to 1300,
    L almost zero.  The central film is 5 % above ertel's for M = 100 and 16 % below for M = 1000.
    """
    require_positive(ellipticity=ellipticity)
    common = moes_unit(M) * regime_numbers(M, 0.0)[1] ** 0.67 / (4.0 * M**2)
    k = ellipticity
    return common * 11.15 * (1.0 - 0.72 * exp(-0.28 * k)), common * 8.70 * (1.0 - 0.85 * exp(-0.31 * k))


def hamrock_dowson_central(parameters: HamrockDowson, ellipticity: float = BALL) -> float:
    """Central film thickness h_c/R = 2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 k)).

    Hamrock BJ, Dowson D. Isothermal elastohydrodynamic lubrication of point contacts, part III. J Lubr Technol
    1977;99:264-276.  The 34 computed contacts have k = 1 to 8, U = 8e-13 to 5e-11, G = 2300 to 6800, W = 1.1e-7 to
    1.1e-6, varied one at a time: M is about 12 to 450, L 3 to 14.  Up to M = 1000 the film is 5 to 14 % below ertel's
    (L = 5, 10).  Of rigid bodies it falls short without limit.  ellipticity: k, half width across the flow over along.
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
    and 1.30 for the first and the last constant.  The range in M and L is taken from Hamrock and Dowson, whose formula
    it goes on from: that of its own contacts is not known here.
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
    Symposium on Tribology (1978), 1979:60-65.  Its own range is not known here; that of the minimum film is taken.
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
    e = parameters.hertz
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
    words.  inside: whether the contact is in that range.
    """

    name: str
    central: float | None
    minimum: float | None
    source: str
    valid: str
    inside: bool

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
    of_ugw = _films_of_ugw(ugw, parameters.hertz, flow, along_an_axis) if ugw is not None and ugw.G > 0 else []
    if D > 1.0:
        return of_ugw
    unit, joined = _own_unit(parameters, flow) / moes_unit(M), nijenbanning_venner_moes(M, L, D)
    k, regimes = BALL * D**-0.64, asymptotes(M, L, D)
    holds = {name: along_an_axis and abs(film / joined - 1.0) < CLOSE for name, film in regimes.items()}

    def of_moes(name: str, film: float, valid: str, inside: bool, minimum: float | None = None) -> FormulaFilm:
        return FormulaFilm(
            name, film * unit, minimum and minimum * unit, SOURCES.get(name, SOURCES[NVM]), valid, inside
        )

    soft, rigid = soft_film(M, k), rigid_film(M, D)
    is_soft = holds["isoviscous, elastic"] and _inside((M, k), SOFT)
    return [
        of_moes(NVM, joined, "all M and L; Barus' law; flow along the shorter axis", along_an_axis),
        *of_ugw,
        of_moes("Hamrock-Dowson, soft", soft[0], "isoviscous, elastic; M = 70 to 1300, k = 1 to 6", is_soft, soft[1]),
        of_moes("Brewe et al., rigid", rigid, "isoviscous, rigid", holds["isoviscous, rigid"], rigid),
        *(of_moes(name, film, REGIMES[name], holds[name]) for name, film in regimes.items() if film),
    ]


def _films_of_ugw(ugw: HamrockDowson, e: DryContact, flow: FlowDirection, along_an_axis: bool) -> list[FormulaFilm]:
    """The formulas of Hamrock and Dowson, of Chittenden, and of the line contact with the same Hertz pressure."""
    at, D = flow.ugw(ugw), flow.radius_ratio
    unit = flow.curvature * cbrt(1.5 * e.kappa * e.beta * ugw.W) ** 2  # the contact's own a^2/R over R_e
    k, root = BALL * D**-0.64, sqrt(sqrt(2.0 * at.U))
    M, L = at.W / root**3, at.G * root

    def film(name: str, central: float | None, minimum: float | None, valid: str, inside: bool) -> FormulaFilm:
        c, m = (value if value is None else value / unit for value in (central, minimum))
        return FormulaFilm(name, c, m, SOURCES[name], valid, inside)

    hard = regime_of(M / 2.0, L, D) == "piezoviscous, elastic" and _inside((M, L, max(k, HARD[2][0])), HARD)
    hamrock_dowson = hamrock_dowson_central(at, k), hamrock_dowson_minimum(at, k)
    chittenden = chittenden_central(at, D), chittenden_minimum(at, D)
    range_ = "piezoviscous, elastic, also at half the load; M = 12 to 1000, L = 3 to 14"
    any_way = f"{range_}, R_e/R_s = 1/25 to {MOST_SLENDER:g}; flow at any angle to the axes"
    results = [
        film("Hamrock-Dowson", *hamrock_dowson, f"{range_}, k = 1 to 8", hard and along_an_axis and D <= 1.0),
        film("Chittenden et al.", *chittenden, any_way, hard and D <= MOST_SLENDER),
    ]
    if D > 1.0 or not along_an_axis:
        return results
    line = line_contact(at, D)
    long = 1.0 - _kept(D) < CLOSE and _inside(line, LONG)
    same = "long ellipse as a line contact of the same p_h: U = 1e-13 to 1e-11, G = 2500 to 5000, W' = 3e-5 to 3e-4"
    return [
        *results,
        film("Dowson-Higginson", None, dowson_higginson_minimum(line), same, long),
        film("Dowson-Toyoda", dowson_toyoda_central(line), None, same, long),
    ]


def _inside(values: Sequence[float], ranges: Sequence[tuple[float, float]]) -> bool:
    return all(least <= value <= most for value, (least, most) in zip(values, ranges, strict=True))


def _elliptic(D: float) -> float:
    return 1.0 + 0.006 * log(D) + 0.63 * D ** (4 / 7)


def _checked(parameters: HamrockDowson, **others: float) -> HamrockDowson:
    require_positive(**parameters._asdict(), **others)
    return parameters


def _checked_ratio(radius_ratio: float) -> float:
    if not 0.0 < radius_ratio <= 1.0:
        raise ValueError(f"radius_ratio = {radius_ratio}: must be above 0 and at most 1 (slender along the flow)")
    return radius_ratio
