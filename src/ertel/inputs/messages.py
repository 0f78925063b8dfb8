"""What is wrong with a case file, in one line: the field, its value, and what is allowed."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Any

from pydantic import ValidationError

from ertel.case.records import OIL_LAWS, printable, show, show_key
from ertel.inputs import schema
from ertel.physics.registry import SHAPES


class ConfigError(ValueError):
    """The input is wrong: the message, one line, names the field, its value and what is allowed."""

    def __init__(self, message: str):
        super().__init__(printable(message))


THINNING = 'shear thinning is written lubricant.rheology = { law = "ree-eyring", tau0 = "5 MPa" }'

# keys that a tribologist may try and that ertel does not support, with an explanation
NOT_THERE = {
    "ellipticity": "give radius_ratio = R_x/R_y, or the radii radius_x and radius_y",
    "tau0": THINNING,
    "eyring": THINNING,
    "carreau": THINNING,
    "friction": "every run has its friction; there is nothing to give",
    "spin": "ertel does not know spin; the surfaces move along x",
    "beta": "the data for temperatures are in the section [thermal]",
    "starvation": "ertel's contacts are fully flooded",
}


def message(error: ValidationError) -> str:
    """The first thing that is wrong: field = value: what is allowed."""
    first: Any = error.errors()[0]
    place = [part for part in first["loc"] if not _is_tag(part)]
    field = f"{field_name(place)} = {show(first['input'])}"
    match first["type"]:
        case schema.UNKNOWN_KEY:
            key, value, known = (first["ctx"][name] for name in ("key", "value", "known"))
            return f"{field_name([*place, key])} = {show(value)}: unknown key; {_known_keys(key, known)}"
        case "value_error":
            return f"{field}: {first['ctx']['error']}"
        case "literal_error" if place[0] == "lubricant" and first["input"] in OIL_LAWS.get(str(place[1]), {}):
            law = first["input"]
            return f'{field}: has data of its own; give them as {{ law = "{law}", ... }}'
        case "literal_error":
            return f"{field}: allowed: {first['ctx']['expected']}"
        case "union_tag_not_found" if place[0] == "roughness" and not isinstance(first["input"], dict):
            return f"{field}: must be a table with a shape; allowed: {_list(SHAPES)}"
        case "union_tag_not_found" if place[0] == "roughness":
            return _unknown_name(place, "shape", first["input"], SHAPES)
        case "union_tag_not_found" if place[0] == "lubricant" and len(place) > 2 and isinstance(first["input"], str):
            return f"{field}: must be a table with a law and its data"
        case "union_tag_not_found" if place[0] == "lubricant":
            return _unknown_name(place, "law", first["input"], OIL_LAWS[str(place[1])])
        case "union_tag_not_found" | "too_short":
            return f"{field}: must be {schema.SIGNAL_TEXT}"
        case "tuple_type" if place == ["roughness"]:
            return f"{field}: must be an array of tables, [[roughness]]"
        case "missing" | "too_long" | "tuple_type" if schema.POINTS in first["loc"]:
            return f"{field}: must be [T, value]"
        case "missing":
            return f"{field_name(place)}: missing"
        case "model_type" | "model_attributes_type":
            return f"{field}: must be a section, [{place[0]}]"
    return f"{field}: " + str(first["msg"]).replace("Input should be", "must be").replace("valid ", "")


def _unknown_name(place: Sequence[str | int], key: str, value: object, allowed: Iterable[str]) -> str:
    given = value.get(key) if isinstance(value, dict) else None if key == "shape" else value
    said = ": missing" if given is None else f" = {show(given)}"
    return f"{field_name(place)}.{key}{said}; allowed: {_list(allowed)}"


def _is_tag(part: str | int) -> bool:
    return isinstance(part, str) and part.startswith("<") and part.endswith(">")


def field_name(place: Sequence[str | int]) -> str:
    """section.key, an element of an array by its number from 1: roughness[1].amplitude."""
    return "".join(f"[{part + 1}]" if isinstance(part, int) else f".{show_key(part)}" for part in place).removeprefix(
        "."
    )


def _known_keys(name: str, known: Sequence[str]) -> str:
    if name in NOT_THERE:
        return NOT_THERE[name]
    close = get_close_matches(name, known, n=1)
    return (f"did you mean {close[0]}? " if close else "") + f"allowed: {_list(known)}"


def _list(names: Iterable[str]) -> str:
    return ", ".join(names)
