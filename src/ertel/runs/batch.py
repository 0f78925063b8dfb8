"""Runs that share compiled programs: many impacts in one call, and compiling ahead by short runs.

Many impacts at once on one device: every time step of all of them is one compiled program, vectorised over cases.

    results = simulate_batch([parse_case({"contact": {"M": M, "L": 10}}) for M in (200, 500, 1000)])

Each case is a run of its own, with its own adaptive steps, events and end: a generator that yields the problem of its
next step and is sent the solution (`TransientRun.attempts`).  The problems of all runs that have not ended are solved
by one call of `jax.vmap`.  What the cases must share is the shape of that call: grid, axes of symmetry, laws of the
oil, closure.

A batched iteration goes on until the slowest case has converged, so a batch pays where a single step leaves the device
idle: small grids, and graphics processors.  Runs that fill the cores are better spread over processes (`ertel.sweep`).

A program depends on the kind of run, the number of nodes, the axes of symmetry and the laws of the oil; not on M, L,
the constants of the oil, tolerances, times or how far the grid reaches.
"""

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import inf
from os import PathLike
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, tree

from ertel.case.case import Case
from ertel.case.definition import grid_of
from ertel.case.status import Status
from ertel.equations.contact import traceable
from ertel.equations.state import StepSolution
from ertel.inputs.case_files import CaseLike, ConfigError, as_case, parse_case, written
from ertel.numerics.programs import double_precision, require_double
from ertel.runs.drive import METHODS, Recorder, result_of, run_of
from ertel.runs.result import Result
from ertel.runs.stepping import Step, TransientRun
from ertel.runs.workers import Failure, check_fork, one_blas_thread
from ertel.solvers.transient import StepProblem, Transient2D, solve_step

Asking = Generator[Any, Any, Any]  # a run that yields problems, is sent their solutions, and returns its outcome
SolveTogether = Callable[[Sequence[Any], int], Sequence[Any]]  # from problems and the number of lanes to solutions
ON_THE_PLANE = tuple(name for name, method in METHODS.items() if method is Transient2D)  # one compiled step for all
EXTENT = ("solver.half_width", "solver.half_width_y", "solver.inlet")  # numbers that a program is given
SHRINKAGE = 4  # a batch becomes smaller, which costs a compilation, when this factor fewer cases still run


@double_precision()
def simulate_batch(
    cases: Sequence[CaseLike], on_step: Callable[[int, Step], object] = lambda number, step: None
) -> list[Result | Failure]:
    """Run cases of one kind and one grid together: one compiled program makes a step of all.

    Parameters
    ----------
    cases : sequence of cases
        Each as for `simulate`.
    on_step : callable
        Sees the number of a case and each step that is accepted in it.

    Returns
    -------
    list of Result or Failure
        The results in the order of the cases; a `Failure` where a run raised.

    Raises
    ------
    ValueError
        The cases cannot share a step; the message names the field in which they differ.
    """
    if isinstance(cases, Case | str | PathLike | Mapping) or not isinstance(cases, Iterable):
        raise ConfigError(f"cases = {written(cases)}: must be a sequence of cases")
    checked = [as_case(case, f"cases[{number}]") for number, case in enumerate(cases)]
    check_alike(checked)
    check_fork()
    runs = [_asking(case, partial(on_step, number)) for number, case in enumerate(checked)]
    return run_together(runs, solve_together)


def _asking(case: Case, on_step: Callable[[Step], object]) -> Generator[StepProblem, StepSolution, Result]:
    """The loop of `drive.drive` over a run in memory; the caller solves its problems."""
    run = TransientRun(case, Transient2D(case, small=inf))  # all cases are solved on the whole grid, by one program
    recorder, step = Recorder(run), run.begin()
    while step.status is Status.RUNNING:
        step = yield from run.attempts(step)
        recorder(step)
        on_step(step)
    return recorder.result(step)


@one_blas_thread()
def run_together(runs: Sequence[Asking], solve: SolveTogether) -> list[Any]:
    """The outcomes of the runs in their order; a `Failure` for each that raised, also when a solve failed.

    solve(problems, lanes) solves the problems of all runs that have not ended, at most `lanes`.
    """
    outcomes: list[Any] = [None] * len(runs)
    replies: dict[int, Any] = dict.fromkeys(range(len(runs)))  # a solution or an exception, by the number of the run
    lanes = len(runs)
    while True:
        problems = {}
        for number, reply in replies.items():
            run = runs[number]
            try:
                problems[number] = run.throw(reply) if isinstance(reply, Exception) else run.send(reply)
            except StopIteration as end:
                outcomes[number] = end.value
            except Exception as error:
                outcomes[number] = Failure.of(error)
        if not problems:
            break
        lanes = lanes_for(len(problems), lanes)
        try:
            solutions = solve(list(problems.values()), lanes)
        except Exception as error:
            solutions = [error] * len(problems)
        replies = dict(zip(problems, solutions, strict=True))
    return outcomes


def lanes_for(asking: int, lanes: int) -> int:
    """The size of the next batch, given the last size; it changes rarely, because every size needs a compilation."""
    while asking * SHRINKAGE <= lanes:
        lanes = -(-lanes // SHRINKAGE)
    return lanes


# -- what cases must share ---------------------------------------------------------------------------------------------


def check_alike(cases: Sequence[Case]) -> None:
    """Raise ValueError unless one compiled step fits all cases."""
    if not cases:
        raise ValueError("cases = []: must be one or more")
    for case in cases:
        if case.solver.method not in ON_THE_PLANE:
            raise ValueError(f'solver.method = "{case.solver.method}": must be one of {ON_THE_PLANE} in a batch')
    first, *others = (shape_of(case) for case in cases)
    for number, other in enumerate(others, start=1):
        for name, value in other.items():
            if value != first[name]:
                allowed = f"must be that of case 0, {first[name]}, in a batch"
                raise ValueError(f"{name} = {value} in case {number}: {allowed}")


def shape_of(case: Case) -> dict[str, object]:
    """Everything on which the compiled step depends, by field."""
    grid, oil = grid_of(case), traceable(case.lubricant)
    return {
        "solver.method": case.solver.method,
        "solver.nodes": grid.nodes,
        "solver.half_width": case.solver.half_width,
        "solver.half_width_y": case.solver.half_width_y,
        "contact.radius_ratio": case.contact.ratio,
        "solver.inlet": grid.centre_x,
        "roughness, lubricant.layer (axes of symmetry)": tuple(grid.even),
        "lubricant.viscosity": _structure(oil.viscosity_law),
        "lubricant.density": _structure(oil.density_law),
        "lubricant.rheology": _structure(traceable(case.oil.fluidity_law)),
        "motion.entrainment": "some" if case.motion.flows else "none",
        "motion.inertia": "some" if case.motion.inertia > 0 else "none",
    }


def program_of(case: Case) -> str:
    """A text that is the same for runs that need the same compiled programs."""
    shape = {name: value for name, value in shape_of(case).items() if name not in EXTENT}
    across = grid_of(case).nodes_y
    return repr((case.kind, across, sorted(shape.items()), case.thermal is not None))


def _structure(law: object) -> tuple[str, object, tuple[tuple[int, ...], ...]]:
    leaves, structure = tree.flatten(law)
    return type(law).__name__, structure, tuple(np.shape(leaf) for leaf in leaves)


# -- one step of all ---------------------------------------------------------------------------------------------------


def solve_together(problems: Sequence[StepProblem], lanes: int) -> list[StepSolution]:
    """The results of `transient.solve_step` for problems of one shape, by one call with this number of lanes."""
    require_double()
    filled = [*problems, *[problems[-1]] * (lanes - len(problems))]
    fields, numbers = _solve_lanes(tree.map(_joined, _axes(problems[0]), *filled, is_leaf=lambda axis: axis is None))
    parts = fields, {name: np.asarray(each) for name, each in numbers.items()}
    lanes_used = range(len(problems))
    return [StepSolution(*({name: each[lane] for name, each in part.items()} for part in parts)) for lane in lanes_used]


def _axes(problem: StepProblem) -> Any:
    """The axis of the lanes in each part of a problem; None for the large parts that all cases share."""
    axes = tree.map(lambda leaf: 0, problem)
    setting = replace(axes.setting, elastic=None, space=None, gap_slope=None)
    return replace(axes, setting=setting, contact=replace(axes.contact, kernel=None, spacing=None))


def _joined(axis: int | None, *values: Any) -> Any:
    if axis is None:
        return values[0]
    return _stack(values) if isinstance(values[0], Array) else np.asarray(values)


_stack = jax.jit(jnp.stack)


@jax.jit
def _solve_lanes(problems: StepProblem) -> tuple[dict[str, list[Array]], Mapping[str, Array]]:
    """The fields of each lane separately; the numbers with the lanes along their first axis."""
    solution = jax.vmap(solve_step, in_axes=(_axes(problems),))(problems)
    return {name: list(lanes) for name, lanes in solution.fields.items()}, solution.numbers


# -- compiling ahead --------------------------------------------------------------------------------------------------

STEPS = 4  # the first three have histories of different length
STEADY, IN_TIME = 257, 129  # nodes per side: the largest of the usual grids
USUAL = (
    {"name": f"steady rolling, 33 to {STEADY}", "contact": {"kind": "rolling"}, "solver": {"nodes": STEADY}},
    {"name": f"impact, {IN_TIME}", "contact": {"kind": "impact"}, "solver": {"method": "2d", "nodes": IN_TIME}},
    {"name": f"impact, {STEADY}", "contact": {"kind": "impact"}, "solver": {"method": "2d", "nodes": STEADY}},
    {"name": "impact, radial, 401", "contact": {"kind": "impact"}, "solver": {"method": "radial", "nodes": 401}},
)
OIL = {"viscosity": "roelands", "density": "dowson-higginson", "eta0": "40 mPa*s", "alpha": "22 / GPa"}


def usual_cases() -> Iterator[Case]:
    """Smooth contacts on the usual grids, with the usual laws of the oil."""
    for case in USUAL:
        yield parse_case({**case, "contact": {**case["contact"], "M": 200, "L": 10}, "lubricant": OIL})  # type: ignore[dict-item]


@double_precision()
def warm_up(case: Case) -> None:
    """Compile what a run of the case needs.

    A steady case is run to its end, a run in time for a few steps.
    """
    run: Any = run_of(case)
    steps = iter(range(STEPS))

    def enough(result: Any) -> bool:
        if case.is_steady or next(steps, None) is not None:
            return False
        run.method.measure(result.state.levels[0])  # as at the moments of which maps are kept
        run.method.friction(result.state.levels[0])
        return True

    result_of(run, [enough])
