"""The cases with whose runs a run is compared for its error: on the half grid, and there in larger steps or wider.

Together they cost less than the run itself: 1/4 of its nodes, 1/4 in half as many steps, and 9/16.
"""

from collections.abc import Mapping
from dataclasses import replace

from ertel.model.case import Case
from ertel.model.sections import Solver, Time
from ertel.numerics.grid import allowed_nodes
from ertel.physics.units import Quantity
from ertel.results.errors import LARGER_STEPS, WIDER_DOMAIN
from ertel.solvers import radial

MOST = 0.5  # time tolerance; a larger one has no meaning


def comparisons(case: Case) -> Mapping[str, Case]:
    """The cases by the part of the error that they tell: "grid", "time" (not if steady), "domain"."""
    half = case.on_half_grid()
    found = {"grid": half, "domain": replace(half, solver=wider(half.solver))}
    if case.time is not None:
        found["time"] = replace(half, time=in_larger_steps(case.time))
    return found


def in_larger_steps(time: Time) -> Time:
    """Steps twice as large; of those that a tolerance controls, the size is its cube root."""
    if time.step is None:
        return replace(time, tolerance=min(time.tolerance * LARGER_STEPS**3, MOST))
    step = time.step
    larger = replace(step, value=LARGER_STEPS * step.value) if isinstance(step, Quantity) else LARGER_STEPS * step
    return replace(time, step=larger)


def wider(solver: Solver) -> Solver:
    """The domain 1.5 times as wide, at the same spacing: as near as grids allow."""
    if solver.method == "radial":
        width = WIDER_DOMAIN * solver.half_width
        cells = (solver.nodes - 1) * radial.extent(width) / radial.extent(solver.half_width)
        return replace(solver, half_width=width, nodes=round(cells) + 1)
    spacing = 2 * solver.half_width / (solver.nodes - 1)
    nodes = allowed_nodes(WIDER_DOMAIN * (solver.nodes - 1) + 1)
    inlet = solver.inlet and solver.inlet + spacing * ((nodes - solver.nodes) * solver.inlet // (2 * solver.half_width))
    return replace(solver, nodes=nodes, half_width=spacing * (nodes - 1) / 2, inlet=inlet)
