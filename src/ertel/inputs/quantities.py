"""Quantities as a user writes them, "10 mm", converted to SI.

Units are from pint, which is imported only if a unit differs from the SI unit.
"""

import re
from collections.abc import Mapping
from decimal import Decimal
from functools import lru_cache
from typing import Any

import numpy as np

from ertel.case.records import is_number, show
from ertel.physics.temperature_laws import ZERO_CELSIUS
from ertel.physics.units import LARGEST, Unit, reads_quantities

HOTTER_THAN_ANY = 1e4  # K
LONGEST = 60  # characters of a quantity

# What pint may see: names of units with powers of at most two digits, * and / between them, one level of parentheses.
# Without it pint computes numbers, such as 9**9**9, for ever.
_POWER = r"(?:\s*(?:\^|\*\*)\s*(?:[+-]?\d{1,2}(?:\.\d{1,2})?|\([+-]?\d{1,2}(?:\.\d{1,2})?\)))?"
_NAME = rf"(?:[^\W\d]\w*{_POWER}|1)"
_PRODUCT = rf"{_NAME}(?:(?:\s*[*/·]\s*|\s+){_NAME})*"
_FACTOR = rf"(?:\(\s*{_PRODUCT}\s*\){_POWER}|{_NAME})"
_UNIT = re.compile(rf"{_FACTOR}(?:(?:\s*[*/·]\s*|\s+){_FACTOR})*")
_TEMPERATURE = re.compile(  # units also as pint writes them
    r"\s*([+-]?[0-9]{1,4}(?:\.[0-9]{1,20})?)\s*(degC|°C|degree_Celsius|K|kelvin)\s*"
)
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


def parse_quantity(value: object, unit: Unit) -> float:
    """A quantity such as "10 mm" as a finite number in the SI unit, above zero unless signed.

    Raises ValueError for any other value, and for a text of more than 60 characters.

    Examples
    --------
    >>> from ertel.physics.units import COMPLIANCE
    >>> parse_quantity("22 / GPa", COMPLIANCE) == 22e-9
    True
    """
    if unit.unit == "K":  # degC has an offset
        return _temperature(value, unit)
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


def _temperature(value: object, unit: Unit) -> float:
    found = parse_temperature(value if isinstance(value, str) else None)
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


def parse_temperature(value: object) -> float:
    """A temperature in K from a number in K or a text, "40 degC" or "313.15 K".

    Raises ValueError for anything else, and below absolute zero.

    Examples
    --------
    >>> parse_temperature("40 degC")
    313.15
    """
    if is_number(value) and 0 < value < HOTTER_THAN_ANY:  # type: ignore[operator]
        return float(value)  # type: ignore[arg-type]
    match = _TEMPERATURE.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        kelvin = 0.0
    elif match[2] in ("K", "kelvin"):
        kelvin = float(match[1])  # as it is: a stored case reads back as the same
    else:
        kelvin = round(float(match[1]) + ZERO_CELSIUS, 6)
    if not kelvin > 0:
        raise ValueError('must be a temperature with its unit, "40 degC" or "313.15 K"')
    return kelvin


def with_unit(value: Any, mark: object) -> Any:
    """A number as a quantity in the SI unit of its field; anything else as it is."""
    if not isinstance(mark, Unit) or not is_number(value):
        return value
    shown = repr(float(value)) if isinstance(value, float) or abs(value) <= LARGEST else show(value)
    return f"{shown} {mark.unit}"


@reads_quantities
def number_or_quantity(value: object, unit: Unit) -> float:
    """A quantity given in Python, in SI: a number in the SI unit, or a text with a unit."""
    return parse_quantity(with_unit(plain_data(value), unit), unit)


@lru_cache(maxsize=256)
def _factor(written: str, unit: Unit) -> Decimal:
    """The number of SI units in one `written`."""
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
