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
from ertel.physics.dry_contact import LINE_LOAD, hertz_ellipse

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


def uncertain_momentum(case: Case, data: "xr.Dataset") -> float:
    """Share of the ball's first momentum that is uncertain because the domain ends: a tenth of `outer_load` over time.

    With the radial method, half width 2 against 30 and M = 20, 100 the load at maximum approach was off by 2.8 and
    0.15 %, the approach by 1.6 and 0.09 %; this share was 1.8 and 0.3 %.
    """
    load, T = FAR_FIELD_ERROR * outer_load(data).values, data["frame"].values
    impulse = load[0] * T[0] + np.trapezoid(load, T)  # before the first map: as there
    return float(impulse) / case.motion.inertia


def outer_load(data: "xr.Dataset") -> "xr.DataArray":
    """Load that the film would not carry if P were 0 at the edge, in units of the dry maximum load, at each map.

    Far out the film is thick and rigid, H = H_w + (r^2 - w^2)/2, and the oil that it displaces flows outwards,
    H^3 dP/dr = -lambda_bar V r/2.  Without an edge that gives P = lambda_bar V/(4 H^2).  The flow through the edge does
    not feel that P = 0 there: it gives lambda_bar V.  The load 2 pi H_w P_w beyond the edge is left out; inside, P is
    too low by P_w everywhere, because an even pressure drives no flow.  For an ellipse 4 is 2 (1 + D), and the load
    beyond the edge is D^(-1/2) times as large.  Beyond both ends of a line it is 2 w P_w/3.
    """
    import xarray as xr

    displaced, H, area = _through_the_edge(data)
    D = float(data.attrs.get("radius_ratio", 1.0))
    P_w = displaced / (2 * (1 + D)) * np.mean(H**-2.0, axis=1)
    H_w = np.mean(H**-2.0, axis=1) ** -0.5
    if not D:
        return xr.DataArray(P_w * area * 4 / 3 / LINE_LOAD, dims="frame")
    return xr.DataArray(P_w * (area + 2 * np.pi * H_w / D**0.5) / hertz_ellipse(D).load, dims="frame")


def _through_the_edge(data: "xr.Dataset") -> tuple[Values, Values, float]:
    """Flow through the edge over the area within (frame,), H on the edge (frame, n), area of the domain."""
    P, H = data["P"].values, data["H"].values
    if "r" in data.dims:
        r = data["r"].values
        flow = np.mean(H[:, -2:] ** 3, axis=1) * (P[:, -2] - P[:, -1]) / (r[-1] - r[-2])
        return 2 * flow / ((r[-1] + r[-2]) / 2), H[:, -1:], float(np.pi * r[-1] ** 2)
    axes = data["P"].dims[1:]
    sides = [(axis, edge, next_) for axis in range(1, P.ndim) for edge, next_ in ((0, 1), (-1, -2))]
    parts = [[np.take(field, k, axis) for field in (P, H) for k in (edge, next_)] for axis, edge, next_ in sides]
    flow = sum(
        np.sum(((H_edge**3 + H_next**3) / 2 * (P_next - P_edge)).reshape(len(P), -1), axis=1)
        for P_edge, P_next, H_edge, H_next in parts
    )
    sizes = np.array([float(np.ptp(data[axis].values)) for axis in axes])
    spacing = float(data["X"][1] - data["X"][0])
    crossed = np.prod(sizes - spacing) * spacing ** (2 - len(sizes))
    edge = np.concatenate([part[2].reshape(len(P), -1) for part in parts], axis=1)
    return flow / crossed, edge, float(np.prod(sizes))


def needed_half_width(case: Case, share: float) -> float:
    """The half width at which the uncertain momentum is `UNCERTAIN_MOMENTUM`, from its share at the case's own."""
    width, start = case.solver.half_width, case.schedule.start_approach
    wide = width
    lost = _lost_on_a_line if case.geometry.is_line else _lost_on_approach
    while share * lost(wide, start) > UNCERTAIN_MOMENTUM * lost(width, start):
        wide *= 1.05
    return ceil(2 * wide) / 2


def _lost_on_approach(w: float, start_approach: float) -> float:
    """Integral over Delta, from the start to first touch, of `outer_load` with half width w: lambda_bar and V are 1.

    With H = w^2/2 - Delta the loss is pi w^2/(4 H^2) + pi/(2 H), which tends to a w^-2 law.
    """
    touch, start = w**2 / 2, w**2 / 2 - start_approach
    return float(np.pi * w**2 / 4 * (1 / touch - 1 / start) + np.pi / 2 * np.log(start / touch))


def _lost_on_a_line(w: float, start_approach: float) -> float:
    """The same of a line contact, (4/3) w/H^2 at each moment."""
    return 4 / 3 * w * (1 / (w**2 / 2) - 1 / (w**2 / 2 - start_approach))


def share_outside(case: Case, data: "xr.Dataset") -> float:
    """The share of the load that the oil outside the grid carries at the last map of rolling in time."""
    if not data.sizes["frame"]:
        return 0.0
    P = data["P"].isel(frame=-1)
    load = float(np.interp(P["frame"], data["time"], data["F"])) if data.sizes["time"] else case.motion.load(0.0)
    inside = float(P.sum()) * float(P["X"][1] - P["X"][0]) ** P.ndim
    return 1.0 - inside / (load * case.geometry.hertz_load) if load > 0 else 0.0
