"""Axisymmetric impact of a smooth ball: the fast twin and independent check of the 2-D method.

Finite volumes on a radial grid, a dense elastic kernel and Newton's method with the full Jacobian.  Nothing is shared with
the 2-D method but the physics: lubricant, closure, backward differences.  Symbols as in `contact`, r = radius / a*.

    d(rho H)/dT - (1/r) d/dr(r eps dP/dr) = 0   where P > 0,   >= 0 where P = 0,   eps = rho H^3/(eta lambda_bar)
    H = -Delta + r^2/2 + (2/pi^2) double integral of P / distance                       eqs. (1), (3)
"""

from collections.abc import Mapping, Sequence
from math import log, pi
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray
from scipy.special import ellipe, ellipkm1

from ertel import bdf
from ertel.case import Case
from ertel.closure import HERTZ_LOAD, ClosureLine, NewtonsLaw
from ertel.level import Attempt, Level
from ertel.lubricant import Lubricant
from ertel.status import Status

jax.config.update("jax_enable_x64", True)

Vector = NDArray[np.float64]

CONTACT = 1.05  # the grid is uniform to here, just outside the largest contact, and widens outwards
WIDENING = 4.0  # growth of the spacing per unit of radius there, in units of the inner spacing
NEWTON_LIMIT = 15
LARGEST_CHANGE = 0.3  # of P in one Newton iteration


class Mesh(NamedTuple):
    """A radial grid: nodes r, volumes per radian around them, faces between, and what elasticity needs.

    kernel: deformation (2/pi^2) double integral of P/distance = kernel @ P, shape (n, n).
    load: double integral of P = load @ P.  Both are exact for P linear between nodes and zero at the outer one.
    """

    r: Array
    face: Array
    volume: Array
    kernel: Array
    load: Array


class Stepped(NamedTuple):
    """P and H at the new level, the largest residual left, the number of Newton iterations."""

    P: Array
    H: Array
    size: Array
    newton: Array


def radii(nodes: int, half_width: float) -> Vector:
    """Nodes from 0 to half_width: uniform in the contact, wider and wider outside."""

    def evenly(r: float) -> float:
        return r if r <= CONTACT else CONTACT + log(1 + WIDENING * (r - CONTACT)) / WIDENING

    s = np.linspace(0.0, evenly(half_width), nodes)
    outside = np.maximum(s - CONTACT, 0.0)
    return np.minimum(s, CONTACT) + np.expm1(WIDENING * outside) / WIDENING


def mesh(nodes: int, half_width: float) -> Mesh:
    """The grid with its elastic kernel."""
    r = radii(nodes, half_width)
    face = (r[1:] + r[:-1]) / 2
    ends = np.concatenate([[0.0], face, [half_width]])
    fields = r, face, np.diff(ends**2) / 2, elastic_kernel(r), load_weights(r)
    return Mesh(*(jnp.asarray(f) for f in fields))


def disc(r: Vector, b: Vector) -> Vector:
    """Integral of 1/distance over a disc of radius b, seen from radius r (arrays that broadcast).

    Inside 4 b E(r^2/b^2), outside 4 r [E(b^2/r^2) - (1 - b^2/r^2) K(b^2/r^2)]: Love's uniform pressure on a circle
    (Johnson, Contact Mechanics, 1985, sec. 3.4), complete elliptic integrals of parameter m = k^2.
    """
    large = np.maximum(r, b)
    ratio = np.minimum(r, b) / large
    m1 = (1 - ratio) * (1 + ratio)  # complementary parameter
    E = ellipe(ratio**2)
    outside = np.where(m1 > 0, m1 * ellipkm1(np.where(m1 > 0, m1, 1.0)), 0.0)
    return np.where(r < b, 4 * b * E, 4 * r * (E - outside))


def elastic_kernel(r: Vector) -> NDArray[np.float64]:
    """Matrix of the deformation (2/pi^2) double integral of P/distance at r, for P linear between the nodes r.

    By parts: a pressure is a heap of discs, the deformation minus the integral of dP/db disc(r, b) db.  So each interval
    needs the mean of disc(r, .) over it; Gauss points, crowded towards the ends, where (b - r) log|b - r| starts or stops.
    """
    x, w = np.polynomial.legendre.leggauss(8)
    x = (x + 1) / 2
    share, weight = x**2 * (3 - 2 * x), w / 2 * 6 * x * (1 - x)
    b = r[:-1, None] + np.diff(r)[:, None] * share
    mean = np.tensordot(disc(r[:, None, None], b[None]), weight, axes=1)
    return 2 / pi**2 * (np.pad(mean, ((0, 0), (0, 1))) - np.pad(mean, ((0, 0), (1, 0))))


def load_weights(r: Vector) -> Vector:
    """Weights of 2 pi integral of P r dr, exact for P linear between the nodes r."""
    h = np.diff(r)
    inner = h * (2 * r[:-1] + r[1:]) / 6  # integral of r times the falling half of a hat
    outer = h * (r[:-1] + 2 * r[1:]) / 6
    return 2 * pi * (np.pad(inner, (0, 1)) + np.pad(outer, (1, 0)))


def divergence_of_flux(grid: Mesh, eps: Array, P: Array) -> Array:
    """(1/r) d/dr(r eps dP/dr) over each volume: what enters through its faces.  Zero on the outer node."""
    flux = grid.face * (eps[1:] + eps[:-1]) / 2 * jnp.diff(P) / jnp.diff(grid.r)
    return jnp.pad(jnp.diff(flux, prepend=0.0), (0, 1)) / grid.volume


def residual(
    grid: Mesh, oil: Lubricant, lambda_bar: Array | float, new: Array | float, past: Array, P: Array, H: Array
) -> Array:
    """Reynolds' equation, eq. (1): squeeze - div(Poiseuille flux), with d(rho H)/dT = new * rho H + past."""
    mass = oil.density(P) * H
    eps = oil.density(P) * jnp.maximum(H, 0.0)**3 / (oil.viscosity(P) * lambda_bar)
    return (new * mass + past - divergence_of_flux(grid, eps, P)).at[-1].set(0.0)


@eqx.filter_jit
def solve(
    grid: Mesh, oil: Lubricant, lambda_bar: Array, new: Array, past: Array, line: ClosureLine, P: Array, tolerance: Array
) -> Stepped:
    """P >= 0 and H at the new level from the guess P: Newton with the exact Jacobian and an active set."""
    rise = line.load_weight / line.approach_weight  # Delta = value/approach_weight - rise * F
    stiffness = grid.kernel + rise * grid.load
    apart = grid.r**2 / 2 - line.value / line.approach_weight

    def equations(P: Array, H: Array) -> Array:
        return residual(grid, oil, lambda_bar, new, past, P, H)

    def free(P: Array, r: Array) -> Array:
        return ((P > 0) | (r < 0)).at[-1].set(False)

    def size(P: Array, r: Array) -> Array:
        return jnp.max(jnp.abs(jnp.where(free(P, r), r, 0.0)))

    def go_on(s: Stepped) -> Array:
        return ((s.size > tolerance) | (s.newton == 0)) & (s.newton < NEWTON_LIMIT)

    def improve(s: Stepped) -> Stepped:
        r, change = jax.linearize(equations, s.P, s.H)
        identity = jnp.eye(len(s.P))
        jacobian = jax.vmap(change, in_axes=1, out_axes=1)(identity, stiffness)
        held = ~free(s.P, r)
        jacobian = jnp.where(held[:, None], identity, jacobian)
        dP = jnp.linalg.solve(jacobian, jnp.where(held, -s.P, -r))
        share = jnp.minimum(1.0, LARGEST_CHANGE / jnp.max(jnp.abs(dP)))
        P = jnp.maximum(s.P + share * dP, 0.0)
        H = apart + stiffness @ P
        return Stepped(P, H, size(P, equations(P, H)), s.newton + 1)

    H = apart + stiffness @ P
    start = Stepped(P, H, size(P, equations(P, H)), jnp.zeros((), jnp.int32))
    return jax.lax.while_loop(go_on, improve, start)


class RadialImpact:
    """The method "radial": see `level.Method`."""

    def __init__(self, case: Case):
        self.mesh = mesh(case.solver.nodes, case.solver.half_width)
        self.lambda_bar = jnp.asarray(case.parameters.lambda_bar)
        self.oil = jax.tree.map(lambda x: jnp.asarray(x) if eqx.is_array_like(x) else x, case.lubricant)
        self.closure = NewtonsLaw()
        self.tolerance = case.solver.tolerance * case.parameters.trapped_film
        self.start_approach = case.time.start_approach
        self.coordinates: Mapping[str, Vector] = {"r": np.asarray(self.mesh.r)}

    def start(self) -> Level:
        """The ball apart, moving in with unit speed, no pressure yet."""
        r = self.mesh.r
        return Level(0.0, self.start_approach, 1.0, jnp.zeros_like(r), r**2 / 2 - self.start_approach)

    def advance(self, levels: Sequence[Level], step: float) -> Attempt:
        """One BDF step (BDF1 from one level, BDF2 from more)."""
        T = levels[0].T + step
        times = [level.T for level in levels]
        rates = bdf.derivative_weights([T, *times[:2]])
        approaches = [level.approach for level in levels]
        line = self.closure.line(T, rates, approaches, [level.velocity for level in levels])
        past = sum(w * self.oil.density(level.P) * level.H for w, level in zip(rates[1:], levels, strict=False))
        weights = bdf.interpolation_weights(T, times)
        guess = jnp.maximum(sum(w * level.P for w, level in zip(weights, levels, strict=True)), 0.0)
        line = ClosureLine(*(jnp.asarray(x) for x in line))
        new, tolerance = jnp.asarray(rates[0]), jnp.asarray(self.tolerance * rates[0])
        s = solve(self.mesh, self.oil, self.lambda_bar, new, past, line, guess, tolerance)
        approach = float((line.value - line.load_weight * (self.mesh.load @ s.P)) / line.approach_weight)
        velocity = self.closure.velocity(T, rates, approach, approaches)
        good = s.size <= self.tolerance * rates[0] and jnp.min(s.H) > 0
        status = Status.CONVERGED if good else Status.NEWTON_STALLED
        return Attempt(Level(T, approach, velocity, s.P, s.H), status, int(s.newton), 0, 0.0)

    def measure(self, level: Level) -> dict[str, float]:
        """F (units of the dry maximum load), P_c, P_max, H_c, H_min, X_min."""
        P, H = np.asarray(level.P), np.asarray(level.H)
        X_min, H_min = lowest_point(np.asarray(self.mesh.r), H)
        F = float(self.mesh.load @ level.P) / HERTZ_LOAD
        return {"F": F, "P_c": P[0], "P_max": P.max(), "H_c": H[0], "H_min": H_min, "X_min": X_min}


def lowest_point(r: Vector, H: Vector) -> tuple[float, float]:
    """Radius and value of the smallest H, by the parabola through the lowest node and its neighbours."""
    i = int(np.argmin(H))
    if i in (0, len(r) - 1):
        return float(r[i]), float(H[i])
    c = np.polyfit(r[i - 1 : i + 2] - r[i], H[i - 1 : i + 2], 2)
    x = -c[1] / (2 * c[0])
    return float(r[i] + x), float(np.polyval(c, x))
