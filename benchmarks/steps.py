"""What a time step of the 2-D method costs: counts, seconds, compile time and memory.  Prints a table.

    python benchmarks/steps.py [nodes ...]          (129 257 513 1025 unless said; a few minutes)

M = 1000, L = 10, and every grid in a process of its own.  Impact: the state at T = 1.2 comes from a run on 65 x 65
nodes, interpolated.  Rolling in time: from the steady film, while the load rises by half in one unit of time.  A few
steps settle the film, the next are timed.  The machine may be busy: the step that was least disturbed counts, and
ratios of processor time tell more than seconds.
"""

import itertools
import resource
import statistics
import tempfile
import time

from common import (
    child,
    grids,
    header,
    impact,
    impact_levels,
    keep_compiled,
    march,
    rolling,
    row,
    seconds,
    step_seconds,
    timed,
)

STEP, SETTLE, TIMED = 0.005, 4, 10
COLUMNS = {
    "convolutions": "convolutions a step",
    "krylov": "Krylov a step",
    "seconds": "seconds a step",
    "ratio": "CPU / its convolutions",
    "cold": "compile cold, s",
    "cached": "compile cached, s",
    "memory": "peak memory, MiB",
}


def measure(kind: str, nodes: int) -> dict[str, float]:
    """All figures of one grid but the cached compile time.  kind: "impact" or "rolling in time"."""
    import jax

    from ertel.equations import contact
    from ertel.solvers.transient import Transient2D

    keep_compiled()
    method = Transient2D(impact(1000, nodes) if kind == "impact" else rolling(1000, nodes, in_time=True))
    start = method.start()
    compile_seconds, _ = timed(lambda: method.advance([start], 1e-4))
    levels = impact_levels(method) if kind == "impact" else [start]
    levels, timings, found = march(method, levels, STEP, SETTLE, TIMED)
    convolve = jax.jit(contact.deformation)
    wall, cpu = (step_seconds(clock, found) for clock in zip(*timings, strict=True))
    convolutions = statistics.mean(level.work.convolutions for level in found)
    return {
        "convolutions": convolutions,
        "krylov": statistics.mean(level.work.krylov for level in found),
        "seconds": wall,
        "ratio": cpu / (convolutions * seconds(convolve, method.contact, levels[0].P, clock=time.process_time)),
        "cold": compile_seconds,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def main() -> None:
    header(["step", "nodes", *COLUMNS.values()])
    for kind, nodes in itertools.product(("impact", "rolling in time"), grids((129, 257, 513, 1025))):
        call = f"measure({kind!r}, {nodes})"
        with tempfile.TemporaryDirectory() as cache:
            cold, cached = (child("steps", call, JAX_COMPILATION_CACHE_DIR=cache) for _ in range(2))
        # the second process ran undisturbed by compiling
        figures = {**cached, "cold": cold["cold"], "cached": cached["cold"]}
        row(kind, f"{nodes}²", *(figures[key] for key in COLUMNS))


if __name__ == "__main__":
    main()
