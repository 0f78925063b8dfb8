"""Units of the fields of records: marks in annotations, and numbers with a unit.

    radius: Annotated[float, LENGTH]          # a quantity: the record holds metres
    wavelength: Annotated[Amount, WIDTH]      # an amount: a number in the units of the case, or a Quantity in SI

Reading and writing of case files, checks of values and conversion to the units of the case all use the same mark.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import isfinite
from typing import Annotated, Any, get_args, get_origin, get_type_hints

SMALLEST, LARGEST = 1e-30, 1e30  # sizes of the numbers of a case: far beyond any contact, and no product overflows


def _is_finite(value: float) -> bool:
    return not isinstance(value, float) or isfinite(value)  # an int may have too many digits for `isfinite`


def _size_complaint(value: float, positive: bool) -> str:
    least = SMALLEST if positive else -LARGEST
    return "" if least <= value <= LARGEST else f"must be between {least:g} and {LARGEST:g}"


@dataclass(frozen=True)
class Unit:
    """SI unit of a field, with an example of how to write it.

    signed: whether the value may be zero or negative.  An amount also has `scale`, the attribute of `Scales` that is
    one unit of the case, and `own`, the name of that unit.
    """

    unit: str
    example: str
    signed: bool = False
    scale: str = ""
    own: str = ""

    def allows(self, value: float) -> bool:
        """Whether a value is allowed, apart from its size: finite, and above zero unless signed."""
        return _is_finite(value) and (self.signed or value > 0)

    def size_complaint(self, value: float) -> str:
        """Between which sizes the value must be, or "" if it is."""
        return _size_complaint(value, positive=not self.signed)

    def complaint(self, value: float) -> str:
        """What the value must be, or "" if it is allowed."""
        if not self.allows(value):
            return "must be finite" if self.signed else "must be finite and above zero"
        return self.size_complaint(value)


LENGTH = Unit("m", "10 mm")
MASS = Unit("kg", "33 g")
DENSITY = Unit("kg/m^3", "7850 kg/m^3")
SPEED = Unit("m/s", "0.1 m/s")
VELOCITY = Unit("m/s", "0.6 m/s", signed=True)
LOAD = Unit("N", "40 N")
RADIUS = Unit("m", "10 mm", signed=True)  # of curvature: negative where the surface is concave
ANGLE = Unit("deg", "30 deg", signed=True)
STRESS = Unit("Pa", "210 GPa")
VISCOSITY = Unit("Pa*s", "40 mPa*s")
COMPLIANCE = Unit("1/Pa", "22 / GPa")
KINEMATIC_VISCOSITY = Unit("m^2/s", "68 mm^2/s")
TEMPERATURE = Unit("K", "40 degC")
EXPANSION = Unit("1/K", "7e-4 / K")
CONDUCTIVITY = Unit("W/(m*K)", "0.14 W/(m*K)")
HEAT_CAPACITY = Unit("J/(kg*K)", "2000 J/(kg*K)")

DURATION = Unit("s", "5 ms", scale="t0", own="t0")
TIME = Unit("s", "5 ms", signed=True, scale="t0", own="t0")
WIDTH = Unit("m", "50 um", scale="a", own="a")
POSITION = Unit("m", "50 um", signed=True, scale="a", own="a")
HEIGHT = Unit("m", "20 nm", signed=True, scale="film", own="a^2/R")


@dataclass(frozen=True)
class Bounds:
    """Bounds of a plain number; messages are derived from them.  whole: the number must be an integer."""

    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None
    whole: bool = False

    def complaint(self, value: float) -> str:
        """What the value must be, or "" if it is allowed."""
        if not _is_finite(value):
            return "must be a finite number"
        if self.whole and not isinstance(value, int):
            return "must be an integer"
        limits = {
            "gt": "greater than",
            "ge": "greater than or equal to",
            "lt": "less than",
            "le": "less than or equal to",
        }
        inside = {
            "gt": lambda limit: value > limit,
            "ge": lambda limit: value >= limit,
            "lt": lambda limit: value < limit,
            "le": lambda limit: value <= limit,
        }
        for name, words in limits.items():
            limit = getattr(self, name)
            if limit is not None and not inside[name](limit):
                return f"must be {words} {limit:g}"
        return _size_complaint(value, positive=self.gt == 0)


FINITE = Bounds()
ABOVE_ZERO = Bounds(gt=0)
NOT_NEGATIVE = Bounds(ge=0)
SHARE = Bounds(gt=0, lt=1)

Mark = Unit | Bounds


@dataclass(frozen=True)
class Quantity:
    """A number in an SI unit, not yet converted to the units of a case."""

    value: float
    unit: str

    def __str__(self) -> str:
        return f"{float(self.value)!r} {self.unit}"


Amount = float | Quantity


def plain(amount: Amount) -> float:
    """The number of an amount that is already in the units of the case.  Raises TypeError for a Quantity."""
    if isinstance(amount, Quantity):
        raise TypeError(f"{amount}: is in SI; bring it to the units of the case first")
    return amount


def marks(record: Any) -> Mapping[str, Mark]:
    """The marks of the fields of a record (a class), by name of the field; fields without a mark are left out."""
    return _marks(record)


@cache
def _marks(record: Any) -> Mapping[str, Mark]:
    hints = get_type_hints(record, include_extras=True)
    found = {name: _mark(hint) for name, hint in hints.items()}
    return {name: mark for name, mark in found.items() if mark is not None}


def _mark(hint: Any) -> Mark | None:
    if get_origin(hint) is Annotated:
        return next((part for part in get_args(hint)[1:] if isinstance(part, Unit | Bounds)), None)
    return None
