"""The memory that a run needs, what the machine has, and which grid fits.

    bytes = BASE + 8 (ARRAYS * nodes that are computed + maps * nodes of the plane)

Measured as the peak of the process on 129 to 1025 nodes per side, within 15 % from 257 on.  The compiled program of an
impact alone needs 87 arrays of the nodes that are computed (22 of the plane, when a quarter of it is computed), that of
steady rolling 115 (57 of the plane): `benchmarks/scaling.py`.
"""

import os
from contextlib import suppress

from ertel.case.case import Case
from ertel.case.grids import grid_of
from ertel.results.variables import FIELDS
from ertel.runs.compile import jax_devices, may_use_accelerator

BASE = 0.55e9  # Python, JAX and the compiler
ARRAYS, ARRAYS_WITH_STEADY = 150, 210  # a run of rolling contains the steady film
MATRICES = 80  # radial: dense matrices of nodes x nodes
EXHAUSTED = "RESOURCE_EXHAUSTED"  # how JAX begins such messages


def needed(case: Case) -> float:
    """The memory in bytes that a run of the case needs, approximately."""
    nodes = case.solver.nodes
    if case.solver.method == "radial":
        return BASE + 8.0 * MATRICES * nodes**2
    arrays = ARRAYS if case.starts_apart else ARRAYS_WITH_STEADY
    return BASE + 8.0 * (arrays * grid_of(case).size + _maps(case) * nodes**2)


def _maps(case: Case) -> float:
    """The number of maps that are stored, approximately; the summary reads all of them."""
    moments = 1 if case.is_steady else case.schedule.duration / case.schedule.interval + 2
    return len(FIELDS) * moments


def available() -> float:
    """The memory in bytes of the device that JAX computes on; 0 where it is not known."""
    if may_use_accelerator() and (limit := (jax_devices()[0].memory_stats() or {}).get("bytes_limit")):
        return float(limit)
    with suppress(AttributeError, ValueError, OSError):  # not on Windows
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return 0.0


def shortage(case: Case) -> str:
    """What the grid of a case needs, what the machine has, and which grid fits, as part of a sentence."""
    there, smaller = available(), case
    with suppress(ValueError):  # the coarsest grid
        smaller = case.on_half_grid()
        while needed(smaller) > there > 0:
            smaller = smaller.on_half_grid()
    has = f", the machine has {_gigabytes(there)}" if there else ""
    return (
        f"solver.nodes = {case.solver.nodes} needs about {_gigabytes(needed(case))} of memory{has}; "
        f"solver.nodes = {smaller.solver.nodes} needs {_gigabytes(needed(smaller))}"
    )


def _gigabytes(amount: float) -> str:
    return f"{amount / 1e9:.2g} GB"


def is_exhausted(error: BaseException) -> bool:
    """Whether an error says that no memory is left."""
    return isinstance(error, MemoryError) or (isinstance(error, RuntimeError) and EXHAUSTED in str(error))
