"""What a steady rolling contact costs, with Roelands' and Dowson and Higginson's laws.  Prints a table.

    python benchmarks/rolling.py        (two minutes with a warm compilation cache)

Every grid is solved to a residual of 1e-6, and to one that leaves less than the grid's own error: the last two columns
are what is left in H_c and H_min (against 1e-9), over the discretisation error.  Times are the least of four runs;
"CPU ns" are of a node of the finest grid and a Krylov iteration on it, with the coarser grids in them.
"""

import time
from collections.abc import Iterator
from typing import Any

from common import header, keep_compiled, row, timed
from common import rolling as case

COUNTS = ("convolutions", "finest", "Newton", "Krylov")
COLUMNS = ("case", "nodes", "tolerance", *COUNTS, "seconds", "CPU s", "CPU ns", "left in H_c", "left in H_min")


def main() -> None:
    keep_compiled()
    header(COLUMNS)
    for M in (20.0, 200.0, 1000.0):
        for nodes in (257, 513):
            for line in measure(M, nodes):
                row(*line)


def measure(M: float, nodes: int) -> Iterator[list[str]]:
    from ertel.numerics.grid import extrapolate
    from ertel.solvers import steady

    exact = steady.steady_film(case(M, nodes, tolerance=1e-9))
    for tolerance in (1e-6, steady.AS_EXACT_AS_THE_GRID):
        found, wall, cpu = quickest(case(M, nodes, tolerance=tolerance))
        s = found.finest
        counts = [f"{found.convolutions:.0f}", f"{s.convolutions:.0f}", str(s.newton), str(s.krylov)]
        nanoseconds = 1e9 * cpu / (nodes**2 * s.krylov)
        half, whole, ours = (each.measure() for each in (*exact.solutions[-2:], s))
        left = (abs(ours[name] - whole[name]) / extrapolate(half[name], whole[name]).error for name in ("H_c", "H_min"))
        times = [f"{wall:.2f}", f"{cpu:.2f}", f"{nanoseconds:.0f}"]
        yield [f"M={M:g} L=10", f"{nodes}²", f"{tolerance:g}", *counts, *times, *(f"{v:.1%}" for v in left)]


def quickest(problem: Any, repeats: int = 4) -> tuple[Any, float, float]:
    """The solution, and the least wall and CPU time: the first run compiles, other work on the machine only adds."""
    from ertel.solvers import steady

    walls, cpus = [], []
    for _ in range(repeats):
        cpu = time.process_time()
        wall, found = timed(lambda: steady.steady_film(problem))
        walls.append(wall)
        cpus.append(time.process_time() - cpu)
    return found, min(walls), min(cpus)


if __name__ == "__main__":
    main()
