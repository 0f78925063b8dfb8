"""The number, line or curve of runs in the place of a measurement, in SI."""

from typing import Any

import numpy as np
import xarray as xr

from ertel.results import alignment
from ertel.results.alignment import INTENSITY, QUANTITIES, si_unit
from ertel.results.numbers import IN_SI, numbers
from ertel.results.profiles import profile
from ertel.results.variables import to_si, with_clock


def number_of(measured: Any, result: Any) -> float:
    """The number of a run, in SI."""
    table = {
        name: each for each in numbers(result.summary).values() for name in (each.name, each.about.si_name) if name
    }
    if measured.quantity not in table:
        raise ValueError(f"{measured.quantity}: the run has no such number; it has {', '.join(table)}")
    number = table[measured.quantity]
    if number.factor is None and number.unit not in ("1", *IN_SI):
        raise ValueError(f"{measured.quantity}: the case is dimensionless, and the measurement is in SI")
    return number.in_si.value


def curve_over(measured: Any, result: Any) -> xr.DataArray:
    """The quantity over the condition of a curve, in SI: of a study, or of a list of runs at each x."""
    if isinstance(result, list):
        x, values = np.asarray(measured.x), np.array([number_of(measured, each) for each in result])
        about = {"long_name": QUANTITIES[measured.quantity].long_name, "units": si_unit(measured.quantity)}
    else:
        data = result.dataset
        axis = "mean_speed" if measured.axis == "speed" and "speed" not in data.coords else measured.axis
        if axis not in data.coords:
            what = ", ".join(map(str, data.coords)) or "nothing" if "status" in data else "nothing: it is one run"
            raise ValueError(
                f"{measured.name}: is a curve over {measured.axis}; compare it with a study; here varies {what}"
            )
        if several := [name for name in data.coords if name != axis and data[name].size > 1]:
            raise ValueError(f"{measured.name}: is one curve, and in the study {several[0]} varies, too")
        if measured.quantity not in data:
            raise ValueError(
                f"{measured.quantity}: the runs have no such number; they have {', '.join(map(str, data))}"
            )
        x, values, about = data[axis].values, data[measured.quantity].values.ravel(), data[measured.quantity].attrs
    order, unit = (
        np.argsort(x, kind="stable"),
        {"units": si_unit(measured.axis), "long_name": measured.axis, "symbol": measured.axis},
    )
    order = order[np.isfinite(values[order])]
    if not len(order):
        raise ValueError(f"{measured.quantity}: no run has this number")
    return xr.DataArray(
        values[order],
        {measured.axis: (measured.axis, x[order], unit)},
        attrs={"symbol": measured.quantity, **about, "moment": ""},
    )


def line_of(measured: Any, result: Any) -> xr.DataArray:
    """The quantity along the line of a profile, or through time, in SI."""
    data: xr.Dataset = result.dataset
    if measured.kind == "profile":
        data = profile(data, measured.at, measured.along)
    elif "time" in data.dims:
        data = data.drop_dims([name for name in data.dims if name != "time"])
        data = to_si(_from_the_start(with_clock(data))) if "si_factor" in data["time"].attrs else data
    else:
        raise ValueError(f"{measured.name}: is a history, and a steady contact has none")
    if measured.axis not in data.coords:
        raise ValueError(f"{measured.name}: is in SI, and the case is dimensionless")
    if measured.kind == "profile" and measured.quantity == INTENSITY:
        if measured.optics is None:
            raise ValueError(f"{measured.name}: is an intensity; give optics=ertel.optics.Interferometer(rig, light)")
        data = (
            alignment.light_along(data, result.case, measured.optics)
            .to_dataset(name=INTENSITY)
            .assign_attrs(data.attrs)
        )
    if measured.quantity not in data:
        raise ValueError(
            f"{measured.quantity}: the run has no such {measured.kind}; it has {', '.join(map(str, data))}"
        )
    return data[measured.quantity].assign_attrs(moment=data.attrs.get("moment", ""), a_m=data.attrs.get("a_m", np.inf))


def _from_the_start(history: xr.Dataset) -> xr.Dataset:
    """The history of a run from its start: before the first step it is as after it."""
    start = history.isel(time=[0]).assign_coords(time=("time", [0.0], history["time"].attrs))
    return xr.concat([start, history], "time") if float(history["time"][0]) > 0 else history
