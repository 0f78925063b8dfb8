"""Viscosity and density laws of measured oils, with constants of their own: modulus, Doolittle, Tait.

The laws that follow from eta0 and alpha alone are in `lubricant`.  All are in SI: pressures and moduli in Pa.
"""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from ertel.physics.registry import DENSITY_LAWS, VISCOSITY_LAWS
from ertel.physics.units import ABOVE_ZERO, FINITE, SHARE, STRESS, Meaning

Array = Any  # a NumPy or JAX array of any shape, or a float


def arrays_of(p: Array) -> Any:
    """The namespace of an array's own functions: NumPy's or JAX's."""
    return p.__array_namespace__() if hasattr(p, "__array_namespace__") else np


@VISCOSITY_LAWS.register("modulus")
@dataclass(frozen=True)
class Modulus:
    """eta/eta0 = exp{p/(a + b p)}: a is 1/alpha, and the logarithm tends to 1/b at high pressure.

    b below zero is a viscosity that grows faster than Barus'; the law then ends at p = a/|b|.  highest: the pressure
    up to which the constants have a source.
    """

    a: Annotated[float, STRESS, Meaning("1/alpha", "50 MPa")]
    b: Annotated[float, FINITE, Meaning("1/ln(eta/eta0) at high pressure", 0.05)]
    highest: Annotated[float | None, STRESS, Meaning("pressure up to which a and b have a source", "1 GPa")] = None
    reference: ClassVar[str] = "Arana A et al. Proc Inst Mech Eng J 2019;233:303, at one temperature"

    def viscosity(self, p: Array) -> Array:
        """eta/eta0 at p (Pa); same shape as p."""
        return arrays_of(p).exp(p / (self.a + self.b * p))


@DENSITY_LAWS.register("tait")
@dataclass(frozen=True)
class Tait:
    """V/V0 = 1 - ln{1 + (p/K0)(1 + K0')}/(1 + K0'), with the bulk modulus K0 at ambient pressure; rho/rho0 = V0/V."""

    K0: Annotated[float, STRESS, Meaning("bulk modulus at ambient pressure", "1.2 GPa")]
    K0_prime: Annotated[float, ABOVE_ZERO, Meaning("its derivative with pressure", 11)]
    reference: ClassVar[str] = "Dymond JH, Malhotra R. The Tait equation: 100 years on. Int J Thermophys 1988;9:941-951"

    def volume(self, p: Array) -> Array:
        """V/V0 at p (Pa); same shape as p."""
        share = 1.0 + self.K0_prime
        return 1.0 - arrays_of(p).log(1.0 + p / self.K0 * share) / share

    def density(self, p: Array) -> Array:
        """rho/rho0 at p (Pa); same shape as p."""
        return 1.0 / self.volume(p)


@VISCOSITY_LAWS.register("doolittle")
@dataclass(frozen=True)
class Doolittle:
    """eta/eta0 = exp{B R (1 - V/V0)/[(V/V0 - R)(1 - R)]}: the free volume of a liquid that Tait's law compresses.

    R is the share of the volume at ambient pressure that the molecules occupy.  highest: the pressure up to which the
    constants have a source.
    """

    B: Annotated[float, ABOVE_ZERO, Meaning("Doolittle's constant", 4)]
    R: Annotated[float, SHARE, Meaning("volume of the molecules over that of the oil at ambient pressure", 0.67)]
    K0: Annotated[float, STRESS, Meaning("bulk modulus at ambient pressure", "1.2 GPa")]
    K0_prime: Annotated[float, ABOVE_ZERO, Meaning("its derivative with pressure", 11)]
    highest: Annotated[float | None, STRESS, Meaning("pressure up to which these have a source", "0.2 GPa")] = None
    reference: ClassVar[str] = (
        "Doolittle AK. Studies in Newtonian flow II. The dependence of the viscosity of liquids on free-space. "
        "J Appl Phys 1951;22:1471-1475"
    )

    @property
    def alpha(self) -> float:
        """Pressure-viscosity coefficient d ln(eta)/dp at ambient pressure (1/Pa)."""
        return self.B * self.R / (1.0 - self.R) ** 2 / self.K0

    def viscosity(self, p: Array) -> Array:
        """eta/eta0 at p (Pa); same shape as p."""
        volume = Tait(self.K0, self.K0_prime).volume(p)
        return arrays_of(p).exp(self.B * self.R * (1.0 - volume) / ((volume - self.R) * (1.0 - self.R)))
