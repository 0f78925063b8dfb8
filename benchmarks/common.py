"""What the benchmarks share: cases, clocks, tables, processes of their own.  Nothing here is measured.

ertel and JAX are imported where they are needed: a child process chooses its platform and cache first.
"""

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
os.environ["JAX_ENABLE_X64"] = "1"  # ertel itself asks JAX for double precision in its public functions alone


def impact(M: float, nodes: int, L: float = 10.0, **sections: dict[str, Any]) -> Any:
    """The case of an impact on nodes x nodes, Roelands and Dowson-Higginson; sections as in a case file."""
    from ertel import parse_case

    solver = {"nodes": nodes, **sections.pop("solver", {})}
    return parse_case({"contact": {"kind": "impact", "M": M, "L": L}, "solver": solver, **sections})


def rolling(M: float, nodes: int, L: float = 10.0, tolerance: float = 1e-6, in_time: bool = False) -> Any:
    """The case of a dimensionless rolling contact, the same oil: steady, or in time with a load that rises."""
    from ertel import parse_case

    solver = {"method": "transient" if in_time else "steady", "nodes": nodes, "tolerance": tolerance}
    motion = {"motion": {"load": [[0.0, 1.0], [1.0, 1.5]]}} if in_time else {}
    return parse_case({"contact": {"kind": "rolling", "M": M, "L": L}, "solver": solver, **motion})


def seconds(work: Callable[..., Any], *arguments: Any, repeats: int = 9, clock: Any = time.perf_counter) -> float:
    """Least time of a call that was warmed up, waited for: what others do on the machine only adds to it."""
    import jax

    jax.block_until_ready(work(*arguments))
    times = []
    for _ in range(repeats):
        start = clock()
        jax.block_until_ready(work(*arguments))
        times.append(clock() - start)
    return min(times)


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Wall time of one call, and what it gave."""
    start = time.perf_counter()
    result = work()
    return time.perf_counter() - start, result


def impact_levels(method: Any, until: float = 1.2) -> list[Any]:
    """The last time levels of an impact at T = until, newest first, interpolated from a run on at most 65 nodes."""
    from dataclasses import replace

    import jax.numpy as jnp

    from ertel.equations import contact
    from ertel.numerics import multigrid
    from ertel.runs.drive import drive, run_of

    p, nodes = method.case.parameters, min(65, method.grid.nodes_x)
    coarse = impact(p.M, nodes, p.L, time={"until": until})
    levels = []
    for level in drive(run_of(coarse)).state.levels:
        P = jnp.asarray(level.P)
        while P.shape[0] < method.grid.shape[0]:
            P = multigrid.prolong(P)
        H = contact.film_thickness(method.contact, P, level.approach)
        fields = {"P": P, "H": H, "mass": contact.mass(method.contact, P, H)}
        levels.append(replace(level, fields=fields, around=None))  # not counted on this grid
    return levels


def march(method: Any, levels: Sequence[Any], step: float, settle: int, timed_steps: int) -> tuple[list[Any], Any, Any]:
    """Fixed steps from these levels: the last levels; times (wall, CPU) and new levels of all but the first few."""
    import jax

    timings, found, levels = [], [], list(levels)
    for number in range(settle + timed_steps):
        cpu = time.process_time()
        wall, new = timed(lambda levels=levels: waited(method.advance(levels, step), jax))
        if number >= settle:
            timings.append((wall, time.process_time() - cpu))
            found.append(new)
        levels = [new, *levels][:3]
    return levels, timings, found


def step_seconds(timings: Sequence[float], levels: Sequence[Any]) -> float:
    """Of a step with the mean number of convolutions, from the step that was least disturbed for its number."""
    each = min(wall / level.work.convolutions for wall, level in zip(timings, levels, strict=True))
    return each * statistics.mean(level.work.convolutions for level in levels)


def keep_compiled() -> None:
    """Small programs too go to the compilation cache, where one is set."""
    import jax

    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)


def waited(level: Any, jax: Any) -> Any:
    jax.block_until_ready(level.H)
    return level


def slope(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Of a straight line through the logarithms."""
    import numpy as np

    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


# -- tables ------------------------------------------------------------------------------------------------------------


def header(columns: Iterable[str]) -> None:
    names = list(columns)
    print("| " + " | ".join(names) + " |\n|" + " --- |" * len(names), flush=True)


def row(*cells: object) -> None:
    print("| " + " | ".join(f"{c:.3g}" if isinstance(c, float) else str(c) for c in cells) + " |", flush=True)


def grids(default: Sequence[int]) -> list[int]:
    """Numbers of nodes from the command line, or these."""
    return [int(a) for a in sys.argv[1:] if a.isdigit()] or list(default)


# -- processes ---------------------------------------------------------------------------------------------------------


def child(module: str, call: str, python: str = sys.executable, **environment: str) -> Any:
    """What a call in a benchmark gives (plain data) in a process of its own: own memory, own compilations."""
    code = f"import json, {module}; print(json.dumps({module}.{call}))"
    paths = os.pathsep.join([str(HERE), str(HERE / "peers"), os.environ.get("PYTHONPATH", "")])
    env = {**os.environ, **environment, "PYTHONPATH": paths}
    done = subprocess.run([python, "-c", code], check=True, stdout=subprocess.PIPE, text=True, env=env)
    return json.loads(done.stdout.splitlines()[-1])
