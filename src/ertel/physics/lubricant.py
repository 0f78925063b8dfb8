"""The oil: viscosity and density as functions of pressure.

Every law is a small frozen record in SI.  `viscosity(p)` gives eta/eta0 and `density(p)` gives rho/rho0 at the pressure
p in Pa.  They accept floats, NumPy arrays and JAX arrays.  A user's own law needs no derivative, because the solver
differentiates it.  It needs a registered name (`ertel.viscosity_laws.register`), so that a case can be stored:

    @ertel.viscosity_laws.register("power")
    @dataclass(frozen=True)
    class Power:
        p1: Annotated[float, units.STRESS]
        n: float

        def viscosity(self, p):
            return (1 + p / self.p1) ** self.n
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import log
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol

import numpy as np

from ertel.physics import units
from ertel.physics.fluidity import Fluidity, NewtonianOil
from ertel.physics.motion import Track
from ertel.physics.registry import DENSITY_LAWS, FLUIDITY_LAWS, OIL_LAWS, VISCOSITY_LAWS, OfAnyOil, Registry, arrays_of
from ertel.physics.units import Amount, Meaning, explained, fields_in_si, plain

Array = Any  # a NumPy or JAX array of any shape, or a float

ALPHA = 2.2e-8  # 1/Pa, pressure-viscosity coefficient of a typical mineral oil
ETA0 = 0.04  # Pa s, viscosity at ambient pressure
P0_ROELANDS = 1.96e8  # Pa, Roelands' pressure constant
DENSITY_PRESSURE = 5.9e8  # Pa, Dowson and Higginson's constant
_points, _weights = np.polynomial.legendre.leggauss(8)
PLACES, WEIGHTS = (1 + _points) / 2, _weights / 2  # of the Gauss rule on [0, 1]


class Viscosity(Protocol):
    """A viscosity law: eta/eta0 at p in Pa."""

    def viscosity(self, p: Array) -> Array: ...


class Density(Protocol):
    """A density law: rho/rho0 at p in Pa."""

    def density(self, p: Array) -> Array: ...


@VISCOSITY_LAWS.register("isoviscous")
@dataclass(frozen=True)
class Isoviscous(OfAnyOil):
    """eta/eta0 = 1."""

    reference: ClassVar[str] = "constant viscosity"

    def viscosity(self, p: Array) -> Array:
        return arrays_of(p).ones_like(p)


@VISCOSITY_LAWS.register("barus")
@dataclass(frozen=True)
class Barus:
    """eta/eta0 = exp(alpha p)."""

    alpha: Annotated[float, units.COMPLIANCE, Meaning("pressure-viscosity coefficient")]
    reference: ClassVar[str] = (
        "Barus C. Isothermals, isopiestics and isometrics relative to viscosity. Am J Sci 1893;45:87-96"
    )

    def viscosity(self, p: Array) -> Array:
        return arrays_of(p).exp(self.alpha * p)

    @classmethod
    def of(cls, oil: "Oil") -> "Barus":
        return cls(_needed(oil, "alpha"))


@VISCOSITY_LAWS.register("roelands")
@dataclass(frozen=True)
class Roelands:
    """eta/eta0 = exp{(alpha p0/z)[(1 + p/p0)^z - 1]} with Roelands' exponent z; d ln(eta)/dp = alpha at p = 0."""

    alpha: Annotated[float, units.COMPLIANCE, Meaning("pressure-viscosity coefficient at ambient pressure")]
    z: Annotated[float, units.ABOVE_ZERO, Meaning("Roelands' exponent", 0.6)]
    p0: Annotated[float, units.STRESS, Meaning("Roelands' pressure", "0.196 GPa")] = P0_ROELANDS
    reference: ClassVar[str] = (
        "Roelands CWA. Correlational aspects of the viscosity-temperature-pressure relationship of lubricating oils. "
        "PhD thesis, TH Delft; 1966"
    )

    def viscosity(self, p: Array) -> Array:
        xp = arrays_of(p)
        power = xp.exp(self.z * xp.log(1.0 + p * (1.0 / self.p0)))  # the derivative of this form needs no second power
        return xp.exp(self.alpha * self.p0 / self.z * (power - 1.0))

    @classmethod
    def of(cls, oil: "Oil") -> "Roelands":
        """The law of an oil; z follows from eta0 and alpha if it is not given."""
        alpha = _needed(oil, "alpha")
        return cls(alpha, oil.z or roelands_exponent(alpha, _needed(oil, "eta0"), oil.p0), oil.p0)


@DENSITY_LAWS.register("incompressible")
@dataclass(frozen=True)
class Incompressible(OfAnyOil):
    """rho/rho0 = 1."""

    reference: ClassVar[str] = "constant density"

    def density(self, p: Array) -> Array:
        return arrays_of(p).ones_like(p)


@DENSITY_LAWS.register("dowson-higginson")
@dataclass(frozen=True)
class DowsonHigginson(OfAnyOil):
    """rho/rho0 = (p1 + 1.34 p)/(p1 + p), p1 = 5.9e8 Pa."""

    p1: Annotated[float, units.STRESS, Meaning("pressure of the law", "0.59 GPa")] = DENSITY_PRESSURE
    reference: ClassVar[str] = "Dowson D, Higginson GR. Elasto-hydrodynamic lubrication. Pergamon Press; 1966"

    def density(self, p: Array) -> Array:
        share = p * (1.0 / self.p1)  # one division of numbers, because at each point it takes half of the time
        return (1.0 + 1.34 * share) / (1.0 + share)


# -- laws of measured oils, with constants of their own ---------------------------------------------------------------


@VISCOSITY_LAWS.register("modulus")
@dataclass(frozen=True)
class Modulus:
    """eta/eta0 = exp{p/(a + b p)}: a is 1/alpha, and the logarithm tends to 1/b at high pressure.

    b below zero is a viscosity that grows faster than Barus'; the law then ends at p = a/|b|.  highest: the pressure
    up to which the constants have a source.
    """

    a: Annotated[float, units.STRESS, Meaning("1/alpha", "50 MPa")]
    b: Annotated[float, units.FINITE, Meaning("1/ln(eta/eta0) at high pressure", 0.05)]
    highest: Annotated[float | None, units.STRESS, Meaning("pressure up to which a and b have a source", "1 GPa")] = (
        None
    )
    reference: ClassVar[str] = "Arana A et al. Proc Inst Mech Eng J 2019;233:303, at one temperature"

    def viscosity(self, p: Array) -> Array:
        """eta/eta0 at p (Pa); same shape as p."""
        return arrays_of(p).exp(p / (self.a + self.b * p))


@DENSITY_LAWS.register("tait")
@dataclass(frozen=True)
class Tait:
    """V/V0 = 1 - ln{1 + (p/K0)(1 + K0')}/(1 + K0'), with the bulk modulus K0 at ambient pressure; rho/rho0 = V0/V."""

    K0: Annotated[float, units.STRESS, Meaning("bulk modulus at ambient pressure", "1.2 GPa")]
    K0_prime: Annotated[float, units.ABOVE_ZERO, Meaning("its derivative with pressure", 11)]
    reference: ClassVar[str] = "Dymond JH, Malhotra R. The Tait equation: 100 years on. Int J Thermophys 1988;9:941-951"

    def volume(self, p: Array) -> Array:
        """V/V0 at p (Pa); same shape as p."""
        share = 1.0 + self.K0_prime
        return 1.0 - arrays_of(p).log(1.0 + p / self.K0 * share) / share

    def density(self, p: Array) -> Array:
        """rho/rho0 at p (Pa); same shape as p."""
        return 1.0 / self.volume(p)


@VISCOSITY_LAWS.register("doolittle")
@dataclass(frozen=True)
class Doolittle:
    """eta/eta0 = exp{B R (1 - V/V0)/[(V/V0 - R)(1 - R)]}: the free volume of a liquid that Tait's law compresses.

    R is the share of the volume at ambient pressure that the molecules occupy.  highest: the pressure up to which the
    constants have a source.
    """

    B: Annotated[float, units.ABOVE_ZERO, Meaning("Doolittle's constant", 4)]
    R: Annotated[float, units.SHARE, Meaning("volume of the molecules over that of the oil at ambient pressure", 0.67)]
    K0: Annotated[float, units.STRESS, Meaning("bulk modulus at ambient pressure", "1.2 GPa")]
    K0_prime: Annotated[float, units.ABOVE_ZERO, Meaning("its derivative with pressure", 11)]
    highest: Annotated[float | None, units.STRESS, Meaning("pressure up to which these have a source", "0.2 GPa")] = (
        None
    )
    reference: ClassVar[str] = (
        "Doolittle AK. Studies in Newtonian flow II. The dependence of the viscosity of liquids on free-space. "
        "J Appl Phys 1951;22:1471-1475"
    )

    @property
    def alpha(self) -> float:
        """Pressure-viscosity coefficient d ln(eta)/dp at ambient pressure (1/Pa)."""
        return self.B * self.R / (1.0 - self.R) ** 2 / self.K0

    def viscosity(self, p: Array) -> Array:
        """eta/eta0 at p (Pa); same shape as p."""
        volume = Tait(self.K0, self.K0_prime).volume(p)
        return arrays_of(p).exp(self.B * self.R * (1.0 - volume) / ((volume - self.R) * (1.0 - self.R)))


# -- the oil ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Lubricant:
    """A viscosity law and a density law as functions of P = p/p_h, with p_h in the laws' unit of pressure."""

    viscosity_law: Viscosity
    density_law: Density
    p_h: float = 1.0

    def viscosity(self, P: Array) -> Array:
        """eta/eta0 at P = p/p_h; same shape as P."""
        return self.viscosity_law.viscosity(self.p_h * P)

    def density(self, P: Array) -> Array:
        """rho/rho0 at P = p/p_h; same shape as P."""
        return self.density_law.density(self.p_h * P)

    def mobility(self, P: Array, H: Array, lambda_bar: Array | float) -> Array:
        """eps = rho H^3/(eta lambda_bar) of a Newtonian oil, eq. (1): the flux is - eps grad P; zero where H <= 0.

        H <= 0 occurs where the surfaces overlap because the grid is too coarse for the film; nothing flows there.
        """
        return self.density(P) * arrays_of(H).maximum(H, 0.0) ** 3 / (self.viscosity(P) * lambda_bar)

    def enthalpy(self, P: Array) -> Array:
        """The integral of dP/(rho/rho0) from 0 to P, by the Gauss rule: the work that brings a unit of oil to P."""
        shares = PLACES.reshape(-1, *[1] * np.ndim(P)) * P  # all in one array: XLA makes a pass of each term of a sum
        return P * arrays_of(P).tensordot(WEIGHTS, 1.0 / self.density(shares), 1)

    def compression(self, P: Array) -> Array:
        """The elastic energy of a unit of volume at P: density * enthalpy - P, zero for an incompressible oil."""
        return self.density(P) * self.enthalpy(P) - P


@explained
@dataclass(frozen=True)
class Oil:
    """An oil in SI: its viscosity and density laws and their data.

    A law is the name of a registered one, if it follows from the data of the oil, or a record of the law.  A
    dimensionless contact uses eta0 and alpha of a typical mineral oil if they are not given: 0.04 Pa s and 22 1/GPa.
    Quantities are numbers in SI or texts with a unit: Oil(eta0="18.6 mPa*s", alpha=20e-9).

    Raises
    ------
    ValueError
        A law is not registered, or a value is not allowed; the message names the argument.
    """

    if TYPE_CHECKING:

        def __init__(
            self,
            eta0: float | str | None = None,
            alpha: float | str | None = None,
            viscosity: str | Viscosity = "roelands",
            density: str | Density = "dowson-higginson",
            p0: float | str = P0_ROELANDS,
            z: float | None = None,
            reference: str = "",
            rheology: str | Fluidity = "newtonian",
            layer: float | str | Sequence[tuple[float, float]] | Track | None = None,
            layer_1: float | str | None = None,
            layer_2: float | str | None = None,
        ) -> None: ...

    eta0: Annotated[
        float | None,
        units.VISCOSITY,
        Meaning("viscosity at ambient pressure, at the inlet; needed in SI, otherwise 40 mPa*s if left out"),
    ] = None
    alpha: Annotated[
        float | None,
        units.COMPLIANCE,
        Meaning("pressure-viscosity coefficient at ambient pressure; needed in SI, otherwise 22 / GPa if left out"),
    ] = None
    viscosity: Annotated[str | Viscosity, Meaning("how the viscosity follows from the pressure: a law")] = "roelands"
    density: Annotated[str | Density, Meaning("how the density follows from the pressure: a law")] = "dowson-higginson"
    p0: Annotated[float, units.STRESS, Meaning("Roelands' pressure", "0.196 GPa")] = P0_ROELANDS
    z: Annotated[float | None, units.ABOVE_ZERO, Meaning("Roelands' exponent; left out: from eta0 and alpha", 0.6)] = (
        None
    )
    reference: Annotated[str, Meaning("source of the data, one line of text", "data sheet of the oil")] = field(
        default="", compare=False
    )
    rheology: Annotated[
        str | Fluidity,
        Meaning(
            "how the oil thins under shear: a law; in SI, not by the radial method",
            {"law": "ree-eyring", "tau0": "5 MPa"},
        ),
    ] = "newtonian"
    layer: Annotated[
        Amount | Track | None,
        units.LAYER,
        Meaning(
            "thickness of the oil on both surfaces together, or across the track, [[y, thickness], ...]; left out: the "
            "gap is full (flooded)"
        ),
    ] = None
    layer_1: Annotated[Amount | None, units.LAYER, Meaning("of the oil on surface 1, in place of layer", "1 um")] = None
    layer_2: Annotated[Amount | None, units.LAYER, Meaning("of the oil on surface 2, in place of layer", "1 um")] = None

    def __post_init__(self) -> None:
        for name, laws in OIL_LAWS.items():
            _check_law(name, getattr(self, name), laws)
        given = {name: value for name, value in vars(self).items() if not name.startswith("layer")}
        vars(self).update(fields_in_si(Oil, given))  # a layer is an amount, which the case checks

    def track(self, slide_to_roll: float) -> Track | None:
        """The oil that both surfaces bring along, (u1 h1 + u2 h2)/u_m; None if flooded."""
        if isinstance(self.layer, Track):
            return self.layer
        if self.layer is not None:
            return Track(((0.0, self.layer),))
        if self.layer_1 is None and self.layer_2 is None:
            return None
        first, second = plain(self.layer_1 or 0.0), plain(self.layer_2 or 0.0)
        return Track(((0.0, first + second + (first - second) * slide_to_roll / 2),))

    @property
    def is_isoviscous(self) -> bool:
        """Whether the viscosity is independent of pressure, so that alpha has no meaning."""
        return self.viscosity == "isoviscous" or isinstance(self.viscosity, Isoviscous)

    @property
    def viscosity_law(self) -> Viscosity:
        """The record of the viscosity law.  Raises ValueError if the oil lacks data for it."""
        law = self.viscosity
        return VISCOSITY_LAWS[law].of(self) if isinstance(law, str) else law  # type: ignore[attr-defined]

    @property
    def density_law(self) -> Density:
        """The record of the density law."""
        law = self.density
        return DENSITY_LAWS[law].of(self) if isinstance(law, str) else law  # type: ignore[attr-defined]

    @property
    def is_newtonian(self) -> bool:
        """Whether the viscosity is independent of the shear stress."""
        return self.rheology == "newtonian" or isinstance(self.rheology, NewtonianOil)

    @property
    def fluidity_law(self) -> Fluidity:
        """The record of the law of shear thinning."""
        law = self.rheology
        return FLUIDITY_LAWS[law].of(self) if isinstance(law, str) else law  # type: ignore[attr-defined]

    def completed(self) -> "Oil":
        """The oil with missing data filled in from a typical mineral oil."""
        return replace(self, eta0=self.eta0 or ETA0, alpha=self.alpha or ALPHA)

    def under(self, p_h: float) -> Lubricant:
        """The laws of the oil in a contact with the pressure scale p_h (Pa)."""
        return Lubricant(self.viscosity_law, self.density_law, p_h)


def roelands_exponent(alpha: float, eta0: float, p0: float = P0_ROELANDS) -> float:
    """Roelands' z = alpha p0/(ln eta0 + 9.67), alpha in 1/Pa, eta0 in Pa s, p0 in Pa.

    Raises ValueError if eta0 is not above exp(-9.67) Pa s; the law has no meaning there.
    """
    log_ratio = log(eta0) + 9.67
    if log_ratio <= 0:
        raise ValueError(f"eta0 = {eta0} Pa s: Roelands' law needs eta0 > 6.3e-5 Pa s")
    return alpha * p0 / log_ratio


def _check_law(field_name: str, law: object, laws: Registry) -> None:
    if isinstance(law, str):
        able = [name for name in laws if hasattr(laws[name], "of")]
        given = f"{field_name} = {json.dumps(law[:60], ensure_ascii=not law[:60].isprintable())}"
        if law in laws and law not in able:
            raise ValueError(f'{given}: has data of its own; give them as {{ law = "{law}", ... }}')
        if law not in able:
            *others, last = map(repr, able)
            allowed = f"{', '.join(others)} or {last}" if others else last
            raise ValueError(f"{given}: allowed: {allowed}")
    else:
        laws.name_of(law, f"{field_name} = {repr(law)[:60]}: ")


def _needed(oil: Oil, name: str) -> float:
    value = getattr(oil, name)
    if value is None:
        raise ValueError(f"{name}: missing; this viscosity law needs it")
    return float(value)
