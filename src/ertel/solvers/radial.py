"""Axisymmetric impact of a smooth ball: faster than the 2-D method, and an independent check of it.

Finite volumes on a radial grid, a dense elastic kernel and Newton's method with the full Jacobian.  The two methods
share the physics (lubricant, closure, backward differences) and nothing else.  r is the radius in units a*, the other
symbols are those of `contact`.

    d(rho H)/dT - (1/r) d/dr(r eps dP/dr) = 0   where P > 0,   >= 0 where P = 0,   eps = rho H^3/(eta lambda_bar)
    H = -Delta + r^2/2 + (2/pi^2) double integral of P/distance                                     eqs. (1), (3)
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray
from scipy.special import ellipe, ellipkm1

from ertel.model import budget, outside
from ertel.model.approach import Closure, ClosureLine, NewtonsLaw
from ertel.model.budget import Account, Around, Film
from ertel.model.case import Case
from ertel.model.friction import ANY_SIZE, Friction, coefficients
from ertel.model.outside import Surroundings
from ertel.model.pytrees import traceable
from ertel.model.state import Method, State, Stepping, Work
from ertel.model.status import Status
from ertel.numerics import bdf
from ertel.numerics.integrals import Disc, disc_weights
from ertel.numerics.programs import Program
from ertel.numerics.stencils import Pair
from ertel.physics.far_field import Motion
from ertel.physics.geometry import CIRCLE
from ertel.physics.lubricant import Lubricant
from ertel.physics.rheology import NEWTONIAN, Rheology

jax.config.update("jax_enable_x64", True)

Floats = NDArray[np.float64]

EDGE = 1.0  # maximum radius of the dry contact: the grid is finest here, where the film is thinnest
WIDENING_INSIDE = 1.5  # the spacing at distance d from the edge is 1 + widening * d times that at the edge
WIDENING_OUTSIDE = 8.0
NEWTON_LIMIT = 15
RINGS = 65  # on which the error in time is taken
LARGEST_CHANGE = 0.3  # of P in one Newton iteration


class Mesh(NamedTuple):
    """A radial grid and what elasticity needs on it.

    Nodes r (n,), faces halfway between (n - 1,), volumes per radian of the ring around each node (n,).
    kernel (n, n): (2/pi^2) double integral of P/distance = kernel @ P.  load (n,): double integral of P = load @ P.
    Both are exact for a pressure that is linear between nodes.
    """

    r: Array
    face: Array
    volume: Array
    kernel: Array
    load: Array


class Equations(NamedTuple):
    """What holds at a new time level.

    d(rho H)/dT = rate * rho H + past.  H = apart + stiffness @ P with Delta eliminated by the closure.  The matrix
    stiffness contains the elastic kernel and the change of Delta with the load.
    """

    mesh: Mesh
    oil: Lubricant
    flow: Rheology
    lambda_bar: float
    rate: float
    past: Array
    apart: Array
    stiffness: Array


class Problem(NamedTuple):
    """The equations of a step, the first guess of P, and the largest residual allowed."""

    equations: Equations
    P: Array
    tolerance: float


class Solution(NamedTuple):
    """P, H (n,), the largest residual that counts (film thickness per time), the number of Newton iterations."""

    P: Array
    H: Array
    size: Array
    newton: Array


def radii(nodes: int, half_width: float) -> Floats:
    """Nodes from 0 to half_width, finest at the edge of the contact; the spacing grows linearly to both sides."""

    s = np.linspace(-_evenly(EDGE, WIDENING_INSIDE), _evenly(half_width - EDGE, WIDENING_OUTSIDE), nodes)
    inside = EDGE - np.expm1(-WIDENING_INSIDE * np.minimum(s, 0.0)) / WIDENING_INSIDE
    r = inside + np.expm1(WIDENING_OUTSIDE * np.maximum(s, 0.0)) / WIDENING_OUTSIDE
    r[0], r[-1] = 0.0, half_width  # free of round-off
    return r


def _evenly(distance: float, widening: float) -> float:
    return float(np.log1p(widening * distance)) / widening


def extent(half_width: float) -> float:
    """The distance from 0 to half_width in units in which the nodes are evenly spaced."""
    return _evenly(EDGE, WIDENING_INSIDE) + _evenly(half_width - EDGE, WIDENING_OUTSIDE)


def mesh(r: Floats) -> Mesh:
    """The grid with nodes r, from 0 outwards, and its elastic kernel."""
    face = (r[1:] + r[:-1]) / 2
    ends = np.concatenate([r[:1], face, r[-1:]])
    fields = r, face, np.diff(ends**2) / 2, elastic_kernel(r), disc_weights(r)
    return Mesh(*(jnp.asarray(f) for f in fields))


def disc(r: Floats, b: Floats) -> Floats:
    """Integral of 1/distance over a disc of radius b > 0, seen from radius r; the two broadcast.

    4 b E(r^2/b^2) inside, 4 r [E(b^2/r^2) - (1 - b^2/r^2) K(b^2/r^2)] outside, with the complete elliptic integrals of
    parameter k^2: uniform pressure on a circle, Johnson, Contact Mechanics (1985), section 3.4.
    """
    ratio = np.minimum(r, b) / np.maximum(r, b)
    complement = (1 - ratio) * (1 + ratio)
    touching = complement == 0  # there complement * K -> 0
    K = ellipkm1(np.where(touching, 1.0, complement))
    E = ellipe(ratio**2)
    return np.asarray(np.where(r < b, 4 * b * E, 4 * r * (E - complement * K)))


def elastic_kernel(r: Floats) -> Floats:
    """Matrix (n, n) of the deformation (2/pi^2) double integral of P/distance, for P linear between the nodes r.

    Such a pressure is a sum of uniformly loaded discs, so its deformation is - integral of dP/db disc(r, b) db.  Each
    interval contributes the mean of disc(r, .) over it.  Gauss points are denser near the ends because of the
    singularity (b - r) log|b - r|.  The pressure on the outer node is that of a disc of its radius.
    """
    x, w = np.polynomial.legendre.leggauss(12)
    x, w = (x + 1) / 2, w / 2
    share, weight = x**2 * (3 - 2 * x), 6 * x * (1 - x) * w
    b = r[:-1, None] + np.diff(r)[:, None] * share
    mean = disc(r[:, None, None], b) @ weight
    kernel = np.pad(mean, ((0, 0), (0, 1))) - np.pad(mean, ((0, 0), (1, 0)))
    kernel[:, -1] += disc(r, r[-1])
    return CIRCLE.compliance * kernel


def outflow(eq: Equations, P: Array, H: Array) -> Array:
    """Oil that flows outwards through each face, per radian and time: - r eps dP/dr, eps the mean of its two nodes.

    The surfaces do not overlap in a solution, but they may during the iteration; the flow is then zero.
    """
    eps, _ = eq.flow.mobility(eq.oil.density(P), eq.oil.viscosity(P), H, eq.lambda_bar)
    return -eq.mesh.face * (eps[1:] + eps[:-1]) / 2 * jnp.diff(P) / jnp.diff(eq.mesh.r)


def residual(eq: Equations, P: Array, H: Array) -> Array:
    """Reynolds' equation (1), squeeze + div(flux), averaged over each ring; zero on the outer node."""
    squeeze = eq.rate * eq.oil.density(P) * H + eq.past
    divergence = jnp.diff(outflow(eq, P, H), prepend=0.0) / eq.mesh.volume[:-1]
    return squeeze.at[:-1].add(divergence).at[-1].set(0.0)


def free(P: Array, r: Array) -> Array:
    """1 where the equation holds.  Elsewhere P is held at zero: on the outer node and where the film cavitates.

    A node with a NaN residual is free, so that the NaN is not hidden.
    """
    return ((P > 0.0) | ~(r >= 0.0)).at[-1].set(False)


def newton_change(eq: Equations, P: Array, H: Array) -> Array:
    """Newton's change of P, with the exact Jacobian; -P where P is held at zero, none on the outer node.

    The residual is local in P and H: its Jacobian is the sum of d/dP (three diagonals) and d/dH (three diagonals) times
    stiffness.  Pushing all columns of (identity, stiffness) through the linearised residual gives just that.
    """
    r, change_of_r = jax.linearize(lambda P, H: residual(eq, P, H), P, H)
    identity = jnp.eye(len(P))
    jacobian = jax.vmap(change_of_r, in_axes=1, out_axes=1)(identity, eq.stiffness)
    holds = free(P, r)
    return jnp.linalg.solve(jnp.where(holds[:, None], jacobian, identity), -jnp.where(holds, r, P.at[-1].set(0.0)))


@jax.jit
def solve(eq: Equations, P: Array, tolerance: float) -> Solution:
    """P >= 0 and H at the new level from the guess P: Newton with an active set, until |residual| <= tolerance.

    The outer node keeps its P.
    """

    def solution(P: Array, newton: Array) -> Solution:
        H = eq.apart + eq.stiffness @ P
        r = residual(eq, P, H)
        return Solution(P, H, jnp.max(jnp.abs(jnp.where(free(P, r), r, 0.0))), newton)

    def go_on(s: Solution) -> Array:
        return ((s.size > tolerance) | (s.newton == 0)) & (s.newton < NEWTON_LIMIT)

    def improve(s: Solution) -> Solution:
        change = newton_change(eq, s.P, s.H)
        share = jnp.minimum(1.0, LARGEST_CHANGE / jnp.max(jnp.abs(change)))
        return solution(jnp.maximum(s.P + share * change, 0.0), s.newton + 1)

    return jax.lax.while_loop(go_on, improve, solution(P, jnp.zeros((), jnp.int32)))


class RadialImpact(Method):
    """The method "radial".

    The default distribution of nodes suits the first touch, the trapped film and the thin edge.  Recommended values are
    half_width = 4 (the load outside falls with its square) and nodes = 401 (H_c within 0.1 % of its limit at M = 1000,
    L = 10).
    """

    controlled = ("H",)

    def __init__(self, case: Case, closure: Closure | None = None):
        self.mesh = mesh(radii(case.solver.nodes, case.solver.half_width))
        self.lambda_bar = case.parameters.lambda_bar
        self.outside = outside.around_circle(np.asarray(self.mesh.r), self.lambda_bar)
        self.oil = traceable(case.lubricant)
        self.closure = closure or NewtonsLaw.of(case.motion)
        self.tolerance = case.solver.tolerance * case.parameters.trapped_film
        self.start_approach = case.schedule.start_approach
        self.coordinates = {"r": np.asarray(self.mesh.r)}
        self.disc = Disc.of(self.coordinates["r"])

    def start(self) -> State:
        """The separated ball approaching with unit speed, under the pressure of the oil that it squeezes."""
        motion = Motion(self.start_approach, 1.0, 0.0, 0.0)
        around, P = self.outside.at(motion), jnp.asarray(self.outside.at_first(motion))
        H = CIRCLE.gap(self.mesh.r, 0.0) - self.start_approach + self.mesh.kernel @ P + around.uplift
        return State(0.0, self.start_approach, 1.0, {"P": P, "H": H}, outside=around.load)

    def attempt(self, levels: Sequence[State], step: float) -> Stepping:
        """One BDF step (BDF1 from one level, BDF2 from more), newest level first: yields one `Problem`."""
        T = levels[0].T + step
        rates = bdf.derivative_weights([T, *(level.T for level in levels[:2])])
        approaches = [level.approach for level in levels]
        line = self.closure.line(T, rates, approaches, [level.velocity for level in levels])
        around = self.surroundings(levels, T)
        line, tolerance = line.less(around.load), self.tolerance * float(rates[0])
        P = predicted_pressure(levels, T).at[-1].set(around.edge[-1])
        s: Solution = yield Problem(self.equations(levels, rates, line, around.uplift), P, tolerance)
        approach = (line.value - line.load_weight * self.load(s.P)) / line.approach_weight
        velocity = self.closure.velocity(T, rates, approach, approaches)
        status = Status.CONVERGED if bool(s.size <= tolerance) else Status.NEWTON_STALLED  # stalled too if NaN
        return State(T, approach, velocity, {"P": s.P, "H": s.H}, status, Work(int(s.newton)), around.load)

    def surroundings(self, levels: Sequence[State], T: float) -> Surroundings:
        """The oil outside at a new level, predicted from the last ones."""
        return self.outside.at(outside.predicted(levels, T, [self.carried(level) for level in levels], 0.0))

    def solve(self, problem: Problem) -> Solution:
        """P and H at the new level."""
        return solve(*problem)

    def equations(
        self, levels: Sequence[State], rates: bdf.Weights, line: ClosureLine, uplift: float = 0.0
    ) -> Equations:
        """The equations of the level after `levels`; uplift: the deformation by the oil outside."""
        past = jnp.zeros_like(self.mesh.r)
        for weight, level in zip(rates[1:], levels, strict=False):
            past += weight * self.oil.density(jnp.asarray(level.P)) * level.H  # of a stored level too, to the last bit
        apart = CIRCLE.gap(self.mesh.r, 0.0) + uplift - line.value / line.approach_weight
        stiffness = self.mesh.kernel + line.load_weight / line.approach_weight * self.mesh.load
        return Equations(self.mesh, self.oil, NEWTONIAN, self.lambda_bar, float(rates[0]), past, apart, stiffness)

    def load(self, P: Array) -> float:
        """Double integral of P on the grid."""
        return float(self.mesh.load @ P)

    def carried(self, level: State) -> float:
        """F, with the load of the oil outside, in units of the dry maximum load."""
        return (self.load(level.P) + level.outside) / CIRCLE.hertz_load

    def measure(self, level: State) -> dict[str, float]:
        """See `Method.measure`; places are radii."""
        P, H, r = np.asarray(level.P), np.asarray(level.H), self.coordinates["r"]
        X_min, H_min = lowest_point(r, H)
        F = self.carried(level)
        films = {"H_c": float(H[0]), "H_min": H_min, "X_min": X_min, "Y_min": 0.0}
        i = int(P.argmax())
        fall = 1 - (P[abs(i - 1)] + P[i + 1]) / (2 * P[i]) if P[i] > 0 else 0.0  # P is even in r
        peak = {"P_max": float(P[i]), "X_P_max": float(r[i]), "Y_P_max": 0.0, "P_fall": float(fall)}
        return {"F": F, "P_c": float(P[0]), **peak, **films}

    def account(self, levels: Sequence[State]) -> dict[str, float]:
        """See `Method.account`."""
        new, *past = levels
        rates = bdf.derivative_weights([level.T for level in levels])
        eq = self.equations(past, rates, ClosureLine(1.0, 0.0, new.approach))
        found: Account = _program(self.disc, eq, new.P, new.H, new.approach)
        rate = float(rates @ [self.load(level.P) for level in levels])
        around = Around(new.outside, self.surroundings(past, new.T).uplift, rate)
        return budget.terms(found.terms, new.velocity, around, CIRCLE.hertz_load) | coefficients(found.friction)

    def friction(self, level: State) -> Friction:
        """See `Method.friction`: by the program of the account, as if the film did not change."""
        eq = self.equations([level], np.zeros(2), ClosureLine(1.0, 0.0, level.approach))
        found: Account = _program(self.disc, eq, level.P, level.H, level.approach)
        return found.friction

    def whole(self, field: Array, odd: bool = False) -> Array:
        """The field itself."""
        return field

    def error(self, new: State, predicted: Mapping[str, Array]) -> float:
        """That of the film."""
        return self.film_error(new.H, predicted["H"], new.P)

    def film_error(self, H: Array, H_predicted: Array, P: Array) -> float:
        """Relative difference of two films, root mean square over the load that P carries.

        The films are means over `RINGS` rings at most (see `Transient2D.film_error`).
        """
        volume, P, H, H_predicted = map(np.asarray, (self.mesh.volume, P, H, H_predicted))
        first = np.arange(0, len(H), -(-len(H) // RINGS))  # nodes of the rings
        pressed, film, predicted = (np.add.reduceat(volume * f, first) for f in (P, H, H_predicted))
        difference = 1 - predicted / film
        return float(np.sqrt(pressed @ difference**2 / max(pressed.sum(), np.finfo(float).tiny)))


def _account(disc: Disc, eq: Equations, P: Array, H: Array, approach: float) -> Account:
    """The account after a step.  Nothing slides and nothing rolls."""
    eps, _ = eq.flow.mobility(eq.oil.density(P), eq.oil.viscosity(P), H, eq.lambda_bar)
    deformation = H + approach - CIRCLE.gap(eq.mesh.r, 0.0)
    heat = disc.of_slopes(Pair(eps), P, eq.oil.enthalpy(P))
    film = Film(P, H, Pair(eps), heat, deformation, residual(eq, P, H), 0.0, 0.0)
    stress, force = jnp.zeros((2, *P.shape)), jnp.zeros(2)
    friction = Friction(stress, heat, force, force, disc.total(heat) / CIRCLE.hertz_load)
    return Account(budget.integrals(disc, eq.oil, film), friction)


_program = Program(jax.jit(_account), ANY_SIZE)


def predicted_pressure(levels: Sequence[State], T: float) -> Array:
    """P extrapolated in time, not below zero.

    Three levels are used during approach.  Two are used during rebound, where the pressure collapses behind the
    receding edge and a parabola overshoots.
    """
    used = levels[:3] if levels[0].velocity > 0 else levels[:2]
    weights = bdf.interpolation_weights(T, [level.T for level in used])
    return jnp.maximum(jnp.tensordot(weights, jnp.stack([level.P for level in used]), axes=1), 0.0)


def lowest_point(r: Floats, H: Floats) -> tuple[float, float]:
    """Radius and value of the minimum of H: the vertex of the parabola through the lowest node and its neighbours."""
    i = int(np.argmin(H))
    if i in (0, len(r) - 1):
        return float(r[i]), float(H[i])
    curvature, slope, value = np.polyfit(r[i - 1 : i + 2] - r[i], H[i - 1 : i + 2], 2)
    return float(r[i] - slope / (2 * curvature)), float(value - slope**2 / (4 * curvature))
