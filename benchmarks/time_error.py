"""Error of H_c and H_min at maximum approach against the number of time steps, adaptive and fixed.  Prints a table.

    python benchmarks/time_error.py [nodes]     (65 unless said; two minutes)

The impact is M = 1000, L = 10.  The discrete equations are solved to 1e-7, so that the error is that of time alone.
The reference is an adaptive run to 1e-8.  "Fixed / steps" is how many times as many fixed steps have the same error,
from a straight line through the logarithms of the fixed runs.
"""

from typing import Any

from common import grids, header, impact, keep_compiled, row, slope

M, FINEST = 1000.0, 1e-8
TOLERANCES = (1e-3, 3e-4, 1e-4, 5e-5, 1e-5, 1e-6)
STEPS = (0.04, 0.02, 0.01, 0.005, 0.0025)
COLUMNS = ("time", "steps", "rejected", "error of H_c", "error of H_min", "fixed / steps, H_c", "fixed / steps, H_min")


def main() -> None:
    keep_compiled()
    nodes = grids((65,))[0]
    exact = run(nodes, tolerance=FINEST)
    fixed = {f"step {step:g}": errors(run(nodes, step=step), exact) for step in STEPS}
    adaptive = {f"tolerance {tol:g}": errors(run(nodes, tolerance=tol), exact) for tol in TOLERANCES}
    powers = {name: [power(runs, which) for which in (2, 3)] for name, runs in (("a", adaptive), ("f", fixed))}
    last = list(fixed.values())[-1]
    print(f"M = {M:g}, L = 10, {nodes}²; reference: {exact['steps']} steps, H_c = {exact['H_c']:.6g}\n")
    header(COLUMNS)
    for name, found in {**adaptive, **fixed}.items():
        needed = [last[0] * (last[2 + k] / found[2 + k]) ** (1 / powers["f"][k]) / sum(found[:2]) for k in (0, 1)]
        row(name, *found, *(needed if name in adaptive else ("", "")))
    for k, name in enumerate(("H_c", "H_min")):
        print(f"\nerror of {name} ~ steps^-{powers['a'][k]:.2f} (adaptive), steps^-{powers['f'][k]:.2f} (fixed)")


def power(runs: dict[str, tuple[int, int, float, float]], which: int) -> float:
    """With which the error falls with the steps."""
    return -slope([found[0] for found in runs.values()], [found[which] for found in runs.values()])


def run(nodes: int, **time: Any) -> dict[str, float]:
    """Films at maximum approach, and the steps that it took; until="max-approach"."""
    from ertel import simulate

    result = simulate(impact(M, nodes, solver={"tolerance": 1e-7}, time=time))
    rejected = int(result.dataset.rejected.sum())
    return {**result.summary, "steps": result.dataset.sizes["time"], "rejected": rejected}


def errors(found: dict[str, float], exact: dict[str, float]) -> tuple[int, int, float, float]:
    H_c, H_min = (abs(found[name] / exact[name] - 1) for name in ("H_c", "H_min"))
    return int(found["steps"]), int(found["rejected"]), H_c, H_min


if __name__ == "__main__":
    main()
