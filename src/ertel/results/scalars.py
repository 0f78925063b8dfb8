"""The numbers of a summary, each with its unit and what it is: for tables that compare runs.

Those of a physical case are in SI under SI names (h_c for H_c), the others in the units of the case.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ertel.physics.scales import Scales
from ertel.results.key_numbers import EXTREMES, KEY
from ertel.results.kinds import KINDS, Kind
from ertel.results.variables import FRICTION, VARIABLES, Variable

UNITS_AT_THE_END = {"_m": "m", "_K": "K"}  # of names in `thermal`
THERMAL = {  # of those values in `thermal` that have a name here
    "h_c_m": "central film thickness, warm",
    "h_min_m": "minimum film thickness, warm",
    "mu_sliding": "traction coefficient, warm",
    "T_1_max_K": "highest temperature of surface 1",
    "T_2_max_K": "highest temperature of surface 2",
    "T_film_max_K": "highest temperature of the film",
    "phi_T": "inlet factor of the film",
}
WORK = {"newton_iterations": "Newton iterations", "krylov_iterations": "Krylov iterations"}
SHOWN = (*KEY, *FRICTION, "restitution")  # in a table of many runs


class Scalar(NamedTuple):
    """A number of a run.  attributes: long_name, units (SI, or "1") and in_units_of, where that is not 1."""

    value: float
    attributes: Mapping[str, str]


def scalars(summary: Mapping[str, Any], scales: Scales | None) -> dict[str, Scalar]:
    """All numbers of a summary by name; the estimated error of H_c is H_c_error (in SI h_c_error).

    summary: as `results.summary` has it.  scales: of the case, None of a dimensionless one.  Empty before the first
    step.
    """
    return dict(_scalars(summary, KINDS[summary["kind"]], scales))


def _scalars(summary: Mapping[str, Any], kind: Kind, scales: Scales | None) -> Iterator[tuple[str, Scalar]]:
    yield from ((name, _plain(summary[name], text)) for name, text in (("M", "load parameter"), ("L", "oil parameter")))
    errors = kind.errors(summary)
    for name, value in kind.values(summary).items():
        variable = VARIABLES["time" if name == "T" else name]
        shown = _shown(name, scales)
        yield shown, _scalar(value, variable, kind, scales)
        if name in errors:
            about = f"estimated error of the {variable.long_name}"
            yield f"{shown}_error", _scalar(errors[name][0], variable, kind, scales, about)
    for name, one in summary.get("extremes", {}).items():
        yield f"{_shown(name, scales)}_extreme", _scalar(one["value"], VARIABLES[name], kind, scales, EXTREMES[name])
    if summary.get("restitution") is not None:
        yield "restitution", _plain(summary["restitution"], "coefficient of restitution")
    yield from _thermal(summary.get("thermal") or {})
    yield from ((name, _plain(summary[name], text)) for name, text in WORK.items() if name in summary)
    yield "wall_time", Scalar(float(summary["wall_s"]), {"long_name": "time of computing", "units": "s"})


def in_si(name: str) -> str:
    """The name of a number in SI; its own where it has no unit."""
    variable = VARIABLES.get("time" if name == "T" else name)
    return (variable and variable.si_name) or name


def _shown(name: str, scales: Scales | None) -> str:
    return in_si(name) if scales else name


def _scalar(value: float, variable: Variable, kind: Kind, scales: Scales | None, long_name: str = "") -> Scalar:
    about = {"long_name": long_name or variable.long_name}
    if scales and variable.scale:
        return Scalar(float(value) * variable.factor(scales), {**about, "units": variable.si_units or "1"})
    own = {"in_units_of": kind.unit(variable.unit)} if variable.unit != "1" else {}
    return Scalar(float(value), {**about, "units": "1", **own})


def _plain(value: float, long_name: str) -> Scalar:
    return Scalar(float(value), {"long_name": long_name, "units": "1"})


def _thermal(values: Mapping[str, Any]) -> Iterator[tuple[str, Scalar]]:
    for name, text in THERMAL.items():
        if values.get(name) is not None:
            ending = next((end for end in UNITS_AT_THE_END if name.endswith(end)), "")
            unit = UNITS_AT_THE_END.get(ending, "1")
            yield f"{name.removesuffix(ending)}_warm", Scalar(float(values[name]), {"long_name": text, "units": unit})
