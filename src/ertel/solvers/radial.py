"""Axisymmetric impact of a smooth ball: faster than the 2-D method, and an independent check of it.

Finite volumes on a radial grid, a dense elastic kernel and Newton's method with the full Jacobian.  The two methods
share the physics (lubricant, closure, backward differences) and nothing else.  r is the radius in units a*, the other
symbols are those of `contact`.

    d(rho H)/dT - (1/r) d/dr(r eps dP/dr) = 0   where P > 0,   >= 0 where P = 0,   eps = rho H^3/(eta lambda_bar)
    H = -Delta + r^2/2 + (2/pi^2) double integral of P/distance                                     eqs. (1), (3)
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.case.spaces import radii
from ertel.equations import account, outside
from ertel.equations.approach import ClosureLine, NewtonsLaw, rate_of_change
from ertel.equations.contact import traceable
from ertel.equations.state import State, StepNumbers, Stepper, StepSolution, lowest_point, packed, padded
from ertel.numerics import bdf
from ertel.numerics.integrals import Disc
from ertel.numerics.programs import ANY_SIZE, Program, require_double
from ertel.numerics.stencils import Pair, banded_product, diagonals
from ertel.physics.geometry import CIRCLE
from ertel.physics.lubricant import Lubricant

Floats = NDArray[np.float64]

NEWTON_LIMIT = 15
RINGS, RINGS_BESIDE_A_MENISCUS = 65, 33  # on which the error in time is taken
LARGEST_CHANGE = 0.3  # of P in one Newton iteration
BLOCKS = 4  # sizes of the matrix in a Newton iteration; 8 and 16 are not faster


class Mesh(NamedTuple):
    """A radial grid, what elasticity needs on it, and the oil.

    Nodes r (n,), faces halfway between (n - 1,), volumes per radian of the ring around each node (n,).
    kernel (n, n): (2/pi^2) double integral of P/distance = kernel @ P, exact for a pressure that is linear between
    nodes, as are the integrals over the disc.
    """

    r: Array
    face: Array
    volume: Array
    kernel: Array
    disc: Disc
    oil: Lubricant
    lambda_bar: float


class Equations(NamedTuple):
    """The equations at a new time level.

    d(rho H)/dT = rate * rho H + past.  H = apart + stiffness @ P with Delta eliminated by the closure.  The matrix
    stiffness contains the elastic kernel and the change of Delta with the load.
    """

    mesh: Mesh
    rate: float
    past: Array
    apart: Array
    stiffness: Array


class RadialProblem(NamedTuple):
    """One BDF step, ready to be solved; see `transient.StepProblem`.

    predict_P, predict_mass: weights of the predicted pressure and oil.  tolerance: of the film left over in a step.
    approaches, loads: of the past levels.  ring: that of each node, on which the error is taken.
    """

    mesh: Mesh
    past: tuple[Mapping[str, Array], ...]
    predict_P: bdf.Weights
    predict_mass: bdf.Weights
    rates: bdf.Weights
    line: ClosureLine
    approaches: Floats
    loads: Floats
    around: outside.Surroundings
    tolerance: float
    ring: Array


class RadialSolution(NamedTuple):
    """P, H (n,), the largest residual that counts (film thickness per time), the number of Newton iterations."""

    P: Array
    H: Array
    size: Array
    newton: Array


def mesh(r: Floats, oil: Lubricant, lambda_bar: float) -> Mesh:
    """The grid with nodes r, from 0 outwards, with an oil."""
    require_double()
    face = (r[1:] + r[:-1]) / 2
    ends = np.concatenate([r[:1], face, r[-1:]])
    nodes, face, volume, kernel = jax.device_put((r, face, np.diff(ends**2) / 2, elastic_kernel(r)))
    return Mesh(nodes, face, volume, kernel, Disc.of(r), traceable(oil), lambda_bar)


def disc(r: Floats, b: Floats) -> Floats:
    """Integral of 1/distance over a disc of radius b > 0, seen from radius r; the two broadcast.

    4 b E(r^2/b^2) inside, 4 r [E(b^2/r^2) - (1 - b^2/r^2) K(b^2/r^2)] outside, with the complete elliptic integrals of
    parameter k^2: uniform pressure on a circle, Johnson, Contact Mechanics (1985), section 3.4.
    """
    from scipy.special import ellipe, ellipkm1  # here: the other methods do without them

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
    eps = eq.mesh.oil.mobility(P, H, eq.mesh.lambda_bar)
    return -eq.mesh.face * (eps[1:] + eps[:-1]) / 2 * jnp.diff(P) / jnp.diff(eq.mesh.r)


def ring_residual(eq: Equations, P: Array, H: Array) -> Array:
    """Reynolds' equation (1), squeeze + div(flux), averaged over each ring; zero on the outer node."""
    squeeze = eq.rate * eq.mesh.oil.density(P) * H + eq.past
    divergence = jnp.diff(outflow(eq, P, H), prepend=0.0) / eq.mesh.volume[:-1]
    return squeeze.at[:-1].add(divergence).at[-1].set(0.0)


def free(P: Array, r: Array) -> Array:
    """1 where the equation holds.  Elsewhere P is held at zero: on the outer node and where the film cavitates.

    A node with a NaN residual is free, so that the NaN is not hidden.
    """
    return ((P > 0.0) | ~(r >= 0.0)).at[-1].set(False)


def newton_change(eq: Equations, P: Array, H: Array) -> Array:
    """Newton's change of P, with the exact Jacobian; none where P is held at zero and on the outer node.

    The residual is local in P and H: its Jacobian is the sum of d/dP (three diagonals) and d/dH (three diagonals) times
    stiffness.  In the rebound the film cavitates outside the contact; the matrix then has the nodes inside only, and
    its factorisation, which takes most of the time, is much cheaper.
    """
    r, change_of_r = jax.linearize(lambda P, H: ring_residual(eq, P, H), P, H)
    zero, holds = jnp.zeros_like(P), free(P, r)
    by_P, by_H = (diagonals(part, len(P)) for part in (lambda d: change_of_r(d, zero), lambda d: change_of_r(zero, d)))

    def of_first(n: int) -> Array:
        """The change, where the last of the first n nodes and all nodes beyond are held."""
        identity = jnp.eye(n)
        jacobian = banded_product(by_P[:, :n], identity) + banded_product(by_H[:, :n], eq.stiffness[:n, :n])
        change = jnp.linalg.solve(jnp.where(holds[:n, None], jacobian, identity), -jnp.where(holds, r, 0.0)[:n])
        return jnp.pad(change, (0, len(P) - n))

    sizes = [-(-len(P) * k // BLOCKS) for k in range(1, BLOCKS + 1)]
    needed = jnp.max(jnp.where(holds, jnp.arange(len(P)), 0)) + 2
    return jax.lax.switch(jnp.searchsorted(jnp.asarray(sizes), needed), [partial(of_first, n) for n in sizes])


@jax.jit
def solve_rings(eq: Equations, P: Array, tolerance: float) -> RadialSolution:
    """P >= 0 and H at the new level from the guess P: Newton with an active set, until |residual| <= tolerance.

    The outer node keeps its P.
    """

    def solution(P: Array, newton: Array) -> RadialSolution:
        H = eq.apart + eq.stiffness @ P
        r = ring_residual(eq, P, H)
        return RadialSolution(P, H, jnp.max(jnp.abs(jnp.where(free(P, r), r, 0.0))), newton)

    def go_on(s: RadialSolution) -> Array:
        return ((s.size > tolerance) | (s.newton == 0)) & (s.newton < NEWTON_LIMIT)

    def improve(s: RadialSolution) -> RadialSolution:
        change = newton_change(eq, s.P, s.H)
        share = jnp.minimum(1.0, LARGEST_CHANGE / jnp.max(jnp.abs(change)))
        return solution(jnp.maximum(s.P + share * change, 0.0), s.newton + 1)

    return jax.lax.while_loop(go_on, improve, solution(P, jnp.zeros((), jnp.int32)))


def equations(mesh: Mesh, past: Array, rates: bdf.Weights, line: ClosureLine, uplift: float = 0.0) -> Equations:
    """The equations of a level.  past: the oil of the earlier ones, newest first.  uplift: by the oil outside."""
    apart = CIRCLE.gap(mesh.r, 0.0) + uplift - line.value / line.approach_weight
    stiffness = mesh.kernel + line.load_weight / line.approach_weight * mesh.disc.weights
    return Equations(mesh, rates[0], jnp.asarray(rates[1:]) @ past, apart, stiffness)


@jax.jit
def solve_ring_step(p: RadialProblem) -> StepSolution:
    """The fields and the numbers after one step."""
    line, tolerance = p.line.less(p.around.load), p.tolerance * p.rates[0]
    pressures, masses = (jnp.stack([level[name] for level in p.past]) for name in ("P", "mass"))
    eq = equations(p.mesh, masses[:2], p.rates, line, p.around.uplift)
    P = jnp.maximum(jnp.tensordot(p.predict_P, pressures, axes=1), 0.0).at[-1].set(p.around.edge[-1])
    s = solve_rings(eq, P, tolerance)
    approach = line.approach(p.mesh.disc.weights @ s.P)
    oil = ring_oil(eq, s.P, s.H)
    terms = ring_account(eq, s.P, s.H, oil, approach)
    error = ring_film_error(p.ring, p.mesh.volume, oil, jnp.tensordot(p.predict_mass, masses, axes=1), s.P)
    velocity = rate_of_change(p.rates, approach, p.approaches)
    load_rate = rate_of_change(p.rates, terms["load"], p.loads)
    numbers = StepNumbers(approach, velocity, terms["load"], p.around.load, error, 0, s.size <= tolerance, s.newton, 0)
    record = account.with_outside(terms, velocity, p.around, CIRCLE.hertz_load, load_rate)
    return StepSolution({"P": s.P, "H": s.H, "mass": oil}, packed({**numbers._asdict(), **record}))


_step_program = Program(solve_ring_step)


def ring_film_error(ring: Array, volume: Array, oil: Array, predicted: Array, P: Array) -> Array:
    """Relative difference of the oil and its prediction, see `state.film_error`, by means over rings of nodes."""
    pressed, film, expected = (jax.ops.segment_sum(field * volume, ring, RINGS) for field in (P, oil, predicted))
    errors = jnp.where(film > 0.0, 1 - expected / film, 0.0)  # there may be fewer rings
    return jnp.sqrt(jnp.sum(pressed * errors**2) / jnp.maximum(pressed.sum(), jnp.finfo(P.dtype).tiny))


class RadialImpact(Stepper):
    """The method "radial".

    The default distribution of nodes suits the first touch, the trapped film and the thin edge.  Recommended values are
    half_width = 4 (the load outside falls with its square) and nodes = 401 (H_c within 0.1 % of its limit at M = 1000,
    L = 10).
    """

    def __init__(self, case: Case):
        lambda_bar = case.parameters.lambda_bar
        self.mesh = mesh(radii(case.solver.nodes, case.solver.half_width), case.lubricant, lambda_bar)
        self.layer = case.layer
        self.outside = outside.around_circle(np.asarray(self.mesh.r), 0.0 if case.layer else lambda_bar)
        self.closure = NewtonsLaw(case.motion.inertia, case.motion.load)
        self.tolerance = case.solver.tolerance * case.parameters.trapped_film
        self.first_motion = case.first_motion
        self.coordinates = {"r": np.asarray(self.mesh.r)}
        nodes, rings = case.solver.nodes, RINGS if self.layer is None else RINGS_BESIDE_A_MENISCUS
        self.ring = jax.device_put(np.arange(nodes) // -(-nodes // rings))

    def start(self) -> State:
        """The separated ball approaching with unit speed, see `Case.first_motion`."""
        motion = self.first_motion
        around, P = self.outside.at(motion), np.asarray(self.outside.at_first(motion))
        r, kernel, weights = map(np.asarray, (self.mesh.r, self.mesh.kernel, self.mesh.disc.weights))
        H = CIRCLE.gap(r, 0.0) - motion.approach + kernel @ P + around.uplift
        full = self.mesh.oil.density(P) * H
        oil = full if self.layer is None else np.minimum(full, self.layer)
        fields = jax.device_put({"P": P, "H": H, "mass": oil})
        return State(0.0, motion.approach, 1.0, fields, outside=around.load, load=float(weights @ P))

    def advance(self, levels: Sequence[State], step: float) -> State:
        """See `Stepper.advance`: BDF1 from one level, BDF2 from more."""
        T = levels[0].T + step
        times = [level.T for level in levels]
        rates = bdf.derivative_weights([T, *times[:2]])
        past = padded(levels)
        approaches, velocities, loads = np.array([(level.approach, level.velocity, level.load) for level in past]).T
        # in the rebound the pressure collapses behind the receding edge, and a parabola overshoots
        recent = times if levels[0].velocity > 0 else times[:2]
        around = self.outside.at(outside.predicted(levels, T, CIRCLE.hertz_load, 0.0))
        problem = RadialProblem(
            self.mesh,
            tuple(level.fields for level in past),
            bdf.three(bdf.interpolation_weights(T, recent)),
            bdf.three(bdf.interpolation_weights(T, times)),
            bdf.three(rates),
            self.closure.line(T, rates, approaches, velocities),
            approaches,
            loads,
            around,
            self.tolerance,
            self.ring,
        )
        new = account.new_level(T, _step_program(problem))
        return replace(new, record={**self.measure(new), **new.record})

    def measure(self, level: State) -> dict[str, float]:
        """See `Stepper.measure`; places are radii."""
        P, H, r = np.asarray(level.P), np.asarray(level.H), self.coordinates["r"]
        X_min, H_min = lowest_point(r, H)
        F = (float(np.asarray(self.mesh.disc.weights) @ P) + level.outside) / CIRCLE.hertz_load
        films = {"H_c": float(H[0]), "H_min": H_min, "X_min": X_min, "Y_min": 0.0}
        i = int(P.argmax())
        fall = (
            1 - (P[abs(i - 1)] + P[min(i + 1, len(P) - 1)]) / (2 * P[i]) if P[i] > 0 else 0.0
        )  # even in r, none beyond the rim
        peak = {"P_max": float(P[i]), "X_P_max": float(r[i]), "Y_P_max": 0.0, "P_fall": float(fall)}
        return {"F": F, "P_c": float(P[0]), **peak, **films}

    def friction(self, level: State) -> account.Friction:
        """See `Stepper.friction`."""
        P, H = jax.device_put((level.P, level.H))
        return _friction_program(self.mesh, P, H)

    def whole(self, field: Array, odd: bool = False) -> Array:
        """The field itself."""
        return field


def ring_oil(eq: Equations, P: Array, H: Array) -> Array:
    """The oil that is there after a step, as mass; see `contact.oil_there`."""
    full, r = eq.mesh.oil.density(P) * H, ring_residual(eq, P, H)
    at_rim = jnp.where(P[-1] > 0.0, 0.0, jnp.maximum(eq.rate * full[-1] + eq.past[-1], 0.0))
    return full - r.at[-1].set(at_rim) / eq.rate


def ring_account(eq: Equations, P: Array, H: Array, oil: Array, approach: float) -> dict[str, Array]:
    """The account after a step, by name."""
    eps = Pair(eq.mesh.oil.mobility(P, H, eq.mesh.lambda_bar))
    friction = ring_friction(eq.mesh, P, H)
    deformation = H + approach - CIRCLE.gap(eq.mesh.r, 0.0)
    growth = ring_residual(eq, P, H) - eq.rate * (eq.mesh.oil.density(P) * H - oil).at[-1].set(0.0)
    mass, leaving = 2 * np.pi * eq.mesh.volume[:-1] @ oil[:-1], 2 * np.pi * outflow(eq, P, H)[-1:]
    film = account.Film(P, H, mass, leaving, eps, friction.loss, deformation, growth, 0.0, 0.0)
    return account.account_terms(eq.mesh.disc, eq.mesh.oil, film, friction, CIRCLE.hertz_load)


def ring_friction(mesh: Mesh, P: Array, H: Array) -> account.Friction:
    """The friction of an impact: no sliding, only heating by pressure-driven flow."""
    eps = Pair(mesh.oil.mobility(P, H, mesh.lambda_bar))
    heat = mesh.disc.of_slopes(eps, P, mesh.oil.enthalpy(P))
    force = jnp.zeros(2)
    return account.Friction(jnp.zeros((2, *P.shape)), heat, force, force, mesh.disc.total(heat) / CIRCLE.hertz_load)


_friction_program = Program(jax.jit(ring_friction), ANY_SIZE)
