"""Line smoother along X, for multigrid operators with a derivative along X:

    e  ->  - div(eps grad e) + (rate + drift d/dX)(stretch * (K e) + local * e),     drift >= 0,

first-order upwind.  For fields that oscillate in time, e exp(i omega T), the rate is complex: i omega.  Or the mass
upstream is multiplied by a phase, with which waves that ride with the flow pass from node to node unchanged.

A change at a node affects every node downstream, so all nodes of an X line are solved together, and all lines at once.
Each node has the kind of change that suits it: at the node alone (Jacobi) or spread over its neighbours
(distributive).  Only the nearest couplings along a line are kept, with the deformation's K00, K10, K20 or those of a
spread change.

Source: Venner CH, Lubrecht AA. Multilevel methods in lubrication. Elsevier; 2000, ch. 6 and 7, written here for arrays.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array
from jax.tree_util import register_dataclass

from ertel.numerics import multigrid, tridiagonal
from ertel.numerics.grid import WHOLE, Even
from ertel.numerics.multigrid import Coefficients, Elasticity
from ertel.numerics.stencils import face_sum
from ertel.numerics.tridiagonal import Factors

JACOBI_DAMPING = 0.4  # both are smaller than in the point smoother, for the second-order wedge and pressure spikes
DISTRIBUTIVE_DAMPING = 0.3


@register_dataclass
@dataclass(frozen=True)
class LineSmoother:
    """The factors of a tridiagonal matrix for each line; by_jacobi, (n, n): 1 where the change is not spread."""

    factors: Factors
    by_jacobi: Array
    rate: Array
    drift_over_spacing: Array
    phase: Array
    even: Even = field(default=WHOLE, metadata={"static": True})
    sweeps: int = field(default=2, metadata={"static": True})  # one damped sweep is not enough

    def balance(self, mass: Array) -> Array:
        rise = jnp.pad(mass[:, 1:] - self.phase * mass[:, :-1], ((0, 0), (1, 0)))
        return self.rate * mass + self.drift_over_spacing * rise

    def change(self, r: Array) -> Array:
        d = tridiagonal.solve(self.factors, r)
        together = multigrid.spread(DISTRIBUTIVE_DAMPING * (1.0 - self.by_jacobi) * d, self.even)
        return JACOBI_DAMPING * self.by_jacobi * d + together


class _Pattern(NamedTuple):
    """The effect of a change at a node on its own line, at a distance of 0, 1 and 2 nodes."""

    deformation: tuple[Array, Array, Array]
    change: tuple[float, float, float]


class _Flow(NamedTuple):
    rate: Array
    drift_over_spacing: Array
    phase: Array


def line_smoother(
    elastic: Elasticity, c: Coefficients, rate: Array | float, drift: Array | float, phase: Array | float = 1.0
) -> LineSmoother:
    """The smoother for an operator with a derivative along X; rate, drift and phase as in the module's docstring."""
    rate, drift, phase = (jnp.asarray(f, multigrid.in_precision(c.free.dtype, f)) for f in (rate, drift, phase))
    flow, size = _Flow(rate, drift / elastic.spacing, phase), jnp.abs(rate)
    # the derivative multiplies short waves by 1/spacing, long ones by one
    by_jacobi = multigrid.diffusion_rules(elastic, c, size + flow.drift_over_spacing, size + drift).astype(c.free.dtype)
    factors = tridiagonal.factorise(*_bands(elastic, c, by_jacobi, flow))
    return LineSmoother(factors, by_jacobi * c.free, *flow, elastic.even)


def _bands(elastic: Elasticity, c: Coefficients, by_jacobi: Array, flow: _Flow) -> tuple[Array, Array, Array]:
    """The operator's three bands on each line; each node has its own kind of change."""
    K, own, along = elastic.near, *_diffusion(elastic, c)
    alone = _Pattern((K[0, 0], K[0, 1], K[0, 2]), (1.0, 0.0, 0.0))
    spread = _Pattern((_spread(K, 0), _spread(K, 1), _spread(K, 2)), (1.0, -0.25, 0.0))

    def coupling(k: int, diffusion_alone: Array, diffusion_spread: Array) -> Array:
        """The entry in row i, column i - k: the change is k nodes upstream."""
        kind = _shifted(by_jacobi, k)
        return kind * (diffusion_alone + _carried(c, alone, k, flow)) + (1.0 - kind) * (
            diffusion_spread + _carried(c, spread, k, flow)
        )

    lower = coupling(1, -along, -along - 0.25 * own) * c.free
    upper = coupling(-1, -_downstream(along), -_downstream(along) - 0.25 * own) * c.free
    return lower, jnp.where(c.free > 0.0, coupling(0, own, 1.25 * own), 1.0), upper


def _diffusion(elastic: Elasticity, c: Coefficients) -> tuple[Array, Array]:
    """The diagonal coefficient of - div(eps grad e), and the coefficient of the upstream face."""
    own, upstream = face_sum(c.eps, elastic.even), 0.5 * (c.eps.x + _upstream(c.eps.x))
    return own / elastic.spacing**2, upstream / elastic.spacing**2


def _spread(K: Array, k: int) -> Array:
    """The deformation k nodes away along the line from a change that is spread as (1; -1/4)."""
    return K[0, k] - 0.25 * (K[0, abs(k - 1)] + K[0, k + 1] + 2.0 * K[1, k])


def _carried(c: Coefficients, pattern: _Pattern, k: int, flow: _Flow) -> Array:
    """(rate + drift d/dX)(stretch K + local), k nodes downstream of a change."""

    def mass(k: int) -> Array:
        return c.stretch * pattern.deformation[abs(k)] + c.local * pattern.change[abs(k)]

    def slope(k: int) -> Array:
        return flow.drift_over_spacing * (mass(k) - flow.phase * _upstream(mass(k - 1)))

    # couplings outside the three bands are added to the nearest band: a uniform change (one that rides with the flow)
    # must have no slope, otherwise it grows downstream
    return flow.rate * mass(k) + slope(k) + (slope(2) * jnp.conj(flow.phase) if k == 1 else 0.0)


def _upstream(f: Array) -> Array:
    """At each node, the value at the previous node of its line."""
    return _shifted(f, 1)


def _downstream(f: Array) -> Array:
    return _shifted(f, -1)


def _shifted(f: Array, k: int) -> Array:
    """The field shifted by k nodes along the lines; zeros enter at the ends."""
    return jax.lax.pad(f, jnp.zeros((), f.dtype), ((0, 0, 0), (k, -k, 0)))
