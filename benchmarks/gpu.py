"""An impact, a steady film and a rebound on a GPU and on the CPU, and whether both find the same.  Prints a table.

    python benchmarks/gpu.py [nodes ...]            (65 ... 4097 unless said; half an hour)

M = 1000, L = 10.  A step: the impact in its middle, steps of 0.005 on from T = 1.2, as in steps.py.  "Step / its
convolutions" divides its time by that of as many double-precision convolutions alone.  The steady film is computed on
all grids, the second time in a process; "first call" is the first one, which compiles where JAX_COMPILATION_CACHE_DIR
is not set.  The rebound, up to 513², is a whole run from Python, the second time.  The CPU is measured up to 1025².
"Difference" is the largest of P and of H over the largest of each, after steps that both solved to 1e-10, so that both
have one answer; it must stay below 1e-9.  Every row and device is a process of its own.  Ends with one
sentence where there is no GPU.
"""

import os
import statistics
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

from common import child, grids, header, impact, impact_levels, march, rolling, row, seconds, step_seconds, timed

NODES = (65, 129, 257, 513, 1025, 2049, 4097)
MOST_ON_CPU, MOST_OF_A_REBOUND = 1025, 513
STEP, SETTLE, TIMED = 0.005, 3, 7
LARGEST_DIFFERENCE = 1e-9
GPU, CPU = "cuda", "cpu"  # as JAX_PLATFORMS has them
COLUMNS = {
    "step": "step, ms",
    "convolutions": "convolutions a step",
    "convolution": "one convolution, ms",
    "ratio": "step / its convolutions",
    "steady": "steady, s",
    "first": "first call, s",
    "rebound": "rebound, s",
    "steps": "its steps",
}
OF_CPU = ("step", "steady", "rebound")


def main() -> None:
    device = child("gpu", "device()", JAX_PLATFORMS=GPU)
    if not device:
        print("Skipped: JAX finds no GPU here.")
        return
    print(f"{device}, and {os.cpu_count()} cores\n")
    header(["nodes", *COLUMNS.values(), *(f"CPU: {COLUMNS[name]}" for name in OF_CPU), "difference"])
    with tempfile.TemporaryDirectory() as folder:
        differences = [compare(nodes, Path(folder)) for nodes in grids(NODES)]
    if max(differences) > LARGEST_DIFFERENCE:
        sys.exit(f"the results differ by {max(differences):.1e}, more than {LARGEST_DIFFERENCE:g}")


def device() -> str:
    """The kind of the device that JAX computes on; empty where it finds none."""
    from ertel.runs.compile import NoDevice, jax_devices

    try:
        return str(jax_devices()[0].device_kind)
    except NoDevice:
        return ""


def compare(nodes: int, folder: Path) -> float:
    """The row of one grid; the difference of the two devices, 0 where the CPU is not measured."""
    import numpy as np

    files = [str(folder / f"{nodes}-{device}.npz") for device in ("gpu", "cpu")]
    on_gpu = child("gpu", f"measure({nodes}, {files[0]!r})", JAX_PLATFORMS=GPU)
    on_cpu: dict[str, Any] = {}
    difference: float | str = ""
    if nodes <= MOST_ON_CPU:
        on_cpu = child("gpu", f"measure({nodes}, {files[1]!r})", JAX_PLATFORMS=CPU)
        with np.load(files[0]) as gpu, np.load(files[1]) as cpu:
            difference = max(float(np.abs(gpu[name] - cpu[name]).max() / np.abs(cpu[name]).max()) for name in cpu)
    row(f"{nodes}²", *(on_gpu[name] for name in COLUMNS), *(on_cpu.get(name, "") for name in OF_CPU), difference)
    return float(difference or 0.0)


def measure(nodes: int, file: str) -> dict[str, Any]:
    """The figures of one grid on the device of this process; P and H after steps solved to 1e-10 go to the file."""
    import jax
    import numpy as np

    import ertel
    from ertel.equations import contact
    from ertel.solvers import steady
    from ertel.solvers.transient import Transient2D

    warnings.simplefilter("ignore")  # of coarse grids
    exact = Transient2D(impact(1000, nodes, solver={"tolerance": 1e-10}))
    levels, _, _ = march(exact, impact_levels(exact), STEP, 0, SETTLE)
    np.savez(file, P=levels[0].P, H=levels[0].H)
    method = Transient2D(impact(1000, nodes))
    levels, timings, found = march(method, impact_levels(method), STEP, SETTLE, TIMED)
    convolutions = statistics.mean(level.work.convolutions for level in found)
    step = step_seconds([wall for wall, _ in timings], found)
    alone = seconds(jax.jit(contact.deformation), method.contact, levels[0].P)
    first, film = (timed(lambda: waited_film(steady.steady_film(rolling(1000, nodes))))[0] for _ in range(2))
    times: dict[str, Any] = {"rebound": "", "steps": ""}
    if nodes <= MOST_OF_A_REBOUND:
        case = impact(1000, nodes, time={"until": "rebound"})
        wall, result = [timed(lambda: ertel.simulate(case)) for _ in range(2)][-1]
        times = {"rebound": wall, "steps": result.summary["steps"]}
    ratio = step / (convolutions * alone)
    each = {"convolutions": convolutions, "convolution": 1e3 * alone, "ratio": ratio, "steady": film, "first": first}
    return {"step": 1e3 * step, **each, **times}


def waited_film(film: Any) -> Any:
    """The film, once it is computed."""
    film.finest.H.block_until_ready()
    return film


if __name__ == "__main__":
    main()
