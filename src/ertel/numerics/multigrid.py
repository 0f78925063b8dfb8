"""A multigrid V-cycle for the linear operators of lubrication, used as a preconditioner.

On every grid the operator is

    e  ->  - div(eps grad q) + stretch * (K e) + local * q,    q = e        (zero where a node is not free)

eps has values along X and along Y (`stencils.Pair`).  It is almost zero inside a contact, where the elastic deformation
K e dominates, and very large outside, where diffusion dominates.  The smoother is chosen node by node: Jacobi where
diffusion dominates, distributive Jacobi where the deformation dominates.  Distributive Jacobi spreads a change as
(1; -1/4 to the four neighbours); the deformation of such a change is short-ranged.  Only neighbours that are smoothed
in the same way take a share: where diffusion dominates, it would leave a residual far larger than the one it removes.

With springs beside the fluid (`Springs`) q = e + stiff * (K e), and a node without flow has the row hold * q.

Source: Venner CH, Lubrecht AA. Multilevel methods in lubrication. Elsevier; 2000, ch. 6 and 7, written here for arrays.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, tree
from jax.tree_util import register_dataclass
from jax.typing import DTypeLike

from ertel.numerics import halfspace
from ertel.numerics.grid import NO_SYMMETRY, Grid, Symmetry
from ertel.numerics.stencils import Pair, diffusion, extended, face_sum

NEAR = 6  # coefficients of the nearest nodes that smoothers use
JACOBI_DAMPING = 0.8
DISTRIBUTIVE_DAMPING = 0.7
SPREAD_DIFFUSION = 2.0  # 1.25 is the diagonal, but the shortest wave has 4 and would grow where eps is large
LEAST_DIAGONAL = 0.2  # of that of constant eps, is kept where eps rises with e
# Jacobi where diffusion exceeds these shares of the deformation's stiffness for short and for long waves.  Jacobi
# amplifies long waves by the ratio of their deformation (of order one on every grid) to the diffusion
SHORT_WAVES, LONG_WAVES = 0.3, 0.03


@register_dataclass
@dataclass(frozen=True)
class DeformationOperator:
    """The deformation operator on one grid: the half space, spacing, and coefficients of the nearest nodes, [Y, X]."""

    kernel: halfspace.Kernel
    spacing: Array
    near: Array

    @property
    def even(self) -> Symmetry:
        """The axes about which fields are even and stored on one side (`stencils`)."""
        return self.kernel.even

    def displacement(self, e: Array) -> Array:
        return self.kernel.displacement(e)


class Springs(NamedTuple):
    """Springs beside the fluid: their stiffness; 1 where the fluid flows; and the size of the fluid's other terms."""

    stiff: Array
    flows: Array
    unit: Array


class Coefficients(NamedTuple):
    """The operator's coefficients on one grid, each of the grid's shape; free is 1 where e may be non-zero.

    steepening: what the change of eps with e adds to the diagonal.  Only the finest grid's own operator has it.
    """

    eps: Pair
    stretch: Array
    local: Array
    free: Array
    steepening: Array | float = 0.0
    springs: Springs | None = None

    def diffusion(self, elastic: DeformationOperator) -> Array:
        """The diagonal of - div(eps grad), shape of the grid."""
        return face_sum(self.eps, elastic.even) / elastic.spacing**2

    def carried(self, e: Array, Ke: Array) -> Array:
        """q."""
        return e if self.springs is None else e + self.springs.stiff * Ke

    def with_held(self, elastic: DeformationOperator, flowing: Array, q: Array) -> Array:
        """The rows of a grid: those of the nodes with flow are given."""
        if self.springs is None:
            return flowing
        return jnp.where(self.springs.flows > 0.0, flowing, self.hold(elastic) * q)

    def hold(self, elastic: DeformationOperator) -> Array:
        """The weight of a row without flow beside springs: the size of its neighbours'."""
        assert self.springs is not None
        return self.springs.unit + self.diffusion(elastic)


class Smoother(Protocol):
    """The relaxation of one grid, and the term that the mass stretch * (K e) + local * e adds to the operator.

    sweeps: their number before, and also after, the correction from the coarser grid.  balance: the mass term of the
    operator, the mass itself or also its derivative along X (`line_smoother`).  change: of e by one sweep, given the
    residual r.
    """

    @property
    def sweeps(self) -> int: ...
    def balance(self, mass: Array) -> Array: ...
    def change(self, r: Array) -> Array: ...


@register_dataclass
@dataclass(frozen=True)
class PointSmoother:
    """Smoother for single nodes: the inverse diagonals of the two kinds of change (zero where not in use).

    by_spread: 1 where the change is spread, 0 elsewhere.
    """

    jacobi: Array
    distributive: Array
    by_spread: Array
    even: Symmetry = field(default=NO_SYMMETRY, metadata={"static": True})
    sweeps: int = field(default=1, metadata={"static": True})

    def balance(self, mass: Array) -> Array:
        return mass

    def change(self, r: Array) -> Array:
        return self.jacobi * r + spread(self.distributive * r, self.by_spread, self.even)


Operator = Callable[[Array, Array], Array]  # a linear map of e and its deformation K e


@register_dataclass
@dataclass(frozen=True)
class GridLevel:
    """One grid of the hierarchy: the operator, and approximate coefficients for the smoother.

    inverse: the dense inverse of the operator, or its factors; on the coarsest grid only.
    """

    elasticity: DeformationOperator
    coefficients: Coefficients
    smoother: Smoother | None
    operator: Operator = field(metadata={"static": True})
    inverse: Array | tuple[Array, Array] | None = None


def deformation_operators(
    grid: Grid, compliance: float, dtype: str, reach: float = 1.0
) -> tuple[DeformationOperator, ...]:
    """The deformation operators of a grid and all its coarser ones; compliance, reach: see `halfspace.kernel`."""
    return tuple(_elasticity(g, compliance, dtype, reach) for g in grid.hierarchy())


def _elasticity(grid: Grid, compliance: float, dtype: str, reach: float) -> DeformationOperator:
    if grid.nodes_y == 1:
        near = halfspace.line_coefficients(NEAR, grid.spacing, reach)
    else:
        near = halfspace.love_coefficients(NEAR, NEAR, grid.spacing)
    near = compliance * near
    kernel = halfspace.kernel(grid, compliance, dtype, reach)
    spacing = jax.device_put(np.asarray(grid.spacing, dtype))
    return DeformationOperator(kernel, spacing, jax.device_put(near.astype(dtype)))


def point_smoother(elastic: DeformationOperator, c: Coefficients) -> PointSmoother:
    """The smoother for an operator without a derivative along X."""
    K, faces, springs = elastic.near, c.diffusion(elastic), c.springs
    # q by a change of a node, and by one that is spread
    one: Array | float = 1.0
    spread_one: Array | float = 1.0
    stretch = c.stretch
    if springs is not None:
        one, spread_one = 1.0 + springs.stiff * K[0, 0], 1.0 + springs.stiff * (K[0, 0] - K[0, 1])
        stretch = stretch + c.local * springs.stiff
    by_jacobi = faces > (SHORT_WAVES * K[0, 0] + LONG_WAVES) * stretch
    diffused = jnp.maximum(faces + c.steepening, LEAST_DIAGONAL * faces)
    jacobi = diffused * one + c.stretch * K[0, 0] + c.local * one
    spread_diffused = (SPREAD_DIFFUSION - 1.0 + spread_one) * diffused
    distributive = spread_diffused + c.stretch * (K[0, 0] - K[0, 1]) + c.local * spread_one
    if springs is not None:
        flows, hold = springs.flows > 0.0, c.hold(elastic)
        by_jacobi = jnp.where(flows, by_jacobi, springs.stiff < one)
        jacobi = jnp.where(flows, jacobi, hold * one)
        distributive = jnp.where(flows, distributive, hold * (spread_one + 0.25))
    alone, together = by_jacobi * c.free, ~by_jacobi * c.free
    by_one, by_spread = alone * (JACOBI_DAMPING / jacobi), together * (DISTRIBUTIVE_DAMPING / distributive)
    return PointSmoother(by_one, by_spread, together, elastic.even)


def hierarchy(
    elastic: Sequence[DeformationOperator],
    finest: Coefficients,
    smoother: Callable[[DeformationOperator, Coefficients], Smoother] = point_smoother,
    operator: Operator | None = None,
) -> tuple[GridLevel, ...]:
    """The levels, finest first: eps is restricted by full weighting, everything else by injection.

    operator: the operator on the finest grid if it differs from the module's (for example the exact Jacobian).  A grid
    of one row has no coarser ones: it is solved directly, and nothing is smoothed.
    """
    if finest.free.shape[0] == 1 and operator is not None:
        only = GridLevel(elastic[0], finest, None, operator)
        return (replace(only, inverse=jax.scipy.linalg.lu_factor(_matrix(only))),)
    coefficients = finest
    levels = []
    for e in elastic:
        smooth = smoother(e, coefficients)
        levels.append(GridLevel(e, coefficients, smooth, operator or partial(_operate, e, coefficients, smooth)))
        operator = None
        eps = tree.map(partial(restrict, even=e.even, beyond="edge"), coefficients.eps)
        springs = tree.map(lambda c: c[::2, ::2], coefficients.springs)
        stretch, local, free = (c[::2, ::2] for c in (coefficients.stretch, coefficients.local, coefficients.free))
        coefficients = Coefficients(eps, stretch, local, free, springs=springs)
    return *levels[:-1], replace(levels[-1], inverse=_inverse(levels[-1]))


def _operate(elastic: DeformationOperator, c: Coefficients, smoother: Smoother, e: Array, Ke: Array) -> Array:
    q = c.carried(e, Ke)
    flowing = smoother.balance(c.stretch * Ke + c.local * q) - diffusion(c.eps, q, elastic.even) / elastic.spacing**2
    return c.with_held(elastic, flowing, q)


def apply(level: GridLevel, e: Array, Ke: Array | None = None) -> Array:
    """The operator applied to e; K e is computed if it is not given."""
    deformation = level.elasticity.displacement(e) if Ke is None else Ke
    return level.coefficients.free * level.operator(e, deformation)


def v_cycle(levels: Sequence[GridLevel], r: Array) -> Array:
    """An approximate solution e of `apply(levels[0], e) = r`; both vanish where a node is not free.

    No deformation is computed on the grid itself.  The deformation of a sweep's change is computed on the coarser grid
    and corrected for near nodes.  The deformation of a correction from the coarser grid is interpolated.
    """
    level, coarser, even = levels[0], levels[1:], levels[0].elasticity.even
    if isinstance(level.inverse, tuple):
        return jax.scipy.linalg.lu_solve(level.inverse, r.ravel()).reshape(r.shape).astype(r.dtype)
    if level.inverse is not None:
        return (level.inverse @ r.ravel()).reshape(r.shape)
    e = relax(level, r)
    Ke = nearly_deformed(level, coarser[0], e)
    correction = v_cycle(coarser, coarser[0].coefficients.free * restrict(r - apply(level, e, Ke), even))
    e += level.coefficients.free * prolong(correction)
    Ke += prolong(coarser[0].elasticity.displacement(correction))
    return e + relax(level, r - apply(level, e, Ke))


def nearly_deformed(level: GridLevel, coarser: GridLevel, e: Array) -> Array:
    """K e by multilevel integration: the smooth part on the coarser grid, the rest from the nearest nodes.

    The part that a coarser grid cannot represent changes sign from node to node; its deformation is short-ranged.
    Source: Brandt A, Lubrecht AA. Multilevel matrix multiplication. J Comput Phys 1990;90:348.
    """
    smooth_part = restrict(e, level.elasticity.even)
    rest = e - prolong(smooth_part)
    return deformed_nearby(level, rest) + prolong(coarser.elasticity.displacement(smooth_part))


def deformed_nearby(level: GridLevel, e: Array) -> Array:
    """K e of short waves, from the node itself and the eight nodes around it.

    Their coefficients are such that waves that alternate from node to node, along one axis or along both, have their
    exact deformation.  With those of the kernel itself the former would have a quarter of it: it comes from afar, too.
    """
    p, itself = extended(e, level.elasticity.even), level.elasticity.near[0, 0]
    along_one, along_both = level.elasticity.kernel.alternating()
    far = 0.25 * (itself - along_one)
    near = 0.25 * (itself - along_both) + far
    beside = (p[1:-1, :-2] + p[1:-1, 2:]) + (p[:-2, 1:-1] + p[2:, 1:-1])
    diagonally = (p[:-2, :-2] + p[2:, 2:]) + (p[:-2, 2:] + p[2:, :-2])
    return itself * p[1:-1, 1:-1] + near * beside + far * diagonally


def precondition(levels: Sequence[GridLevel], r: Array) -> Array:
    """A V-cycle in the precision of the levels, for a residual r of any magnitude and precision."""
    size = jnp.linalg.norm(r)  # scaling prevents underflow of a small residual
    precision = in_precision(levels[0].coefficients.free.dtype, r)
    return v_cycle(levels, (r / size).astype(precision)).astype(r.dtype) * size


def in_precision(precision: DTypeLike, values: Array | complex) -> DTypeLike:
    """The type of values, real or complex, in the precision of a real type."""
    return jnp.promote_types(precision, "complex64") if jnp.iscomplexobj(values) else precision


@cache
def v_cycle_convolutions(grid: Grid) -> float:
    """The work of a V-cycle in convolutions; each counts as the nodes of its grid over those of the finest grid."""
    return sum(2.0 * g.size / grid.size for g in grid.hierarchy()[1:])


def relax(level: GridLevel, r: Array) -> Array:
    """The change of e by all sweeps, given the residual r.

    A later sweep includes only the deformation by the nearest nodes.  This is enough, because changes are either spread
    or made where diffusion dominates.
    """
    assert level.smoother is not None
    e = smooth(level, r)
    for _ in range(level.smoother.sweeps - 1):
        e += smooth(level, r - apply(level, e, deformed_nearby(level, e)))
    return e


def smooth(level: GridLevel, r: Array) -> Array:
    """The change of e by one sweep, given the residual r."""
    assert level.smoother is not None
    return level.coefficients.free * level.smoother.change(r)


def _inverse(level: GridLevel) -> Array:
    """The operator's inverse on the coarsest grid as a matrix; the identity where a node is not free."""
    return jnp.linalg.inv(_matrix(level)).astype(level.coefficients.free.dtype)


def _matrix(level: GridLevel) -> Array:
    """The operator as a matrix, in double precision, because the rows differ by many orders of magnitude."""
    free = level.coefficients.free
    unit_vectors = jnp.eye(free.size, dtype=free.dtype).reshape(free.size, *free.shape)
    matrix = jax.vmap(lambda e: apply(level, e).ravel())(unit_vectors).T * free.ravel() + jnp.diag(1.0 - free.ravel())
    return matrix.astype(jnp.promote_types(matrix.dtype, "float64"))


def spread(d: Array, receives: Array | float = 1.0, even: Symmetry = NO_SYMMETRY) -> Array:
    """The distributive change: d at the node, -d/4 at each of its four neighbours that receives (1, others 0)."""
    p = extended(d, even)
    return d - 0.25 * receives * ((p[:-2, 1:-1] + p[2:, 1:-1]) + (p[1:-1, :-2] + p[1:-1, 2:]))


@partial(jax.jit, static_argnames=("even", "beyond"))  # one tracing for each shape
def restrict(fine: Array, even: Symmetry = NO_SYMMETRY, beyond: str = "constant") -> Array:
    """Full weighting to every second node; beyond the edge the field is zero ("constant") or constant ("edge")."""
    p = extended(fine, even, beyond)
    in_y = 0.25 * (p[:-2:2] + 2.0 * p[1:-1:2] + p[2::2])
    return 0.25 * (in_y[:, :-2:2] + 2.0 * in_y[:, 1:-1:2] + in_y[:, 2::2])


def lowest_mean(field: Array, even: Symmetry, grids: int) -> Array:
    """The least of a field's mean values around each node, on this grid and on so many coarser ones."""
    if grids == 0:
        return field
    return jnp.minimum(field, prolong(lowest_mean(restrict(field, even), even, grids - 1)))


@jax.jit
def prolong(coarse: Array) -> Array:
    """Bilinear interpolation to twice as many cells."""
    rows = interleave(coarse, 0.5 * (coarse[1:] + coarse[:-1]))
    return interleave(rows.T, 0.5 * (rows.T[1:] + rows.T[:-1])).T


def prolong_smooth(coarse: Array) -> Array:
    """Cubic interpolation to twice as many cells, linear next to the edge; it preserves second derivatives."""
    return _interpolate(_interpolate(coarse).T).T


def _interpolate(coarse: Array) -> Array:
    linear = 0.5 * (coarse[1:] + coarse[:-1])
    return interleave(coarse, linear.at[1:-1].add((2 * linear[1:-1] - linear[2:] - linear[:-2]) / 8))


def interleave(nodes: Array, between: Array) -> Array:
    """Interleaved rows: those of `nodes`, with the rows of `between` (one fewer) between them."""
    pairs = jnp.stack([nodes[:-1], between], axis=1)
    return jnp.concatenate([pairs.reshape(-1, nodes.shape[1]), nodes[-1:]])
