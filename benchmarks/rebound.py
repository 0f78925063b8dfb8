"""How the work of a whole rebound depends on the grid: steps, iterations, processor time, and what came out.

    python benchmarks/rebound.py [nodes ...]          (129 257 unless said; the radial method on 201 and 401)

M = 1000, L = 10, compiled before by a rebound of few steps; some minutes.  While the ball leaves, a pressure spike of
a few cells moves inwards; it must not rule the steps.
"""

import time
from math import nan
from typing import Any

from common import grids, header, impact, keep_compiled, row


def rebound(method: str, nodes: int) -> tuple[Any, ...]:
    """Steps, steps after T = 3.2, Newton and Krylov iterations, processor time, restitution, H_c, H_min."""
    import ertel

    coarse, default = {"until": "rebound", "tolerance": 2e-3}, {"until": "rebound"}
    cases = [impact(1000, nodes, solver={"method": method}, time=steps) for steps in (coarse, default)]
    ertel.simulate(cases[0])
    begin = time.process_time()
    found = ertel.simulate(cases[1])
    seconds, s = time.process_time() - begin, found.summary
    late = int((found.dataset.time > 3.2).sum())
    films = (nan if s[name] is None else s[name] for name in ("H_c", "H_min"))  # none where the film vanishes
    return s["steps"], late, s["newton_iterations"], s["krylov_iterations"], seconds, s["restitution"] or nan, *films


def main() -> None:
    keep_compiled()
    header(["method", "nodes", "steps", "after T = 3.2", "Newton", "Krylov", "CPU, s", "e", "H_c", "H_min"])
    for method, chosen in (("2d", grids((129, 257))), ("radial", (201, 401))):
        for nodes in chosen:
            row(method, nodes, *(f"{value:.6g}" for value in rebound(method, nodes)))


if __name__ == "__main__":
    main()
