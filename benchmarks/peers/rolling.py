"""A steady rolling contact by ertel and by slippy: same physical case, domain, grid; time and error.  Prints a table.

    SLIPPY_PYTHON=path/to/python python benchmarks/peers/rolling.py [nodes ...]      (65 unless said; five minutes)

M = 100, L = 5 (Roelands, Dowson and Higginson), |X|, |Y| <= 3.  SLIPPY_PYTHON: of an environment with slippy (see
README.md here), this one unless said.  "Error" is to the converged value: ertel on 257² and 513², extrapolated.  Both
programs run once to compile and once on the clock, from their own first guess to their own tolerance.
"""

import os
import subprocess
import sys
import time
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from common import child, grids, header, keep_compiled, rolling, row

M, L, HALF_WIDTH, ITERATIONS = 100.0, 5.0, 3.0, 20000
R, E_PRIME = 0.01, 2.2e11  # m, Pa: any will do, the films are compared in a^2/R
COLUMNS = ("program", "nodes", "H_c", "error", "H_min", "error", "iterations", "CPU s", "CPU s / ertel's")


def main() -> None:
    keep_compiled()
    from ertel.numerics.grid import extrapolate
    from ertel.solvers import steady

    python = os.environ.get("SLIPPY_PYTHON", sys.executable)
    half, fine = (s.measure() for s in steady.steady_film(case(513)).solutions[-2:])
    exact = {name: extrapolate(half[name], fine[name]).extrapolated for name in ("H_c", "H_min")}
    print(f"M = {M:g}, L = {L:g}; converged: H_c = {exact['H_c']:.4f}, H_min = {exact['H_min']:.4f}\n", flush=True)
    skipped = ""
    header(COLUMNS)
    for nodes in grids((65,)):
        own = by_ertel(nodes)
        show("ertel", nodes, own, exact, own)
        try:
            call = f"solve({nodes}, {HALF_WIDTH}, {physical()!r}, {ITERATIONS})"
            other = child("slippy_solver", call, python, PYTHONWARNINGS="ignore")
            show("slippy", nodes, other, exact, own)
        except (subprocess.CalledProcessError, FileNotFoundError):
            skipped = f"slippy skipped: it does not run in {Path(python).name} (see README.md beside this script)."
    print(f"\n{skipped}" if skipped else "")


def case(nodes: int) -> Any:
    found = rolling(M, nodes, L)
    return replace(found, solver=replace(found.solver, half_width=HALF_WIDTH, inlet=HALF_WIDTH))


def by_ertel(nodes: int) -> dict[str, Any]:
    from ertel.solvers import steady

    steady.steady_film(case(nodes))
    start = time.process_time()
    found = steady.steady_film(case(nodes)).finest
    found_in = time.process_time() - start
    return {**found.measure(), "iterations": found.newton, "seconds": found_in}


def physical() -> dict[str, float]:
    """The case in SI."""
    from ertel.physics.lubricant import ALPHA, ETA0, P0_ROELANDS, roelands_exponent
    from ertel.physics.scales import Parameters

    p = Parameters.from_moes(M, L)
    p_h = p.alpha_bar / ALPHA
    a = pi * R * p_h / E_PRIME
    load, speed = 2 * pi / 3 * a**2 * p_h, p.lambda_bar * a**3 * p_h / (12 * ETA0 * R**2)
    oil = {"eta0": ETA0, "p0": P0_ROELANDS, "z": roelands_exponent(ALPHA, ETA0)}
    return {"R": R, "E_prime": E_PRIME, "a": a, "p_h": p_h, "load": load, "speed": speed, **oil}


def show(program: str, nodes: int, found: dict[str, Any], exact: dict[str, float], own: dict[str, Any]) -> None:
    films = (f for name in exact for f in (found[name], f"{found[name] / exact[name] - 1:+.1%}"))
    row(program, f"{nodes}²", *films, found["iterations"], found["seconds"], found["seconds"] / own["seconds"])


if __name__ == "__main__":
    main()
