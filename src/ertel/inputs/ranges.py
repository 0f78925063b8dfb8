"""The values at which a curve is computed: a range such as "0:0.5:15", or values one by one.

    0:0.5:15                    15 values from 0 to 0.5, equal steps
    0.1 m/s:10 m/s:12:log       12 values, equal ratios: for a range over decades
    0.1:10 m/s:12:log           the same: a unit at one end holds for both
    0, 0.01, 0.05               these values

A quantity without any unit is in SI.
"""

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np

from ertel.case.reading import parse_number
from ertel.case.records import ConfigError, show
from ertel.inputs.quantities import parse_quantity
from ertel.physics.units import Bounds, Mark

LOG = "log"
MOST_VALUES = 1000
NUMBER = Bounds(gt=1, le=MOST_VALUES, whole=True)

Given = str | float | Sequence[Any]


def parse_values(name: str, given: Given, mark: Mark) -> tuple[float, ...]:
    """The values of a range, or of a list, in SI.

    Parameters
    ----------
    name : str
        What varies, for messages.
    given : str, float or sequence
        A text as above; or one value or several, each a number (in SI) or a text with a unit.
    mark : Unit or Bounds
        What a value must be: a quantity with this unit, or a plain number.

    Raises ConfigError for anything else, for no values at all, and for values that neither rise nor fall.

    Examples
    --------
    >>> from ertel.physics.units import VELOCITY
    >>> parse_values("mean_speed", "0.1:10 m/s:3:log", VELOCITY)
    (0.1, 1.0, 10.0)
    """
    try:
        found = _ranged(given, mark) if isinstance(given, str) and ":" in given else _listed(given, mark)
    except ValueError as error:
        raise ConfigError(f"{name} = {show(given)}: {error}") from error
    steps = {(late > early) - (late < early) for early, late in pairwise(found)}
    if len(steps) > 1 or 0 in steps:
        raise ConfigError(f"{name} = {show(given)}: must rise or fall from value to value")
    if len(found) > MOST_VALUES:
        raise ConfigError(f"{name}: has {len(found)} values; must be at most {MOST_VALUES}")
    return found


def _listed(given: Given, mark: Mark) -> tuple[float, ...]:
    if isinstance(given, int | float | np.generic):
        given = [given]
    items = given.split(",") if isinstance(given, str) else list(given)
    if not items:
        raise ValueError("must be one value or more")
    return tuple(_value(item, mark) for item in items)


def _ranged(text: str, mark: Mark) -> tuple[float, ...]:
    left, *rest = (part.strip() for part in text.split(":"))
    if len(rest) not in (2, 3) or rest[2:] not in ([], [LOG]):
        raise ValueError(f"must be FIRST:LAST:NUMBER, or FIRST:LAST:NUMBER:{LOG} for equal ratios")
    unit = unit_in(rest[0]) or unit_in(left)
    start, end = (_value(text, mark, unit) for text in (left, rest[0]))
    return spaced(start, end, _number(rest[1]), logarithmic=bool(rest[2:]))


def spaced(start: float, end: float, number: int, logarithmic: bool) -> tuple[float, ...]:
    """Values from start to end, with equal steps or equal ratios.  Raises ValueError where there are no such ratios."""
    if logarithmic and not start * end > 0:
        raise ValueError("the ends of a range with equal ratios (log) must both be above zero, or both below")
    if logarithmic:
        return (start, *(float(value) for value in np.geomspace(start, end, number)[1:-1]), end)
    first, last = Fraction(repr(start)), Fraction(repr(end))  # exact, so that a range through zero contains zero
    return tuple(float(first + (last - first) * i / (number - 1)) for i in range(number))


def _number(text: str) -> int:
    try:
        return int(parse_number(int(text), NUMBER))
    except ValueError as error:
        raise ValueError(f"the number of values must be a whole number from 2 to {MOST_VALUES}") from error


def unit_in(text: str) -> str:
    """The text after the number of a quantity."""
    return text.lstrip("+-0123456789.eE ")


def _value(given: Any, mark: Mark, unit: str = "") -> float:
    """A plain number, or a quantity in SI; one without its unit is in `unit`, or in SI."""
    given = given.item() if isinstance(given, np.generic) else given
    if isinstance(mark, Bounds):
        return parse_number(_plain(given) if isinstance(given, str) else given, mark)
    if isinstance(given, bool) or not isinstance(given, int | float | str):
        raise ValueError(f'must be numbers in {mark.unit}, or quantities such as "{mark.example}"')
    has_unit = isinstance(given, str) and unit_in(given)
    return parse_quantity(str(given).strip() if has_unit else f"{given} {unit or mark.unit}", mark)


def _plain(text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise ValueError(f"{show(text)} must be a number") from error
