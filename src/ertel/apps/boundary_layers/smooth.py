"""Smooth impacts: the runs of Figs. 1 to 4."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ertel import parse_case, simulate
from ertel.apps.boundary_layers.plans import LOADS, SHOWN_LOAD, L, Plan
from ertel.runs.tasks import Task

Values = NDArray[np.float64]
Results = Mapping[str, Any]  # task name -> result
Definition = Literal["film", "slope", "half-hertz"]  # of the front, see ertel.fronts.front

NAMES: Mapping[Definition, str] = {
    "film": "minimum film",
    "slope": "steepest pressure",
    "half-hertz": "half the Hertz pressure",
}
FORMED = 0.4  # a*: at smaller radii there is a bell of pressure and no front yet
INTERVAL = 0.01  # t0 between maps
NO_MAPS = 10.0  # t0: longer than the impact


def smooth_impact(M: float, L: float, solver: Mapping[str, Any], interval: float) -> xr.Dataset:
    """A smooth impact up to maximum approach.

    solver: the section [solver] of a case file.  interval: between maps (t0).  Raises RuntimeError where the run fails.
    """
    source = {"contact": {"M": M, "L": L}, "solver": dict(solver), "output": {"interval": interval}}
    result = simulate(parse_case(source))
    if not result.status.ok:
        raise RuntimeError(f"M = {M}, L = {L}: {result.status.value}; {result.status.advice}")
    return result.dataset


def radial_name(M: float, L: float, plan: Plan) -> str:
    """Name of a `radial_task`."""
    return f"smooth_M{M:g}_L{L:g}_{plan.smooth.radial_nodes}"


def radial_task(M: float, L: float, plan: Plan) -> Task:
    """A smooth impact by the radial method."""
    solver = {"method": "radial", "nodes": plan.smooth.radial_nodes, "half_width": 4.0}
    arguments = (float(M), float(L), solver, INTERVAL)
    return Task(radial_name(M, L, plan), smooth_impact, arguments, plan.smooth.radial_seconds)


def radial_tasks(plan: Plan) -> list[Task]:
    """The smooth impacts by the radial method."""
    return [radial_task(M, L, plan) for M in LOADS]


def plane_name(plan: Plan) -> str:
    """Name of the `plane_task`."""
    return f"smooth_2d_M{SHOWN_LOAD}_{plan.smooth.plane_nodes}"


def plane_task(plan: Plan) -> Task:
    """One of the smooth impacts by the 2-D method."""
    solver = {"nodes": plan.smooth.plane_nodes, "half_width": plan.smooth.plane_half_width}
    return Task(plane_name(plan), smooth_impact, (SHOWN_LOAD, L, solver, NO_MAPS), plan.smooth.plane_seconds)


def all_tasks(plan: Plan) -> list[Task]:
    """The smooth impacts by the radial method, and the one by the 2-D method."""
    return [*radial_tasks(plan), plane_task(plan)]


def radial_runs(results: Results, plan: Plan) -> dict[int, xr.Dataset]:
    """M -> smooth impact by the radial method."""
    return {M: results[radial_name(M, L, plan)] for M in LOADS}


def new_figure(rows: int, columns: int) -> tuple[Figure, list[Axes]]:
    """A figure with panels, row by row."""
    figure = Figure(figsize=(max(4.8 * columns, 7.0), 3.8 * rows), layout="constrained")
    return figure, list(figure.subplots(rows, columns, squeeze=False).ravel())
