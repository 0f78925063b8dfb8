"""Cost of an impact in a batch of N (`ertel.simulate_batch`), against N runs one after the other.  Prints a table.

    python benchmarks/batch.py [nodes ...]      (65 129 unless said; ten minutes, half of it compiling)

The cases differ in M (200 to 1000).  Every batch runs three times, the first time to compile, and the faster of the
others counts.  "Lanes waiting" is the share of lanes that had ended or were filled up: a batch runs on until its last
case has come to its end.
"""

from operator import itemgetter
from typing import Any

from common import grids, header, impact, keep_compiled, row, timed

SIZES = (1, 2, 4, 8, 16, 32)
COLUMNS = ("nodes", "N", "seconds", "seconds a case", "one by one / batch", "lanes waiting", "first run, s")


def main() -> None:
    keep_compiled()
    header(COLUMNS)
    for nodes in grids((65, 129)):
        for size in SIZES:
            row(*measure(nodes, size))


def measure(nodes: int, size: int) -> list[Any]:
    import numpy as np

    from ertel import simulate, simulate_batch

    cases = [impact(float(M), nodes, time={"until": 2.0}) for M in np.geomspace(200, 1000, size + 2)[1:-1]]
    first, _ = timed(lambda: simulate_batch(cases))
    together, results = min((timed(lambda: simulate_batch(cases)) for _ in range(2)), key=itemgetter(0))
    some = cases[:: max(1, size // 4)]
    simulate(some[0])  # compiles; then the mean of up to four stands for all
    alone = sum(timed(lambda case=case: simulate(case))[0] for case in some) / len(some)
    steps = [r.dataset.sizes["time"] for r in results]
    waiting = 1 - sum(steps) / (size * max(steps))
    return [f"{nodes}²", size, together, together / size, size * alone / together, waiting, first]


if __name__ == "__main__":
    main()
