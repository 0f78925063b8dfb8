"""Quantities: "10 mm" and what it is in SI; and amounts, which may also be plain numbers in the units of a case.

Units are pint's, and pint is late: it takes a while, and dimensionless cases never need it.
"""

import re
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from math import isfinite
from typing import Any


@dataclass(frozen=True)
class SI:
    """Marks a field as a quantity: its SI unit, an example of how to write it, whether it may be zero or less."""

    unit: str
    example: str
    signed: bool = False


LENGTH = SI("m", "10 mm")
MASS = SI("kg", "33 g")
DENSITY = SI("kg/m^3", "7850 kg/m^3")
SPEED = SI("m/s", "0.1 m/s")
VELOCITY = SI("m/s", "0.6 m/s", signed=True)
LOAD = SI("N", "40 N")
STRESS = SI("Pa", "210 GPa")
VISCOSITY = SI("Pa*s", "40 mPa*s")
COMPLIANCE = SI("1/Pa", "22 / GPa")
DURATION = SI("s", "5 ms")
TIME = SI("s", "5 ms", signed=True)
SMALL_LENGTH = SI("m", "50 um")
POSITION = SI("m", "50 um", signed=True)
HEIGHT = SI("m", "20 nm", signed=True)

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf)\b)\s*(.*?)\s*", re.IGNORECASE)


def parse_quantity(value: object, si: SI) -> float | None:
    """A quantity such as "10 mm" as a finite number in the SI unit, above zero unless signed; None stays None.

    Examples
    --------
    >>> parse_quantity("22 / GPa", COMPLIANCE) == 22e-9
    True
    """
    if value is None:
        return None
    wanted = f'a quantity {"" if si.signed else "above zero "}with a unit such as "{si.example}"'
    match = _NUMBER.fullmatch(value) if isinstance(value, str) else None
    if match is None or not match[2]:
        raise ValueError(f"must be {wanted}")
    unit = f"1{match[2]}" if match[2].startswith("/") else match[2]
    if not _allowed(float(match[1]), si):
        raise ValueError(f"must be {wanted}")
    return float(Decimal(match[1]) * _factor(unit, si))  # decimal, so that "18.6 mPa*s" is the float 0.0186


@dataclass(frozen=True)
class Amount:
    """A number in the units of a case, or, where it has an SI unit, a quantity."""

    value: float
    unit: str = ""

    def over(self, scale: float | None) -> float:
        """The number in the units of a case, whose scale is None where the case is dimensionless."""
        if not self.unit:
            return self.value
        if scale is None:
            raise ValueError(f"must be a plain number: a dimensionless case has no {self.unit}")
        return self.value / scale

    @property
    def plain(self) -> float | str:
        """As one would write it in a case file."""
        return f"{self.value!r} {self.unit}" if self.unit else self.value


def parse_amount(value: object, si: SI, own: str) -> Amount:
    """A plain number in the units `own` of a case, or a quantity."""
    if isinstance(value, Amount):
        return value
    if isinstance(value, str):
        return Amount(parse_quantity(value, si) or 0.0, si.unit)
    if isinstance(value, bool) or not isinstance(value, int | float) or not _allowed(value, si):
        least = "" if si.signed else " above zero"
        raise ValueError(f'must be a number{least}, in units {own}, or a quantity such as "{si.example}"')
    return Amount(float(value))


def _allowed(value: float, si: SI) -> bool:
    return isfinite(value) and (si.signed or value > 0)


@cache
def _factor(unit: str, si: SI) -> Decimal:
    """How many SI units one `unit` is."""
    if unit == si.unit:
        return Decimal(1)
    import pint

    registry = _registry()
    try:
        found = registry.Quantity(1.0, registry.parse_units(unit))
    except Exception as error:  # pint raises many kinds, from its own to the tokenizer's
        raise ValueError(f'has an unknown unit "{unit}"; write for example "{si.example}"') from error
    try:
        return Decimal(f"{found.to(si.unit).magnitude:.14g}")  # without the round-off of powers of ten
    except pint.PintError as error:
        raise ValueError(f'has the wrong dimension {found.dimensionality}; write for example "{si.example}"') from error


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()
