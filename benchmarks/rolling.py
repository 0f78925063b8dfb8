"""What a steady rolling contact costs, with Roelands' and Dowson and Higginson's laws.  Prints a table.

    python benchmarks/rolling.py        (two minutes with a warm compilation cache)

Every grid is solved twice, the second time compiled, to a residual of 1e-6; "ratio" is the wall time over that of as
many convolutions alone in the same run.
"""

import time

from common import header, keep_compiled, row, seconds, timed
from common import rolling as case

COLUMNS = ("case", "nodes", "convolutions", "finest", "Newton", "Krylov", "seconds", "CPU s", "ratio")


def main() -> None:
    keep_compiled()
    header(COLUMNS)
    for M in (200.0, 1000.0):
        for nodes in (257, 513):
            row(*measure(M, nodes))


def measure(M: float, nodes: int) -> list[str]:
    import jax
    import jax.numpy as jnp

    from ertel import halfspace, steady2d

    steady2d.steady(case(M, nodes))
    cpu = time.process_time()
    wall, found = timed(lambda: steady2d.steady(case(M, nodes)))
    cpu = time.process_time() - cpu
    grid, s = found.finest.grid, found.finest
    convolve = jax.jit(halfspace.displacement, static_argnums=2)
    one = seconds(convolve, halfspace.spectrum(grid), jnp.asarray(s.P), grid.even, repeats=15)
    counts = [f"{found.convolutions:.0f}", f"{s.convolutions:.0f}", str(s.newton), str(s.krylov)]
    ratio = wall / (found.convolutions * one)
    return [f"M={M:g} L=10", f"{nodes}²", *counts, f"{wall:.2f}", f"{cpu:.2f}", f"{ratio:.1f}"]


if __name__ == "__main__":
    main()
