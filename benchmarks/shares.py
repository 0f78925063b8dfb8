"""Where the time of an impact step and of a steady rolling contact goes.  Prints three tables.

    python benchmarks/shares.py [nodes ...] [--compile] [--outside]     (129 257 513 1025 unless said; five minutes)

M = 1000, L = 10.  A part's time is that of the part alone, compiled, times how often it is needed; so the parts need
not add up to the whole, and "rest" is what is left: data moved between operations, and, below zero, what XLA merges.
Rolling: the parts are of the finest grid.  "Python" is what a step (or the solution on the finest grid) takes outside
the compiled program.  "A flush" writes the steps of five seconds (here nine), a map and the checkpoint; of a steady
contact it is all that storing a run adds to it.  The first table (33 65 129 257 unless said; alone with --outside) has
the processor time of a step in the loop of a run, and what of it is spent outside the solve: the account of the film,
the way into the program and back, the error, the record.  With --compile: a first call without a cache, in a process of
its own (half a minute more for each row).
"""

import itertools
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

from common import child, grids, header, impact, impact_levels, keep_compiled, march, rolling, row, seconds, timed

STEP, SETTLE, TIMED, COUNTED = 0.005, 4, 8, 100
PARTS = {
    "fft": "FFT",
    "smoother": "smoother",
    "transfer": "transfer",
    "vectors": "Krylov vectors",
    "residual": "residual, Jacobian",
    "coarsest": "coarsest grid, direct",
    "setup": "V-cycle's coefficients",
    "python": "Python",
}
COLUMNS = ["nodes", "seconds", *PARTS.values(), "rest", "coarser grids", "compile, s", "a flush, s"]


def main() -> None:
    print("Impact, one step: what is outside its solve\n")
    header(["nodes", "CPU, ms", "the solve alone, ms", "outside"])
    for nodes in grids((33, 65, 129, 257)):
        whole, alone = child("shares", f"measure_outside({nodes})")
        row(f"{nodes}²", 1e3 * whole, 1e3 * alone, f"{1 - alone / whole:.0%}")
    print()
    if "--outside" in sys.argv:
        return
    for kind, title in (("impact", "Impact, one step"), ("rolling", "Steady rolling, the finest grid")):
        print(f"{title}\n", flush=True)
        header(COLUMNS if kind == "rolling" else [c for c in COLUMNS if c != "coarser grids"])
        for nodes in grids((129, 257, 513, 1025)):
            with tempfile.TemporaryDirectory() as cache:
                cold = "--compile" in sys.argv and child(
                    "shares", f"compile_seconds({kind!r}, {nodes})", JAX_COMPILATION_CACHE_DIR=cache
                )
            found = child("shares", f"measure_{kind}({nodes})")
            whole = found["seconds"]
            shares = [found[name] / whole for name in PARTS]
            coarser = [found["coarser"] / whole] if kind == "rolling" else []
            numbers = [*shares, 1 - sum(shares), *coarser]
            row(f"{nodes}²", whole, *(f"{share:.0%}" for share in numbers), cold or "", found["flush"])
        print()


def compile_seconds(kind: str, nodes: int) -> float:
    """The first step (rolling: the first solution on all grids) less a second one."""
    if kind == "rolling":
        from ertel.solvers import steady

        first, second = (timed(lambda: steady.steady_film(rolling(1000, nodes)))[0] for _ in range(2))
        return first - second
    from ertel.solvers.transient import Transient2D

    method = Transient2D(impact(1000, nodes))
    levels = [method.start()]
    first, second = (timed(lambda: method.advance(levels, 1e-4))[0] for _ in range(2))
    return first - second


# -- impact ------------------------------------------------------------------------------------------------------------


def measure_outside(nodes: int) -> tuple[float, float]:
    """Processor time of a step in the loop of a run, and of the solve alone: medians, taken in turns."""
    import jax

    from ertel.numerics.programs import Program
    from ertel.solvers import transient

    keep_compiled()
    course, item = _run_of_steps(nodes)
    alone = Program(jax.jit(lambda problem: transient.solve_step(problem).fields))
    asked: list[Any] = []

    def solve(problem: Any) -> Any:
        asked.append(problem)
        return solve_step(problem)

    solve_step, course.method.solve = course.method.solve, solve
    times = []
    for _ in range(SETTLE + COUNTED):
        start = time.process_time()
        item = course.advance(item)
        jax.block_until_ready(item.state.levels[0].H)
        whole = time.process_time() - start
        program = alone.ready(asked[-1])
        start = time.process_time()
        jax.block_until_ready(program(asked[-1]))
        times.append((whole, time.process_time() - start))
    whole, solve_alone = (statistics.median(each) for each in zip(*times[SETTLE:], strict=True))
    return whole, solve_alone


def _run_of_steps(nodes: int) -> tuple[Any, Any]:
    """A course of fixed steps of an impact, and its item in the middle of the impact."""
    from ertel.case.status import Status
    from ertel.runs.stepping import RunState, Step, TransientRun
    from ertel.solvers.transient import Transient2D

    case = impact(1000, nodes, time={"step": STEP})
    method = Transient2D(case)
    levels, _, _ = march(method, impact_levels(method), STEP, SETTLE, 1)
    frame = int(levels[0].T / case.schedule.interval) + 1
    return TransientRun(case, method), Step(RunState(tuple(levels), STEP, next_frame=frame), {}, (), Status.RUNNING)


def measure_impact(nodes: int) -> dict[str, float]:
    """Seconds of a step, of its parts, and of a flush."""
    import jax

    from ertel.case.status import Status
    from ertel.equations.approach import balanced
    from ertel.equations.flow import Rate
    from ertel.runs.stepping import RunState, Step, TransientRun
    from ertel.solvers import nonlinear, transient

    keep_compiled()
    on_device: list[float] = []

    def solve(problem: Any) -> Any:
        wall, answer = timed(lambda: jax.block_until_ready(transient.solve_step(problem)))
        on_device.append(wall)
        return answer

    case = impact(1000, nodes, time={"step": STEP})
    method = transient.Transient2D(case)
    method.solve = solve
    levels, _, found = march(method, impact_levels(method), STEP, SETTLE, TIMED)
    course = TransientRun(case, method)
    item = Step(RunState(tuple(levels), STEP), {}, (), Status.RUNNING)
    steps = []
    for number in range(1 + TIMED):
        wall, item = timed(lambda item=item: course.advance(item))
        if number == 0:  # it compiles what is measured of a step
            on_device.clear()
        else:
            steps.append((wall, item))
    walls = [wall for wall, _ in steps]
    convolutions = [step.record["convolutions"] for _, step in steps]
    whole = min(w / n for w, n in zip(walls, convolutions, strict=True)) * statistics.mean(convolutions)
    newton, krylov = (statistics.mean(getattr(level.work, name) for level in found) for name in ("newton", "krylov"))
    now = levels[0]
    rate, line = Rate(1.5 / STEP, 0.0 * now.H), balanced()
    how = nonlinear.Algorithms(nonlinear.approach_as_unknown, nonlinear.point_preconditioner, transient.OPTIONS)
    problem = nonlinear.Problem(method.contact, method.setting.elastic, rate, line, 1.0, 1.0, how)
    parts = _parts(problem, now.P, now.H)
    return {
        "seconds": whole,
        **_times(parts, newton, krylov),
        "python": min(w - d for w, d in zip(walls, on_device, strict=True)),
        "flush": _flush_seconds(course, [step for _, step in steps]),
    }


def _flush_seconds(course: Any, steps: list[Any]) -> float:
    from dataclasses import replace

    from ertel.runs.stepping import frame_of
    from ertel.runs.store import RunStore

    with tempfile.TemporaryDirectory() as directory:
        store = RunStore.create(Path(directory) / "run", course.case, course)
        frame = frame_of(course.method, steps[-1].state.levels[0], "")
        for step in steps:
            store(replace(step, frames=()))
        store(replace(steps[-1], frames=(frame,)))
        return timed(store.flush)[0]


# -- rolling -----------------------------------------------------------------------------------------------------------


def measure_rolling(nodes: int) -> dict[str, float]:
    """Seconds of the solution on the finest grid, of its parts, of the coarser grids, and of a flush."""
    import jax

    from ertel.equations import discretise
    from ertel.equations.approach import balanced
    from ertel.equations.flow import steady_rate
    from ertel.numerics import multigrid
    from ertel.physics.geometry import CIRCLE
    from ertel.solvers import nonlinear, steady

    keep_compiled()
    case = rolling(1000, nodes)
    steady.steady_film(case)
    solve, on_device = steady._program, [0.0]

    def solve_and_wait(*fields: Any) -> Any:
        on_device[0], answer = timed(lambda: jax.block_until_ready(solve(*fields)))
        return answer

    with mock.patch.object(steady, "_program", solve_and_wait):
        walls, solutions = zip(*_each(steady.nested(case)), strict=True)
    last = solutions[-1]
    c = discretise.contact_of(case, last.grid)
    elastic = multigrid.deformation_operators(last.grid, CIRCLE.compliance, nonlinear.PRECISION)
    problem = nonlinear.Problem(c, elastic, steady_rate(1.0), balanced(), 1.0, 1.0, steady.ALGORITHMS)
    parts = _parts(problem, last.P, last.H)
    return {
        "seconds": walls[-1],
        **_times(parts, last.newton, last.krylov),
        "python": walls[-1] - on_device[0],
        "coarser": sum(walls[:-1]),
        "flush": _run_seconds(case) - sum(walls),
    }


def _each(course: Iterator[Any]) -> Iterator[tuple[float, Any]]:
    """What an iterator gives, with the seconds it took."""
    while True:
        wall, item = timed(lambda: next(course, None))
        if item is None:
            return
        yield wall, item


def _run_seconds(case: Any) -> float:
    """A stored steady run, the second one: all is imported and compiled."""
    from ertel.runs import store

    def run(directory: Path) -> float:
        kept = store.RunStore.create(directory, case)
        return timed(lambda: store.compute(kept))[0]

    with tempfile.TemporaryDirectory() as directory:
        return [run(Path(directory) / name) for name in ("first", "second")][-1]


# -- the parts ---------------------------------------------------------------------------------------------------------


def _parts(problem: Any, P: Any, H: Any) -> dict[str, tuple[float, float, float]]:
    """Seconds of each part: once in a solve, for each Newton iteration, for each Krylov iteration."""
    import jax
    import jax.numpy as jnp

    from ertel.equations import contact
    from ertel.numerics import multigrid, newton, stencils

    call = seconds(jax.jit(lambda x: x + 1), 0.0)  # which parts in one program do not need

    def clock(work: Callable[..., Any], *arguments: Any) -> float:
        return max(seconds(work, *arguments) - call, 0.0)

    c, one = problem.contact, jnp.ones_like(P)
    free = stencils.inside(one, c.even)

    def levels_at(P: Any, H: Any) -> Any:
        return problem.algorithms.preconditioner(problem, P, H, free).args[0]

    levels = levels_at(P, H)
    convolve = jax.jit(lambda kernel, P: kernel.displacement(P))
    exact = clock(convolve, c.kernel, P)
    fft = smooth = transfer = operate = 0.0
    for fine, coarse in itertools.pairwise(levels):
        e, small = fine.coefficients.free, coarse.coefficients.free
        fft += 2 * clock(convolve, coarse.elasticity.kernel, small)
        smooth += 2 * clock(jax.jit(multigrid.relax), fine, e)
        down, up = jax.jit(partial(multigrid.restrict, even=c.even)), jax.jit(multigrid.prolong)
        transfer += 2 * clock(down, e) + 4 * clock(up, small)
        operate += 2 * clock(jax.jit(multigrid._operate), fine.elasticity, fine.coefficients, fine.smoother, e, e)
    direct = clock(jax.jit(multigrid.v_cycle), levels[-1:], levels[-1].coefficients.free)

    def coefficients(P: Any, H: Any) -> Any:
        return [(level.coefficients, level.smoother) for level in levels_at(P, H)]

    def residual(P: Any, H: Any) -> Any:
        return contact.residual(c, P, H, problem.rate)

    r = clock(jax.jit(residual), P, H)
    jvp = clock(jax.jit(jax.linearize(residual, P, H)[1]), P, H)
    iterations = 4
    diagonal = 1.0 + jnp.arange(P.size, dtype=P.dtype).reshape(P.shape) / P.size  # so that it does not converge at once
    search = jax.jit(lambda b: newton.gcr(lambda x: diagonal * x, lambda k, r: r, b, 0.0, iterations))
    room = clock(jax.jit(lambda: jnp.zeros((2 * problem.algorithms.options.krylov_limit, *P.shape))))
    return {
        "fft": (exact, exact, exact + fft),
        "smoother": (0.0, 0.0, smooth),
        "transfer": (0.0, 0.0, transfer),
        "vectors": (0.0, room, clock(search, P) / iterations),
        "residual": (r, 2 * r + jvp, jvp + operate),
        "coarsest": (0.0, 0.0, direct),
        "setup": (0.0, clock(jax.jit(coefficients), P, H), 0.0),
    }


def _times(parts: dict[str, tuple[float, float, float]], newton: float, krylov: float) -> dict[str, float]:
    return {name: a + newton * b + krylov * c for name, (a, b, c) in parts.items()}


if __name__ == "__main__":
    main()
