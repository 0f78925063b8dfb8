"""The places of a method's nodes, on a plane or along a radius, and what follows from them for grid and domain."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ertel.case.sections import Solver
from ertel.numerics.grid import Grid, allowed_nodes, check_coarsening, nodes_across
from ertel.physics.geometry import CIRCLE, Geometry

EDGE = 1.0  # maximum radius of the dry contact: the grid is finest here, where the film is thinnest
WIDENING_INSIDE = 1.5  # the spacing at distance d from the edge is 1 + widening * d times that at the edge
WIDENING_OUTSIDE = 8.0
FRONT_POSITION = 0.9  # a: where the front of an impact is looked at, and the spacing of a radial grid
SMALLEST_RADIUS = 1.2  # of a radial grid: the contact grows to radius 1 and needs an inlet
PARTS = 16  # of the length; the contact's centre ends one, so that it is a node of this grid and of the coarser ones


class AlongX:
    """The nodes of a method: a uniform row of them along the flow, for a line contact; nothing changes across it.

    axes: of the maps of a run, in order.  lacks: the keys of [solver] that have no meaning.
    """

    axes: tuple[str, ...] = ("X",)
    lacks: tuple[str, ...] = ("half_width_y",)

    def across(self, solver: Solver) -> int:
        """The number of nodes across the flow; 1 where there is only one axis."""
        return 1

    def in_words(self, nodes: int, across: int) -> str:
        """The number of nodes in words."""
        return f"{nodes} nodes along x"

    def spacing(self, solver: Solver) -> float:
        """The spacing in a, where it counts."""
        return 2.0 * solver.half_width / (solver.nodes - 1)

    def suited(self, circular: Solver, geometry: Geometry) -> Solver:
        """The default solver of a circular contact, for another geometry."""
        return circular

    def completed(self, solver: Solver, geometry: Geometry) -> Solver:
        """The solver of a case with what follows from the geometry."""
        return solver

    def wider(self, solver: Solver, factor: float) -> Solver:
        """The domain wider by a factor, at the same spacing: as near as grids allow."""
        spacing = self.spacing(solver)
        nodes = allowed_nodes(factor * (solver.nodes - 1) + 1)
        more = (nodes - solver.nodes) * (solver.inlet or 0.0) // (2 * solver.half_width)
        inlet = solver.inlet and solver.inlet + spacing * more
        across = solver.half_width_y and factor * solver.half_width_y
        return replace(solver, nodes=nodes, half_width=spacing * (nodes - 1) / 2, half_width_y=across, inlet=inlet)

    def complaints(self, solver: Solver, geometry: Geometry, grown: float) -> Iterator[tuple[str, str]]:
        """The fields that are not allowed, and what is wrong: the contact must lie inside the nodes.

        grown: its size where it is largest, as on the flat flank of a cam, over that of R and F*.
        """
        try:
            check_coarsening(Grid(solver.nodes, self.across(solver), 1.0))
        except ValueError as error:
            entry, _, complaint = str(error).partition(": ")
            yield entry, complaint
        along_x, along_y = (grown * extent for extent in geometry.extent)
        inside = "so that the contact lies inside the grid" + (" at all times" if grown > 1.0 else "")
        if not solver.half_width > along_x:
            yield "half_width", f"must be greater than {along_x:g}, {inside}"
        if solver.half_width_y is not None and not solver.half_width_y > along_y:
            yield "half_width_y", f"must be greater than {along_y:g}, {inside}"
        most = 2 * solver.half_width - along_x
        if solver.inlet is not None and not along_x < solver.inlet < most:
            yield "inlet", f"must be above {along_x:g} and below {most:g} = 2 half_width - {along_x:g}, {inside}"


class OnThePlane(AlongX):
    """A uniform grid on a rectangle, which multigrid can coarsen."""

    axes, lacks = ("Y", "X"), ()

    def across(self, solver: Solver) -> int:
        return nodes_across(solver.nodes, (solver.half_width_y or solver.half_width) / solver.half_width)

    def in_words(self, nodes: int, across: int) -> str:
        return f"{nodes} x {across} nodes"

    def suited(self, circular: Solver, geometry: Geometry) -> Solver:
        """The default solver of a circular contact, with half width, inlet and nodes for another geometry.

        On every side the edge has the same distance from the contact, in units of its smaller half width, and the
        spacing has the same size in these units.
        """
        if geometry is CIRCLE:
            return circular
        reach, unit = geometry.extent[0], geometry.smaller
        length, spacing = 2 * (reach + (circular.half_width - 1) * unit), self.spacing(circular)
        inlet = circular.inlet
        if inlet is not None:
            upstream = reach + (inlet - 1) * unit
            share = round(PARTS * upstream / length) / PARTS
            length = max(upstream / share, (length - upstream) / (1 - share))
            inlet = share * length
        nodes = allowed_nodes(length / (spacing * unit) * (1 - 1e-9) + 1)
        return replace(circular, half_width=length / 2, inlet=inlet, nodes=nodes)

    def completed(self, solver: Solver, geometry: Geometry) -> Solver:
        """The half width along y in effect, a little more than asked for so that multigrid can coarsen.

        Left out, the edge has the same distance from the contact along y as along x.  None: left out, and as along x.
        """
        along_x, along_y = geometry.extent
        default = solver.half_width + along_y - along_x
        widths = solver.half_width_y or default, default
        nodes, usual = (nodes_across(solver.nodes, width / solver.half_width) for width in widths)
        if nodes == usual == solver.nodes:
            return replace(solver, half_width_y=None)
        return replace(solver, half_width_y=solver.half_width * (nodes - 1) / (solver.nodes - 1))


class AlongTheRadius(AlongX):
    """Nodes from the centre outwards, finest at the edge of the contact."""

    axes, lacks = ("r",), ("inlet", "half_width_y")

    def in_words(self, nodes: int, across: int) -> str:
        return f"{nodes} nodes along the radius"

    def spacing(self, solver: Solver) -> float:
        r = radii(solver.nodes, solver.half_width)
        near = int(np.abs(r - FRONT_POSITION).argmin())
        return float(r[near + 1] - r[near])

    def wider(self, solver: Solver, factor: float) -> Solver:
        width = factor * solver.half_width
        cells = (solver.nodes - 1) * _extent(width) / _extent(solver.half_width)
        return replace(solver, half_width=width, nodes=round(cells) + 1)

    def complaints(self, solver: Solver, geometry: Geometry, grown: float) -> Iterator[tuple[str, str]]:
        if solver.half_width < SMALLEST_RADIUS:
            yield "half_width", f"must be at least {SMALLEST_RADIUS}"


def radii(nodes: int, half_width: float) -> NDArray[np.float64]:
    """Nodes from 0 to half_width, finest at the edge of the contact; the spacing grows linearly to both sides."""
    s = np.linspace(-_evenly(EDGE, WIDENING_INSIDE), _evenly(half_width - EDGE, WIDENING_OUTSIDE), nodes)
    inside = EDGE - np.expm1(-WIDENING_INSIDE * np.minimum(s, 0.0)) / WIDENING_INSIDE
    r = inside + np.expm1(WIDENING_OUTSIDE * np.maximum(s, 0.0)) / WIDENING_OUTSIDE
    r[0], r[-1] = 0.0, half_width  # free of round-off
    return r


def _evenly(distance: float, widening: float) -> float:
    return float(np.log1p(widening * distance)) / widening


def _extent(half_width: float) -> float:
    """The distance from 0 to half_width in units in which the nodes are evenly spaced."""
    return _evenly(EDGE, WIDENING_INSIDE) + _evenly(half_width - EDGE, WIDENING_OUTSIDE)
