"""Newton-Krylov iteration with an active set, for a field P >= 0 and a field H that is affine in P.

    r(P, H) = 0 where P > 0,   r(P, H) >= 0 where P = 0,   H = H(P) affine

The Jacobian is exact (automatic differentiation of r).  The affine part is given as a separate linear map, because it
is expensive (a convolution): each Newton iteration and each Krylov iteration needs it once, not counting the
preconditioner.

H may depend on one more unknown, a number with a linear equation of its own (such as a given load): see `Border`.
The linear systems are solved by generalised conjugate residuals with a preconditioner, `gcr`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, tree

from ertel.numerics.programs import exportable

Map = Callable[[Array], Array]


@dataclass(frozen=True)
class Options:
    """Limits of the iteration.

    largest_change: of P, and of s as a share of the smallest H where that is above one, in one Newton iteration.
    first_reduction: reduction of the linear residual in the first Newton iteration.  krylov_reduction: the strongest
    reduction in later ones, see `_forcing`.
    """

    newton_least: int = 1  # at least 1: errors of predictions within the tolerance would accumulate from step to step
    newton_limit: int = 40
    filling_limit: int = 6  # iterations that use `filled`: it may free and hold the same nodes in turns
    krylov_limit: int = 16
    krylov_reduction: float = 1e-2
    first_reduction: float = 1e-2
    largest_change: float = 0.3


class Border(NamedTuple):
    """One more unknown: a number s, by which H changes uniformly, and its linear equation misfit(P, s) = 0.

    s: the first guess.  tolerance: bound of the misfit.  weight: least weight of the misfit, relative to the field's
    residual, in the norm that the Krylov iteration reduces.  A misfit of one counts at least as much as the residual of
    all nodes: on the wide domain of a very light contact that is large, and the search would ignore the load.  dP_ds:
    the change with s of a P that is given (r = 0 there).
    """

    s: Array | float
    dH_ds: float
    misfit: Callable[[Array, Array], Array]
    tolerance: Array | float
    weight: Array | float
    dP_ds: Array | float = 0.0


NO_BORDER = Border(0.0, 0.0, lambda P, s: s, 1.0, 1.0)


@exportable
class Solution(NamedTuple):
    """An iterate: P and H, both (n, n); the maximum residual in units of the tolerance; the work.

    left: the residual, >= 0 where P is held at zero, elsewhere nearly zero, shape (n, n).  shared: see `NewtonKrylov`.
    history: the maximum residual before the first and after each Newton iteration, shape (newton_limit + 1,), padded
    with NaN.  forcing: the reduction of the next linear residual.
    """

    P: Array
    H: Array
    s: Array
    left: Array
    shared: Any
    residual: Array
    newton: Array
    krylov: Array
    history: Array
    forcing: Array

    @property
    def converged(self) -> Array:
        """Whether every residual is within the tolerance."""
        return self.residual <= 1.0


_Pair = tuple[Array, Array]  # a field and a number
_Change = Callable[[Array, Array], Array]  # of r, from those of P and H


@dataclass(frozen=True)
class NewtonKrylov:
    """The equations with the ways to solve them; a change is one of P and one of s.

    partner_change maps a change of P to the change of H.  preconditioner(P, H, free, shared) returns an approximate
    inverse of the Jacobian on the free nodes.  tolerance bounds |r| at every free node.

    shared: from P, H and what it gave last (None at first) to what the residual, its derivative and the preconditioner
    share there.

    filled: from r where P = 0 (0 elsewhere) to a field that is negative at the nodes which the next iteration frees;
    it may free more nodes than those with r < 0, since the iteration holds them again if P < 0 follows.
    """

    residual: Callable[[Array, Array, Any], Array]
    partner_change: Map
    preconditioner: Callable[[Array, Array, Array, Any], Map]
    tolerance: Array | float
    options: Options = Options()
    border: Border = NO_BORDER
    filled: Map = lambda r: r
    shared: Callable[[Array, Array, Any], Any] = lambda P, H, last: None

    def solve(self, P: Array, H: Array) -> Solution:
        """The solution from the first guess P and the matching H = H(P), both of shape (n, n)."""
        zero = jnp.zeros((), jnp.int32)
        s = jnp.asarray(self.border.s, P.dtype)
        history = jnp.full(self.options.newton_limit + 1, jnp.nan)
        infinite, forcing = (jnp.asarray(value, P.dtype) for value in (jnp.inf, self.options.first_reduction))
        # no residual is needed yet: the first iteration is always done, and begins with it
        first = Solution(P, H, s, jnp.zeros_like(P), self.shared(P, H, None), infinite, zero, zero, history, forcing)
        return jax.lax.while_loop(self.is_unsolved, self.improve, first)

    def size(self, P: Array, s: Array, r: Array) -> Array:
        """The largest residual in units of the tolerance."""
        misfit = jnp.abs(self.border.misfit(P, s)) / self.border.tolerance
        return jnp.maximum(largest_residual(P, r, self.tolerance), misfit)

    def is_unsolved(self, it: Solution) -> Array:
        options = self.options
        return ((it.residual > 1.0) & (it.newton < options.newton_limit)) | (it.newton < options.newton_least)

    def improve(self, it: Solution) -> Solution:
        """One Newton iteration."""
        r, change_of_r = jax.linearize(lambda P, H: self.residual(P, H, it.shared), it.P, it.H)
        (dP, ds), krylov = self.newton_change(it, r, change_of_r)
        # all nodes by the same share: where the few of a spike alone are held back, their neighbours lose their balance
        largest = jnp.maximum(jnp.max(jnp.abs(dP)), jnp.abs(ds) / jnp.maximum(jnp.min(it.H), 1.0))
        share = jnp.minimum(1.0, self.options.largest_change / jnp.maximum(largest, jnp.finfo(dP.dtype).tiny))
        P, s = jnp.maximum(it.P + share * self.change_of_P((dP, ds)), 0.0), it.s + share * ds
        H = it.H + self.change_of_H((P - it.P, s - it.s))
        shared, count = self.shared(P, H, it.shared), it.newton + 1
        left = self.residual(P, H, shared)
        size, reached = self.size(it.P, it.s, r), self.size(P, s, left)
        history = it.history.at[it.newton].set(size).at[count].set(reached)
        forcing = _forcing(self.options, reached / size, reached)
        return Solution(P, H, s, left, shared, reached, count, it.krylov + krylov, history, forcing)

    def change_of_P(self, d: _Pair) -> Array:
        return d[0] + self.border.dP_ds * d[1]

    def change_of_H(self, d: _Pair) -> Array:
        return self.partner_change(d[0]) + self.border.dH_ds * d[1]

    def newton_change(self, it: Solution, r: Array, change_of_r: _Change) -> tuple[_Pair, Array]:
        """The change that solves the linear equations nearly, and the Krylov iterations that it took."""
        early = it.newton < self.options.filling_limit
        free = _free(it.P, jnp.where(early, self.filled(jnp.where(it.P > 0.0, 0.0, r)), r))
        weight = jnp.maximum(self.border.weight, jnp.linalg.norm(free * r))
        misfit, change_of_misfit = jax.linearize(self.border.misfit, it.P, it.s)

        def jacobian(d: _Pair) -> _Pair:
            dP = self.change_of_P(d)
            return free * change_of_r(dP, self.change_of_H(d)), weight * change_of_misfit(dP, d[1])

        inverse = self.preconditioner(it.P, it.H, free, it.shared)
        column = free * change_of_r(jnp.full_like(it.P, self.border.dP_ds), jnp.full_like(it.H, self.border.dH_ds))

        def direction(k: Array, r: _Pair) -> _Pair:
            """Search direction k: first a change of s with the field's response, then changes of the field alone."""
            if self.border is NO_BORDER:
                return inverse(r[0]), r[1]
            return inverse(jnp.where(k == 0, -column, r[0])), jnp.where(k == 0, 1.0, 0.0)

        return gcr(jacobian, direction, (-free * r, -weight * misfit), it.forcing, self.options.krylov_limit)


LOOSEST = 0.1  # weakest reduction by the Krylov iteration, while Newton's iteration converges slowly


def _forcing(options: Options, gain: Array, size: Array) -> Array:
    """Reduction of the next linear residual, limited to what is useful for Newton's iteration and for the tolerance.

    gain: the last reduction factor of the maximum residual.  When Newton's iteration converges, the next factor is
    about its square.  Source: Eisenstat SC, Walker HF. SIAM J Sci Comput 1996;17:16 (choice 2).
    """
    useful = jnp.clip(gain**2, options.krylov_reduction, LOOSEST)
    return jnp.maximum(useful, jnp.minimum(0.3 / size, 0.3))


def largest_residual(P: Array, r: Array, tolerance: Array | float) -> Array:
    """The largest residual r of the nodes where the equation holds, in units of its tolerance."""
    return jnp.max(jnp.abs(_free(P, r) * r) / tolerance)


def _free(P: Array, r: Array) -> Array:
    """1 where the equation holds, 0 where P is held at zero."""
    return jnp.where((P > 0.0) | ~(r >= 0.0), 1.0, 0.0)  # free also where r is NaN, so that the NaN is not hidden


# -- linear systems ---------------------------------------------------------------------------------------------------

_Search = tuple[Any, Any, Any, Any, Array]  # x, r; z and apply(z) of the iterations so far; their number


def gcr(
    apply: Callable[[Any], Any], direction: Callable[[Array, Any], Any], b: Any, reduction: Array | float, limit: int
) -> tuple[Any, Array]:
    """Solve apply(x) = b until |r| <= reduction |b|, in at most `limit` iterations; return x and the iteration count.

    b is an array or a tuple of arrays, real or complex.  direction(k, r) returns the k-th search direction from the
    residual r; it applies the preconditioner.

    The method is generalised conjugate residuals (Eisenstat, Elman, Schultz, SIAM J Numer Anal 1983;20:345).  It has
    the same iterates as flexible GMRES and keeps the residual, so the preconditioner may have lower precision.
    """
    # z and apply(z) of the iterations so far, the latter orthonormal; only the first k are used
    zs = ws = tree.map(lambda part: jnp.zeros((limit, *part.shape), part.dtype), b)
    goal = reduction * _norm(b)

    def go_on(state: _Search) -> Array:
        _, r, _, _, k = state
        return (_norm(r) > goal) & (k < limit)

    def improve(state: _Search) -> _Search:
        x, r, zs, ws, k = state
        z = direction(k, r)

        def orthogonalise(j: Array, zw: tuple[Any, Any]) -> tuple[Any, Any]:
            z, w = zw
            zj, wj = (tree.map(lambda part: part[j], past) for past in (zs, ws))
            overlap = _dot(wj, w)
            return _add(z, -overlap, zj), _add(w, -overlap, wj)

        z, w = jax.lax.fori_loop(0, k, orthogonalise, (z, apply(z)))
        size = _norm(w)
        size = jnp.where(size > 0.0, size, 1.0)  # zero where no node is free: nothing can change
        z, w = (tree.map(lambda part: part / size, v) for v in (z, w))
        step = _dot(w, r)
        zs, ws = (tree.map(lambda past, part: past.at[k].set(part), vs, v) for vs, v in ((zs, z), (ws, w)))
        return _add(x, step, z), _add(r, -step, w), zs, ws, k + 1

    x = tree.map(jnp.zeros_like, b)
    x, _, _, _, k = jax.lax.while_loop(go_on, improve, (x, b, zs, ws, jnp.zeros((), jnp.int32)))
    return x, k


def _dot(a: Any, b: Any) -> Array:
    return sum(tree.leaves(tree.map(jnp.vdot, a, b)), jnp.zeros(()))


def _norm(a: Any) -> Array:
    return jnp.sqrt(_dot(a, a).real)


def _add(a: Any, share: Array, b: Any) -> Any:
    return tree.map(lambda x, y: x + share * y, a, b)
