"""The balances of a run: mass, momentum of the ball, and energy, each with its relative imbalance.

In time the terms of `equations.account` are integrated over the steps, from the first one on: the flows of oil by the
backward differences that the oil obeys, the others by the trapezium rule.  What is stored is a difference.  A steady
contact has rates: nothing is stored.  Signs are such that in each balance

    mass        stored + outflow = inflow + cavity_source
    momentum    ball + impulse_of_film = impulse_of_load
    energy      kinetic + elastic + oil + dissipated + outside = work_of_load + work_of_surfaces

and the imbalance is the difference of the two sides, as a share of what is turned over:

    mass        the oil that came in or that left, whichever is more
    momentum    the integral of the larger of F and w
    energy      the kinetic energy at the start, the work of the load, and the work of the surfaces where the gap closes

Most of the work in rolling is given back where the gap opens.  So the rolling resistance, which is what is not given
back, is less exact than the balance: by the ratio of the two.  All is dimensionless in the units of `variables`.

Last come the load and the momentum that the oil outside the domain takes.
"""

from collections.abc import Mapping
from math import ceil
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ertel.case.case import Case
from ertel.numerics.bdf import backward_integral

if TYPE_CHECKING:
    import xarray as xr

Values = NDArray[np.float64]
Balances = Mapping[str, Mapping[str, float | None]]

# the right-hand sides
GAINED = ("inflow", "cavity_source", "impulse_of_load", "applied_load", "work_of_load", "work_of_surfaces")
# by balance: what 1 is, as an attribute of `Scales`, and its unit
AMOUNTS = {"mass": ("oil", "m3"), "momentum": ("momentum", "N_s"), "energy": ("energy", "J")}
NOTHING = 1e-9  # of the oil on the grid, flows: the balance of a layer that stays on the grid is round-off
RATES = {"mass": ("oil_flow", "m3_per_s"), "momentum": ("load", "N"), "energy": ("power", "W")}


def in_time(case: Case, data: "xr.Dataset") -> dict[str, dict[str, float | None]]:
    """The balances from the first step of a run to its last, by name; empty with fewer than two steps.

    Each has its terms and `imbalance`, None where nothing was turned over.
    """
    if data.sizes["time"] < 2:
        return {}
    v = {name: np.asarray(data[name].values) for name in data.variables if data[name].dims == ("time",)}
    inertia, v["kinetic"] = case.motion.inertia, case.motion.inertia / 2 * v["V"] ** 2
    v["larger_load"] = np.maximum(v["F"], v["w"])
    sums = {name: float(np.trapezoid(values, v["time"])) for name, values in v.items()}
    stored = {name: float(values[-1] - values[0]) for name, values in v.items()}
    of_load = np.diff(v["Delta"]) * (v["w"][1:] + v["w"][:-1]) / 2
    times = np.array([v["time"][0] - v["dT"][0], *v["time"]])
    flows = {name: backward_integral(times, v[name]) for name in ("inflow", "outflow", "cavity_source")}
    mass = {"stored": stored["mass"], **flows}
    momentum = {"ball": inertia * stored["V"], "impulse_of_load": sums["w"], "impulse_of_film": sums["F"]}
    energy = {
        "kinetic": stored["kinetic"],
        "elastic": stored["elastic_energy"],
        "oil": stored["oil_energy"],
        **({"asperities": stored["asperity_energy"]} if "asperity_energy" in stored else {}),
        "dissipated": sums["dissipation"],
        "outside": sums["outside_power"],
        "work_of_load": float(of_load.sum()),
        "work_of_surfaces": sums["power_from_surfaces"] - sums["power_to_surfaces"],
    }
    flowed = max(mass["inflow"] + mass["cavity_source"], mass["outflow"])
    turned_over = float(v["kinetic"][0] + np.maximum(of_load, 0.0).sum()) + sums["power_from_surfaces"]
    return {
        "mass": _closed(mass, flowed if flowed > NOTHING * v["mass"].max() else 0.0),
        "momentum": _closed(momentum, sums["larger_load"]),
        "energy": _closed(energy, turned_over),
    }


def steady(case: Case, rates: Mapping[str, float], film_load: float) -> dict[str, dict[str, float | None]]:
    """The balances of a steady contact, as rates.  Momentum is the load.

    rates: from `GridSolution.account`.  film_load: what the film carries, in F*.
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


# -- the oil outside the domain ----------------------------------------------------------------------------------------

UNCERTAIN_MOMENTUM = 5e-3  # share of the ball's momentum that may depend on where the domain ends
FAR_FIELD_ERROR = 0.1  # of the load outside, which is known in closed form (`physics.far_field`) but not exactly


def uncertain_momentum(case: Case, data: "xr.Dataset", wider: float = 1.0) -> float:
    """Share of the ball's first momentum that is uncertain because the domain ends.

    It is a tenth of the load that the oil outside adds, over time: outside, and inside, where P is higher everywhere by
    that at the edge.  Far out P goes as r^-4 and the gap is a parabola, so that both parts are the same, of a line one
    and three.  wider: by this factor, of a domain that is so many times as wide; P at its edge goes as H^-2.

    With the radial method, half width 2 against 30 and M = 20, 100 the load at maximum approach was off by 2.8 and
    0.15 %, the approach by 1.6 and 0.09 %; this share is 2.1 and 0.3 %.
    """
    T, outside = data["time"].values, data["F_outside"].values
    w, (parts, power) = case.solver.half_width, (4.0, 1) if case.geometry.is_line else (2.0, 2)
    apart = np.maximum(-data["Delta"].values, 0.0)  # later the bodies give way
    fall = wider**power * ((apart + w**2 / 2) / (apart + (wider * w) ** 2 / 2)) ** 2
    load = FAR_FIELD_ERROR * parts * fall * outside
    impulse = load[0] * T[0] + np.trapezoid(load, T)  # before the first step: as after it
    return float(impulse) / case.motion.inertia


def needed_half_width(case: Case, data: "xr.Dataset") -> float:
    """The half width at which the uncertain momentum is `UNCERTAIN_MOMENTUM`."""
    wider = 1.0
    while uncertain_momentum(case, data, wider) > UNCERTAIN_MOMENTUM:
        wider *= 1.05
    return ceil(2 * wider * case.solver.half_width) / 2


def share_outside(data: "xr.Dataset") -> float:
    """The share of the load that the oil outside the grid carries at the last step of rolling in time."""
    pairs = zip(data["F"].values[-1:], data["F_outside"].values[-1:], strict=True)  # none before the first step
    return sum(float(outside / F) for F, outside in pairs if F > 0.0)
