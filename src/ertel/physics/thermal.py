"""Heat in the film: inlet shear heating, viscosity of the warm oil, thermal data of a solid.

All quantities in SI.  The viscosity's coefficient of temperature is beta = -d ln(eta)/dT in 1/K.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, log, sqrt
from typing import Annotated, Any, Literal, NamedTuple

from ertel.physics.registry import arrays_of
from ertel.physics.units import CONDUCTIVITY, DENSITY, HEAT_CAPACITY, require_not_negative, require_positive


@dataclass(frozen=True)
class Solid:
    """Thermal data of a body: density in kg/m^3, heat capacity in J/(kg K), conductivity in W/(m K)."""

    density: Annotated[float, DENSITY]
    heat_capacity: Annotated[float, HEAT_CAPACITY]
    conductivity: Annotated[float, CONDUCTIVITY]

    @property
    def effusivity(self) -> float:
        """(rho c k)^{1/2}, in J/(m^2 K s^{1/2})."""
        return sqrt(self.density * self.heat_capacity * self.conductivity)


# -- the inlet --------------------------------------------------------------------------------------------------------


def thermal_loading(eta0: float, beta: float, u_m: float, conductivity: float) -> float:
    """L_t = eta0 beta u_m^2/k, the thermal loading of the inlet (not Moes' L).  u_m: mean speed, m/s."""
    require_positive("conductivity", conductivity)
    return eta0 * beta * u_m**2 / conductivity


def gupta_factor(L_t: float, slide_to_roll: float, p_h_over_E: float) -> float:
    """Film with inlet shear heating over the isothermal film.

        phi_T = (1 - 13.2 (p_h/E') L_t^0.42)/(1 + 0.213 (1 + 2.23 S^0.83) L_t^0.64)

    Gupta PK, Cheng HS, Zhu D, Forster NH, Schrand JB. Viscoelastic effects in MIL-L-7808-type lubricant, part I. Tribol
    Trans 1992;35:269-274.  S = |u1 - u2|/u_m with the mean speed.  Below L_t = 0.1 the factor is above 0.9 in pure
    rolling; up to L_t of about 1 the film is set in the inlet, as the formula assumes.

    Raises ValueError for negative arguments.

    Examples
    --------
    >>> round(gupta_factor(1.0, 0.2, 0.5 / 226), 4)
    0.7256
    """
    _check_inlet(L_t, slide_to_roll)
    require_not_negative("p_h_over_E", p_h_over_E)
    return (1.0 - 13.2 * p_h_over_E * L_t**0.42) / (1.0 + 0.213 * (1.0 + 2.23 * slide_to_roll**0.83) * L_t**0.64)


def wilson_sheu_factor(L_t: float, slide_to_roll: float) -> float:
    """phi_T = 1/(1 + 0.1 (1 + 14.8 S^0.83) L_t^0.64): a rigid inlet, without the load.

    Wilson WRD, Sheu S. Effect of inlet shear heating due to sliding on elastohydrodynamic film thickness. J Lubr
    Technol 1983;105:187-188.  S as in `gupta_factor`.
    """
    _check_inlet(L_t, slide_to_roll)
    return 1.0 / (1.0 + 0.1 * (1.0 + 14.8 * slide_to_roll**0.83) * L_t**0.64)


class InletFactor(NamedTuple):
    """A formula for phi_T from (L_t, S, p_h/E'), with its source and its range in words."""

    formula: Callable[[float, float, float], float]
    source: str
    valid: str
    largest_L_t: float


InletName = Literal["gupta", "wilson-sheu", "none"]
INLET_FACTORS: dict[InletName, InletFactor] = {
    "gupta": InletFactor(gupta_factor, "Gupta et al. 1992, Zhu and Cheng", "L_t up to about 1", 1.0),
    "wilson-sheu": InletFactor(
        lambda L_t, S, _: wilson_sheu_factor(L_t, S), "Wilson and Sheu 1983", "L_t up to about 1, low load", 1.0
    ),
    "none": InletFactor(lambda *_: 1.0, "a film without inlet shear heating", "any L_t", inf),
}


def _check_inlet(L_t: float, slide_to_roll: float) -> None:
    require_not_negative("L_t", L_t)
    require_not_negative("slide_to_roll", slide_to_roll)


# -- the viscosity of the warm oil ------------------------------------------------------------------------------------

Array = Any  # a NumPy or JAX array of any shape, or a float
ViscosityName = Literal["houpert", "exponential"]
COLDEST_OIL = 138.0  # K: Roelands' temperature at which every oil has an infinite viscosity
ROELANDS_LOG = 9.67  # minus the logarithm of his viscosity at a pressure of - p0, in Pa s
NEAREST = 0.05  # to that temperature, over the inlet's distance to it


@dataclass(frozen=True)
class Houpert:
    """Roelands' law of temperature in Houpert's form, for any law of pressure.

        ln eta + 9.67 is proportional to (T - 138 K)^{-S0},    S0 = beta (T0 - 138 K)/(ln eta0 + 9.67)

    at every pressure, so that the coefficient of temperature at the inlet's temperature T0 grows with the pressure:
    beta(p) = beta (ln eta(p) + 9.67)/(ln eta0 + 9.67).  Houpert L. New results of traction force calculations in
    elastohydrodynamic contacts. J Tribol 1985;107:241-248.

    log_viscosity: ln eta0 + 9.67.  exponent: S0.  distance: T0 - 138 K.
    """

    log_viscosity: float
    exponent: float
    distance: float

    @classmethod
    def of(cls, eta0: float, beta: float, temperature: float) -> "Houpert":
        """The law of an oil with eta0 (Pa s) and beta (1/K) at `temperature` (K).

        Raises ValueError unless eta0 > 6.3e-5 Pa s and temperature > 138 K, where the law has no meaning.
        """
        log_viscosity, distance = log(eta0) + ROELANDS_LOG, temperature - COLDEST_OIL
        if not log_viscosity > 0:
            raise ValueError(f"eta0 = {eta0} Pa s: Houpert's law needs eta0 > 6.3e-5 Pa s")
        if not distance > 0:
            raise ValueError(f"temperature = {temperature} K: Houpert's law needs more than {COLDEST_OIL:g} K")
        return cls(log_viscosity, beta * distance / log_viscosity, distance)

    def change(self, log_ratio: Array, warmer: Array) -> Array:
        """ln eta(p, T) - ln eta(p, T0), from ln eta(p, T0)/eta0 and T - T0 in K."""
        xp = arrays_of(warmer)
        share = xp.maximum(1.0 + warmer / self.distance, NEAREST)
        return (self.log_viscosity + log_ratio) * xp.expm1(-self.exponent * xp.log(share))


@dataclass(frozen=True)
class Exponential:
    """eta = eta(p, T0) exp{-beta (T - T0)}: one beta for all pressures."""

    beta: float

    @classmethod
    def of(cls, eta0: float, beta: float, temperature: float) -> "Exponential":
        """The law of an oil with the coefficient beta (1/K)."""
        return cls(beta)

    def change(self, log_ratio: Array, warmer: Array) -> Array:
        """ln eta(p, T) - ln eta(p, T0), from ln eta(p, T0)/eta0, which does not matter, and T - T0 in K."""
        return -self.beta * warmer


WarmViscosity = Houpert | Exponential
WARM_VISCOSITIES: dict[ViscosityName, type[Houpert] | type[Exponential]] = {
    "houpert": Houpert,
    "exponential": Exponential,
}
