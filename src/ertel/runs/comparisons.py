"""The cases with whose runs a run is compared for its error: on the half grid, and there in smaller steps or wider.

Together they cost about 1.2 times the run itself: 1/4 of its nodes, 1/4 in 1.4 times as many steps, and 9/16.
"""

from collections.abc import Mapping
from dataclasses import replace

from ertel.case import derived
from ertel.case.case import Case
from ertel.case.sections import Solver, Time
from ertel.numerics.grid import allowed_nodes
from ertel.physics.units import Quantity
from ertel.results.errors import SMALLER_STEPS, WIDER_DOMAIN


def comparisons(case: Case) -> Mapping[str, Case]:
    """The cases by the part of the error that they tell: "grid", "time" (not if steady), "domain"."""
    half = case.on_half_grid()
    found = {"grid": half, "domain": replace(half, solver=wider(half.solver))}
    if case.time is not None:
        found["time"] = replace(half, time=in_smaller_steps(case.time))
    return found


def in_smaller_steps(time: Time) -> Time:
    """Steps smaller by sqrt(1/2); of those that a tolerance controls, the size goes as its cube root."""
    step = time.step
    if step is None:
        return replace(time, tolerance=time.tolerance * SMALLER_STEPS**3)
    smaller = replace(step, value=SMALLER_STEPS * step.value) if isinstance(step, Quantity) else SMALLER_STEPS * step
    return replace(time, step=smaller)


def wider(solver: Solver) -> Solver:
    """The domain 1.5 times as wide, at the same spacing: as near as grids allow."""
    if solver.method == "radial":
        width = WIDER_DOMAIN * solver.half_width
        cells = (solver.nodes - 1) * derived.extent(width) / derived.extent(solver.half_width)
        return replace(solver, half_width=width, nodes=round(cells) + 1)
    spacing = 2 * solver.half_width / (solver.nodes - 1)
    nodes = allowed_nodes(WIDER_DOMAIN * (solver.nodes - 1) + 1)
    inlet = solver.inlet and solver.inlet + spacing * ((nodes - solver.nodes) * solver.inlet // (2 * solver.half_width))
    across = solver.half_width_y and WIDER_DOMAIN * solver.half_width_y
    return replace(solver, nodes=nodes, half_width=spacing * (nodes - 1) / 2, half_width_y=across, inlet=inlet)
