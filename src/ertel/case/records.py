"""Records: written as plain data, checked, converted to the units of a case, and shown in messages.

Plain data is the content of a case file: numbers, strings, lists, tables.  A quantity is a string with its SI unit,
"0.01 m", which reads back as the same float.  The unit of a field is in the mark of its annotation (`physics.units`).
"""

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, is_dataclass, replace
from math import inf, log10
from typing import Any, TypeVar

import numpy as np

import ertel.physics.laws  # noqa: F401 - which have their names from here on
from ertel.case.height_map import HeightMap
from ertel.physics.fluidity import Fluidity
from ertel.physics.lubricant import Oil
from ertel.physics.motion import Oscillation, Polyline, Smooth
from ertel.physics.registry import ASPERITY_LAWS, FLUIDITY_LAWS, OIL_LAWS, SHAPES, Registry
from ertel.physics.scales import Scales
from ertel.physics.surfaces import Feature
from ertel.physics.units import LARGEST, Bounds, Mark, Quantity, Unit, fields_of

T = TypeVar("T")


def points_in(options: Iterable[Any]) -> type[Polyline] | None:
    """The kind of points that is among the kinds of values of an annotation."""
    return next((kind for kind in options if isinstance(kind, type) and issubclass(kind, Polyline)), None)


# -- writing ----------------------------------------------------------------------------------------------------------


def data_of(record: Any) -> dict[str, Any]:
    """A record as plain data; what is None or infinite is left out.  Raises ValueError for what cannot be written."""
    data = {}
    for name, field in fields_of(record).items():
        value = getattr(record, name)
        if value is not None and not (isinstance(value, float | str | tuple) and value in (inf, "", ())):
            data[name] = _plain(value, field.mark)
    return data


def _plain(value: Any, mark: object = None) -> Any:
    match value:
        case Quantity():
            return str(value)
        case bool() | int() | float() | str():
            return with_unit(value, mark)
        case tuple() | list():
            return [_plain(item) for item in value]
        case Smooth():
            return {"smooth": [_plain(point) for point in value.points]}
        case Polyline():
            (start, first), *rest = value.points
            return _plain(first) if start == 0.0 and not rest else [_plain(point) for point in value.points]
        case Oscillation():
            return data_of(value)
        case HeightMap():
            return value.name
        case _ if hasattr(value, "fluidity"):  # a law inside of another one
            return law_data(value, FLUIDITY_LAWS)
        case _ if hasattr(value, "curve"):
            return law_data(value, ASPERITY_LAWS)
    raise ValueError(f"{show(value)}: cannot be written down; allowed: numbers, texts, signals, records with a name")


def law_fields(record: Any) -> tuple[str, ...]:
    """The fields of a law (a class) that are laws of shear thinning themselves."""
    return tuple(name for name, field in fields_of(record).items() if field.hint is Fluidity)


def law_data(law: object, laws: Registry) -> Any:
    """A law as its name if its data are those of the oil, otherwise as a table."""
    return law if isinstance(law, str) else {"law": laws.name_of(law), **data_of(law)}


def inner_laws(laws: Registry) -> dict[str, Any]:
    """The laws that may stand inside of another one, by their names."""
    return {name: law for name, law in laws.items() if not law_fields(law)}


def oil_data(oil: Oil) -> dict[str, Any]:
    """An oil as plain data."""
    written = {name: law_data(getattr(oil, name), laws) for name, laws in OIL_LAWS.items()}
    plain = data_of(replace(oil, viscosity="isoviscous", density="incompressible", rheology="newtonian"))
    return {**plain, **written}


def feature_data(feature: Feature) -> dict[str, Any]:
    """A feature as plain data."""
    return {"shape": SHAPES.name_of(feature.shape), **data_of(feature.shape), "surface": feature.surface}


# -- NumPy's numbers --------------------------------------------------------------------------------------------------


def with_own_numbers(value: Any) -> Any:
    """A record, or what stands in one, with plain numbers for NumPy's scalars, and pint's in SI."""
    if value is None or type(value) in (float, int, str):  # most of what stands in one
        return value
    if isinstance(value, np.generic):
        return value.item()
    if hasattr(value, "to_base_units"):  # of pint
        base = value.to_base_units()
        return Quantity(float(base.magnitude), {"meter": "m", "second": "s"}.get(str(base.units), str(base.units)))
    if type(value) is tuple:
        items = tuple(with_own_numbers(item) for item in value)
        return items if any(new is not old for new, old in zip(items, value, strict=True)) else value
    if not is_dataclass(value) or isinstance(value, type):
        return value
    old = {item.name: getattr(value, item.name) for item in fields(value)}
    changed = {name: new for name, part in old.items() if (new := with_own_numbers(part)) is not part}
    return replace(value, **changed) if changed else value


# -- checking ---------------------------------------------------------------------------------------------------------


def checked(record: T, place: str) -> T:
    """The same record.  Raises ValueError if a field, also of a record in it, has a value that is not allowed."""
    if isinstance(record, Polyline):
        with refusing(place, record):
            for point in record.points:
                for number, of_number in zip(point, record.MARKS, strict=True):
                    check_value(number, of_number)
    for name, field in fields_of(record).items():
        value, mark, choices = getattr(record, name), field.mark, field.choices
        if isinstance(value, Polyline | Oscillation) or (is_dataclass(value) and mark is None):
            checked(value, f"{place}.{name}")
            continue
        is_default = type(value) is type(field.usual) and bool(value == field.usual)  # which may be infinite
        if value is None or is_default or (isinstance(value, str) and value in choices):
            continue
        with refusing(f"{place}.{name}", with_unit(value, mark)):
            check_value(value, mark, choices)
    return record


def check_value(value: Any, mark: Mark | None, choices: Sequence[str] = ()) -> None:
    """Raise ValueError unless a value, a number or for an amount also a quantity in SI, is one that its mark allows.

    choices: what is allowed too, or instead if there is no mark.
    """
    if mark is not None and (complaint := _complaint(value, mark)):
        raise ValueError(f"{complaint}{''.join(f', or {show(choice)}' for choice in choices)}")
    if mark is None and choices:
        raise ValueError(f"allowed: {alternatives(map(repr, choices))}")


def _complaint(value: Any, mark: Mark) -> str:
    number = with_own_numbers(value)
    if isinstance(mark, Unit) and mark.scale:
        if isinstance(value, Quantity) and value.unit == mark.unit:
            number, mark = with_own_numbers(value.value), mark.in_si
        elif not is_number(number) or not mark.allows(number):
            least = "" if mark.signed else " above zero"
            return f'must be a finite number{least}, in units {mark.own}, or a quantity such as "{mark.example}"'
    if not is_number(number):
        return "must be an integer" if isinstance(mark, Bounds) and mark.whole else "must be a number"
    return mark.complaint(number)


def is_number(value: object) -> bool:
    """Whether a value is one of Python's numbers; booleans do not count."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def with_unit(value: Any, mark: object) -> Any:
    """A number as a quantity in the SI unit of its field, "0.01 m"; an amount and anything else as it is."""
    number = with_own_numbers(value)
    if not isinstance(mark, Unit) or mark.scale or not is_number(number):
        return value
    text = repr(float(number)) if isinstance(number, float) or abs(number) <= LARGEST else show(number)
    return f"{text} {mark.unit}"


def named(place: str, function: Callable[..., T], *arguments: Any, **keywords: Any) -> T:
    """The result of function(...); a ValueError about an argument is raised again with the field's place."""
    try:
        return function(*arguments, **keywords)
    except ArithmeticError as error:
        raise ConfigError(f"{place}: has numbers too large or too small to compute with; check their units") from error
    except ValueError as error:
        message = str(error)
        is_complete = message.startswith((f"{place}.", f"{place}:"))
        raise ConfigError(message if is_complete else f"{place}.{message}") from error


@contextmanager
def refusing(place: str, value: Any) -> Iterator[None]:
    """A complaint about a value is raised again with its place and the value; a `ConfigError` names them already."""
    try:
        yield
    except ConfigError:
        raise
    except ValueError as error:
        raise ConfigError(f"{place} = {show(value)}: {error}") from error


# -- showing, in messages ---------------------------------------------------------------------------------------------


class ConfigError(ValueError):
    """The input is wrong: the message, one line, names the field, its value and what is allowed."""

    def __init__(self, message: str):
        super().__init__(printable(message))


SHOWN = 100  # characters of a value in a message
BARE_KEY = re.compile(r"[\w-]{1,40}")


def show(value: object) -> str:
    """A value as it is written in a case file, for messages: printable, and cut after 100 characters."""
    text = _shown(value, SHOWN)
    return text if len(text) <= SHOWN else text[: SHOWN - 4] + " ..."


def _shown(value: object, room: int) -> str:
    """The value as text, of which only the first `room` characters matter; no more is built than that needs."""
    if isinstance(value, Polyline | Oscillation):
        return _shown(_plain(value), room)
    if isinstance(value, Mapping):
        items = (f"{show_key(key)} = {_shown(item, room - 2)}" for key, item in value.items())
        return "{ " + _joined(items, room) + " }" if room > 0 else "..."
    if isinstance(value, list | tuple):
        return "[" + _joined((_shown(item, room - 1) for item in value), room) + "]" if room > 0 else "..."
    if isinstance(value, int) and value.bit_length() > 4 * SHOWN:
        return f"(an integer of about {int(value.bit_length() * log10(2))} digits)"
    part = value[:room] if isinstance(value, str | bytes) else str(value) if isinstance(value, Quantity) else value
    return printable(json.dumps(part, default=str, ensure_ascii=False))


def alternatives(texts: Iterable[str]) -> str:
    """Some texts as alternatives: a, b or c."""
    *others, last = texts
    return f"{', '.join(others)} or {last}" if others else last


def shortened(text: str) -> str:
    """A text of any origin for a message: its beginning and its end."""
    return printable(text if len(text) <= SHOWN else f"{text[: SHOWN // 2]} ... {text[-SHOWN // 2 :]}")


def field_name(place: Sequence[str | int]) -> str:
    """section.key, an element of an array by its number from 1: roughness[1].amplitude."""
    parts = (f"[{part + 1}]" if isinstance(part, int) else f".{show_key(part)}" for part in place)
    return "".join(parts).removeprefix(".")


def show_key(key: object) -> str:
    """A key as in TOML: quoted unless it is short and consists of letters, digits, - and _."""
    return key if isinstance(key, str) and BARE_KEY.fullmatch(key) else show(str(key))


def _joined(items: Iterable[str], room: int) -> str:
    parts: list[str] = []
    for item in items:
        parts.append(item)
        room -= len(item) + 2
        if room < 0:
            break
    return ", ".join(parts)


def printable(text: str) -> str:
    """The text with all invisible characters escaped, so that no message can steer a terminal."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


# -- a whole case, in a few lines -------------------------------------------------------------------------------------

NUMBER = re.compile(r"[-+]?\d+\.?\d*(e[-+]?\d+)?(?= |$)")
LISTED = 4  # items at most, of a longer list their number
LEFT_OUT = ("schema", "name", "reference")


def described(data: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The sections of a case in plain data, each with its content in one line."""
    for name, section in data.items():
        for one in section if isinstance(section, list) else [section]:
            if name not in LEFT_OUT:
                yield name, _pairs(one) if isinstance(one, Mapping) else one


def _pairs(data: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} = {_short(value)}" for key, value in data.items() if key not in LEFT_OUT)


def _short(value: Any) -> str:
    """A value for reading: numbers, also those before a unit, with four digits."""
    if isinstance(value, Mapping):
        return f"{{ {_pairs(value)} }}"
    if isinstance(value, list):
        return f"({len(value)} points)" if len(value) > LISTED else f"[{', '.join(map(_short, value))}]"
    return NUMBER.sub(lambda match: f"{float(match[0]):.4g}", str(value))


# -- units of the case ------------------------------------------------------------------------------------------------


def scaled(record: T, scales: Scales | None, place: str) -> T:
    """The record with every Quantity as a number in the units of the case.

    Raises ValueError if the case is dimensionless (scales is None).
    """
    if isinstance(record, Polyline):
        points: list[Any] = []
        for number, point in enumerate(record.points, 1):
            marked = zip(point, record.MARKS, strict=True)
            points.append(tuple(_over(value, mark, scales, f"{place}[{number}]") for value, mark in marked))
        with refusing(place, record):
            return type(record)(tuple(points))
    changed: dict[str, Any] = {}
    for name, field in fields_of(record).items():
        value, where = getattr(record, name), f"{place}.{name}"
        if isinstance(value, Quantity):
            changed[name] = _over(value, field.mark, scales, where)
        elif is_dataclass(value) and not isinstance(value, type):
            changed[name] = scaled(value, scales, where if name != "shape" else place)
    return named(place, replace, record, **changed) if changed else record


def _over(amount: Any, mark: object, scales: Scales | None, place: str) -> float:
    if not isinstance(amount, Quantity):
        return float(amount)
    with refusing(place, amount):
        if scales is None:
            raise ValueError(f"must be a plain number: a dimensionless case has no {amount.unit}")
        assert isinstance(mark, Unit)
        number: float = amount.value / getattr(scales, mark.scale)
        if complaint := mark.complaint(number):
            raise ValueError(f"is {number:g} {mark.own} in this contact; {complaint}")
    return number


def amounts(record: Any, place: str) -> Iterator[tuple[str, Unit, Any]]:
    """The amounts of a record, and of records in it: place, unit and value of each."""
    parts = [(f"{place}.{name}", field.mark, getattr(record, name)) for name, field in fields_of(record).items()]
    if isinstance(record, Polyline):
        numbered = enumerate(record.points, 1)
        parts = [(f"{place}[{n}]", *part) for n, point in numbered for part in zip(record.MARKS, point, strict=True)]
    for where, mark, value in parts:
        if isinstance(value, Polyline | Oscillation):
            yield from amounts(value, where)
        elif isinstance(mark, Unit) and mark.scale and value is not None:
            yield where, mark, value


def scaled_all(records: Sequence[T], scales: Scales | None, place: str) -> tuple[T, ...]:
    """Each record in the units of the case.  place: name of the list; its items are counted from one."""
    return tuple(scaled(record, scales, f"{place}[{number}]") for number, record in enumerate(records, 1))
