"""The error of a run in grid, time and domain together, from runs on the half grid that differ in one of them."""

from collections.abc import Mapping
from math import hypot
from typing import Any, NamedTuple

from ertel.numerics.grid import extrapolate

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
