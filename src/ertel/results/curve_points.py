"""The points of a traction curve: what varies, what each point says, and all of them as a Dataset.

The curve of a physical case is in SI.  That of a dimensionless case is in the units of the case; its traction
coefficients are multiples of a/R, a number that such a case does not have.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.physics.units import FINITE, LOAD, VELOCITY, Mark
from ertel.results import variables
from ertel.results.dataset import provenance
from ertel.results.variables import COEFFICIENT, FRICTION, Variable

Point = Mapping[str, Any]  # of a curve, see `point`


class Axis(NamedTuple):
    """What varies along a curve: its name in words, its symbol and unit, and what its values must be."""

    long_name: str
    symbol: str
    unit: str
    mark: Mark


AXES: Mapping[str, Axis] = {
    "slide_to_roll": Axis("slide-to-roll ratio", "S", "", FINITE),
    "mean_speed": Axis("mean speed", "u_m", "m/s", VELOCITY),
    "load": Axis("load", "F", "N", LOAD),
}
SHOWN = ("mu_sliding", "mu_rolling", "mu_1", "power_loss", "H_c", "H_min", "tau_max")  # in a table
WORK = ("newton_iterations", "krylov_iterations", "convolutions")
NUMBERS = (*SHOWN, "mu_2", "mu_sliding_y", "P_max", *WORK)
SHOWN_WARM = ("mu_isothermal", "T_film_max")  # with a section [thermal]
WARM = (*SHOWN_WARM, "T_1_max", "T_2_max", "phi_T")
VARIABLES: Mapping[str, Variable] = {
    **variables.VARIABLES,
    "mu_1": Variable("friction coefficient of surface 1, mu + mu_r", "mu_1", "a/R", COEFFICIENT, "mu_1", "1"),
    "mu_2": Variable("friction coefficient of surface 2, mu_r - mu", "mu_2", "a/R", COEFFICIENT, "mu_2", "1"),
    "tau_max": Variable("maximum mid-plane shear stress", "tau_max", "p_h a/R", "shear_stress", "tau_max", "Pa"),
    "mu_isothermal": replace(
        FRICTION["mu_sliding"], long_name="isothermal traction coefficient", si_name="mu_isothermal"
    ),
    "T_1_max": Variable("highest temperature of surface 1", "T_1", "K", "", "T_1_max", "K"),
    "T_2_max": Variable("highest temperature of surface 2", "T_2", "K", "", "T_2_max", "K"),
    "T_film_max": Variable("highest temperature of the film", "T_film", "K", "", "T_film_max", "K"),
    "phi_T": Variable("inlet factor of the film", "phi_T"),
}


def numbers_of(case: Case) -> tuple[str, ...]:
    """The numbers of a point by name; with a section [thermal] also those of `WARM`."""
    return NUMBERS if case.thermal is None else (*NUMBERS, *WARM)


def point(case: Case, values: Mapping[str, float], status: Status, warnings: Sequence[str]) -> Point:
    """A point of a curve as plain data, in SI where the case is physical.

    values: `numbers_of` the case by name, dimensionless.  Where the film did not converge there are none: each is None.
    """
    numbers = {name: values[name] * _factor(case, name) if status.ok else None for name in numbers_of(case)}
    return {**numbers, "status": status.value, "warnings": list(warnings)}


def _factor(case: Case, name: str) -> float:
    """What 1 is in SI; 1 where the case or the variable is dimensionless."""
    variable = VARIABLES[name]
    return variable.factor(case.scales) if case.scales and variable.scale else 1.0


def assemble(case: Case, axis: str, values: Sequence[float], points: Sequence[Point], film: str) -> xr.Dataset:
    """The points as a Dataset over what varies; in SI under SI names (h_c for H_c) where the case is physical.

    values: along the axis, of the curve; the points are the first ones of them.  film: see `ertel.traction`.
    """
    found: dict[str, Any] = {}
    for name in numbers_of(case):
        numbers = np.array([p[name] for p in points], dtype=float)  # None becomes nan
        found[shown_name(case.scales is not None, name)] = (axis, numbers, _attributes(case, VARIABLES[name]))
    found["status"] = (axis, np.array([p["status"] for p in points], dtype=str), {"long_name": "how it ended"})
    along = AXES[axis]
    about = {"long_name": along.long_name, "symbol": along.symbol, "units": along.unit or "1"}
    coordinate = (axis, np.array(values[: len(points)], dtype=float), about)
    return xr.Dataset(found, {axis: coordinate}, {**provenance(case), "varies": axis, "film": film})


def shown_name(physical: bool, name: str) -> str:
    """The name of a variable in a curve: that in SI, or the dimensionless one."""
    return (physical and VARIABLES[name].si_name) or name


def _attributes(case: Case, variable: Variable) -> dict[str, str]:
    comment = {"comment": variable.comment} if variable.comment else {}
    if case.scales:
        symbol = variable.si_name or variable.symbol
        return {"long_name": variable.long_name, "symbol": symbol, "units": variable.si_units or "1", **comment}
    unit = {"in_units_of": variable.unit} if variable.unit != "1" else {}
    return {"long_name": variable.long_name, "symbol": variable.symbol, "units": "1", **unit, **comment}


def largest_of(values: xr.DataArray) -> float:
    """The largest size of the values that are there."""
    return float(np.abs(np.nan_to_num(values.values)).max(initial=0.0))
