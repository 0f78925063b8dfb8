"""Texts made of the layout: new case files that explain all keys, and their JSON schema."""

import json
from collections.abc import Iterator, Mapping
from textwrap import wrap
from typing import Any

from ertel.case.conditions import FOREIGN, Kind
from ertel.case.methods import NEW, Method, of_kind
from ertel.case.records import inner_laws, points_in, show
from ertel.case.sections import SECTIONS
from ertel.inputs import layout
from ertel.inputs.layout import Key, Place
from ertel.inputs.names import OF_OILS
from ertel.inputs.quantities import LONGEST
from ertel.physics.geometry import geometry
from ertel.physics.motion import Oscillation, Polyline, Signal, Smooth, Track
from ertel.physics.registry import SHAPES, Registry
from ertel.physics.units import FINITE, Bounds, Mark

SCHEMA_FILE = "ertel.schema.json"
WIDTH, MEANING_FROM = 120, 36  # columns
STEEL = {"E1": "210 GPa", "nu1": 0.3, "E2": "210 GPa", "nu2": 0.3}
OIL = {"eta0": "20 mPa*s", "alpha": "20 / GPa"}
GIVEN: Mapping[Kind, Mapping[str, Mapping[str, Any]]] = {  # what a new case file gives, besides its [solver]
    "impact": {
        "[contact]": {"kind": "impact", "radius": "10 mm", "ball_density": "7850 kg/m^3", "speed": "0.1 m/s", **STEEL},
        "[lubricant]": OIL,
        "[time]": {"until": "max-approach"},
    },
    "rolling": {
        "[contact]": {"kind": "rolling", "radius": "10 mm", "load": "40 N", "mean_speed": "0.5 m/s", **STEEL},
        "[lubricant]": OIL,
    },
}
LINE: Mapping[Kind, Mapping[str, Any]] = {  # in the place of these, for a line contact
    "impact": {"length": "10 mm", "mass": "3 kg", "ball_density": None, "speed": "0.3 m/s"},
    "rolling": {"length": "10 mm", "load": "2 kN"},
}
ABOUT: Mapping[Kind, str] = {"impact": "A ball hits an oiled surface.", "rolling": "A ball rolls on an oiled surface."}
SHAPE = "spot"


def about(kind: Kind, line: bool = False) -> str:
    """A new case in a sentence."""
    return ABOUT[kind].replace("ball", "roller") if line else ABOUT[kind]


def template(kind: Kind, name: str, line: bool = False) -> str:
    """A new case file.  kind: "impact" or "rolling".  name: of the file, for the comments at its head.

    line: for a line contact.
    """
    method = of_kind(kind)[0].of(geometry(0.0)) if line else NEW[kind]
    contact = {**GIVEN[kind]["[contact]"], **(LINE[kind] if line else {})}
    lines = [
        f"#:schema ./{SCHEMA_FILE}",
        f"# {about(kind, line)}",
        "#",
        f"#   ertel check {name}        what follows from it, without running it",
        f"#   ertel run {name}",
        "#",
        "# Keys in comments are optional; some exclude others, see ertel check. Quantities have a unit, any",
        "# that you like; amounts without one are in the units of the case: lengths a, heights a^2/R, times t0.",
    ]
    solver = {"method": method.name, "nodes": method.new_nodes}
    given = {**GIVEN[kind], "[contact]": contact, "[solver]": solver}
    for place in layout.places():
        is_told = place.title.startswith("[") or place.title == f'shape = "{SHAPE}"'
        if is_told and not _is_of_other(place.text, kind):
            lines += _section(place, given, method)
    return "\n".join(lines) + "\n"


def _section(place: Place, given: Mapping[str, Mapping[str, Any]], method: Method) -> Iterator[str]:
    """The lines of a section; one of which nothing is given is a comment as a whole."""
    values, kind = given.get(place.title, {}), method.kind
    mark = "" if values else "# "
    if place.title.startswith("["):
        yield ""
        yield from _line(f"{mark}{place.title}", place.text)
    foreign = FOREIGN[kind] if place.title == "[contact]" else layout.field_names(layout.Machines)  # they are sections
    ours = [key for key in place.keys if key.name not in foreign and not _is_of_other(key.meaning.text, kind)]
    for key in sorted(ours, key=lambda key: values.get(key.name) is None):
        yield from _line(_written(key, values, _examples(place.title, method)), key.meaning.text)


def _is_of_other(meaning: str, kind: Kind) -> bool:
    """Whether a meaning says that a key or a section is for the other kind of contact only."""
    other = "rolling" if kind == "impact" else "impact"
    return meaning.startswith(f"{other}:")


def _written(key: Key, values: Mapping[str, Any], examples: Mapping[str, str]) -> str:
    if values.get(key.name) is not None:
        return f"{key.name} = {show(values[key.name])}"
    return f"# {key.name} = {examples.get(key.name) or key.example or show(SHAPE)}"


def _examples(title: str, method: Method) -> Mapping[str, str]:
    """Examples that depend on the kind of contact: the defaults of its method, and its end."""
    if title == "[solver]":
        return {name: show(value) for name, value in vars(method.defaults).items() if value is not None}
    return {"until": show(next(each.end for each in of_kind(method.kind) if each.end))} if title == "[time]" else {}


def _line(text: str, meaning: str) -> Iterator[str]:
    """A line with its meaning behind it, or above where that is too long."""
    whole = f"{text:{MEANING_FROM}} # {meaning}"
    if len(whole) <= WIDTH:
        yield whole
    else:
        yield from (f"# {part}" for part in wrap(meaning, WIDTH - 2))
        yield text


# -- the JSON schema --------------------------------------------------------------------------------------------------
#
# For editors and checkers: keys, kinds of values, meanings, examples.  It takes every file that ertel takes.  It cannot
# tell which units fit, nor which keys belong together: that is in the rules of the case, and `ertel check` says it.

Schema = dict[str, Any]
DIALECT = "https://json-schema.org/draft/2020-12/schema"


def json_schema() -> Schema:
    """The JSON schema of a case file, with the laws and shapes that are registered now."""
    top, *_ = layout.places()
    tables = {name: _table_schema(layout.section(name)) for name in SECTIONS}
    shapes = [_table_schema(layout.shape_place(name), *layout.shape_keys()[1:], shape=name) for name in SHAPES]
    roughness = {"type": "array", "items": {"oneOf": shapes}, "description": layout.TOP["roughness"].text}
    properties = {key.name: _explained(key) for key in top.keys} | tables | {"roughness": roughness}
    whole = {"$schema": DIALECT, "title": "Case file of ertel", "type": "object", "description": "A case of ertel."}
    return {**whole, "properties": properties, "additionalProperties": False, "required": ["contact"]}


def json_schema_text() -> str:
    """The JSON schema as a text in ASCII."""
    return json.dumps(json_schema(), indent=2) + "\n"


def _table_schema(place: Place, *more: Key, **name: str) -> Schema:
    """The schema of a table, which has no other keys.  name: of its law or shape, by its key."""
    keys = (*place.keys, *more)
    properties = {key: {"const": value} for key, value in name.items()} | {key.name: _explained(key) for key in keys}
    schema = {"type": "object", "description": place.text, "properties": properties, "additionalProperties": False}
    required = [*name, *(key.name for key in keys if key.default == layout.NEEDED)]
    return {**schema, "required": required} if required else schema


def _record_schema(record: Any, **name: str) -> Schema:
    return _table_schema(Place("", layout.first_paragraph(record), layout.keys_of(record)), **name)


def _explained(key: Key) -> Schema:
    """The schema of a key with its meaning."""
    example = {} if key.meaning.example is None else {"examples": [key.meaning.example]}
    return {**_value_schema(key), "description": key.meaning.text, **example}


def _value_schema(key: Key) -> Schema:
    """The schema of the value of a key."""
    if Track in key.options and key.mark is not None:
        return {"anyOf": [_marked_schema(key.mark), _points_schema(Track)]}
    if Signal in key.options:
        points = {"smooth": {**_points_schema(Smooth), "description": "points of a smooth curve"}}
        smooth = {"type": "object", "properties": points, "required": ["smooth"], "additionalProperties": False}
        return {"anyOf": [_marked_schema(FINITE), _points_schema(Polyline), smooth, _record_schema(Oscillation)]}
    if key.mark is not None:
        marked = _marked_schema(key.mark)
        return {"anyOf": [{"enum": list(key.choices)}, *marked["anyOf"]]} if key.choices else marked
    if key.law is not None:
        return _law_schema(key.law, by_name=str in key.options)
    if key.choices:
        return {"enum": list(key.choices)}
    if record := next((record for record in layout.TABLES if record in key.options), None):
        table = _record_schema(record)
        return {"anyOf": [{"type": "string"}, table]} if str in key.options else table
    if line := points_in(key.options):
        return _points_schema(line)
    if Ellipsis in key.options:
        return {"type": "array", "items": {"type": "number"}}
    types = {bool: "boolean", float: "number", int: "integer"}
    return {"type": next((types[option] for option in key.options if option in types), "string")}


def _points_schema(kind: type[Polyline]) -> Schema:
    """The points of a signal or a track."""
    point = {"type": "array", "prefixItems": [*map(_marked_schema, kind.MARKS)], "minItems": 2, "maxItems": 2}
    return {"type": "array", "items": point, "minItems": 1}


def _law_schema(laws: Registry, by_name: bool) -> Schema:
    """A law by its name, or a table with its name and data of its own."""
    named: list[Schema] = []
    if by_name:
        of_oils = [name for name in OF_OILS if name in inner_laws(laws)]
        named = [{"type": "string", "enum": [*layout.able_names(laws), *of_oils]}]
    tables = []
    for name, law in (laws if by_name else inner_laws(laws)).items():
        table = _record_schema(law, law=name)
        if name in OF_OILS:  # a named oil may have the rest
            table["required"] = ["law"]
        tables.append(table)
    return {"oneOf": [*named, *tables]}


# -- numbers and quantities -------------------------------------------------------------------------------------------

QUANTITY = "^ *(Ra *)?[-+]?[.0-9].*[A-Za-zµμ]"  # a number and a unit; ertel itself says which units it takes


def _marked_schema(mark: Mark) -> Schema:
    """A plain number, a quantity (a text with a unit), or an amount: either of them."""
    if isinstance(mark, Bounds):
        names = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
        limits = {name: getattr(mark, key) for key, name in names.items() if getattr(mark, key) is not None}
        return {"type": "integer" if mark.whole else "number", **limits}
    quantity = {"type": "string", "pattern": QUANTITY, "maxLength": LONGEST, "examples": [mark.example]}
    if not mark.scale:
        return quantity
    least: Schema = {} if mark.signed else {"exclusiveMinimum": 0}
    return {"anyOf": [{"type": "number", **least}, quantity]}
