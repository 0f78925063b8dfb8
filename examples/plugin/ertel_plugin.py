"""A viscosity law and a shape for ertel; the entry points in pyproject.toml give them their names in case files.

In a case file:

    [lubricant]
    eta0 = "40 mPa*s"
    alpha = "22 / GPa"
    viscosity = { law = "mcewen", alpha = "22 / GPa", q = 12 }

    [[roughness]]
    shape = "scratch"
    depth = "200 nm"
    width = "20 um"
"""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from ertel.physics import units
from ertel.physics.units import Amount, Meaning, plain


@dataclass(frozen=True)
class McEwen:
    """eta/eta0 = (1 + alpha p/q)^q: between a line (q = 1) and Barus' law (q without bound)."""

    alpha: Annotated[float, units.COMPLIANCE, Meaning("pressure-viscosity coefficient at ambient pressure")]
    q: Annotated[float, units.ABOVE_ZERO, Meaning("McEwen's exponent", 12)]
    reference: ClassVar[str] = "McEwen E. J Inst Petrol 1952;38:646-672"

    def viscosity(self, p: Any) -> Any:
        """eta/eta0 at p (Pa), a number or an array of NumPy or JAX; same shape."""
        return (1.0 + self.alpha * p / self.q) ** self.q


@dataclass(frozen=True)
class Scratch:
    """A scratch across the flow."""

    depth: Annotated[Amount, units.HEIGHT, Meaning("its depth", "200 nm")]
    width: Annotated[Amount, units.WIDTH, Meaning("its width at half depth", "20 um")]
    x: Annotated[Amount, units.POSITION, Meaning("its place at T = 0")] = 0.0

    def heights(self, X: Any, Y: Any) -> Any:
        """Height over the surface in a^2/R, positive towards the film; X and Y in a broadcast."""
        distance = (X - plain(self.x)) / plain(self.width)
        return -plain(self.depth) * 2.0 ** -((2.0 * distance) ** 2) + np.zeros_like(Y)

    @property
    def size(self) -> float:
        """Its finest detail (a): ertel warns where the grid does not resolve it."""
        return plain(self.width)
