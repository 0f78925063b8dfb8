"""How numbers and quantities are written in case files, as JSON schemas: for hover texts and completion in editors.

ertel itself takes every unit of the right dimension that pint knows.  A pattern cannot: it has the spellings below,
with a prefix of SI where a `~` stands, and refuses all others, those of another dimension among them.
"""

import re
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from ertel.inputs.quantities import LONGEST
from ertel.physics.units import TEMPERATURE, Bounds, Unit

SPELLINGS: Mapping[str, Sequence[str]] = {  # by the SI unit
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
    """A regular expression (ECMA 262) for quantities in a unit, as they are usually written."""
    any_sign = unit.signed or unit == TEMPERATURE  # 0 degC is above zero
    number = rf"[+-]?{DIGITS}" if any_sign else rf"\+?{ABOVE_ZERO}{DIGITS}"
    spelled = "|".join(_expression(text) for text in SPELLINGS.get(unit.unit, (unit.unit,)))
    return rf"^ *{number} *(?:{spelled}) *$"


def _expression(spelling: str) -> str:
    """One spelling of a unit, with the ways in which products and powers are written."""
    ways = {"~": PREFIX, "*": "(?: *[*·] *| +)", "/": " */ *", "^": r" *(?:\^|\*\*) *"}
    return "".join(ways.get(part) or re.escape(part) for part in re.split(r"([~*/^])", spelling) if part)


def quantity_schema(unit: Unit) -> dict[str, Any]:
    """The JSON schema of a quantity, a text with a unit."""
    return {"type": "string", "pattern": pattern(unit), "maxLength": LONGEST, "examples": [unit.example]}


def amount_schema(unit: Unit) -> dict[str, Any]:
    """The JSON schema of an amount: a number in the unit of the case, or a quantity."""
    least: dict[str, Any] = {} if unit.signed else {"exclusiveMinimum": 0}
    return {"anyOf": [{"type": "number", **least}, quantity_schema(unit)]}


def number_schema(bounds: Bounds) -> dict[str, Any]:
    """The JSON schema of a plain number."""
    names = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
    limits = {name: getattr(bounds, key) for key, name in names.items() if getattr(bounds, key) is not None}
    return {"type": "integer" if bounds.whole else "number", **limits}


def kind_of(mark: Unit | Bounds) -> str:
    """In a word what kind of value is written."""
    if isinstance(mark, Unit):
        return f"number ({mark.own}) or quantity" if mark.scale else "quantity"
    return "integer" if mark.whole else "number"
