"""Temperature laws of an oil: viscosity and density at ambient pressure, and the laws of pressure.

A rule takes the oil at ambient pressure and gives the oil of a contact: its alpha, viscosity law and density law.  A
law is the name of one that follows from eta0 and alpha (Roelands' law, with Dowson and Higginson's density), or a
record with constants of its own.

All temperatures are absolute (K) and all quantities in SI; kinematic viscosities are in m^2/s.
"""

from dataclasses import dataclass
from math import exp, log, log10
from typing import Annotated, ClassVar, NamedTuple

from ertel.physics import units
from ertel.physics.lubricant import Doolittle, Modulus, Oil, Tait
from ertel.physics.units import Unit

ZERO_CELSIUS = 273.15  # K
THIN = 2e-6  # m^2/s: below it, D341 needs terms that are left out here
LUBRICATING_OILS = 0.6278  # kg/(m^3 K), API's constant K1 of lubricating oils
STRESS_PER_KELVIN = Unit("Pa/K", "226 kPa/K", signed=True)
SIGNED_STRESS = Unit("Pa", "-22.8 MPa", signed=True)
PER_KELVIN = Unit("1/K", "-1.4e-3 / K", signed=True)
FLATTEST, STEEPEST = 2.8, 4.5  # slopes of ASTM D341 of mineral oils; those of the comparison below are 3.2 to 4.3


@dataclass(frozen=True)
class Walther:
    """Kinematic viscosity by ASTM D341: log10 log10(nu + 0.7) = A - B log10 T, nu in mm^2/s, T in K.

    nu40, nu100: at 40 and 100 degC (m^2/s).  Raises ValueError unless nu40 > nu100 >= 2 mm^2/s; the short form of D341
    is exact to 0.04 % there.

    Source: ASTM D341, Standard Practice for Viscosity-Temperature Equations and Charts for Liquid Petroleum.
    """

    title: ClassVar[str] = "ASTM D341"
    nu40: Annotated[float, units.KINEMATIC_VISCOSITY]
    nu100: Annotated[float, units.KINEMATIC_VISCOSITY]

    def __post_init__(self) -> None:
        if not THIN <= self.nu100 < self.nu40 < 1.0:
            raise ValueError(f'{self}: must be nu40 > nu100 >= 2 mm^2/s; write them with their unit, "68 mm^2/s"')

    def __str__(self) -> str:
        return f"nu40 = {_mm2(self.nu40)} and nu100 = {_mm2(self.nu100)}"

    @property
    def slope(self) -> float:
        """B, the slope of the line; between 2.5 (high viscosity index) and 4.5 (low)."""
        return (_ordinate(self.nu40) - _ordinate(self.nu100)) / (log10(373.15) - log10(313.15))

    def kinematic(self, T: float) -> float:
        """Kinematic viscosity (m^2/s) at T (K).  Raises ValueError where it is below 2 mm^2/s."""
        ordinate = _ordinate(self.nu40) - self.slope * (log10(T) - log10(313.15))
        nu: float = (10.0 ** (10.0**ordinate) - 0.7) * 1e-6
        if nu < THIN:
            raise ValueError(f"temperature = {T:g} K: too hot for ASTM D341, {_mm2(nu)} is below 2 mm^2/s")
        return nu

    def dynamic(self, T: float, density: float) -> float:
        """Viscosity (Pa s) at T (K), where the oil has this density (kg/m^3)."""
        return self.kinematic(T) * density


def _ordinate(nu: float) -> float:
    return log10(log10(nu * 1e6 + 0.7))


def _mm2(nu: float) -> str:
    return f"{nu * 1e6:.4g} mm^2/s"


@dataclass(frozen=True)
class Vogel:
    """Vogel's law eta = K exp{C/(T - D)} through three measured viscosities.

    T1, T2, T3: temperatures (K), rising.  eta1, eta2, eta3: viscosities (Pa s) there, falling.  Raises ValueError for
    another order, or if no law of this form passes through them.
    """

    title: ClassVar[str] = "Vogel's law"
    T1: Annotated[float, units.TEMPERATURE]
    T2: Annotated[float, units.TEMPERATURE]
    T3: Annotated[float, units.TEMPERATURE]
    eta1: Annotated[float, units.VISCOSITY]
    eta2: Annotated[float, units.VISCOSITY]
    eta3: Annotated[float, units.VISCOSITY]

    def __post_init__(self) -> None:
        if not (0 < self.T1 < self.T2 < self.T3 and self.eta1 > self.eta2 > self.eta3 > 0):
            raise ValueError("T1, T2, T3, eta1, eta2, eta3: temperatures must rise and viscosities fall")
        if not self.D < self.T1:
            raise ValueError("eta1, eta2, eta3: Vogel's law does not pass through these viscosities")

    @property
    def D(self) -> float:
        """The temperature (K) at which the viscosity would be infinite."""
        first, second = log(self.eta1 / self.eta2), log(self.eta2 / self.eta3)
        # C (T2 - T1)/((T1 - D)(T2 - D)) = first and the same for the second interval; their ratio is linear in D
        ratio = first / second * (self.T3 - self.T2) / (self.T2 - self.T1)
        return (ratio * self.T1 - self.T3) / (ratio - 1.0) if ratio != 1.0 else -float("inf")

    @property
    def C(self) -> float:
        """The rate C (K)."""
        return log(self.eta1 / self.eta3) / (1.0 / (self.T1 - self.D) - 1.0 / (self.T3 - self.D))

    def dynamic(self, T: float, density: float) -> float:
        """Viscosity (Pa s) at T (K); the density plays no part."""
        return self.eta2 * exp(self.C / (T - self.D) - self.C / (self.T2 - self.D))


ViscosityOfTemperature = Walther | Vogel


@dataclass(frozen=True)
class Expansion:
    """Density at ambient pressure, rho = rho15 exp{-a dT (1 + 0.8 a dT)} with dT = T - 15 degC.

    density: rho15, at 15 degC (kg/m^3), as on data sheets.  expansion: a at 15 degC (1/K); if it is not given, a =
    0.6278/rho15 as for lubricating oils, 7e-4/K for a mineral oil.

    Source: API Manual of Petroleum Measurement Standards, chapter 11.1 (ASTM D1250), lubricating oils: its constant
    K1 = 0.34878 for degF is 0.6278 kg/m^3/K; its base temperature is 15.56 degC, which changes the density by 0.04 %.
    """

    title: ClassVar[str] = "expansion by API MPMS 11.1"
    density: Annotated[float, units.DENSITY]
    expansion: Annotated[float | None, units.EXPANSION] = None

    def at(self, T: float) -> float:
        """Density (kg/m^3) at T (K)."""
        rise = (self.expansion or LUBRICATING_OILS / self.density) * (T - ZERO_CELSIUS - 15.0)
        return self.density * exp(-rise * (1.0 + 0.8 * rise))


# -- rules for the pressure -------------------------------------------------------------------------------------------


class Ambient(NamedTuple):
    """An oil at ambient pressure: T (K), eta0 (Pa s), density (kg/m^3) and its law of viscosity and temperature."""

    T: float
    eta0: float
    density: float
    law: ViscosityOfTemperature


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

    def at(self, oil: Ambient) -> Oil:
        """The oil at its temperature.

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
        return Oil(oil.eta0, so_klaus(oil.law.kinematic(oil.T), oil.law.slope, oil.density))


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
    alpha_1: Annotated[float, units.COMPLIANCE]
    eta_1: Annotated[float, units.VISCOSITY]
    exponent: Annotated[float, units.FINITE]

    def at(self, oil: Ambient) -> Oil:
        """The oil at its temperature."""
        return Oil(oil.eta0, self.alpha_1 * (oil.eta0 / self.eta_1) ** self.exponent)


@dataclass(frozen=True)
class ModulusOfTemperature:
    """eta/eta0 = exp{p/[a1 + a2 T + (b1 + b2 T) p]}, T in K.  highest: pressure up to which this has a source.

    Source: Arana A et al. Proc Inst Mech Eng J 2019;233:303.
    """

    title: ClassVar[str] = "modulus law"
    a1: Annotated[float, SIGNED_STRESS]
    a2: Annotated[float, STRESS_PER_KELVIN]
    b1: Annotated[float, units.FINITE]
    b2: Annotated[float, PER_KELVIN]
    highest: Annotated[float | None, units.STRESS] = None

    def at(self, oil: Ambient) -> Oil:
        """The oil at its temperature.  Raises ValueError where a1 + a2 T is not above zero."""
        a = self.a1 + self.a2 * oil.T
        if not a > 0:
            raise ValueError(f"temperature = {oil.T:g} K: too cold for this modulus law, a1 + a2 T must be above zero")
        return Oil(oil.eta0, 1.0 / a, Modulus(a, self.b1 + self.b2 * oil.T, self.highest))


@dataclass(frozen=True)
class DoolittleOfTemperature:
    """Doolittle's law with Tait's: R = R_ref + R_slope (T - T_ref), K0 = K0_ref exp{-K0_rate (T - T_ref)}.

    R is the occupied share of the volume, K0 the bulk modulus, both at ambient pressure; B and K0' are constant.
    highest: pressure up to which this has a source at temperatures other than T_ref.
    """

    title: ClassVar[str] = "Doolittle's law, density by Tait's"
    B: Annotated[float, units.ABOVE_ZERO]
    R_ref: Annotated[float, units.SHARE]
    R_slope: Annotated[float, PER_KELVIN]
    K0_ref: Annotated[float, units.STRESS]
    K0_rate: Annotated[float, PER_KELVIN]
    K0_prime: Annotated[float, units.ABOVE_ZERO]
    T_ref: Annotated[float, units.TEMPERATURE]
    highest: Annotated[float | None, units.STRESS] = None

    def at(self, oil: Ambient) -> Oil:
        """The oil at its temperature."""
        warmer = oil.T - self.T_ref
        K0, R = self.K0_ref * exp(-self.K0_rate * warmer), self.R_ref + self.R_slope * warmer
        viscosity = Doolittle(self.B, R, K0, self.K0_prime, self.highest if warmer else None)
        return Oil(oil.eta0, viscosity.alpha, viscosity, Tait(K0, self.K0_prime))


PressureRule = SoKlaus | PowerOfViscosity | ModulusOfTemperature | DoolittleOfTemperature
