"""The energy equation of the oil, and the heat that flows into both bodies.

In each column of oil, with the velocities and the heat of `columns` and z across the film:

    rho c (u dT/dx + v dT/dy) = k d2T/dz2 + heat + a_T T (u dp/dx + v dp/dy)
    surfaces: T_i = T_b,i + K_i q_i,     q_i = the flux into body i, with half of the heat of asperities

K_i is linear.  A body that moves through the contact gets warm by what has flowed in upstream, one at rest by what
flows in anywhere (`solvers.heat`).  Heat is conducted across the film only.  Oil that moves from one height to another
takes no heat along.

The heights are those of `numerics.lobatto`, and the equation is weighted with their weights.  So the columns keep the
balance of conduction, heat and fluxes to round-off.  Slopes along X and Y are of second order, from where the oil
at that height comes from; outside the grid it has the temperature of the inlet.

A change of the temperatures is found by sweeps along X, downstream and back.  What has flowed from the columns before
is known, so that each column is a small system of its own; flow along Y is left to the iteration around the sweeps.
The heat of a column follows its mean temperature.  Its full derivative would also have the shear that moves to
the warmest height, and a change may then be far too large.

All in SI; temperatures T above that of the inlet, with the heights as their first axis, shape (points, n_y, n_x).
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array
from jax.tree_util import register_dataclass

from ertel.equations.columns import OilMotion, WarmColumns
from ertel.numerics.grid import Symmetry

ENDS = (0, -1)  # surface 2 and surface 1


@register_dataclass
@dataclass(frozen=True)
class Energy:
    """The energy equation of a film.

    columns: of X that points downstream.  capacity: rho c, J/(m^3 K), shape (n_y, n_x).  conductivity: k, W/(m K).
    expansion: a_T, 1/K.  inlet: temperature in the inlet, K.  bodies, rises: T_b above it and K, of surface 2 and of
    surface 1.  solid: heat of asperities, W/m^2.  spacing: m.
    """

    columns: WarmColumns
    capacity: Array
    conductivity: Any
    expansion: Any
    inlet: Any
    bodies: tuple[Any, Any]
    rises: tuple[Any, Any]
    solid: Any
    spacing: Any
    even: Symmetry = field(metadata={"static": True})

    def residual(self, T: Array, m: OilMotion) -> Array:
        """The residual of temperatures, W/m^3 inside the film and K at both surfaces.  m: their motion."""
        kept = self._kept(T, m, m.heat, self.inlet)
        for end, body, rise, flux in zip(ENDS, self.bodies, self.rises, self.fluxes(T, m), strict=True):
            kept = kept.at[end].set(T[end] - body - rise(flux))
        return kept

    def fluxes(self, T: Array, m: OilMotion) -> tuple[Array, Array]:
        """The heat into body 2 and into body 1, W/m^2."""
        kept = self._kept(T, m, m.heat, self.inlet)
        first, last = (0.5 * self.solid - self.columns.film * kept[end] for end in ENDS)
        return first, last

    def change(self, d: Array, m: OilMotion, softer: Array) -> Array:
        """The change of `residual` by a change of the temperatures.  softer: that of the heat, by 1 K in a column."""
        kept = self._kept(d, m, softer * self.columns.across.integral(d), 0.0)
        for end, rise in zip(ENDS, self.rises, strict=True):
            kept = kept.at[end].set(d[end] - rise(-self.columns.film * kept[end]))
        return kept

    def compression(self, m: OilMotion) -> Array:
        """u dp/dx + v dp/dy at each height, W/m^3."""
        return (m.u * self.columns.gradient.x + m.v * self.columns.gradient.y) / self.columns.film

    def carried(self, T: Array, m: OilMotion) -> Array:
        """rho c (u dT/dx + v dT/dy), W/m^3."""
        return self.capacity * (_along_x(T, m.u, self.spacing) + _along_y(T, m.v, self.spacing, self.even))

    def _kept(self, T: Array, m: OilMotion, heat: Array, inlet: Any) -> Array:
        across, film = self.columns.across, self.columns.film
        compressed = self.expansion * (inlet + T) * self.compression(m)
        return across.weights * (self.carried(T, m) - heat - compressed) + self.conductivity / film**2 * across.stiff(T)


def _along_x(T: Array, u: Array, spacing: Any) -> Array:
    """u dT/dx; T = 0 beyond the grid."""
    p = jnp.pad(T, ((0, 0), (0, 0), (2, 2)))
    return _upwind(u, p[..., :-4], p[..., 1:-3], T, p[..., 3:-1], p[..., 4:]) / (2.0 * spacing)


def _along_y(T: Array, v: Array, spacing: Any, even: Symmetry) -> Array:
    """v dT/dy likewise; zero in a line contact."""
    if T.shape[1] == 1:
        return jnp.zeros_like(T)
    p = jnp.pad(T, ((0, 0), (2, 2), (0, 0)))
    if even.y:
        p = p.at[:, 0].set(p[:, 4]).at[:, 1].set(p[:, 3])
    return _upwind(v, p[:, :-4], p[:, 1:-3], T, p[:, 3:-1], p[:, 4:]) / (2.0 * spacing)


def _upwind(speed: Array, *T: Array) -> Array:
    """The speed times the slope on twice unit spacing, from five neighbouring values."""
    back, ahead = 3.0 * T[2] - 4.0 * T[1] + T[0], -3.0 * T[2] + 4.0 * T[3] - T[4]
    return jnp.maximum(speed, 0.0) * back + jnp.minimum(speed, 0.0) * ahead


# -- sweeps ------------------------------------------------------------------------------------------------------------


class ColumnSweep(NamedTuple):
    """The columns of the linear system, one after the other along X (first axis).

    inverse: of the system of each column, (n_x, points, points, n_y).  size: its diagonal, (points, n_y, n_x).  ends:
    the balance of heat at both surfaces, (n_x, 2, points, n_y).  carried: from the column before, downstream and back,
    two of (n_x, points, n_y).  own: K of a node by itself, (n_x, 2, n_y).  before: K of the columns before, downstream
    and back, two of (n_x, 2, n_x).  film: (n_x, n_y).
    """

    inverse: Array
    size: Array
    ends: Array
    carried: tuple[Array, Array]
    own: Array
    before: tuple[Array, Array]
    film: Array

    def __call__(self, wrong: Array, back: bool = False) -> Array:
        """The change of the temperatures that puts right what is wrong, as far as a sweep knows."""

        def column(past: Any, at: Any) -> Any:
            (last_but_one, last), q = past
            j, wrong, inverse, ends, carried, own, before, film = at
            brought = carried * (last_but_one - 4.0 * last)
            known, reached = wrong - brought, before @ q
            for e, end in enumerate(ENDS):
                known = known.at[end].set(wrong[end] + reached[e, e] - own[e] * film * brought[end])
            T = jnp.einsum("kly,ly->ky", inverse, known)
            flux = jnp.stack([-film * (jnp.sum(ends[e] * T, axis=0) + brought[end]) for e, end in enumerate(ENDS)])
            return ((last, T), q.at[:, j].set(flux)), T

        points, rows = wrong.shape[:2]
        n, zero = wrong.shape[2], jnp.zeros((points, rows))
        columns = jnp.arange(n), jnp.moveaxis(wrong, -1, 0), self.inverse, self.ends, self.carried[back]
        along = *columns, self.own, self.before[back], self.film
        _, T = jax.lax.scan(column, ((zero, zero), jnp.zeros((2, n, rows))), along, reverse=back)
        return jnp.moveaxis(T, 0, -1)


def sweep_of(energy: Energy, m: OilMotion, softer: Array) -> ColumnSweep:
    """The sweeps for `Energy.change`."""
    across, film = energy.columns.across, energy.columns.film
    points, once = softer.shape[0], energy.capacity / (2.0 * energy.spacing)
    each = jnp.eye(points)[:, :, None, None]
    flows = jnp.abs(m.u) + (0.0 if film.shape[0] == 1 else jnp.abs(m.v))
    stays = across.weights * (3.0 * once * flows - energy.expansion * energy.compression(m))
    matrix = each * stays + energy.conductivity / film**2 * across.stiffness[:, :, None, None]
    matrix = matrix - (across.weights * softer)[:, None] * across.weights
    ends, (alone, *before) = matrix[jnp.array(ENDS)], zip(*(rise.split() for rise in energy.rises), strict=True)
    own = jnp.stack([jnp.broadcast_to(one, film.shape) for one in alone])
    for e, end in enumerate(ENDS):
        matrix = matrix.at[end].set(each[end] + own[e] * film * ends[e])
    carried = [across.weights * once * jnp.maximum(u, 0.0) for u in (m.u, -m.u)]
    return ColumnSweep(
        _columns_first(_inverted(matrix)),
        matrix[jnp.arange(points), jnp.arange(points)],
        _columns_first(ends),
        (_columns_first(carried[0]), _columns_first(carried[1])),
        _columns_first(own),
        tuple(jnp.stack(K, axis=1) for K in before),  # type: ignore[arg-type]
        film.T,
    )


def _columns_first(field: Array) -> Array:
    return jnp.moveaxis(field, -1, 0)


def _inverted(matrix: Array) -> Array:
    """The inverses of many small matrices, shape (n, n, ...), by Gauss's and Jordan's elimination, all at once."""
    n = matrix.shape[0]
    unit = jnp.broadcast_to(jnp.eye(n).reshape(n, n, *[1] * (matrix.ndim - 2)), matrix.shape)
    both = jnp.concatenate([matrix, unit], axis=1)
    for k in range(n):
        row = both[k] / both[k, k]
        both = (both - both[:, k : k + 1] * row).at[k].set(row)
    return both[:, n:]
