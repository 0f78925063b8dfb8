"""Solution of linear systems by generalised conjugate residuals with a preconditioner."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, tree

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
