"""Error of H_c and H_min at maximum approach against the number of time steps, adaptive and fixed.  Prints a table.

    python benchmarks/time_error.py [nodes]     (65 unless said; two minutes)

The impact is M = 1000, L = 10.  The discrete equations are solved to 1e-7, so that the error is that of time alone.  The
reference is an adaptive run to 1e-8.  "Fixed steps needed" is how many fixed steps have the same error of H_c, from
a straight line through the logarithms of the fixed runs.
"""

import math
from typing import Any

from common import grids, header, impact, row, slope

M, FINEST = 1000.0, 1e-8
TOLERANCES = (1e-3, 3e-4, 1e-4, 5e-5, 1e-5, 1e-6)
STEPS = (0.04, 0.02, 0.01, 0.005, 0.0025)
COLUMNS = ("time", "steps", "rejected", "error of H_c", "error of H_min", "fixed steps needed / steps")


def main() -> None:
    import jax

    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.3)
    nodes = grids((65,))[0]
    exact = run(nodes, tolerance=FINEST)
    fixed = {f"step {step:g}": errors(run(nodes, step=step), exact) for step in STEPS}
    adaptive = {f"tolerance {tol:g}": errors(run(nodes, tolerance=tol), exact) for tol in TOLERANCES}
    order = -slope(*zip(*((steps, H_c) for steps, _, H_c, _ in fixed.values()), strict=True))
    last = list(fixed.values())[-1]
    print(f"M = {M:g}, L = 10, {nodes}²; reference: {exact['steps']} steps, H_c = {exact['H_c']:.6g}\n")
    header(COLUMNS)
    for name, (steps, rejected, H_c, H_min) in {**adaptive, **fixed}.items():
        needed = last[0] * (last[2] / H_c) ** (1 / order) / (steps + rejected)
        row(name, steps, rejected, H_c, H_min, needed if name in adaptive else "")
    powers = [-slope(*zip(*((s, e) for s, _, e, _ in runs.values()), strict=True)) for runs in (adaptive, fixed)]
    print(f"\nerror of H_c ~ steps^-{powers[0]:.2f} (adaptive), steps^-{powers[1]:.2f} (fixed)")


def run(nodes: int, **time: Any) -> dict[str, float]:
    """Films at maximum approach, and the steps that it took; until="max-approach"."""
    from ertel import simulate

    result = simulate(impact(M, nodes, solver={"tolerance": 1e-7}, time=time))
    rejected = int(result.dataset.rejected.sum())
    return {**result.summary["max_approach"], "steps": result.dataset.sizes["time"], "rejected": rejected}


def errors(found: dict[str, float], exact: dict[str, float]) -> tuple[int, int, float, float]:
    if not found.get("H_c"):
        return int(found["steps"]), int(found["rejected"]), math.nan, math.nan
    H_c, H_min = (abs(found[name] / exact[name] - 1) for name in ("H_c", "H_min"))
    return int(found["steps"]), int(found["rejected"]), H_c, H_min


if __name__ == "__main__":
    main()
