"""What line contacts cost: steady films, a whole rebound and rolling in time, on a row of nodes.  Prints two tables.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/lines.py [nodes ...]        (257 513 1025 unless said)

Roelands and Dowson-Higginson, M = 20, L = 10.  A row has no coarser grids: every Newton iteration factorises the
Jacobian, a matrix of the nodes; an impact is even in X, and solves on half of them.  Processor time of the second call;
the first one compiles, for some ten seconds a grid.
"""

import time
from typing import Any

from common import grids, header, keep_compiled, row, slope

LOAD = [[0.0, 1.0], [1.0, 1.5]]  # rises by half in a time unit


def line(kind: str, nodes: int, **sections: Any) -> Any:
    """The case of a line contact."""
    from ertel import parse_case

    solver = {"nodes": nodes, **sections.pop("solver", {})}
    contact = {"kind": kind, "M": 20, "L": 10, "radius_ratio": 0}
    return parse_case({"contact": contact, "solver": solver, **sections})


def second(case: Any, repeats: int = 2) -> tuple[Any, float]:
    """The result, and the least processor time of the calls after the first."""
    import ertel

    times = []
    for _ in range(repeats + 1):
        begin = time.process_time()
        result = ertel.simulate(case)
        times.append(time.process_time() - begin)
    return result, min(times[1:])


def main() -> None:
    keep_compiled()
    sizes = grids((257, 513, 1025))
    header(["steady", "nodes", "Newton, all grids", "Krylov, all grids", "H_c", "CPU, s"])
    for nodes in sizes:
        result, cpu = second(line("rolling", nodes))
        s = result.summary
        row("rolling", nodes, s["newton_iterations"], s["krylov_iterations"], f"{s['H_c']:.5f}", f"{cpu:.2g}")
    header(["in time", "nodes", "steps", "Newton a step", "Krylov a Newton iteration", "CPU, s", "CPU a step, ms"])
    marched: dict[str, list[float]] = {}
    for kind, sections in {
        "impact to the rebound": {"time": {"until": "rebound"}},
        "rolling, load rises": {"solver": {"method": "transient"}, "motion": {"load": LOAD}, "time": {"until": 1.0}},
    }.items():
        for nodes in sizes:
            result, cpu = second(line("impact" if "impact" in kind else "rolling", nodes, **sections), 1)
            s = result.summary
            newton, krylov = s["newton_iterations"], s["krylov_iterations"]
            counts = [f"{newton / s['steps']:.2f}", f"{krylov / newton:.2f}"]
            row(kind, nodes, s["steps"], *counts, f"{cpu:.2g}", f"{1e3 * cpu / s['steps']:.3g}")
            marched.setdefault(kind, []).append(cpu / s["steps"])
    if len(sizes) > 1:
        for kind, times in marched.items():
            print(f"CPU of a step grows with the nodes to the power {slope(sizes, times):.1f}: {kind}")


if __name__ == "__main__":
    main()
