"""Quantities as a user writes them, "10 mm", converted to SI.

Units are from pint, which is imported only if a unit differs from the SI unit.
"""

import re
from collections.abc import Mapping
from decimal import Decimal
from functools import lru_cache
from typing import Any

import numpy as np

from ertel.physics.units import Amount, Bounds, Quantity, Unit

LONGEST = 60  # characters of a quantity

# What pint may see: names of units with powers of at most two digits, * and / between them, one level of parentheses.
# Without it pint computes numbers, such as 9**9**9, for ever.
_POWER = r"(?:\s*(?:\^|\*\*)\s*(?:[+-]?\d{1,2}(?:\.\d{1,2})?|\([+-]?\d{1,2}(?:\.\d{1,2})?\)))?"
_NAME = rf"(?:[^\W\d]\w*{_POWER}|1)"
_PRODUCT = rf"{_NAME}(?:(?:\s*[*/·]\s*|\s+){_NAME})*"
_FACTOR = rf"(?:\(\s*{_PRODUCT}\s*\){_POWER}|{_NAME})"
_UNIT = re.compile(rf"{_FACTOR}(?:(?:\s*[*/·]\s*|\s+){_FACTOR})*")
_NUMBER = re.compile(r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3}(?![0-9]))?|(?:nan|inf)\b)", re.I)


def plain_data(value: Any) -> Any:
    """NumPy's scalars as numbers, and a pint quantity as a text; also inside of lists and tables."""
    if isinstance(value, Mapping):
        return {key: plain_data(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain_data(item) for item in value]
    if isinstance(value, np.generic):
        return value.item()
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        return f"{plain_data(value.magnitude)!r} {value.units}"
    return value


def parse_quantity(value: object, unit: Unit) -> float | None:
    """A quantity such as "10 mm" as a finite number in the SI unit, above zero unless signed; None stays None.

    Raises ValueError for any other value, and for a text of more than 60 characters.

    Examples
    --------
    >>> from ertel.physics.units import COMPLIANCE
    >>> parse_quantity("22 / GPa", COMPLIANCE) == 22e-9
    True
    """
    if value is None:
        return None
    wanted = f'a quantity {"" if unit.signed else "above zero "}with a unit such as "{unit.example}"'
    if isinstance(value, str) and len(value) > LONGEST:
        raise ValueError(f"must be {wanted}, of at most {LONGEST} characters")
    number, written = _split(value)
    if not written:
        raise ValueError(f"must be {wanted}")
    found = float(Decimal(number) * _factor(written, unit))  # decimal, so that "18.6 mPa*s" is the float 0.0186
    if not unit.allows(found):
        raise ValueError(f"must be {wanted}")
    if complaint := unit.size_complaint(found):
        raise ValueError(complaint)
    return found


def _split(value: object) -> tuple[str, str]:
    """The number and the unit of a text; "" for what is not there."""
    text = value.strip() if isinstance(value, str) else ""
    match = _NUMBER.match(text)
    if match is None:
        return "", ""
    unit = text[match.end() :].lstrip()
    return match[0], f"1{unit}" if unit.startswith("/") else unit


def parse_number(value: object, bounds: Bounds) -> float:
    """A plain number within bounds; an int stays an int if the number must be whole."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("must be an integer" if bounds.whole else "must be a number")
    if complaint := bounds.complaint(value):
        raise ValueError(complaint)
    return value if bounds.whole else float(value)


def parse_amount(value: object, unit: Unit) -> Amount | None:
    """A plain number in the units of a case, or a quantity in SI; None stays None."""
    if value is None or isinstance(value, Quantity):
        return value
    if isinstance(value, str):
        return Quantity(parse_quantity(value, unit.in_si) or 0.0, unit.unit)
    if isinstance(value, bool) or not isinstance(value, int | float) or not unit.allows(value):
        least = "" if unit.signed else " above zero"
        raise ValueError(f'must be a number{least}, in units {unit.own}, or a quantity such as "{unit.example}"')
    if complaint := unit.size_complaint(value):
        raise ValueError(complaint)
    return float(value)


@lru_cache(maxsize=256)
def _factor(written: str, unit: Unit) -> Decimal:
    """How many SI units one `written` is."""
    if written == unit.unit:
        return Decimal(1)
    unknown = f'has an unknown unit "{written}"; write for example "{unit.example}"'
    if not _UNIT.fullmatch(written):
        raise ValueError(unknown)
    registry = _registry()
    try:
        found = registry.Quantity(1.0, registry.parse_units(written))
        wrong = found.dimensionality != registry.Quantity(1.0, unit.unit).dimensionality
        factor = 1.0 if wrong else found.to(unit.unit).magnitude
    except Exception as error:  # pint raises many kinds, from its own to the tokenizer's
        raise ValueError(unknown) from error
    if wrong:
        raise ValueError(f'has the wrong dimension {found.dimensionality}; write for example "{unit.example}"')
    return Decimal(f"{factor:.14g}")  # without the round-off of powers of ten


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()
