"""What an oil that thins costs: steps in time and steady solves beside those of a Newtonian oil.  Prints two tables.

    python benchmarks/thinning.py [nodes]           (129 unless said; some minutes)

A ball of 20 mm under 20 N and 1 m/s with S = 0.5, M = 61, L = 11, p_h = 0.79 GPa; the steps are those of a load that
rises.  All oils are measured in the same run: only the ratios tell.
"""

import statistics
import time
from typing import Any

from common import grids, header, keep_compiled, march, row, step_seconds, timed

STEP, SETTLE, TIMED = 0.02, 3, 8


def oils() -> dict[str, Any]:
    """The laws by name, the Newtonian one first."""
    from ertel.physics.fluidity import Carreau, Limited, ReeEyring

    carreau = Carreau(6e6, 0.42)
    return {
        "Newtonian": "newtonian",
        "Eyring, 2 MPa": ReeEyring(2e6),
        "Carreau": carreau,
        "limited": Limited(carreau, 0.05),
    }


def case(rheology: Any, nodes: int, method: str) -> Any:
    """The contact on nodes x nodes."""
    import ertel

    load = {"load": [[0.0, 1.0], [1.0, 1.5]]}
    return ertel.rolling(
        radius="10 mm",
        E_prime="226 GPa",
        load="20 N",
        mean_speed="1 m/s",
        slide_to_roll=0.5,
        oil=ertel.Oil(eta0="40 mPa*s", alpha="20 / GPa"),
        rheology=rheology,
        nodes=nodes,
        method=method,
        **({"motion": load, "until": 1.0} if method == "transient" else {}),
    )


def steps(rheology: Any, nodes: int) -> tuple[float, ...]:
    """Newton and Krylov iterations of a step, its least wall and processor time, and the first call's wall time."""
    from ertel.solvers.transient import Transient2D

    method = Transient2D(case(rheology, nodes, "transient"))
    start = method.start()
    first, _ = timed(lambda: method.advance([start], STEP))
    _, timings, found = march(method, [start], STEP, SETTLE, TIMED)
    wall, cpu = (step_seconds(clock, found) for clock in zip(*timings, strict=True))
    counts = (statistics.mean(getattr(level.work, name) for level in found) for name in ("newton", "krylov"))
    return (*counts, wall, cpu, first)


def steady(rheology: Any, nodes: int) -> tuple[float, ...]:
    """Newton and Krylov iterations of a steady solve on the finest grid, its wall and processor time, all grids."""
    from ertel.solvers.steady import steady_film as solve

    chosen = case(rheology, nodes, "steady")
    found, clocks = solve(chosen), []
    for _ in range(3):
        cpu = time.process_time()
        wall, found = timed(lambda: solve(chosen))
        clocks.append((wall, time.process_time() - cpu))
    return found.finest.newton, found.finest.krylov, *map(min, zip(*clocks, strict=True))


def main() -> None:
    """Print the tables."""
    keep_compiled()
    for nodes in grids((129,)):
        for what, work, columns in (("step", steps, ("first call, s",)), ("steady solve", steady, ())):
            header((f"{what}, {nodes}²", "Newton", "Krylov", "wall, s", "CPU, s", *columns, "wall ratio", "CPU ratio"))
            newtonian = None
            for name, rheology in oils().items():
                found = work(rheology, nodes)
                newtonian = newtonian or found
                row(name, *found, found[2] / newtonian[2], found[3] / newtonian[3])
            print()


if __name__ == "__main__":
    main()
