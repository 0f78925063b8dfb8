"""The 2-D grid in time: one BDF step of `contact`'s residual, for an impact, for rolling, and for both at once."""

from collections.abc import Callable, Sequence
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ertel.model import contact, discretise
from ertel.model.approach import HERTZ_LOAD, Closure, ClosureLine, NewtonsLaw
from ertel.model.case import Case
from ertel.model.contact import Contact, Rate
from ertel.model.measure import measure
from ertel.model.state import Attempt, Level
from ertel.model.status import Status
from ertel.numerics import bdf, multigrid, newton
from ertel.numerics.grid import check_nodes
from ertel.numerics.multigrid import Elasticity
from ertel.numerics.symmetry import Even, total, unfolded
from ertel.solvers import nonlinear, steady
from ertel.solvers.nonlinear import Close, Preconditioner, Problem

THIN = 0.1  # of the film scale: below this the time error of a film is not taken relative to itself
STEEPEST_FALL = 0.6  # share of the last pressure that the prediction keeps at least
LOAD_SHARE = 0.01  # of the tolerance, is left over in a balanced load (relative)
# Krylov: 3 or 4 are needed, and each has its two fields.  Newton: cavitation advances a node in one iteration
OPTIONS = newton.Options(newton_limit=100, krylov_limit=10)
SolveStep = Callable[..., tuple[newton.Solution, Array]]


class Transient2D:
    """The methods "2d" and "transient": see `level.Method`.

    An impact starts with the bodies apart, rolling from its steady film.  closure is the law for Delta: Newton's law
    with the case's load and inertia unless another is given.  solve_step: in place of `solve_on_device`, with the
    same arguments and results (`batch` solves the steps of many cases at once).
    """

    def __init__(self, case: Case, closure: Closure | None = None, solve_step: SolveStep | None = None):
        check_nodes(case.solver.nodes)
        self.case = case
        self.grid = discretise.grid_of(case)
        self.contact = contact.ball_on_plane(self.grid, case.parameters.lambda_bar, case.lubricant)
        self.closure = closure or NewtonsLaw.of(case.motion)
        self.preconditioner = nonlinear.carried if case.motion.flows else nonlinear.still
        self.elastic = multigrid.elasticities(self.grid, nonlinear.PRECONDITIONER_PRECISION)
        self.coordinates = {"Y": self.grid.y, "X": self.grid.x}
        self._solve_step = solve_step or solve_on_device

    def start(self) -> Attempt:
        """The bodies apart, moving in with unit speed, no pressure yet; or the steady film with the motion at T = 0."""
        if not self.case.starts_apart:
            rolling = steady.steady(self.case)
            s = rolling.finest
            level = Level(0.0, s.approach, 0.0, s.P, s.H)
            return Attempt(level, s.status, s.newton, s.krylov, rolling.convolutions)
        c, approach = self.contact_at(0.0), self.case.schedule.start_approach
        P = jnp.zeros(self.grid.shape)
        level = Level(0.0, approach, 1.0, P, c.gap - approach)  # nothing is deformed yet
        return Attempt(level, Status.CONVERGED, 0, 0, 1.0)

    def contact_at(self, T: float) -> Contact:
        """The surfaces and the oil at time T."""
        return discretise.moved(self.contact, self.case, self.grid, T)

    def advance(self, levels: Sequence[Level], step: float) -> Attempt:
        """One BDF step (BDF1 from one level, BDF2 from more)."""
        T = levels[0].T + step
        times = [level.T for level in levels]
        rates = bdf.derivative_weights([T, *times[:2]])
        approaches = [level.approach for level in levels]
        line = self.closure.line(T, rates, approaches, [level.velocity for level in levels])
        padded = [*levels, *[levels[-1]] * 2][:3]  # one shape, so one compilation, whatever the history
        predict = bdf.interpolation_weights(T, times)
        solution, approach = self._solve_step(
            self.contact_at(T),
            self.elastic,
            jnp.stack([level.P for level in padded]),
            jnp.stack([level.H for level in padded]),
            float(predict @ approaches),
            _pad(predict),
            _pad(rates),
            line,
            self.case.motion.entrainment(T),
            self.case.solver.tolerance,
            self.case.film_scale,
            close=nonlinear.eliminated if line.approach_weight else nonlinear.bordered,
            preconditioner=self.preconditioner,
        )
        n, k = int(solution.newton), int(solution.krylov)
        approach = float(approach)
        velocity = self.closure.velocity(T, rates, approach, approaches)
        status = Status.CONVERGED if bool(solution.converged) else Status.NEWTON_STALLED
        work = nonlinear.convolutions(self.grid, n, k)
        return Attempt(Level(T, approach, velocity, solution.P, solution.H), status, n, k, work)

    def measure(self, level: Level) -> dict[str, float]:
        """Load, pressures and films of one level; without entrainment X_min is the radius of the least film."""
        values = measure(self.grid, level.P, level.H)
        values["F"] = values.pop("load") / HERTZ_LOAD
        if not self.case.motion.flows:
            values |= {"X_min": float(np.hypot(values["X_min"], values["Y_min"])), "Y_min": 0.0}
        return values

    def whole(self, field: Array) -> Array:
        """A field of a level on the whole plane."""
        return unfolded(field, self.grid.even)

    def film_error(self, H: Array, H_predicted: Array, P: Array) -> float:
        """Relative difference of two films, root mean square over the load that P carries."""
        return float(_film_error(H, H_predicted, P, THIN * self.case.film_scale, self.grid.even))


def _pad(weights: np.ndarray) -> np.ndarray:
    return np.pad(weights, (0, 3 - len(weights)))


@partial(jax.jit, static_argnames="even")
def _film_error(H: Array, H_predicted: Array, P: Array, thin: float, even: Even) -> Array:
    relative = (H - H_predicted) / (jnp.abs(H) + thin)
    return jnp.sqrt(total(P * relative**2, even) / jnp.maximum(total(P, even), jnp.finfo(P.dtype).tiny))


@partial(jax.jit, static_argnames=("close", "preconditioner"))
def solve_on_device(
    c: Contact,
    elastic: tuple[Elasticity, ...],
    P_old: Array,
    H_old: Array,
    approach: float,
    predict: Array,
    rates: Array,
    line: ClosureLine,
    entrainment: float,
    tolerance: float,
    film_scale: float,
    *,
    close: Close,
    preconditioner: Preconditioner,
) -> tuple[newton.Solution, Array]:
    """P, H and Delta after one step.

    P_old, H_old: of the last three levels, newest first, shape (3, n, n), with the weights of the prediction and of the
    time derivative (for the new level, and the last two), both of shape (3,).
    """
    mass = contact.mass(c, P_old[:2], H_old[:2])
    rate = Rate(rates[0], jnp.tensordot(rates[1:], mass, axes=1))
    P = jnp.tensordot(predict, P_old, axes=1)
    # Newton comes down to a small pressure in few iterations and up from none in many (the viscosity is exponential),
    # and a free boundary retreats in one and advances a node at a time: so predict no steep fall
    P = jnp.maximum(P, STEEPEST_FALL * P_old[0])
    # a residual r adds r/rates[0] to the film in this step
    allowed = tolerance * rates[0] * (film_scale + jnp.abs(H_old[0]))
    problem = Problem(rate, entrainment, line, allowed, LOAD_SHARE * tolerance)
    return nonlinear.solve(
        c, elastic, problem, P, approach, close=close, preconditioner=preconditioner, options=OPTIONS
    )
