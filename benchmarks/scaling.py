"""Seconds and memory of a time step, and of a steady rolling contact, against the number of nodes.  Prints two tables.

    python benchmarks/scaling.py [nodes ...] [--impact] [--rolling]     (65 ... 2049 unless said; ten minutes)

Both kinds unless one is named.  On a GPU name 4097 as well.  The impact is M = 1000, L = 10 in its
middle (steps of 0.005 on from T = 1.2, as in steps.py); rolling is M = 1000, L = 10 from the Hertz pressure on 33² to a
residual of 1e-6.  Memory is XLA's account of the compiled program (`memory_analysis`: arguments + results + temporary)
in arrays of the fine grid: as kept in double precision (a quarter of the plane for impact, half for rolling), and in
arrays of the whole plane.  The slope is that of the logarithms, seconds against nodes²; on a machine that does
other work the CPU's are the ones to read.
"""

import statistics
import sys
import time
from typing import Any

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
    slope,
    step_seconds,
    timed,
)

NODES = (65, 129, 257, 513, 1025, 2049)
STEP, SETTLE, TIMED = 0.005, 3, 7
COLUMNS = {
    "seconds": "seconds",
    "cpu": "CPU s",
    "per_node": "CPU ns a node",
    "convolutions": "convolutions",
    "kept": "arrays as kept",
    "whole": "arrays of the whole plane",
    "MiB": "MiB",
}


def main() -> None:
    kinds = [kind for kind in ("impact", "rolling") if f"--{kind}" in sys.argv] or ["impact", "rolling"]
    for kind in kinds:
        titles = {"impact": "Impact, one step", "rolling": "Steady rolling, all grids"}
        print(f"{titles[kind]}\n", flush=True)
        header(["nodes", *COLUMNS.values()])
        found = {}
        for nodes in grids(NODES):
            found[nodes] = child("scaling", f"measure_{kind}({nodes})")
            row(f"{nodes}²", *(found[nodes][key] for key in COLUMNS))
        for least in (min(found), 257):
            several = [n for n in found if n >= least]
            if len(several) > 1:
                wall, cpu = (
                    slope([n**2 for n in several], [found[n][key] for n in several]) for key in ("seconds", "cpu")
                )
                print(f"\nslope from {least}² per node: {wall:.2f}, of CPU seconds {cpu:.2f}", flush=True)
        print()


def measure_impact(nodes: int) -> dict[str, float]:
    keep_compiled()
    from ertel.solvers.transient import Transient2D, solve_step

    method = Transient2D(impact(1000, nodes))
    levels, timings, found = march(method, impact_levels(method), STEP, SETTLE, TIMED)
    memory = _memory(solve_step.lower(method.problem(levels, STEP)).compile())
    convolutions = statistics.mean(level.work.convolutions for level in found)
    wall, cpu = (step_seconds(times, found) for times in zip(*timings, strict=True))
    return _figures(method.grid, wall, cpu, convolutions, memory)


def measure_rolling(nodes: int) -> dict[str, float]:
    keep_compiled()
    from unittest import mock

    from ertel.solvers import nonlinear, steady

    case = rolling(1000, nodes)
    with mock.patch.object(steady, "_program", wraps=steady._program) as solver:
        steady.steady_film(case)
    cpu = time.process_time()
    seconds, found = timed(lambda: steady.steady_film(case))
    cpu = time.process_time() - cpu
    last = solver.call_args
    memory = _memory(nonlinear.solve.lower(*last.args, **last.kwargs).compile())
    return _figures(found.finest.grid, seconds, cpu, found.convolutions, memory)


def _memory(compiled: Any) -> float:
    """Bytes of a compiled program while it runs."""
    m = compiled.memory_analysis()
    return m.argument_size_in_bytes + m.output_size_in_bytes + m.temp_size_in_bytes - m.alias_size_in_bytes


def _figures(grid: Any, seconds: float, cpu: float, convolutions: float, memory: float) -> dict[str, float]:
    rows, columns = grid.shape
    return {
        "seconds": seconds,
        "cpu": cpu,
        "per_node": 1e9 * cpu / grid.nodes**2,
        "convolutions": convolutions,
        "kept": memory / (8 * rows * columns),
        "whole": memory / (8 * grid.nodes**2),
        "MiB": memory / 2**20,
    }


if __name__ == "__main__":
    main()
