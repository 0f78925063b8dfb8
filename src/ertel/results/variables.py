"""A run as an xarray Dataset: the one table of names, symbols and units, and the way back to SI.

Everything is dimensionless; where the case is physical each variable also carries `si_factor`, `si_units` and
`si_name`, so that a stored run turns into SI without ertel: value * si_factor.
"""

import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, is_dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from math import floor, inf, log10
from typing import Any, Protocol

import numpy as np
import xarray as xr

import ertel
from ertel.model import discretise
from ertel.model.case import Case
from ertel.model.state import GridSolution
from ertel.physics import hertz
from ertel.physics.geometry import HERTZ_LOAD
from ertel.physics.scales import HamrockDowson, Scales, hamrock_dowson

PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
EVENTS = ("", "max-approach", "end")  # why a frame was kept; the first: because it was time


@dataclass(frozen=True)
class Variable:
    """What a name stands for.  unit: what 1 is, in words; in SI it is `share` of the attribute `scale` of Scales."""

    long_name: str
    symbol: str
    unit: str = "1"
    scale: str = ""
    si_name: str = ""
    si_units: str = ""
    share: float = 1.0

    def factor(self, scales: Scales) -> float:
        """What 1 is in SI."""
        return float(getattr(scales, self.scale)) * self.share


def _length(long_name: str, symbol: str) -> Variable:
    return Variable(long_name, symbol, "a*", "a", symbol.lower(), "m")


def _film(long_name: str, symbol: str, si_name: str) -> Variable:
    return Variable(long_name, symbol, "a*^2/R", "film", si_name, "m")


def _pressure(long_name: str, symbol: str) -> Variable:
    return Variable(long_name, symbol, "p_h*", "p_h", symbol.lower(), "Pa")


def _time(long_name: str, symbol: str) -> Variable:
    return Variable(long_name, symbol, "t0", "t0", symbol.replace("T", "t"), "s")


AXES: Mapping[str, Variable] = {
    "time": _time("time", "T"),
    "frame": _time("time of a map", "T"),
    "X": _length("position along x", "X"),
    "Y": _length("position along y", "Y"),
    "r": _length("distance from the centre", "r"),
    "grid": Variable("nodes per side of a grid", "n"),
    "iteration": Variable("Newton iteration", "k"),
}
SCALARS: Mapping[str, Variable] = {
    "dT": _time("time step", "dT"),
    "Delta": _film("mutual approach of the bodies", "Delta", "delta"),
    "V": Variable("approach speed", "dDelta/dT", "a*^2/(R t0)", "speed", "v", "m/s"),
    "F": Variable("load carried by the film", "F", "F*", "load", "f", "N"),
    "P_c": _pressure("central pressure", "P_c"),
    "P_max": _pressure("largest pressure", "P_max"),
    "H_c": _film("central film thickness", "H_c", "h_c"),
    "H_min": _film("least film thickness", "H_min", "h_min"),
    "X_min": _length("place of the least film", "X_min"),  # smooth impact: its radius
    "Y_min": _length("place of the least film across", "Y_min"),
    "U": Variable("entrainment", "U", "a*/t0", "front_speed", "u_m", "m/s"),
    "w": Variable("applied load", "w", "F*", "load", "w", "N"),
    "error": Variable("local time error of the step", "error", "time.tolerance"),
    "newton_iterations": Variable("Newton iterations of the step", "n_N"),
    "krylov_iterations": Variable("Krylov iterations of the step", "n_K"),
    "convolutions": Variable("convolutions of the step, on the finest grid", "n_c"),
    "rejected": Variable("attempts rejected before the step", "n_r"),
}
FIELDS: Mapping[str, Variable] = {
    "P": _pressure("pressure", "P"),
    "H": _film("film thickness", "H", "h"),
}
OF_A_GRID: Mapping[str, Variable] = {  # of a steady contact, with some of the scalars
    "load": Variable("load carried by the film", "integral of P", "a*^2 p_h*", "load", "load", "N", 1 / HERTZ_LOAD),
    "residual": Variable("largest residual", "res"),
    "history": Variable("largest residual after each iteration", "res"),
}
EVENT = Variable("why the map was kept", "event")
VARIABLES: Mapping[str, Variable] = {**AXES, **SCALARS, **FIELDS, **OF_A_GRID, "event": EVENT}
FILMS = ("H_c", "H_min")  # that have an error estimate
MEASURED = ("H_c", "H_min", "X_min", "Y_min", "Delta", "P_c", "P_max", "load")  # of a rolling contact's summary
AT_MAXIMUM = ("T", "Delta", "F", "P_c", "P_max", "H_c", "H_min", "X_min")  # of a summary


class Frame(Protocol):
    """A map of film and pressure: what `simulation` hands over."""

    @property
    def T(self) -> float: ...
    @property
    def P(self) -> Any: ...
    @property
    def H(self) -> Any: ...
    @property
    def event(self) -> str: ...


def variable_attributes(name: str, scales: Scales | None) -> dict[str, object]:
    """CF attributes of a variable: units, long_name, symbol, what 1 stands for, and its SI factor if there is one."""
    variable = VARIABLES[name]
    attributes: dict[str, object] = {"long_name": variable.long_name, "symbol": variable.symbol, "units": "1"}
    if variable.unit != "1":
        attributes["in_units_of"] = variable.unit
    if variable is EVENT:
        attributes |= {"flag_values": list(range(len(EVENTS))), "flag_meanings": " ".join(e or "time" for e in EVENTS)}
    if scales and variable.scale:
        attributes |= {"si_name": variable.si_name, "si_units": variable.si_units}
        attributes["si_factor"] = variable.factor(scales)
    return attributes


def columns(records: Sequence[Mapping[str, float]]) -> dict[str, np.ndarray]:
    """Step records as arrays by variable name, T as `time`."""
    names = {"time": "T", **{name: name for name in SCALARS}}
    return {name: np.array([record[key] for record in records], dtype=float) for name, key in names.items()}


def maps(frames: Sequence[Frame]) -> dict[str, np.ndarray]:
    """Frames as arrays by variable name, stacked along the first axis."""
    return {
        "frame": np.array([frame.T for frame in frames], dtype=float),
        "event": np.array([EVENTS.index(frame.event) for frame in frames], dtype=np.int8),
        **{name: np.array([getattr(frame, name) for frame in frames], dtype=float) for name in FIELDS},
    }


def dimensions(name: str, coordinates: Mapping[str, Any]) -> tuple[str, ...]:
    """Dimensions of a variable; the space axes are those of the method's coordinates, in order."""
    if name in FIELDS:
        return ("frame", *coordinates)
    return (name,) if name in AXES else ("frame",) if name == "event" else ("time",)


def assemble(
    case: Case,
    records: Sequence[Mapping[str, float]],
    frames: Sequence[Frame],
    coordinates: Mapping[str, Any],
    attributes: Mapping[str, object] | None = None,
) -> xr.Dataset:
    """The run as a Dataset: scalars over `time` (every step), maps over `frame` and the space axes.

    attributes are added to the provenance of the case (see `provenance`).
    """
    axes_in_space = {name: np.asarray(axis) for name, axis in coordinates.items()}
    fields = maps(frames)
    for name in FIELDS:  # no maps at all still have their shape
        fields[name] = fields[name].reshape(len(frames), *(len(axis) for axis in axes_in_space.values()))
    arrays = {**columns(records), **fields, **axes_in_space}
    variables = {
        name: (dimensions(name, coordinates), values, variable_attributes(name, case.scales))
        for name, values in arrays.items()
    }
    axes = {name: variables.pop(name) for name in AXES if name in variables}
    return xr.Dataset(variables, axes, {**provenance(case), **(attributes or {})})


def assemble_steady(
    case: Case, solutions: Sequence[GridSolution], attributes: Mapping[str, object] | None = None
) -> xr.Dataset:
    """The steady contact as a Dataset: H and P on the finest grid so far, scalars and residuals over `grid`.

    grid: nodes a side, coarsest first.  convolutions: in units of one on that grid.  attributes as in `assemble`.
    """
    finest = solutions[-1].grid if solutions else discretise.grid_of(case)
    nothing = np.full((finest.nodes, finest.nodes), np.nan)
    last = solutions[-1] if solutions else None
    fields = {name: np.asarray(last.whole(getattr(last, name))) if last else nothing for name in FIELDS}
    longest = max((len(s.history) for s in solutions), default=0)
    history = np.full((len(solutions), longest), np.nan)
    for row, s in zip(history, solutions, strict=True):
        row[: len(s.history)] = s.history
    of_grids = [{**s.measure(), **_work(s)} for s in solutions]
    names = (*MEASURED, "residual", "newton_iterations", "krylov_iterations", "convolutions")
    arrays: dict[str, tuple[tuple[str, ...], Any]] = {
        **{name: (("Y", "X"), values) for name, values in fields.items()},
        **{name: (("grid",), np.array([row[name] for row in of_grids], dtype=float)) for name in names},
        "history": (("grid", "iteration"), history),
    }
    axes = {"Y": finest.y, "X": finest.x, "grid": np.array([s.grid.nodes for s in solutions], dtype=np.int64)}
    coordinates = {**axes, "iteration": np.arange(longest)}
    return xr.Dataset(
        {name: (dims, values, variable_attributes(name, case.scales)) for name, (dims, values) in arrays.items()},
        {name: ((name,), values, variable_attributes(name, case.scales)) for name, values in coordinates.items()},
        {**provenance(case), **(attributes or {})},
    )


def _work(s: GridSolution) -> dict[str, float]:
    counts = {"newton_iterations": s.newton, "krylov_iterations": s.krylov, "convolutions": s.convolutions}
    return {"residual": s.residual, **counts}


def to_si(dataset: xr.Dataset) -> xr.Dataset:
    """The run of a physical case in SI units, its variables under their SI names (h_c for H_c, t for time, ...).

    Raises ValueError for a dimensionless run.
    """
    if not any("si_factor" in variable.attrs for variable in dataset.variables.values()):
        raise ValueError("dataset: has no SI scales, its case was dimensionless; give radius, mass, speed, ... instead")
    converted = dataset.copy()
    names = {}
    for name, variable in dataset.variables.items():
        attributes = dict(variable.attrs)
        if "si_factor" in attributes:
            factor, attributes["units"] = attributes.pop("si_factor"), attributes.pop("si_units")
            attributes["symbol"] = attributes.pop("si_name")
            attributes.pop("in_units_of")
            converted[name] = (variable.dims, variable.values * factor, attributes)
            names[name] = attributes["symbol"] if name != "frame" else name
    return converted.rename({name: new for name, new in names.items() if new != name})


def exponent(size: float) -> int:
    """The power of ten, of those with a prefix, that brings a size between about 0.5 and 500."""
    return min(max(3 * floor(log10(size) / 3 + 0.1), min(PREFIXES)), max(PREFIXES)) if size > 0 else 0


def with_prefix(value: float, unit: str) -> str:
    """A value in SI for reading: 1.4e9, "Pa" is "1.4 GPa"."""
    power = 0 if "/" in unit else exponent(abs(value))
    return f"{value / 10**power:.4g} {PREFIXES[power]}{unit}"


# -- provenance -------------------------------------------------------------------------------------------------------


def provenance(case: Case) -> dict[str, object]:
    """Attributes that make a run self-describing: case, versions, platform, time, references."""
    laws = (case.lubricant.viscosity_law, case.lubricant.density_law)
    return {
        "Conventions": "CF-1.11",
        "title": case.name or f"{case.kind}, M = {case.parameters.M:.4g}, L = {case.parameters.L:.4g}",
        "source": f"ertel {ertel.__version__}",
        "references": "; ".join(getattr(law, "reference", type(law).__name__) for law in laws),
        "date_created": datetime.now(UTC).isoformat(timespec="seconds"),
        "platform": f"{platform.system()} {platform.machine()}, {platform.processor() or 'unknown processor'}",
        "versions": json.dumps(versions()),
        "case": json.dumps(describe(case), default=repr),
        "kind": case.kind,
        "method": case.solver.method,
        **parameters_of(case),
        **scales_of(case),
    }


def versions() -> dict[str, str]:
    """Versions of what a result may depend on."""
    packages = ("jax", "jaxlib", "numpy", "scipy", "xarray", "zarr")
    ours = {"ertel": ertel.__version__, "python": platform.python_version()}
    return ours | {name: version(name) for name in packages}


def describe(case: Case) -> dict[str, object]:
    """A case as plain data: the records that it is made of, the names of its laws, and its input."""
    oil = case.lubricant
    return {
        "name": case.name,
        "kind": case.kind,
        "parameters": asdict(case.parameters),
        "lubricant": {"viscosity": _describe_law(oil.viscosity_law), "density": _describe_law(oil.density_law)},
        "motion": {name: _describe_law(value) for name, value in vars(case.motion).items()},
        "roughness": [{"surface": f.surface, **_describe_law(f.shape)} for f in case.roughness],
        "solver": asdict(case.solver),
        "time": asdict(case.time),
        "output": asdict(case.output),
        "scales": asdict(case.scales) if case.scales else None,
        "source": case.source,
    }


def _describe_law(law: Any) -> Any:
    """A record as its name and what is in it; infinite means that there is none.  A number as it is."""
    if isinstance(law, int | float):
        return law
    values = asdict(law) if is_dataclass(law) and not isinstance(law, type) else {}
    return {"law": type(law).__name__, **{name: value for name, value in values.items() if value != inf}}


def parameters_of(case: Case) -> dict[str, float]:
    """The dimensionless parameters by name."""
    p = case.parameters
    return {"lambda_bar": p.lambda_bar, "alpha_bar": p.alpha_bar, "M": p.M, "L": p.L}


def parameter_summary(case: Case) -> dict[str, Any]:
    """What the parameters of a case say before it is run; under `si` the scales of a physical one, named with units.

    Names: U, G, W, Hamrock and Dowson's, for an impact with F* and a*/t0 for load and speed.  Of an impact: stokes,
    St = m v0/(6 pi eta0 R^2); trapped_film, the scale of the film in a*^2/R; contact_time_s, of the dry impact.
    """
    p, s = case.parameters, case.scales
    impact = case.kind == "impact"
    content: dict[str, Any] = {**parameters_of(case)}
    if impact:
        content |= {"stokes": p.stokes, "trapped_film": p.trapped_film}
    if s is None:
        return content
    more = {}
    if impact:
        more = {"contact_time_s": hertz.CONTACT_TIME * s.t0, "mass_kg": s.ball_mass}
        more["trapped_film_m"] = p.trapped_film * s.film
    return {**content, **ugw_of(case)._asdict(), "si": {**scales_of(case), **more}}


def ugw_of(case: Case) -> HamrockDowson:
    """Hamrock and Dowson's U, G, W of a physical case.  Raises ValueError for a dimensionless one."""
    p, s = case.parameters, case.scales
    if s is None:
        raise ValueError("case: has no U, G, W, it is dimensionless")
    eta0 = p.lambda_bar * s.t0 * s.a**2 * s.p_h / (12 * s.R**2)
    return hamrock_dowson(s, eta0, p.alpha_bar / s.p_h)


def scales_of(case: Case) -> dict[str, float]:
    """The SI scales of a physical case, named with their units; empty for a dimensionless one."""
    s = case.scales
    if s is None:
        return {}
    named = {"R_m": s.R, "E_prime_Pa": s.E_prime, "a_m": s.a, "p_h_Pa": s.p_h, "delta_m": s.film}
    speed = {"v0_m_per_s": s.speed} if case.kind == "impact" else {"u_m_m_per_s": s.front_speed}
    return named | {"F_N": s.load, "t0_s": s.t0} | speed


def si_summary(case: Case, max_approach: Mapping[str, float] | None) -> dict[str, object] | None:
    """An impact's summary in SI: the scales and the values at maximum approach; None for a dimensionless case.

    Names end with their unit: t_s, delta_m, f_N, p_c_Pa, p_max_Pa, h_c_m, h_min_m, x_min_m.
    """
    if case.scales is None:
        return None
    values = None if max_approach is None else in_si({key: max_approach[key] for key in AT_MAXIMUM}, case.scales)
    return {**scales_of(case), "max_approach": values}


def in_si(values: Mapping[str, float | None], scales: Scales) -> dict[str, float | None]:
    """Values by the name of their variable in SI, under its SI name and unit; H_c_error and the like as H_c."""
    found = {}
    for name, value in values.items():
        base = name.removesuffix("_error").removesuffix("_extrapolated")
        variable = VARIABLES["time" if base == "T" else base]
        unit = variable.si_units.replace("/", "_per_")
        found[f"{variable.si_name}{name.removeprefix(base)}_{unit}"] = (
            None if value is None else value * variable.factor(scales)
        )
    return found
