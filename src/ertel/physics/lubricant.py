"""The oil: how viscosity and density change with pressure.

Every law is a small immutable object.  `viscosity(P)` gives eta/eta0 and `density(P)` gives rho/rho0 at the
dimensionless pressure P = p/p_h.  Any frozen dataclass with such a method can take its place, once it is registered
with `jax.tree_util.register_dataclass` like those below: a user's own law needs no derivative, the solver
differentiates it.
"""

from dataclasses import dataclass
from math import log
from typing import Any, ClassVar, Protocol

import jax.numpy as jnp
from jax.tree_util import register_dataclass

Array = Any  # a NumPy or JAX array of any shape, or a float

ALPHA = 2.2e-8  # 1/Pa, pressure-viscosity index of a typical mineral oil
ETA0 = 0.04  # Pa s, viscosity at ambient pressure
P0_ROELANDS = 1.96e8  # Pa, Roelands' pressure constant
DENSITY_PRESSURE = 5.9e8  # Pa, Dowson and Higginson's constant


class Viscosity(Protocol):
    """A viscosity law: eta/eta0 at P = p/p_h, and the paper or book it comes from."""

    reference: ClassVar[str]

    def viscosity(self, P: Array) -> Array: ...


class Density(Protocol):
    """A density law: rho/rho0 at P = p/p_h, and the paper or book it comes from."""

    reference: ClassVar[str]

    def density(self, P: Array) -> Array: ...


@register_dataclass
@dataclass(frozen=True)
class Isoviscous:
    """eta/eta0 = 1."""

    reference: ClassVar[str] = "constant viscosity"

    def viscosity(self, P: Array) -> Array:
        return jnp.ones_like(P)


@register_dataclass
@dataclass(frozen=True)
class Barus:
    """eta/eta0 = exp(alpha_bar P), alpha_bar = alpha p_h (dimensionless)."""

    alpha_bar: float
    reference: ClassVar[str] = (
        "Barus C. Isothermals, isopiestics and isometrics relative to viscosity. Am J Sci 1893;45:87-96"
    )

    def viscosity(self, P: Array) -> Array:
        return jnp.exp(self.alpha_bar * P)


@register_dataclass
@dataclass(frozen=True)
class Roelands:
    """eta/eta0 = exp{(alpha p0/z)[(1 + p_h P/p0)^z - 1]}, so that d ln(eta)/dp = alpha at p = 0.

    alpha_bar = alpha p_h and p_ratio = p_h/p0 are dimensionless; z is Roelands' exponent.
    """

    alpha_bar: float
    z: float
    p_ratio: float
    reference: ClassVar[str] = (
        "Roelands CWA. Correlational aspects of the viscosity-temperature-pressure relationship of lubricating oils. "
        "PhD thesis, TH Delft; 1966"
    )

    def viscosity(self, P: Array) -> Array:
        power = jnp.exp(self.z * jnp.log(1.0 + self.p_ratio * P))  # so written, its derivative needs no second power
        return jnp.exp(self.alpha_bar / (self.p_ratio * self.z) * (power - 1.0))


@register_dataclass
@dataclass(frozen=True)
class Incompressible:
    """rho/rho0 = 1."""

    reference: ClassVar[str] = "constant density"

    def density(self, P: Array) -> Array:
        return jnp.ones_like(P)


@register_dataclass
@dataclass(frozen=True)
class DowsonHigginson:
    """rho/rho0 = (5.9e8 + 1.34 p)/(5.9e8 + p), p in Pa; p_ratio = p_h / 5.9e8 Pa (dimensionless)."""

    p_ratio: float
    reference: ClassVar[str] = "Dowson D, Higginson GR. Elasto-hydrodynamic lubrication. Pergamon Press; 1966"

    def density(self, P: Array) -> Array:
        return (1.0 + 1.34 * self.p_ratio * P) / (1.0 + self.p_ratio * P)


@register_dataclass
@dataclass(frozen=True)
class Lubricant:
    """A viscosity law and a density law together."""

    viscosity_law: Viscosity
    density_law: Density

    def viscosity(self, P: Array) -> Array:
        """eta/eta0 at P = p/p_h, of P's shape."""
        return self.viscosity_law.viscosity(P)

    def density(self, P: Array) -> Array:
        """rho/rho0 at P = p/p_h, of P's shape."""
        return self.density_law.density(P)


def roelands_exponent(alpha: float, eta0: float, p0: float = P0_ROELANDS) -> float:
    """Roelands' z = alpha p0/(ln eta0 + 9.67), alpha in 1/Pa, eta0 in Pa s, p0 in Pa.

    Raises ValueError where eta0 lies below exp(-9.67) Pa s, for which the law has no meaning.
    """
    log_ratio = log(eta0) + 9.67
    if log_ratio <= 0:
        raise ValueError(f"eta0 = {eta0} Pa s: Roelands' law needs eta0 > 6.3e-5 Pa s")
    return alpha * p0 / log_ratio
