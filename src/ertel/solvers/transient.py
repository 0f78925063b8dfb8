"""Time steps on the 2-D grid: one BDF step of `contact`'s residual, for impact, rolling, and both combined."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.tree_util import register_dataclass

from ertel.model import budget, contact, discretise, outside
from ertel.model.approach import Closure, ClosureLine, NewtonsLaw
from ertel.model.budget import Account, Around, Moment
from ertel.model.case import Case
from ertel.model.contact import Contact
from ertel.model.flow import Flow, rate_in_time
from ertel.model.friction import Friction, coefficients
from ertel.model.measure import measure
from ertel.model.state import Method, State, Stepping, Work
from ertel.model.status import Status
from ertel.numerics import bdf, multigrid, newton, stencils
from ertel.numerics.bdf import Weights
from ertel.numerics.grid import Even, check_grid
from ertel.numerics.integrals import Plane
from ertel.numerics.multigrid import Elasticity
from ertel.numerics.programs import Program
from ertel.numerics.symmetry import total, unfolded
from ertel.physics.far_field import Motion
from ertel.solvers import nonlinear, steady
from ertel.solvers.nonlinear import Close, Problem
from ertel.solvers.preconditioner import PRECISION, point_preconditioner

THIN = 0.1  # of the film scale: below this the time error of a film is not taken relative to itself
STEEPEST_FALL = 0.6  # share of the last pressure that the prediction keeps at least
LOAD_SHARE = 0.01  # of the tolerance, is left over in a balanced load (relative)
LARGEST_REST = 20.0  # tolerances of time, may be left over in the film of a step: more would rule the size of the steps
SMALL = 3 * 65 * 65  # entries of three levels on a grid whose account, once a step, is not worth optimising
# Krylov: 3 or 4 are needed, and each has its two fields
OPTIONS = newton.Options(newton_limit=100, krylov_limit=10)


@register_dataclass
@dataclass(frozen=True)
class StepProblem:
    """One BDF step, ready to be solved.

    past: fields of the last three levels, newest first, each of shape (3, n, n).  predict, rates: weights of the
    prediction and of the time derivative (for the new level, and the last two), both of shape (3,).  flow: how the oil
    moves, None where it stays.  approach: the predicted Delta.  edge: P on the edge of the grid, zero inside.  elastic:
    the deformation operators of the preconditioner's grids.
    """

    contact: Contact
    elastic: tuple[Elasticity, ...]
    past: Mapping[str, Array]
    approach: float
    edge: Array
    predict: Weights
    rates: Weights
    line: ClosureLine
    flow: Flow | None
    tolerance: float
    film_scale: float
    close: Close = field(metadata={"static": True})
    options: newton.Options = field(default=OPTIONS, metadata={"static": True})


class StepSolution(NamedTuple):
    """The new fields, each of shape (n, n), Delta, whether the solve converged, and its iterations."""

    fields: Mapping[str, Array]
    approach: Array
    converged: Array
    newton: Array
    krylov: Array


def stacked(levels: Sequence[State]) -> dict[str, Array]:
    """The fields of some levels by name, the levels along the first axis."""
    return {name: jnp.stack([level.fields[name] for level in levels]) for name in levels[0].fields}


class Transient2D(Method):
    """The methods "2d" and "transient".

    An impact starts with the bodies apart, rolling from its steady film.  closure is the law for Delta: Newton's law
    with the case's load and inertia unless another is given.
    """

    controlled = ("mass",)

    def __init__(self, case: Case, closure: Closure | None = None):
        self.case = case
        self.grid = discretise.grid_of(case)
        check_grid(self.grid)
        self.geometry = case.geometry
        self.contact = discretise.smooth_contact(case, self.grid)
        self.outside = discretise.outside_of(case, self.grid)
        self.closure = closure or NewtonsLaw.of(case.motion, self.geometry.hertz_load)
        self.elastic = multigrid.elasticities(self.grid, self.geometry.compliance, PRECISION)
        self.coordinates = {"Y": self.grid.y, "X": self.grid.x}
        self.space = Plane.of(self.grid)
        self.coarsenings = discretise.coarsenings(case, self.grid.spacing, len(self.elastic) - 1)
        time = case.schedule
        self.tolerance = case.solver.tolerance
        if not time.step:
            self.tolerance = min(self.tolerance, LARGEST_REST * time.tolerance)

    def start(self) -> State:
        """The separated bodies approaching with unit speed, the oil squeezed; or the steady film at T = 0."""
        return self._first

    @cached_property
    def _first(self) -> State:
        c = self.contact_at(0.0)
        if not self.case.starts_apart:
            rolling = steady.settled(self.case)
            s = rolling.finest
            work = Work(s.newton, s.krylov, rolling.convolutions)
            return State(0.0, s.approach, 0.0, _fields(c, s.P, s.H), s.status, work, s.outside)
        motion = Motion(self.case.schedule.start_approach, 1.0, 0.0, self.case.motion.entrainment(0.0))
        around, P = self.outside.at(motion), jnp.asarray(self.outside.at_first(motion))
        H = contact.film_thickness(c, P, motion.approach) + around.uplift
        work = Work(convolutions=1.0)
        return State(0.0, motion.approach, 1.0, _fields(c, P, H), work=work, outside=around.load)

    def contact_at(self, T: float) -> Contact:
        """The surfaces and the oil at time T."""
        return discretise.moved(self.contact, self.case, self.grid, T)

    def flow(self, T: float, times: Sequence[float]) -> Flow | None:
        """How the oil moves up to a new time T from earlier times, newest first; None where it stays."""
        if not self.case.motion.flows:
            return None
        distance = self.case.motion.entrainment.integral
        ways = [(distance(late) - distance(early)) / self.grid.spacing for late, early in pairwise([T, *times])]
        return Flow(self.case.motion.entrainment(T), tuple(ways), self.start_mass)

    @cached_property
    def start_mass(self) -> Array:
        """The mass of the film from which the run starts: the steady film of rolling, the smooth gap of an impact."""
        if self.case.starts_apart:
            return self.contact.gap
        return contact.mass(self.contact, self._first.P, self._first.H)

    def attempt(self, levels: Sequence[State], step: float) -> Stepping:
        """One BDF step (BDF1 from one level, BDF2 from more): yields one `StepProblem`."""
        T = levels[0].T + step
        times = [level.T for level in levels]
        rates = bdf.derivative_weights([T, *times[:2]])
        approaches = [level.approach for level in levels]
        line = self.closure.line(T, rates, approaches, [level.velocity for level in levels])
        predict = bdf.interpolation_weights(T, times)
        around = self.outside.at(self.motion(levels, T))
        surfaces, line = self.contact_at(T), line.less(around.load)
        solution: StepSolution = yield StepProblem(
            replace(surfaces, gap=surfaces.gap + around.uplift),
            self.elastic,
            stacked(padded(levels)),
            float(predict @ approaches),
            around.edge,
            _pad(predict),
            _pad(rates),
            line,
            self.flow(T, [*times, times[-1]][:2]),
            self.tolerance,
            self.case.film_scale,
            nonlinear.eliminated if line.approach_weight else nonlinear.bordered,
        )
        n, k = int(solution.newton), int(solution.krylov)
        approach = float(solution.approach)
        velocity = self.closure.velocity(T, rates, approach, approaches)
        status = Status.CONVERGED if bool(solution.converged) else Status.NEWTON_STALLED
        work = Work(n, k, nonlinear.convolutions(self.grid, n, k))
        return State(T, approach, velocity, solution.fields, status, work, around.load)

    def motion(self, levels: Sequence[State], T: float) -> Motion:
        """What the oil outside knows of the new level.

        The squeeze of a rolling contact is left out there: with little or no inertia V follows from the film of the
        same step, and taken from the steps before it would swing up.
        """
        loads = [self.carried(level) for level in levels[: outside.NEWEST]]
        found = outside.predicted(levels, T, loads, self.case.motion.entrainment(T))
        return found if self.case.starts_apart else found._replace(velocity=0.0)

    def solve(self, problem: StepProblem) -> StepSolution:
        """The step's solution, on this device."""
        return _step_program(problem)

    def measure(self, level: State) -> dict[str, float]:
        """See `Method.measure`."""
        values = measure(self.grid, level.P, level.H)
        values["F"] = (values.pop("load") + level.outside) / self.geometry.hertz_load
        if self.case.is_axisymmetric:
            for X, Y in (("X_min", "Y_min"), ("X_P_max", "Y_P_max")):
                values |= {X: float(np.hypot(values[X], values[Y])), Y: 0.0}
        return values

    def account(self, levels: Sequence[State]) -> dict[str, float]:
        """See `Method.account`."""
        new, *past = levels
        times, scale = [level.T for level in past], self.geometry.hertz_load
        rates = bdf.derivative_weights([new.T, *times[:2]])
        masses = stacked([new, *padded(past)[:2]])["mass"]
        flow = self.flow(new.T, [*times, times[-1]][:2])
        found = self._account(new, masses, _pad(rates), flow)
        loads = [self.carried(level) * scale - level.outside for level in levels]
        beyond = self.carried(new) * scale - float(found.terms["load"])  # half a cell around the grid counts as outside
        around = Around(beyond, self.outside.at(self.motion(past, new.T)).uplift, float(rates @ loads))
        return budget.terms(found.terms, new.velocity, around, scale) | coefficients(found.friction)

    def friction(self, level: State) -> Friction:
        """See `Method.friction`: by the program of the account, as if the film did not change."""
        masses: Any = np.stack([np.asarray(level.fields["mass"])] * 3)
        return self._account(level, masses, np.zeros(3), self.flow(level.T, [level.T] * 2)).friction

    def _account(self, level: State, masses: Array, rates: Weights, flow: Flow | None) -> Account:
        case, T = self.case, level.T
        U = 0.0 if flow is None else flow.entrainment
        gap_change = discretise.gap_change(case, self.grid, T)
        loaded = self.carried(level), self.geometry.hertz_load
        moment = Moment(level.approach, U, case.motion.sliding(T), gap_change, *loaded)
        found: Account = _program(self.space, self.contact_at(T), level.P, level.H, moment, masses, rates, flow)
        return found

    def carried(self, level: State) -> float:
        """F, with the load of the oil outside, in units of Hertz' load."""
        return (float(contact.load(self.contact, level.P)) + level.outside) / self.geometry.hertz_load

    def whole(self, field: Array, odd: bool = False) -> Array:
        """A field of a level on the whole plane."""
        return unfolded(np.asarray(field), self.grid.even, odd)  # type: ignore[arg-type]

    def error(self, new: State, predicted: Mapping[str, Array]) -> float:
        """That of the mass, in units of film: unlike H it is free of what Newton's iteration leaves over."""
        return self.film_error(new.fields["mass"], predicted["mass"], new.P)

    def film_error(self, H: Array, H_predicted: Array, P: Array) -> float:
        """Relative difference of two films, root mean square over the load that P carries.

        It is taken on a coarser grid: a pressure spike of a few cells that moves has an error at every node that it
        passes, which does not grow into the film and would make the number of steps that of the nodes.
        """
        thin = THIN * self.case.film_scale
        return float(_film_error(H, H_predicted, P, thin, self.grid.even, self.coarsenings))


def _fields(c: Contact, P: Array, H: Array, left: Array | float = 0.0) -> dict[str, Array]:
    """The fields of a level.  left: the mass that is left over at each node when the equations are solved.

    The field "mass" is rho H less that rest, so it solves Reynolds' equation exactly.  It is the past of the next
    steps: they bring the rest into the film, and it does not add up from step to step.
    """
    return {"P": P, "H": H, "mass": contact.mass(c, P, H) - left}


def padded(levels: Sequence[State]) -> list[State]:
    """Three levels, the oldest repeated: one shape, so one compilation, whatever the history."""
    return [*levels, *[levels[-1]] * 2][:3]


def _pad(weights: np.ndarray) -> np.ndarray:
    return np.pad(weights, (0, 3 - len(weights)))


@partial(jax.jit, static_argnames=("even", "coarsenings"))
def _film_error(H: Array, H_predicted: Array, P: Array, thin: float, even: Even, coarsenings: int) -> Array:
    for _ in range(coarsenings):
        H, H_predicted, P = (multigrid.restrict(field, even) for field in (H, H_predicted, P))
    relative = (H - H_predicted) / (jnp.abs(H) + thin)
    return jnp.sqrt(total(P * relative**2, even) / jnp.maximum(total(P, even), jnp.finfo(P.dtype).tiny))


@jax.jit
def solve_step(p: StepProblem) -> StepSolution:
    """The fields and Delta after one step."""
    P_old, H_old = p.past["P"], p.past["H"]
    rate = rate_in_time(p.rates, p.past["mass"][:2], p.flow, p.contact.spacing)
    P = jnp.tensordot(p.predict, P_old, axes=1)
    # The viscosity is exponential, so Newton needs few iterations to lower a pressure and many to raise it from zero.
    # So the prediction limits the fall.
    P = stencils.edged(jnp.maximum(P, STEEPEST_FALL * P_old[0]), p.edge, p.contact.even)
    # a residual r leaves the mass r/rate.new over in this step
    allowed = p.tolerance * rate.new * (p.film_scale + jnp.abs(H_old[0]))
    problem = Problem(
        p.contact,
        p.elastic,
        rate,
        p.line,
        allowed,
        LOAD_SHARE * p.tolerance,
        p.close,
        point_preconditioner,
        p.options,
    )
    s, approach = nonlinear.solve(problem, P, p.approach)
    return StepSolution(_fields(p.contact, s.P, s.H, s.left / rate.new), approach, s.converged, s.newton, s.krylov)


_step_program = Program(solve_step)


def _account(
    space: Plane, c: Contact, P: Array, H: Array, m: Moment, masses: Array, rates: Weights, flow: Flow | None
) -> Account:
    """The account after a step.  masses: at the new time and the last two, shape (3, n, n)."""
    change = rate_in_time(rates, masses[1:], flow, c.spacing).of(masses[0], c.spacing)
    return budget.account(space, c, P, H, m, change)


_program = Program(jax.jit(_account), SMALL)
