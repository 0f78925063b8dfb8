"""What a time step of the 2-D method costs: counts, seconds, compile time and memory.  Prints a table.

    python benchmarks/steps.py [nodes ...]          (129 257 513 1025 unless said; a few minutes)

The impact is M = 1000, L = 10.  Each grid is measured in a process of its own: the state at T = 1.2 comes from a run
on 65 x 65 nodes, interpolated; a few steps settle it, the next are timed.  The machine may be busy: the step that
was least disturbed counts, and ratios tell more than seconds.
"""

import resource
import statistics
import tempfile

from common import child, grids, header, impact, impact_levels, keep_compiled, march, row, seconds, step_seconds, timed

STEP, SETTLE, TIMED = 0.005, 4, 10
COLUMNS = {
    "convolutions": "convolutions a step",
    "krylov": "Krylov a step",
    "seconds": "seconds a step",
    "ratio": "time / its convolutions",
    "cold": "compile cold, s",
    "cached": "compile cached, s",
    "memory": "peak memory, MiB",
}


def measure(nodes: int) -> dict[str, float]:
    """All figures of one grid but the cached compile time."""
    import jax

    from ertel.equations import contact
    from ertel.solvers.transient import Transient2D

    keep_compiled()
    method = Transient2D(impact(1000, nodes))
    compile_seconds, _ = timed(lambda: method.advance([method.start()], 1e-4))
    levels, timings, found = march(method, impact_levels(method), STEP, SETTLE, TIMED)
    convolve = jax.jit(contact.deformation)
    step = step_seconds([wall for wall, _ in timings], found)
    convolutions = statistics.mean(level.work.convolutions for level in found)
    return {
        "convolutions": convolutions,
        "krylov": statistics.mean(level.work.krylov for level in found),
        "seconds": step,
        "ratio": step / (convolutions * seconds(convolve, method.contact, levels[0].P)),
        "cold": compile_seconds,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def main() -> None:
    header(["nodes", *COLUMNS.values()])
    for nodes in grids((129, 257, 513, 1025)):
        with tempfile.TemporaryDirectory() as cache:
            cold, cached = (child("steps", f"measure({nodes})", JAX_COMPILATION_CACHE_DIR=cache) for _ in range(2))
        # the second process ran undisturbed by compiling
        figures = {**cached, "cold": cold["cold"], "cached": cached["cold"]}
        row(f"{nodes}²", *(figures[key] for key in COLUMNS))


if __name__ == "__main__":
    main()
