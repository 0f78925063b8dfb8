"""Steady rolling on the 2-D grid: `contact`'s residual without squeeze, with a given load, coarse grid first.

The unknowns are P and the approach Delta; Newton's iteration carries both.  A solution on a coarse grid is the first
guess on the next finer one (nested iteration), and tells the error of the film at no cost.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from ertel import contact, halfspace, lines, multigrid, newton
from ertel.closure import STATIC_LOAD, ClosureLine
from ertel.contact import Contact, Rate
from ertel.grid import Grid, check_nodes
from ertel.lubricant import Lubricant
from ertel.multigrid import Elasticity
from ertel.status import Status

PRECONDITIONER_PRECISION = "float64"  # single loses its way at high load: M = 3000 on 513 nodes
FIRST_GRID = 33  # nodes a side from which nested iteration starts, or the next that the finest grid allows
LENGTH, INLET = 6.0, 4.5  # of the domain and of its part upstream of the centre, in units a
LEAST_FILM = 0.5  # share of the coarse grid's smallest film that a first guess keeps
OPTIONS = newton.Options(krylov_limit=30)
STEADY = Rate(0.0, 0.0)


def flooded_grid(nodes: int, entrainment: float = 1.0) -> Grid:
    """nodes x nodes on [-4.5, 1.5] x [-3, 3], or its mirror image where the oil moves towards - X."""
    centre = LENGTH / 2 - INLET
    return Grid(nodes, LENGTH / (nodes - 1), centre_x=centre if entrainment >= 0 else -centre)


@dataclass(frozen=True)
class GridSolution:
    """The steady contact on one grid: fields (nodes, nodes), approach in a^2/R, how it ended, and the work it took."""

    grid: Grid
    P: Array
    H: Array
    approach: float
    residual: float
    status: Status
    newton: int
    krylov: int
    convolutions: float

    def measure(self) -> dict[str, float]:
        """Films and pressures: H_c, P_c at (0, 0), H_min the smallest at a node where P > 0, and where that is."""
        column, row = (int(abs(axis).argmin()) for axis in (self.grid.x, self.grid.y))
        least = int(jnp.argmin(jnp.where(self.P > 0.0, self.H, jnp.inf)))
        i, j = divmod(least, self.grid.nodes)
        return {
            "H_c": float(self.H[row, column]),
            "H_min": float(self.H[i, j]),
            "X_min": float(self.grid.x[j]),
            "Y_min": abs(float(self.grid.y[i])),
            "Delta": self.approach,
            "P_c": float(self.P[row, column]),
            "P_max": float(self.P.max()),
            "load": float(jnp.sum(self.P)) * self.grid.spacing**2,
        }


class Extrapolation(NamedTuple):
    """A value on the finest grid, an estimate of its error there, and the value extrapolated to zero spacing."""

    value: float
    error: float
    extrapolated: float


@dataclass(frozen=True)
class Rolling:
    """The solutions on all grids, coarsest first."""

    solutions: tuple[GridSolution, ...]

    @property
    def finest(self) -> GridSolution:
        return self.solutions[-1]

    @property
    def convolutions(self) -> float:
        """The work on all grids, in convolutions on the finest."""
        return sum(s.convolutions * (s.grid.nodes / self.finest.grid.nodes) ** 2 for s in self.solutions)

    def extrapolate(self, name: str) -> Extrapolation:
        """A quantity of `measure` by Richardson's extrapolation: the error falls with the square of the spacing."""
        coarse, fine = (s.measure()[name] for s in self.solutions[-2:])
        return Extrapolation(fine, abs(fine - coarse) / 3, fine + (fine - coarse) / 3)


def steady(
    lambda_bar: float,
    lubricant: Lubricant,
    nodes: int = 257,
    entrainment: float = 1.0,
    tolerance: float = 1e-8,
) -> Rolling:
    """The smooth circular contact under its static load; tolerance bounds the residual of Reynolds' equation.

    entrainment is U: 1, or -1 for oil that moves towards -X.
    """
    check_nodes(nodes)
    grids = [flooded_grid(nodes, entrainment)]
    while (grids[-1].nodes - 1) // 2 + 1 >= FIRST_GRID:
        grids.append(grids[-1].coarser())
    solutions: list[GridSolution] = []
    for grid in reversed(grids):
        c = contact.ball_on_plane(grid, lambda_bar, lubricant)
        P, approach = first_guess(c, solutions[-1]) if solutions else hertz_pressure(grid, STATIC_LOAD)
        solutions.append(solve(grid, c, P, approach, STATIC_LOAD, entrainment, tolerance))
    return Rolling(tuple(solutions))


def hertz_pressure(grid: Grid, line: ClosureLine) -> tuple[Array, float]:
    """Pressure and approach of the dry contact, its load made that of the line on this grid."""
    P = jnp.sqrt(jnp.maximum(1.0 - grid.x[None, :] ** 2 - grid.y[:, None] ** 2, 0.0))
    return P * (line.value / line.load_weight / (jnp.sum(P) * grid.spacing**2)), 1.0


def first_guess(c: Contact, coarse: GridSolution) -> tuple[Array, float]:
    """Pressure and approach from twice the spacing; the bodies are moved apart where they would overlap."""
    P = multigrid.prolong(coarse.P)
    least = LEAST_FILM * max(coarse.measure()["H_min"], 0.0)
    overlap = least - float(contact.film_thickness(c, P, coarse.approach).min())
    return P, coarse.approach - max(overlap, 0.0)


def solve(
    grid: Grid, c: Contact, P: Array, approach: float, line: ClosureLine, entrainment: float, tolerance: float
) -> GridSolution:
    """The steady solution on one grid from a first guess of P and the approach."""
    elastic = multigrid.elasticities(grid, PRECONDITIONER_PRECISION)
    s = _solve(c, elastic, P, approach, line, entrainment, tolerance)
    status = Status.CONVERGED if bool(s.converged) else Status.NEWTON_STALLED
    n, k = int(s.newton), int(s.krylov)
    work = convolutions(grid, n, k)
    return GridSolution(grid, s.P, s.H, float(s.s), float(s.residual) * tolerance, status, n, k, work)


def convolutions(grid: Grid, newton_iterations: int, krylov_iterations: int) -> float:
    """Work in convolutions on this grid: a V-cycle each Krylov iteration, and one each Newton iteration for Delta."""
    v_cycle = multigrid.v_cycle_convolutions(grid)
    return 1 + newton_iterations * (1 + v_cycle) + krylov_iterations * (1 + v_cycle)


@jax.jit
def _solve(
    c: Contact,
    elastic: tuple[Elasticity, ...],
    P: Array,
    approach: Array | float,
    line: ClosureLine,
    entrainment: Array | float,
    tolerance: float,
) -> newton.Solution:
    def residual(P: Array, H: Array) -> Array:
        return contact.residual(c, P, H, STEADY, entrainment)

    def film_change(dP: Array) -> Array:
        return halfspace.displacement(c.kernel, dP)

    def preconditioner(P: Array, H: Array, free: Array) -> newton.Map:
        return _preconditioner(c, elastic, P, H, free, entrainment)

    def misfit(P: Array, approach: Array) -> Array:
        return line.approach_weight * approach + line.load_weight * contact.load(c, P) - line.value

    H = contact.film_thickness(c, P, approach)
    border = newton.Border(approach, -1.0, misfit, tolerance, 1.0 / c.spacing)
    return newton.solve(residual, film_change, preconditioner, P, H, tolerance, OPTIONS, border)


def _preconditioner(
    c: Contact, elastic: Sequence[Elasticity], P: Array, H: Array, free: Array, entrainment: Array | float
) -> newton.Map:
    density, slope = jax.jvp(c.lubricant.density, (P,), (jnp.ones_like(P),))
    precision = elastic[0].spectrum.dtype
    speed = jnp.abs(entrainment)

    def downstream(f: Array) -> Array:
        """The lines in the direction of the flow (and, by the same reversal, back again)."""
        return jnp.where(entrainment >= 0, f, f[:, ::-1])

    def smoother(e: Elasticity, coefficients: multigrid.Coefficients) -> lines.Lines:
        return lines.lines(e, coefficients, 0.0, speed)

    finest = (contact.mobility(c, P, H), density, slope * H, contact.inside(free))
    coefficients = multigrid.Coefficients(*(downstream(f).astype(precision) for f in finest))
    levels = multigrid.hierarchy(elastic, coefficients, smoother)
    return lambda r: downstream(multigrid.precondition(levels, downstream(r)))
