"""Materials of the two bodies: elasticity for the contact, thermal data for its heating."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from ertel.physics.bodies import reduced_modulus
from ertel.physics.oils import Sourced, ThermalData
from ertel.physics.units import DENSITY, STRESS, Bounds


@dataclass(frozen=True)
class Elasticity:
    """Young's modulus E (Pa), Poisson's ratio nu and density (kg/m^3)."""

    title: ClassVar[str] = "isotropic"
    E: Annotated[float, STRESS]
    nu: Annotated[float, Bounds(gt=-1, le=0.5)]
    density: Annotated[float, DENSITY]


@dataclass(frozen=True)
class Material:
    """A material with the sources of its data."""

    name: str
    text: str
    elasticity: Sourced[Elasticity]
    thermal: Sourced[ThermalData] | None = None

    def reduced_modulus(self, other: "Material") -> float:
        """Reduced modulus E' (Pa) of a contact with another material, 2/E' = sum of (1 - nu^2)/E."""
        first, second = self.elasticity.data, other.elasticity.data
        return reduced_modulus(first.E, first.nu, second.E, second.nu)
