"""Columns of tables: to read, with prefixes that fit, and of files, with the unit in the name."""

import numpy as np
import xarray as xr

from ertel.results.curve_points import largest_of
from ertel.results.variables import PREFIXES, exponent


def with_units(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with the unit at the end of every name in SI: h_c_m, mean_speed_m_per_s."""
    units = {str(name): str(v.attrs.get("units", "1")) for name, v in dataset.variables.items()}
    return dataset.rename({name: f"{name}_{_spelled(unit)}" for name, unit in units.items() if unit != "1"})


def _spelled(unit: str) -> str:
    return unit.replace("/", "_per_").replace("*", "_")


def column(head: str, values: xr.DataArray) -> list[str]:
    """A heading with the unit, and the values in it, with a prefix that fits the largest; texts as they are."""
    if values.dtype.kind in "UOT":
        return [head, *(str(value) for value in values.values)]
    unit = values.attrs.get("units", "1")
    if unit == "1":
        return [head, *(_number(value) for value in values.values)]
    power = 0 if "/" in unit or unit in ("K", "Pa*s") else exponent(largest_of(values))
    return [f"{head} ({PREFIXES[power]}{unit})", *(_number(value / 10**power) for value in values.values)]


def _number(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.4g}"
