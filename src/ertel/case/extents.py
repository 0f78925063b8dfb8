"""The size of the grid: defaults that follow the ellipse, and the side along y."""

from dataclasses import replace

from ertel.case.sections import Solver
from ertel.numerics.grid import allowed_nodes, nodes_across
from ertel.physics.geometry import CIRCLE, Geometry

PARTS = 16  # of the length; the contact's centre ends one, so that it is a node of this grid and of the coarser ones


def suited(circular: Solver, geometry: Geometry) -> Solver:
    """The default solver of a circular contact, with half width, inlet and nodes for another geometry.

    On every side the edge has the same distance from the contact, in units of its smaller half width, and the spacing
    has the same size in these units.
    """
    if geometry is CIRCLE:
        return circular
    reach, unit = geometry.extent[0], geometry.smaller
    length, spacing = 2 * (reach + (circular.half_width - 1) * unit), 2 * circular.half_width / (circular.nodes - 1)
    inlet = circular.inlet
    if inlet is not None:
        upstream = reach + (inlet - 1) * unit
        share = round(PARTS * upstream / length) / PARTS
        length = max(upstream / share, (length - upstream) / (1 - share))
        inlet = share * length
    nodes = allowed_nodes(length / (spacing * unit) * (1 - 1e-9) + 1)
    return replace(circular, half_width=length / 2, inlet=inlet, nodes=nodes)


def half_width_y(solver: Solver, geometry: Geometry) -> float | None:
    """The half width along y in effect, a little more than wanted so that multigrid can coarsen.

    Left out, the edge has the same distance from the contact along y as along x.  None: left out, and as along x.
    """
    along_x, along_y = geometry.extent
    default = solver.half_width + along_y - along_x
    nodes, usual = (
        nodes_across(solver.nodes, wanted / solver.half_width) for wanted in (solver.half_width_y or default, default)
    )
    if nodes == usual == solver.nodes:
        return None
    return solver.half_width * (nodes - 1) / (solver.nodes - 1)
