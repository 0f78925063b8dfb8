"""How viscosity and density of an oil at ambient pressure depend on temperature.

All temperatures are absolute (K) and all quantities in SI; kinematic viscosities are in m^2/s.
"""

from dataclasses import dataclass
from math import exp, log, log10
from typing import Annotated, ClassVar

from ertel.physics.units import DENSITY, EXPANSION, KINEMATIC_VISCOSITY, TEMPERATURE, VISCOSITY

ZERO_CELSIUS = 273.15  # K
THIN = 2e-6  # m^2/s: below it, D341 needs terms that are left out here
LUBRICATING_OILS = 0.6278  # kg/(m^3 K), API's constant K1 of lubricating oils


@dataclass(frozen=True)
class Walther:
    """Kinematic viscosity by ASTM D341: log10 log10(nu + 0.7) = A - B log10 T, nu in mm^2/s, T in K.

    Parameters
    ----------
    nu40, nu100 : float
        Kinematic viscosities at 40 and 100 degC (m^2/s).

    Raises ValueError unless nu40 > nu100 >= 2 mm^2/s; the short form of D341 is exact to 0.04 % there.

    Source: ASTM D341, Standard Practice for Viscosity-Temperature Equations and Charts for Liquid Petroleum.
    """

    title: ClassVar[str] = "ASTM D341"
    nu40: Annotated[float, KINEMATIC_VISCOSITY]
    nu100: Annotated[float, KINEMATIC_VISCOSITY]

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

    Parameters
    ----------
    T1, T2, T3 : float
        Temperatures (K), rising.
    eta1, eta2, eta3 : float
        Viscosities (Pa s) there, falling.

    Raises ValueError for temperatures or viscosities in another order, or if no law of this form passes through them.
    """

    title: ClassVar[str] = "Vogel's law"
    T1: Annotated[float, TEMPERATURE]
    T2: Annotated[float, TEMPERATURE]
    T3: Annotated[float, TEMPERATURE]
    eta1: Annotated[float, VISCOSITY]
    eta2: Annotated[float, VISCOSITY]
    eta3: Annotated[float, VISCOSITY]

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

    Parameters
    ----------
    density : float
        rho15, the density at 15 degC (kg/m^3), as on data sheets.
    expansion : float
        Coefficient of thermal expansion a at 15 degC (1/K).  If it is not given, a = 0.6278/rho15 as for lubricating
        oils, 7e-4/K for a mineral oil.

    Source: API Manual of Petroleum Measurement Standards, chapter 11.1 (ASTM D1250), lubricating oils: its constant
    K1 = 0.34878 for degF is 0.6278 kg/m^3/K; its base temperature is 15.56 degC, which changes the density by 0.04 %.
    """

    title: ClassVar[str] = "expansion by API MPMS 11.1"
    density: Annotated[float, DENSITY]
    expansion: Annotated[float | None, EXPANSION] = None

    def at(self, T: float) -> float:
        """Density (kg/m^3) at T (K)."""
        rise = (self.expansion or LUBRICATING_OILS / self.density) * (T - ZERO_CELSIUS - 15.0)
        return self.density * exp(-rise * (1.0 + 0.8 * rise))
