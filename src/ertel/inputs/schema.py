"""The layout of case files, generated from the records of the model: sections and keys with their types, by pydantic.

A quantity is a string with a unit ("10 mm"), a dimensionless number a plain number.  An amount may be either: a plain
number in the units of the case, a, a^2/R or t0, or a quantity.  The rules for valid input are in the model.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, fields
from functools import cache, partial
from typing import Annotated, Any, Literal, get_origin, get_type_hints

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag, create_model, model_validator
from pydantic_core import PydanticCustomError

from ertel.inputs.quantities import parse_amount, parse_number, parse_quantity
from ertel.model.conditions import Conditions
from ertel.model.records import OIL_LAWS, law_fields
from ertel.model.sections import STOPS, Drive, Output, Solver, Time
from ertel.model.thermal import Thermal
from ertel.physics.lubricant import Oil
from ertel.physics.motion import Oscillation
from ertel.physics.registry import DENSITY_LAWS, FLUIDITY_LAWS, SHAPES, VISCOSITY_LAWS, Registry
from ertel.physics.units import DURATION, FINITE, TIME, Bounds, Quantity, Unit, marks

NUMBER, POINTS, TABLE, NAME = "<number>", "<points>", "<table>", "<name>"  # tags, no part of a field's name
NAMED = {"Contact": ("material_1", "material_2"), "Lubricant": ("oil", "temperature")}  # see inputs.names
UNKNOWN_KEY = "unknown_key"  # the type of an error; its context: key, value and known keys
SIGNAL_TEXT = "a number, an array of [T, value], or a table { mean, amplitude, period, phase }"
SETTINGS = ConfigDict(strict=True, frozen=True, allow_inf_nan=False, arbitrary_types_allowed=True)


class Section(BaseModel):
    """A section of a case file; keys that are left out are None."""

    model_config = SETTINGS

    @model_validator(mode="before")
    @classmethod
    def _knows_its_keys(cls, data: object) -> object:
        """Unlike pydantic's own check, this one tells which keys there are."""
        known = keys_of(cls)
        for key, value in data.items() if isinstance(data, dict) else ():
            if key not in known:
                raise PydanticCustomError(UNKNOWN_KEY, "unknown key", {"key": str(key), "value": value, "known": known})
        return data


def section_of(record: Any, name: str = "", **special: Any) -> type[Section]:
    """The section that stands for a record; special: types of fields that are not read off the record's own."""
    hints, kinds = get_type_hints(record), marks(record)
    keys: dict[str, Any] = {}
    for item in fields(record):
        kind = special.get(item.name) or _type(hints[item.name], kinds.get(item.name))
        optional = item.default is not MISSING or item.default_factory is not MISSING
        keys[item.name] = (kind | None, None) if optional else (kind, ...)
    return create_model(name or record.__name__, __base__=Section, __doc__=record.__doc__, **keys)


def _type(hint: Any, mark: object) -> Any:
    """The type of a key, with what reads its value."""
    if isinstance(mark, Unit):
        read, kind = (parse_amount, float | Quantity) if mark.scale else (parse_quantity, float)
        return Annotated[kind | None, BeforeValidator(partial(read, unit=mark))]
    if isinstance(mark, Bounds):
        return Annotated[int if mark.whole else float, BeforeValidator(partial(parse_number, bounds=mark))]
    return Annotated[hint, Field(strict=False)] if get_origin(hint) is tuple else hint


# -- what is more than a number ---------------------------------------------------------------------------------------


def _one_of(*allowed: int) -> Any:
    """The type of one of some integers; a plain literal would take true for 1."""

    def read(value: object) -> object:
        if type(value) is int and value in allowed:
            return value
        raise ValueError(f"allowed: {' or '.join(map(str, allowed))}")

    return Annotated[int, BeforeValidator(read)]


def _event_or_time(value: object) -> object:
    if value in STOPS:
        return value
    try:
        return parse_amount(value, DURATION)
    except ValueError as error:
        names = ", ".join(f'"{event}"' for event in STOPS)
        raise ValueError(f'must be {names} or a time above zero, in units t0 or a quantity such as "5 ms"') from error


def _signal_form(value: object) -> str | None:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return NUMBER
    if isinstance(value, list | tuple):
        return POINTS
    return TABLE if isinstance(value, dict | Section) else None


Moment = Annotated[float | Quantity, BeforeValidator(partial(parse_amount, unit=TIME))]
Number = Annotated[float, BeforeValidator(partial(parse_number, bounds=FINITE))]
Point = Annotated[tuple[Moment, Number], Field(strict=False)]
OscillationTable = section_of(Oscillation)
Signal = Annotated[
    Annotated[Number, Tag(NUMBER)]
    | Annotated[tuple[Point, ...], Field(strict=False, min_length=1), Tag(POINTS)]
    | Annotated[OscillationTable, Tag(TABLE)],  # type: ignore[valid-type]
    Discriminator(_signal_form),
]
Until = Annotated[float | Quantity | str, BeforeValidator(_event_or_time)]


def _tag_of(key: str, records: Mapping[str, type]) -> Callable[[object], str | None]:
    """The tag that distinguishes the tables of a registry: the name under a key."""

    def tag(value: object) -> str | None:
        name = value.get(key) if isinstance(value, dict) else getattr(value, key, None)
        return f"<{name}>" if isinstance(name, str) and name in records else None

    return tag


def _tables(key: str, records: Mapping[str, type]) -> Iterator[Any]:
    """A table for every record of a registry, told apart by its name under a key."""
    for name, record in records.items():
        inside = {part: _inner_law() for part in law_fields(record)}
        own = create_model(name, __base__=section_of(record, **inside), **{key: (Literal[name], ...)})  # type: ignore[call-overload]
        if key == "shape":
            own = create_model(name, __base__=own, surface=(_one_of(1, 2), 1))
        yield Annotated[own, Tag(f"<{name}>")]


def _union(options: list[Any], discriminator: Any) -> Any:
    union = options[0]
    for option in options[1:]:
        union = union | option
    return Annotated[union, Discriminator(discriminator)]


def _law(laws: Registry) -> Any:
    """A law by its name, or a table with its name and data of its own."""

    table = _tag_of("law", laws)

    def form(value: object) -> str | None:
        return NAME if isinstance(value, str) else table(value)

    able = tuple(name for name, law in laws.items() if hasattr(law, "of"))
    return _union([Annotated[Literal[able], Tag(NAME)], *_tables("law", laws)], form)


def _inner_law() -> Any:
    """A law of shear thinning inside of another one: a table; there is no third one inside of it."""
    plain = {name: law for name, law in FLUIDITY_LAWS.items() if not law_fields(law)}
    return _union(list(_tables("law", plain)), _tag_of("law", plain))


# -- the whole file ---------------------------------------------------------------------------------------------------


def case_file() -> type[Section]:
    """The layout of a whole case file, with the laws and shapes that are registered now."""
    return _case_file(*(tuple(registry.items()) for registry in (VISCOSITY_LAWS, DENSITY_LAWS, FLUIDITY_LAWS, SHAPES)))


@cache
def _case_file(*registered: tuple[tuple[str, type], ...]) -> type[Section]:
    feature: Any = _union(list(_tables("shape", SHAPES)), _tag_of("shape", SHAPES))
    oil = section_of(Oil, "Lubricant", **{name: _law(registry) for name, registry in OIL_LAWS.items()})
    sections: dict[str, Any] = {
        "schema_version": (Annotated[_one_of(1), Field(alias="schema")], 1),
        "name": (str, ""),
        "contact": (section_of(Conditions, "Contact"), ...),
        "lubricant": (oil | None, None),
        "solver": (section_of(Solver) | None, None),
        "motion": (section_of(Drive, "Motion", load=Signal, entrainment=Signal) | None, None),
        "roughness": (Annotated[tuple[feature, ...], Field(strict=False)], ()),
        "time": (section_of(Time, until=Until) | None, None),
        "output": (section_of(Output) | None, None),
        "thermal": (section_of(Thermal) | None, None),
    }
    return create_model("CaseFile", __base__=Section, **sections)


def plain(value: object) -> Any:
    """What was read as plain data for `Case.from_data`: what is None or was left out is not there."""
    if isinstance(value, BaseModel):
        named = {field.alias or key: getattr(value, key) for key, field in type(value).model_fields.items()}
        return {key: plain(item) for key, item in named.items() if item is not None}
    return [plain(item) for item in value] if isinstance(value, tuple | list) else value


def keys_of(model: type[BaseModel]) -> list[str]:
    """The keys of a section, as they are written."""
    return [*NAMED.get(model.__name__, ()), *(field.alias or key for key, field in model.model_fields.items())]
