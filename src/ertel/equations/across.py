"""Integrals of an oil's fluidity across the film, with the linear stress tau = t + zeta g, zeta from -1/2 to 1/2.

They are sums over Gauss nodes, or exact integrals of a series for phi where the oil hardly thins.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.tree_util import register_dataclass

from ertel.physics.fluidity import Fluidity

SPREAD = 10.0  # growth of ln(phi) towards a wall over half the film at which the nodes begin to move to the walls
PLAIN = 1e-3  # a spread that stands for none
# largest error of a series of phi that replaces the law (of its slope by ln |tau|: twenty times that), largest phi - 1
SERIES_ERROR, SERIES_END = 1e-9, 1e-2
NO_STRESS = 1e-60  # Pa

Tensor = tuple[Array, Array, Array]  # symmetric: xx, xy, yy
OF_POWERS = 1.0, 0.0, 1.0 / 12.0, 0.0, 1.0 / 80.0  # integrals of zeta^k, k = 0 to 4
TINY = 1e-150  # length of a vector that stands for zero
Nodes = tuple[Array, Array]  # zeta > 0 and weight of each pair, shape (NODES/2, ...)


# -- vectors -----------------------------------------------------------------------------------------------------------


@register_dataclass
@dataclass(frozen=True)
class Vector:
    """Its components along X and along Y, two arrays.  One array for both would be taken apart in every product."""

    x: Array
    y: Array

    def __add__(self, other: "Vector") -> "Vector":
        return Vector(self.x + other.x, self.y + other.y)

    def __sub__(self, other: "Vector") -> "Vector":
        return Vector(self.x - other.x, self.y - other.y)

    def __mul__(self, factor: Any) -> "Vector":
        return Vector(factor * self.x, factor * self.y)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Array) -> "Vector":
        return Vector(self.x / divisor, self.y / divisor)


def dot(a: Vector, b: Vector) -> Array:
    """The scalar product."""
    return a.x * b.x + a.y * b.y


def square(a: Vector) -> Array:
    """The square of the length."""
    return dot(a, a)


def length(a: Vector) -> Array:
    """The length, at least `TINY`, so that it can divide."""
    return jnp.sqrt(jnp.maximum(square(a), TINY**2))


def dyad(a: Vector, b: Vector) -> Tensor:
    """The symmetric part of the product a b."""
    return a.x * b.x, 0.5 * (a.x * b.y + a.y * b.x), a.y * b.y


# -- sums over nodes ---------------------------------------------------------------------------------------------------


def gauss_nodes(law: Fluidity, across: int, pressure: Array, stress: Vector, gradient: Vector) -> Nodes:
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


def _sizes(t: Vector, g: Vector, zeta: Array) -> Array:
    """|tau| at + zeta and at - zeta, shape (2, NODES/2, ...)."""
    mean, along = square(t) + zeta**2 * square(g), 2.0 * zeta * dot(t, g)
    return jnp.sqrt(jnp.maximum(jnp.stack([mean + along, mean - along]), TINY**2))


class Moments(NamedTuple):
    """The sums S_0, S_1, S_2 of zeta^k phi, and A, C, D."""

    s: Sequence[Array]
    A: Tensor
    C: Tensor
    D: Tensor


def sums_by_nodes(law: Fluidity, pressure: Array, t: Vector, g: Vector, nodes: Nodes) -> Sequence[Array]:
    """S_0, S_1 and S_2 over the Gauss nodes."""
    return _sums(nodes, law.fluidity(_sizes(t, g, nodes[0]), pressure), range(3))


def moments_by_nodes(law: Fluidity, pressure: Array, t: Vector, g: Vector, nodes: Nodes) -> Moments:
    """The sums over the Gauss nodes."""
    phi, slope = with_slope(law, pressure, _sizes(t, g, nodes[0]))
    return assembled(_sums(nodes, phi, range(3)), _sums(nodes, slope, range(5)), t, g)


def _sums(nodes: Nodes, values: Array, powers: Sequence[int]) -> Sequence[Array]:
    """The integrals of zeta^k times the values on both sides."""
    zeta, weight = nodes
    both = values[0] + values[1], values[0] - values[1]
    return [jnp.sum(weight * zeta**k * both[k % 2], axis=0) for k in powers]


def assembled(s: Sequence[Array], r: Sequence[Array], t: Vector, g: Vector) -> Moments:
    """From the sums with phi and with phi'/|tau|, by the power of zeta."""
    products = _products(t, g)
    return Moments(s, *(_tensor(s[k], r[k : k + 3], products) for k in range(3)))


def _tensor(s: Array, r: Sequence[Array], products: Sequence[Tensor]) -> Tensor:
    """Integral of zeta^k (phi + tau tau phi'/|tau|): s of zeta^k phi, r of zeta^(k + 0, 1, 2) phi'/|tau|."""
    xx, xy, yy = (
        sum((a * b for a, b in zip(r, parts, strict=True)), jnp.zeros(())) for parts in zip(*products, strict=True)
    )
    return s + xx, xy, s + yy


def _products(t: Vector, g: Vector) -> Sequence[Tensor]:
    """tau tau with tau = t + zeta g, by the power of zeta."""
    return dyad(t, t), dyad(t, 2.0 * g), dyad(g, g)


# -- where the oil hardly thins ---------------------------------------------------------------------------------------


class Series(NamedTuple):
    """phi = 1 + first |tau|^2 + second |tau|^4, and where it is as good as the law."""

    first: Array
    second: Array
    holds: Array


def series_of(law: Fluidity, pressure: Array, stress: Vector, gradient: Vector) -> Series:
    """The series through phi at the largest stress T that there can be, and at T/sqrt(2); it is checked at T/2."""
    T = jax.lax.stop_gradient(jnp.maximum(length(stress) + 0.5 * length(gradient), NO_STRESS))  # without influence
    end, middle, check = law.fluidity(jnp.stack([T, 0.5**0.5 * T, 0.5 * T]), pressure) - 1.0
    second = 2.0 * end - 4.0 * middle
    first = end - second
    holds = (jnp.abs(first / 4.0 + second / 16.0 - check) <= SERIES_ERROR) & (end <= SERIES_END)
    return Series(first / T**2, second / T**4, holds)


def integrals_of_stress(t: Vector, g: Vector) -> Sequence[Sequence[Array | float]]:
    """The integrals of zeta^k |tau|^j: for j = 0 and 2 with k = 0 to 4, for j = 4 with k = 0 to 2."""
    a, b, c = square(t), dot(t, g), square(g)  # |tau|^2 = a + 2 b zeta + c zeta^2
    middle = 4.0 * b**2 + 2.0 * a * c  # |tau|^4 = a^2 + 4 a b zeta + middle zeta^2 + 4 b c zeta^3 + c^2 zeta^4
    squares = a + c / 12.0, b / 6.0, a / 12.0 + c / 80.0, b / 40.0, a / 80.0 + c / 448.0
    fourths = (
        a**2 + middle / 12.0 + c**2 / 80.0,
        a * b / 3.0 + b * c / 20.0,
        a**2 / 12.0 + middle / 80.0 + c**2 / 448.0,
    )
    return OF_POWERS, squares, fourths


def series_sums(series: Series, of_stress: Sequence[Sequence[Array | float]]) -> Sequence[Array]:
    """The integrals of zeta^k (phi - 1), k = 0 to 2, from those of the stress."""
    _, squares, fourths = of_stress
    return [series.first * square + series.second * fourth for square, fourth in zip(squares, fourths, strict=False)]


def series_moments(series: Series, of_stress: Sequence[Sequence[Array | float]], t: Vector, g: Vector) -> Moments:
    """The same integrals as `moments_by_nodes`, exact, from those of the stress."""
    ones, squares, _ = of_stress
    s = [one + rest for one, rest in zip(ones, series_sums(series, of_stress), strict=False)]
    r = [2.0 * series.first * one + 4.0 * series.second * square for one, square in zip(ones, squares, strict=True)]
    return assembled(s, r, t, g)
