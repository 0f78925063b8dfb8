"""The layout of case files, generated from the records of the model: sections and keys with their types, by pydantic.

A quantity is a string with a unit ("10 mm"), a dimensionless number a plain number.  An amount may be either: a plain
number in the units of the case, a, a^2/R or t0, or a quantity.  The rules for valid input are in the model, the
meanings of the keys at the fields of the records.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, fields
from functools import cache, partial
from inspect import getdoc
from typing import Annotated, Any, Literal, NamedTuple, get_origin, get_type_hints

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    WithJsonSchema,
    create_model,
    model_validator,
)
from pydantic_core import PydanticCustomError

from ertel.case.conditions import Conditions
from ertel.case.height_map import HeightMap
from ertel.case.records import OIL_LAWS, law_fields
from ertel.case.sections import STOPS, Drive, Output, Solver, Time
from ertel.case.thermal import Thermal
from ertel.inputs.named import DataSheet, Materials, MeasuredFile, NamedLubricant
from ertel.inputs.quantities import parse_amount, parse_number, parse_quantity
from ertel.inputs.spellings import amount_schema, number_schema, quantity_schema
from ertel.physics.lubricant import Oil
from ertel.physics.motion import Oscillation
from ertel.physics.registry import DENSITY_LAWS, FLUIDITY_LAWS, SHAPES, VISCOSITY_LAWS, Registry
from ertel.physics.units import DURATION, FINITE, TIME, Bounds, Meaning, Quantity, Unit, marks, meanings

NUMBER, POINTS, TABLE, NAME = "<number>", "<points>", "<table>", "<name>"  # tags, no part of a field's name
UNKNOWN_KEY = "unknown_key"  # the type of an error; its context: key, value and known keys
SIGNAL_TEXT = "a number, an array of [T, value], or a table { mean, amplitude, period, phase }"
SETTINGS = ConfigDict(
    strict=True,
    frozen=True,
    allow_inf_nan=False,
    arbitrary_types_allowed=True,
    json_schema_extra={"additionalProperties": False},
)


class Part(NamedTuple):
    """A section: its record, what it is about, and a record of further keys that name something in the library."""

    record: Any
    text: str
    named: Any = None


SECTIONS: Mapping[str, Part] = {
    "contact": Part(Conditions, "the two bodies and their operating conditions", Materials),
    "lubricant": Part(Oil, "the oil: its name, or its data", NamedLubricant),
    "solver": Part(Solver, "grid and tolerance"),
    "motion": Part(Drive, "load and speed as functions of time"),
    "time": Part(Time, "start, end and steps of a run in time"),
    "output": Part(Output, "which maps are kept, besides those at maximum approach and at the end"),
    "thermal": Part(Thermal, "rolling: temperatures of a steady contact in SI, may be empty where all is named"),
}
TOP: Mapping[str, Meaning] = {  # keys of the file itself
    "schema": Meaning("version of this layout"),
    "name": Meaning("of the run's directory and titles; left out: that of the file", "steel_ball"),
    "roughness": Meaning("shapes on the surfaces, any number of them; their heights are added"),
}
FILES = {"measured": MeasuredFile}  # records of further keys of shapes, that say how their file is read
SURFACE = Meaning("surface on which the shape is and with which it moves")


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


def section_of(record: Any, name: str = "", base: type[Section] = Section, /, **special: Any) -> type[Section]:
    """The section that stands for a record.

    base: a section whose keys it has too.  special: types of fields that are not read off the record's own.
    """
    hints, kinds, said = get_type_hints(record), marks(record), meanings(record)
    keys: dict[str, Any] = {}
    for item in fields(record):
        kind = special.get(item.name) or _type(hints[item.name], kinds.get(item.name))
        optional = item.default is not MISSING or item.default_factory is not MISSING
        known = _explained(said.get(item.name))
        keys[item.name] = (kind | None, Field(None, **known)) if optional else (kind, Field(**known))
    return create_model(name or record.__name__, __base__=base, __doc__=first_paragraph(record), **keys)


def _explained(meaning: Meaning | None) -> dict[str, Any]:
    """What the schema says of a key."""
    if meaning is None:
        return {}
    example = {} if meaning.example is None else {"examples": [meaning.example]}
    return {"description": meaning.text, **example}


def first_paragraph(record: Any) -> str:
    """What the docstring of a record says at first, on one line."""
    return " ".join((getdoc(record) or "").partition("\n\n")[0].split())


def _type(hint: Any, mark: object) -> Any:
    """The type of a key, with what reads its value."""
    if isinstance(mark, Unit):
        read, kind, told = (
            (parse_amount, float | Quantity, amount_schema) if mark.scale else (parse_quantity, float, quantity_schema)
        )
        return Annotated[kind | None, BeforeValidator(partial(read, unit=mark)), WithJsonSchema(told(mark))]
    if isinstance(mark, Bounds):
        number: Any = int if mark.whole else float
        reader = BeforeValidator(partial(parse_number, bounds=mark))
        return Annotated[number, reader, WithJsonSchema(number_schema(mark))]
    if hint is HeightMap:
        return str
    return Annotated[hint, Field(strict=False)] if get_origin(hint) is tuple else hint


# -- what is more than a number ---------------------------------------------------------------------------------------


def _one_of(*allowed: int) -> Any:
    """The type of one of some integers; a plain literal would take true for 1."""

    def read(value: object) -> object:
        if type(value) is int and value in allowed:
            return value
        raise ValueError(f"allowed: {' or '.join(map(str, allowed))}")

    return Annotated[int, BeforeValidator(read), WithJsonSchema({"enum": list(allowed)})]


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


Moment = Annotated[
    float | Quantity, BeforeValidator(partial(parse_amount, unit=TIME)), WithJsonSchema(amount_schema(TIME))
]
Number = Annotated[float, BeforeValidator(partial(parse_number, bounds=FINITE)), WithJsonSchema(number_schema(FINITE))]
Point = Annotated[tuple[Moment, Number], Field(strict=False)]
OscillationTable = section_of(Oscillation)
Signal = Annotated[
    Annotated[Number, Tag(NUMBER)]
    | Annotated[tuple[Point, ...], Field(strict=False, min_length=1), Tag(POINTS)]
    | Annotated[OscillationTable, Tag(TABLE)],  # type: ignore[valid-type]
    Discriminator(_signal_form),
]
Until = Annotated[
    float | Quantity | str,
    BeforeValidator(_event_or_time),
    WithJsonSchema({"anyOf": [{"enum": list(STOPS)}, *amount_schema(DURATION)["anyOf"]]}),
]


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
        told = first_paragraph(record)
        named = {key: (Literal[name], ...)}
        base = section_of(FILES[name]) if key == "shape" and name in FILES else Section
        section = section_of(record, "", base, **inside)
        own = create_model(name, __base__=section, __doc__=told, **named)  # type: ignore[call-overload]
        if key == "shape":
            surface = (_one_of(1, 2), Field(1, **_explained(SURFACE)))
            own = create_model(name, __base__=own, __doc__=told, surface=surface)
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
    named = {"NamedLubricant": {"oil": str | section_of(DataSheet)}}
    special: Mapping[str, dict[str, Any]] = {
        "lubricant": {name: _law(registry) for name, registry in OIL_LAWS.items()},
        "motion": {"load": Signal, "entrainment": Signal},
        "time": {"until": Until},
    }
    found: dict[str, Any] = {
        "schema_version": (_one_of(1), Field(1, alias="schema", **_explained(TOP["schema"]))),
        "name": (str, Field("", **_explained(TOP["name"]))),
    }
    for name, part in SECTIONS.items():
        base = section_of(part.named, **named.get(part.named.__name__, {})) if part.named else Section
        kind = section_of(part.record, name.capitalize(), base, **special.get(name, {}))
        needed = name == "contact"
        found[name] = (kind if needed else kind | None, Field(... if needed else None, description=part.text))
    found["roughness"] = (tuple[feature, ...], Field((), strict=False, **_explained(TOP["roughness"])))
    return create_model("CaseFile", __base__=Section, __doc__="A case of ertel.", **found)


def plain(value: object) -> Any:
    """What was read as plain data for `Case.from_data`: what is None or was left out is not there."""
    if isinstance(value, BaseModel):
        named = {field.alias or key: getattr(value, key) for key, field in type(value).model_fields.items()}
        return {key: plain(item) for key, item in named.items() if item is not None}
    return [plain(item) for item in value] if isinstance(value, tuple | list) else value


def keys_of(model: type[BaseModel]) -> list[str]:
    """The keys of a section, as they are written."""
    return [field.alias or key for key, field in model.model_fields.items()]
