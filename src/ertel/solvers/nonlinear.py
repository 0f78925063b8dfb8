"""One solve on the 2-D grid: P and Delta at a new time level or in the steady state, for impact and rolling.

The equation is always `contact.residual`, and the closure is always one linear equation (`approach.ClosureLine`).  The
system is closed in one of two ways.  With inertia, Delta has a weight in the closure and is eliminated.  With a
balanced load it has none, and Newton's iteration solves for Delta as one more unknown.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, tree
from jax.tree_util import register_dataclass

from ertel.equations import contact
from ertel.equations.approach import ClosureLine
from ertel.equations.contact import Contact, PressureFlow
from ertel.equations.flow import Rate, downstream, flow_aligned, upstream_of, void_change
from ertel.equations.linearised import linear_film
from ertel.equations.outside import UNCHANGED, Surroundings
from ertel.equations.touch import TOUCHING, Asperities
from ertel.numerics import halfspace, multigrid, newton, stencils
from ertel.numerics.grid import Grid, Symmetry
from ertel.numerics.line_smoother import line_smoother
from ertel.numerics.stencils import FloatLike

PRECISION = "float32"  # of the preconditioner
INFLOW = 3.0  # weight of what flows into a cavity: a mean around a node counts the cavity on both sides of the node
HOLDING = 20  # Newton iterations after which a starved film is kinked where it is: it may fill and empty nodes in turns
NOTABLE = 1e-9  # of p_h: a pressure of asperities outside the middle of a grid
LOAD_WEIGHT = 200.0  # weight of the load misfit relative to the residual: every search keeps the load


@register_dataclass
@dataclass(frozen=True)
class Problem:
    """The equations at the new level, their tolerances, and the algorithms that solve them.

    contact, rate, line: the surfaces, the rate of change following the flow, the closure's line.
    tolerance: of Reynolds' equation at each node, (n, n) or a number.  load_tolerance: of a line with Delta unknown.
    elastic: the deformation operators of the preconditioner's grids.  outside: the change of the oil outside with
    Delta, from the first guess of an unknown Delta.
    """

    contact: Contact
    elastic: tuple[multigrid.DeformationOperator, ...]
    rate: Rate
    line: ClosureLine
    tolerance: FloatLike
    load_tolerance: FloatLike
    algorithms: "Algorithms" = field(metadata={"static": True})
    outside: Surroundings = UNCHANGED


# from P_f, H, the free nodes, and P where asperities touch
Preconditioner = Callable[[Problem, Array, Array, Array, Array | None], newton.Inverse]
MakeSmoother = Callable[[multigrid.DeformationOperator, multigrid.Coefficients], multigrid.Smoother]
CloseSystem = Callable[[Problem, Array, FloatLike], "ClosedSystem"]  # from the first guess of P and Delta


class Algorithms(NamedTuple):
    """The closure of the system, the approximate inverse of its Jacobian, and the limits of the iterations."""

    close: CloseSystem
    preconditioner: Preconditioner
    options: newton.Options


class ClosedSystem(NamedTuple):
    """The system in the form for Newton's iteration: the first H, the change of H with P, and the border, if any.

    approach: Delta from the solution.
    """

    H: Array
    film_change: newton.Map
    border: newton.Border
    approach: Callable[[newton.Solution], Array]


class Shared(NamedTuple):
    """The part of an iteration that the residual and its inverse share.

    flow: at the film.  kinked: the nodes at which a starved film is kinked.  times: iterations before.
    """

    flow: PressureFlow
    kinked: Any  # None of any other film
    times: Array


@dataclass(frozen=True)
class SolidPart(newton.Part):
    """The part of the pressure that asperities carry, for Newton's iteration.

    unit: of the residual, per pressure of one node.  alone: the deformation of a node by its own pressure.
    """

    asperities: Asperities
    unit: FloatLike
    alone: FloatLike
    even: Symmetry

    def pressure(self, H: Array) -> Array:
        return self.asperities.pressure(H)

    def tangent(self, P: Array, H: Array) -> newton.Tangent:
        return self.asperities.tangent(P, H)

    def active(self, P: Array, H: Array, free: Array) -> Array:
        """1 where the pressure may change."""
        may = (free > 0.0) | (P > 0.0) | (self.pressure(H) > TOUCHING)
        return stencils.inside(jnp.where(may, 1.0, 0.0), self.even)

    def held(self, P: Array, H: Array, free: Array) -> Array:
        may = self.active(P, H, free) * (1.0 - free)
        return may * self.unit / (1.0 + self.tangent(P, H).stiffness * self.alone)


def _solid_part(problem: Problem) -> SolidPart | None:
    c, rate = problem.contact, problem.rate
    if c.asperities is None:
        return None
    unit = rate.new * c.spacing + (0.0 if rate.wedge is None else rate.wedge)
    return SolidPart(c.asperities, unit, problem.elastic[0].near[0, 0].astype(c.gap.dtype), c.even)


@jax.jit
def solve(problem: Problem, P: Array, approach: FloatLike, P_f: Array | None = None) -> tuple[newton.Solution, Array]:
    """P, H and Delta from a first guess of P and Delta (which is not used where Delta follows from P).

    P_f: the pressure of the oil, where asperities touch.  `shared` of the solution is the flow in its film; of a steady
    film, whose program is exported, where it is kinked.
    """
    turned = partial(flow_aligned, problem.rate)
    problem, P, P_f = _flow_aligned(problem), turned(P), turned(P_f)
    how, c = problem.algorithms, problem.contact
    closed = how.close(problem, P, approach)

    def residual(P_f: Array, H: Array, at: Shared) -> Array:
        return contact.residual(replace(c, flow=at.flow), P_f, H, problem.rate._replace(held=at.kinked))

    def inverse(P_f: Array, H: Array, free: Array, P: Array | None, at: Shared) -> newton.Inverse:
        now = replace(problem, contact=replace(c, flow=at.flow), rate=problem.rate._replace(held=at.kinked))
        return how.preconditioner(now, P_f, H, free, P)

    def shared(P_f: Array, H: Array, last: Shared | None) -> Shared:
        flow, kinked = (last.flow if last else c.flow).at(c, P_f, H), problem.rate.kinked(P_f)
        if last is None or kinked is None:
            return Shared(flow, kinked, jnp.zeros((), int))
        return Shared(flow, jnp.where(last.times < HOLDING, kinked, last.kinked), last.times + 1)

    fill = partial(filled, problem)
    system = newton.NewtonKrylov(
        residual,
        closed.film_change,
        inverse,
        problem.tolerance,
        how.options,
        closed.border,
        fill,
        shared,
        _solid_part(problem),
    )
    solution = system.solve(P, closed.H, P_f)
    fields = {name: turned(getattr(solution, name)) for name in ("P", "Q", "H", "left")}
    flow_there = solution.shared.flow if problem.rate.wedge is None else turned(solution.shared.kinked)
    return solution._replace(**fields, shared=flow_there), closed.approach(solution)


class Middle(NamedTuple):
    """The elastic kernels of the middle of a grid, as in `Contact` and in `Problem`."""

    kernel: halfspace.Kernel
    elastic: tuple[multigrid.DeformationOperator, ...]

    def solve(
        self, problem: Problem, P: Array, approach: FloatLike, P_f: Array | None = None
    ) -> tuple[newton.Solution, Array]:
        """As the function `solve`, for a film with P = 0 outside the middle, at a quarter of the cost.

        A residual outside that asks for pressure there counts as one that is left.
        """
        c, rate = problem.contact, problem.rate
        middle = stencils.middle(P.shape, c.even)
        inner = replace(
            problem,
            contact=replace(c, gap=c.gap[middle], kernel=self.kernel),
            elastic=self.elastic,
            rate=rate._replace(past=jnp.asarray(rate.past)[middle]),
            tolerance=jnp.asarray(problem.tolerance)[middle],
            outside=problem.outside._replace(edge=0.0),  # P = 0 there
        )
        solution, found = solve(inner, P[middle], approach, None if P_f is None else P_f[middle])
        zero, Q = jnp.zeros_like(P), solution.Q
        P = zero.at[middle].set(solution.P)
        H = contact.film_thickness(c, P, found)
        solution = solution._replace(P=P, Q=None if Q is None else zero.at[middle].set(Q), H=H)
        flow = c.flow.at(c, solution.own, H)
        left = contact.residual(replace(c, flow=flow), solution.own, H, rate)
        residual = jnp.maximum(solution.residual, newton.largest_residual(solution.own, left, problem.tolerance))
        if c.asperities is not None:  # they may touch outside too
            elsewhere = c.asperities.pressure(H).at[middle].set(0.0).max()
            residual = jnp.where(elsewhere > NOTABLE, jnp.inf, residual)
        return solution._replace(left=left, shared=flow, residual=residual), found


def filled(problem: Problem, r: Array) -> Array:
    """Negative where the oil fills a cavity.  r: the residual in the cavity, zero elsewhere.

    At the edge of a cavity r < 0 is oil that flows in; further inside r > 0 is what the cavity takes up.  The oil
    reaches as far as the two balance: where a mean value of r is negative.  If only the nodes with r < 0 were freed,
    the edge would move by one node per iteration.
    """
    balance = INFLOW * jnp.minimum(r, 0.0) + jnp.maximum(r, 0.0)
    return multigrid.lowest_mean(balance, problem.contact.even, len(problem.elastic) - 1)


def _flow_aligned(problem: Problem) -> Problem:
    """The problem with X in the direction of entrainment, where the rate has one."""
    if problem.rate.wedge is None:
        return problem
    turned, c = partial(flow_aligned, problem.rate), problem.contact
    return replace(
        problem,
        contact=replace(c, gap=turned(c.gap), flow=c.flow.turned(turned)),
        rate=problem.rate._replace(past=turned(problem.rate.past), wedge=jnp.abs(problem.rate.wedge)),
        tolerance=turned(problem.tolerance),
    )


def convolutions(grid: Grid, newton_iterations: int, krylov_iterations: int) -> float:
    """Work in convolutions on this grid (one on a coarser grid counts by its nodes).

    One for the first film, one each Newton iteration, one and a V-cycle each Krylov iteration.
    """
    return 1 + newton_iterations + krylov_iterations * (1 + multigrid.v_cycle_convolutions(grid))


# -- Delta ------------------------------------------------------------------------------------------------------------


def eliminate_approach(problem: Problem, P: Array, approach: FloatLike) -> ClosedSystem:
    """Eliminate Delta, for a closure in which Delta has a weight."""
    c, line = problem.contact, problem.line

    def of(P: Array) -> Any:
        return line.approach(contact.pressure_load(c, P))

    def film_change(dP: Array) -> Array:
        rise = line.load_weight * contact.pressure_load(c, dP) / line.approach_weight
        return contact.deformation(c, dP) + rise

    return ClosedSystem(contact.film_thickness(c, P, of(P)), film_change, newton.NO_BORDER, lambda s: of(s.P))


def approach_as_unknown(problem: Problem, P: Array, approach: FloatLike) -> ClosedSystem:
    """Delta as one more unknown, with the closure as its equation."""
    c, line, outside, first = problem.contact, problem.line, problem.outside, approach

    def misfit(P: Array, approach: Array) -> Array:
        load = contact.pressure_load(c, P) + outside.load * (approach - first)
        return line.approach_weight * approach + line.load_weight * load - line.value

    def film_change(dP: Array) -> Array:
        return contact.deformation(c, dP)

    weight = LOAD_WEIGHT * (1.0 + problem.rate.new) / c.spacing
    border = newton.Border(approach, outside.uplift - 1.0, misfit, problem.load_tolerance, weight, outside.edge)
    return ClosedSystem(contact.film_thickness(c, P, approach), film_change, border, lambda s: s.s)


# -- approximate inverses of the Jacobian: a V-cycle in single precision, with one of two smoothers --------------------
#
# * Steps in time have no derivative along X: a change at a node stays near it, and nodes are relaxed one by one.
# * A steady film has the wedge U dm/dX: a change travels downstream, and all nodes of a line along X are solved
#   together.
#
# On the finest grid the V-cycle has the Jacobian itself, from `equations.linearised`.  Single precision is enough,
# because the Krylov iteration keeps its residual in double precision (`newton.gcr`).


def point_preconditioner(problem: Problem, P_f: Array, H: Array, free: Array, P: Array | None) -> newton.Inverse:
    """V-cycle with the point smoother, for a rate without a wedge: every step in time."""
    return preconditioned(problem, P_f, H, free, P, problem.rate.new, multigrid.point_smoother)


def line_preconditioner(problem: Problem, P_f: Array, H: Array, free: Array, P: Array | None) -> newton.Inverse:
    """V-cycle with the line smoother along the direction of entrainment, for a film with a wedge."""
    drift = 0.0 if problem.rate.wedge is None else problem.rate.wedge
    smoother = partial(line_smoother, rate=problem.rate.new, drift=drift)
    return preconditioned(problem, P_f, H, free, P, 1.0, smoother)


def preconditioned(
    problem: Problem,
    P_f: Array,
    H: Array,
    free: Array,
    P: Array | None,
    rate: Array | float,
    smoother: MakeSmoother,
) -> newton.Inverse:
    """A V-cycle with a smoother; rate: of the mass, where the smoother adds none of its own."""
    levels = multigrid_levels(problem, P_f, H, free, rate, smoother, P)
    finest, inverse, touch = levels[0].coefficients, partial(multigrid.precondition, levels), _solid_part(problem)
    if finest.springs is None or P is None or touch is None:
        return newton.Inverse(inverse)
    hold, held = finest.hold(problem.elastic[0]), touch.held(P, H, free)
    weight = finest.springs.unit / hold
    rows = jnp.where(held > 0.0, held / hold, weight)
    return newton.Inverse(lambda r: inverse(r / rows), weight)


def multigrid_levels(
    problem: Problem,
    P_f: Array,
    H: Array,
    free: Array,
    rate: Array | float,
    smoother: MakeSmoother,
    P: Array | None = None,
) -> tuple[multigrid.GridLevel, ...]:
    """The V-cycle's grids for the Jacobian, on the finest grid the exact one."""
    precision, c = problem.elastic[0].near.dtype, problem.contact
    film = linear_film(c, P_f, H).in_precision(precision)
    single = partial(jnp.asarray, dtype=precision)
    free = single(stencils.inside(free, c.even))
    rate, new, wedge = tree.map(single, (rate, problem.rate.new, problem.rate.wedge))
    zero, in_time, kinked = jnp.zeros_like(film.P), Rate(new, 0.0, wedge), problem.rate.kinked(P_f)
    springs, active, touch = None, free, _solid_part(problem)
    if P is not None and touch is not None:
        stiff = single(touch.tangent(P, H).stiffness)
        springs = multigrid.Springs(stiff, free, single(touch.unit) * jnp.ones_like(stiff))
        active = single(touch.active(P, H, free))
    mass = film.by_H.mass, film.by_P.mass
    finest = multigrid.Coefficients(film.eps, rate * mass[0], rate * mass[1], active, film.steepening, springs)

    # what does not depend on the change is computed once
    def change(e: Array, Ke: Array) -> Array:
        q = finest.carried(e, Ke)
        dP = q if springs is None else free * q
        r = film.residual(dP, Ke, lambda m: in_time.of(m, film.spacing, kinked))
        if kinked is not None:
            first = downstream(film.change(dP, Ke).mass[:, :2], kinked[:, :2])[:, 0]
            void = void_change(1.0 - free, r * film.spacing / wedge, first)
            r = stencils.inside(r + wedge * upstream_of(void) / film.spacing, c.even)
        return finest.with_held(problem.elastic[0], r, q)

    _, jacobian = jax.linearize(change, zero, zero)
    return multigrid.hierarchy(problem.elastic, finest, smoother, jacobian)
