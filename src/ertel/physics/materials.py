"""The materials of a contact: oils and solids whose data have a source, and what follows from them.

Every part of the data has its source and the temperatures at which it is valid.  What has no trustworthy source is
None.  The materials themselves are data files, see `inputs.oils`.  All functions take and return SI units.
"""

from dataclasses import dataclass, replace
from math import inf, log, pi, sqrt
from typing import Annotated, ClassVar, Generic, TypeVar

from ertel.physics import units
from ertel.physics.fluidity import Carreau, Fluidity
from ertel.physics.lubricant import Oil
from ertel.physics.temperature_laws import ZERO_CELSIUS, Ambient, Expansion, PressureRule, ViscosityOfTemperature
from ertel.physics.units import Bounds, require_positive

Data = TypeVar("Data", covariant=True)
GRAVITY = 9.80665  # m/s^2, standard
SMALL_STEP = 0.01  # K, for the derivative of the viscosity
RHEOLOGY = " Rheology: "  # in the reference of an oil, before the source of its law of shear thinning


@dataclass(frozen=True)
class Sourced(Generic[Data]):
    """Data with their source, the temperatures (K) between which they are valid, and a note on their accuracy."""

    data: Data
    source: str
    coldest: float
    hottest: float
    note: str = ""

    def missing_at(self, T: float, quantity: str, name: str) -> str:
        """A sentence that these data of an oil are not known at T (K); empty if they are."""
        if self.coldest <= T <= self.hottest:
            return ""
        ends = dict.fromkeys((celsius(self.coldest), celsius(self.hottest)))
        return f"the library has {quantity} of {name} at {' to '.join(ends)}, not at {celsius(T)}"


@dataclass(frozen=True)
class ThermalData:
    """Thermal conductivity (W/(m K)) and heat capacity (J/(kg K)) at ambient pressure."""

    title: ClassVar[str] = "at ambient pressure"
    conductivity: Annotated[float, units.CONDUCTIVITY]
    heat_capacity: Annotated[float, units.HEAT_CAPACITY]


def celsius(T: float) -> str:
    """A temperature (K) as it is written in case files: "40 degC"."""
    return f"{round(T - ZERO_CELSIUS, 6):g} degC"


# -- an oil whose data are known against temperature, and the oil of a contact that follows from it --------------------


@dataclass(frozen=True)
class LimitingStress:
    """Limiting shear stress Lambda p: what a source gives of `fluidity.Limited`, whose base is another law."""

    title: ClassVar[str] = "Lambda p"
    Lambda: Annotated[float, units.ABOVE_ZERO]


@dataclass(frozen=True)
class NamedOil:
    """An oil with its data against temperature.

    name, text: the name by which case files call it, and what it is.  viscosity, density: at ambient pressure.
    pressure: the rule that gives alpha and the pressure laws at a temperature.
    """

    name: str
    text: str
    viscosity: Sourced[ViscosityOfTemperature]
    density: Sourced[Expansion]
    pressure: Sourced[PressureRule]
    shear: Sourced[Carreau] | None = None
    limiting_stress: Sourced[LimitingStress] | None = None
    thermal: Sourced[ThermalData] | None = None

    @property
    def temperatures(self) -> tuple[float, float]:
        """The temperatures (K) between which viscosity, density and pressure laws are valid."""
        parts = (self.viscosity, self.density, self.pressure)
        return max(part.coldest for part in parts), min(part.hottest for part in parts)

    def density_at(self, T: float) -> float:
        """Density (kg/m^3) at ambient pressure at T (K)."""
        return self.density.data.at(T)

    def viscosity_at(self, T: float) -> float:
        """Viscosity eta0 (Pa s) at ambient pressure at T (K)."""
        return self.viscosity.data.dynamic(T, self.density_at(T))

    def thinning_at(self, T: float) -> float:
        """Temperature coefficient of the viscosity, beta = -d ln(eta0)/dT (1/K), at T (K)."""
        colder, warmer = self.viscosity_at(T - SMALL_STEP), self.viscosity_at(T + SMALL_STEP)
        return log(colder / warmer) / (2 * SMALL_STEP)

    def expansion_at(self, T: float) -> float:
        """Thermal expansion at ambient pressure, - d ln(rho)/dT (1/K), at T (K)."""
        return log(self.density_at(T - SMALL_STEP) / self.density_at(T + SMALL_STEP)) / (2 * SMALL_STEP)

    def pressure_laws_at(self, T: float) -> Oil:
        """alpha (1/Pa), viscosity law and density law at T (K)."""
        return self.pressure.data.at(Ambient(T, self.viscosity_at(T), self.density_at(T), self.viscosity.data))

    def at(self, T: float, rheology: str | Fluidity | None = None) -> Oil:
        """The oil of a contact at T (K).  Raises ValueError if T is outside the data.

        rheology: a law of shear thinning, or "newtonian"; None: the oil's own where it has one at T, otherwise
        Newtonian.  The reference then has the source of that law, or says at which temperatures there is one.
        """
        coldest, hottest = self.temperatures
        if not coldest <= T <= hottest:
            raise ValueError(
                f"temperature = {T:g} K: must be between {celsius(coldest)} and {celsius(hottest)}, the range of the "
                f"data ({self.name})"
            )
        law, rheology_source = self._own_rheology(T) if rheology is None else (rheology, "")
        source = f"{self.name} at {celsius(T)}. Viscosity: {self.viscosity.source} Pressure: {self.pressure.source}"
        return replace(self.pressure_laws_at(T), reference=f"{source}{rheology_source}", rheology=law)

    def _own_rheology(self, T: float) -> tuple[str | Fluidity, str]:
        """The oil's own law of shear thinning at T (K), and what the reference says of it."""
        if self.shear is None:
            return "newtonian", ""
        if missing := self.shear.missing_at(T, "G and n", self.name):
            return "newtonian", f"{RHEOLOGY}Newtonian, {missing}."
        return self.shear.data, f"{RHEOLOGY}{self.shear.source.rstrip('.')}."


# -- the two bodies: reduced modulus and radius, the mass of a ball and its speed after a fall -------------------------


def reduced_modulus(E1: float, nu1: float, E2: float, nu2: float) -> float:
    """Reduced modulus E' (Pa), 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, from Young's moduli (Pa), Poisson's ratios."""
    require_positive(E1=E1, E2=E2)
    for name, nu in {"nu1": nu1, "nu2": nu2}.items():
        if not -1 < nu <= 0.5:
            raise ValueError(f"{name} = {nu}: Poisson's ratio must be above -1 and not above 0.5")
    return 2 / ((1 - nu1**2) / E1 + (1 - nu2**2) / E2)


def reduced_radius(R1: float, R2: float) -> float:
    """Reduced radius R (m) along one principal axis, 1/R = 1/R1 + 1/R2: concave radii are negative, planes infinite.

    It is infinite or negative where the curvatures do not add up to more than zero: no contact at a point.
    """
    curvature = 1 / R1 + 1 / R2
    return 1 / curvature if curvature else inf


def sphere_mass(radius: float, density: float) -> float:
    """Mass (kg) of a solid ball of the given radius (m) and density (kg/m^3)."""
    require_positive(radius=radius, density=density)
    return 4 * pi / 3 * density * radius**3


def drop_speed(height: float) -> float:
    """Speed v0 = sqrt(2 g h) (m/s) of a ball dropped from a height (m), without air drag."""
    require_positive(height=height)
    return sqrt(2 * GRAVITY * height)


@dataclass(frozen=True)
class Elasticity:
    """Young's modulus E (Pa), Poisson's ratio nu and density (kg/m^3)."""

    title: ClassVar[str] = "isotropic"
    E: Annotated[float, units.STRESS]
    nu: Annotated[float, Bounds(gt=-1, le=0.5)]
    density: Annotated[float, units.DENSITY]


@dataclass(frozen=True)
class Strength:
    """Hardness (Pa), the mean pressure under an indenter, and what follows for a contact of smooth bodies.

    A metal's yield stress Y is about a third of its hardness (Tabor D. The hardness of metals. Oxford; 1951), and a
    point contact with nu = 0.3 begins to yield below its surface where the maximum Hertz pressure is 1.6 Y (Johnson KL.
    Contact mechanics. Cambridge; 1985, chapter 6).
    """

    title: ClassVar[str] = "yields at a maximum Hertz pressure of 1.6/3 of the hardness"
    hardness: Annotated[float, units.STRESS]

    @property
    def yield_stress(self) -> float:
        """The yield stress (Pa)."""
        return self.hardness / 3.0

    @property
    def first_yield(self) -> float:
        """The maximum Hertz pressure (Pa) at which a point contact begins to yield."""
        return 1.6 * self.yield_stress


@dataclass(frozen=True)
class Material:
    """A material with the sources of its data."""

    name: str
    text: str
    elasticity: Sourced[Elasticity]
    thermal: Sourced[ThermalData] | None = None
    strength: Sourced[Strength] | None = None

    def reduced_modulus(self, other: "Material") -> float:
        """Reduced modulus E' (Pa) of a contact with another material, 2/E' = sum of (1 - nu^2)/E."""
        first, second = self.elasticity.data, other.elasticity.data
        return reduced_modulus(first.E, first.nu, second.E, second.nu)
