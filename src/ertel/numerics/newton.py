"""Newton-Krylov iteration with an active set, for a field P >= 0 and a field H that is affine in P.

    r(P, H) = 0 where P > 0,   r(P, H) >= 0 where P = 0,   H = H(P) affine

The Jacobian is exact (automatic differentiation of r).  The affine part is given as a separate linear map, because it
is expensive (a convolution): each Newton iteration and each Krylov iteration needs it once, not counting the
preconditioner.

H may depend on one more unknown, a number with a linear equation of its own (such as a given load): see `Border`.

Of P a part C may depend on H alone, see `Part`.  Then r has the rest Q = P - C(H) in place of P:

    r(Q, H) = 0 where Q > 0,   r(Q, H) >= 0 where Q = 0,   P = Q + C(H),   H = H(P) affine

The linear systems are solved by generalised conjugate residuals with a preconditioner, `gcr`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

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


class Tangent(NamedTuple):
    """A straight line in place of C(H): its value at the H that is there, and its fall - dC/dH >= 0."""

    value: Array
    stiffness: Array


class Part(Protocol):
    """A part C of P that falls with H, above zero."""

    def pressure(self, H: Array) -> Array:
        """C(H)."""

    def tangent(self, P: Array, H: Array) -> Tangent:
        """The tangent of C, or one that is less steep where C(H) is far above P."""

    def held(self, P: Array, H: Array, free: Array) -> Array:
        """The weight of the equation P = C where P may change but no node is free, zero elsewhere."""


class Inverse(NamedTuple):
    """An approximate inverse of the Jacobian, and the weight of the rows of r: 1, unless P has a part C(H)."""

    of: Map
    weight: Array | float = 1.0


NO_BORDER = Border(0.0, 0.0, lambda P, s: s, 1.0, 1.0)


@exportable
class Solution(NamedTuple):
    """An iterate: P and H, both (n, n); the maximum residual in units of the tolerance; the work.

    Q: P without its part C(H), None where P has none.  left: the residual, >= 0 where P (or Q) is held at zero,
    elsewhere nearly zero, shape (n, n).  shared: see `NewtonKrylov`.  history: the maximum residual before the first
    and after each Newton iteration, shape (newton_limit + 1,), padded with NaN.  forcing: the reduction of the next
    linear residual.
    """

    P: Array
    Q: Array | None
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
    def own(self) -> Array:
        """P, or Q where P has a part C(H)."""
        return self.P if self.Q is None else self.Q

    @property
    def converged(self) -> Array:
        """Whether every residual is within the tolerance."""
        return self.residual <= 1.0


_Pair = tuple[Array, Array]  # a field and a number
_Change = Callable[[Array, Array], Array]  # of r, from those of P and H


@dataclass(frozen=True)
class NewtonKrylov:
    """The equations with the ways to solve them; a change is one of P and one of s.

    partner_change maps a change of P to the change of H.  preconditioner(Q, H, free, P, shared) returns an approximate
    inverse of the Jacobian; Q is P itself and P None without a part C.  tolerance bounds |r| at every free node.

    shared: from P, H and what it gave last (None at first) to what the residual, its derivative and the preconditioner
    share there.  All of these take Q in place of P where P has a part C(H).

    filled: from r where P = 0 (0 elsewhere) to a field that is negative at the nodes which the next iteration frees;
    it may free more nodes than those with r < 0, since the iteration holds them again if P < 0 follows.
    """

    residual: Callable[[Array, Array, Any], Array]
    partner_change: Map
    preconditioner: Callable[[Array, Array, Array, Array | None, Any], Inverse]
    tolerance: Array | float
    options: Options = Options()
    border: Border = NO_BORDER
    filled: Map = lambda r: r
    shared: Callable[[Array, Array, Any], Any] = lambda P, H, last: None
    part: Part | None = None

    def solve(self, P: Array, H: Array, Q: Array | None = None) -> Solution:
        """The solution from the first guess P and the matching H = H(P), both of shape (n, n); Q with a part C(H)."""
        zero = jnp.zeros((), jnp.int32)
        s = jnp.asarray(self.border.s, P.dtype)
        history = jnp.full(self.options.newton_limit + 1, jnp.nan)
        infinite, forcing = (jnp.asarray(value, P.dtype) for value in (jnp.inf, self.options.first_reduction))
        # no residual is needed yet: the first iteration is always done, and begins with it
        shared = self.shared(P if Q is None else Q, H, None)
        first = Solution(P, Q, H, s, jnp.zeros_like(P), shared, infinite, zero, zero, history, forcing)
        return jax.lax.while_loop(self.is_unsolved, self.improve, first)

    def size(self, it: Solution, r: Array) -> Array:
        """The largest residual in units of the tolerance."""
        misfit = jnp.abs(self.border.misfit(it.P, it.s)) / self.border.tolerance
        size = jnp.maximum(largest_residual(it.own, r, self.tolerance), misfit)
        if self.part is None:
            return size
        unbalanced = it.P - it.own - self.part.tangent(it.P, it.H).value
        unbalanced *= self.part.held(it.P, it.H, _free(it.own, r))
        return jnp.maximum(size, jnp.max(jnp.abs(unbalanced) / self.tolerance))

    def is_unsolved(self, it: Solution) -> Array:
        options = self.options
        return ((it.residual > 1.0) & (it.newton < options.newton_limit)) | (it.newton < options.newton_least)

    def improve(self, it: Solution) -> Solution:
        """One Newton iteration."""
        r, change_of_r = jax.linearize(lambda P, H: self.residual(P, H, it.shared), it.own, it.H)
        (dP, ds), free, krylov = self.newton_change(it, r, change_of_r)
        # all nodes by the same share: where the few of a spike alone are held back, their neighbours lose their balance
        largest = jnp.maximum(jnp.max(jnp.abs(dP)), jnp.abs(ds) / jnp.maximum(jnp.min(it.H), 1.0))
        share = jnp.minimum(1.0, self.options.largest_change / jnp.maximum(largest, jnp.finfo(dP.dtype).tiny))
        P, s = jnp.maximum(it.P + share * self.change_of_P((dP, ds)), 0.0), it.s + share * ds
        H = it.H + self.change_of_H((P - it.P, s - it.s))
        Q = None
        if self.part is not None:
            # along the curve C itself, which Newton's iteration then need not follow; on an edge Q is what P leaves
            held = self.part.held(it.P, it.H, free) > 0.0
            Q = jnp.where(held, 0.0, jnp.maximum(P - self.part.pressure(H), 0.0))
        own, count = P if Q is None else Q, it.newton + 1
        shared = self.shared(own, H, it.shared)
        left = self.residual(own, H, shared)
        new = it._replace(P=P, Q=Q, H=H, s=s, left=left, shared=shared, newton=count, krylov=it.krylov + krylov)
        size, reached = self.size(it, r), self.size(new, left)
        history = it.history.at[it.newton].set(size).at[count].set(reached)
        if self.part is not None:
            stays = (count > LATE) & (reached < ROUND_OFF) & (reached > 0.5 * size)
            reached = jnp.where(stays, jnp.minimum(reached, 1.0), reached)
        return new._replace(residual=reached, history=history, forcing=_forcing(self.options, reached / size, reached))

    def change_of_P(self, d: _Pair) -> Array:
        return d[0] + self.border.dP_ds * d[1]

    def change_of_H(self, d: _Pair) -> Array:
        return self.partner_change(d[0]) + self.border.dH_ds * d[1]

    def newton_change(self, it: Solution, r: Array, change_of_r: _Change) -> tuple[_Pair, Array, Array]:
        """The change that solves the linear equations nearly, the free nodes, and the Krylov iterations for it."""
        early = it.newton < self.options.filling_limit
        free = _free(it.own, jnp.where(early, self.filled(jnp.where(it.own > 0.0, 0.0, r)), r))
        line = None if self.part is None else self.part.tangent(it.P, it.H)
        inverse = self.preconditioner(it.own, it.H, free, None if line is None else it.P, it.shared)
        rows, b = self.rows(it, r, change_of_r, free, line, inverse)
        weight = jnp.maximum(self.border.weight, jnp.linalg.norm(b))
        misfit, change_of_misfit = jax.linearize(self.border.misfit, it.P, it.s)

        def jacobian(d: _Pair) -> _Pair:
            dP = self.change_of_P(d)
            return rows(dP, self.change_of_H(d)), weight * change_of_misfit(dP, d[1])

        column = rows(jnp.full_like(it.P, self.border.dP_ds), jnp.full_like(it.H, self.border.dH_ds))

        def direction(k: Array, r: _Pair) -> _Pair:
            """Search direction k: first a change of s with the field's response, then changes of the field alone."""
            if self.border is NO_BORDER:
                return inverse.of(r[0]), r[1]
            return inverse.of(jnp.where(k == 0, -column, r[0])), jnp.where(k == 0, 1.0, 0.0)

        # with a part C(H) the misfit outweighs the rows, and the first change alone, of s, would seem to be enough
        least = 0 if self.part is None else 2
        change, krylov = gcr(jacobian, direction, (b, -weight * misfit), it.forcing, self.options.krylov_limit, least)
        return change, free, krylov

    def rows(
        self, it: Solution, r: Array, change_of_r: _Change, free: Array, line: Tangent | None, inverse: Inverse
    ) -> tuple[_Change, Array]:
        """The linear equations as a map of the changes of P and H, and their right-hand side."""
        if self.part is None or line is None:
            return lambda dP, dH: free * change_of_r(dP, dH), -free * r
        held = self.part.held(it.P, it.H, free)

        def rows(dQ: Array, dH: Array) -> Array:
            return inverse.weight * free * change_of_r(free * dQ, dH) + held * dQ

        rest = it.P - it.own - line.value
        b = -inverse.weight * free * r - rows(rest, jnp.zeros_like(rest))
        return lambda dP, dH: rows(dP + line.stiffness * dH, dH), b


# with a part C(H): a residual of fewer tolerances that does not fall any more, after so many iterations, is round-off
ROUND_OFF, LATE = 10.0, 5
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
    apply: Callable[[Any], Any],
    direction: Callable[[Array, Any], Any],
    b: Any,
    reduction: Array | float,
    limit: int,
    least: int = 0,
) -> tuple[Any, Array]:
    """Solve apply(x) = b until |r| <= reduction |b|, in at most `limit` iterations; return x and the iteration count.

    It makes `least` iterations in any case.

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
        unsolved = _norm(r) > goal
        return (unsolved | (k < least) if least else unsolved) & (k < limit)

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
