"""The JSON schema of case files, for editors and checkers: keys, kinds of values, meanings, examples.

It takes every file that ertel takes, as far as units are spelled as in SPELLINGS.  It does not tell which keys belong
together: that is in the rules of the case, and `ertel check` says it.
"""

import json
import re
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from ertel.case.records import inner_laws
from ertel.inputs.layout import (
    NEEDED,
    SECTIONS,
    TOP,
    DataSheet,
    Key,
    able_names,
    first_paragraph,
    keys_of,
    places,
    shape_keys,
)
from ertel.inputs.names import OF_OILS
from ertel.inputs.quantities import LONGEST
from ertel.physics.motion import Oscillation, Signal
from ertel.physics.registry import SHAPES, Registry
from ertel.physics.units import FINITE, TEMPERATURE, TIME, Bounds, Mark, Unit

Schema = dict[str, Any]
DIALECT = "https://json-schema.org/draft/2020-12/schema"


def json_schema() -> Schema:
    """The JSON schema of a case file, with the laws and shapes that are registered now."""
    found = {place.title: place for place in places()}
    sections = {name: _table(part.text, found[f"[{name}]"].keys) for name, part in SECTIONS.items()}
    shapes = []
    for name in SHAPES:
        place = found[f'shape = "{name}"']
        shapes.append(_table(place.text, (*place.keys, shape_keys()[1]), shape=name))
    top = {key.name: _explained(key) for key in found["(top)"].keys}
    roughness = {"type": "array", "items": {"oneOf": shapes}, "description": TOP["roughness"].text}
    return {
        "$schema": DIALECT,
        "title": "Case file of ertel",
        **_object("A case of ertel.", {**top, **sections, "roughness": roughness}, ["contact"]),
    }


def json_schema_text() -> str:
    """The JSON schema as a text in ASCII."""
    return json.dumps(json_schema(), indent=2) + "\n"


def _object(text: str, properties: Schema, required: Sequence[str]) -> Schema:
    """The schema of a table that has no other keys."""
    found = {"type": "object", "description": text, "properties": properties, "additionalProperties": False}
    return {**found, "required": list(required)} if required else found


def _table(text: str, keys: Sequence[Key], **name: str) -> Schema:
    """The schema of a table.  name: of its law or shape, by its key."""
    properties = {key: {"const": value} for key, value in name.items()}
    properties |= {key.name: _explained(key) for key in keys}
    required = [key.name for key in keys if key.default == NEEDED]
    return _object(text, properties, [*name, *required])


def _explained(key: Key) -> Schema:
    """The schema of a key with its meaning."""
    example = {} if key.meaning.example is None else {"examples": [key.meaning.example]}
    return {**_value(key), "description": key.meaning.text, **example}


def _value(key: Key) -> Schema:
    """The schema of the value of a key."""
    if key.mark is not None:
        marked = _marked(key.mark)
        return {"anyOf": [{"enum": list(key.choices)}, *marked["anyOf"]]} if key.choices else marked
    if key.law is not None:
        return _law(key.law, by_name=str in key.options)
    if key.choices:
        return {"enum": list(key.choices)}
    if Signal in key.options:
        point = {"type": "array", "prefixItems": [_marked(TIME), _marked(FINITE)], "minItems": 2, "maxItems": 2}
        points = {"type": "array", "items": point, "minItems": 1}
        return {"anyOf": [_marked(FINITE), points, _table(first_paragraph(Oscillation), keys_of(Oscillation))]}
    if DataSheet in key.options:
        return {"anyOf": [{"type": "string"}, _table(first_paragraph(DataSheet), keys_of(DataSheet))]}
    if Ellipsis in key.options:
        return {"type": "array", "items": {"type": "number"}}
    types = {bool: "boolean", float: "number", int: "integer"}
    return {"type": next((types[option] for option in key.options if option in types), "string")}


def _law(laws: Registry, by_name: bool) -> Schema:
    """A law by its name, or a table with its name and data of its own."""
    named: list[Schema] = []
    if by_name:
        of_oils = [name for name in OF_OILS if name in inner_laws(laws)]
        named = [{"type": "string", "enum": [*able_names(laws), *of_oils]}]
    tables = []
    for name, law in (laws if by_name else inner_laws(laws)).items():
        table = _table(first_paragraph(law), keys_of(law), law=name)
        if name in OF_OILS:  # a named oil may have the rest
            table["required"] = ["law"]
        tables.append(table)
    return {"oneOf": [*named, *tables]}


# -- numbers and quantities -------------------------------------------------------------------------------------------

SPELLINGS: Mapping[str, Sequence[str]] = {  # by the SI unit; a prefix of SI may stand in place of ~
    "m": ("~m", "~meter", "~metre", "inch", "in", "ft", "thou"),
    "s": ("~s", "~second", "minute", "min", "hour", "h"),
    "kg": ("~g", "gram", "tonne", "t", "lb", "oz"),
    "N": ("~N", "newton", "kgf", "lbf", "kg*m/s^2"),
    "m/s": ("~m/s", "~m/min", "km/h", "in/s", "ft/s", "ft/min", "mph", "kph"),
    "kg/m^3": ("~g/~m^3", "~g/~L", "~g/~l", "lb/ft^3", "lb/in^3"),
    "Pa": ("~Pa", "bar", "mbar", "kbar", "psi", "ksi", "atm", "~N/~m^2", "kgf/mm^2", "kgf/cm^2"),
    "1/Pa": ("1/~Pa", "/~Pa", "~Pa^-1", "~m^2/~N", "1/bar", "/bar", "1/psi", "/psi"),
    "Pa*s": ("~Pa*~s", "P", "cP", "mP", "poise", "~N*~s/~m^2", "~g/(~m*s)", "~g/~m/s", "reyn"),
    "m^2/s": ("~m^2/s", "St", "cSt", "mSt"),
    "K": ("K", "kelvin", "degC", "degF", "celsius"),
    "1/K": ("1/K", "/K", "K^-1", "1/delta_degC", "/delta_degC"),
    "deg": ("deg", "degree", "degrees", "~rad", "radian"),
    "W/(m*K)": ("~W/(~m*K)", "~W/~m/K"),
    "J/(kg*K)": ("~J/(~g*K)", "~J/~g/K"),
}
PREFIX = "(?:[TGMkhdcmunpµμ]|nano|micro|milli|centi|kilo|mega|giga)?"
DIGITS = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?(?![0-9])"
ABOVE_ZERO = "(?=[0.]*[1-9])"  # a digit that is not zero follows


@cache
def pattern(unit: Unit) -> str:
    """A regular expression (ECMA 262) for quantities in a unit, as they are usually written.

    ertel itself takes every unit of the right dimension that pint knows; the pattern takes the spellings above only.
    """
    any_sign = unit.signed or unit == TEMPERATURE  # 0 degC is above zero
    number = rf"[+-]?{DIGITS}" if any_sign else rf"\+?{ABOVE_ZERO}{DIGITS}"
    spelled = "|".join(_expression(text) for text in SPELLINGS.get(unit.unit, (unit.unit,)))
    return rf"^ *{number} *(?:{spelled}) *$"


def _expression(spelling: str) -> str:
    """One spelling of a unit, with the ways in which products and powers are written."""
    ways = {"~": PREFIX, "*": "(?: *[*·] *| +)", "/": " */ *", "^": r" *(?:\^|\*\*) *"}
    return "".join(ways.get(part) or re.escape(part) for part in re.split(r"([~*/^])", spelling) if part)


def _marked(mark: Mark) -> Schema:
    """A plain number, a quantity (a text with a unit), or an amount: either of them."""
    if isinstance(mark, Bounds):
        names = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
        limits = {name: getattr(mark, key) for key, name in names.items() if getattr(mark, key) is not None}
        return {"type": "integer" if mark.whole else "number", **limits}
    quantity = {"type": "string", "pattern": pattern(mark), "maxLength": LONGEST, "examples": [mark.example]}
    if not mark.scale:
        return quantity
    least: Schema = {} if mark.signed else {"exclusiveMinimum": 0}
    return {"anyOf": [{"type": "number", **least}, quantity]}
