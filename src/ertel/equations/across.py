"""Integrals of an oil's fluidity across the film, with the linear stress tau = t + zeta g, zeta from -1/2 to 1/2.

They are sums over Gauss nodes, or exact integrals of a series for phi where the oil hardly thins.  t and g have the
shape (2, ...): along X and along Y, then the shape of the fields.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ertel.physics.fluidity import Fluidity

SPREAD = 10.0  # growth of ln(phi) towards a wall over half the film at which the nodes begin to move to the walls
PLAIN = 1e-3  # a spread that stands for none
# largest error of a series of phi that replaces the law (of its slope by ln |tau|: twenty times that), largest phi - 1
SERIES_ERROR, SERIES_END = 1e-9, 1e-2
NO_STRESS = 1e-60  # Pa

Tensor = tuple[Array, Array, Array]  # symmetric: xx, xy, yy
TINY = 1e-150  # length of a vector that stands for zero
Nodes = tuple[Array, Array]  # zeta > 0 and weight of each pair, shape (NODES/2, ...)


def gauss_nodes(law: Fluidity, across: int, pressure: Array, stress: Array, gradient: Array) -> Nodes:
    """Gauss nodes for the middle stress and gradient, near the walls where the fluidity grows steeply there.

    zeta = asinh(z sinh c)/(2 c) with Gauss nodes z in (-1, 1), which are those for c = 0.  c grows with the rate of
    growth of ln(phi) at the wall with the larger stress.
    """
    wall = stress + jnp.where(dot(stress, gradient) >= 0.0, 0.5, -0.5) * gradient
    phi, slope = with_slope(law, pressure, length(wall))
    growth = slope / phi * jnp.abs(dot(wall, gradient)) / 2.0
    c = jnp.maximum(growth / SPREAD, PLAIN)[None]
    z, w = gauss(across, pressure.ndim)
    stretch = jnp.sinh(c)
    moved = z * stretch
    root = jnp.sqrt(1.0 + moved**2)
    return jnp.log(moved + root) / (2.0 * c), w * stretch / (2.0 * c * root)  # asinh, in half the time


def gauss(across: int, ndim: int) -> tuple[Any, Any]:
    """Gauss nodes in (0, 1) and weights, for fields of so many dimensions."""
    z, weight = (both[across // 2 :].reshape(-1, *[1] * ndim) for both in np.polynomial.legendre.leggauss(across))
    return z, weight


def with_slope(law: Fluidity, pressure: Array, size: Array) -> tuple[Array, Array]:
    """phi and phi'/|tau| at |tau|."""
    phi, slope = jax.jvp(lambda x: law.fluidity(x, pressure), (size,), (jnp.ones_like(size),))
    return phi, slope / size


def both_sides(law: Fluidity, pressure: Array, t: Array, g: Array, zeta: Array) -> tuple[Array, Array]:
    """phi and phi'/|tau| at + zeta and at - zeta, each of shape (2, NODES/2, ...)."""
    mean, along = square(t) + zeta**2 * square(g), 2.0 * zeta * dot(t, g)
    size = jnp.sqrt(jnp.maximum(jnp.stack([mean + along, mean - along]), TINY**2))
    return with_slope(law, pressure, size)


class Moments(NamedTuple):
    """The sums over the nodes with phi (s0, s1, s2), and A, C, D."""

    s0: Array
    s1: Array
    s2: Array
    A: Tensor
    C: Tensor
    D: Tensor


def moments_by_nodes(law: Fluidity, pressure: Array, t: Array, g: Array, nodes: Nodes) -> Moments:
    """The sums over the Gauss nodes."""
    zeta, weight = nodes
    phi, slope = both_sides(law, pressure, t, g, zeta)
    weights = [weight, weight * zeta, weight * zeta**2, weight * zeta**3, weight * zeta**4]
    s = [_paired(w, phi, k) for k, w in enumerate(weights[:3])]
    return _assembled(s, [_paired(w, slope, k) for k, w in enumerate(weights)], t, g)


def _assembled(s: Sequence[Array], r: Sequence[Array], t: Array, g: Array) -> Moments:
    """From the sums with phi and with phi'/|tau|, by the power of zeta."""
    A, C, D = (_tensor(s[k], r[k], r[k + 1], r[k + 2], t, g) for k in range(3))
    return Moments(s[0], s[1], s[2], A, C, D)


def sliding_moments(law: Fluidity, pressure: Array, t: Array, g: Array, nodes: Nodes) -> tuple[Array, Array, Tensor]:
    """The moments that the sliding needs: s0, s1 and A."""
    zeta, weight = nodes
    phi, slope = both_sides(law, pressure, t, g, zeta)
    weights = [weight, weight * zeta, weight * zeta**2]
    s0, s1 = (_paired(w, phi, k) for k, w in enumerate(weights[:2]))
    r0, r1, r2 = (_paired(w, slope, k) for k, w in enumerate(weights))
    return s0, s1, _tensor(s0, r0, r1, r2, t, g)


def _paired(weight: Array, values: Array, power: int) -> Array:
    """The sum over the nodes of weight * values, odd in zeta if the power is."""
    both = values[0] - values[1] if power % 2 else values[0] + values[1]
    return jnp.sum(weight * both, axis=0)


def _tensor(s: Array, r0: Array, r1: Array, r2: Array, t: Array, g: Array) -> Tensor:
    """Integral of zeta^k (phi + tau tau phi'/|tau|) with tau = t + zeta g."""
    xx = s + (r0 * t[0] ** 2 + 2.0 * r1 * t[0] * g[0] + r2 * g[0] ** 2)
    yy = s + (r0 * t[1] ** 2 + 2.0 * r1 * t[1] * g[1] + r2 * g[1] ** 2)
    return xx, r0 * t[0] * t[1] + r1 * (t[0] * g[1] + t[1] * g[0]) + r2 * g[0] * g[1], yy


# -- where the oil hardly thins ---------------------------------------------------------------------------------------


class Series(NamedTuple):
    """phi = 1 + first |tau|^2 + second |tau|^4, and where it is as good as the law."""

    first: Array
    second: Array
    holds: Array


def series_of(law: Fluidity, pressure: Array, stress: Array, gradient: Array) -> Series:
    """The series through phi at the largest stress T that there can be, and at T/sqrt(2); it is checked at T/2."""
    T = jax.lax.stop_gradient(jnp.maximum(length(stress) + 0.5 * length(gradient), NO_STRESS))  # without influence
    end, middle, check = (law.fluidity(T * share**0.5, pressure) - 1.0 for share in (1.0, 0.5, 0.25))
    second = 2.0 * end - 4.0 * middle
    first = end - second
    holds = (jnp.abs(first / 4.0 + second / 16.0 - check) <= SERIES_ERROR) & (end <= SERIES_END)
    return Series(first / T**2, second / T**4, holds)


def series_moments(series: Series, t: Array, g: Array) -> Moments:
    """The same integrals as `moments_by_nodes`, exact."""
    a, b, c, (first, second, _) = square(t), dot(t, g), square(g), series  # |tau|^2 = a + 2 b zeta + c zeta^2
    phi = (
        1.0 + a * (first + second * a),
        2.0 * b * (first + 2.0 * second * a),
        first * c + second * (2.0 * a * c + 4.0 * b**2),
        4.0 * second * b * c,
        second * c**2,
    )
    slope = 2.0 * first + 4.0 * second * a, 8.0 * second * b, 4.0 * second * c

    def integral(of: tuple[Array, ...], k: int) -> Array:
        """The integral of zeta^k times a polynomial."""
        return sum(
            (part / ((j + k + 1) * 2 ** (j + k)) for j, part in enumerate(of) if (j + k) % 2 == 0), jnp.zeros(())
        )

    return _assembled([integral(phi, k) for k in range(3)], [integral(slope, k) for k in range(5)], t, g)


# -- vectors, of shape (2, ...): along X and along Y -------------------------------------------------------------------


def dot(a: Array, b: Array) -> Array:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1]


def square(a: Array) -> Array:
    """The square of the length."""
    return dot(a, a)


def length(a: Array) -> Array:
    """The length, at least `TINY`, so that it can divide."""
    return jnp.sqrt(jnp.maximum(square(a), TINY**2))
