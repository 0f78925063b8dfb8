"""The two bodies: reduced modulus and radius, the mass of a ball and its speed after a fall, and their materials.

All functions take and return SI units.
"""

from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import Annotated, ClassVar

from ertel.physics.oils import Sourced, ThermalData
from ertel.physics.units import DENSITY, STRESS, Bounds, require_positive


def reduced_modulus(E1: float, nu1: float, E2: float, nu2: float) -> float:
    """Reduced modulus E' (Pa), 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, from Young's moduli (Pa), Poisson's ratios."""
    for name, E in {"E1": E1, "E2": E2}.items():
        require_positive(name, E)
    for name, nu in {"nu1": nu1, "nu2": nu2}.items():
        if not -1 < nu <= 0.5:
            raise ValueError(f"{name} = {nu}: Poisson's ratio must be above -1 and not above 0.5")
    return 2 / ((1 - nu1**2) / E1 + (1 - nu2**2) / E2)


def reduced_radius(R1: float, R2: float = inf) -> float:
    """Reduced radius R (m), 1/R = 1/R1 + 1/R2, of two balls, or of a ball on a plane (R2 infinite)."""
    require_positive("R1", R1)
    if not R2 > 0:
        raise ValueError(f"R2 = {R2}: must be above zero (infinite for a plane)")
    return 1 / (1 / R1 + 1 / R2)


def conforming_radius(R1: float, R2: float) -> float:
    """Reduced radius R (m) along one principal axis, 1/R = 1/R1 + 1/R2: concave radii are negative, planes infinite.

    It is infinite or negative where the curvatures do not add up to more than zero: no contact at a point.
    """
    curvature = 1 / R1 + 1 / R2
    return 1 / curvature if curvature else inf


def sphere_mass(radius: float, density: float) -> float:
    """Mass (kg) of a solid ball of the given radius (m) and density (kg/m^3)."""
    require_positive("radius", radius)
    require_positive("density", density)
    return 4 * pi / 3 * density * radius**3


def drop_speed(height: float, g: float = 9.80665) -> float:
    """Speed v0 = sqrt(2 g h) (m/s) of a ball dropped from a height (m), without air drag."""
    require_positive("height", height)
    require_positive("g", g)
    return sqrt(2 * g * height)


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
