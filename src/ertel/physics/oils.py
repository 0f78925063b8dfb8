"""An oil whose data are known against temperature, and the oil of a contact that follows from it.

Every part of the data has its source and the temperatures at which it is valid.  What has no trustworthy source is
None.  The oils themselves are data files, see `inputs.oils`.
"""

from dataclasses import dataclass
from math import log
from typing import Annotated, ClassVar, Generic, TypeVar

from ertel.physics.fluidity import Carreau, Fluidity
from ertel.physics.lubricant import Oil
from ertel.physics.temperature_laws import (
    ZERO_CELSIUS,
    Ambient,
    Expansion,
    PressureLaws,
    PressureRule,
    ViscosityOfTemperature,
)
from ertel.physics.units import ABOVE_ZERO, CONDUCTIVITY, HEAT_CAPACITY

Data = TypeVar("Data", covariant=True)
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

    def __post_init__(self) -> None:
        if not self.source:
            raise ValueError("source: missing")
        if not 0 < self.coldest <= self.hottest:
            raise ValueError(f"coldest = {self.coldest} K: must be above zero and not above hottest = {self.hottest} K")

    def missing_at(self, T: float, wanted: str, name: str) -> str:
        """A sentence that these data of an oil are not known at T (K); empty if they are."""
        if self.coldest <= T <= self.hottest:
            return ""
        ends = dict.fromkeys((celsius(self.coldest), celsius(self.hottest)))
        return f"the library has {wanted} of {name} at {' to '.join(ends)}, not at {celsius(T)}"


@dataclass(frozen=True)
class LimitingStress:
    """Limiting shear stress Lambda p: what a source gives of `fluidity.Limited`, whose base is another law."""

    title: ClassVar[str] = "Lambda p"
    Lambda: Annotated[float, ABOVE_ZERO]


@dataclass(frozen=True)
class ThermalData:
    """Thermal conductivity (W/(m K)) and heat capacity (J/(kg K)) at ambient pressure."""

    title: ClassVar[str] = "at ambient pressure"
    conductivity: Annotated[float, CONDUCTIVITY]
    heat_capacity: Annotated[float, HEAT_CAPACITY]


@dataclass(frozen=True)
class NamedOil:
    """An oil with its data against temperature.

    Parameters
    ----------
    name, text : str
        The name by which case files call it, and what it is.
    viscosity, density : Sourced
        Viscosity and density at ambient pressure against temperature.
    pressure : Sourced
        The rule that gives alpha and the pressure laws at a temperature.
    shear, limiting_stress, thermal : Sourced or None
        Shear thinning, limiting shear stress, and thermal data.
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

    def pressure_laws_at(self, T: float) -> PressureLaws:
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
        laws = self.pressure_laws_at(T)
        law, said = self._own_rheology(T) if rheology is None else (rheology, "")
        source = f"{self.name} at {celsius(T)}. Viscosity: {self.viscosity.source} Pressure: {self.pressure.source}"
        reference = f"{source}{said}"
        return Oil(self.viscosity_at(T), laws.alpha, laws.viscosity, laws.density, reference=reference, rheology=law)

    def _own_rheology(self, T: float) -> tuple[str | Fluidity, str]:
        """The oil's own law of shear thinning at T (K), and what the reference says of it."""
        if self.shear is None:
            return "newtonian", ""
        if missing := self.shear.missing_at(T, "G and n", self.name):
            return "newtonian", f"{RHEOLOGY}Newtonian, {missing}."
        return self.shear.data, f"{RHEOLOGY}{self.shear.source.rstrip('.')}."


def celsius(T: float) -> str:
    """A temperature (K) as it is written in case files: "40 degC"."""
    return f"{round(T - ZERO_CELSIUS, 6):g} degC"
