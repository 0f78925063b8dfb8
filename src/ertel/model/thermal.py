"""The section [thermal] of a case: data of the oil and of both bodies for the temperatures of a steady contact."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ertel.model.records import show
from ertel.model.sections import Solver
from ertel.physics.lubricant import Oil
from ertel.physics.motion import Motion
from ertel.physics.scales import Scales
from ertel.physics.thermal import (
    INLET_FACTORS,
    WARM_VISCOSITIES,
    InletName,
    Solid,
    ViscosityName,
    WarmViscosity,
    thermal_loading,
)
from ertel.physics.units import CONDUCTIVITY, DENSITY, EXPANSION, HEAT_CAPACITY, TEMPERATURE


@dataclass(frozen=True)
class Thermal:
    """What the temperatures of a contact depend on, in SI.

    Parameters
    ----------
    temperature : float
        Of the oil in the inlet (K), for which eta0 and alpha hold.
    conductivity, beta : float
        Of the oil: thermal conductivity (W/(m K)) and -d ln(eta)/dT at ambient pressure (1/K), at that temperature.
    density_1, heat_capacity_1, conductivity_1, density_2, heat_capacity_2, conductivity_2 : float
        Of the bodies: density (kg/m^3), heat capacity (J/(kg K)) and thermal conductivity (W/(m K)).
    temperature_1, temperature_2 : float
        Of the bodies far below their surfaces (K); that of the oil in the inlet if it is not given.  How warm a machine
        gets is not known to a contact.
    viscosity : "houpert" or "exponential"
        How the viscosity falls with the temperature under pressure, see `physics.thermal.WARM_VISCOSITIES`.
    inlet_factor : "gupta", "wilson-sheu" or "none"
        The formula by which inlet shear heating reduces the film, see `physics.thermal.INLET_FACTORS`.
    """

    temperature: Annotated[float, TEMPERATURE]
    conductivity: Annotated[float, CONDUCTIVITY]
    beta: Annotated[float, EXPANSION]
    density_1: Annotated[float, DENSITY]
    heat_capacity_1: Annotated[float, HEAT_CAPACITY]
    conductivity_1: Annotated[float, CONDUCTIVITY]
    density_2: Annotated[float, DENSITY]
    heat_capacity_2: Annotated[float, HEAT_CAPACITY]
    conductivity_2: Annotated[float, CONDUCTIVITY]
    temperature_1: Annotated[float | None, TEMPERATURE] = None
    temperature_2: Annotated[float | None, TEMPERATURE] = None
    viscosity: ViscosityName = "houpert"
    inlet_factor: InletName = "gupta"

    def __post_init__(self) -> None:
        allowed: dict[str, list[str]] = {"viscosity": [*WARM_VISCOSITIES], "inlet_factor": [*INLET_FACTORS]}
        for name, known in allowed.items():
            if getattr(self, name) not in known:
                raise ValueError(f"{name} = {show(getattr(self, name))}: allowed: {', '.join(known)}")
        for name in ("temperature_1", "temperature_2"):
            if getattr(self, name) is None:
                object.__setattr__(self, name, self.temperature)

    @property
    def bodies(self) -> tuple[Solid, Solid]:
        """The thermal data of both bodies."""
        return (
            Solid(self.density_1, self.heat_capacity_1, self.conductivity_1),
            Solid(self.density_2, self.heat_capacity_2, self.conductivity_2),
        )

    @property
    def warmer(self) -> tuple[float, float]:
        """By how much the bodies are warmer than the oil in the inlet (K)."""
        assert self.temperature_1 is not None and self.temperature_2 is not None  # `__post_init__`
        return self.temperature_1 - self.temperature, self.temperature_2 - self.temperature

    def viscosity_of(self, eta0: float) -> WarmViscosity:
        """The law of the warm oil's viscosity.  Raises ValueError for an eta0 (Pa s) for which it has no meaning."""
        return WARM_VISCOSITIES[self.viscosity].of(eta0, self.beta, self.temperature)

    def inlet(self, eta0: float, scales: Scales, mean_speed: float, slide_to_roll: float) -> "Inlet":
        """Inlet shear heating; mean_speed in m/s."""
        L_t = thermal_loading(eta0, self.beta, mean_speed, self.conductivity)
        factor = INLET_FACTORS[self.inlet_factor].formula(L_t, abs(slide_to_roll), scales.p_h / scales.E_prime)
        return Inlet(L_t, factor)


class Inlet(NamedTuple):
    """Thermal loading L_t of the inlet, and phi_T, by which the film is thinner."""

    L_t: float
    factor: float


def check(thermal: Thermal, oil: Oil, scales: Scales | None, solver: Solver, motion: Motion) -> None:
    """Temperatures are those of a steady contact in SI, in which the film's formula has a meaning."""
    if solver.method != "steady":
        raise ValueError(
            f'thermal: is for a steady contact, and this one has solver.method = "{solver.method}"; leave the section '
            '[thermal] out, or use a rolling contact with solver.method = "steady"'
        )
    if scales is None or oil.eta0 is None:
        raise ValueError("thermal: needs a contact in SI; give radius, load, ... or leave the section [thermal] out")
    try:
        thermal.viscosity_of(oil.eta0)
    except ValueError as error:
        raise ValueError(f"thermal.viscosity = {show(thermal.viscosity)}: {error}") from error
    inlet = thermal.inlet(oil.eta0, scales, motion.entrainment(0.0) * scales.front_speed, motion.slide_to_roll)
    if not inlet.factor > 0:
        raise ValueError(
            f"thermal.inlet_factor = {show(thermal.inlet_factor)}: its formula gives phi_T = {inlet.factor:.3g} at the "
            f'thermal loading L_t = {inlet.L_t:.3g}; must be above zero, use "wilson-sheu" or "none"'
        )
