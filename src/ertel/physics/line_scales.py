"""Scales and dimensionless parameters of a line contact: of two cylinders with parallel axes.

The two formulas for lambda_bar and alpha_bar are those of `scales`; only the dry contact and the relation to Moes'
numbers differ.  With the load per length w1:

    b = sqrt(8 w1 R/(pi E')),    p_h = E' b/(4 R),    w1 = (pi/2) b p_h
    M = w1/(E' R) (2 U)^(-1/2) = sqrt(3 pi^2/(8 lambda_bar)),    L = alpha E' (2 U)^(1/4) = alpha_bar sqrt(2 pi/M)

Units are those of the whole contact: N, W and J belong to its length.
"""

from dataclasses import dataclass
from math import inf, pi, sqrt

from ertel.physics.dry_contact import DryContact, HertzLine
from ertel.physics.scales import Parameters, Scales
from ertel.physics.units import require_not_negative, require_positive

USUAL_LINE = HertzLine(100.0)
ROUNDS = 30  # to find the contact of an impact, whose stiffness depends on its length; each leaves a tenth


@dataclass(frozen=True)
class LineParameters(Parameters):
    """The dimensionless parameters of a smooth line contact, for impact and rolling.

    Parameters
    ----------
    lambda_bar, alpha_bar : float
        See `Parameters`.
    hertz : HertzLine
        The dry contact, with the length over the half width, which matters to an impact only; left out: 100.

    Examples
    --------
    >>> line = LineParameters.from_moes(M=20, L=10)
    >>> round(line.lambda_bar, 8), round(line.alpha_bar, 4)
    (0.00925275, 17.8412)
    """

    hertz: DryContact = USUAL_LINE

    @classmethod
    def from_moes(cls, M: float, L: float, hertz: DryContact = USUAL_LINE) -> "LineParameters":
        """Parameters from Moes' load parameter M > 0 and lubricant parameter L >= 0 of a line contact."""
        require_positive(M=M)
        require_not_negative(L=L)
        return cls(3 * pi**2 / (8 * M**2), L * sqrt(M / (2 * pi)), hertz)

    @property
    def M(self) -> float:
        """Moes' load parameter of a line contact."""
        return sqrt(3 * pi**2 / (8 * self.lambda_bar))

    @property
    def L(self) -> float:
        """Moes' lubricant parameter of a line contact."""
        return self.alpha_bar * sqrt(2 * pi / self.M)

    @property
    def M_BH(self) -> float:
        """The same as M."""
        return self.M

    @property
    def L_BH(self) -> float:
        """The same as L."""
        return self.L

    @property
    def stokes(self) -> float:
        """The inverse of the share of its speed that the oil takes from a rigid body until the film is b^2/R.

        Its pressure is lambda_bar V/(2 H^2), so that V falls by sqrt(2) lambda_bar/(inertia sqrt(H_c)).
        """
        return self.hertz.inertia / (sqrt(2) * self.lambda_bar)

    @property
    def as_ball(self) -> "LineParameters":
        """The same line contact: what the oil far away carries depends on lambda_bar here."""
        return self

    @property
    def trapped_film(self) -> float:
        """Scale of the film thickness that an impact traps, in units b^2/R.

        It is sqrt(alpha_bar lambda_bar/2), the film thickness at which a rigid cylinder stops in a Barus oil, but at
        least 0.44 sqrt(lambda_bar/kappa) with the dry approach kappa: what elastic deformation alone traps.
        """
        return max(sqrt(self.alpha_bar * self.lambda_bar / 2), self._isoviscous)

    @property
    def impact_films(self) -> tuple[float, float]:
        """Least and largest expected central film of an impact at maximum approach, in units b^2/R.

        Fitted: 0.43 L^0.18 kappa^-0.28 of the film at which a rigid cylinder stops, within 6 %, for alpha_bar = 10 to
        40 and Roelands' law; 0.43 to 0.46 sqrt(lambda_bar/kappa) in an isoviscous oil with lambda_bar = 1e-4 to 0.1.
        """
        stopped = sqrt(self.alpha_bar * self.lambda_bar / 2)
        film = 0.43 * self.L**0.18 * self.hertz.approach**-0.28 * stopped
        return max(0.94 * film, 0.98 * self._isoviscous), max(1.06 * film, 1.05 * self._isoviscous)

    @property
    def _isoviscous(self) -> float:
        return 0.44 * sqrt(self.lambda_bar / self.hertz.approach)

    def at(self, load: float, speed: float, curvature: float = 1.0) -> "LineParameters":
        """The parameters under a load w in F*, at a speed U in b/t0, of a radius R/c; all three above zero."""
        U = speed * curvature  # over R
        M, L = self.M * load * curvature * U**-0.5, self.L * U**0.25
        return LineParameters.from_moes(M, L, HertzLine(self.hertz.reach / sqrt(load / curvature)))

    def nabla2(self, wavelength: float) -> float:
        """Operating parameter of amplitude reduction of a line contact, (wavelength/b) M^(3/4)/L^(1/2).

        It is infinite for alpha_bar = 0.  Source: Venner CH, Couhier F, Lubrecht AA, Greenwood JA.  Leeds-Lyon Symp
        1996:221.
        """
        require_positive(wavelength=wavelength)
        return wavelength * self.M**0.75 / sqrt(self.L) if self.alpha_bar > 0 else inf


@dataclass(frozen=True)
class LineScales(Scales):
    """The SI value of one unit of each dimensionless quantity of a line contact.

    a is the half width b, and areas, loads and amounts of oil belong to the whole length.
    """

    parameters = LineParameters

    @property
    def length(self) -> float:
        """Length of the contact (m)."""
        return self.hertz.reach * self.a

    @property
    def W(self) -> float:
        """Dowson and Higginson's load parameter w1/(E' R), with the load per length."""
        return self.load / self.length / (self.E_prime * self.R)


def line_impact_scales(R: float, mass: float, speed: float, E_prime: float, length: float) -> LineScales:
    """Scales of the impact of a cylinder: the Hertz contact at the maximum of the dry impact, t0 = b^2/(R v0).

    All kinetic energy is then stored elastically, m v0^2 = inertia (pi E' length/(8 R^2)) b^4.  mass, speed: of the
    body (kg), at first touch (m/s).  The others as in `LineScales`.

    Examples
    --------
    >>> scales = line_impact_scales(R=0.01, mass=0.3, speed=1.0, E_prime=226e9, length=0.02)
    >>> f"{scales.a:.6g} m, {scales.p_h:.7g} Pa, {scales.hertz.reach:.5g}"
    '0.000283978 m, 1.604475e+09 Pa, 70.428'
    """
    require_positive(R=R, mass=mass, speed=speed, E_prime=E_prime, length=length)
    inertia = 1.0
    for _ in range(ROUNDS):
        b = (8 * R**2 * mass * speed**2 / (pi * E_prime * length * inertia)) ** 0.25
        inertia = max(HertzLine(length / b).inertia, 0.125)  # a length of some b, which a case does not allow
    return LineScales(R, E_prime, b, E_prime * b / (4 * R), b**2 / (R * speed), HertzLine(length / b))


def line_rolling_scales(R: float, load: float, mean_speed: float, E_prime: float, length: float) -> LineScales:
    """Scales of a rolling line contact: the Hertz contact under the static load, t0 = b/u_m.

    load: on the whole length (N).  mean_speed: u_m = (u1 + u2)/2 (m/s).  The others as in `LineScales`.
    """
    require_positive(R=R, load=load, mean_speed=mean_speed, E_prime=E_prime, length=length)
    b = sqrt(8 * load / length * R / (pi * E_prime))
    return LineScales(R, E_prime, b, E_prime * b / (4 * R), b / mean_speed, HertzLine(length / b))
