"""Cyclic reduction for many tridiagonal systems at once, factorised once and solved often.

Every second unknown is eliminated, then every second of the rest, and so on, as on the grids of multigrid; here the
coarse problem is exact.  The unknowns of one level are independent, unlike those in elimination along the line.  Rows
are not exchanged, so the diagonal must not be small compared with the rest of its row.

Source: Hockney RW. A fast direct solution of Poisson's equation using Fourier analysis. J ACM 1965;12:95.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from ertel.numerics.multigrid import interleave

SHORT = 33  # nodes per line; elimination is as fast for lines up to this length


class Rows(NamedTuple):
    """Rows of matrices with unit diagonal: the coefficients of the two neighbours, each of shape (lines, n)."""

    lower: Array
    upper: Array


class Halving(NamedTuple):
    """The rows of the odd and the even nodes, and the scale factors of the even rows after the odd are eliminated."""

    odd: Rows
    even: Rows
    scale: Array


class Factors(NamedTuple):
    """The scale factors of the rows, the halvings (longest lines first), and the remaining rows."""

    scale: Array
    halvings: tuple[Halving, ...]
    rest: Rows


def factorise(lower: Array, diagonal: Array, upper: Array) -> Factors:
    """Factors of the matrices with these bands, (lines, n): coefficients of unknowns i - 1, i and i + 1 in row i.

    Lines are halved while their number of nodes is odd and above SHORT.
    """
    rows, halvings = Rows(lower / diagonal, upper / diagonal), []
    while (n := rows.lower.shape[1]) > SHORT and n % 2:
        halving, rows = _halve(rows)
        halvings.append(halving)
    return Factors(1.0 / diagonal, tuple(halvings), rows)


def solve_lines(factors: Factors, b: Array) -> Array:
    """The solutions for right-hand sides b of shape (lines, n)."""
    return _solve(factors.halvings, factors.rest, factors.scale * b)


def _solve(halvings: Sequence[Halving], rest: Rows, b: Array) -> Array:
    if not halvings:
        return jax.lax.linalg.tridiagonal_solve(rest.lower, jnp.ones_like(b), rest.upper, b[..., None])[..., 0]
    (odd, even, scale), *shorter = halvings
    left_out = b[:, 1::2]
    x = _solve(shorter, rest, scale * (b[:, ::2] - even.lower * _before(left_out) - even.upper * _after(left_out)))
    between = left_out - odd.lower * x[:, :-1] - odd.upper * x[:, 1:]
    return interleave(x.T, between.T).T


def _halve(rows: Rows) -> tuple[Halving, Rows]:
    """The halving, and the rows of the even nodes after elimination of the odd nodes."""
    odd, even = (Rows(*(part[:, first::2] for part in rows)) for first in (1, 0))
    diagonal = 1.0 - even.lower * _before(odd.upper) - even.upper * _after(odd.lower)
    lower, upper = -even.lower * _before(odd.lower), -even.upper * _after(odd.upper)
    return Halving(odd, even, 1.0 / diagonal), Rows(lower / diagonal, upper / diagonal)


def _before(odd: Array) -> Array:
    """At each even node, the value at the odd node before it; zero at the first."""
    return jnp.pad(odd, ((0, 0), (1, 0)))


def _after(odd: Array) -> Array:
    return jnp.pad(odd, ((0, 0), (0, 1)))


def diagonals(change: Callable[[Array], Array], n: int) -> Array:
    """The three diagonals (3, n) of a linear map whose matrix has no others: entries (i, i - 1), (i, i) and (i, i + 1).

    Every third column is looked at together.
    """
    i, shift = jnp.arange(n), jnp.arange(-1, 2)[:, None]
    answers = jax.vmap(change)(jnp.where(i % 3 == jnp.arange(3)[:, None], 1.0, 0.0))
    found: Array = answers[(i + shift) % 3, i]
    return found


def banded_product(diagonals: Array, matrix: Array) -> Array:
    """The matrix of three diagonals times another one."""
    lower, middle, upper = diagonals[:, :, None]
    product: Array = lower * jnp.roll(matrix, 1, axis=0) + middle * matrix + upper * jnp.roll(matrix, -1, axis=0)
    return product
