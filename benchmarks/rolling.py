"""What a steady rolling contact costs, with Roelands' and Dowson and Higginson's laws.  Prints a table.

    python benchmarks/rolling.py        (two minutes with a warm compilation cache)

Every grid is solved twice, the second time compiled, to a residual of 1e-6; "ratio" is the wall time over that of as
many convolutions alone in the same run.
"""

import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

COLUMNS = ("case", "nodes", "convolutions", "finest", "Newton", "Krylov", "seconds", "CPU s", "ratio")


def main() -> None:
    print("| " + " | ".join(COLUMNS) + " |\n|" + " --- |" * len(COLUMNS))
    for M in (200.0, 1000.0):
        for nodes in (257, 513):
            print("| " + " | ".join(measure(M, nodes)) + " |", flush=True)


def measure(M: float, nodes: int) -> list[str]:
    import jax
    import jax.numpy as jnp

    from ertel import halfspace, steady2d
    from ertel.case import SOLVERS, Case
    from ertel.lubricant import ALPHA, ETA0, P0_ROELANDS, DowsonHigginson, Lubricant, Roelands, roelands_exponent
    from ertel.motion import STEADY_ROLLING
    from ertel.scales import Parameters

    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.3)
    p = Parameters.from_moes(M, 10.0)
    p_h = p.alpha_bar / ALPHA
    oil = Lubricant(
        Roelands(p.alpha_bar, roelands_exponent(ALPHA, ETA0), p_h / P0_ROELANDS), DowsonHigginson(p_h / 5.9e8)
    )
    solver = replace(SOLVERS["steady"], nodes=nodes, tolerance=1e-6)
    case = Case(p, oil, solver, kind="rolling", motion=STEADY_ROLLING)
    steady2d.steady(case)
    start, cpu = time.perf_counter(), time.process_time()
    found = steady2d.steady(case)
    jax.block_until_ready(found.finest.H)
    wall, cpu = time.perf_counter() - start, time.process_time() - cpu
    grid = found.finest.grid
    convolve = jax.jit(halfspace.displacement, static_argnums=2)
    one = seconds(convolve, halfspace.spectrum(grid), jnp.asarray(found.finest.P), grid.even)
    s = found.finest
    counts = [f"{found.convolutions:.0f}", f"{s.convolutions:.0f}", str(s.newton), str(s.krylov)]
    ratio = wall / (found.convolutions * one)
    return [f"M={M:g} L=10", f"{nodes}²", *counts, f"{wall:.2f}", f"{cpu:.2f}", f"{ratio:.1f}"]


def seconds(work: Callable[..., Any], *arguments: Any, repeats: int = 15) -> float:
    import jax

    jax.block_until_ready(work(*arguments))
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        jax.block_until_ready(work(*arguments))
        times.append(time.perf_counter() - start)
    return statistics.median(times)


if __name__ == "__main__":
    main()
