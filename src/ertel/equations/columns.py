"""WarmColumns of warm oil: what a temperature that varies across the film makes of its flow.

With zeta from -1/2 at surface 2 to 1/2 at surface 1, the oil at each height is softer than that of the inlet's
temperature T0 at the same pressure by the factor f = eta(p, T0)/eta(p, T).  As in `shear`, whose symbols these are, the
stress is linear, tau = t + zeta g, and

    integral of f phi tau dzeta = s                           which fixes t
    velocity = u_2 + (h/eta) integral of f phi tau            from surface 2 on
    volume flux = u_m h - (h^2/eta) Q,      Q = integral of zeta f phi tau dzeta
    heat = f phi tau^2/eta                                    per volume

Two numbers of each column enter Reynolds' equation (`warm.WarmFlow`):

* the share c of the oil that the surfaces drag along.  Without a pressure gradient the stress is the same at all
  heights, so that the law of thinning drops out: c = 1 - S <zeta f>/<f>, with means across the film.  It is the
  viscosity wedge: where the slower surface is the hotter one, c > 1.
* theta, the mobility over that of the same film at T0, along X and along Y.  The mobility of an oil that thins is the
  mean of dQ/dg on the way from no gradient to this one.

All in SI.  Functions of the height have it as their first axis, at the points of `numerics.lobatto`.
Source: Yang P, Wen S. J Tribol 1990;112:631-636 (flow of an oil whose viscosity varies across the film).
"""

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array
from jax.tree_util import register_dataclass

from ertel.equations.across import Moments, Vector, assembled, dot, length, square, with_slope
from ertel.equations.shear import divided, middle_stress
from ertel.numerics.lobatto import Lobatto
from ertel.physics.fluidity import Fluidity
from ertel.physics.thermal import WarmViscosity

ON_THE_WAY = (0.5 - 0.75**0.5 / 3.0, 0.5 + 0.75**0.5 / 3.0)  # two Gauss points of the way from no gradient to all of it


class OilMotion(NamedTuple):
    """The movement of the oil at the points across the film.

    stress: t in Pa.  u, v: along X and along Y, m/s, shape (points, n_y, n_x).  heat: W/m^3, of the same shape.
    """

    stress: Vector
    u: Array
    v: Array
    heat: Array


@register_dataclass
@dataclass(frozen=True)
class WarmColumns:
    """The columns of a film, in SI; fields of shape (n_y, n_x).

    pressure: Pa.  film: h in m.  viscosity: eta(p, T0) in Pa s, with log_ratio, its logarithm over that at p = 0.
    gradient: g = h grad p, Pa.  u_1, u_2: speeds of the surfaces along X, m/s.
    """

    law: Fluidity
    warm: WarmViscosity
    pressure: Array
    film: Array
    viscosity: Array
    log_ratio: Array
    gradient: Vector
    u_1: Any
    u_2: Any
    across: Lobatto

    @property
    def sliding(self) -> Vector:
        """s = eta (u_1 - u_2)/h in Pa."""
        along_x = self.viscosity * (self.u_1 - self.u_2) / self.film
        return Vector(along_x, jnp.zeros_like(along_x))

    def softness(self, warmer: Array) -> Array:
        """f for temperatures above T0, in K."""
        return jnp.exp(-self.warm.change(self.log_ratio, warmer))

    def motion(self, warmer: Array) -> OilMotion:
        """Velocities and heat at temperatures above T0, of shape (points, n_y, n_x)."""
        f = self.softness(warmer)
        t = self._stress(f, self.gradient)
        tau = t + self.across.z * self.gradient
        rate = f * self.law.fluidity(length(tau), self.pressure) / self.viscosity
        u, v = (self.film * self.across.from_below(rate * along) for along in (tau.x, tau.y))
        return OilMotion(t, self.u_2 + u, v, rate * square(tau))

    def share(self, warmer: Array) -> Array:
        """c."""
        f, mean = self.softness(warmer), self.across.integral
        ratio = 2.0 * (self.u_1 - self.u_2) / (self.u_1 + self.u_2)
        return 1.0 - ratio * mean(self.across.z * f) / mean(f)

    def mobility(self, warmer: Array) -> Array:
        """The mean of dQ/dg along X and along Y, shape (2, n_y, n_x); theta is its ratio to that at T0."""
        f = self.softness(warmer)

        def at(share: float) -> tuple[Array, Array]:
            g = share * self.gradient
            m = self._moments(f, self._stress(f, g), g)
            of_x, of_y = Vector(*m.C[:2]), Vector(*m.C[1:])
            return m.D[0] - dot(divided(m.A, of_x), of_x), m.D[2] - dot(divided(m.A, of_y), of_y)

        first, second = (jnp.stack(at(share)) for share in ON_THE_WAY)
        return 0.5 * (first + second)

    def _stress(self, f: Array, g: Vector) -> Vector:
        """t; it changes with f when it is differentiated."""
        held, s = jax.lax.stop_gradient(f), self.sliding
        size = jnp.abs(self.across.z) * length(g)
        phi, slope = with_slope(self.law, self.pressure, jnp.maximum(size, 1e-60))
        resting = self.across.integral(held * (phi + slope * size**2))
        t, _ = middle_stress(self.law, self.pressure, s, g, resting, partial(self._moments, held, g=g))
        m = self._moments(held, t, g)
        tau = t + self.across.z * g
        flows = f * self.law.fluidity(length(tau), self.pressure)
        slid = Vector(self.across.integral(flows * tau.x), self.across.integral(flows * tau.y))
        return jax.lax.stop_gradient(t) + divided(jax.lax.stop_gradient(m.A), s - slid)

    def _moments(self, f: Array, t: Vector, g: Vector) -> Moments:
        z, mean = self.across.z, self.across.integral
        phi, slope = with_slope(self.law, self.pressure, length(t + z * g))
        return assembled([mean(z**k * f * phi) for k in range(3)], [mean(z**k * f * slope) for k in range(5)], t, g)
