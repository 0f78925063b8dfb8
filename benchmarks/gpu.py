"""The same time steps on the CPU and on the GPU: seconds a step, their ratio, and the difference of the results.

    JAX_PLATFORMS=cuda,cpu python benchmarks/gpu.py [nodes ...]      (513 1025 2049 unless said; ten minutes)

Impact, M = 1000, L = 10, steps of 0.005 on from T = 1.2, solved to 1e-10 so that both have one answer.  "Difference" is
the largest of P and of H over the largest of each; it must stay below 1e-9.  Ends with one sentence where there is no
GPU.
"""

import sys
from typing import Any

from common import grids, header, impact, impact_levels, march, row, step_seconds

NODES = (513, 1025, 2049)
STEP, SETTLE, TIMED = 0.005, 3, 7
LARGEST_DIFFERENCE = 1e-9
COLUMNS = ("nodes", "CPU, s", "GPU, s", "CPU / GPU", "difference")


def main() -> None:
    import jax

    try:
        gpu, cpu = jax.devices("gpu")[0], jax.devices("cpu")[0]
    except RuntimeError:
        print("Skipped: JAX finds no GPU here (or JAX_PLATFORMS leaves one of the two out).")
        return
    print(f"{gpu.device_kind}\n")
    header(COLUMNS)
    differences = [compare(nodes, cpu, gpu) for nodes in grids(NODES)]
    if max(differences) > LARGEST_DIFFERENCE:
        sys.exit(f"the results differ by {max(differences):.1e}, more than {LARGEST_DIFFERENCE:g}")


def compare(nodes: int, cpu: Any, gpu: Any) -> float:
    import numpy as np

    (t_cpu, on_cpu), (t_gpu, on_gpu) = (measure(nodes, device) for device in (cpu, gpu))
    difference = max(
        float(np.abs(a - b).max() / np.abs(a).max())
        for a, b in zip(map(np.asarray, on_cpu), map(np.asarray, on_gpu), strict=True)
    )
    row(f"{nodes}²", t_cpu, t_gpu, t_cpu / t_gpu, difference)
    return difference


def measure(nodes: int, device: Any) -> tuple[float, tuple[Any, Any]]:
    """Seconds a step, and P and H after the last."""
    import jax

    from ertel.solvers.transient import Transient2D

    with jax.default_device(device):
        method = Transient2D(impact(1000, nodes, solver={"tolerance": 1e-10}))
        levels, timings, found = march(method, impact_levels(method), STEP, SETTLE, TIMED)
    return step_seconds([wall for wall, _ in timings], found), (levels[0].P, levels[0].H)


if __name__ == "__main__":
    main()
