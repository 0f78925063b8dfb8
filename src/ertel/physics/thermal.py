"""Heat in the film: thermal data of a solid, inlet shear heating, flash temperature, viscosity of the warm oil.

All quantities in SI.  The viscosity's coefficient of temperature is beta = -d ln(eta)/dT in 1/K.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, log, pi, sqrt
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

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
    require_positive(conductivity=conductivity)
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
    require_not_negative(L_t=L_t, slide_to_roll=slide_to_roll, p_h_over_E=p_h_over_E)
    return (1.0 - 13.2 * p_h_over_E * L_t**0.42) / (1.0 + 0.213 * (1.0 + 2.23 * slide_to_roll**0.83) * L_t**0.64)


def wilson_sheu_factor(L_t: float, slide_to_roll: float) -> float:
    """phi_T = 1/(1 + 0.1 (1 + 14.8 S^0.83) L_t^0.64): a rigid inlet, without the load.

    Wilson WRD, Sheu S. Effect of inlet shear heating due to sliding on elastohydrodynamic film thickness. J Lubr
    Technol 1983;105:187-188.  S as in `gupta_factor`.
    """
    require_not_negative(L_t=L_t, slide_to_roll=slide_to_roll)
    return 1.0 / (1.0 + 0.1 * (1.0 + 14.8 * slide_to_roll**0.83) * L_t**0.64)


class InletFactor(NamedTuple):
    """A formula for phi_T from (L_t, S, p_h/E'), with its source and its range in words."""

    formula: Callable[[float, float, float], float]
    source: str
    valid: str
    largest_L_t: float


InletName = Literal["solved", "gupta", "wilson-sheu", "none"]
INLET_FACTORS: dict[InletName, InletFactor] = {
    "solved": InletFactor(lambda *_: 1.0, "the film is solved with its heat", "any L_t", inf),
    "gupta": InletFactor(gupta_factor, "Gupta et al. 1992, Zhu and Cheng", "L_t up to about 1", 1.0),
    "wilson-sheu": InletFactor(
        lambda L_t, S, _: wilson_sheu_factor(L_t, S), "Wilson and Sheu 1983", "L_t up to about 1, low load", 1.0
    ),
    "none": InletFactor(lambda *_: 1.0, "a film without inlet shear heating", "any L_t", inf),
}


# -- flash temperature: how much hotter the surfaces of a sliding contact are than their bodies ------------------------
#
#     T(x) = (pi rho c k |u|)^{-1/2} * integral of q(x') |x - x'|^{-1/2} dx' over all x' upstream of x
#
# q is the heat flux into the body, in W/m^2, and u the speed of its surface through the contact.  Heat flows into the
# depth only, so that the speed must be high: Peclet number |u| a rho c/(2 k) above about 5 (Blok H. Proc Inst Mech Eng
# General Discussion on Lubrication 1937;2:222-235; Carslaw HS, Jaeger JC. Conduction of heat in solids. Oxford; 1959).
# From a surface at rest heat flows to all sides: T = 1/(2 pi k) * double integral of q/distance.
#
# The moving kernel is singular at x' = x.  It is integrated exactly over every cell, with q linear between the nodes.

Floats = NDArray[np.float64]
SLOWEST = 5.0  # Peclet number below which heat that flows along the surface counts
AT_REST = 4.0 / pi  # Peclet number of a circle with uniform heat that is as hot in its middle at rest as by the formula
AT_REST_ON_A_LINE = 0.1  # likewise of a strip that is a hundred times as long as wide, whose ends cool its middle


def peclet_number(solid: Solid, speed: float, half_width: float) -> float:
    """|u| a rho c/(2 k): speed in m/s, half width of the heated strip in m."""
    return abs(speed) * half_width * solid.density * solid.heat_capacity / (2.0 * solid.conductivity)


def slow_excess(peclet: float, is_line: bool = False) -> float:
    """By what share a temperature rise is too high where a surface is slow.

    Below AT_REST the surface counts as one at rest; above it, heat that flows along the surface is left out.  Compared
    with 2 q a/[k (4 + pi Pe)^{1/2}], the highest temperature of a circle with uniform heat, which joins both limits
    (Tian X, Kennedy FE. J Tribol 1994;116:167-174); on a line with their 2 q b/[k (pi + pi Pe)^{1/2}] of a long strip.

    Examples
    --------
    >>> round(slow_excess(SLOWEST), 2)
    0.12
    """
    if is_line:
        return sqrt(1.0 + 1.0 / max(peclet, AT_REST_ON_A_LINE)) - 1.0
    ratio = peclet / AT_REST
    return sqrt(1.0 + min(ratio, 1.0 / ratio if ratio > 0 else 0.0)) - 1.0


def moving_source_weights(nodes: int, spacing: float) -> Floats:
    """Weights of the kernel x^{-1/2}: the integral at node i is the sum over j <= i of weights[i - j] q[j].

    (4/3) spacing^{1/2} [(m + 1)^{3/2} - 2 m^{3/2} + |m - 1|^{3/2}] for m >= 1, and 4/3 spacing^{1/2} for m = 0: exact
    where q is linear between nodes and zero before the first.  Second order where q is smooth.  Shape (nodes,).
    """
    m = np.arange(nodes, dtype=float)
    weights = (m + 1.0) ** 1.5 - 2.0 * m**1.5 + np.abs(m - 1.0) ** 1.5
    weights[0] = 1.0
    return np.asarray(4.0 / 3.0 * sqrt(spacing) * weights)


def response(solid: Solid, speed: float, nodes: int, spacing: float) -> Floats:
    """The matrix K with T = q @ K.T along X: temperature rise (K) from the heat flux (W/m^2), shape (nodes, nodes).

    speed: of the surface along X, m/s, with its sign.  spacing in m.  Raises ValueError for speed = 0: from a surface
    at rest heat flows away to all sides, and the formula does not hold.
    """
    if not 0 < abs(speed) < inf:
        raise ValueError(f"speed = {speed}: must be finite and not zero")
    weights = moving_source_weights(nodes, spacing) / (sqrt(pi * abs(speed)) * solid.effusivity)
    lag = np.arange(nodes)[:, None] - np.arange(nodes)[None, :]
    matrix = np.where(lag >= 0, weights[np.abs(lag)], 0.0)
    return matrix if speed > 0 else np.asarray(matrix.T)


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
WARM_VISCOSITIES: dict[ViscosityName, type[WarmViscosity]] = {"houpert": Houpert, "exponential": Exponential}
