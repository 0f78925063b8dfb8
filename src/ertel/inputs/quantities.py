"""Quantities as a user writes them, "10 mm", converted to SI: one, or several as a list or a range.

Units are from pint, which takes long to import: it reads all but the SI unit and the usual prefixes of that.
"""

import re
import unicodedata
from collections.abc import Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from ertel.case.reading import parse_number
from ertel.case.records import is_number, refusing, show, with_unit
from ertel.physics.temperature_laws import ZERO_CELSIUS
from ertel.physics.units import KINEMATIC_VISCOSITY, PREFIXED, ROUGHNESS, Bounds, Mark, Unit, reads_quantities

NumberOrText = float | str  # in SI, or a text with a unit
HOTTER_THAN_ANY = 1e4  # K
ANGULAR = re.compile("rpm|rad|deg|rev|turn")
PIXELS = ("px", "pixel", "pixels", "dot", "pel", "css_pixel")  # pint has sizes for some of them
LONGEST = 60  # characters of a quantity
RMS_OVER_MEAN = 1.25  # an rms roughness over Ra, of Gaussian heights

# What pint may see: names of units with powers of at most two digits, * and / between them, one level of parentheses.
# Without it pint computes numbers, such as 9**9**9, for ever.
_POWER = r"(?:\s*(?:\^|\*\*)\s*(?:[+-]?\d{1,2}(?:\.\d{1,2})?|\([+-]?\d{1,2}(?:\.\d{1,2})?\)))?"
_NAME = rf"(?:[^\W\d]\w*{_POWER}|1)"
_PRODUCT = rf"{_NAME}(?:(?:\s*[*/]\s*|\s+){_NAME})*"
_FACTOR = rf"(?:\(\s*{_PRODUCT}\s*\){_POWER}|{_NAME})"
_UNIT = re.compile(rf"{_FACTOR}(?:(?:\s*[*/]\s*|\s+){_FACTOR})*")
_TEMPERATURE = re.compile(  # units also as pint writes them
    r"\s*([+-]?[0-9]{1,4}(?:\.[0-9]{1,20})?)\s*(degC|°C|degree_Celsius|K|kelvin)\s*"
)
_NUMBER = re.compile(r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3}(?![0-9]))?|(?:nan|inf)\b)", re.I)
_THOUSANDS = re.compile(r"\s*[+-]?(?:[1-9][0-9]{0,2}(?:,[0-9]{3})+|[0-9]+[.,][0-9]+[.,].*)(?![0-9])")
_DECIMAL_COMMA = re.compile(r"(\s*[+-]?[0-9]+),([0-9]+)")
_POWER_OF_TEN = re.compile(r"(?<=[0-9])\s*[*x]\s*10\s*(?:\^|\*\*)?\s*(?=[+-]?[0-9])")
_SIGNS = str.maketrans("\u2212\u22c5\u00b7\u2219\u00d7", "-***x")  # minus, three dots, times
_AS_IN_PAPERS = [  # what stands in papers and data sheets: what pint reads in its place
    (re.compile(r"°"), "deg"),
    (re.compile(r"(?<=Pa)-?s\b"), "*s"),  # the pascal-second: nobody writes "Pas" for several pascals
    (re.compile(r"/\s*(m|kg)\s*\*?\s*K"), r"/(\1*K)"),  # W/mK: a millikelvin is not meant
    (re.compile(r"(?<=[^\W\d_])\.(?=[^\W\d_])"), "*"),
    (re.compile(r"(?<=[^\W\d_])(-?[1-4])(?![\w.])"), r"^\1"),  # mm2/s, K-1
]
_MEAN = re.compile(r"\s*Ra(?!\s*Ra)")  # of heights; once
_VG = re.compile(r"\s*ISO[\s-]*VG[\s-]*([0-9]{1,4})\s*", re.I)


def plain_data(value: Any) -> Any:
    """NumPy's scalars as numbers, and a pint quantity as a text; also inside of lists and tables."""
    if isinstance(value, Mapping):
        return {key: plain_data(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain_data(item) for item in value]
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0):
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
    if isinstance(value, str) and (grade := _VG.fullmatch(value[:LONGEST])):  # ISO 3448
        if unit.unit != KINEMATIC_VISCOSITY.unit:
            raise ValueError("is a viscosity at 40 degC; give an oil by name (ertel oils), or nu40, nu100 and density")
        value = f"{grade[1]} mm^2/s"
    if unit == ROUGHNESS and isinstance(value, str) and (mean := _MEAN.match(value)):
        return RMS_OVER_MEAN * parse_quantity(value[mean.end() :], unit)
    if isinstance(value, str) and _THOUSANDS.match(value[:LONGEST]):
        raise ValueError("has a comma that may part thousands or decimals; write a point, and nothing for thousands")
    description = f'a quantity {"" if unit.signed else "above zero "}with a unit such as "{unit.example}"'
    if isinstance(value, str) and len(value) > LONGEST:
        raise ValueError(f"must be {description}, of at most {LONGEST} characters")
    if unit.unit == "K":  # degC has an offset
        number_in_si = parse_temperature(value if isinstance(value, str) else None)
    else:
        number, written = split(value)
        if not written:
            raise ValueError(f"must be {description}")
        number_in_si = float(Decimal(number) * _factor(written, unit))  # decimal: "18.6 mPa*s" is the float 0.0186
    if complaint := unit.complaint(number_in_si):
        raise ValueError(complaint)
    return number_in_si


def split(value: object) -> tuple[str, str]:
    """The number and the unit of a text; "" for what is not there."""
    text = _plain_signs(value).strip() if isinstance(value, str) else ""
    match = _NUMBER.match(text)
    if match is None:
        return "", ""
    unit = text[match.end() :].lstrip()
    for written, read in _AS_IN_PAPERS:
        unit = written.sub(read, unit)
    return match[0], f"1{unit}" if unit.startswith("/") else unit


def _plain_signs(text: str) -> str:
    """A text in plain signs: superscripts, minus, dots and the degree as they are typed, with a decimal point.

    >>> _plain_signs("2,2⋅10⁻⁸ m²/N")
    '2.2e-8 m2/N'
    """
    plain = unicodedata.normalize("NFKC", text.translate(_SIGNS)).translate(_SIGNS)
    return _POWER_OF_TEN.sub("e", _DECIMAL_COMMA.sub(r"\1.\2", plain, count=1), count=1)


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
    match = _TEMPERATURE.fullmatch(_plain_signs(value)) if isinstance(value, str) else None
    if match is None:
        kelvin = 0.0
    elif match[2] in ("K", "kelvin"):
        kelvin = float(match[1])  # as it is: a stored case reads back as the same
    else:
        kelvin = round(float(match[1]) + ZERO_CELSIUS, 6)
    if not kelvin > 0:
        raise ValueError('must be a temperature with its unit, "40 degC" or "313.15 K"')
    return kelvin


def quantity_of(name: str, given: object, unit: Unit) -> float:
    """A quantity as `parse_quantity` reads it.  Raises ConfigError, which names the argument."""
    with refusing(name, given):
        return parse_quantity(given, unit)


@reads_quantities
def number_or_quantity(value: object, unit: Unit) -> float:
    """A quantity given in Python, in SI: a number in the SI unit, or a text with a unit."""
    return parse_quantity(with_unit(plain_data(value), unit), unit)


@lru_cache(maxsize=256)
def _factor(written: str, unit: Unit) -> Decimal:
    """The number of SI units in one `written`."""
    power = 0 if written == unit.unit else PREFIXED.get((written.replace("1/ ", "1/"), unit.unit))
    if power is not None:
        return Decimal(10) ** power
    if unit.unit == "rad/s" and not ANGULAR.search(written):
        raise ValueError(f'does not say what turns: write "{unit.example}", or rad/s')
    if written in PIXELS:
        raise ValueError('is in pixels; give the size of one as its unit, such as "0.8 um"')
    unknown = f'has an unknown unit "{written}"; write for example "{unit.example}"'
    if not _UNIT.fullmatch(written):
        raise ValueError(unknown)
    registry = _registry()
    try:
        one = registry.Quantity(1.0, registry.parse_units(written))
        wrong = one.dimensionality != registry.Quantity(1.0, unit.unit).dimensionality
        factor = 1.0 if wrong else one.to(unit.unit).magnitude
    except Exception as error:  # pint raises many kinds, from its own to the tokenizer's
        raise ValueError(unknown) from error
    if wrong and unit.unit == "N" and (one * registry.m).check(unit.unit):
        raise ValueError("is a load per length; give the load on the whole length, and contact.length")
    if wrong:
        raise ValueError(f'has the wrong dimension {one.dimensionality}; write for example "{unit.example}"')
    return Decimal(f"{factor:.14g}")  # without the round-off of powers of ten


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


# -- several values: a range such as "0:0.5:15", or values one by one -------------------------------------------------
#
#     0:0.5:15                    15 values from 0 to 0.5, equal steps
#     0.1 m/s:10 m/s:12:log       12 values, equal ratios: for a range over decades
#     0.1:10 m/s:12:log           the same: a unit at one end holds for both
#     0, 0.01, 0.05               these values
#
# In studies and on the command line.  A quantity without any unit is in SI, in a study it needs one.

LOG = "log"
MOST_VALUES = 1000
_RANGE = re.compile(rf"([^:]+):([^:]+):\s*([0-9]{{1,4}})\s*(:\s*{LOG}\s*)?")

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
    with refusing(name, given):
        values = _ranged(given, mark) if isinstance(given, str) and ":" in given else _listed(given, mark)
        steps = {(late > early) - (late < early) for early, late in pairwise(values)}
        if len(steps) > 1 or 0 in steps:
            raise ValueError("must rise or fall from value to value")
        if len(values) > MOST_VALUES:
            raise ValueError(f"has {len(values)} values; must be at most {MOST_VALUES}")
    return values


def _listed(given: Given, mark: Mark) -> tuple[float, ...]:
    if isinstance(given, int | float | np.generic):
        given = [given]
    items = given.split(",") if isinstance(given, str) else list(given)
    if not items:
        raise ValueError("must be one value or more")
    return tuple(marked_value(item, mark) for item in items)


class Range(NamedTuple):
    """Values from one end to the other: the numbers and the units of both ends, how many values, which steps."""

    ends: tuple[str, str]
    units: tuple[str, str]
    number: int
    logarithmic: bool

    @classmethod
    def read(cls, text: str) -> "Range":
        """The range in a text as above; a unit at one end holds for both.  Raises ValueError for anything else."""
        match = _RANGE.fullmatch(text)
        if match is None or not 2 <= int(match[3]) <= MOST_VALUES:
            number = f"with NUMBER a whole number from 2 to {MOST_VALUES}"
            raise ValueError(f"must be FIRST:LAST:NUMBER, or FIRST:LAST:NUMBER:{LOG} for equal ratios, {number}")
        (first, unit), (last, other) = map(split, match.group(1, 2))
        for end, written in zip((first, last), match.groups(), strict=False):
            if not end or not isfinite(float(end)):
                raise ValueError(f"{show(written.strip())} must be a finite number, with or without a unit")
        return cls((first, last), (unit or other, other or unit), int(match[3]), match[4] is not None)

    def between(self, first: float, last: float) -> tuple[float, ...]:
        """The values between two ends, equal steps or equal ratios.  Raises ValueError without such ratios."""
        if self.logarithmic and not first * last > 0:
            raise ValueError("the ends of a range with equal ratios (log) must both be above zero, or both below")
        if self.logarithmic:
            return (first, *(float(value) for value in np.geomspace(first, last, self.number)[1:-1]), last)
        start, end = Fraction(repr(first)), Fraction(repr(last))  # exact, so that a range through zero contains zero
        return tuple(float(start + (end - start) * i / (self.number - 1)) for i in range(self.number))


def _ranged(text: str, mark: Mark) -> tuple[float, ...]:
    found = Range.read(text)
    first, last = (marked_value(" ".join(end), mark) for end in zip(found.ends, found.units, strict=True))
    return found.between(first, last)


def marked_value(given: Any, mark: Mark) -> float:
    """A plain number, or a quantity in SI; one without its unit is in SI."""
    given = plain_data(given)
    if isinstance(given, str) and (isinstance(mark, Bounds) or not split(given)[1]):
        try:
            given = float(given)
        except ValueError as error:
            raise ValueError(f"{show(given)} must be a number") from error
    if isinstance(mark, Bounds):
        return parse_number(given, mark)
    if isinstance(given, bool) or not isinstance(given, int | float | str):
        raise ValueError(f'must be numbers in {mark.unit}, or quantities such as "{mark.example}"')
    return number_or_quantity(given, mark)
