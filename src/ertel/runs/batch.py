"""Many impacts at once on one device: every time step of all of them is one compiled program, vectorised over cases.

    results = simulate_batch([parse_case({"contact": {"M": M, "L": 10}}) for M in (200, 500, 1000)])

Each case is an ordinary run in a thread of its own, with its own adaptive steps, events and end (`simulation`).  A run
that wants a step asks and waits; when all that still run have asked, one call of `jax.vmap` answers them.  What they
must share is the shape of that call: grid, axes of symmetry, laws of the oil, closure.

A batched iteration goes on until the slowest case has converged, so a batch pays where a single step leaves the device
idle: small grids, and graphics processors.  Runs that fill the cores are better spread over processes (`sweep`).
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from operator import itemgetter
from queue import SimpleQueue
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, tree

from ertel.model import discretise
from ertel.model.case import Case
from ertel.model.contact import Contact
from ertel.numerics import newton
from ertel.runs.drive import Result, Step, simulate
from ertel.runs.sweep import Failure
from ertel.solvers import transient
from ertel.solvers.nonlinear import Close, Preconditioner
from ertel.solvers.transient import Transient2D

Arguments = tuple[tuple[Any, ...], Mapping[str, Any]]  # of `transient.solve_on_device`: by position, by keyword
Answer = tuple[newton.Solution, Any]
SolveTogether = Callable[[Sequence[Arguments], int], Sequence[Answer]]  # from steps and the number of lanes
METHODS = ("2d", "transient")
SHRINKAGE = 4  # a batch becomes smaller, which costs a compilation, when this factor fewer cases still run


def simulate_batch(
    cases: Sequence[Case], on_step: Callable[[int, Step], object] = lambda number, step: None
) -> list[Result | Failure]:
    """The results of all cases in their order, as `simulate` gives them; a `Failure` where a run raised.

    on_step sees every accepted step with the number of its case, called from that case's thread.  Raises ValueError,
    naming the field, where the cases cannot share a step.
    """
    check_alike(cases)
    desk = Desk(len(cases))

    def run(number: int) -> Result:
        try:
            method = Transient2D(cases[number], solve_step=partial(desk.ask, number))
            return simulate(cases[number], partial(on_step, number), method=method)
        finally:
            desk.leave()

    with ThreadPoolExecutor(len(cases)) as pool:
        futures = [pool.submit(run, number) for number in range(len(cases))]
        desk.serve(solve_together)
    return [_outcome(future) for future in futures]


def _outcome(future: "Future[Result]") -> Result | Failure:
    error = future.exception()
    return Failure(f"{type(error).__name__}: {error}") if error else future.result()


# -- what cases must share ---------------------------------------------------------------------------------------------


def check_alike(cases: Sequence[Case]) -> None:
    """Raise ValueError unless one compiled step fits all cases."""
    if not cases:
        raise ValueError("cases = []: must be one or more")
    for case in cases:
        if case.solver.method not in METHODS:
            raise ValueError(f'solver.method = "{case.solver.method}": must be one of {METHODS} in a batch')
    first, *others = (_shape(case) for case in cases)
    for number, other in enumerate(others, start=1):
        for name, value in other.items():
            if value != first[name]:
                raise ValueError(
                    f"{name} = {value} in case {number}: must be that of case 0, {first[name]}, in a batch"
                )


def _shape(case: Case) -> dict[str, object]:
    """All that the compiled step depends on, by the field that decides it."""
    grid, oil = discretise.grid_of(case), case.lubricant
    return {
        "solver.method": case.solver.method,
        "solver.nodes": grid.nodes,
        "solver.half_width": case.solver.half_width,
        "solver.inlet": grid.centre_x,
        "roughness (axes of symmetry)": tuple(grid.even),
        "lubricant.viscosity": _structure(oil.viscosity_law),
        "lubricant.density": _structure(oil.density_law),
        "motion.entrainment": "some" if case.motion.flows else "none",
        "motion.inertia": "some" if case.motion.inertia > 0 else "none",
    }


def _structure(law: object) -> tuple[str, object, tuple[tuple[int, ...], ...]]:
    leaves, structure = tree.flatten(law)
    return type(law).__name__, structure, tuple(np.shape(leaf) for leaf in leaves)


# -- the meeting of the runs -------------------------------------------------------------------------------------------


class _Question(NamedTuple):
    number: int
    arguments: Arguments
    answer: "Future[Answer]"


class Desk:
    """Where runs in threads ask for a step (`ask`), and one thread answers when all that still run have (`serve`)."""

    def __init__(self, running: int):
        self._running = running
        self._inbox: SimpleQueue[_Question | None] = SimpleQueue()  # None: a run has left

    def ask(self, number: int, *fields: Any, **choices: Any) -> Answer:
        """Wait for what `transient.solve_on_device` gives for these arguments; raises what solving raised."""
        question = _Question(number, (fields, choices), Future())
        self._inbox.put(question)
        return question.answer.result()

    def leave(self) -> None:
        """This run asks no more."""
        self._inbox.put(None)

    def serve(self, solve: SolveTogether) -> None:
        """Answer until all runs have left; solve(steps, lanes) solves the steps, at most `lanes`.

        An interrupt ends the runs at their next step.
        """
        waiting: list[_Question] = []
        lanes = self._running
        try:
            while self._running:
                self._receive(waiting)
                if waiting and len(waiting) == self._running:
                    lanes = lanes_for(len(waiting), lanes)
                    _answer(sorted(waiting, key=lambda question: question.number), solve, lanes)
                    waiting.clear()
        except BaseException:
            while self._running:
                for question in waiting:
                    question.answer.cancel()
                waiting.clear()
                self._receive(waiting)
            raise

    def _receive(self, waiting: list[_Question]) -> None:
        question = self._inbox.get()
        if question is None:
            self._running -= 1
        else:
            waiting.append(question)


def lanes_for(asking: int, lanes: int) -> int:
    """The size of the next batch, given the last one's: rarely another, because every size is compiled."""
    while asking * SHRINKAGE <= lanes:
        lanes = -(-lanes // SHRINKAGE)
    return lanes


def _answer(questions: Sequence[_Question], solve: SolveTogether, lanes: int) -> None:
    try:
        answers = solve([question.arguments for question in questions], lanes)
    except Exception as error:
        for question in questions:
            question.answer.set_exception(error)
        return
    for question, answer in zip(questions, answers, strict=True):
        question.answer.set_result(answer)


# -- one step of all ---------------------------------------------------------------------------------------------------


def solve_together(steps: Sequence[Arguments], lanes: int) -> list[Answer]:
    """What `transient.solve_on_device` gives for steps of one shape, by one call on so many lanes."""
    filled = [*steps, *[steps[-1]] * (lanes - len(steps))]
    (one, elastic, *_), choices = filled[0]
    own = [(replace(contact, kernel=0.0, spacing=0.0), *others) for (contact, _, *others), _ in filled]
    contact, *others = tree.map(_stacked, *own)
    contact = replace(contact, kernel=one.kernel, spacing=one.spacing)  # the same for all, and large
    P, H, rest = _solve_lanes(contact, elastic, others, **choices)
    numbers = jax.device_get(rest)  # the small ones together: each read waits for the device
    answers = []
    for lane in range(len(steps)):
        solution, approach = tree.map(itemgetter(lane), numbers)
        answers.append((solution._replace(P=P[lane], H=H[lane]), approach))
    return answers


def _stacked(*values: Any) -> Any:
    return _stack(values) if isinstance(values[0], Array) else np.asarray(values)


@jax.jit
def _stack(fields: Sequence[Array]) -> Array:
    return jnp.stack(fields)


@partial(jax.jit, static_argnames=("close", "preconditioner"))
def _solve_lanes(
    contact: Contact, elastic: Any, others: Sequence[Any], *, close: Close, preconditioner: Preconditioner
) -> tuple[list[Array], list[Array], Any]:
    """P and H of each lane apart; all other results with the lanes along their first axis."""
    lane_axes = replace(tree.map(lambda _: 0, contact), kernel=None, spacing=None)
    solve = partial(transient.solve_on_device, close=close, preconditioner=preconditioner)
    solution, approach = jax.vmap(solve, (lane_axes, None, *[0] * len(others)))(contact, elastic, *others)
    return list(solution.P), list(solution.H), (solution._replace(P=(), H=()), approach)
