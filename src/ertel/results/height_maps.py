"""The measured heights of a case as variables of its Dataset, so that the Dataset alone can show the roughness."""

from typing import Any

import xarray as xr

from ertel.case.case import Case
from ertel.case.height_map import HeightMap

FILE = "file"  # the attribute with the name that the plain data of the case use


def variables_of(case: Case) -> dict[str, tuple[tuple[str, str], Any, dict[str, str]]]:
    """The heights of each measured surface of a case, as they were read: rows along y, columns along x."""
    attributes = {"long_name": "heights of a measured surface, without a unit: their rms and lengths are in the case"}
    return {
        f"heights_{found.digest}": (
            (f"row_{found.digest}", f"column_{found.digest}"),
            found.heights,
            {**attributes, FILE: name},
        )
        for name, found in case.maps.items()
    }


def maps_of(dataset: xr.Dataset) -> dict[str, HeightMap]:
    """The measured heights in a Dataset, as `Case.maps`."""
    found = {name: variable for name, variable in dataset.variables.items() if FILE in variable.attrs}
    return {variable.attrs[FILE]: HeightMap(variable.values) for variable in found.values()}
