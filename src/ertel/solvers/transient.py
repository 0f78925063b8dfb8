"""Time steps on the 2-D grid: one BDF step of `contact`'s residual, for impact, rolling, and both combined."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from math import hypot
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.tree_util import register_dataclass
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.case.estimates import coarsenings, grid_of
from ertel.equations import account, contact, discretise, outside, state
from ertel.equations.account import Friction, Moment
from ertel.equations.approach import ClosureLine, NewtonsLaw, rate_of_change
from ertel.equations.contact import Contact
from ertel.equations.flow import Flow, OilContent, Rate, rate_in_time
from ertel.equations.outside import UNCHANGED, Surroundings
from ertel.equations.state import State, Stepper, StepSolution, Work, own_pressure, padded
from ertel.numerics import bdf, halfspace, multigrid, newton, stencils
from ertel.numerics.grid import check_coarsening
from ertel.numerics.integrals import Plane
from ertel.numerics.programs import Compiled, Program
from ertel.numerics.stencils import FloatLike, shown
from ertel.solvers import nonlinear, steady
from ertel.solvers.nonlinear import PRECISION, Algorithms, Problem

MAX_PRESSURE_DROP = 0.4  # share of the last pressure by which the prediction may fall
LOAD_TOLERANCE = 0.01  # of the tolerance, is left over in a balanced load (relative)
# RESIDUAL: largest residual film of a step, in tolerances of time; a larger one would dominate the step size.
# A step needs 2 or 3 Krylov iterations, and each has its two fields
FALLING_RESIDUAL, ROLLING_RESIDUAL = 20.0, 10.0
OPTIONS = newton.Options(newton_limit=100, krylov_limit=6, first_reduction=0.1)
FALLING = Algorithms(nonlinear.eliminate_approach, nonlinear.point_preconditioner, OPTIONS)
# With little inertia or none V is the difference of the films of two steps, and a large residual of a step is amplified
SHARPER = replace(OPTIONS, krylov_limit=10, first_reduction=0.01)
ROLLING = Algorithms(nonlinear.approach_as_unknown, nonlinear.point_preconditioner, SHARPER)

SMALL = 512  # nodes a side of a grid on which one program more takes longer than it saves


@register_dataclass
@dataclass(frozen=True)
class Setting:
    """The constants of a run.

    elastic: the deformation operators of the preconditioner's grids.  space: the grid, for integrals and extremes.
    gap: the smooth gap of the case, shape (n, n), None where its curvature stays.  gap_slope: dG/dX of it.  tolerance:
    of the film that is left over in a step, relative.  film_scale: of the case.  hertz_load: F* in a^2 p_h.
    coarsenings: see `film_error`.
    """

    elastic: tuple[multigrid.DeformationOperator, ...]
    space: Plane
    gap_slope: Array
    gap: Array | None
    tolerance: float
    film_scale: float
    hertz_load: float
    coarsenings: int = field(metadata={"static": True})


class Known(NamedTuple):
    """The numbers of a new level that are known before it is solved.

    predict, rates: weights of the prediction and of the time derivative (for the new level, and the last two), both of
    shape (3,).  approaches, loads: of the last three levels.  curvatures: of the gap at the new level, at the last two
    and at T = 0.  sliding: u1 - u2 in a/t0.  load_around, uplift: of the oil outside, at the predicted Delta and per
    change of Delta.
    """

    predict: bdf.Weights
    rates: bdf.Weights
    line: ClosureLine
    approaches: Any
    loads: Any
    curvatures: Any
    sliding: float
    load_around: Any
    uplift: Any
    load_change: float
    uplift_change: float

    def packed(self) -> bdf.Weights:
        """One array: each one that goes to the device costs the same time, however small."""
        return np.hstack(self)

    @classmethod
    def of(cls, packed: Array | bdf.Weights) -> "Known":
        levels = packed[9:12], packed[12:15], packed[15:19]
        return cls(packed[:3], packed[3:6], ClosureLine(*packed[6:9]), *levels, *packed[19:])  # type: ignore[arg-type]


@register_dataclass
@dataclass(frozen=True)
class StepProblem:
    """One BDF step, ready to be solved.

    past: fields of the last three levels, newest first.  known: from `Known.packed`.  middle: where P > 0, None if
    elsewhere too.  edge, edge_change: P on the edge, and its change with Delta.  flow: how the oil moves, None where it
    stays.  roughness_change: the rate of change of the roughness following the flow, shape (n, n) or a number.
    """

    setting: Setting
    contact: Contact
    past: tuple[Mapping[str, Array], ...]
    known: bdf.Weights
    middle: nonlinear.Middle | None
    edge: Array | NDArray[np.float64]
    edge_change: FloatLike | NDArray[np.float64]
    flow: Flow | None
    roughness_change: Array | float
    algorithms: Algorithms = field(metadata={"static": True})


class Transient2D(Stepper):
    """The methods "2d" and "transient".

    An impact starts with the bodies apart, rolling from its steady film.

    Parameters
    ----------
    case : Case
        What is asked.
    small : float
        On grids with more nodes a side than this, a film that has pressure in the middle of the grid alone, as in a
        rebound, is solved there, at a quarter of the cost.
    """

    def __init__(self, case: Case, small: float = SMALL):
        case = steady.fed(case)
        self.case, self.small = case, small
        self.grid = grid_of(case)
        check_coarsening(self.grid)
        self.geometry = case.geometry
        self.contact = jax.device_put(discretise.smooth_contact(case, self.grid))
        self.outside = discretise.outside_of(case, self.grid)
        self.layer = discretise.layer_of(case, self.grid)
        self.closure = NewtonsLaw(case.motion.inertia, case.motion.load, self.geometry.hertz_load)
        elastic = multigrid.deformation_operators(self.grid, self.geometry.compliance, PRECISION, self.geometry.reach)
        self.coordinates = self.grid.coordinates
        tolerance = case.solver.tolerance
        if not case.schedule.step:
            rest = FALLING_RESIDUAL if case.starts_apart else ROLLING_RESIDUAL
            tolerance = min(tolerance, rest * case.schedule.tolerance)
        setting = Setting(
            elastic,
            Plane.of(self.grid),
            discretise.gap_slope(case, self.grid),
            self.contact.gap if case.motion.bends else None,
            tolerance,
            case.film_scale,
            self.geometry.hertz_load,
            coarsenings(case, self.grid.spacing, self.grid.halvings),
        )
        self.setting: Setting = jax.device_put(setting)
        self._programs: dict[Any, Compiled] = {}

    def start(self) -> State:
        """The separated bodies with unit speed, see `Case.first_motion`; or the steady film at T = 0."""
        if not self.case.starts_apart:
            s = self._rolling.finest
            work = Work(s.newton, s.krylov, self._rolling.convolutions)
            return State(0.0, s.approach, 0.0, s.fields, s.status, work, s.outside, s.load)
        motion = self.case.first_motion
        around, P = self.outside.at(motion), jax.device_put(self.outside.at_first(motion))
        fields, load = _squeezed(self.contact_at(0.0), P, motion.approach, around.uplift, self.layer)
        work = Work(convolutions=1.0)
        return State(0.0, motion.approach, 1.0, fields, work=work, outside=around.load, load=float(load))

    @cached_property
    def _rolling(self) -> steady.Rolling:
        """The steady film from which rolling starts."""
        return steady.settled(self.case)

    def contact_at(self, T: float) -> Contact:
        """The surfaces and the oil at time T."""
        return discretise.roughened(self.contact, self.case, self.grid, T)

    def flow(self, T: float, times: Sequence[float]) -> Flow | None:
        """The movement of the oil up to a new time T from earlier times, newest first; None where it stays."""
        motion = self.case.motion
        if not motion.flows:
            return None
        distance = motion.entrainment.integral
        ways = [(distance(late) - distance(early)) / self.grid.spacing for late, early in pairwise([T, *times])]
        signals = motion.entrainment, motion.load, motion.curvature
        changes = self.case.starts_apart or self.case.features or any(s(t) != s(T) for s in signals for t in times)
        return Flow(motion.entrainment(T), tuple(ways), self.start_content, not changes)

    @cached_property
    def start_content(self) -> OilContent:
        """The oil of the film from which the run starts: of steady rolling, of the gap of an impact, or its layer."""
        if not self.case.starts_apart:
            return self._rolling.finest.content
        gap = self.contact.gap
        if self.layer is None:
            return OilContent.without_void(gap)
        return OilContent.without_void(jnp.broadcast_to(self.layer, gap.shape), jnp.zeros(gap.shape, bool))

    def advance(self, levels: Sequence[State], step: float) -> State:
        """See `Stepper.advance`: BDF1 from one level, BDF2 from more."""
        T, problem = levels[0].T + step, self.problem(levels, step)
        new = self._level(T, self.solve(problem), in_the_middle=problem.middle is not None)
        if problem.middle is not None and not new.status.ok:  # P > 0 elsewhere too
            tried = new.work.convolutions
            new = self._level(T, self.solve(replace(problem, middle=None)))
            new = replace(new, work=new.work._replace(convolutions=tried + new.work.convolutions))
        return new

    def problem(self, levels: Sequence[State], step: float) -> StepProblem:
        """The equations of one step on from one to three levels, newest level first."""
        T = levels[0].T + step
        times = [level.T for level in levels]
        rates = bdf.derivative_weights([T, *times[:2]])
        past = padded(levels)
        approaches, velocities, loads = np.array([(level.approach, level.velocity, level.load) for level in past]).T
        line = self.closure.line(T, rates, approaches, velocities)
        predict = bdf.interpolation_weights(T, times)
        motion = outside.predicted(levels, T, self.geometry.hertz_load, self.case.motion.entrainment(T))
        change, sliding = UNCHANGED, self.case.motion.sliding(T)
        curvatures = self.case.motion.curvature.at(np.array([T, *[*times, times[-1]][:2], 0.0]))
        if not self.case.starts_apart:
            # with little or no inertia V follows from the film of the same step, and extrapolating it is unstable
            V = rate_of_change(rates, bdf.three(predict) @ approaches, approaches)
            loads_given = [self.case.motion.load(time) for time in (T, *times)]
            load_rate = rate_of_change(rates, loads_given[0], loads_given[1:])
            motion = motion._replace(velocity=V, load_rate=load_rate, entrainment=self.case.motion.flow_at(T))
            bending = rate_of_change(rates, curvatures[0], curvatures[1:])
            motion = motion._replace(curvature=curvatures[0], bending=bending)
            change = Surroundings(*(rates[0] * part for part in self.outside.change(motion)))
        around = self.outside.at(motion)
        weights = bdf.three(predict), bdf.three(rates)
        known = Known(*weights, line, approaches, loads, curvatures, sliding, around.load, around.uplift, *change[1:])
        # the Delta of a light ball that rolls is a small difference of large numbers, so it is not eliminated
        falls = self.case.starts_apart and line.approach_weight
        return StepProblem(
            self.setting,
            self.contact_at(T),
            tuple(level.fields for level in past),
            known.packed(),
            self._middle_under(levels[0], around.edge),
            around.edge,
            change.edge,
            self.flow(T, [*times, times[-1]][:2]),
            discretise.roughness_change(self.case, self.grid, T),
            FALLING if falls else ROLLING,
        )

    def _level(self, T: float, solution: StepSolution, in_the_middle: bool = False) -> State:
        """The state after a step with its work: in the middle, the film on the whole grid is one convolution more."""
        new = account.new_level(T, solution)
        newton, krylov, _ = new.work
        grid = self.grid.middle() if in_the_middle else self.grid
        convolutions = in_the_middle + nonlinear.convolutions(grid, newton, krylov) * grid.size / self.grid.size
        record = self._on_rings(dict(new.record))
        return replace(new, work=Work(newton, krylov, convolutions), record=record)

    def _middle_under(self, level: State, edge: NDArray[np.float64]) -> nonlinear.Middle | None:
        """The middle of the grid if a film has pressure nowhere else; None otherwise and on a small grid."""
        if min(self.grid.nodes_x, self.grid.nodes_y) <= self.small:
            return None
        around = level.around  # a step has counted on the device, and P itself stays there
        around = stencils.beyond_middle(np.asarray(level.P), self.grid.even) if around is None else around
        return None if around or edge.any() else self._middle

    @cached_property
    def _middle(self) -> nonlinear.Middle:
        middle, compliance = self.grid.middle(), self.geometry.compliance
        elastic = multigrid.deformation_operators(middle, compliance, PRECISION)
        return nonlinear.Middle(halfspace.kernel(middle, compliance), elastic)

    def solve(self, problem: StepProblem) -> StepSolution:
        """The step's solution, on this device."""
        # the steps of a run are of few kinds; to look the program up by all of their leaves takes longer than the rest
        kind = problem.algorithms.close, problem.middle is None
        if kind not in self._programs:
            self._programs[kind] = _step_program.ready(problem)
        return self._programs[kind](problem)

    def measure(self, level: State) -> dict[str, float]:
        """See `Stepper.measure`."""
        values = state.measure(self.grid, level.P, level.H)
        values["F"] = (values.pop("load") + level.outside) / self.geometry.hertz_load
        if touch := account.touch_of(self.contact, level.fields.get("P_asperity")):
            found = _touch_terms(self.setting.space, touch, level.H, values["F"], self.geometry.hertz_load)
            values |= {name: float(number) for name, number in found.items()}
        return self._on_rings(values)

    def _on_rings(self, values: dict[str, float]) -> dict[str, float]:
        """The same with the places of the extremes as radii where the contact is axisymmetric."""
        if self.case.is_axisymmetric:
            for X, Y in (("X_min", "Y_min"), ("X_P_max", "Y_P_max")):
                values |= {X: hypot(values[X], values[Y]), Y: 0.0}
        return values

    def friction(self, level: State) -> Friction:
        """See `Stepper.friction`."""
        c, sliding, scale = self.contact_at(level.T), self.case.motion.sliding(level.T), self.geometry.hertz_load
        load = (level.load + level.outside) / scale
        P_f, H, P_asperity = jax.device_put((level.P_f, level.H, level.fields.get("P_asperity")))
        return account.friction_program(self.setting.space, c, P_f, H, sliding, load, scale, P_asperity)

    def whole(self, field: Array, odd: bool = False) -> Array:
        """A field of a level on the whole plane, or along a line."""
        return shown(np.asarray(field), self.grid.even, odd)  # type: ignore[arg-type]


@jax.jit
def _squeezed(
    c: Contact, P: Array, approach: float, uplift: float, layer: Array | None
) -> tuple[dict[str, Array], Array]:
    """The fields of a ball that comes near, and its load.  layer: of oil, None where the gap is full."""
    H = contact.film_thickness(c, P, approach) + uplift
    oil = contact.mass(c, P, H)
    oil = oil if layer is None else jnp.minimum(oil, layer)
    return state.level_fields(P, None if c.asperities is None else P, H, oil), contact.pressure_load(c, P)


@jax.jit
def solve_step(p: StepProblem) -> StepSolution:
    """The fields and the numbers after one step."""
    s, known, masses = p.setting, Known.of(p.known), [level["mass"] for level in p.past[:2]]
    pressures = [own_pressure(level) for level in p.past[:2]]
    bent = s.gap, known.curvatures[1:3] - known.curvatures[3]
    p = p if p.flow is None else replace(p, flow=p.flow.beside(pressures[0], masses[0]))
    rate = rate_in_time(known.rates, masses, p.flow, p.contact.spacing, pressures, bent)
    P = _weighted(known.predict, [own_pressure(level) for level in p.past])
    P_old, H_old = own_pressure(p.past[0]), p.past[0]["H"]
    # The viscosity is exponential, so Newton needs few iterations to lower a pressure and many to raise it from zero.
    # So the prediction limits the fall.
    P = stencils.inside(jnp.maximum(P, (1.0 - MAX_PRESSURE_DROP) * P_old), p.contact.even) + jnp.asarray(p.edge)
    P_f = None
    if p.contact.asperities is not None:
        P_f, carried = P, _weighted(known.predict, [level["P_asperity"] for level in p.past])
        P = P_f + stencils.inside(jnp.maximum(carried, 0.0), p.contact.even)
    # a residual r leaves the mass r/rate.new over in this step
    allowed = s.tolerance * rate.new * (s.film_scale + jnp.abs(H_old))
    problem = Problem(
        replace(p.contact, gap=p.contact.gap + known.uplift),
        s.elastic,
        rate,
        known.line.less(known.load_around),
        allowed,
        LOAD_TOLERANCE * s.tolerance,
        p.algorithms,
        Surroundings(p.edge_change, known.load_change, known.uplift_change),
    )
    predicted = known.predict @ known.approaches
    solution, approach = (p.middle.solve if p.middle else nonlinear.solve)(problem, P, predicted, P_f)
    more = approach - predicted
    known = known._replace(
        load_around=known.load_around + more * known.load_change, uplift=known.uplift + more * known.uplift_change
    )
    oil = contact.oil_there(p.contact, solution.own, solution.H, solution.left, rate)
    fields = state.level_fields(solution.P, solution.Q, solution.H, oil)
    return StepSolution(fields, state.packed(_numbers(p, known, rate, solution, fields, approach)))


_step_program, _touch_terms = Program(solve_step), jax.jit(account.touch_terms)


def _numbers(
    p: StepProblem, known: Known, rate: Rate, s: newton.Solution, fields: Mapping[str, Array], approach: Array
) -> dict[str, Any]:
    """The numbers of the step, see `StepSolution`."""
    c, mass, setting = replace(p.contact, flow=s.shared), fields["mass"], p.setting
    U = 0.0 if p.flow is None else p.flow.entrainment
    values = state.key_values(setting.space, s.P, s.H)
    load = values.pop("load")
    F = (load + known.load_around) / setting.hertz_load
    gap_change = U * setting.gap_slope - p.roughness_change
    if setting.gap is not None:
        new, *earlier = known.curvatures[:3]
        gap_change += U * (new - 1.0) * setting.gap_slope + rate_of_change(known.rates, new, earlier) * setting.gap
    moment = Moment(approach, U, known.sliding, gap_change, F, setting.hertz_load)
    changes = mass, rate.of(mass, c.spacing), rate.through, fields.get("P_asperity")
    terms, _ = account.account(setting.space, c, s.own, s.H, moment, *changes)
    predicted = _weighted(known.predict, [level["mass"] for level in p.past])
    weight = stencils.inside(s.P, c.even)  # the edge is given
    error = state.film_error(mass, predicted, weight, state.THIN * setting.film_scale, c.even, setting.coarsenings)
    velocity = rate_of_change(known.rates, approach, known.approaches)
    # half a cell around the grid counts as outside
    beyond = Surroundings(p.edge, known.load_around + load - terms["load"], known.uplift)
    load_rate = rate_of_change(known.rates, load, known.loads)
    beyond_middle, ended = stencils.beyond_middle(s.P, c.even), (s.converged, s.newton, s.krylov)
    numbers = state.StepNumbers(approach, velocity, load, known.load_around, error, beyond_middle, *ended)
    of_account = account.with_outside(terms, velocity, beyond, setting.hertz_load, load_rate)
    return {**numbers._asdict(), **values, "F": F, **of_account}


def _weighted(weights: bdf.Weights, fields: Sequence[Array]) -> Array:
    return jnp.tensordot(jnp.asarray(weights), jnp.stack(fields), axes=1)
