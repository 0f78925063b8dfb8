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

A change of the temperatures is found by sweeps over the grid, from each of its corners to the one across.  What has
flowed from the columns before, along X and along Y, is known, so that each column is a small system of its own.
The heat of a column follows its mean temperature.  Its full derivative would also have the shear that moves to
the warmest height, and a change may then be far too large.

All in SI; temperatures T above that of the inlet, with the heights as their first axis, shape (points, n_y, n_x).
"""

from dataclasses import dataclass, field
from functools import partial
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
    """The columns of the linear system, one diagonal of the grid after the other: i + j = s, from 0 to n - 1.

    What has flowed into a column, along X and along Y, comes from the two diagonals before.  Fields are `_skewed`.

    inverse: of the system of each column, (n, points, points, n_y).  ends: the balance of heat at both surfaces, (n, 2,
    points, n_y).  carried: from the columns before along X and along Y, onwards and back, two of (n, 2, points, n_y).
    own: K of a node by itself, (n, 2, n_y).  before: K of the nodes before in the same row, onwards and back, two of
    (n, 2, n).  film: (n, n_y).  flipped: whether a sweep onwards goes against Y.
    """

    inverse: Array
    ends: Array
    carried: tuple[Array, Array]
    own: Array
    before: tuple[Array, Array]
    film: Array
    flipped: bool

    def __call__(self, wrong: Array, back: bool) -> Array:
        """The change of the temperatures that puts right what is wrong, as far as a sweep knows."""
        n, points, _, rows = self.inverse.shape

        def brought(carried: Array, beyond: Array, last: Array) -> Array:
            def from_row(T: Array, k: int) -> Array:
                around = jnp.pad(T, ((0, 0), (k, k)))
                return around[:, 2 * k :] if back else around[:, :rows]

            along_y = from_row(beyond, 2) - 4.0 * from_row(last, 1)
            return carried[0] * (beyond - 4.0 * last) + carried[1] * along_y

        def diagonal(past: Any, at: Any) -> Any:
            (beyond, last), q = past
            s, wrong, inverse, ends, carried, own, before, film = at
            came, reached = brought(carried, beyond, last), jnp.einsum("es,esy->ey", before, q)
            known = wrong - came
            for e, end in enumerate(ENDS):
                known = known.at[end].set(wrong[end] + reached[e] - own[e] * film * came[end])
            T = jnp.einsum("kly,ly->ky", inverse, known)
            flux = jnp.stack([-film * (jnp.sum(ends[e] * T, axis=0) + came[end]) for e, end in enumerate(ENDS)])
            return ((last, T), q.at[:, s].set(flux)), T

        zero = jnp.zeros((points, rows))
        fields = self.inverse, self.ends, self.carried[back], self.own, self.before[back], self.film
        along = jnp.arange(n), _skewed(wrong, self.flipped), *fields
        _, T = jax.lax.scan(diagonal, ((zero, zero), jnp.zeros((2, n, rows))), along, reverse=back)
        return _straight(T, self.flipped)


def sweeps_of(energy: Energy, m: OilMotion, softer: Array) -> tuple[Array, list[ColumnSweep]]:
    """The diagonal of `Energy.change`, (points, n_y, n_x), and sweeps for it: two, of a line contact one."""
    across, film, once = energy.columns.across, energy.columns.film, energy.capacity / (2.0 * energy.spacing)
    points, (rows, nodes) = softer.shape[0], film.shape
    each, is_line, n = jnp.eye(points)[:, :, None, None], rows == 1, rows + nodes - 1
    flows = jnp.abs(m.u) + (0.0 if is_line else jnp.abs(m.v))
    stays = across.weights * (3.0 * once * flows - energy.expansion * energy.compression(m))
    matrix = each * stays + energy.conductivity / film**2 * across.stiffness[:, :, None, None]
    matrix = matrix - (across.weights * softer)[:, None] * across.weights
    ends, (alone, *before) = matrix[jnp.array(ENDS)], zip(*(rise.split() for rise in energy.rises), strict=True)
    own = jnp.stack([jnp.broadcast_to(one, film.shape) for one in alone])
    for e, end in enumerate(ENDS):
        matrix = matrix.at[end].set(each[end] + own[e] * film * ends[e])
    inverse, carried = _inverted(matrix), across.weights * once * jnp.stack([m.u, m.v])

    def reached(K: Array, ahead: Array) -> Array:
        """K by the diagonals from one to those behind it."""
        return jnp.where(ahead > 0, jnp.pad(K, (0, n - nodes))[ahead], 0.0)

    ahead = jnp.arange(n)[:, None] - jnp.arange(n)
    onwards, back = (
        jnp.stack([reached(K, way) for K in both], axis=1) for both, way in zip(before, (ahead, -ahead), strict=True)
    )

    def sweep(flipped: bool) -> ColumnSweep:
        skewed = partial(_skewed, flipped=flipped)
        flow = carried * jnp.array([1.0, -1.0 if flipped else 1.0])[:, None, None, None]
        ways = skewed(jnp.maximum(flow, 0.0)), skewed(jnp.maximum(-flow, 0.0))
        return ColumnSweep(skewed(inverse), skewed(ends), ways, skewed(own), (onwards, back), skewed(film), flipped)

    size = matrix[jnp.arange(points), jnp.arange(points)]
    return size, [sweep(False)] if is_line else [sweep(False), sweep(True)]


def _skewed(field: Array, flipped: bool) -> Array:
    """A field (..., n_y, n_x) by diagonals, (n_x + n_y - 1, ..., n_y), with zeros beyond the grid."""
    field = field[..., ::-1, :] if flipped else field
    *first, rows, columns = field.shape
    n = columns + rows - 1
    # rows of n + 1 values that are read as rows of n: each begins one place later than the one before
    wide = jnp.pad(field, (*[(0, 0)] * (len(first) + 1), (0, rows))).reshape(*first, -1)
    return jnp.moveaxis(wide[..., : rows * n].reshape(*first, rows, n), -1, 0)


def _straight(field: Array, flipped: bool) -> Array:
    """The field of which `_skewed` are the diagonals."""
    n, *first, rows = field.shape
    wide = jnp.moveaxis(field, 0, -1).reshape(*first, rows * n)
    wide = jnp.pad(wide, (*[(0, 0)] * len(first), (0, rows))).reshape(*first, rows, n + 1)[..., : n + 1 - rows]
    return wide[..., ::-1, :] if flipped else wide


def _inverted(matrix: Array) -> Array:
    """The inverses of many small matrices, shape (n, n, ...), by Gauss's and Jordan's elimination, all at once."""
    n = matrix.shape[0]
    unit = jnp.broadcast_to(jnp.eye(n).reshape(n, n, *[1] * (matrix.ndim - 2)), matrix.shape)
    both = jnp.concatenate([matrix, unit], axis=1)
    for k in range(n):
        row = both[k] / both[k, k]
        both = (both - both[:, k : k + 1] * row).at[k].set(row)
    return both[:, n:]
