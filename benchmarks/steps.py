"""What a time step of the 2-D method costs: counts, seconds, shares, compile time and memory.  Prints a table.

    python benchmarks/steps.py [nodes ...]          (129 257 513 1025 unless said; a few minutes)

The impact is M = 1000, L = 10.  Each grid is measured in a process of its own: the state at T = 1.2 comes from a run
on 65 x 65 nodes, interpolated; a few steps settle it, the next are timed.  Times are medians of one noisy machine: read
the ratios.
"""

import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

STEP, SETTLE, TIMED = 0.005, 4, 10
COLUMNS = {
    "convolutions": "convolutions a step",
    "krylov": "Krylov a step",
    "seconds": "seconds a step",
    "ratio": "time / its convolutions",
    "fft": "FFT share",
    "smoother": "smoother share",
    "rest": "rest",
    "cold": "compile cold, s",
    "cached": "compile cached, s",
    "memory": "peak memory, MiB",
}


def measure(nodes: int, cache: str) -> dict[str, float]:
    """All figures of one grid but the cached compile time."""
    import jax

    jax.config.update("jax_compilation_cache_dir", cache)
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.3)
    import jax.numpy as jnp

    from ertel import contact, halfspace, multigrid
    from ertel.config import parse_case
    from ertel.level import Level
    from ertel.simulation import transient
    from ertel.transient2d import Transient2D

    def case_on(n: int) -> Any:
        solver = {"nodes": n}
        return parse_case({"contact": {"kind": "impact", "M": 1000, "L": 10}, "solver": solver, "time": {"until": 1.2}})

    def seconds(work: Callable[[], Any], repeats: int = 7) -> float:
        jax.block_until_ready(work())
        times = []
        for _ in range(repeats):
            start = time.perf_counter()
            jax.block_until_ready(work())
            times.append(time.perf_counter() - start)
        return statistics.median(times)

    method = Transient2D(case_on(nodes))
    start = time.perf_counter()
    method.advance([method.start().level], 1e-4)
    compile_seconds = time.perf_counter() - start
    *_, last = transient(case_on(65))
    levels = []
    for level in last.state.levels:
        P = jnp.asarray(level.P)
        while P.shape[0] < method.grid.shape[0]:
            P = multigrid.prolong(P)
        levels.append(level._replace(P=P, H=contact.film_thickness(method.contact, P, level.approach)))
    timings, attempts = [], []
    for number in range(SETTLE + TIMED):
        start = time.perf_counter()
        attempt = method.advance(levels, STEP)
        jax.block_until_ready(attempt.level.H)
        if number >= SETTLE:
            timings.append(time.perf_counter() - start)
            attempts.append(attempt)
        levels = [attempt.level, *levels][:3]

    P: Any = levels[0].P
    now: Level = levels[0]
    deform, smooth = jax.jit(contact.deformation), jax.jit(multigrid.smooth)
    convolve = jax.jit(halfspace.displacement, static_argnums=2)
    exact = seconds(lambda: deform(method.contact, P))
    one = jnp.ones_like(P)
    free = contact.inside(one, method.grid.even)
    coefficients = (contact.mobility(method.contact, P, now.H), one / STEP, 0 * one, free)
    coarse = multigrid.Coefficients(*(c.astype(method.elastic[0].spectrum.dtype) for c in coefficients))
    per_cycle = {"fft": 0.0, "smoother": 0.0}
    levels_of_grids = multigrid.hierarchy(method.elastic, coarse)
    for level in levels_of_grids[1:]:  # the finest grid has no convolution in a V-cycle
        e, kernel = level.coefficients.free, level.elasticity.spectrum
        per_cycle["fft"] += 2 * seconds(lambda e=e, kernel=kernel: convolve(kernel, e, method.grid.even))
    for level in levels_of_grids[:-1]:
        e = level.coefficients.free
        per_cycle["smoother"] += 2 * seconds(lambda e=e, level=level: smooth(level, e))
    step = statistics.median(timings)
    krylov = statistics.mean(a.krylov for a in attempts)
    newton = statistics.mean(a.newton for a in attempts)
    convolutions = statistics.mean(a.convolutions for a in attempts)
    fft = ((1 + newton + krylov) * exact + krylov * per_cycle["fft"]) / step
    smoother = krylov * per_cycle["smoother"] / step
    return {
        "convolutions": convolutions,
        "krylov": krylov,
        "seconds": step,
        "ratio": step / (convolutions * exact),
        "fft": fft,
        "smoother": smoother,
        "rest": 1 - fft - smoother,
        "cold": compile_seconds,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def main() -> None:
    grids = [int(a) for a in sys.argv[1:]] or [129, 257, 513, 1025]
    print("| nodes | " + " | ".join(COLUMNS.values()) + " |")
    print("| --- " * (len(COLUMNS) + 1) + "|")
    for nodes in grids:
        with tempfile.TemporaryDirectory() as cache:
            cold, cached = (child(nodes, cache) for _ in range(2))
        row = replace_cold(cold, cached)
        print(f"| {nodes}² | " + " | ".join(f"{row[key]:.3g}" for key in COLUMNS) + " |", flush=True)


def replace_cold(cold: dict[str, float], cached: dict[str, float]) -> dict[str, float]:
    """The second process ran undisturbed by compiling: its figures, with the first one's compile time."""
    return {**cached, "cold": cold["cold"], "cached": cached["cold"]}


def child(nodes: int, cache: str) -> dict[str, float]:
    code = f"import json, steps; print(json.dumps(steps.measure({nodes}, {cache!r})))"
    command = [sys.executable, "-c", code]
    output = subprocess.run(command, cwd=__file__.rsplit("/", 1)[0], check=True, capture_output=True, text=True).stdout
    result: dict[str, float] = json.loads(output.splitlines()[-1])
    return result


if __name__ == "__main__":
    main()
