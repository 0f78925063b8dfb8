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
class Strength:
    """Hardness (Pa), the mean pressure under an indenter, and what follows for a contact of smooth bodies.

    A metal's yield stress Y is about a third of its hardness (Tabor D. The hardness of metals. Oxford; 1951), and a
    point contact with nu = 0.3 begins to yield below its surface where the maximum Hertz pressure is 1.6 Y (Johnson KL.
    Contact mechanics. Cambridge; 1985, chapter 6).
    """

    title: ClassVar[str] = "yields at a maximum Hertz pressure of 1.6/3 of the hardness"
    hardness: Annotated[float, STRESS]

    @property
    def first_yield(self) -> float:
        """The maximum Hertz pressure (Pa) at which a point contact begins to yield."""
        return 1.6 / 3.0 * self.hardness


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
