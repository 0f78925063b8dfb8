"""Shear-thinning oils: the fluidity as a function of the shear stress.

    du/dz = (phi(|tau|)/eta) tau,        phi = 1 for a Newtonian oil

eta is the viscosity at low stress and tau the shear stress, a vector.  Every law is a small frozen record in SI.  Its
two methods take the pressure too, in Pa, so that a stress of the law may depend on it (`Limited`):

* fluidity(stress, pressure): phi at |tau| in Pa.  It must be positive and must not fall with the stress.
* stress(rate, pressure): |tau| at the shear rate du/dz, given as eta du/dz in Pa.  It is only the start and the scale
  of an iteration (`ertel.equations.shear`): errors of half its value cost an iteration or two and no accuracy.

They accept floats, NumPy arrays and JAX arrays.  A user's own law needs no derivative.  It needs a registered name:

    @FLUIDITY_LAWS.register("rabinowitsch")
    @dataclass(frozen=True)
    class Rabinowitsch:
        tau0: Annotated[float, STRESS]

        def fluidity(self, stress, pressure):
            return 1 + (stress / self.tau0) ** 2

        def stress(self, rate, pressure):
            return rate / (1 + (rate / self.tau0) ** 2) ** (1 / 3)

Whether the oils of rolling contacts follow Eyring's or Carreau's law is disputed (Spikes H, Jie Z. Tribol Lett
2014;56:1-25, against Bair S, Vergne P, Kumar P, et al. Tribol Lett 2015;58:16), so that none is a default.
"""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Protocol

from ertel.physics.registry import FLUIDITY_LAWS, OfAnyOil, arrays_of
from ertel.physics.units import ABOVE_ZERO, SHARE, STRESS, Bounds, Meaning

Array = Any  # a NumPy or JAX array of any shape, or a float

EXPONENT = Bounds(gt=0, le=1)  # of a law that thins: 1 is Newtonian
ALMOST_ZERO = 1e-30  # a ratio of stresses that stands for zero where the formula has 0/0
NO_STRESS = 1e-200  # Pa
LARGEST_EXPONENT = 150.0  # exp(150) can still be squared, cubed in tensors; above, the fluidity stays as it is


class Fluidity(Protocol):
    """A law of shear thinning; |tau|, eta du/dz and the pressure in Pa."""

    def fluidity(self, stress: Array, pressure: Array) -> Array: ...

    def stress(self, rate: Array, pressure: Array) -> Array: ...


@FLUIDITY_LAWS.register("newtonian")
@dataclass(frozen=True)
class NewtonianOil(OfAnyOil):
    """phi = 1."""

    reference: ClassVar[str] = "constant fluidity"

    def fluidity(self, stress: Array, pressure: Array) -> Array:
        return arrays_of(stress).ones_like(stress)

    def stress(self, rate: Array, pressure: Array) -> Array:
        return rate


@FLUIDITY_LAWS.register("ree-eyring")
@dataclass(frozen=True)
class ReeEyring:
    """phi = sinh(x)/x with x = |tau|/tau0; constant above x = 150.

    tau0: Eyring's stress, some MPa for the oils of rolling contacts.
    """

    tau0: Annotated[float, STRESS, Meaning("Eyring's stress", "5 MPa")]
    reference: ClassVar[str] = (
        "Johnson KL, Tevaarwerk JL. Shear behaviour of elastohydrodynamic oil films. Proc R Soc Lond A 1977;356:215-236"
    )

    def fluidity(self, stress: Array, pressure: Array) -> Array:
        xp = arrays_of(stress)
        x = xp.clip(stress / self.tau0, ALMOST_ZERO, LARGEST_EXPONENT)
        growth = xp.expm1(x)
        return 0.5 * (growth + growth / (1.0 + growth)) / x  # sinh(x)/x with one exponential

    def stress(self, rate: Array, pressure: Array) -> Array:
        return self.tau0 * arrays_of(rate).asinh(rate / self.tau0)


@FLUIDITY_LAWS.register("carreau")
@dataclass(frozen=True)
class Carreau:
    """phi = (1 + x^2)^{(1/n - 1)/2} with x = |tau|/G: Bair's form, in the stress.

    It is not the form in the shear rate, eta (1 + (eta du/dz/G)^2)^{(n - 1)/2}, but has the same limits.  n = 1 is
    Newtonian.  G: the stress at which thinning begins.
    """

    title: ClassVar[str] = "Carreau's law"
    G: Annotated[float, STRESS, Meaning("stress at which the oil begins to thin", "5 MPa")]
    n: Annotated[float, EXPONENT, Meaning("exponent; 1: Newtonian", 0.5)]
    reference: ClassVar[str] = (
        "Bair S. A rough shear-thinning correction for EHD film thickness. Tribol Trans 2004;47:361-365"
    )

    def fluidity(self, stress: Array, pressure: Array) -> Array:
        xp = arrays_of(stress)  # the derivative of this form needs no second power
        return xp.exp(0.5 * (1.0 / self.n - 1.0) * xp.log(1.0 + (stress / self.G) ** 2))

    def stress(self, rate: Array, pressure: Array) -> Array:
        """The form in the shear rate."""
        xp = arrays_of(rate)
        return rate * xp.exp(0.5 * (self.n - 1.0) * xp.log(1.0 + (rate / self.G) ** 2))


@FLUIDITY_LAWS.register("limited")
@dataclass(frozen=True)
class Limited:
    """A law with a limiting shear stress tau_L = ambient + Lambda p, in a form without a jump or a pole.

    Shear rates add up: that of the law, and that of a film that slips when the stress comes near its limit.  With
    u = |tau|/tau_L,

        phi = phi of the law + (y(u) - u)/u
        y = atanh(u)                                      up to u1 = 1 - sharpness
        y = atanh(u1) + {exp[k (u - u1)] - 1}/(2 u1)      above, k = 2 u1/(1 - u1^2)

    Up to u1 a Newtonian oil has the law of Gecim and Winer, eta du/dz = tau_L atanh(tau/tau_L), which differs little
    from Bair and Winer's -tau_L ln(1 - tau/tau_L) but is smooth at tau = 0.  Both have a pole at tau_L: where the
    pressure gradient drives the stress at a wall to the limit, no stress in the middle carries the sliding (the film
    moves as a plug).  Therefore the law goes on above u1 as an exponential with the same value, slope and curvature.
    There the stress rises by sharpness * tau_L while the shear rate rises by a factor of e.  What rises above tau_L
    makes the flux have a solution; friction does not count it (`limited_stress`).

    base: the law without a limit.  Lambda: dtau_L/dp, 0.03 to 0.1 for most oils.  ambient: tau_L at ambient
    pressure, without which an oil could carry no stress at the edges of the film; 4 MPa is of a PAO.  sharpness: width
    of the exponential part.
    """

    base: Annotated[Fluidity, Meaning("the law without a limit: a table with one of the other laws")]
    Lambda: Annotated[float, ABOVE_ZERO, Meaning("growth of the limiting stress with pressure", 0.05)]
    ambient: Annotated[float, STRESS, Meaning("limiting stress at ambient pressure", "4 MPa")] = 4e6
    sharpness: Annotated[float, SHARE, Meaning("share of the limit over which the oil comes to slip")] = 0.05
    reference: ClassVar[str] = (
        "Gecim B, Winer WO. Lubricant limiting shear stress effect on EHD film thickness. J Lubr Technol "
        "1980;102:213-220; Bair S, Winer WO. A rheological model for elastohydrodynamic contacts based on primary "
        "laboratory data. J Lubr Technol 1979;101:258-264"
    )

    def limit(self, pressure: Array) -> Array:
        """tau_L in Pa; pressures below ambient count as ambient."""
        return self.ambient + self.Lambda * arrays_of(pressure).maximum(pressure, 0.0)

    def fluidity(self, stress: Array, pressure: Array) -> Array:
        xp = arrays_of(stress)
        end, growth = self._end(xp)
        u = xp.clip(stress / self.limit(pressure), ALMOST_ZERO, end + LARGEST_EXPONENT / growth)
        below = xp.minimum(u, end)
        above = u - below
        slip = 0.5 * xp.log1p(2.0 * below / (1.0 - below)) - below + xp.expm1(growth * above) / (2.0 * end) - above
        return self.base.fluidity(stress, pressure) + xp.maximum(slip, 0.0) / u

    def stress(self, rate: Array, pressure: Array) -> Array:
        """The smaller of the law's stress and of a limited Newtonian oil's, with a smooth passage."""
        xp = arrays_of(rate)
        limit, (end, growth) = self.limit(pressure), self._end(xp)
        y = rate / limit
        above = xp.maximum(y - xp.atanh(end), 0.0)
        slipping = limit * (xp.minimum(xp.tanh(y), end) + xp.log1p(2.0 * end * above) / growth)
        steep = xp.maximum(rate, NO_STRESS)
        thinning = steep / xp.maximum(self.base.stress(rate, pressure), NO_STRESS)
        return rate / xp.sqrt(xp.sqrt(thinning**4 + (steep / xp.maximum(slipping, NO_STRESS)) ** 4 - 1.0))

    def _end(self, xp: Any) -> tuple[Array, Array]:
        """u1, where the exponential begins, and its growth k."""
        end = xp.asarray(1.0 - self.sharpness)
        return end, 2.0 * end / (1.0 - end**2)


def limited_stress(law: Fluidity, stress: Array, pressure: Array) -> Array:
    """The stress that friction counts: not more than the limiting shear stress, where the law has one.

    stress: shape (2, ...), pressure: shape (...), both in Pa.
    """
    return cut_off(stress, law.limit(pressure)) if isinstance(law, Limited) else stress


def cut_off(stress: Array, limit: Array) -> Array:
    """The stress vector, shape (2, ...), with its length cut off at a limit above zero, shape (...)."""
    xp = arrays_of(stress)
    square = stress[0] ** 2 + stress[1] ** 2
    above = square > limit**2
    # a root of zero has no derivative
    return stress * xp.where(above, limit / xp.sqrt(xp.where(above, square, limit**2)), 1.0)
