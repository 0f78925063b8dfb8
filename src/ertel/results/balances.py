"""The balances of a run: mass, momentum of the ball, and energy, each with its relative imbalance.

In time the terms of `equations.account` are integrated by the trapezium rule over the steps, from the first one on;
what is stored is a difference.  A steady contact has rates: nothing is stored.  Signs are such that in each balance

    mass        stored + outflow = inflow + cavity_source
    momentum    ball + impulse_of_film = impulse_of_load
    energy      kinetic + elastic + oil + dissipated + outside = work_of_load + work_of_surfaces

and the imbalance is the difference of the two sides, as a share of what is turned over:

    mass        the oil that came in or that left, whichever is more
    momentum    the integral of the larger of F and w
    energy      the kinetic energy at the start, the work of the load, and the work of the surfaces where the gap closes

Most of the work in rolling is given back where the gap opens.  So the rolling resistance, which is what is not given
back, is less exact than the balance: by the ratio of the two.  All is dimensionless in the units of `variables`.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ertel.case.case import Case

if TYPE_CHECKING:
    import xarray as xr

Values = NDArray[np.float64]
Balances = Mapping[str, Mapping[str, float | None]]

# the right-hand sides
GAINED = ("inflow", "cavity_source", "impulse_of_load", "applied_load", "work_of_load", "work_of_surfaces")
# by balance: what 1 is, as an attribute of `Scales`, and its unit
AMOUNTS = {"mass": ("oil", "m3"), "momentum": ("momentum", "N_s"), "energy": ("energy", "J")}
RATES = {"mass": ("oil_flow", "m3_per_s"), "momentum": ("load", "N"), "energy": ("power", "W")}


def in_time(case: Case, data: "xr.Dataset") -> dict[str, dict[str, float | None]]:
    """The balances from the first step of a run to its last, by name; empty with fewer than two steps.

    Each has its terms and `imbalance`, None where nothing was turned over.
    """
    if data.sizes["time"] < 2:
        return {}
    v = {name: np.asarray(data[name].values) for name in data.variables if data[name].dims == ("time",)}
    sums = {name: _integral(values, v["time"]) for name, values in v.items()}
    stored = {name: _change(v[name]) for name in ("mass", "elastic_energy", "oil_energy", "V")}
    inertia, kinetic = case.motion.inertia, case.motion.inertia / 2 * v["V"] ** 2
    of_load = np.diff(v["Delta"]) * (v["w"][1:] + v["w"][:-1]) / 2
    mass = {"stored": stored["mass"], **{name: sums[name] for name in ("inflow", "outflow", "cavity_source")}}
    momentum = {"ball": inertia * stored["V"], "impulse_of_load": sums["w"], "impulse_of_film": sums["F"]}
    energy = {
        "kinetic": _change(kinetic),
        "elastic": stored["elastic_energy"],
        "oil": stored["oil_energy"],
        "dissipated": sums["dissipation"],
        "outside": sums["outside_power"],
        "work_of_load": float(of_load.sum()),
        "work_of_surfaces": sums["power_from_surfaces"] - sums["power_to_surfaces"],
    }
    turned_over = float(kinetic[0] + np.maximum(of_load, 0.0).sum()) + sums["power_from_surfaces"]
    return {
        "mass": _closed(mass, max(mass["inflow"] + mass["cavity_source"], mass["outflow"])),
        "momentum": _closed(momentum, _integral(np.maximum(v["F"], v["w"]), v["time"])),
        "energy": _closed(energy, turned_over),
    }


def steady(case: Case, rates: Mapping[str, float], film_load: float) -> dict[str, dict[str, float | None]]:
    """The balances of a steady contact, as rates.  Momentum is the load.

    rates: from `equations.account.steady_account`.  film_load: what the film carries, in F*.
    """
    mass = {name: rates[name] for name in ("inflow", "outflow", "cavity_source")}
    momentum = {"applied_load": case.motion.load(0.0), "film_load": film_load}
    energy = {
        "dissipated": rates["dissipation"],
        "outside": rates["outside_power"],
        "work_of_surfaces": rates["power_from_surfaces"] - rates["power_to_surfaces"],
    }
    return {
        "mass": _closed(mass, max(mass["inflow"] + mass["cavity_source"], mass["outflow"])),
        "momentum": _closed(momentum, max(momentum.values())),
        "energy": _closed(energy, rates["power_from_surfaces"]),
    }


def terms_in_si(case: Case, balances: Balances) -> dict[str, dict[str, float]]:
    """The terms of the balances of a physical case in SI; their names end with the unit."""
    assert case.scales is not None
    content: dict[str, dict[str, float]] = {}
    for name, terms in balances.items():
        scale, unit = (RATES if case.is_steady else AMOUNTS)[name]
        factor = float(getattr(case.scales, scale))
        terms_of_balance = {term: value for term, value in terms.items() if value is not None and term != "imbalance"}
        content[name] = {f"{term}_{unit}": value * factor for term, value in terms_of_balance.items()}
    return content


def _closed(terms: Mapping[str, float], turned_over: float) -> dict[str, float | None]:
    """The terms of a balance with its imbalance."""
    rest = sum(-value if name in GAINED else value for name, value in terms.items())
    return {**terms, "imbalance": abs(rest) / turned_over if turned_over > 0 else None}


def _integral(values: Values, T: Values) -> float:
    return float(np.trapezoid(values, T))


def _change(values: Values) -> float:
    return float(values[-1] - values[0])
