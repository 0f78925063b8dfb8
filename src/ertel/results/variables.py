"""The table of names, symbols and units of results, and the conversion to SI.

Everything is dimensionless; where the case is physical each variable also carries `si_factor`, `si_units` and
`si_name`, so that a stored run turns into SI without ertel: value * si_factor.  This module imports no xarray.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import floor, log10
from typing import TYPE_CHECKING, Any

from ertel.physics.scales import Scales
from ertel.physics.temperature_laws import ZERO_CELSIUS

if TYPE_CHECKING:
    import xarray as xr

COEFFICIENT = "coefficient"  # in place of a scale: computed in units a/R, and a plain number in a physical case
KELVIN = "K"  # the unit of temperatures, the only one that is the same in SI
CELSIUS = "degC"  # in which they are shown
PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
EVENTS = ("", "max-approach", "end")  # why a frame was kept; the first: because it was time


@dataclass(frozen=True)
class Variable:
    """The meaning of a name.

    unit: what 1 is, in words.  scale: the attribute of `Scales` that 1 is in SI.  si_name: in `VARIABLES` that in lower
    case where it is not given.  comment: what a user must know besides.
    """

    long_name: str
    symbol: str
    unit: str = "1"
    scale: str = ""
    si_units: str = ""
    si_name: str = ""
    comment: str = ""

    def factor(self, scales: Scales) -> float:
        """The value of 1 in SI."""
        return 1.0 if self.scale == COEFFICIENT else float(getattr(scales, self.scale))


# what 1 is: in words, as an attribute of `Scales`, in SI
TIME = ("t0", "t0", "s")
LENGTH = ("a*", "a", "m")
FILM = ("a*^2/R", "film", "m")
PRESSURE = ("p_h*", "p_h", "Pa")
FORCE = ("F*", "load", "N")
ENERGY = ("F* a*^2/R", "energy", "J")
POWER = ("F* a*^2/(R t0)", "power", "W")
OIL_FLOW = ("rho0 a*^4/(R t0)", "oil_flow", "m3/s")
SHEAR = ("p_h* a*/R", "shear_stress", "Pa")
NUMBER = ("a*/R", COEFFICIENT, "1")

RING = "in an axisymmetric contact the place is a ring: X is its radius, Y is 0"
AXES: Mapping[str, Variable] = {
    "time": Variable("time", "T", *TIME, "t"),
    "frame": Variable("time of a map", "T", *TIME, "t"),
    "X": Variable("position along x", "X", *LENGTH),
    "Y": Variable("position along y", "Y", *LENGTH),
    "r": Variable("distance from the centre", "r", *LENGTH),
    "grid": Variable("nodes per side of a grid", "n"),
    "iteration": Variable("Newton iteration", "k"),
}
AMBIENT = "in SI a volume: that of the oil at ambient pressure"
BUDGET: Mapping[str, Variable] = {  # the terms of the balances, see `equations.account`
    "mass": Variable("oil on the grid", "m", "rho0 a*^4/R", "oil", "m3", "oil_volume", AMBIENT),
    "inflow": Variable("oil that flows in through the edge of the grid", "m_in", *OIL_FLOW, comment=AMBIENT),
    "outflow": Variable("oil that flows out through the edge of the grid", "m_out", *OIL_FLOW, comment=AMBIENT),
    "cavity_source": Variable("oil that cavities make, zero to round-off", "m_c", *OIL_FLOW, comment=AMBIENT),
    "elastic_energy": Variable("elastic energy of the solids", "E_solids", *ENERGY),
    "oil_energy": Variable("elastic energy of the compressed oil", "E_oil", *ENERGY),
    "dissipation": Variable("viscous dissipation of the pressure-driven flow", "D", *POWER),
    "power_from_surfaces": Variable("power of the moving surfaces where the gap closes", "S_in", *POWER),
    "power_to_surfaces": Variable("power given back where the gap opens", "S_out", *POWER),
    "outside_power": Variable("power that goes to the oil outside the grid", "W_out", *POWER),
}
PUSHED = "the force of surface 1 on surface 2 over the load of the film, positive along X"
RESISTANCE = (
    "of each surface: (1/2) double integral of H dP/dX over the load of the film, positive against motion along X"
)
LOSS = "heat of sliding and of the pressure-driven flow"
FRICTION: Mapping[str, Variable] = {  # see `equations.account`
    "mu_sliding": Variable("traction coefficient", "mu_sliding", *NUMBER, comment=PUSHED),
    "mu_sliding_y": Variable("traction coefficient along y", "mu_sliding_y", *NUMBER, comment=PUSHED.replace("X", "Y")),
    "mu_rolling": Variable("rolling resistance coefficient", "mu_rolling", *NUMBER, comment=RESISTANCE),
    "power_loss": Variable("power loss", "power_loss", *POWER, comment=LOSS),
}
SCALARS: Mapping[str, Variable] = {
    "dT": Variable("time step", "dT", *TIME),
    "Delta": Variable("mutual approach of the bodies", "Delta", *FILM),
    "V": Variable("approach speed", "dDelta/dT", "a*^2/(R t0)", "speed", "m/s"),
    "F": Variable("load carried by the film", "F", *FORCE),
    "P_c": Variable("central pressure", "P_c", *PRESSURE),
    "P_max": Variable("maximum pressure", "P_max", *PRESSURE),
    "H_c": Variable("central film thickness", "H_c", *FILM),
    "H_min": Variable("minimum film thickness", "H_min", *FILM),
    "X_P_max": Variable("place of the maximum pressure along x", "X_P_max", *LENGTH, comment=RING),
    "Y_P_max": Variable("place of the maximum pressure along y", "Y_P_max", *LENGTH, comment=RING),
    "P_fall": Variable("fall of the pressure from its maximum to the next nodes", "1 - P_next/P_max"),
    "X_min": Variable("place of the minimum film thickness along x", "X_min", *LENGTH, comment=RING),
    "Y_min": Variable("place of the minimum film thickness along y", "Y_min", *LENGTH, comment=RING),
    **BUDGET,
    **FRICTION,
    "U": Variable("entrainment", "U", "a*/t0", "front_speed", "m/s", "u_m"),
    "w": Variable("applied load", "w", *FORCE),
    "error": Variable("local time error of the step", "error", "time.tolerance"),
    "newton_iterations": Variable("Newton iterations", "n_N"),
    "krylov_iterations": Variable("Krylov iterations", "n_K"),
    "convolutions": Variable("convolutions of the step, on the finest grid", "n_c"),
    "rejected": Variable("attempts rejected before the step", "n_r"),
}
FIELDS: Mapping[str, Variable] = {
    "P": Variable("pressure", "P", *PRESSURE),
    "H": Variable("film thickness", "H", *FILM),
    "oil": Variable("oil in the gap, H where it is full", "H_oil", *FILM, "h_oil"),
    "tau_x": Variable("shear stress in the middle of the film along x", "tau_x", *SHEAR),
    "tau_y": Variable("shear stress in the middle of the film along y", "tau_y", *SHEAR),
    "loss": Variable("power loss per area", "q", "p_h* a*^2/(R t0)", "power_per_area", "W/m2"),
}
TEMPERATURES: Mapping[str, Variable] = {  # maps of a steady contact with [thermal], see `solvers.heat`
    "T_1": Variable("temperature of surface 1", "T_1", KELVIN),
    "T_2": Variable("temperature of surface 2", "T_2", KELVIN),
    "T_film": Variable("temperature of the film", "T_film", KELVIN, comment="mean across the film"),
}
OF_A_GRID: Mapping[str, Variable] = {  # of a steady contact, with some of the scalars
    "load": Variable("load carried by the film", "integral of P", "a*^2 p_h*", "force", "N"),
    "residual": Variable("maximum residual", "res"),
    "history": Variable("maximum residual after each iteration", "res"),
}
HOTTEST: Mapping[str, Variable] = {
    "T_1_max": Variable("highest temperature of surface 1", "T_1_max", KELVIN),
    "T_2_max": Variable("highest temperature of surface 2", "T_2_max", KELVIN),
    "T_film_max": Variable("highest temperature of the film", "T_film_max", KELVIN),
    "phi_T": Variable("inlet factor of the film", "phi_T"),
}
OF_A_CURVE: Mapping[str, Variable] = {  # of a traction curve, with some of the scalars
    "mu_1": Variable("friction coefficient of surface 1, mu + mu_r", "mu_1", "a/R", COEFFICIENT, "1"),
    "mu_2": Variable("friction coefficient of surface 2, mu_r - mu", "mu_2", "a/R", COEFFICIENT, "1"),
    "tau_max": Variable("maximum mid-plane shear stress", "tau_max", "p_h a/R", "shear_stress", "Pa"),
    "mu_isothermal": Variable("isothermal traction coefficient", "mu_isothermal", *NUMBER, comment=PUSHED),
    **HOTTEST,
}
OUTCOME: Mapping[str, Variable] = {  # of a run as a whole
    "M": Variable("load parameter", "M"),
    "L": Variable("oil parameter", "L"),
    "H_min_extreme": Variable("thinnest film of the run", "H_min", *FILM),
    "P_max_extreme": Variable("highest pressure of the run", "P_max_extreme", *PRESSURE),
    "restitution": Variable("coefficient of restitution", "e"),
    "contact_time": Variable("contact time, with more than 1 % of the largest load", "T_contact", *TIME, "t_contact"),
    "h_c_warm": Variable("central film thickness, warm", "h_c", "m"),
    "h_min_warm": Variable("minimum film thickness, warm", "h_min", "m"),
    "mu_sliding_warm": Variable("traction coefficient, warm", "mu_sliding"),
    **{f"{name}_warm": variable for name, variable in HOTTEST.items()},
    "wall_time": Variable("time of computing", "t_wall", "s"),
}
EVENT = Variable("why the map was kept", "event")
_DEFINED: Mapping[str, Variable] = {
    **{**AXES, **SCALARS, **FIELDS, **TEMPERATURES, **OF_A_GRID, **OF_A_CURVE, **OUTCOME},
    "F_max": Variable("largest load carried by the film", "F_max", *FORCE),
    "T": AXES["time"],
    "event": EVENT,
}
VARIABLES: Mapping[str, Variable] = {
    name: replace(variable, si_name=variable.si_name or name.lower()) if variable.scale else variable
    for name, variable in _DEFINED.items()
}
FILMS = ("H_c", "H_min")
WHOLE = ("restitution", "contact_time", "F_max")  # of an impact as a whole
# with an error under --error and in a convergence series; P_max and places are values of single nodes
ESTIMATED = (*FILMS, "T", "Delta", "P_c", "F", *FRICTION, *WHOLE)
MEASURED = ("H_c", "H_min", "X_min", "Y_min", "Delta", "P_c", "P_max", "load")  # of a rolling contact's summary
MADE_BY = "ertel, with Matplotlib"  # in the files of pictures and movies: who drew them
FIGURES_IN_TIME = (
    "overview", "film", "pressure", "oil", "maps", "profiles", "history", "friction", "front", "spacetime",
)  # fmt: skip
FIGURES_STEADY = ("overview", "film", "pressure", "oil", "maps", "midlines", "convergence", "friction")
AT_MAXIMUM = ("T", "Delta", "F", "P_c", "P_max", "H_c", "H_min", "X_min", "Y_min")  # of a summary


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


def is_steady(dataset: "xr.Dataset") -> bool:
    """Return whether a Dataset holds a steady contact, on its grids, and not a run in time."""
    return "grid" in dataset.dims


def figures_of(dataset: "xr.Dataset") -> tuple[str, ...]:
    """The names of the figures that a run has, see `ertel.plots`."""
    return FIGURES_STEADY if is_steady(dataset) else FIGURES_IN_TIME


def with_coefficients(values: Mapping[str, Any], scales: Scales | None) -> dict[str, Any]:
    """The values with coefficients of friction as plain numbers in place of units a/R, where the case is physical."""
    unit = scales.a_over_R if scales else 1.0
    coefficients = {name: value for name, value in values.items() if VARIABLES.get(name, EVENT).scale == COEFFICIENT}
    return {**values, **{name: value if value is None else value * unit for name, value in coefficients.items()}}


def one_number(dataset: "xr.Dataset") -> "xr.Dataset":
    """The Dataset of a stored run, its coefficients of friction as plain numbers: earlier versions stored units a/R."""
    converted = {}
    for name, variable in dataset.variables.items():
        factor = variable.attrs.get("si_factor", 1.0)
        if VARIABLES.get(str(name), EVENT).scale == COEFFICIENT and factor != 1.0:
            attributes = {key: value for key, value in variable.attrs.items() if key != "in_units_of"}
            converted[name] = (variable.dims, variable.values * factor, {**attributes, "si_factor": 1.0})
    return dataset.assign(converted) if converted else dataset


def variable_attributes(name: str, scales: Scales | None) -> dict[str, Any]:
    """CF attributes of a variable: units, long_name, symbol, what 1 stands for, and its SI factor if there is one."""
    variable = VARIABLES[name]
    attributes: dict[str, Any] = {"long_name": variable.long_name, "symbol": variable.symbol, "units": "1"}
    if variable.unit == KELVIN:
        attributes["units"] = KELVIN
    elif variable.unit != "1" and not (scales and variable.scale == COEFFICIENT):
        attributes["in_units_of"] = variable.unit
    if variable.comment:
        attributes["comment"] = variable.comment
    if variable is EVENT:
        attributes |= {"flag_values": list(range(len(EVENTS))), "flag_meanings": " ".join(e or "time" for e in EVENTS)}
    if scales and variable.scale:
        attributes |= {"si_name": variable.si_name, "si_units": variable.si_units}
        attributes["si_factor"] = variable.factor(scales)
    return attributes


def value_in_si(value: Any, attributes: Mapping[str, Any]) -> tuple[str, Any, dict[str, Any]]:
    """The SI name, value and attributes of a variable of a physical case, from its own, which have an si_factor."""
    attributes = dict(attributes)
    factor, attributes["units"] = attributes.pop("si_factor"), attributes.pop("si_units")
    attributes["symbol"] = attributes.pop("si_name")
    attributes.pop("in_units_of", None)
    return attributes["symbol"], value * factor, attributes


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
    converted, names = dataset.copy(), {}
    for name, variable in dataset.variables.items():
        if "si_factor" in variable.attrs:
            new, values, attributes = value_in_si(variable.values, variable.attrs)
            converted[name] = (variable.dims, values, attributes)
            names[name] = new if name != "frame" else name
    return converted.rename(names)


def prefixed(unit: str, largest: float) -> tuple[float, str]:
    """A unit of SI with the prefix that brings the largest value between about 0.5 and 500: what 1 of it is, its name.

    Quotients and temperatures have no prefix, a plain number has no unit.
    """
    power = 0
    if abs(largest) > 0 and "/" not in unit and unit not in ("1", KELVIN, CELSIUS):
        power = min(max(3 * floor(log10(abs(largest)) / 3 + 0.1), min(PREFIXES)), max(PREFIXES))
    return 10.0**power, "" if unit == "1" else PREFIXES[power] + unit


def in_celsius(values: Any, unit: str) -> tuple[Any, str]:
    """Values and their unit for reading: temperatures (no differences of them) in degC, anything else as it is."""
    return (values - ZERO_CELSIUS, CELSIUS) if unit == KELVIN else (values, unit)


def with_prefix(value: float, unit: str) -> str:
    """A value in SI for reading: 1.4e9, "Pa" is "1.4 GPa"."""
    one, name = prefixed(unit, value)
    return f"{value / one:.4g} {name}".rstrip()


def values_in_si(values: Mapping[str, Any], scales: Scales) -> dict[str, float | None]:
    """Convert dimensionless values, by the name of their variable, to SI; what has no unit is left out.

    The names in SI end with the unit: H_c becomes h_c_m, P_max p_max_Pa.  H_c_error and H_c_extrapolated scale as H_c.
    """
    converted = {}
    for name, value in values.items():
        base = name.removesuffix("_error").removesuffix("_extrapolated")
        variable = VARIABLES.get(base)
        if variable is not None and variable.scale:
            key = named_with_unit(variable.si_name + name.removeprefix(base), variable.si_units)
            converted[key] = None if value is None else value * variable.factor(scales)
    return converted


def named_with_unit(name: str, unit: str) -> str:
    """A name with its unit at the end: h_c_m, mean_speed_m_per_s; a plain number keeps its name."""
    return name if unit == "1" else f"{name}_{unit.replace('/', '_per_').replace('*', '_')}"
