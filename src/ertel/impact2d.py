"""Impact on the 2-D grid: one time step of `contact`'s residual, with a closure for Delta."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ertel import bdf, contact, halfspace, multigrid, newton
from ertel.case import Case
from ertel.closure import FREE_BALL, HERTZ_LOAD, Closure, ClosureLine
from ertel.contact import Contact, Rate
from ertel.grid import Grid, check_nodes
from ertel.level import Attempt, Level
from ertel.multigrid import Elasticity
from ertel.status import Status

PRECONDITIONER_PRECISION = "float32"
THIN = 0.1  # of the trapped film: below this the time error of a film is not taken relative to itself
STEEPEST_FALL = 0.6  # share of the last pressure that the prediction keeps at least


class Impact2D:
    """The method "2d": see `level.Method`.  closure is the law for Delta: the free ball's unless another is given."""

    def __init__(self, case: Case, closure: Closure = FREE_BALL):
        check_nodes(case.solver.nodes)
        self.grid = Grid.square(case.solver.nodes, case.solver.half_width)
        self.contact = contact.ball_on_plane(self.grid, case.parameters.lambda_bar, case.lubricant)
        self.elastic = multigrid.elasticities(self.grid, PRECONDITIONER_PRECISION)
        self.closure = closure
        self.tolerance = case.solver.tolerance
        self.film_scale = case.parameters.trapped_film
        self.start_approach = case.time.start_approach
        self.coordinates = {"Y": self.grid.y, "X": self.grid.x}

    def start(self) -> Level:
        """The ball apart, moving in with unit speed, no pressure yet."""
        P = jnp.zeros((self.grid.nodes, self.grid.nodes))
        return Level(0.0, self.start_approach, 1.0, P, contact.film_thickness(self.contact, P, self.start_approach))

    def advance(self, levels: Sequence[Level], step: float) -> Attempt:
        """One BDF step (BDF1 from one level, BDF2 from more)."""
        T = levels[0].T + step
        times = [level.T for level in levels]
        rates = bdf.derivative_weights([T, *times[:2]])
        approaches = [level.approach for level in levels]
        line = self.closure.line(T, rates, approaches, [level.velocity for level in levels])
        padded = [*levels, *[levels[-1]] * 2][:3]  # one shape, so one compilation, whatever the history
        solution, approach = _advance(
            self.contact,
            self.elastic,
            jnp.stack([level.P for level in padded]),
            jnp.stack([level.H for level in padded]),
            _pad(bdf.interpolation_weights(T, times)),
            _pad(rates),
            line,
            self.tolerance,
            self.film_scale,
        )
        n, k = int(solution.newton), int(solution.krylov)
        approach = float(approach)
        velocity = self.closure.velocity(T, rates, approach, approaches)
        status = Status.CONVERGED if bool(solution.converged) else Status.NEWTON_STALLED
        return Attempt(Level(T, approach, velocity, solution.P, solution.H), status, n, k, self.convolutions(n, k))

    def measure(self, level: Level) -> dict[str, float]:
        """Load, pressures and films of one level."""
        values = _measure(self.contact, level.P, level.H)
        F, P_c, P_max, H_c, H_min, X_min = (float(v) for v in values)
        return {"F": F, "P_c": P_c, "P_max": P_max, "H_c": H_c, "H_min": H_min, "X_min": X_min}

    def film_error(self, H: Array, H_predicted: Array, P: Array) -> float:
        """Relative difference of two films, root mean square over the load that P carries."""
        return float(_film_error(H, H_predicted, P, THIN * self.film_scale))

    def convolutions(self, newton_iterations: int, krylov_iterations: int) -> float:
        """Work in convolutions on the finest grid (one on a coarser grid counts by its nodes)."""
        return 1 + newton_iterations + krylov_iterations * (1 + multigrid.v_cycle_convolutions(self.grid))


def _pad(weights: np.ndarray) -> np.ndarray:
    return np.pad(weights, (0, 3 - len(weights)))


@jax.jit
def _measure(c: Contact, P: Array, H: Array) -> Array:
    middle = P.shape[0] // 2
    least = jnp.argmin(H)
    # the undeformed gap of a smooth ball is half the squared distance from the centre
    X_min = jnp.sqrt(2.0 * c.gap.ravel()[least])
    values = [contact.load(c, P) / HERTZ_LOAD, P[middle, middle], P.max(), H[middle, middle], H.min(), X_min]
    return jnp.stack(values)


@jax.jit
def _film_error(H: Array, H_predicted: Array, P: Array, thin: float) -> Array:
    relative = (H - H_predicted) / (jnp.abs(H) + thin)
    return jnp.sqrt(jnp.sum(P * relative**2) / jnp.maximum(jnp.sum(P), jnp.finfo(P.dtype).tiny))


@jax.jit
def _advance(
    c: Contact,
    elastic: tuple[Elasticity, ...],
    P_old: Array,
    H_old: Array,
    predict: Array,
    rates: Array,
    line: ClosureLine,
    tolerance: float,
    film_scale: float,
) -> tuple[newton.Solution, Array]:
    mass = c.lubricant.density(P_old[:2]) * H_old[:2]
    rate = Rate(rates[0], jnp.tensordot(rates[1:], mass, axes=1))

    def approach(P: Array) -> Array:
        return (line.value - line.load_weight * contact.load(c, P)) / line.approach_weight

    def residual(P: Array, H: Array) -> Array:
        return contact.residual(c, P, H, rate, 0.0)

    def film_change(dP: Array) -> Array:
        rise = line.load_weight * contact.load(c, dP) / line.approach_weight
        return halfspace.displacement(c.kernel, dP) + rise

    def preconditioner(P: Array, H: Array, free: Array) -> newton.Map:
        return _preconditioner(c, elastic, P, H, free, rate)

    P = jnp.tensordot(predict, P_old, axes=1)
    # Newton comes down to a small pressure in few iterations and up from none in many (the viscosity is exponential),
    # and a free boundary retreats in one and advances a node at a time: so predict no steep fall
    P = jnp.maximum(P, STEEPEST_FALL * P_old[0])
    H = contact.film_thickness(c, P, approach(P))
    # a residual r adds r/rates[0] to the film in this step
    allowed = tolerance * rates[0] * (film_scale + jnp.abs(H))
    solution = newton.solve(residual, film_change, preconditioner, P, H, allowed)
    return solution, approach(solution.P)


def _preconditioner(
    c: Contact, elastic: tuple[Elasticity, ...], P: Array, H: Array, free: Array, rate: Rate
) -> newton.Map:
    density, slope = jax.jvp(c.lubricant.density, (P,), (jnp.ones_like(P),))
    precision = elastic[0].spectrum.dtype
    finest = multigrid.Coefficients(
        contact.mobility(c, P, H), rate.new * density, rate.new * slope * H, contact.inside(free)
    )
    levels = multigrid.hierarchy(elastic, multigrid.Coefficients(*(f.astype(precision) for f in finest)))
    return lambda r: multigrid.precondition(levels, r)
