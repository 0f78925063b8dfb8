"""The response of a contact to small changes of its surfaces, to first order: of a time step, and of steady rolling.

Tangent-linear step: a step solves r(P, H(P, Delta), past) = 0 on the free nodes.  Its derivative is one linear system
with the Jacobian of the solved step, the exact one (automatic differentiation of `contact.residual`), and the same
preconditioner.

Waves through a steady rolling contact: one complex system in place of time steps.  Roughness
r = Re[shape exp(i omega T)] of small height changes P, H and Delta by Re[P' exp(i omega T)] and so on:

    D m' - div(eps' grad P + eps grad P') = 0     where P > 0, elsewhere P' = 0
    H' = - Delta' + K P' - shape
    - omega^2 inertia Delta' + F' = 0

Where the film ends, P and its gradient vanish, so that a small motion of its end has no effect of first order.
D m = dm/dT + U dm/dX is that of backward differences along the flow (`flow`) with steps of one cell, U dT = h:

    D m = U (3 m(X) - 4 q m(X - h) + q^2 m(X - 2 h))/(2 h),    q = exp(- i omega h/U)

This is the upstream slope of m without the phase of waves that ride with the oil, so these are carried without loss.
Time steps of this length lead to the same film once it is periodic; at omega = 0 D is the wedge of the steady film.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, tree

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.equations import contact, discretise
from ertel.equations.approach import ClosureLine, NewtonsLaw, balanced, rate_of_change
from ertel.equations.contact import Contact
from ertel.equations.flow import Flow, OilContent, Rate, flow_aligned, rate_in_time, steady_rate
from ertel.equations.linearised import LinearFilm, flux_change, linear_film
from ertel.equations.state import State, Work
from ertel.numerics import bdf, multigrid
from ertel.numerics.line_smoother import LineSmoother, line_smoother
from ertel.numerics.newton import gcr
from ertel.numerics.programs import require_double
from ertel.numerics.stencils import FloatLike, inside, upstream_slope
from ertel.physics.motion import constant
from ertel.solvers import nonlinear
from ertel.solvers.grid_solution import GridSolution
from ertel.solvers.nonlinear import PRECISION, Problem
from ertel.solvers.transient import FALLING, Transient2D

NODES_PER_WAVE = 4  # a coarse grid that has fewer is for long waves alone
# of the linear solves.  Waves mostly take 13 to 20 iterations; each keeps two fields
REDUCTION, STEP_LIMIT, WAVE_LIMIT = 1e-6, 40, 60

Fields = Mapping[str, Array]

# -- a time step ------------------------------------------------------------------------------------------------------


def tangent_start(shape: Array) -> State:
    """The change at T = 0: only the surfaces change, not the position of the ball."""
    return State(0.0, 0.0, 0.0, {"P": jnp.zeros_like(shape), "H": -shape})


def tangent_step(method: Transient2D, smooth: Sequence[State], changes: Sequence[State], shape: Array) -> State:
    """The change of the newest level of `smooth`.

    smooth: the levels of the run, newest first.  changes: of the levels before, newest first, fields per unit of the
    parameter.  shape: height of the roughness per unit of the parameter at that time, shape (n, n), in a^2/R.
    Raises ValueError where the load is balanced without inertia.
    """
    require_double()
    motion, new = method.case.motion, smooth[0]
    if not motion.inertia > 0:
        raise ValueError(f"motion.inertia = {motion.inertia}: must be above zero for a tangent-linear run")
    times = [level.T for level in smooth[:3]]
    rates = bdf.derivative_weights(times)
    law = NewtonsLaw(motion.inertia, constant(0.0), method.geometry.hertz_load)  # the applied load does not change
    approaches = [level.approach for level in changes]
    line = law.line(new.T, rates, approaches, [level.velocity for level in changes])
    before = len(times) - 1
    past, change = (
        {name: jnp.stack([level.fields[name] for level in levels]) for name in ("P", "H")}
        for levels in (smooth[1 : before + 1], changes[:before])
    )
    c, flow = method.contact_at(new.T), method.flow(new.T, times[1:])
    problem = Problem(c, method.setting.elastic, Rate(rates[0], 0.0), line, 1.0, 1.0, FALLING)
    fields, approach, iterations = _solve_step(problem, new.fields, past, change, rates, flow, shape)
    velocity = rate_of_change(rates, float(approach), approaches)
    status = Status.CONVERGED if int(iterations) < STEP_LIMIT else Status.NEWTON_STALLED
    return State(new.T, float(approach), velocity, fields, status, Work(krylov=int(iterations)))


@jax.jit
def _solve_step(
    problem: Problem, fields: Fields, past: Fields, change: Fields, rates: bdf.Weights, flow: Flow | None, shape: Array
) -> tuple[Fields, Array, Array]:
    """The changes of the fields and of the approach, and the number of Krylov iterations.

    fields: of the solved step.  past, change: P and H of the levels before, newest first, and their changes, each of
    shape (1 or 2, n, n).  flow: as in `StepProblem`.  shape: as in `tangent_step`.
    """
    c, line, P, H = problem.contact, problem.line, fields["P"], fields["H"]
    free = jnp.where(P > 0.0, 1.0, 0.0)
    _, mass_change = jax.jvp(partial(contact.mass, c), (past["P"], past["H"]), (change["P"], change["H"]))
    # the mass of the start does not change with the roughness
    flow = flow and flow._replace(start=OilContent.without_void(jnp.zeros_like(P)))
    rate = rate_in_time(rates, mass_change, flow, c.spacing)

    def residual(P: Array, H: Array, past: Array) -> Array:
        return contact.residual(c, P, H, Rate(rate.new, past))

    _, change_of_r = jax.linearize(residual, P, H, jnp.zeros_like(P))
    closed = nonlinear.eliminate_approach(problem, P, 0.0)
    inverse = nonlinear.point_preconditioner(problem, P, H, free, None).of
    given = -line.value / line.approach_weight - shape  # the part of dH that no pressure makes
    dP, iterations = gcr(
        lambda d: free * change_of_r(d, closed.film_change(d), jnp.zeros_like(d)),
        lambda k, r: inverse(r),
        -free * change_of_r(jnp.zeros_like(P), given, rate.past),
        REDUCTION,
        STEP_LIMIT,
    )
    approach = line.approach(contact.pressure_load(c, dP))
    return {"P": dP, "H": closed.film_change(dP) + given}, approach, iterations


# -- waves through a steady film --------------------------------------------------------------------------------------


class RoughnessWave(NamedTuple):
    """Roughness Re[shape exp(i frequency T)]; frequency >= 0 in 1/t0, shape in a^2/R, complex, of the grid's shape."""

    frequency: float
    shape: Array


class WaveResponse(NamedTuple):
    """P', H' (complex, of the grid's shape) and Delta'; whether the solve converged; its iterations and convolutions.

    A convolution of a complex field counts as two.
    """

    P: Array
    H: Array
    approach: complex
    converged: bool
    krylov: int
    convolutions: float


def wave_response(case: Case, film: GridSolution, wave: RoughnessWave) -> WaveResponse:
    """The response of the steady film of a case to a wave, to first order in its height."""
    require_double()
    motion = case.motion
    line = balanced(0.0, case.geometry.hertz_load)._replace(approach_weight=-motion.inertia * wave.frequency**2)
    c = discretise.smooth_contact(case, film.grid)
    elastic = multigrid.deformation_operators(film.grid, case.geometry.compliance, PRECISION, case.geometry.reach)
    dP, dH, approach, iterations = _solve_wave(c, elastic, film.P, film.H, line, motion.entrainment(0.0), wave)
    k, converged = int(iterations), bool((iterations < WAVE_LIMIT) & jnp.isfinite(approach))
    return WaveResponse(dP, dH, complex(approach), converged, k, 2 * nonlinear.convolutions(film.grid, 0, k))


@jax.jit
def _solve_wave(
    c: Contact,
    elastic: tuple[multigrid.DeformationOperator, ...],
    P: Array,
    H: Array,
    line: ClosureLine,
    entrainment: FloatLike,
    wave: RoughnessWave,
) -> tuple[Array, Array, Array, Array]:
    """P', H', Delta' and the number of Krylov iterations."""
    turned = partial(flow_aligned, steady_rate(entrainment))
    P, H, shape, speed = turned(P), turned(H), turned(wave.shape), jnp.abs(entrainment)
    film, flux = linear_film(c, P, H), flux_change(c, P, H)
    free = inside(jnp.where(P > 0.0, 1.0, 0.0), c.even)
    riding = _Riding(jnp.exp(-1j * wave.frequency / speed * c.spacing * jnp.arange(P.shape[1])), speed, wave.frequency)
    inverse = partial(multigrid.precondition, _levels(film, free, elastic, riding))
    weight = nonlinear.LOAD_WEIGHT / c.spacing
    zero, one = jnp.zeros_like(shape), jnp.ones((), shape.dtype)

    def residual(dP: Array, dH: Array) -> Array:
        """The change of the residual on the free nodes."""
        return free * inside(riding.rate(film.change(dP, dH).mass, c.spacing) - flux(dP, dH), c.even)

    def system(d: tuple[Array, Array]) -> tuple[Array, Array]:
        e, s = d
        misfit = line.approach_weight * s + line.load_weight * contact.pressure_load(c, e)
        return residual(e, contact.deformation(c, e) - s), weight * misfit

    lifted = residual(zero, jnp.ones_like(shape))

    def direction(k: Array, r: tuple[Array, Array]) -> tuple[Array, Array]:
        """Search direction k: first a change of Delta with the pressure's response, then changes of P alone."""
        return inverse(jnp.where(k == 0, lifted, r[0])), jnp.where(k == 0, one, 0.0)

    by_the_wave = residual(zero, shape), 0.0 * one
    (dP, approach), iterations = gcr(system, direction, by_the_wave, REDUCTION, WAVE_LIMIT)
    dH = contact.deformation(c, dP) - approach - shape
    return turned(dP), turned(dH), approach, iterations


class _Riding(NamedTuple):
    """Waves that ride with the oil.

    phase: exp(- i omega X/U), shape (n,), X downstream.  entrainment: U > 0.  frequency: omega.
    """

    phase: Array
    entrainment: FloatLike
    frequency: FloatLike

    def rate(self, mass: Array, spacing: FloatLike) -> Array:
        """The rate of change of the mass following the flow."""
        return self.phase * self.entrainment * upstream_slope(mass * jnp.conj(self.phase), spacing)


def _levels(
    film: LinearFilm, free: Array, elastic: tuple[multigrid.DeformationOperator, ...], riding: _Riding
) -> tuple[multigrid.GridLevel, ...]:
    """The V-cycle's grids, on the finest grid the operator with the mobility of the nodes."""
    precision = elastic[0].near.dtype
    film = film.in_precision(precision)
    fields = free, riding
    free, riding = tree.map(lambda values: jnp.asarray(values, multigrid.in_precision(precision, values)), fields)

    def smoother(e: multigrid.DeformationOperator, c: multigrid.Coefficients) -> LineSmoother:
        """The waves where the grid holds those that ride with the oil; elsewhere long waves alone."""
        turn = riding.frequency * e.spacing / riding.entrainment
        holds = turn <= 2 * jnp.pi / NODES_PER_WAVE
        phase = jnp.where(holds, jnp.exp(-1j * turn), 1.0)
        rate = jnp.where(holds, 0.0, 1j * riding.frequency)
        return line_smoother(e, c, rate, riding.entrainment, phase)

    def residual(dP: Array, dH: Array) -> Array:
        return film.residual(dP, dH, lambda mass: riding.rate(mass, film.spacing))

    finest = multigrid.Coefficients(film.eps, film.by_H.mass, film.by_P.mass, free, film.steepening)
    return multigrid.hierarchy(elastic, finest, smoother, residual)
