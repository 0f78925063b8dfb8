"""A run as an xarray Dataset: scalars over time and fields over frames, or a steady contact over its grids.

Its attributes are the provenance of the run; the measured heights of the case are among its variables.  Last come its
files for other programs: NetCDF, tables as CSV, maps for ParaView.  Each makes its directory if it can write.
"""

import json
import platform
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from ertel.case.case import Case
from ertel.case.height_map import HeightMap
from ertel.results import variables
from ertel.results.figures import is_line, is_steady
from ertel.results.parameters import parameters_of, scale_values
from ertel.results.variables import named_with_unit, names_where, variable_attributes, with_coefficients
from ertel.version import installed_version

Arrays = dict[str, tuple[tuple[str, ...], Any]]  # dimensions and values by the name of the variable
SteadyGrid = Any  # the steady contact on one grid, `solvers.grid_solution.GridSolution`, which results do not import
FILE = "file"  # the attribute of measured heights with the name that the plain data of the case use


class Frame(NamedTuple):
    """The maps of all fields at a time, by name; event: "", "max-approach" or "end"."""

    T: float
    fields: Mapping[str, Any]
    event: str


def names_over(case: Case, *over: str) -> list[str]:
    """The names of the variables that the Dataset of a case has over these; of a line contact none across it."""
    line, touches = case.geometry.is_line, case.touches
    there = names_where(lambda variable: variable.over in over and (touches or not variable.of_touch))
    return [name for name in there if not (line and variables.VARIABLES[name].is_across)]


def columns(case: Case, records: Sequence[Mapping[str, float]]) -> dict[str, np.ndarray]:
    """Step records as arrays by variable name, T as `time`; coefficients as `with_coefficients` says.

    What a method does not have is nan.
    """
    keys = {"time": "T", **{name: name for name in names_over(case, "step")}}
    arrays = {name: np.array([each.get(key, np.nan) for each in records], dtype=float) for name, key in keys.items()}
    return with_coefficients(arrays, case.scales)


def maps(case: Case, frames: Sequence[Frame]) -> dict[str, np.ndarray]:
    """Frames as arrays by variable name, stacked along the first axis; the one row of a line contact has no axis."""
    return {
        "frame": np.array([frame.T for frame in frames], dtype=float),
        "event": np.array([variables.EVENTS.index(frame.event) for frame in frames], dtype=np.int8),
        **{n: np.array([np.squeeze(frame.fields[n]) for frame in frames], float) for n in names_over(case, "map")},
    }


def assemble(
    case: Case, records: Sequence[Mapping[str, float]], frames: Sequence[Frame], coordinates: Mapping[str, Any]
) -> xr.Dataset:
    """The run as a Dataset: scalars over `time` (every step), maps over `frame` and the space axes.

    records: the scalars of every accepted step, by variable name and "T", dimensionless.  frames: the maps that were
    kept.  coordinates: axes of the maps in order, in a*: Y and X, or X, or r.
    """
    space = {name: np.asarray(axis) for name, axis in coordinates.items()}
    shape = len(frames), *(len(axis) for axis in space.values())  # which no maps at all have, too
    arrays: Arrays = {name: (("time",), values) for name, values in columns(case, records).items()}
    fields = names_over(case, "map")
    for name, values in maps(case, frames).items():
        arrays[name] = (("frame", *space), values.reshape(shape)) if name in fields else (("frame",), values)
    arrays |= {name: ((name,), axis) for name, axis in space.items()}
    return _dataset(case, arrays)


def assemble_steady(case: Case, grid: Any, solutions: Sequence[SteadyGrid]) -> xr.Dataset:
    """The steady contact as a Dataset: fields on the finest grid, scalars and residuals over `grid`.

    grid: that of the fields, of the last solution, or of the case as long as there is none, with its `coordinates`.
    solutions: coarsest first; the coordinate `grid` has their numbers of nodes a side.  One that is not solved has its
    work only.
    """
    fields = names_over(case, "map", *(["heated map"] if case.thermal else []))
    if case.thermal and case.thermal.is_solved:  # the film itself is the warm one
        fields = [name for name in fields if not name.endswith("_warm")]
    space: Mapping[str, Any] = grid.coordinates
    nothing = np.full([len(axis) for axis in space.values()], np.nan)
    maps = solutions[-1].maps if solutions and solutions[-1].status.is_solved else dict.fromkeys(fields, nothing)
    work = ("residual", "newton_iterations", "krylov_iterations", "convolutions")
    rows = [(with_coefficients(s.record, case.scales), s.status.is_solved) for s in solutions]
    there = [n for n in names_over(case, "step", "grid") if all(n in row for row, _ in rows)]
    histories = list(zip_longest(*(s.history for s in solutions), fillvalue=np.nan))
    arrays: Arrays = {
        **{name: (tuple(space), maps[name]) for name in fields},
        **{name: ((name,), axis) for name, axis in space.items()},
        **{n: (("grid",), np.array([row[n] if ok or n in work else np.nan for row, ok in rows], float)) for n in there},
        "history": (("grid", "iteration"), np.reshape(histories, (len(histories), len(solutions))).T),
        "grid": (("grid",), np.array([s.grid.nodes for s in solutions], dtype=np.int64)),
        "iteration": (("iteration",), np.arange(len(histories))),
    }
    if case.thermal and solutions and solutions[-1].status.is_solved:
        heights, T = solutions[-1].across
        arrays |= {"zeta": (("zeta",), heights), "T_across": (("zeta", "X"), T)}
    return _dataset(case, arrays)


def _dataset(case: Case, arrays: Arrays) -> xr.Dataset:
    """The Dataset of a run from its arrays, with the attributes of its variables and its own."""
    about = {name: variable_attributes(name, case.scales, case.geometry.is_line) for name in arrays}
    described = {name: (*indexed(name, *each), about[name]) for name, each in arrays.items()}
    axes = {name: described.pop(name) for name in names_where(lambda v: v.over == "axis") if name in described}
    return xr.Dataset({**described, **variables_of(case)}, axes, provenance(case))


def indexed(name: str, dims: Sequence[str], values: Any) -> tuple[Sequence[str], Any]:
    """The dimensions and values of a variable; those of an axis as an index, or xarray imports pint to look for its."""
    return dims, pd.Index(values) if list(dims) == [name] else values


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
        **({variables.START_APPROACH: case.schedule.start_approach} if case.starts_apart else {}),
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


# -- for other programs ------------------------------------------------------------------------------------------------

RUN, HISTORY, GRIDS, MAPS = "run.nc", "history.csv", "grids.csv", "maps"  # the files; maps.pvd, maps_0000.vti, ...


def with_units(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with the unit at the end of every name in SI: h_c_m, mean_speed_m_per_s."""
    units = {str(name): str(v.attrs.get("units", "1")) for name, v in dataset.variables.items()}
    return dataset.rename({name: named_with_unit(name, unit) for name, unit in units.items()})


def largest_of(values: xr.DataArray) -> float:
    """The largest size of the values that are there."""
    return float(np.abs(np.nan_to_num(values.values)).max(initial=0.0))


def to_netcdf(dataset: xr.Dataset, directory: Path) -> list[Path]:
    """Write the whole run as NetCDF 3, which every program that knows NetCDF reads; the paths of the files."""
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / RUN
    short = {name: v.astype(np.int32) for name, v in dataset.variables.items() if v.dtype == np.int64}
    numbers = {key: int(value) for key, value in dataset.attrs.items() if isinstance(value, bool)}  # 0 or 1
    dataset.assign(short).assign_attrs(numbers).to_netcdf(path, engine="scipy")
    return [path]


def to_csv(dataset: xr.Dataset, directory: Path) -> list[Path]:
    """Write the scalars of every time step, or of every grid of a steady contact; the paths of the files.

    Names in SI end with their unit: h_c_m.
    """
    steady = is_steady(dataset)
    along = "grid" if steady else "time" if "time" in dataset.dims else "t"
    scalars = [name for name, values in dataset.data_vars.items() if values.dims == (along,)]
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / (GRIDS if steady else HISTORY)
    with_units(dataset[scalars].reset_coords(drop=True)).to_dataframe().to_csv(path)
    return [path]


def to_vtk(dataset: xr.Dataset, directory: Path) -> list[Path]:
    """Write the maps as VTK images, and for a run in time a collection with their times; the paths of the files.

    Raises ValueError where there are no maps on a plane, or where pyevtk is not installed.
    """
    try:
        from pyevtk.hl import imageToVTK
        from pyevtk.vtk import VtkGroup
    except ImportError as error:
        raise ValueError('maps for ParaView need pyevtk: pip install "ertel[paraview]"') from error
    if dataset.sizes.get("frame", 1) == 0:
        raise ValueError("the run has no maps yet; export it later")
    Y, X = ("Y", "X") if "Y" in dataset.dims else ("y", "x")
    names = [str(name) for name, values in dataset.data_vars.items() if values.dims[-2:] == (Y, X)]
    if not names:
        run = "line contact" if is_line(dataset.attrs) else f"{dataset.attrs['method']} run"
        raise ValueError(f"maps for ParaView: a {run} has profiles only; use netcdf or csv")
    x, y = (dataset[axis].values.tolist() for axis in (X, Y))  # of NumPy they would be written as np.float64(...)
    origin, spacing = (x[0], y[0], 0.0), (x[1] - x[0], y[1] - y[0], 1.0)
    moments = dataset.sizes.get("frame", 1)
    directory.mkdir(parents=True, exist_ok=True)
    collection, paths = VtkGroup(str(directory / MAPS)), []
    for number in range(moments):
        one = dataset[names].isel(frame=number) if "frame" in dataset.dims else dataset[names]
        fields = {name: np.ascontiguousarray(one[name].values.T[:, :, None], dtype=float) for name in names}
        paths.append(Path(imageToVTK(str(directory / f"{MAPS}_{number:04}"), origin, spacing, pointData=fields)))
        collection.addFile(str(paths[-1]), float(one["frame"]) if "frame" in one.coords else 0.0)
    collection.save()
    return [directory / f"{MAPS}.pvd", *paths]


EXPORTS = {"netcdf": to_netcdf, "csv": to_csv, "vtk": to_vtk}
