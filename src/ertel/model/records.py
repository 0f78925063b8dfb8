"""Records as plain data and back, checked field by field, and brought to the units of a case.

Plain data is what a case file holds: numbers, texts, lists, tables.  A quantity is a text in its SI unit, "0.01 m",
which reads back as the same float.  What a field is measured in stands in the mark of its annotation (`physics.units`).
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, Field, fields, is_dataclass, replace
from math import inf
from typing import Any, TypeVar

from ertel.physics.lubricant import Oil
from ertel.physics.motion import Oscillation, Polyline, Signal, constant
from ertel.physics.registry import DENSITY_LAWS, SHAPES, VISCOSITY_LAWS, Registry
from ertel.physics.scales import Scales
from ertel.physics.surfaces import Feature
from ertel.physics.units import TIME, Bounds, Quantity, Unit, marks

T = TypeVar("T")
Data = Mapping[str, Any]


# -- writing ----------------------------------------------------------------------------------------------------------


def data_of(record: Any) -> dict[str, Any]:
    """A record as plain data; what is None or infinite is left out.  Raises ValueError for what cannot be written."""
    kinds, found = marks(type(record)), {}
    for item in fields(record):
        value = getattr(record, item.name)
        if not _is_nothing(value):
            found[item.name] = _plain(value, kinds.get(item.name))
    return found


def _is_nothing(value: Any) -> bool:
    return value is None or (isinstance(value, float | str | tuple) and value in (inf, "", ()))


def _plain(value: Any, mark: object = None) -> Any:
    match value:
        case Quantity():
            return str(value)
        case float() | int() if isinstance(mark, Unit) and not mark.scale:
            return f"{float(value)!r} {mark.unit}"
        case bool() | int() | float() | str():
            return value
        case tuple():
            return [_plain(item) for item in value]
        case Polyline():
            (start, first), *rest = value.points
            return first if start == 0.0 and not rest else [[_plain(T), v] for T, v in value.points]
        case Oscillation():
            return data_of(value)
    raise ValueError(f"{value!r}: cannot be written down; allowed: numbers, texts, signals, and records with a name")


def law_data(law: object, laws: Registry) -> Any:
    """A law by its name where its data are those of the oil, else as a table."""
    return law if isinstance(law, str) else {"law": laws.name_of(law), **data_of(law)}


def oil_data(oil: Oil) -> dict[str, Any]:
    """An oil as plain data."""
    written = {"viscosity": law_data(oil.viscosity, VISCOSITY_LAWS), "density": law_data(oil.density, DENSITY_LAWS)}
    plain = data_of(replace(oil, viscosity="isoviscous", density="incompressible"))
    return {**plain, **written}


def feature_data(feature: Feature) -> dict[str, Any]:
    """A feature as plain data."""
    return {"shape": SHAPES.name_of(feature.shape), **data_of(feature.shape), "surface": feature.surface}


# -- reading ----------------------------------------------------------------------------------------------------------


def record_of(record: Callable[..., T], data: Data, place: str) -> T:
    """A record from plain data.  place: where it is, for messages.  Raises ValueError about the first thing wrong."""
    if not isinstance(data, Mapping):
        raise ValueError(f"{place} = {show(data)}: must be a table")
    known = {item.name: item for item in fields(record)}  # type: ignore[arg-type]
    for name in data:
        if name not in known:
            raise ValueError(f"{place}.{name} = {show(data[name])}: unknown key; allowed: {', '.join(known)}")
    for name, item in known.items():
        if name not in data and item.default is MISSING and item.default_factory is MISSING:
            raise ValueError(f"{place}.{name}: missing")
    kinds = marks(record)
    values = {name: _read(value, kinds.get(name), f"{place}.{name}") for name, value in data.items()}
    return named(place, record, **values)


def _read(value: Any, mark: object, place: str) -> Any:
    if isinstance(mark, Unit) and isinstance(value, str):
        number, _, unit = value.partition(" ")
        try:
            if unit == mark.unit:
                return Quantity(float(number), unit) if mark.scale else float(number)
        except ValueError:
            pass
        raise ValueError(f"{place} = {show(value)}: must be a number and the unit {mark.unit}")
    if isinstance(value, list):  # of a law with a table
        return tuple(_read(item, None, place) for item in value)
    whole = isinstance(mark, Bounds) and mark.whole
    if mark is not None and not whole and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    return value


def signal_of(data: Any, place: str) -> Signal:
    """A signal from a number, a list of [T, value], or a table { mean, amplitude, period, phase }."""
    if isinstance(data, Mapping):
        return record_of(Oscillation, data, place)
    if isinstance(data, int | float):
        return constant(float(data))
    points = [(_read(T, TIME, place), float(value)) for T, value in data]
    return named(place, Polyline, tuple(points), text=show(data))


def law_of(data: Any, laws: Registry, place: str) -> Any:
    """A law: a name, or a record from a table with its name under `law`."""
    if not isinstance(data, Mapping):
        return data
    name = data.get("law")
    if name not in laws:
        raise ValueError(f"{place}.law = {show(name)}: allowed: {', '.join(laws)}")
    record: Any = laws[str(name)]
    return checked(record_of(record, {k: v for k, v in data.items() if k != "law"}, place), place)


def oil_of(data: Data, place: str) -> Oil:
    """An oil from plain data."""
    laws = {"viscosity": VISCOSITY_LAWS, "density": DENSITY_LAWS}
    read = {k: law_of(v, laws[k], f"{place}.{k}") if k in laws else v for k, v in data.items()}
    return record_of(Oil, read, place)


def feature_of(data: Data, place: str) -> Feature:
    """A feature from plain data, its shape by a registered name."""
    name, surface = data.get("shape"), data.get("surface", 1)
    if name not in SHAPES:
        said = "missing" if name is None else f"= {show(name)}"
        raise ValueError(f"{place}.shape{' ' if name else ': '}{said}; allowed: {', '.join(SHAPES)}")
    if surface not in (1, 2):
        raise ValueError(f"{place}.surface = {show(surface)}: allowed: 1 or 2")
    shape: Any = SHAPES[str(name)]
    return Feature(record_of(shape, {k: v for k, v in data.items() if k not in ("shape", "surface")}, place), surface)


# -- checking ---------------------------------------------------------------------------------------------------------


def checked(record: T, place: str) -> T:
    """The record again.  Raises ValueError where a field has a value that its mark does not allow."""
    kinds = marks(type(record))
    for item in fields(record):  # type: ignore[arg-type]
        value, mark = getattr(record, item.name), kinds.get(item.name)
        if value is not None and value != _default(item) and mark is not None:
            _check(value, mark, f"{place}.{item.name}")
    return record


def _default(item: "Field[Any]") -> Any:
    return None if item.default is MISSING else item.default


def _check(value: Any, mark: Unit | Bounds, place: str) -> None:
    number = value.value if isinstance(value, Quantity) else value
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise ValueError(f"{place} = {show(value)}: must be a number")
    if isinstance(mark, Bounds):
        complaint = mark.complaint(number)
        if complaint:
            raise ValueError(f"{place} = {show(value)}: {complaint}")
    elif not mark.allows(number):
        shown = show(value) if mark.scale else show(f"{number!r} {mark.unit}")
        raise ValueError(f"{place} = {shown}: must be {'finite' if mark.signed else 'finite and above zero'}")


def named(place: str, function: Callable[..., T], *arguments: Any, text: str = "", **keywords: Any) -> T:
    """function(...), its complaint about an argument as one about a field of the place."""
    try:
        return function(*arguments, **keywords)
    except (ValueError, ArithmeticError) as error:
        message = str(error)
        if text:
            raise ValueError(f"{place} = {text}: {message.partition(': ')[2] or message}") from error
        raise ValueError(message if message.startswith(f"{place}.") else f"{place}.{message}") from error


def show(value: object) -> str:
    """A value as one would write it in a case file."""
    if isinstance(value, Quantity):
        return show(str(value))
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {show(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(show(item) for item in value) + "]"
    if isinstance(value, Polyline | Oscillation):
        return show(_plain(value))
    return json.dumps(value, default=str, ensure_ascii=False).replace("\x7f", "\\u007f")


# -- units of the case ------------------------------------------------------------------------------------------------


def scaled(record: T, scales: Scales | None, place: str) -> T:
    """The record with every Quantity as a number in the units of the case.

    Raises ValueError where the case is dimensionless (scales is None) and has no such units.
    """
    if isinstance(record, Polyline):
        points = tuple((_over(T, TIME, scales, f"{place}[{i}]"), v) for i, (T, v) in enumerate(record.points, 1))
        return named(place, Polyline, points, text=show(record))  # type: ignore[return-value]
    kinds = marks(type(record))
    changed: dict[str, Any] = {}
    for item in fields(record):  # type: ignore[arg-type]
        value, where = getattr(record, item.name), f"{place}.{item.name}"
        if isinstance(value, Quantity):
            changed[item.name] = _over(value, kinds[item.name], scales, where)
        elif is_dataclass(value) and not isinstance(value, type):
            changed[item.name] = scaled(value, scales, where if item.name != "shape" else place)
    return replace(record, **changed) if changed else record  # type: ignore[type-var]


def _over(amount: Any, mark: object, scales: Scales | None, place: str) -> float:
    if not isinstance(amount, Quantity):
        return float(amount)
    if scales is None:
        raise ValueError(f"{place} = {show(amount)}: must be a plain number: a dimensionless case has no {amount.unit}")
    assert isinstance(mark, Unit)
    return amount.value / float(getattr(scales, mark.scale))


def scaled_all(records: Sequence[T], scales: Scales | None, place: str) -> tuple[T, ...]:
    """Each record in the units of the case; place: of the list, whose items are counted from one."""
    return tuple(scaled(record, scales, f"{place}[{number}]") for number, record in enumerate(records, 1))
