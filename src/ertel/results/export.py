"""A run for other programs: NetCDF, tables as CSV, maps for ParaView.  Each makes its directory if it can write."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ertel.results.report import with_units
from ertel.results.variables import is_steady

RUN, HISTORY, GRIDS, MAPS = "run.nc", "history.csv", "grids.csv", "maps"  # the files; maps.pvd, maps_0000.vti, ...
PLANE = (("Y", "X"), ("y", "x"))  # the axes of maps: dimensionless, and in SI


class NoExport(ValueError):
    """A run cannot be written in this form; the message says why, and what can."""


def to_netcdf(dataset: xr.Dataset, directory: Path) -> list[Path]:
    """Write the whole run as NetCDF 3, which every program that knows NetCDF reads; the paths of the files."""
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / RUN
    short = {name: v.astype(np.int32) for name, v in dataset.variables.items() if v.dtype == np.int64}
    dataset.assign(short).assign_attrs(_plain(dataset.attrs)).to_netcdf(path, engine="scipy")
    return [path]


def _plain(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes as NetCDF has them: a truth value is 0 or 1."""
    return {key: int(value) if isinstance(value, bool) else value for key, value in attributes.items()}


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

    Raises NoExport where there are no maps on a plane, or where pyevtk is not installed.
    """
    try:
        from pyevtk.hl import imageToVTK
        from pyevtk.vtk import VtkGroup
    except ImportError as error:
        raise NoExport('maps for ParaView need pyevtk: pip install "ertel[paraview]"') from error
    Y, X = _plane(dataset)
    names = [str(name) for name, values in dataset.data_vars.items() if values.dims[-2:] == (Y, X)]
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


def _plane(dataset: xr.Dataset) -> tuple[str, str]:
    """The axes of the maps."""
    for axes in PLANE:
        if all(axis in dataset.dims for axis in axes):
            if dataset.sizes.get("frame", 1) == 0:
                raise NoExport("the run has no maps yet; export it later")
            return axes
    raise NoExport("maps for ParaView: a run by the radial method has profiles only; use netcdf or csv")


EXPORTS = {"netcdf": to_netcdf, "csv": to_csv, "vtk": to_vtk}
