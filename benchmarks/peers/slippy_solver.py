"""A steady rolling contact by slippy, in its own Python (it needs NumPy < 2 and SciPy < 1.12, and no ertel)."""

import contextlib
import io
import tempfile
import time
import warnings
from itertools import count
from pathlib import Path
from typing import Any

RELAXATION, TOLERANCE = 0.05, 2e-6  # that of its own example, and its default
_numbers = count()  # slippy wants every material to have a name of its own


def available() -> str:
    """slippy's version; raises ImportError where it is absent."""
    from importlib.metadata import version

    import slippy.contact  # noqa: F401

    return version("slippy")


def solve(nodes: int, half_width: float, physical: dict[str, float], iterations: int) -> dict[str, Any]:
    """Films in units a^2/R on nodes x nodes over [-half_width a, half_width a]^2, from no pressure; CPU seconds.

    physical: R, E_prime, a, p_h, load, speed (mean), eta0, p0 and z (Roelands), all in SI.
    """
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as directory, contextlib.chdir(directory):  # it writes files where it runs
        _solve(nodes, half_width, physical, 3)  # compiles
        start = time.process_time()
        state = _solve(nodes, half_width, physical, iterations)
        cpu = time.process_time() - start
        done = Path("contact.log").read_text().count("er_load")
    gap, pressure, middle = state["nd_gap"], state["nd_pressure"], nodes // 2
    return {
        "H_c": float(gap[middle, middle]),
        "H_min": float(gap[pressure > 0].min()),
        "load": float(state["total_normal_load"] / physical["load"]),
        "converged": bool(state["converged"]),
        "iterations": done,
        "seconds": cpu,
    }


def _solve(nodes: int, half_width: float, physical: dict[str, float], iterations: int) -> Any:
    import slippy
    import slippy.contact as c
    import slippy.surface as s

    slippy.CUDA = False
    q, nu = physical, 0.3
    spacing = 2 * half_width * q["a"] / (nodes - 1)
    ball = s.RoundSurface((q["R"],) * 3, shape=(nodes, nodes), grid_spacing=spacing, generate=True)
    flat = s.FlatSurface()
    ball.material = flat.material = c.Elastic(f"metal {next(_numbers)}", {"E": q["E_prime"] * (1 - nu**2), "v": nu})
    oil = c.Lubricant("oil")
    oil.add_sub_model("nd_viscosity", c.lubricant_models.nd_roelands(q["eta0"], q["p0"], q["p_h"], q["z"]))
    oil.add_sub_model("nd_density", c.lubricant_models.nd_dowson_higginson(q["p_h"]))
    model = c.ContactModel("contact", ball, flat, oil)
    reynolds = c.UnifiedReynoldsSolver(0, spacing, q["p_h"], q["R"], q["a"], q["eta0"], 872.0)
    limits = {"relaxation_factor": RELAXATION, "max_it_pressure": iterations, "rtol_pressure": TOLERANCE}
    model.add_step(c.IterSemiSystem("main", reynolds, q["speed"], 1, no_time=True, normal_load=q["load"], **limits))
    with contextlib.redirect_stdout(io.StringIO()):
        return model.solve(skip_data_check=True)
