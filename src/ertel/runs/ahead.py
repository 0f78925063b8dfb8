"""The programs that runs need, and compiling them ahead by short runs.

A program depends on the kind of run, the number of nodes, the axes of symmetry and the laws of the oil; not on M, L,
the constants of the oil, tolerances, times or how far the grid reaches.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from jax import tree

from ertel.case.case import Case
from ertel.case.estimates import grid_of
from ertel.equations.contact import traceable
from ertel.inputs.case_files import parse_case
from ertel.numerics.programs import double_precision
from ertel.runs.drive import result_of, run_of

STEPS = 4  # the first three have histories of different length
STEADY, IN_TIME = 257, 129  # nodes per side: the largest of the usual grids
USUAL = (
    {"name": f"steady rolling, 33 to {STEADY}", "contact": {"kind": "rolling"}, "solver": {"nodes": STEADY}},
    {"name": f"impact, {IN_TIME}", "contact": {"kind": "impact"}, "solver": {"method": "2d", "nodes": IN_TIME}},
    {"name": f"impact, {STEADY}", "contact": {"kind": "impact"}, "solver": {"method": "2d", "nodes": STEADY}},
    {"name": "impact, radial, 401", "contact": {"kind": "impact"}, "solver": {"method": "radial", "nodes": 401}},
)
OIL = {"viscosity": "roelands", "density": "dowson-higginson", "eta0": "40 mPa*s", "alpha": "22 / GPa"}


def program_of(case: Case) -> str:
    """A text that is the same for runs that need the same compiled programs."""
    grid, oil = grid_of(case), traceable(case.lubricant)
    laws = [_structure(law) for law in (oil.viscosity_law, oil.density_law, traceable(case.oil.fluidity_law))]
    shape = (grid.nodes, grid.nodes_y, case.contact.ratio, tuple(grid.even))
    moves = (case.motion.flows, case.motion.inertia > 0)
    return repr(
        (case.kind, case.solver.method, shape, laws, moves, case.thermal and case.thermal.is_solved, case.touches)
    )


def _structure(law: object) -> tuple[str, object, list[tuple[int, ...]]]:
    leaves, structure = tree.flatten(law)
    return type(law).__name__, structure, [np.shape(leaf) for leaf in leaves]


def usual_cases() -> Iterator[Case]:
    """Smooth contacts on the usual grids, with the usual laws of the oil."""
    for case in USUAL:
        yield parse_case({**case, "contact": {**case["contact"], "M": 200, "L": 10}, "lubricant": OIL})  # type: ignore[dict-item]


@double_precision()
def warm_up(case: Case) -> None:
    """Compile what a run of the case needs.

    A steady case is run to its end, a run in time for a few steps.
    """
    run: Any = run_of(case)
    steps = iter(range(STEPS))

    def enough(result: Any) -> bool:
        if case.is_steady or next(steps, None) is not None:
            return False
        run.method.measure(result.state.levels[0])  # as at the moments of which maps are kept
        run.method.friction(result.state.levels[0])
        return True

    result_of(run, [enough])
