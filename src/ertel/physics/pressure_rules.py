"""How the viscosity of an oil follows pressure at a given temperature: rules that give the laws of a contact.

A rule takes the oil at ambient pressure and gives its pressure-viscosity coefficient alpha, viscosity law and density
law.  A law is the name of one that follows from eta0 and alpha (Roelands' law, with Dowson and Higginson's density), or
a record with constants of its own.
"""

from dataclasses import dataclass
from math import exp, log10
from typing import Annotated, ClassVar, NamedTuple

from ertel.physics.lubricant import Density, Viscosity
from ertel.physics.pressure_laws import Doolittle, Modulus, Tait
from ertel.physics.temperature_laws import ViscosityOfTemperature, Walther
from ertel.physics.units import ABOVE_ZERO, COMPLIANCE, FINITE, SHARE, STRESS, TEMPERATURE, VISCOSITY, Unit

STRESS_PER_KELVIN = Unit("Pa/K", "226 kPa/K", signed=True)
SIGNED_STRESS = Unit("Pa", "-22.8 MPa", signed=True)
PER_KELVIN = Unit("1/K", "-1.4e-3 / K", signed=True)
FLATTEST, STEEPEST = 2.8, 4.5  # slopes of ASTM D341 of mineral oils; those of the comparison below are 3.2 to 4.3


class Ambient(NamedTuple):
    """An oil at ambient pressure: T (K), eta0 (Pa s), density (kg/m^3) and its law of viscosity and temperature."""

    T: float
    eta0: float
    density: float
    law: ViscosityOfTemperature


class PressureLaws(NamedTuple):
    """alpha (1/Pa) and the laws of a contact."""

    alpha: float
    viscosity: str | Viscosity = "roelands"
    density: str | Density = "dowson-higginson"


@dataclass(frozen=True)
class SoKlaus:
    """So and Klaus' correlation for mineral oils, from two viscosities and the density; the pressure law is Roelands'.

    10^8 alpha = 1.216 + 4.143 (lg nu)^3.0627 + 2.848e-4 b^5.1903 (lg nu)^1.5976 - 3.999 (lg nu)^3.0975 rho^0.1162, with
    alpha in 1/Pa, the kinematic viscosity nu in mm^2/s and the density rho in g/cm^3 at the temperature of interest,
    and the slope b of ASTM D341.

    Scatter, found with the 38 measured coefficients of 13 mineral oils (2.4 to 2000 mPa s, 30 to 100 degC) in
    Stachowiak and Batchelor, Engineering Tribology, table 2.3: on average 10 % too high, standard deviation 12 %,
    extremes -10 % and +39 %; at 60 and 100 degC on average 5 % too high.  The film of a rolling contact goes with
    about the square root of alpha.

    Source: So BYC, Klaus EE. Viscosity-pressure correlation of liquids. ASLE Trans 1980;23:409-421.
    """

    title: ClassVar[str] = "alpha by So and Klaus' correlation, Roelands' law"

    def at(self, oil: Ambient) -> PressureLaws:
        """The laws at the temperature of the oil.

        Raises ValueError if its viscosity is not given by ASTM D341, or if its slope is not that of a mineral oil:
        the correlation has its fifth power.
        """
        if not isinstance(oil.law, Walther):
            raise ValueError("pressure: So and Klaus' correlation needs the slope of ASTM D341")
        if not FLATTEST <= oil.law.slope <= STEEPEST:
            raise ValueError(
                f"{oil.law}: their slope by ASTM D341 is {oil.law.slope:.2f}; So and Klaus' correlation for alpha is "
                f"for {FLATTEST} to {STEEPEST}, mineral oils; give alpha"
            )
        return PressureLaws(so_klaus(oil.law.kinematic(oil.T), oil.law.slope, oil.density))


def so_klaus(nu: float, slope: float, density: float) -> float:
    """Pressure-viscosity coefficient (1/Pa) of a mineral oil, see `SoKlaus`; nu in m^2/s, density in kg/m^3."""
    decades, rho = log10(nu * 1e6), density / 1000.0
    alpha = 1.216 + 4.143 * decades**3.0627 + 2.848e-4 * slope**5.1903 * decades**1.5976
    return float(alpha - 3.999 * decades**3.0975 * rho**0.1162) * 1e-8


@dataclass(frozen=True)
class PowerOfViscosity:
    """alpha = alpha_1 (eta0/eta_1)^exponent from one measured coefficient; the pressure law is Roelands'.

    Source of the form: Gold PW et al. Viscosity-pressure-temperature behaviour of mineral and synthetic oils.
    J Synth Lubr 2001;18:51-79, who take a power of the kinematic viscosity.
    """

    title: ClassVar[str] = "alpha as a power of the viscosity, Roelands' law"
    alpha_1: Annotated[float, COMPLIANCE]
    eta_1: Annotated[float, VISCOSITY]
    exponent: Annotated[float, FINITE]

    def at(self, oil: Ambient) -> PressureLaws:
        """The laws at the temperature of the oil."""
        return PressureLaws(self.alpha_1 * (oil.eta0 / self.eta_1) ** self.exponent)


@dataclass(frozen=True)
class ModulusOfTemperature:
    """eta/eta0 = exp{p/[a1 + a2 T + (b1 + b2 T) p]}, T in K.  highest: pressure up to which this has a source.

    Source: Arana A et al. Proc Inst Mech Eng J 2019;233:303.
    """

    title: ClassVar[str] = "modulus law"
    a1: Annotated[float, SIGNED_STRESS]
    a2: Annotated[float, STRESS_PER_KELVIN]
    b1: Annotated[float, FINITE]
    b2: Annotated[float, PER_KELVIN]
    highest: Annotated[float | None, STRESS] = None

    def at(self, oil: Ambient) -> PressureLaws:
        """The laws at the temperature of the oil.  Raises ValueError where a1 + a2 T is not above zero."""
        a = self.a1 + self.a2 * oil.T
        if not a > 0:
            raise ValueError(f"temperature = {oil.T:g} K: too cold for this modulus law, a1 + a2 T must be above zero")
        return PressureLaws(1.0 / a, Modulus(a, self.b1 + self.b2 * oil.T, self.highest))


@dataclass(frozen=True)
class DoolittleOfTemperature:
    """Doolittle's law with Tait's: R = R_ref + R_slope (T - T_ref), K0 = K0_ref exp{-K0_rate (T - T_ref)}.

    R is the occupied share of the volume, K0 the bulk modulus, both at ambient pressure; B and K0' are constant.
    highest: pressure up to which this has a source at temperatures other than T_ref.
    """

    title: ClassVar[str] = "Doolittle's law, density by Tait's"
    B: Annotated[float, ABOVE_ZERO]
    R_ref: Annotated[float, SHARE]
    R_slope: Annotated[float, PER_KELVIN]
    K0_ref: Annotated[float, STRESS]
    K0_rate: Annotated[float, PER_KELVIN]
    K0_prime: Annotated[float, ABOVE_ZERO]
    T_ref: Annotated[float, TEMPERATURE]
    highest: Annotated[float | None, STRESS] = None

    def at(self, oil: Ambient) -> PressureLaws:
        """The laws at the temperature of the oil."""
        warmer = oil.T - self.T_ref
        K0, R = self.K0_ref * exp(-self.K0_rate * warmer), self.R_ref + self.R_slope * warmer
        viscosity = Doolittle(self.B, R, K0, self.K0_prime, self.highest if warmer else None)
        return PressureLaws(viscosity.alpha, viscosity, Tait(K0, self.K0_prime))


PressureRule = SoKlaus | PowerOfViscosity | ModulusOfTemperature | DoolittleOfTemperature
