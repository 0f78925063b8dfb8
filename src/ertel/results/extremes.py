"""The extremes of a run in time: its thinnest film and its highest pressure, with their times and places."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ertel.physics.scales import Scales
from ertel.results import variables

NARROW = (
    0.1  # share of a maximum by which the pressure may fall to the next nodes; below, P_max changes by some per cent
)
EXTREMES = {"H_min": np.argmin, "P_max": np.argmax}
PLACES = {"H_min": ("X_min", "Y_min"), "P_max": ("X_P_max", "Y_P_max")}


def extremes(data: xr.Dataset) -> dict[str, dict[str, Any]]:
    """The smallest H_min and the largest P_max over all steps; empty before the first step.

    By name: `value` (dimensionless), `T` (t0), `X` and `Y` (a*), and `note`, empty or what is to be said of the value.
    """
    if data.sizes["time"] == 0:
        return {}
    found = {}
    for name, extreme in EXTREMES.items():
        step = data.isel(time=int(extreme(data[name].values)))
        X, Y = (float(step[place]) for place in PLACES[name])
        note = _note_on_peak(float(step["P_fall"])) if name == "P_max" else ""
        found[name] = {"value": float(step[name]), "T": float(step["time"]), "X": X, "Y": Y, "note": note}
    return found


def _note_on_peak(fall: float) -> str:
    if fall <= NARROW:
        return ""
    return f"it depends on the grid: the peak is few nodes wide, {fall:.0%} lower at the next nodes"


def in_si(found: Mapping[str, Mapping[str, Any]], scales: Scales) -> dict[str, dict[str, float | None]]:
    """The extremes in SI, by the same names; keys end with their unit: h_min_m, p_max_Pa, t_s, x_m, y_m."""
    return {
        name: variables.in_si({name: one["value"], "T": one["T"], "X": one["X"], "Y": one["Y"]}, scales)
        for name, one in found.items()
    }
