"""The table of names, symbols and units of results, and the conversion to SI.

Everything is dimensionless; where the case is physical each variable also carries `si_factor`, `si_units` and
`si_name`, so that a stored run turns into SI without ertel: value * si_factor.  This module imports no xarray.

T counts from the start of a run, and so does t in rolling.  The t of an impact counts from the first touch of the
undeformed bodies, Delta = 0, whatever the gap at the start: t = (T - si_zero) * si_factor, see `with_clock`.
"""

import re
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass, replace
from math import floor, log10
from typing import TYPE_CHECKING, Any

from ertel.physics.motion import first_touch
from ertel.physics.scales import Scales
from ertel.physics.temperature_laws import ZERO_CELSIUS

if TYPE_CHECKING:
    import xarray as xr

COEFFICIENT = "coefficient"  # in place of a scale: computed in units a/R, and a plain number in a physical case
KELVIN = "K"  # the unit of temperatures, the only one that is the same in SI
CELSIUS = "degC"  # in which they are shown
AS_WRITTEN = {"1/Pa": (1e-9, "/GPa"), "m^2/s": (1e-6, "mm²/s"), "W/m2": (1e6, "W/mm²")}  # as tribologists do
PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
TOUCH = "T_touch"  # in a summary and among the attributes of a run: T at t = 0
START_APPROACH = "start_approach"  # of an impact, among its attributes
EVENTS = ("", "max-approach", "end")  # why a frame was kept; the first: because it was time


@dataclass(frozen=True)
class Variable:
    """The meaning of a number or a field, and where it is shown.

    unit: what 1 is, in words.  scale: the attribute of `Scales` that 1 is in SI.  si_name: the name in lower case where
    it is not given.  comment: what a user must know besides.
    over: what a Dataset has it over: "axis" (it is one), "step" (each time step, or each grid of a steady contact),
    "grid", "map", "heated map"; "" of a run as a whole.
    at_moment: it is in the summary, with its value at maximum approach, at the last time or steadily.
    of_impact: it is in the summary of an impact, about all of it.
    shown: it is a key number: texts, tables of runs and studies, and the app show it.
    has_error: it has an error under --error and a limit in a convergence series; values of single nodes have none.
    panel, curve_panel: the panel that draws it in the picture of a study, and of a traction curve.
    is_heated: heat changes it; the number with heat has the name with _warm, and is shown in its place.
    is_across: it is about the direction across the flow, in which nothing of a line contact changes: it has none.
    of_touch: only a contact whose asperities touch has it.
    """

    long_name: str
    symbol: str
    unit: str = "1"
    scale: str = ""
    si_units: str = ""
    si_name: str = ""
    comment: str = ""
    over: str = ""
    at_moment: bool = False
    of_impact: bool = False
    shown: bool = False
    has_error: bool = False
    panel: str = ""
    curve_panel: str = ""
    is_heated: bool = False
    is_across: bool = False
    of_touch: bool = False

    def factor(self, scales: Scales) -> float:
        """The value of 1 in SI."""
        return 1.0 if self.scale == COEFFICIENT else float(getattr(scales, self.scale))


# what 1 is: in words, as an attribute of `Scales`, in SI
TIME = ("t0", "t0", "s")
LENGTH = ("a*", "a", "m")
FILM = ("a*^2/R", "film", "m")
PRESSURE = ("p_h*", "p_h", "Pa")
AREA = ("a*^2", "area", "m2")
FORCE = ("F*", "load", "N")
LOAD = ("a*^2 p_h*", "force", "N")
ENERGY = ("F* a*^2/R", "energy", "J")
POWER = ("F* a*^2/(R t0)", "power", "W")
OIL_FLOW = ("rho0 a*^4/(R t0)", "oil_flow", "m3/s")
SHEAR = ("p_h* a*/R", "shear_stress", "Pa")
NUMBER = ("a*/R", COEFFICIENT, "1")

RING = "in an axisymmetric contact the place is a ring: X is its radius, Y is 0"
AMBIENT = "in SI a volume: that of the oil at ambient pressure"
PUSHED = "the force of surface 1 on surface 2 over the load of the film, positive along X"
RESISTANCE = "of each surface: (1/2) double integral of H dP/dX over the load of the film, positive against motion"
LOSS = "heat of sliding and of the pressure-driven flow"
# where a number is shown
MOMENT: dict[str, Any] = {"at_moment": True}
ESTIMATED: dict[str, Any] = {"at_moment": True, "has_error": True}
FRICTION: dict[str, Any] = {**ESTIMATED, "shown": True}
IMPACT: dict[str, Any] = {"of_impact": True, "has_error": True}
THICKNESS = "Film thickness"  # the panel of films
FILMS_SHOWN: dict[str, Any] = {**FRICTION, "panel": THICKNESS, "curve_panel": "Film", "is_heated": True}
TRACTION: dict[str, Any] = {**FRICTION, "panel": "Traction", "curve_panel": "Traction", "is_heated": True}
SHARE = "Share of the load on asperities"
SOLID: dict[str, Any] = {"panel": SHARE, "curve_panel": SHARE, "of_touch": True}
BOUNDARY: dict[str, Any] = {**FRICTION, "curve_panel": "Traction", "of_touch": True}

# The one table, and the one order of all numbers.  A new number is a line here, beside the place where it is computed.
AXES = {
    "time": Variable("time", "T", *TIME, "t"),
    "frame": Variable("time of a map", "T", *TIME, "t"),
    "X": Variable("position along x", "X", *LENGTH),
    "Y": Variable("position along y", "Y", *LENGTH),
    "Z": Variable("depth below the surface of a body", "Z", *LENGTH),
    "r": Variable("distance from the centre", "r", *LENGTH),
    "zeta": Variable("height in the film over the film thickness, -1/2 at surface 2", "zeta"),
    "grid": Variable("nodes per side of a grid", "n"),
    "iteration": Variable("Newton iteration", "k"),
}
CASES = {
    "M": Variable("load parameter", "M"),
    "L": Variable("oil parameter", "L"),
    "T": Variable("time", "T", *TIME, "t", **ESTIMATED),
}
STEPS = {  # and grids
    "H_c": Variable("central film thickness", "H_c", *FILM, **FILMS_SHOWN),
    "H_min": Variable("minimum film thickness", "H_min", *FILM, **FILMS_SHOWN),
    "P_c": Variable("central pressure", "P_c", *PRESSURE, **ESTIMATED),
    "P_max": Variable("maximum pressure", "P_max", *PRESSURE, **MOMENT, shown=True, panel="Maximum pressure"),
    "X_min": Variable("place of the minimum film thickness along x", "X_min", *LENGTH, comment=RING, **MOMENT),
    "Y_min": Variable(
        "place of the minimum film thickness along y", "Y_min", *LENGTH, comment=RING, **MOMENT, is_across=True
    ),
    "Delta": Variable("mutual approach of the bodies", "Delta", *FILM, **ESTIMATED),
    "F": Variable("load carried by the film", "F", *FORCE, **ESTIMATED),
    "F_outside": Variable("load carried by the oil outside the grid, a part of F", "F_out", *FORCE),
    "mu_sliding": Variable("traction coefficient", "mu_sliding", *NUMBER, comment=PUSHED, **TRACTION),
    "mu_sliding_y": Variable(
        "traction coefficient along y", "mu_sliding_y", *NUMBER, comment=PUSHED.replace("X", "Y"),
        **FRICTION, is_heated=True, is_across=True,
    ),
    "mu_boundary": Variable(
        "boundary part of the traction coefficient", "mu_boundary", *NUMBER, comment="of asperities", **BOUNDARY
    ),
    "mu_oil": Variable("oil's part of the traction coefficient", "mu_oil", *NUMBER, **BOUNDARY),
    "mu_rolling": Variable(
        "rolling resistance coefficient", "mu_rolling", *NUMBER, comment=RESISTANCE, **FRICTION, curve_panel="Traction"
    ),
    "power_loss": Variable(
        "power loss", "power_loss", *POWER, comment=LOSS, **FRICTION, curve_panel="Power loss", is_heated=True
    ),
    "asperity_share": Variable("share of the load that asperities carry", "share", **FRICTION, **SOLID),
    "contact_area": Variable("area of solid contact", "A_c", *AREA, **ESTIMATED, of_touch=True),
    "P_asperity_max": Variable("maximum pressure of asperities", "P_c,max", *PRESSURE, **MOMENT, of_touch=True),
    "V": Variable("approach speed", "dDelta/dT", "a*^2/(R t0)", "speed", "m/s"),
    "X_P_max": Variable("place of the maximum pressure along x", "X_P_max", *LENGTH, comment=RING),
    "Y_P_max": Variable("place of the maximum pressure along y", "Y_P_max", *LENGTH, comment=RING, is_across=True),
    "P_fall": Variable("fall of the pressure from its maximum to the next nodes", "1 - P_next/P_max"),
    # the terms of the balances, see `equations.account`
    "mass": Variable("oil on the grid", "m", "rho0 a*^4/R", "oil", "m3", "oil_volume", AMBIENT),
    "inflow": Variable("oil that flows in through the edge of the grid", "m_in", *OIL_FLOW, comment=AMBIENT),
    "outflow": Variable("oil that flows out through the edge of the grid", "m_out", *OIL_FLOW, comment=AMBIENT),
    "cavity_source": Variable("oil that cavities make, zero to round-off", "m_c", *OIL_FLOW, comment=AMBIENT),
    "elastic_energy": Variable("elastic energy of the solids", "E_solids", *ENERGY),
    "oil_energy": Variable("elastic energy of the compressed oil", "E_oil", *ENERGY),
    "asperity_energy": Variable("elastic energy of asperities", "E_asperities", *ENERGY, of_touch=True),
    "dissipation": Variable("viscous dissipation of the pressure-driven flow", "D", *POWER),
    "power_from_surfaces": Variable("power of the moving surfaces where the gap closes", "S_in", *POWER),
    "power_to_surfaces": Variable("power given back where the gap opens", "S_out", *POWER),
    "outside_power": Variable("power that goes to the oil outside the grid", "W_out", *POWER),
    "U": Variable("entrainment", "U", "a*/t0", "front_speed", "m/s", "u_m"),
    "w": Variable("applied load", "w", *FORCE),
    "dT": Variable("time step", "dT", *TIME),
    "error": Variable("local time error of the step", "error", "time.tolerance"),
    "newton_iterations": Variable("Newton iterations", "n_N"),
    "krylov_iterations": Variable("Krylov iterations", "n_K"),
    "convolutions": Variable("convolutions on the finest grid", "n_c"),
    "rejected": Variable("rejected attempts of steps", "n_r"),
}  # fmt: skip
GRIDS = {  # of a steady contact alone
    "load": Variable("load carried by the film", "integral of P", *LOAD, at_moment=True),
    "residual": Variable("maximum residual", "res"),
}
RUNS = {  # of a run as a whole, or of a traction curve
    "restitution": Variable("coefficient of restitution", "e", **IMPACT, shown=True, panel="Restitution"),
    "contact_time": Variable(
        "contact time, with more than 1 % of the largest load", "T_contact", *TIME, "t_contact", **IMPACT
    ),
    "F_max": Variable("largest load carried by the film", "F_max", *FORCE, **IMPACT),
    "H_min_extreme": Variable("thinnest film of the run", "H_min", *FILM),
    "P_max_extreme": Variable("highest pressure of the run", "P_max_extreme", *PRESSURE),
    "mu_1": Variable("friction coefficient of surface 1, mu + mu_r", "mu_1", *NUMBER, is_heated=True),
    "mu_2": Variable("friction coefficient of surface 2, mu_r - mu", "mu_2", *NUMBER, is_heated=True),
    "tau_max": Variable(
        "maximum mid-plane shear stress", "tau_max", *SHEAR,
        shown=True, curve_panel="Maximum shear stress", is_heated=True,
    ),
    "von_mises_max": Variable("largest von Mises stress in body 1", "sigma_vM", *PRESSURE),
    "X_von_mises": Variable("place of the largest von Mises stress along x", "X_vM", *LENGTH),
    "Y_von_mises": Variable("place of the largest von Mises stress along y", "Y_vM", *LENGTH, is_across=True),
    "Z_von_mises": Variable("depth of the largest von Mises stress", "Z_vM", *LENGTH),
    "shear_max": Variable("largest shear stress in body 1, of all planes", "tau_1", *PRESSURE),
    "Z_shear": Variable("depth of the largest shear stress in body 1", "Z_tau", *LENGTH),
    "yield_ratio": Variable("largest von Mises stress over the yield stress of body 1", "sigma_vM/Y"),
    "T_film_max": Variable("highest film temperature", "T_film_max", KELVIN, shown=True, curve_panel="Temperature"),
    "T_1_max": Variable("highest temperature of surface 1", "T_1_max", KELVIN, curve_panel="Temperature"),
    "T_2_max": Variable("highest temperature of surface 2", "T_2_max", KELVIN, curve_panel="Temperature"),
    "T_film_mean": Variable("mean temperature of the film, weighted with the pressure", "T_film_mean", KELVIN),
    "T_max": Variable("highest temperature of the oil", "T_max", KELVIN, curve_panel="Temperature"),
    "X_T_max": Variable("place of the highest temperature along x", "X_T", *LENGTH),
    "Y_T_max": Variable("place of the highest temperature along y", "Y_T", *LENGTH, is_across=True),
    "zeta_T_max": Variable("height of the highest temperature, -1/2 at surface 2, 1/2 at surface 1", "zeta_T"),
    "Lambda": Variable("minimum film over rms roughness", "Lambda", shown=True, curve_panel="Film over roughness"),
    "Hersey": Variable("Hersey number eta0 u_m/p_h", "eta0 u_m/p_h", *LENGTH),
    "phi_T": Variable("inlet factor of the film", "phi_T", curve_panel="Inlet factor"),
    "L_t": Variable("thermal loading parameter", "L_t"),
    "wall_time": Variable("time of computing", "t_wall", "s"),
}  # fmt: skip
MAPS = {
    "P": Variable("pressure", "P", *PRESSURE),
    "P_asperity": Variable("pressure of asperities", "P_asperity", *PRESSURE, comment="a part of P", of_touch=True),
    "H": Variable("film thickness", "H", *FILM),
    "oil": Variable("oil in the gap, H where it is full", "H_oil", *FILM, "h_oil"),
    "tau_x": Variable("shear stress in the middle of the film along x", "tau_x", *SHEAR),
    "tau_y": Variable("shear stress in the middle of the film along y", "tau_y", *SHEAR, is_across=True),
    "loss": Variable("power loss per area", "q", "p_h* a*^2/(R t0)", "power_per_area", "W/m2"),
}
ACROSS = {  # the film of a steady contact with [thermal], in the plane Y = 0
    "T_across": Variable("temperature across the film at Y = 0", "T", KELVIN, comment="from surface 2 to surface 1"),
}
HEATED_MAPS = {  # of a steady contact with [thermal], see `solvers.heat`
    "T_1": Variable("temperature of surface 1", "T_1", KELVIN),
    "T_2": Variable("temperature of surface 2", "T_2", KELVIN),
    "T_film": Variable("temperature of the film", "T_film", KELVIN, comment="mean across the film"),
    "share": Variable("oil that the surfaces drag along, over that of a film that is equally warm across", "c"),
    "tau_x_warm": Variable("shear stress in the middle of the warm film along x", "tau_x", *SHEAR),
    "tau_y_warm": Variable("shear stress in the middle of the warm film along y", "tau_y", *SHEAR, is_across=True),
}
EVENT = Variable("why the map was kept", "event")
OTHERS = {"history": Variable("maximum residual after each iteration", "res"), "event": EVENT}


def _all() -> Iterator[tuple[str, Variable]]:
    """The variables by name; one with heat stands behind the same without."""
    runs = [("axis", AXES), ("", CASES), ("step", STEPS), ("grid", GRIDS), ("", RUNS)]
    maps = [("map", MAPS), ("heated map", HEATED_MAPS), ("across", ACROSS), ("other", OTHERS)]
    for over, part in (*runs, *maps):
        for name, variable in part.items():
            si_name = (variable.si_name or name.lower()) if variable.scale else ""
            yield name, replace(variable, over=over, si_name=si_name)
            if variable.is_heated:
                variable = replace(variable, long_name=f"{variable.long_name}, warm", si_name=f"{si_name}_warm")
                yield f"{name}_warm", replace(variable, at_moment=False, has_error=False)


VARIABLES = dict(_all())
FILMS = ("H_c", "H_min")


def names_where(chosen: Callable[[Variable], Any]) -> list[str]:
    """The names of the variables that a function chooses, in the order of the table."""
    return [name for name, variable in VARIABLES.items() if chosen(variable)]


def stored_in(there: Container[Any], chosen: Callable[[Variable], Any], cold: bool = False) -> dict[str, Variable]:
    """The same by the names that a Dataset or a mapping has, which may be those in SI.

    Those with heat stand in the place of those without it, or beside them where the `cold` ones are wanted, too.
    """
    found = {name: each for name in names_where(chosen) for each in (name, name_in_si(name)) if each in there}
    return {each: VARIABLES[name] for name, each in found.items() if cold or f"{name}_warm" not in found}


def along_a_line(unit: str) -> str:
    """A unit of an integral over the surface as that of an integral along a line contact, for each length across."""
    return re.sub(r"(a\*?)\^2(?= p_h|$)", r"\1", re.sub(r"(a\*?)\^4", r"\1^3", unit))


def unit_of(kind: str, unit: str) -> str:
    """A unit of `VARIABLES` as a contact of this kind, "impact" or "rolling", names it.

    The scales of rolling are those of the static contact and not of the dry impact, and a/t0 is u_m.
    """
    if kind != "rolling":
        return unit
    return unit.replace("*", "").replace("a^2/(R t0)", "u_m a/R").replace("a/t0", "u_m")


def name_in_si(name: str) -> str:
    """The name of a variable in SI; its own where it has no unit."""
    return (name in VARIABLES and VARIABLES[name].si_name) or name


def with_coefficients(values: Mapping[str, Any], scales: Scales | None) -> dict[str, Any]:
    """The values with coefficients of friction as plain numbers in place of units a/R, where the case is physical."""
    unit = scales.a_over_R if scales else 1.0
    coefficients = {name: value for name, value in values.items() if VARIABLES.get(name, EVENT).scale == COEFFICIENT}
    return {**values, **{name: value if value is None else value * unit for name, value in coefficients.items()}}


def variable_attributes(name: str, scales: Scales | None, line: bool = False) -> dict[str, Any]:
    """CF attributes of a variable, of a line contact or not: units, names, what 1 stands for, its SI factor if any."""
    variable = VARIABLES[name]
    attributes: dict[str, Any] = {"long_name": variable.long_name, "symbol": variable.symbol, "units": "1"}
    if variable.unit == KELVIN:
        attributes["units"] = KELVIN
    elif variable.unit != "1" and not (scales and variable.scale == COEFFICIENT):
        attributes["in_units_of"] = along_a_line(variable.unit) if line else variable.unit
    if variable.comment:
        attributes["comment"] = variable.comment
    if name == "event":
        attributes |= {"flag_values": list(range(len(EVENTS))), "flag_meanings": " ".join(e or "time" for e in EVENTS)}
    if scales and variable.scale:
        attributes |= {"si_name": variable.si_name, "si_units": variable.si_units}
        attributes["si_factor"] = variable.factor(scales)
    return attributes


def value_in_si(value: Any, attributes: Mapping[str, Any]) -> tuple[str, Any, dict[str, Any]]:
    """The SI name, value and attributes of a variable of a physical case, from its own, which have an si_factor."""
    value, attributes = shifted(value, attributes), dict(attributes)
    attributes["units"], attributes["symbol"] = attributes.pop("si_units"), attributes.pop("si_name")
    for name in ("si_factor", "si_zero", "in_units_of"):
        attributes.pop(name, None)
    return attributes["symbol"], value, attributes


def shifted(value: Any, attributes: Mapping[str, Any]) -> Any:
    """A value in SI from its own unit, a time from the first touch; as it is where the attributes know no SI."""
    return (value - attributes.get("si_zero", 0.0)) * attributes.get("si_factor", 1.0)


def with_clock(dataset: "xr.Dataset") -> "xr.Dataset":
    """A run whose times have the attribute `si_zero`, T at t = 0, where it is an impact in SI."""
    axes = [name for name in ("time", "frame") if "si_factor" in (dataset[name].attrs if name in dataset else ())]
    if dataset.attrs.get("kind") != "impact" or not axes or "si_zero" in dataset[axes[0]].attrs:
        return dataset
    zero = dataset.attrs.get(TOUCH)
    if zero is None:
        T, Delta = (dataset[name].values if "Delta" in dataset else () for name in ("time", "Delta"))
        zero = first_touch(T, Delta, dataset.attrs.get(START_APPROACH, -1.0))
    clocked = dataset.copy()
    for name in axes:
        clocked.variables[name].attrs = {**dataset[name].attrs, "si_zero": zero}
    return clocked


def to_si(dataset: "xr.Dataset") -> "xr.Dataset":
    """The run of a physical case in SI units; its variables have their SI names (h_c for H_c, t for time, ...).

    Parameters
    ----------
    dataset : xarray.Dataset
        The dataset of a run.

    Returns
    -------
    xarray.Dataset
        The same in SI units.

    Raises
    ------
    ValueError
        The run is dimensionless.
    """
    if not any("si_factor" in variable.attrs for variable in dataset.variables.values()):
        raise ValueError("dataset: the case is dimensionless and has no SI scales; give radius, speed, ... in SI")
    dataset = with_clock(dataset)
    converted, new_names = dataset.copy(), {}
    for name, variable in dataset.variables.items():
        if "si_factor" in variable.attrs:
            new, values, attributes = value_in_si(variable.values, variable.attrs)
            converted[name] = (variable.dims, values, attributes)
            new_names[name] = new if name != "frame" else name
    return converted.rename(new_names)


def prefixed(unit: str, largest: float) -> tuple[float, str]:
    """A unit of SI with the prefix that brings the largest value between about 0.5 and 500: what 1 of it is, its name.

    Other quotients than those of `AS_WRITTEN`, temperatures, masses and angles have no prefix, a plain number no unit.
    """
    power, times = 0, {"m2": 2, "m3": 3}.get(unit, 1)  # a prefix of an area counts twice
    if abs(largest) > 0 and "/" not in unit and unit not in ("1", KELVIN, CELSIUS, "kg", "deg"):
        power = min(max(3 * floor(log10(abs(largest)) / (3 * times) + 0.1), min(PREFIXES)), max(PREFIXES))
    written = unit.replace("m2", "m²").replace("m3", "m³")
    return AS_WRITTEN.get(unit) or (10.0 ** (power * times), "" if unit == "1" else PREFIXES[power] + written)


def in_celsius(values: Any, unit: str) -> tuple[Any, str]:
    """Values and their unit for reading: temperatures (no differences of them) in degC, anything else as it is."""
    return (values - ZERO_CELSIUS, CELSIUS) if unit == KELVIN else (values, unit)


def with_prefix(value: float, unit: str) -> str:
    """A value in SI for reading: 1.4e9, "Pa" is "1.4 GPa"."""
    one, name = prefixed(unit, value)
    return f"{value / one:.4g} {name}".rstrip()


def named_with_unit(name: str, unit: str) -> str:
    """A name with its unit at the end: h_c_m, mean_speed_m_per_s; a plain number keeps its name."""
    return name if unit == "1" else f"{name}_{unit.replace('/', '_per_').replace('*', '_')}"
