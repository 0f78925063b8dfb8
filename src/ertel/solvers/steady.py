"""Steady rolling on the 2-D grid: `contact`'s residual where the past is the film upstream, with a given load.

The unknowns are P and the approach Delta; Newton's iteration solves for both.  A solution on a coarse grid is the first
guess on the next finer grid (nested iteration), and gives an error estimate of the film thickness at no extra cost.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from threading import Thread
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.case.estimates import grid_of, largest_film
from ertel.case.status import Status
from ertel.equations import contact, discretise
from ertel.equations.approach import balanced
from ertel.equations.contact import Contact
from ertel.equations.flow import steady_rate
from ertel.equations.state import SteadySolver
from ertel.numerics import multigrid, newton
from ertel.numerics.grid import Grid, check_coarsening, expected_next
from ertel.numerics.programs import Program, double_precision
from ertel.solvers import heat, nonlinear
from ertel.solvers.grid_solution import GridSolution, warm_contact
from ertel.solvers.guesses import motion_of, refined, rough_guess, unbalanced
from ertel.solvers.heat import Rounds, WarmFactors, heated

Floats = NDArray[np.float64]

FIRST_GRID = 33  # nodes a side from which nested iteration starts, or the next that the finest grid allows
FIRST_ROW = 129  # nodes of a line contact from which it starts: each grid is a program
ASTRAY = 0.3  # of the load out of balance, from which the dry contact is a better first guess than the coarser grid
LEAST_FILM = 0.5  # a first guess keeps this fraction of the coarse grid's minimum film thickness
TOLERANCE = 1e-8  # of the residual of the steady film from which a transient run starts
SETTLING = 5  # solves at most until the film and the oil outside agree; each leaves a hundredth, a tenth at low M
OUTSIDE = 1e-4  # of the load: a change of the load outside that leaves the film as it is (H_c by as much at most)
# leaves a tenth of the discretisation error at most (measured, H_c, H_min)
AS_EXACT_AS_THE_GRID = 0.03
SMALL = 2 * 65 * 65  # entries of the largest array on a grid that is solved in less time than its program is optimised
# least: where the tolerance is so loose that the first guess may meet it, one iteration leaves too much
# Krylov: 3 to 6 are needed, a sharp spike on a fine grid wants all; each keeps its two fields; Newton: likewise, 5 to 7
OPTIONS = newton.Options(newton_limit=100, newton_least=2, krylov_limit=18, first_reduction=0.1)
ALGORITHMS = nonlinear.Algorithms(nonlinear.approach_as_unknown, nonlinear.line_preconditioner, OPTIONS)

_program = Program(nonlinear.solve, SMALL)


class SteadyFilm(SteadySolver):
    """The method "steady"."""

    def __init__(self, case: Case):
        self.case, self.grids = fed(case), grids_of(case)[::-1]

    def compile_ahead(self) -> None:
        """See `SteadySolver.compile_ahead`."""
        compile_ahead(self.case)

    def solve(self, done: Sequence[GridSolution]) -> GridSolution:
        """The solution on the next grid."""
        return next(nested(self.case, done))

    def restored(self, number: int, stored: Mapping[str, Any]) -> GridSolution:
        """The solution from what was stored of it."""
        return GridSolution(self.case, self.grids[number], **stored)


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
        return sum(s.convolutions * s.grid.size / self.finest.grid.size for s in self.solutions)


def steady_film(case: Case) -> Rolling:
    """The steady contact with the load and the entrainment of T = 0, on all grids."""
    return Rolling(tuple(nested(case)))


def fed(case: Case) -> Case:
    """The case; with a full inlet where a rolling line contact has a layer of more oil than passes it.

    Nothing leaks to the sides of a line.  So its film is the layer, or the flooded one; the oil that does not pass
    gathers in front of it.  Raises ValueError where more than the layer passes at one time, and less at another one.
    """
    if case.layer is None or case.starts_apart or not case.geometry.is_line:
        return case
    full = replace(case, oil=replace(case.oil, layer=None, layer_1=None, layer_2=None))
    passes = _passing(full)
    most = passes * largest_film(case)
    if passes <= case.layer < most:
        layer = f"lubricant.layer = {case.layer:.3g} a^2/R"
        now_and_later = f"is more than passes at T = 0 ({passes:.3g}), and less than what passes later ({most:.3g})"
        raise ValueError(f"{layer}: {now_and_later}; give a layer that is always one or the other, or leave it out")
    return full if case.layer >= most else case


@lru_cache(maxsize=8)  # a run asks once for each of its parts
def _passing(flooded: Case) -> float:
    """The oil per area that passes a flooded line contact."""
    return steady_film(flooded).finest.account.terms["inflow"] / abs(flooded.motion.entrainment(0.0))


def nested(case: Case, done: Sequence[GridSolution] = ()) -> Iterator[GridSolution]:
    """Solutions from the coarsest grid to the case's own; goes on after those that are done."""
    grids, solutions = grids_of(case), list(done)
    if not done:
        compile_ahead(case)
    for grid in reversed(grids[: len(grids) - len(done)]):
        factors = first_factors(case, grid, solutions)
        c = warm_contact(case, grid, factors)
        if solutions:
            guess: Any = first_guess(c, solutions[-1], expected_next([s.approach for s in solutions]))
            if c.asperities is not None and unbalanced(c, *guess) > ASTRAY:  # a steep law in a very thin film
                guess = rough_guess(case, grid, c)
        else:
            first = solve_on_grid(case, grid, c, *rough_guess(case, grid, c))
            guess = first.P, first.approach, first.P_f  # with the oil outside of the lubricated contact
        solution = _agreeing(c, solve_on_grid(case, grid, c, *guess), OUTSIDE)
        if factors is not None:
            solution = _with_heat(solution, factors, heat.AGREED if grid is grids[0] else heat.AS_A_GUESS)
        solutions.append(_judged(solution) if grid is grids[0] else solution)
        yield solutions[-1]


def first_factors(case: Case, grid: Grid, coarser: Sequence[GridSolution]) -> WarmFactors | None:
    """The factors of a warm film with which the search on a grid starts; None of a film that is solved without heat."""
    if case.thermal is None or not case.thermal.is_solved:
        return None
    known = coarser[-1].factors if coarser and coarser[-1].status.ok else None
    return WarmFactors.of_cold(grid) if known is None else known.finer()


def _with_heat(s: GridSolution, factors: WarmFactors, allowed: float) -> GridSolution:
    """The film with its heat, in rounds (`solvers.heat`); without a result where the two do not agree.

    allowed: change of H_c and of H_min in the last round, over H_c.
    """
    rounds, films = Rounds(factors), s.measure()
    for _ in range(heat.ROUNDS):
        found = heated(s.case, s.P_f, s.H, s.grid, s.P_asperity, factors, heat.IN_A_ROUND)
        moved = np.max(np.abs(found.T - factors.T))
        factors, last = rounds.next(found), films
        c = warm_contact(s.case, s.grid, factors)
        s = replace(_continued(s, c, heat.LOOSE), **factors._asdict())
        if not s.status.ok:
            return s
        films = s.measure()
        stays = max(abs(films[name] - last[name]) for name in ("H_c", "H_min")) <= allowed * films["H_c"]
        if stays and moved < 0.99 * heat.LARGEST_CHANGE:
            return replace(_continued(s, c), **factors._asdict())
    return replace(s, status=Status.NO_AGREEMENT)


def _continued(s: GridSolution, c: Contact, looser: float = 1.0) -> GridSolution:
    """The solution that goes on from another one, with the work of both.  looser: see `solve_on_grid`."""
    again = solve_on_grid(s.case, s.grid, c, s.P, s.approach, s.P_f, looser)
    work = s.newton + again.newton, s.krylov + again.krylov, s.convolutions + again.convolutions
    history = s.history + again.history[1:]
    return replace(again, newton=work[0], krylov=work[1], convolutions=work[2], history=history)


def grids_of(case: Case) -> list[Grid]:
    """The case's own grid and its coarser ones.  Raises ValueError for a grid that cannot be coarsened."""
    grids = [grid_of(case)]
    check_coarsening(grids[0])
    is_line = grids[0].nodes_y == 1
    while (coarser := grids[-1].coarser()).nodes_x >= (FIRST_ROW if is_line else FIRST_GRID):
        if not is_line and coarser.nodes_y < FIRST_GRID:
            break
        grids.append(coarser)
    return grids


def _judged(finest: GridSolution) -> GridSolution:
    """The solution on the finest grid; its status is FILM_VANISHED where H_min <= 0."""
    status = finest.status.of_film(finest.measure()["H_min"])
    if status.ok and finest.T is not None and finest.heat is not None and not finest.heat.converged:
        status = Status.NO_AGREEMENT
    return finest if status is finest.status else replace(finest, status=status)  # which would forget its temperatures


def settled(case: Case) -> Rolling:
    """The steady contact, on its own grid with the oil outside at the contact's own Delta, not at that of the guess.

    Time steps know Delta, so a run in time needs this film to stay steady.
    """
    *coarser, s = steady_film(case).solutions
    return Rolling((*coarser, _judged(_agreeing(discretise.contact_of(case, s.grid), s, TOLERANCE))))


def _agreeing(c: Contact, s: GridSolution, allowed: float) -> GridSolution:
    """The solution with the oil outside at its own Delta, not at that of the guess.

    allowed: change of the load outside, over the load.
    """
    outside = discretise.outside_of(s.case, s.grid)
    load = s.case.motion.load(0.0) * s.case.geometry.hertz_load
    for _ in range(SETTLING):
        if not s.status.ok or abs(outside.at(motion_of(s.case, s.approach)).load - s.outside) <= allowed * load:
            break
        s = _continued(s, c)
    return s


def first_guess(c: Contact, coarse: GridSolution, approach: float) -> tuple[Array, float, Array]:
    """Pressure, approach and pressure of the oil from the coarser grid; reduced if the surfaces would overlap."""
    H_min = coarse.measure()["H_min"]
    least, thinnest = LEAST_FILM * max(H_min, 0.0), H_min + coarse.approach - approach
    P = P_f = refined(c, coarse.P_f, np.asarray(coarse.case.layer is not None))
    if coarse.P_asperity is not None:
        P = P_f + refined(c, coarse.P_asperity, np.asarray(False))
    return P, approach - max(least - thinnest, 0.0), P_f


def solve_on_grid(
    case: Case,
    grid: Grid,
    c: Contact,
    P: Array | Floats,
    approach: float,
    P_f: Array | Floats | None = None,
    looser: float = 1.0,
) -> GridSolution:
    """The steady solution on one grid from a first guess of P and the approach; the latter fixes the oil outside.

    P_f: the first guess of the pressure of the oil, where asperities touch.  looser: factor of the tolerance.
    """
    outside = discretise.outside_of(case, grid)
    around = outside.at(motion_of(case, approach))
    gap = jax.device_put(np.asarray(c.gap) + around.uplift)  # NumPy has nothing to compile
    problem = problem_of(case, grid, replace(c, gap=gap), around.load, looser)
    P = np.where(outside.is_edge, around.edge, P)
    P_f = None if c.asperities is None else np.where(outside.is_edge, around.edge, P if P_f is None else P_f)
    s, Delta = _program(problem, P, float(approach), P_f)
    s = s._replace(residual=np.asarray(s.residual))  # NumPy has nothing to compile
    if not np.isfinite(s.residual):  # the first guess is left, for the next grid and for what is stored
        H = contact.film_thickness(problem.contact, jnp.asarray(P), approach)
        s, Delta = s._replace(P=P, Q=P_f, H=H), approach
    status = Status.CONVERGED if s.converged else Status.NEWTON_STALLED
    n, k = int(s.newton), int(s.krylov)
    work = nonlinear.convolutions(grid, n, k)
    history = tuple((np.asarray(s.history)[: n + 1] * problem.tolerance).tolist())
    numbers = float(Delta), history[-1], status, n, k, work, history, around.load
    return GridSolution(case, grid, s.P, s.H, *numbers, s.shared, None if s.Q is None else s.P - s.Q)


def problem_of(case: Case, grid: Grid, c: Contact, outside: float, looser: float = 1.0) -> nonlinear.Problem:
    """The equations of the steady film on one grid.  outside: the load that the oil outside the grid carries."""
    geometry, tolerance = case.geometry, looser * (case.solver.tolerance if case.is_steady else TOLERANCE)
    return nonlinear.Problem(
        c,
        multigrid.deformation_operators(grid, geometry.compliance, nonlinear.PRECISION, geometry.reach),
        steady_rate(case.motion.entrainment(0.0), discretise.layer_of(case, grid)),
        balanced(case.motion.load(0.0), geometry.hertz_load).less(outside),
        tolerance,
        tolerance / geometry.hertz_load,
        ALGORITHMS,
    )


def compile_ahead(case: Case) -> None:
    """Compile the programs of a steady film, or load them, in the background: the finest grid's takes the longest."""

    @double_precision()  # it holds for one thread
    def compile_all() -> None:
        with suppress(Exception):  # the run itself meets the error, and says so
            for grid in grids_of(case)[:-1]:  # the coarsest one's is needed at once
                problem = problem_of(case, grid, warm_contact(case, grid, first_factors(case, grid, ())), 0.0)
                zero = np.zeros(grid.shape)
                _program.ready(problem, zero, 0.0, zero if case.touches else None)

    Thread(target=compile_all).start()
