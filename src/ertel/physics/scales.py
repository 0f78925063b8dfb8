"""Scales and dimensionless parameters: from physical input to (lambda_bar, alpha_bar) and back to SI.

Impact and rolling have the same equation.  Both give a record `Scales`, and one function computes from it
lambda_bar = 12 eta0 R^2/(t0 a^2 p_h), eqs. (8) and (12) of the paper.  Only the time scale differs: t0 = delta*/v0 in
an impact (13), t0 = a/u_m in a rolling contact (9).

======================  =========================================================================================
symbol                  meaning
======================  =========================================================================================
E_prime (E')            reduced modulus, 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2
R                       reduced radius, 1/R = 1/R1 + 1/R2; of an ellipse R_x, that along its axis x
a, p_h, delta*, F*      Hertz contact radius, pressure, approach and load: at the maximum of the dry impact (impact),
                        under the static load (rolling); F = (2/3) E' sqrt(R) delta^{3/2}, a^2 = R delta,
                        p_h = E' a/(pi R); of an ellipse a is the half width b along x, see `geometry`
D, kappa, beta          of an ellipse: R_x/R_y, and the constants that follow from it (`dry_contact.HertzEllipse`)
U, G, W                 Hamrock and Dowson's speed, material and load parameters; U uses the mean speed u_m
M, L                    Moes' load and lubricant parameters; 2U is the speed parameter of the sum of the speeds
M_BH, L_BH              those of Biboulet and Houpert (2010), M beta^{1/4} kappa and L beta^{-3/4}: with them every
                        ellipse has the circle's relations to lambda_bar and alpha_bar
======================  =========================================================================================

All functions take and return SI units.
"""

from dataclasses import dataclass
from math import cbrt, cos, inf, pi, radians, sin, sqrt
from typing import NamedTuple

from ertel.physics.dry_contact import CIRCULAR, DryContact, HertzEllipse, hertz_ellipse
from ertel.physics.units import require_not_negative, require_positive

ISOVISCOUS_FILM = 0.3135  # H_c / sqrt(lambda_bar) at the maximum of an isoviscous impact (computed)


def _fourth_root(value: float) -> float:
    return sqrt(sqrt(value))


@dataclass(frozen=True)
class Parameters:
    """The dimensionless parameters of a smooth contact, for impact and rolling.

    Parameters
    ----------
    lambda_bar : float
        Speed parameter 12 eta0 R^2/(t0 a^2 p_h), eqs. (8), (12).  Above zero.
    alpha_bar : float
        Pressure-viscosity coefficient times Hertz pressure, alpha p_h.  Zero means isoviscous.
    hertz : HertzEllipse or HertzLine
        The constants of the dry contact, and with them D = R_x/R_y; left out: those of a circle.

    Examples
    --------
    >>> case = Parameters.from_moes(M=1000, L=10)
    >>> round(case.M), round(case.L), round(case.lambda_bar, 8)
    (1000, 10, 0.00109777)
    """

    lambda_bar: float
    alpha_bar: float
    hertz: DryContact = CIRCULAR

    def __post_init__(self) -> None:
        require_positive(lambda_bar=self.lambda_bar)
        require_not_negative(alpha_bar=self.alpha_bar)

    @classmethod
    def from_moes(cls, M: float, L: float, hertz: DryContact = CIRCULAR) -> "Parameters":
        """Parameters from Moes' load parameter M > 0 and lubricant parameter L >= 0."""
        require_positive(M=M)
        require_not_negative(L=L)
        M_BH, L_BH = M * _fourth_root(hertz.beta) * hertz.kappa, L / _fourth_root(hertz.beta) ** 3
        return cls(cbrt(128 * pi**3 / (3 * M_BH)) / M_BH, L_BH / pi * cbrt(1.5 * M_BH), hertz)

    @property
    def radius_ratio(self) -> float:
        """D = R_x/R_y; 1 for a circular contact, 0 for a line."""
        return self.hertz.radius_ratio

    @property
    def M(self) -> float:
        """Moes' load parameter, of a circle M_BH."""
        return self.M_BH / (_fourth_root(self.hertz.beta) * self.hertz.kappa)

    @property
    def L(self) -> float:
        """Moes' lubricant parameter, of a circle L_BH."""
        return self.L_BH * _fourth_root(self.hertz.beta) ** 3

    @property
    def M_BH(self) -> float:
        """Load parameter (128 pi^3/(3 lambda_bar^3))^{1/4}; the paper's list of symbols omits the last cube."""
        return sqrt(sqrt(128 * pi**3 / (3 * self.lambda_bar)) / self.lambda_bar)

    @property
    def L_BH(self) -> float:
        """Lubricant parameter alpha_bar (lambda_bar pi^3/6)^{1/4}."""
        return self.alpha_bar * _fourth_root(self.lambda_bar * pi**3 / 6)

    @property
    def stokes(self) -> float:
        """Stokes number of the impact: m v0 over what the oil takes while the film of rigid bodies falls by a factor e.

        For a ball m v0/(6 pi eta0 R^2) = 16/(15 lambda_bar); for an ellipse R^2 is 2 (R_x R_y)^{3/2}/(R_x + R_y).
        """
        D, e = self.radius_ratio, self.hertz
        return 16 / (15 * self.lambda_bar) * e.approach / e.kappa * (1 + D) * sqrt(D) / 2

    @property
    def as_ball(self) -> "Parameters":
        """The ball with this Stokes number and alpha_bar: as much of its load is carried by the oil far away."""
        return Parameters(16 / (15 * self.stokes), self.alpha_bar)

    @property
    def trapped_film(self) -> float:
        """Scale of the film thickness that an impact traps, in units a^2/R.

        It is sqrt(L/M) = sqrt(alpha_bar lambda_bar)/2, the film thickness at which a rigid ball stops in a Barus oil,
        but at least 0.3135 sqrt(lambda_bar), the film thickness that elastic deformation alone traps for alpha_bar = 0.
        The pressure between rigid ellipsoids is 2/(1 + D) times that of balls, so that lambda_bar counts by that much.
        """
        lambda_bar = self.lambda_bar * 2 / (1 + self.radius_ratio)
        return max(0.5 * sqrt(self.alpha_bar * lambda_bar), ISOVISCOUS_FILM * sqrt(lambda_bar))

    @property
    def impact_films(self) -> tuple[float, float]:
        """Least and largest expected central film of an impact at maximum approach, in units a^2/R.

        Measured: 0.62 to 0.69 of the film at which a rigid ball stops for M = 20 to 10000, L = 2 to 15 and Roelands'
        law; 0.97 to 1.00 of `trapped_film` in an isoviscous oil with lambda_bar = 1e-4 to 0.1.
        """
        isoviscous = ISOVISCOUS_FILM * sqrt(self.lambda_bar * 2 / (1 + self.radius_ratio))
        return max(0.6 * self.trapped_film, 0.95 * isoviscous), max(0.7 * self.trapped_film, isoviscous)

    def at(self, load: float, speed: float, curvature: float = 1.0) -> "Parameters":
        """The parameters under a load w in F*, at a speed U in a/t0, of a radius R/c; all three above zero."""
        U = speed * curvature  # over R
        return Parameters.from_moes(self.M * load * curvature**2 * U**-0.75, self.L * U**0.25, self.hertz)

    def nabla2(self, wavelength: float) -> float:
        """Operating parameter of amplitude reduction, eq. (16): wavelength sqrt(M_BH/L_BH), wavelength in units a.

        It is infinite for alpha_bar = 0; the theory does not cover that case.  It was made for circular contacts.
        """
        require_positive(wavelength=wavelength)
        return wavelength * 2 / sqrt(self.alpha_bar * self.lambda_bar) if self.alpha_bar > 0 else inf


@dataclass(frozen=True)
class Scales:
    """The SI value of one unit of each dimensionless quantity.

    Parameters
    ----------
    R, E_prime : float
        Reduced radius (m) and reduced modulus (Pa).
    a, p_h : float
        Units of X, Y (m) and of P (Pa): Hertz contact radius and pressure.
    t0 : float
        Unit of T (s).
    hertz : HertzEllipse or HertzLine
        The constants of the dry contact; left out: those of a circle.
    """

    R: float
    E_prime: float
    a: float
    p_h: float
    t0: float
    hertz: DryContact = CIRCULAR

    parameters = Parameters

    def __post_init__(self) -> None:
        require_positive(R=self.R, E_prime=self.E_prime, a=self.a, p_h=self.p_h, t0=self.t0)

    @property
    def a_y(self) -> float:
        """Half width (m) of the Hertz contact along its axis y, or half the length of a line; that along x is a."""
        return self.a * self.hertz.wide

    @property
    def film(self) -> float:
        """Unit of H, Delta and roughness (m): a^2/R; of a circular contact delta*, the Hertz approach."""
        return self.a**2 / self.R

    @property
    def shear_stress(self) -> float:
        """Unit of the shear stress across the film (Pa): p_h a/R."""
        return self.p_h * self.a / self.R

    @property
    def a_over_R(self) -> float:
        """Unit of a coefficient of friction, shear stress over pressure: a/R."""
        return self.a / self.R

    @property
    def power_per_area(self) -> float:
        """Unit of the power loss per area (W/m^2): shear stress times speed along the surface."""
        return self.shear_stress * self.front_speed

    @property
    def approach(self) -> float:
        """The Hertz approach delta* (m)."""
        return self.hertz.approach * self.film

    @property
    def area(self) -> float:
        """Unit of an area of the surface (m^2): a^2; of a line contact b over the whole length."""
        return self.a**2 * self.hertz.across

    @property
    def force(self) -> float:
        """Unit of the double integral of P (N): area p_h."""
        return self.area * self.p_h

    @property
    def load(self) -> float:
        """Unit of the load F (N): the Hertz load F* = (2 pi/3) a a_y p_h, of a line (pi/2) b length p_h."""
        return self.hertz.load * self.area * self.p_h

    @property
    def speed(self) -> float:
        """Unit of dDelta/dT and dH/dT (m/s): film/t0; v0 in an impact."""
        return self.film / self.t0

    @property
    def front_speed(self) -> float:
        """Unit of speeds along the surface (m/s): a/t0; u_m in rolling, the scale of the front speed in an impact."""
        return self.a / self.t0

    @property
    def oil(self) -> float:
        """Unit of an amount of oil (m^3 at ambient pressure): area film."""
        return self.area * self.film

    @property
    def oil_flow(self) -> float:
        """Unit of a flow of oil (m^3/s): oil/t0."""
        return self.oil / self.t0

    @property
    def momentum(self) -> float:
        """Unit of momentum (N s): F* t0."""
        return self.load * self.t0

    @property
    def energy(self) -> float:
        """Unit of energy (J): F* a^2/R; m v0^2/2 of a ball's impact is 2/5 of it."""
        return self.load * self.film

    @property
    def power(self) -> float:
        """Unit of power (W): F* a^2/(R t0)."""
        return self.energy / self.t0

    @property
    def W(self) -> float:
        """Hamrock and Dowson's load parameter F*/(E' R^2)."""
        return self.load / (self.E_prime * self.R**2)

    @property
    def ball_mass(self) -> float:
        """Mass (kg) of the body whose dry impact has these scales."""
        return self.hertz.inertia * self.load * self.t0**2 / self.film


def _hertz_scales(R: float, E_prime: float, a: float, t0: float, e: HertzEllipse) -> Scales:
    return Scales(R, E_prime, a, E_prime * a / (pi * e.beta * R), t0, e)


def impact_scales(R: float, mass: float, speed: float, E_prime: float, radius_ratio: float = 1.0) -> Scales:
    """Scales of an impact: the Hertz contact at the maximum of the dry impact, t0 = a^2/(R v0), eq. (13).

    At the maximum all kinetic energy is stored elastically, m v0^2/2 = (2/5) F* delta*; for a ball that is
    (4/15) E' sqrt(R) delta*^{5/2}.  mass, speed: of the ball (kg), at first touch (m/s).  The others as in `Scales`.

    Examples
    --------
    >>> scales = impact_scales(R=0.01, mass=0.0326726, speed=0.1, E_prime=226.37e9)
    >>> f"{scales.a:.4g} m, {scales.p_h:.4g} Pa, {scales.film:.4g} m, {scales.t0:.4g} s"
    '0.0001934 m, 1.394e+09 Pa, 3.741e-06 m, 3.741e-05 s'
    """
    require_positive(R=R, mass=mass, speed=speed, E_prime=E_prime)
    e = hertz_ellipse(radius_ratio)
    film = (15 * mass * speed**2 * e.kappa * e.beta / (8 * E_prime * sqrt(R) * e.approach)) ** 0.4
    return _hertz_scales(R, E_prime, sqrt(R * film), film / speed, e)


def rolling_scales(R: float, load: float, mean_speed: float, E_prime: float, radius_ratio: float = 1.0) -> Scales:
    """Scales of a rolling contact: the Hertz contact under the static load, t0 = a/u_m, eq. (9).

    The half width is a^3 = 3 kappa beta F R/(2 E').  load: F (N).  mean_speed: u_m = (u1 + u2)/2 (m/s).  The others as
    in `Scales`.
    """
    require_positive(R=R, load=load, mean_speed=mean_speed, E_prime=E_prime)
    e = hertz_ellipse(radius_ratio)
    a = cbrt(1.5 * load * R / E_prime * e.kappa * e.beta)
    return _hertz_scales(R, E_prime, a, a / mean_speed, e)


def parameters(scales: Scales, eta0: float, alpha: float) -> Parameters:
    """lambda_bar and alpha_bar of an impact or a rolling contact, eq. (8) = eq. (12).

    eta0 is the viscosity at ambient pressure (Pa s), alpha the pressure-viscosity coefficient (1/Pa; 0: isoviscous).
    """
    require_positive(eta0=eta0)
    require_not_negative(alpha=alpha)
    lambda_bar = 12 * eta0 * scales.R**2 / (scales.t0 * scales.a**2 * scales.p_h)
    return scales.parameters(lambda_bar, alpha * scales.p_h, scales.hertz)


class HamrockDowson(NamedTuple):
    """Hamrock and Dowson's parameters U = eta0 u_m/(E' R), G = alpha E', W = F/(E' R^2)."""

    U: float
    G: float
    W: float


def hamrock_dowson(scales: Scales, eta0: float, alpha: float) -> HamrockDowson:
    """U, G, W of a contact with the given scales; an impact uses F* as the load and a/t0 as the speed u_m.

    For an ellipse R is R_x; W of a line contact is that of its load per length, w1/(E' R).
    """
    require_positive(eta0=eta0)
    require_not_negative(alpha=alpha)
    return HamrockDowson(
        U=eta0 * scales.front_speed / (scales.E_prime * scales.R),
        G=alpha * scales.E_prime,
        W=scales.W,
    )


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
