"""Units and meanings of the fields of records: marks in annotations, and numbers with a unit.

    radius: Annotated[float, LENGTH, Meaning("radius of the ball")]   # a quantity: the record holds metres
    wavelength: Annotated[Amount, WIDTH]      # an amount: a number in the units of the case, or a Quantity in SI

Reading and writing of case files, checks of values and conversion to the units of the case all use the same mark.
Every text that explains a key to a user is made from its meaning.
"""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields, replace
from functools import cache
from math import isfinite
from numbers import Real
from textwrap import wrap
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

SMALLEST, LARGEST = 1e-30, 1e30  # sizes of the numbers of a case: far beyond any contact, and no product overflows


def _is_finite(value: float) -> bool:
    return not isinstance(value, float) or isfinite(value)  # an int may have too many digits for `isfinite`


def _size_complaint(value: float, least: float, most: float) -> str:
    return "" if least <= value <= most else f"must be between {least:g} and {most:g}"


@dataclass(frozen=True)
class Unit:
    """SI unit of a field, with an example of how to write it.

    signed: whether the value may be zero or negative.  least, most: the sizes that it may have, in the SI unit; beyond
    any real contact, so that only typing errors are refused.  An amount also has `scale`, the attribute of
    `Scales` that is one unit of the case, and `own`, the name of that unit; least and most are then in this unit.
    """

    unit: str
    example: str
    signed: bool = False
    scale: str = ""
    own: str = ""
    least: float = SMALLEST
    most: float = LARGEST

    def between(self, least: float, most: float) -> "Unit":
        """The same unit for a value of other sizes."""
        return replace(self, least=least, most=most)

    @property
    def in_si(self) -> "Unit":
        """The unit of a quantity; it differs for an amount only."""
        return Unit(self.unit, self.example, self.signed) if self.scale else self

    def allows(self, value: float) -> bool:
        """Whether a value is allowed, apart from its size: finite, and above zero unless signed."""
        return _is_finite(value) and (self.signed or value > 0)

    def size_complaint(self, value: float) -> str:
        """Between which sizes the value must be, or "" if it is."""
        complaint = _size_complaint(value, -self.most if self.signed else self.least, self.most)
        return complaint and f"{complaint}{f', in units {self.own}' if self.scale else f' {self.unit}'}"

    def complaint(self, value: float) -> str:
        """The complaint, what the value must be, or "" if it is allowed."""
        if not self.allows(value):
            return "must be finite" if self.signed else "must be finite and above zero"
        return self.size_complaint(value)


LENGTH = Unit("m", "10 mm")
MASS = Unit("kg", "33 g", least=1e-18, most=1e12)
DENSITY = Unit("kg/m^3", "7850 kg/m^3", least=0.1, most=1e5)
SPEED = Unit("m/s", "0.1 m/s", least=1e-9, most=1e4)
VELOCITY = Unit("m/s", "0.6 m/s", signed=True, most=1e4)
LOAD = Unit("N", "40 N", least=1e-12, most=1e12)
RADIUS = Unit("m", "10 mm", signed=True, most=1e5)  # of curvature: negative where the surface is concave
ANGLE = Unit("deg", "30 deg", signed=True)
ROTATION = Unit("rad/s", "1500 rpm", least=1e-6, most=1e6)
TORQUE = Unit("N*m", "100 N*m", least=1e-12, most=1e12)
STIFFNESS = Unit("N/m", "40 N/mm", least=1e-6, most=1e15)
STRESS = Unit("Pa", "210 GPa")
MODULUS = STRESS.between(1.0, 1e14)
VISCOSITY = Unit("Pa*s", "40 mPa*s", least=1e-7, most=1e6)
COMPLIANCE = Unit("1/Pa", "22 / GPa", least=1e-13, most=1e-5)
KINEMATIC_VISCOSITY = Unit("m^2/s", "68 mm^2/s", least=1e-9, most=1e3)
TEMPERATURE = Unit("K", "40 degC", least=1.0, most=5000.0)
EXPANSION = Unit("1/K", "7e-4 / K", least=1e-8, most=1.0)
CONDUCTIVITY = Unit("W/(m*K)", "0.14 W/(m*K)", least=1e-4, most=1e5)
HEAT_CAPACITY = Unit("J/(kg*K)", "2000 J/(kg*K)", least=1.0, most=1e6)

DURATION = Unit("s", "5 ms", scale="t0", own="t0")
TIME = Unit("s", "5 ms", signed=True, scale="t0", own="t0")
WIDTH = Unit("m", "50 um", scale="a", own="a", least=1e-6, most=1e6)
POSITION = Unit("m", "50 um", signed=True, scale="a", own="a", most=1e6)
LAYER = Unit("m", "2 um", scale="film", own="a^2/R", least=1e-9, most=1e6)
HEIGHT = Unit("m", "20 nm", signed=True, scale="film", own="a^2/R", most=1e6)
ROUGHNESS = Unit("m", "50 nm")
RMS = Unit("m", "50 nm", scale="film", own="a^2/R", least=1e-12, most=1e6)

# the usual units with a prefix: the power of ten that one of them is, by its name and that of the SI unit
_PREFIXES = {"n": -9, "u": -6, "m": -3, "k": 3, "M": 6, "G": 9}
PREFIXED = {(p + unit, unit): n for unit in ("m", "s", "m/s", "N", "Pa", "Pa*s") for p, n in _PREFIXES.items()}
PREFIXED |= {(f"1/{prefix}Pa", "1/Pa"): -power for prefix, power in _PREFIXES.items()}


@dataclass(frozen=True)
class Bounds:
    """Bounds of a plain number; messages are derived from them.

    whole: the number must be an integer.  least, most: the sizes that it may have, as in `Unit`.
    """

    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None
    whole: bool = False
    least: float = SMALLEST
    most: float = LARGEST

    def complaint(self, value: float) -> str:
        """The complaint, what the value must be, or "" if it is allowed."""
        if not _is_finite(value):
            return "must be a finite number"
        if self.whole and not isinstance(value, int):
            return "must be an integer"
        if self.gt is not None and value <= self.gt:
            return f"must be greater than {self.gt:g}"
        if self.ge is not None and value < self.ge:
            return f"must be greater than or equal to {self.ge:g}"
        if self.lt is not None and value >= self.lt:
            return f"must be less than {self.lt:g}"
        if self.le is not None and value > self.le:
            return f"must be less than or equal to {self.le:g}"
        lowest = -self.most if self.ge is None else self.ge
        return _size_complaint(value, self.least if self.gt == 0 else lowest, self.most)


FINITE = Bounds()
ABOVE_ZERO = Bounds(gt=0)
NOT_NEGATIVE = Bounds(ge=0)
SHARE = Bounds(gt=0, lt=1)

Mark = Unit | Bounds


@dataclass(frozen=True)
class Meaning:
    """The meaning of a field to a user.

    text: a phrase, without a capital letter and a full stop.  example: a value as it is written in a case file, where
    neither the unit nor the default shows one.
    """

    text: str
    example: Any = None


NO_MEANING = Meaning("")
MUST_BE_GIVEN = object()  # in the place of the usual value of a field


@dataclass(frozen=True)
class Quantity:
    """A number in an SI unit, not yet converted to the units of a case."""

    value: float
    unit: str

    def __mul__(self, factor: float) -> "Quantity":
        return Quantity(self.value * factor, self.unit)

    def __str__(self) -> str:
        return f"{float(self.value)!r} {self.unit}"


Amount = float | Quantity


def plain(amount: Amount) -> float:
    """The number of an amount that is already in the units of the case.  Raises TypeError for a Quantity."""
    if isinstance(amount, Quantity):
        raise TypeError(f"{amount}: is in SI; bring it to the units of the case first")
    return amount


@dataclass(frozen=True)
class Field:
    """A field of a record: all that the reader, the writer, the checks and the texts for users know of it.

    hint: its annotation without mark and meaning.  usual: the value that it has if it is left out; MUST_BE_GIVEN: none.
    """

    name: str
    hint: Any
    mark: Mark | None = None
    meaning: Meaning = NO_MEANING
    usual: Any = MUST_BE_GIVEN

    @property
    def options(self) -> tuple[Any, ...]:
        """The kinds of values that the annotation allows."""
        return get_args(self.hint) or (self.hint,)

    @property
    def choices(self) -> tuple[Any, ...]:
        """The values that the annotation enumerates."""
        options = (self.hint, *self.options)
        return tuple(value for option in options if get_origin(option) is Literal for value in get_args(option))


def fields_of(record: Any) -> Mapping[str, Field]:
    """The fields of a record, or of a class of records, by name."""
    return _fields_of(record if isinstance(record, type) else type(record))


@cache
def _fields_of(record: Any) -> Mapping[str, Field]:
    hints, whole, found = get_type_hints(record), get_type_hints(record, include_extras=True), {}
    for item in fields(record):
        parts = getattr(whole[item.name], "__metadata__", ())
        meaning = next((part for part in parts if isinstance(part, Meaning)), NO_MEANING)
        mark = next((part for part in parts if isinstance(part, Unit | Bounds)), None)
        usual = MUST_BE_GIVEN if item.default is MISSING else item.default
        usual = usual if item.default_factory is MISSING else item.default_factory()
        found[item.name] = Field(item.name, hints[item.name], mark, meaning, usual)
    return found


def marks(record: Any) -> Mapping[str, Mark]:
    """The marks of the fields of a record (a class), by name of the field; fields without a mark are left out."""
    return {name: field.mark for name, field in fields_of(record).items() if field.mark}


def meanings(record: Any) -> Mapping[str, Meaning]:
    """The meanings of the fields of a record (a class), by name of the field; fields without one are left out."""
    return {name: field.meaning for name, field in fields_of(record).items() if field.meaning.text}


def require_positive(**values: float) -> None:
    """Raise ValueError unless all values, given by their names, are finite and above zero."""
    for name, value in values.items():
        if not (isfinite(value) and value > 0):
            raise ValueError(f"{name} = {value}: must be finite and above zero")


def require_not_negative(**values: float) -> None:
    """Raise ValueError unless all values, given by their names, are finite and not below zero."""
    for name, value in values.items():
        if not (isfinite(value) and value >= 0):
            raise ValueError(f"{name} = {value}: must be finite and not below zero")


# -- what is made of the marks ----------------------------------------------------------------------------------------

Record = TypeVar("Record", bound=type)
_quantity_readers: list[Callable[[Any, Unit], float]] = []  # the last one counts


def reads_quantities(reader: Callable[[Any, Unit], float]) -> Callable[[Any, Unit], float]:
    """A decorator for the function that reads numbers in SI and texts with a unit, "10 mm": that of `inputs`."""
    _quantity_readers.append(reader)
    return reader


def in_si(value: Any, mark: Mark) -> float:
    """The value of a field in SI: a number as it is, or a text with a unit.  Raises ValueError for anything else."""
    if isinstance(mark, Unit) and type(value) is not float and _quantity_readers:
        return _quantity_readers[-1](value, mark)
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError("must be a number")
    if complaint := mark.complaint(value):  # type: ignore[arg-type]
        raise ValueError(complaint)
    return float(value)


def fields_in_si(record: Any, given: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a record (a class) by name, those of fields with a mark in SI: numbers, or texts with a unit.

    Raises ValueError for the first that cannot be, with its name.
    """
    values, kinds = dict(given), marks(record)
    for name in kinds.keys() & {name for name, value in given.items() if value is not None}:
        try:
            values[name] = in_si(given[name], kinds[name])
        except ValueError as error:
            raise ValueError(f"{name} = {repr(given[name])[:60]}: {error}") from error
    return values


def si_numbers(given: Any, unit: Unit, written: str = "") -> Any:
    """Numbers in SI: plain ones, in the unit that is written, or a quantity of pint, which has its own.

    given: a number, a text with its unit, an array or a sequence of them.  Raises ValueError for a unit that is not
    known or does not fit.
    """
    if isinstance(given, str):
        return in_si(given, replace(unit, signed=True))
    if isinstance(given, list | tuple):
        return [si_numbers(each, unit, written) for each in given]
    own = hasattr(given, "magnitude") and hasattr(given, "units")
    numbers, written = (given.magnitude, str(given.units)) if own else (given, written)
    if written in ("", unit.unit):
        return numbers
    one = in_si(written if written[0].isdigit() else f"1 {written}", replace(unit, signed=True))
    return numbers + (one - 1.0) if unit.unit == "K" else one * numbers  # degC has an offset


def explained(record: Record) -> Record:
    """A decorator that puts meaning, unit and default of each field into the docstring of a record."""
    lines = ["", "", "Parameters", "----------"]
    for name, field in fields_of(record).items():
        default = "" if field.usual in (MUST_BE_GIVEN, None, "") else f", default {field.usual!r}"
        lines += parameter_lines(name, field.meaning, field.mark, default)
    vars(record)["__init__"].__annotations__ = get_type_hints(record)  # a signature without the marks
    record.__doc__ = (record.__doc__ or "").rstrip() + "\n    ".join(lines) + "\n    "
    return record


def parameter_lines(name: str, meaning: Meaning, mark: Mark | None, default: str = "") -> tuple[str, ...]:
    """A parameter as numpydoc writes it: its name, unit and default, and its meaning."""
    kind = ""
    if isinstance(mark, Unit):
        kind = f"number ({mark.own}) or quantity ({mark.unit})" if mark.scale else f"quantity ({mark.unit})"
    elif isinstance(mark, Bounds):
        kind = "integer" if mark.whole else "number"
    heading = f"{kind}{default}".removeprefix(", ")
    text = wrap(f"{meaning.text[0].upper()}{meaning.text[1:]}.", 110)
    return f"{name} : {heading}" if heading else name, *(f"    {line}" for line in text)
