"""Stored runs of earlier versions, their summaries and their Datasets, in the form of today.

Summaries had the values of an impact under `max_approach`, the numbers with heat in SI under `thermal`, and the
coefficients of friction in units a/R, or in SI under `si`.  Datasets had the coefficients in units a/R.
Times in SI counted from the start.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ertel.physics.scales import Scales
from ertel.results.numbers import ERRORS, Outcome, scales_in
from ertel.results.variables import COEFFICIENT, EVENT, TOUCH, VARIABLES, names_where

if TYPE_CHECKING:
    import xarray as xr


def as_now(summary: Outcome) -> dict[str, Any]:
    """The summary of a stored run in the form of today; one of today as it is.

    Temperatures and traction of a heat balance that has not converged are None.
    """
    now, si = {**dict.fromkeys(ERRORS), **summary}, dict(summary.get("si", {}))
    if "max_approach" in now:
        now |= now.pop("max_approach") or {}
        si |= si.pop("max_approach", None) or {}
        now.setdefault("T", None)
        if estimate := now.get("error_estimate"):
            now["error_estimate"] = {{"Delta_max": "Delta"}.get(name, name): each for name, each in estimate.items()}
    coefficients = names_where(lambda variable: variable.scale == COEFFICIENT)
    now |= {name: si[name] for name in coefficients if name in now and name in si}
    if scales := scales_in(summary):
        now["si"] = si
        if "h_c_m" in (heat := now.get("thermal", {})):
            si |= {"h_c_warm_m": heat["h_c_m"], "h_min_warm_m": heat["h_min_m"]}
            now |= _with_heat(heat, scales)
    return now


def from_touch(summary: Outcome, touch: float) -> dict[str, Any]:
    """The summary of an impact in SI whose times there counted from its start; now from the first touch, at T."""
    seconds = touch * summary["si"]["t0_s"]

    def later(values: Outcome) -> dict[str, Any]:
        return {**values, **({"t_s": values["t_s"] - seconds} if values.get("t_s") is not None else {})}

    si = later(summary["si"])
    si |= {"extremes": {name: later(one) for name, one in si["extremes"].items()}} if "extremes" in si else {}
    return {**summary, TOUCH: touch, "si": si}


def _with_heat(heat: Mapping[str, Any], scales: Scales) -> dict[str, Any]:
    """The numbers with heat as they stand in a summary today, from the part `thermal` of earlier versions."""
    warm = {key.removesuffix("_K"): value for key, value in heat.items() if key.endswith("_K")}
    warm |= {"mu_sliding_warm": heat["mu_sliding"]}
    return {
        "H_c_warm": heat["h_c_m"] / scales.film,
        "H_min_warm": heat["h_min_m"] / scales.film,
        **{name: heat[name] for name in ("L_t", "phi_T")},
        **(warm if heat["converged"] else dict.fromkeys(warm)),
        "thermal": {name: heat[name] for name in ("inlet_factor", "iterations", "converged")},
    }


def one_number(dataset: "xr.Dataset") -> "xr.Dataset":
    """The Dataset of a stored run, its coefficients of friction as plain numbers: earlier versions stored units a/R."""
    converted = {}
    for name, variable in dataset.variables.items():
        factor = variable.attrs.get("si_factor", 1.0)
        if VARIABLES.get(str(name), EVENT).scale == COEFFICIENT and factor != 1.0:
            attributes = {key: value for key, value in variable.attrs.items() if key != "in_units_of"}
            converted[name] = (variable.dims, variable.values * factor, {**attributes, "si_factor": 1.0})
    return dataset.assign(converted) if converted else dataset
