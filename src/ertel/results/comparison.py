"""A measurement beside a run: the values of both, their difference, and the quantities that can be compared."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from ertel.results.alignment import Values
from ertel.results.numbers import IN_SI
from ertel.results.variables import OUTCOME, VARIABLES, Variable, with_prefix

if TYPE_CHECKING:
    from ertel.results.measurements import Measurement

INTENSITY = "intensity"
QUANTITIES: Mapping[str, Variable] = {  # by the names of the SI Dataset and of the summary
    **{variable.si_name or name: variable for name, variable in VARIABLES.items()},
    **{name: VARIABLES[name] for name in OUTCOME},
    INTENSITY: Variable("intensity", "I"),
}


def unit_of_quantity(quantity: str) -> str:
    """The SI unit of a quantity, "1" of a plain number.  Raises ValueError for a name that is not known."""
    if quantity not in QUANTITIES:
        raise ValueError(f"quantity = {quantity!r}: must be the name of a result, such as h, h_c, restitution")
    about = QUANTITIES[quantity]
    return about.si_units or (about.unit if about.unit in IN_SI else "1")


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """A measurement beside a run, in SI.

    Attributes
    ----------
    measurement : Measurement
        As it was given.
    x : array (n,)
        Its places or times, aligned; zero of a number.
    measured, computed : array (n,)
        The values, aligned, and those of the run; of an intensity as a share of the light.
    shown : array (n,)
        The values of the run as the instrument shows them, beside the measured ones as they were given.
    shift : mapping
        What the alignment took off: "centre" (m or s) of x, "offset" or "background" and "tilt" (per m or s) of the
        values; and their "gain", or the "index" of the oil that fits best.
    line : DataArray or None
        All that the run has along the line or through time, its attribute `moment` in words; None of a number.
    sigma : array (n,) or None
        The standard errors of the aligned values.
    """

    measurement: "Measurement"
    x: Values
    measured: Values
    computed: Values
    shown: Values
    shift: Mapping[str, float] = field(default_factory=dict)
    line: xr.DataArray | None = None
    sigma: Values | None = None

    @property
    def difference(self) -> Values:
        """Measured less computed, (n,)."""
        return self.measured - self.computed

    @property
    def rms(self) -> float:
        """The root mean square of the difference."""
        return float(np.sqrt(np.mean(self.difference**2)))

    @property
    def where(self) -> str:
        """The moment of a profile in words, "" of a history and of a number."""
        return "" if self.line is None else str(self.line.attrs["moment"])

    @property
    def text(self) -> str:
        """The rms difference in words, with its share of the mean."""
        share = self.rms / float(np.abs(self.computed).mean() or 1.0)
        return f"rms difference {with_prefix(self.rms, unit_of_quantity(self.measurement.quantity))} ({share:.1%} of the mean)"

    def __repr__(self) -> str:
        m = self.measurement
        units = {
            "centre": unit_of_quantity(m.axis),
            "offset": unit_of_quantity(m.quantity),
            "tilt": f"{unit_of_quantity(m.quantity)}/{unit_of_quantity(m.axis)}",
        }
        shift = "".join(f"; {name} {with_prefix(value, units.get(name, '1'))}" for name, value in self.shift.items())
        where = f", {self.where}" if self.where else ""
        return f"{m.name}: {QUANTITIES[m.quantity].long_name}{where}: {self.text}, {len(self.x)} values{shift}"
