"""Line smoother along X, for multigrid operators with a derivative along X:

    e  ->  - div(eps grad q) + (rate + drift d/dX)(stretch * (K e) + local * q),     drift >= 0,

with q = e, or e + stiff * (K e) beside springs (`multigrid`),
second-order upwind, first-order in the matrices of the lines.  For fields that oscillate in time, e exp(i omega T), the
rate is complex: i omega.  Or the mass upstream is multiplied by a phase, with which waves that ride with the flow pass
from node to node unchanged.

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

from ertel.numerics import multigrid
from ertel.numerics.grid import NO_SYMMETRY, Symmetry
from ertel.numerics.multigrid import Coefficients, DeformationOperator, interleave
from ertel.numerics.stencils import extended, face_sum, largest_around

DISTRIBUTIVE_DAMPING = 0.5  # less than of single nodes: the second-order wedge doubles the shortest waves
SHORT_WAVES, LONG_WAVES = 0.9, 0.03  # as in `multigrid`; short waves grow more readily with the derivative
# in units of the long waves' stiffness.  Where the diffusion at a node and at all nodes around it is less, Jacobi would
# amplify long waves: so it is where sliding thins the oil in the whole contact
MODERATE = 3.0
SHORT = 33  # nodes per line; elimination is as fast for lines up to this length


# -- cyclic reduction for many tridiagonal systems at once, factorised once and solved often --------------------------
#
# Every second unknown is eliminated, then every second of the rest, and so on, as on the grids of multigrid; here the
# coarse problem is exact.  The unknowns of one level are independent, unlike those in elimination along the line.  Rows
# are not exchanged, so the diagonal must not be small compared with the rest of its row.
#
# Source: Hockney RW. A fast direct solution of Poisson's equation using Fourier analysis. J ACM 1965;12:95.


class Rows(NamedTuple):
    """Rows of matrices with unit diagonal: the coefficients of the two neighbours, each of shape (lines, n)."""

    lower: Array
    upper: Array


class Factors(NamedTuple):
    """The scale factors of the rows, and the scaled rows.

    Of a line that is halved, rows are the even ones, odd the others, and rest the factors of what is left of the even
    rows when the odd nodes are eliminated.
    """

    scale: Array
    rows: Rows
    odd: Rows | None = None
    rest: "Factors | None" = None


def factorise(lower: Array, diagonal: Array, upper: Array) -> Factors:
    """Factors of the matrices with these bands, (lines, n): coefficients of unknowns i - 1, i and i + 1 in row i.

    Lines are halved while their number of nodes is odd and above SHORT.
    """
    scale, rows, n = 1.0 / diagonal, Rows(lower / diagonal, upper / diagonal), diagonal.shape[1]
    if n <= SHORT or n % 2 == 0:
        return Factors(scale, rows)
    odd, even = (Rows(*(part[:, first::2] for part in rows)) for first in (1, 0))
    diagonal = 1.0 - even.lower * _before(odd.upper) - even.upper * _after(odd.lower)
    rest = factorise(-even.lower * _before(odd.lower), diagonal, -even.upper * _after(odd.upper))
    return Factors(scale, even, odd, rest)


def solve_lines(factors: Factors, b: Array) -> Array:
    """The solutions for right-hand sides b of shape (lines, n)."""
    scale, (lower, upper), odd, rest = factors
    b = scale * b
    if odd is None or rest is None:
        return jax.lax.linalg.tridiagonal_solve(lower, jnp.ones_like(b), upper, b[..., None])[..., 0]
    left_out = b[:, 1::2]
    x = solve_lines(rest, b[:, ::2] - lower * _before(left_out) - upper * _after(left_out))
    between = left_out - odd.lower * x[:, :-1] - odd.upper * x[:, 1:]
    return interleave(x.T, between.T).T


def _before(odd: Array) -> Array:
    """At each even node, the value at the odd node before it; zero at the first."""
    return jnp.pad(odd, ((0, 0), (1, 0)))


def _after(odd: Array) -> Array:
    return jnp.pad(odd, ((0, 0), (0, 1)))


# -- the smoother -----------------------------------------------------------------------------------------------------


class _Flow(NamedTuple):
    """The rate, the drift and the phase of the module's docstring."""

    rate: Array
    drift_over_spacing: Array
    phase: Array


@register_dataclass
@dataclass(frozen=True)
class LineSmoother:
    """The factors of a tridiagonal matrix for each line.

    by_jacobi, by_spread: (n, n), 1 where a change stays at its node and where it is spread, 0 elsewhere.
    """

    factors: Factors
    by_jacobi: Array
    by_spread: Array
    flow: _Flow
    even: Symmetry = field(default=NO_SYMMETRY, metadata={"static": True})
    sweeps: int = field(default=2, metadata={"static": True})  # one damped sweep is not enough

    def balance(self, mass: Array) -> Array:
        m, phase = jnp.pad(mass, ((0, 0), (2, 0)), mode="edge"), self.flow.phase
        rise = 1.5 * m[:, 2:] - 2.0 * phase * m[:, 1:-1] + 0.5 * phase**2 * m[:, :-2]
        return self.flow.rate * mass + self.flow.drift_over_spacing * rise

    def change(self, r: Array) -> Array:
        d = solve_lines(self.factors, r)
        together = multigrid.spread(DISTRIBUTIVE_DAMPING * self.by_spread * d, self.by_spread, self.even)
        return multigrid.JACOBI_DAMPING * self.by_jacobi * d + together


def line_smoother(
    elastic: DeformationOperator, c: Coefficients, rate: Array | float, drift: Array | float, phase: Array | float = 1.0
) -> LineSmoother:
    """The smoother for an operator with a derivative along X; rate, drift and phase as in the module's docstring."""
    rate, drift, phase = (jnp.asarray(f, multigrid.in_precision(c.free.dtype, f)) for f in (rate, drift, phase))
    flow, size = _Flow(rate, drift / elastic.spacing, phase), jnp.abs(rate)
    # the derivative multiplies short waves by 1/spacing, long ones by one
    short, long = (size + flow.drift_over_spacing) * elastic.near[0, 0], size + drift
    stretch = c.stretch if c.springs is None else c.stretch + c.local * c.springs.stiff
    stiffness = (SHORT_WAVES * short + LONG_WAVES * long) * stretch
    diffusion = c.diffusion(elastic)
    jacobi = (diffusion > stiffness) & (largest_around(diffusion / stretch, elastic.even) > MODERATE * long)
    if c.springs is not None:
        held_alone = c.springs.stiff < 1.0 + c.springs.stiff * elastic.near[0, 0]
        jacobi = jnp.where(c.springs.flows > 0.0, jacobi, held_alone)
    by_jacobi, by_spread = jacobi * c.free, ~jacobi * c.free
    return LineSmoother(factorise(*_bands(elastic, c, by_spread, flow)), by_jacobi, by_spread, flow, elastic.even)


class _Pattern(NamedTuple):
    """A change of one at a node: the changes of its neighbours upstream, downstream, and on both sides together."""

    upstream: Array
    downstream: Array
    beside: Array

    def at(self, k: int) -> Array | float:
        """The change k nodes downstream on the line."""
        return 1.0 if k == 0 else {-1: self.upstream, 1: self.downstream}.get(k, 0.0)

    def deformation(self, K: Array, k: int) -> Array:
        """The deformation k nodes downstream on the line."""
        on_line = K[0, abs(k)] + self.upstream * K[0, abs(k + 1)] + self.downstream * K[0, abs(k - 1)]
        return on_line + self.beside * K[1, abs(k)]


def _bands(elastic: DeformationOperator, c: Coefficients, by_spread: Array, flow: _Flow) -> tuple[Array, Array, Array]:
    """The operator's three bands on each line; each node has its own kind of change."""
    p = extended(by_spread, elastic.even)
    pattern = _Pattern(*(-0.25 * by_spread * near for near in (p[1:-1, :-2], p[1:-1, 2:], p[:-2, 1:-1] + p[2:, 1:-1])))
    # of - div(eps grad e): the sum over the faces, the diagonal, and the coefficients of the faces along the line
    faces = face_sum(c.eps, elastic.even) / elastic.spacing**2
    centre = jnp.maximum(faces + c.steepening, multigrid.LEAST_DIAGONAL * faces)
    upstream = 0.5 * (c.eps.x + _upstream(c.eps.x)) / elastic.spacing**2
    downstream = _upstream(upstream, -1)

    def carried(k: int, at: int = 0) -> Array:
        """q by a change k nodes upstream of a node which is `at` nodes downstream of the row's own."""
        return _upstream(_carried(elastic, c, pattern, k + at), -at) if at else _carried(elastic, c, pattern, k)

    def diffused(k: int) -> Array:
        """By a change k nodes upstream."""
        return centre * carried(k) - upstream * carried(k, -1) - downstream * carried(k, 1)

    def coupling(k: int) -> Array:
        """The entry in row i, column i - k: the change is k nodes upstream."""
        # couplings outside the three bands count too: without them the sum over a line can be negative
        beyond, held = (diffused(2 * k), carried(2 * k)) if k else (0.0, 0.0)
        flowing = diffused(k) + beyond + _moved(elastic, c, pattern, k, flow)
        return flowing if c.springs is None else c.with_held(elastic, flowing, carried(k) + held)

    across = 0.5 * (faces - upstream - downstream) * pattern.beside  # from the neighbours on other lines
    if c.springs is not None:
        across = c.springs.flows * across
    diagonal = jnp.where(c.free > 0.0, coupling(0) - across, 1.0)
    return coupling(1) * c.free, diagonal, coupling(-1) * c.free


def _carried(elastic: DeformationOperator, c: Coefficients, pattern: _Pattern, k: int) -> Array:
    """q, k nodes downstream of a change."""
    change = _upstream(pattern.at(k) * c.free, k)
    if c.springs is None:
        return change
    return c.carried(change, _upstream(pattern.deformation(elastic.near, k) * c.free, k))


def _moved(elastic: DeformationOperator, c: Coefficients, pattern: _Pattern, k: int, flow: _Flow) -> Array:
    """(rate + drift d/dX)(stretch K + local), k nodes downstream of a change."""

    def mass(k: int) -> Array:
        deformation = _upstream(pattern.deformation(elastic.near, k), k)
        return c.stretch * deformation + c.local * _carried(elastic, c, pattern, k)

    def slope(k: int) -> Array:
        return flow.drift_over_spacing * (mass(k) - flow.phase * _upstream(mass(k - 1)))

    # couplings outside the three bands are added to the nearest band: a uniform change (one that rides with the flow)
    # must have no slope, otherwise it grows downstream
    return flow.rate * mass(k) + slope(k) + (slope(2) * jnp.conj(flow.phase) if k == 1 else 0.0)


def _upstream(f: Array, k: int = 1) -> Array:
    """At each node, the value k nodes upstream on its line; zero beyond the ends."""
    return jax.lax.pad(f, jnp.zeros((), f.dtype), ((0, 0, 0), (k, -k, 0)))
