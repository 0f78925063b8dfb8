"""Quantities as a user writes them, "10 mm", converted to SI.

Units are from pint, which is imported only if a unit differs from the SI unit.
"""

import re
from decimal import Decimal
from functools import cache
from typing import Any

from ertel.physics.units import Amount, Quantity, Unit

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf)\b)\s*(.*?)\s*", re.IGNORECASE)


def parse_quantity(value: object, unit: Unit) -> float | None:
    """A quantity such as "10 mm" as a finite number in the SI unit, above zero unless signed; None stays None.

    Examples
    --------
    >>> from ertel.physics.units import COMPLIANCE
    >>> parse_quantity("22 / GPa", COMPLIANCE) == 22e-9
    True
    """
    if value is None:
        return None
    wanted = f'a quantity {"" if unit.signed else "above zero "}with a unit such as "{unit.example}"'
    match = _NUMBER.fullmatch(value) if isinstance(value, str) else None
    if match is None or not match[2]:
        raise ValueError(f"must be {wanted}")
    written = f"1{match[2]}" if match[2].startswith("/") else match[2]
    if not unit.allows(float(match[1])):
        raise ValueError(f"must be {wanted}")
    return float(Decimal(match[1]) * _factor(written, unit))  # decimal, so that "18.6 mPa*s" is the float 0.0186


def parse_amount(value: object, unit: Unit) -> Amount | None:
    """A plain number in the units of a case, or a quantity in SI; None stays None."""
    if value is None or isinstance(value, Quantity):
        return value
    if isinstance(value, str):
        return Quantity(parse_quantity(value, unit) or 0.0, unit.unit)
    if isinstance(value, bool) or not isinstance(value, int | float) or not unit.allows(value):
        least = "" if unit.signed else " above zero"
        raise ValueError(f'must be a number{least}, in units {unit.own}, or a quantity such as "{unit.example}"')
    return float(value)


@cache
def _factor(written: str, unit: Unit) -> Decimal:
    """How many SI units one `written` is."""
    if written == unit.unit:
        return Decimal(1)
    import pint

    registry = _registry()
    try:
        found = registry.Quantity(1.0, registry.parse_units(written))
    except Exception as error:  # pint raises many kinds, from its own to the tokenizer's
        raise ValueError(f'has an unknown unit "{written}"; write for example "{unit.example}"') from error
    try:
        return Decimal(f"{found.to(unit.unit).magnitude:.14g}")  # without the round-off of powers of ten
    except pint.PintError as error:
        raise ValueError(
            f'has the wrong dimension {found.dimensionality}; write for example "{unit.example}"'
        ) from error


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()
