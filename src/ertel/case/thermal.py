"""The section [thermal] of a case: data of the oil and of both bodies for the temperatures of a steady contact."""

from dataclasses import dataclass
from math import cbrt
from typing import Annotated, NamedTuple

from ertel.case.records import show
from ertel.case.sections import Solver
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
from ertel.physics.units import CONDUCTIVITY, DENSITY, EXPANSION, HEAT_CAPACITY, TEMPERATURE, Meaning, explained


@explained
@dataclass(frozen=True)
class Thermal:
    """Data for the temperatures of a contact in SI: temperatures (K), data of the oil and of both bodies.

    How warm a machine gets is not known to a contact.  The named laws are in `physics.thermal`: WARM_VISCOSITIES, how
    the viscosity falls with the temperature under pressure, and INLET_FACTORS, by which formula inlet shear heating
    reduces the film.
    """

    temperature: Annotated[
        float,
        TEMPERATURE,
        Meaning("of the oil in the inlet, for which eta0 and alpha hold; left out: that in [lubricant]"),
    ]
    conductivity: Annotated[
        float, CONDUCTIVITY, Meaning("thermal conductivity of the oil; left out: that of the named oil")
    ]
    beta: Annotated[
        float,
        EXPANSION,
        Meaning("-d ln(eta)/dT of the oil at ambient pressure; left out: that of the named oil", "0.035 / K"),
    ]
    density_1: Annotated[float, DENSITY, Meaning("density of body 1; left out, as the next two: that of material_1")]
    heat_capacity_1: Annotated[float, HEAT_CAPACITY, Meaning("heat capacity of body 1", "460 J/(kg*K)")]
    conductivity_1: Annotated[float, CONDUCTIVITY, Meaning("thermal conductivity of body 1", "46 W/(m*K)")]
    density_2: Annotated[float, DENSITY, Meaning("density of body 2; left out, as the next two: that of material_2")]
    heat_capacity_2: Annotated[float, HEAT_CAPACITY, Meaning("heat capacity of body 2", "460 J/(kg*K)")]
    conductivity_2: Annotated[float, CONDUCTIVITY, Meaning("thermal conductivity of body 2", "46 W/(m*K)")]
    temperature_1: Annotated[
        float | None,
        TEMPERATURE,
        Meaning("of body 1 far below its surface; left out: that of the oil", "60 degC"),
    ] = None
    temperature_2: Annotated[
        float | None,
        TEMPERATURE,
        Meaning("of body 2 far below its surface; left out: that of the oil", "60 degC"),
    ] = None
    viscosity: Annotated[
        ViscosityName, Meaning("how it falls with the temperature: more under pressure, or equally at all pressures")
    ] = "houpert"
    inlet_factor: Annotated[InletName, Meaning("formula of the film with inlet shear heating")] = "gupta"

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

    def inlet(self, eta0: float, p_h_over_E: float, mean_speed: float, slide_to_roll: float) -> "Inlet":
        """Inlet shear heating; eta0 in Pa s, mean_speed in m/s."""
        L_t = thermal_loading(eta0, self.beta, mean_speed, self.conductivity)
        factor = INLET_FACTORS[self.inlet_factor].formula(L_t, abs(slide_to_roll), p_h_over_E)
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
    pressure = scales.p_h * cbrt(motion.load(0.0)) / scales.E_prime
    inlet = thermal.inlet(oil.eta0, pressure, motion.entrainment(0.0) * scales.front_speed, motion.slide_to_roll)
    if not inlet.factor > 0:
        raise ValueError(
            f"thermal.inlet_factor = {show(thermal.inlet_factor)}: its formula gives phi_T = {inlet.factor:.3g} at the "
            f'thermal loading L_t = {inlet.L_t:.3g}; must be above zero, use "wilson-sheu" or "none"'
        )
