"""Solid contact in the film: asperities carry the part P_c(H) of the pressure, and the oil carries the rest.

    P = P_f + P_c(H),    P_f >= 0,    r(P_f, H) >= 0,    P_f r = 0,    H = - Delta + gap + K P

P is the total pressure, which elasticity and the load see.  P_f is that of the oil: Reynolds' equation, the laws of the
oil and the sign condition see it.  H is the mean gap, above zero always.  A cavity (P_f = 0) carries P = P_c.

All quantities are dimensionless: P_c = p/p_h, H = h R/a^2.
"""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.tree_util import register_dataclass

from ertel.numerics.newton import Tangent
from ertel.physics.asperities import GapCurve

POINTS = 2000  # of a table: the cubic between them is exact to 1e-8
HIGHEST = 60.0  # ln P_c, at which the law ends: nothing is as stiff
TOUCHING = 1e-12  # of p_h, below which asperities do not touch
STEEP = 0.3  # of p_h: where P_c exceeds P by more, its tangent is taken at a larger gap


@register_dataclass
@dataclass(frozen=True)
class Asperities:
    """A law over x = ln H: a cubic between equidistant points, straight lines beyond the last ones.

    friction: the coefficient where they touch, in a/R.  first, step: of x.  cubic: coefficients of ln P_c, highest
    power first, shape (4, n - 1).  energy: ln of the integral of P_c from H to infinity, at the points.  area: share of
    area in touch there, None where no law says it.
    """

    friction: float
    first: float
    step: float
    cubic: Array
    energy: Array
    area: Array | None = None

    @classmethod
    def of(cls, curve: GapCurve, pressure_unit: float, film_unit: float, friction: float = 0.0) -> "Asperities":
        """The law from its points in SI.  pressure_unit: of P (Pa); film_unit: of H (m)."""
        from scipy.interpolate import CubicSpline  # SciPy loads slowly

        x = np.log(curve.h / film_unit)
        grid, step = np.linspace(x[0], x[-1], POINTS, retstep=True)
        ln_p = CubicSpline(x, np.log(curve.p / pressure_unit))(grid)
        work = np.exp(ln_p + grid)  # P_c dH = P_c H dx
        tail = work[-1] * step / max(-ln_p[-1] + ln_p[-2] - step, step)
        energy = tail + np.append(np.cumsum((0.5 * step * (work[1:] + work[:-1]))[::-1])[::-1], 0.0)
        area = None if curve.area is None else jax.device_put(np.interp(grid, x, curve.area))
        cubic, ln_energy = jax.device_put((CubicSpline(grid, ln_p).c, np.log(energy)))
        return cls(friction, float(grid[0]), float(step), cubic, ln_energy, area)

    def pressure(self, H: Array) -> Array:
        """P_c, shape of H."""
        return self._law(H)[0]

    def tangent(self, P: Array, H: Array) -> Tangent:
        """The tangent of P_c at H; where P_c is far above the whole pressure P, that at a larger gap.

        There the tangent at H is so steep that Newton's iteration would crawl along the curve.
        """
        there = jnp.maximum(H, self._gap(P + STEEP))
        value, slope = self._law(there)
        return Tangent(value + slope * (H - there), -slope)

    def stored(self, H: Array) -> Array:
        """The elastic energy that the asperities hold, per area: the integral of P_c from H to infinity."""
        return jnp.exp(jnp.interp(self._x(H), self._points(self.energy), self.energy))

    def touching(self, H: Array) -> Array:
        """The share of the area in touch, where the law says it."""
        assert self.area is not None
        return jnp.interp(self._x(H), self._points(self.area), self.area)

    def _law(self, H: Array) -> tuple[Array, Array]:
        """P_c and dP_c/dH."""
        place = (self._x(H) - self.first) / self.step
        i = jnp.clip(jnp.floor(place).astype(int), 0, self.cubic.shape[1] - 1)
        t = self.step * (place - i)
        inside = jnp.clip(t, 0.0, self.step)
        c = [jnp.take(row, i) for row in self.cubic]
        slope = (3.0 * c[0] * inside + 2.0 * c[1]) * inside + c[2]
        ln_p = ((c[0] * inside + c[1]) * inside + c[2]) * inside + c[3] + slope * (t - inside)
        P = jnp.exp(jnp.minimum(ln_p, HIGHEST))
        return P, P * slope / _open(H)

    def _gap(self, P: Array) -> Array:
        """The gap at which the asperities carry P > 0."""
        ln_p, x = self.cubic[3][::-1], self._points(self.cubic[3])[::-1]
        y = jnp.log(P)
        beyond = jnp.maximum(y - ln_p[-1], 0.0) / jnp.minimum(self.cubic[2, 0], -1e-3)
        return jnp.exp(jnp.interp(y, ln_p, x) + jnp.maximum(beyond, -50.0))

    def _x(self, H: Array) -> Array:
        return jnp.log(_open(H))

    def _points(self, values: Array) -> Array:
        return self.first + self.step * jnp.arange(values.shape[0])


def _open(H: Array) -> Array:
    """H above zero: an iteration may close a gap."""
    return jnp.maximum(H, 1e-30)
