"""The numbers of a run as one table, which repr, notebooks, `ertel ls`, `ertel compare`, studies and the app print.

It is made from the summary of the run, as `results.summary` writes it and as summary.json has it, also that of earlier
versions.  This module imports neither JAX nor xarray.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ertel.case.case import Case
from ertel.case.status import Status
from ertel.physics.scales import Scales
from ertel.results.variables import COEFFICIENT, FILMS, FRICTION, MEASURED, OUTCOME, VARIABLES, unit_of, with_prefix

Outcome = Mapping[str, Any]  # of a run, as `results.summary` and `summary.json` have it

KEY = ("H_c", "H_min", "P_max")
SHOWN = (*KEY, *FRICTION, "restitution")  # in a table of many runs
WARM = {  # of those under `thermal`
    **{"h_c_m": "h_c_warm", "h_min_m": "h_min_warm", "mu_sliding": "mu_sliding_warm", "T_1_max_K": "T_1_max_warm"},
    **{"T_2_max_K": "T_2_max_warm", "T_film_max_K": "T_film_max_warm", "phi_T": "phi_T_warm"},
}
WORK = {"newton_iterations": "newton_iterations", "krylov_iterations": "krylov_iterations", "wall_s": "wall_time"}
IN_SI = ("m", "K", "s")  # units of numbers that are in SI in the summary itself
FREE = ("name", "reference")  # keys of a case that change no result


class Number(NamedTuple):
    """A number of the outcome of a run.

    value, error, extrapolated: in `unit`, "1" for a plain number; the error is the estimated one of the discretisation.
    factor: what 1 is in SI, where the value is known by si_name in si_units; None for a dimensionless case.
    """

    name: str
    symbol: str
    long_name: str
    value: float
    unit: str = "1"
    factor: float | None = None
    si_name: str = ""
    si_units: str = "1"
    error: float | None = None
    extrapolated: float | None = None

    @property
    def text(self) -> str:
        """The value in its unit."""
        if self.name == "restitution":
            return f"{self.value:.4f}"
        return f"{self.value:.4g}" if self.unit == "1" else f"{self.value:.4g} {self.unit}"

    @property
    def text_in_si(self) -> str:
        """The value in SI; empty where it is not known, or the same."""
        known = self.factor is not None and self.si_units != "1"
        return with_prefix(self.value * (self.factor or 1.0), self.si_units) if known else ""

    @property
    def text_of_error(self) -> str:
        """The error over the value; empty where it is not known."""
        return f"{self.error / abs(self.value):.1%}" if self.error is not None and self.value else ""

    @property
    def full_text(self) -> str:
        """The value in SI and in its unit, as far as they are known."""
        return f"{self.text_in_si} ({self.text})" if self.text_in_si else self.text


def numbers(summary: Outcome) -> dict[str, Number]:
    """The numbers of a summary by name: parameters, values, extremes, restitution, temperatures, work.

    The values of an impact hold at maximum approach, those of rolling at the last time, or steadily; before, there are
    none.
    """
    values = {"M": summary["M"], "L": summary["L"], **values_of(summary)}
    values |= {f"{name}_extreme": one["value"] for name, one in summary.get("extremes", {}).items()}
    values["restitution"] = summary.get("restitution")
    thermal = summary.get("thermal") or {}
    values |= {name: thermal.get(key) for key, name in WARM.items()}
    values |= {name: summary.get(key) for key, name in WORK.items()}
    scales, errors = scales_in(summary), errors_of(summary)
    return {
        name: number(summary["kind"], scales, name, value, *errors.get(name, ()))
        for name, value in values.items()
        if value is not None
    }


def number(
    kind: str,
    scales: Scales | None,
    name: str,
    value: float,
    error: float | None = None,
    extrapolated: float | None = None,
) -> Number:
    """A number by its name in `VARIABLES` or `OUTCOME`, in a contact of this kind, with these scales."""
    variable = OUTCOME.get(name) or VARIABLES[name]
    physical = scales is not None and bool(variable.scale)
    return Number(
        name,
        variable.symbol,
        variable.long_name,
        value,
        "1" if physical and variable.scale == COEFFICIENT else unit_of(kind, variable.unit),
        variable.factor(scales) if scales and physical else None,
        variable.si_name or name,
        variable.si_units or "1",
        error,
        extrapolated,
    )


def values_of(summary: Outcome) -> dict[str, float]:
    """The measured values by name; empty where there are none."""
    if "max_approach" in summary:
        return dict(summary["max_approach"] or {})
    names = ("T", *MEASURED, *FRICTION) if summary["H_c"] is not None else ()
    return {name: summary[name] for name in names if name in summary}


def errors_of(summary: Outcome) -> dict[str, tuple[float, float]]:
    """Discretisation error and extrapolated value by name, where they were estimated."""
    names = [name for name in FILMS if summary.get(f"{name}_error") is not None]
    errors = {name: (summary[f"{name}_error"], summary[f"{name}_extrapolated"]) for name in names}
    for name, estimate in (summary.get("error_estimate") or {}).items():
        errors["Delta" if name == "Delta_max" else name] = estimate["error"], estimate["extrapolated"]
    return errors


def scales_in(summary: Outcome) -> Scales | None:
    """The scales of the case, None of a dimensionless one."""
    si = summary.get("si")
    if si is None:
        return None
    radius_ratio = summary.get("radius_ratio", 1.0)
    return Scales(si["R_m"], si["E_prime_Pa"], si["a_m"], si["p_h_Pa"], si["t0_s"], radius_ratio)


def moment(summary: Outcome) -> str:
    """The time at which the values hold, or the reason why there are none."""
    gone = summary["status"] == Status.FILM_VANISHED.value
    if "max_approach" in summary:
        if summary["max_approach"]:
            return "at maximum approach"
        return "no result, the film vanishes before" if gone else "maximum approach was not reached"
    if summary["H_c"] is None:
        return "no result" if gone or "T" not in summary else "no step was taken"
    if "T" in summary:
        return f"at T = {summary['T']:.4g}"
    return f"on {summary['nodes']} x {summary.get('nodes_y', summary['nodes'])} nodes"


def key_numbers(summary: Outcome) -> list[Number]:
    """Films, maximum pressure, friction and restitution of a run; empty without them.

    A coefficient of friction is named where it is not zero.
    """
    if not values_of(summary):
        return []
    table = numbers(summary)
    names = [name for name in SHOWN if name in KEY or name in table]
    return [table[name] for name in names if name not in FRICTION or table[name].value]


def as_now(summary: Outcome) -> dict[str, Any]:
    """The summary of a stored run; earlier versions had the coefficients of friction in units a/R and under `si`."""
    reached, si = summary.get("max_approach"), summary.get("si", {})
    if reached:
        return {**summary, "max_approach": _with_coefficients(reached, si.get("max_approach") or {})}
    return _with_coefficients(summary, si)


def _with_coefficients(values: Outcome, si: Mapping[str, float]) -> dict[str, Any]:
    return {**values, **{name: si[name] for name in FRICTION if name in values and name in si}}


# -- tables of many runs ----------------------------------------------------------------------------------------------


class Scalar(NamedTuple):
    """A number for a table.  attributes: long_name, units (SI, or "1") and in_units_of, where that is not 1."""

    value: float
    attributes: Mapping[str, str]


def scalars(summary: Outcome, in_si: bool = True) -> dict[str, Scalar]:
    """The numbers of a summary by name; those of a physical case in SI under SI names (h_c for H_c), if `in_si`.

    The estimated error of H_c is H_c_error, in SI h_c_error.
    """
    table = {}
    for each in numbers(summary).values():
        name, factor, about = each.name, 1.0, {"units": "1"}
        if in_si and each.factor is not None:
            name, factor, about = each.si_name, each.factor, {"units": each.si_units}
        elif each.unit in IN_SI:
            about = {"units": each.unit}
        elif each.unit != "1":
            about = {"units": "1", "in_units_of": each.unit}
        table[name] = Scalar(float(each.value * factor), {"long_name": each.long_name, **about})
        if each.error is not None:
            long_name = f"estimated error of the {each.long_name}"
            table[f"{name}_error"] = Scalar(each.error * factor, {"long_name": long_name, **about})
    return table


class Difference(NamedTuple):
    """A key of the cases that differs.  first, second: its values, None where it is not there."""

    field: str
    first: Any
    second: Any


def differences(first: Case, second: Case) -> list[Difference]:
    """The keys of two cases that differ, names and references apart."""
    one, two = (dict(_flat(case.to_data())) for case in (first, second))
    return [Difference(key, one.get(key), two.get(key)) for key in {**one, **two} if one.get(key) != two.get(key)]


def _flat(data: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Every value with its place: contact.speed, roughness[1].amplitude."""
    if isinstance(data, Mapping):
        for key, value in data.items():
            if key not in FREE:
                yield from _flat(value, f"{place}.{key}".removeprefix("."))
    elif isinstance(data, list) and data and all(isinstance(item, Mapping) for item in data):
        for position, item in enumerate(data, 1):
            yield from _flat(item, f"{place}[{position}]")
    else:
        yield place, data


class Compared(NamedTuple):
    """A number of both runs, with its name, what it is and its unit; None where it is not there."""

    name: str
    first: float | None
    second: float | None
    attributes: Mapping[str, str]

    @property
    def change(self) -> float | None:
        """second/first - 1; None where one is not there or the first is zero."""
        if self.first is None or self.second is None or self.first == 0:
            return None
        return self.second / self.first - 1


def pairs(first: Outcome, second: Outcome) -> list[Compared]:
    """The numbers of two runs from their summaries; in SI where both cases are."""
    in_si = "si" in first and "si" in second
    one, two = (scalars(summary, in_si) for summary in (first, second))
    values = [(name, one.get(name), two.get(name)) for name in {**one, **two}]
    return [Compared(name, a and a.value, b and b.value, (a or two[name]).attributes) for name, a, b in values]
