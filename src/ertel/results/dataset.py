"""A run as an xarray Dataset: scalars over time and fields over frames, or a steady contact over its grids.

Its attributes are the provenance of the run; the measured heights of the case are among its variables.
"""

import json
import platform
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from typing import Any, Protocol

import numpy as np
import xarray as xr

from ertel.case.case import Case
from ertel.case.height_map import HeightMap
from ertel.numerics.grid import Grid
from ertel.physics.scales import Scales
from ertel.results.parameters import parameters_of, scale_values
from ertel.results.steady import SteadyGrid
from ertel.results.variables import (
    AXES,
    BUDGET,
    EVENTS,
    FIELDS,
    FRICTION,
    MEASURED,
    SCALARS,
    TEMPERATURES,
    variable_attributes,
    with_coefficients,
)
from ertel.version import installed_version

FILE = "file"  # the attribute of measured heights with the name that the plain data of the case use


class StoredFields(Protocol):
    """The fields of a run at one time."""

    @property
    def T(self) -> float: ...
    @property
    def fields(self) -> Mapping[str, Any]: ...
    @property
    def event(self) -> str: ...


def columns(records: Sequence[Mapping[str, float]], scales: Scales | None) -> dict[str, np.ndarray]:
    """Step records as arrays by variable name, T as `time`; coefficients as `with_coefficients` says."""
    names = {"time": "T", **{name: name for name in SCALARS}}
    arrays = {name: np.array([record[key] for record in records], dtype=float) for name, key in names.items()}
    return with_coefficients(arrays, scales)


def maps(frames: Sequence[StoredFields]) -> dict[str, np.ndarray]:
    """Frames as arrays by variable name, stacked along the first axis."""
    return {
        "frame": np.array([frame.T for frame in frames], dtype=float),
        "event": np.array([EVENTS.index(frame.event) for frame in frames], dtype=np.int8),
        **{name: np.array([frame.fields[name] for frame in frames], dtype=float) for name in FIELDS},
    }


def dimensions(name: str, coordinates: Mapping[str, Any]) -> tuple[str, ...]:
    """Dimensions of a variable of a run in time; the space axes are those of `coordinates`, in order."""
    if name in FIELDS:
        return ("frame", *coordinates)
    return (name,) if name in AXES else ("frame",) if name == "event" else ("time",)


def assemble(
    case: Case,
    records: Sequence[Mapping[str, float]],
    frames: Sequence[StoredFields],
    coordinates: Mapping[str, Any],
    attributes: Mapping[str, object] | None = None,
) -> xr.Dataset:
    """The run as a Dataset: scalars over `time` (every step), maps over `frame` and the space axes.

    Parameters
    ----------
    case : Case
        The case of the run; its provenance is stored in the attributes.
    records : sequence of mappings
        The scalars of every accepted step, by variable name and "T", dimensionless.
    frames : sequence of StoredFields
        The maps that were kept.
    coordinates : mapping
        Axes of the maps in order, in a*: Y and X, or r.
    attributes : mapping, optional
        More attributes of the Dataset.
    """
    space = {name: np.asarray(axis) for name, axis in coordinates.items()}
    stacks = maps(frames)
    for name in FIELDS:  # no maps at all still have their shape
        stacks[name] = stacks[name].reshape(len(frames), *(len(axis) for axis in space.values()))
    arrays = {**columns(records, case.scales), **stacks, **space}
    variables = {
        name: (dimensions(name, coordinates), values, variable_attributes(name, case.scales))
        for name, values in arrays.items()
    }
    axes = {name: variables.pop(name) for name in AXES if name in variables}
    return xr.Dataset({**variables, **variables_of(case)}, axes, {**provenance(case), **(attributes or {})})


def assemble_steady(
    case: Case, grid: Grid, solutions: Sequence[SteadyGrid], attributes: Mapping[str, object] | None = None
) -> xr.Dataset:
    """The steady contact as a Dataset: fields on the finest grid, scalars and residuals over `grid`.

    Parameters
    ----------
    case : Case
        The case of the run.
    grid : Grid
        That of the fields: of the last solution, or of the case as long as there is none.
    solutions : sequence of SteadyGrid
        Coarsest first; the coordinate `grid` has their numbers of nodes a side.
    attributes : mapping, optional
        More attributes of the Dataset.
    """
    fields = FIELDS if case.thermal is None else {**FIELDS, **TEMPERATURES}
    nothing = np.full((len(grid.y), len(grid.x)), np.nan)
    maps = solutions[-1].maps if solutions else dict.fromkeys(fields, nothing)
    rows = [with_coefficients(s.record, case.scales) for s in solutions]
    names = (*MEASURED, *BUDGET, *FRICTION, "residual", "newton_iterations", "krylov_iterations", "convolutions")
    longest = max((len(s.history) for s in solutions), default=0)
    history = np.full((len(solutions), longest), np.nan)
    for row, s in zip(history, solutions, strict=True):
        row[: len(s.history)] = s.history
    axes = {
        "Y": grid.y,
        "X": grid.x,
        "grid": np.array([s.grid.nodes for s in solutions], dtype=np.int64),
        "iteration": np.arange(longest),
    }
    arrays: dict[str, tuple[tuple[str, ...], Any]] = {
        **{name: (("Y", "X"), maps[name]) for name in fields},
        **{name: (("grid",), np.array([row[name] for row in rows], dtype=float)) for name in names},
        "history": (("grid", "iteration"), history),
        **{name: ((name,), axis) for name, axis in axes.items()},
    }
    variables = {
        name: (dims, values, variable_attributes(name, case.scales)) for name, (dims, values) in arrays.items()
    }
    coordinates = {name: variables.pop(name) for name in axes}
    return xr.Dataset({**variables, **variables_of(case)}, coordinates, {**provenance(case), **(attributes or {})})


# -- provenance -------------------------------------------------------------------------------------------------------


def provenance(case: Case) -> dict[str, object]:
    """Attributes that make a run self-describing: case, versions, platform, time, references."""
    laws: list[object] = [case.lubricant.viscosity_law, case.lubricant.density_law]
    if not case.oil.is_newtonian:
        laws.append(case.oil.fluidity_law)
    return {
        "Conventions": "CF-1.11",
        "title": case.name or f"{case.kind}, M = {case.parameters.M:.4g}, L = {case.parameters.L:.4g}",
        "source": f"ertel {installed_version()}",
        "references": "; ".join(getattr(law, "reference", type(law).__name__) for law in laws),
        "date_created": datetime.now(UTC).isoformat(timespec="seconds"),
        "platform": f"{platform.system()} {platform.machine()}, {platform.processor() or 'unknown processor'}",
        "versions": json.dumps(versions()),
        **_written(case),
        "kind": case.kind,
        "method": case.solver.method,
        **parameters_of(case),
        **scale_values(case),
    }


@cache  # reading them takes longer than writing a coarse grid
def versions() -> dict[str, str]:
    """Versions of the software on which a result may depend."""
    packages = ("jax", "jaxlib", "numpy", "scipy", "xarray", "zarr")
    ours = {"ertel": installed_version(), "python": platform.python_version()}
    return ours | {name: version(name) for name in packages}


def _written(case: Case) -> dict[str, str]:
    """The case as it is written and its digest; for one that cannot be written the reason."""
    try:
        return {"case": json.dumps(case.to_data()), "digest": case.digest}
    except ValueError as error:
        return {"case_not_written": str(error)}


# -- measured heights -------------------------------------------------------------------------------------------------


def variables_of(case: Case) -> dict[str, tuple[tuple[str, str], Any, dict[str, str]]]:
    """The heights of each measured surface of a case, as they were read: rows along y, columns along x."""
    attributes = {"long_name": "heights of a measured surface, without a unit: their rms and lengths are in the case"}
    return {
        f"heights_{heights.digest}": (
            (f"row_{heights.digest}", f"column_{heights.digest}"),
            heights.heights,
            {**attributes, FILE: name},
        )
        for name, heights in case.maps.items()
    }


def maps_of(dataset: xr.Dataset) -> dict[str, HeightMap]:
    """The measured heights in a Dataset, as `Case.maps`."""
    heights = {name: variable for name, variable in dataset.variables.items() if FILE in variable.attrs}
    return {variable.attrs[FILE]: HeightMap(variable.values) for variable in heights.values()}
