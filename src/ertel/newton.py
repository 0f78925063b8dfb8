"""Newton-Krylov for a field P >= 0 whose partner H depends on it linearly, with an active set.

    r(P, H) = 0 where P > 0,   r(P, H) >= 0 where P = 0,   H = H(P) affine

The Jacobian is exact (automatic differentiation of r); the affine part is given as its own linear map, because it is
the expensive one (in elastohydrodynamics a convolution): each Newton iteration needs it once, each Krylov iteration
once more besides what the preconditioner does.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

Map = Callable[[Array], Array]


@dataclass(frozen=True)
class Options:
    """Limits of the iteration; `largest_change` bounds the change of P in one Newton iteration."""

    newton_limit: int = 40  # few are needed, but a free boundary may have many nodes to advance, one at a time
    krylov_limit: int = 16
    krylov_reduction: float = 1e-2
    largest_change: float = 0.3


class Solution(NamedTuple):
    """P and H, both (n, n); the largest residual in units of the tolerance; whether it met it; the work done."""

    P: Array
    H: Array
    residual: Array
    converged: Array
    newton: Array
    krylov: Array


_Search = tuple[Array, Array, Array, Array, Array]  # x, r, z and apply(z) of the iterations so far, their number


class _Iterate(NamedTuple):
    P: Array
    H: Array
    size: Array
    newton: Array
    krylov: Array


def solve(
    residual: Callable[[Array, Array], Array],
    partner_change: Map,
    preconditioner: Callable[[Array, Array, Array], Map],
    P: Array,
    H: Array,
    tolerance: Array | float,
    options: Options = Options(),
) -> Solution:
    """Solve from the first guess P with its partner H = H(P), both of shape (n, n).

    partner_change maps a change of P to that of H.  preconditioner(P, H, free) returns an approximate inverse of the
    Jacobian on the free nodes.  tolerance bounds |r| at every free node; one iteration is done in any case, because a
    prediction within the tolerance would let its error pile up from solve to solve.
    """
    tiny = jnp.finfo(P.dtype).tiny

    def size(P: Array, H: Array) -> Array:
        r = residual(P, H)
        return jnp.max(jnp.abs(_free(P, r) * r) / tolerance)

    def go_on(it: _Iterate) -> Array:
        return ((it.size > 1.0) & (it.newton < options.newton_limit)) | (it.newton == 0)

    def improve(it: _Iterate) -> _Iterate:
        r, change_of_r = jax.linearize(residual, it.P, it.H)
        free = _free(it.P, r)

        def jacobian(d: Array) -> Array:
            return free * change_of_r(d, partner_change(d))

        # later iterations often only move a free boundary: they need not be solved far beyond the tolerance
        enough = jnp.clip(0.3 / it.size, options.krylov_reduction, 0.3)
        d, krylov = gcr(
            jacobian,
            preconditioner(it.P, it.H, free),
            -free * r,
            jnp.where(it.newton == 0, options.krylov_reduction, enough),
            options.krylov_limit,
        )
        share = jnp.minimum(1.0, options.largest_change / jnp.maximum(jnp.max(jnp.abs(d)), tiny))
        P_new = jnp.maximum(it.P + share * d, 0.0)
        H_new = it.H + partner_change(P_new - it.P)
        return _Iterate(P_new, H_new, size(P_new, H_new), it.newton + 1, it.krylov + krylov)

    zero = jnp.zeros((), jnp.int32)
    first = _Iterate(P, H, size(P, H), zero, zero)
    last = jax.lax.while_loop(go_on, improve, first)
    return Solution(last.P, last.H, last.size, last.size <= 1.0, last.newton, last.krylov)


def _free(P: Array, r: Array) -> Array:
    """1 where the equation holds, 0 where P is held at zero."""
    return jnp.where((P > 0.0) | ~(r >= 0.0), 1.0, 0.0)  # free too where r is not a number, so that it shows


def gcr(apply: Map, precondition: Map, b: Array, reduction: Array | float, limit: int) -> tuple[Array, Array]:
    """Solve apply(x) = b until |r| <= reduction |b|, at most `limit` iterations; returns x and their number.

    Generalised conjugate residuals (Eisenstat, Elman, Schultz, SIAM J Numer Anal 1983;20:345): the same iterates as
    flexible GMRES, with the residual at hand, so that the preconditioner may be of lower precision.
    """
    # z and apply(z) of the iterations so far, the latter orthonormal; only the first k are ever touched
    zs = ws = jnp.zeros((limit, *b.shape), b.dtype)
    goal = reduction * jnp.linalg.norm(b)

    def go_on(state: _Search) -> Array:
        _, r, _, _, k = state
        return (jnp.linalg.norm(r) > goal) & (k < limit)

    def improve(state: _Search) -> _Search:
        x, r, zs, ws, k = state
        z = precondition(r)

        def orthogonalise(j: Array, zw: tuple[Array, Array]) -> tuple[Array, Array]:
            z, w = zw
            overlap = jnp.vdot(ws[j], w)
            return z - overlap * zs[j], w - overlap * ws[j]

        z, w = jax.lax.fori_loop(0, k, orthogonalise, (z, apply(z)))
        size = jnp.linalg.norm(w)
        z, w = z / size, w / size
        step = jnp.vdot(w, r)
        return x + step * z, r - step * w, zs.at[k].set(z), ws.at[k].set(w), k + 1

    x, _, _, _, k = jax.lax.while_loop(go_on, improve, (jnp.zeros_like(b), b, zs, ws, jnp.zeros((), jnp.int32)))
    return x, k
