"""The error of a run in grid, time and domain together, from runs on the half grid that differ in one of them.

`comparisons` in `runs` gives these runs; their summaries complete that of the run itself.
"""

from collections.abc import Mapping
from math import hypot
from typing import Any, NamedTuple

from ertel.case.case import Case
from ertel.numerics.grid import extrapolate
from ertel.results.summary import with_si
from ertel.results.variables import FILMS

SMALLER_STEPS = 0.5**0.5  # of the run for the error in time: half the error of second order
WIDER_DOMAIN = 1.5  # of the run for the error of the domain


class Estimate(NamedTuple):
    """A value, what it lacks by grid, time and domain, the size of all three, and the value with them added."""

    value: float
    parts: Mapping[str, float]
    error: float
    extrapolated: float

    @property
    def dominant(self) -> str:
        """The largest part: "grid", "time" or "domain"."""
        return max(self.parts, key=lambda name: abs(self.parts[name]))

    def data(self) -> dict[str, Any]:
        """As plain data."""
        named = {"value": self.value, "error": self.error, "extrapolated": self.extrapolated}
        return {**named, **self.parts, "dominant": self.dominant}


def estimate(fine: float, others: Mapping[str, float]) -> Estimate:
    """The error of a value from the same value of other runs.

    grid: on the half grid.  time: there in smaller steps, by sqrt(1/2).  domain: there on a domain 1.5 times as wide.
    The last two are left out where they do not apply.  The error is of second order in the spacing and in the step, and
    of third order in 1/width: the oil outside carries a share 1/width^2 of the load, and its far field misses 1/width.
    """
    half = others["grid"]
    parts = {"grid": extrapolate(half, fine).extrapolated - fine}
    if "time" in others:
        parts["time"] = (others["time"] - half) / (1 - SMALLER_STEPS**2)
    if "domain" in others:
        parts["domain"] = (others["domain"] - half) / (1 - WIDER_DOMAIN**-3)
    return Estimate(fine, parts, hypot(*parts.values()), fine + sum(parts.values()))


def with_error(case: Case, fine: Mapping[str, Any], others: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The summary of a run with the errors of its films that other runs tell, and their parts under `error_estimate`.

    Those of an impact hold at maximum approach, and there is that of Delta too; `error_estimate` is None where one of
    the runs did not reach it.

    Parameters
    ----------
    case : Case
        The case of the run.
    fine : mapping
        The summary of the run.
    others : mapping
        The summaries of the other runs, see `estimate`.
    """
    own, compared, names = fine, others, {name: name for name in FILMS}
    if case.starts_apart:
        own, compared = fine["max_approach"], {part: summary["max_approach"] for part, summary in others.items()}
        names["Delta_max"] = "Delta"
        if own is None or None in compared.values():
            return {**fine, "error_estimate": None}
    estimates = {
        name: estimate(own[key], {part: values[key] for part, values in compared.items()})
        for name, key in names.items()
    }
    content = dict(fine)
    for name in FILMS:
        content |= {f"{name}_error": estimates[name].error, f"{name}_extrapolated": estimates[name].extrapolated}
    content["error_estimate"] = {name: each.data() for name, each in estimates.items()}
    return content if case.starts_apart else with_si(case, content)
