"""All keys of case files, read off the records of the model: for the table of keys, `--help-keys` and templates."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import MISSING, fields
from math import isfinite
from typing import Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

from ertel.case.height_map import HeightMap
from ertel.case.records import OIL_LAWS, law_fields, show
from ertel.case.sections import ENDS, METHODS, SOLVERS, START_APPROACH, STOPS, Solver, Time
from ertel.case.thermal import Thermal
from ertel.inputs.named import DataSheet
from ertel.inputs.schema import FILES, SECTIONS, SURFACE, TOP, first_paragraph
from ertel.inputs.spellings import kind_of
from ertel.physics.motion import Oscillation, Signal
from ertel.physics.registry import SHAPES, Registry
from ertel.physics.units import Bounds, Meaning, Unit, marks, meanings

NEEDED = "needed"
SIGNAL = "number, [[T, value], ...] or table"


class Key(NamedTuple):
    """A key of a case file.

    kind: what kind of value it has.  default: as it is written; "" if the meaning says what holds without the key.
    example: a value as it is written, "" if there is none.
    """

    name: str
    kind: str
    meaning: str
    default: str = ""
    example: str = ""


class Place(NamedTuple):
    """A section or a table of a case file: how it begins, what it is about, and its keys."""

    title: str
    text: str
    keys: tuple[Key, ...]


def places() -> Iterator[Place]:
    """All sections and tables of a case file, with the laws and shapes that are registered now."""
    top = (_explained("name", TOP["name"], "text", ""), _explained("schema", TOP["schema"], "1", "1"))
    yield Place("(top)", "the case", top)
    for name, part in SECTIONS.items():
        if name == "time":
            yield from _roughness()
        named = keys_of(part.named) if part.named else ()
        yield Place(f"[{name}]", part.text, (*named, *keys_of(part.record)))
        if name == "lubricant":
            yield Place("oil = { ... }", first_paragraph(DataSheet).removesuffix("."), keys_of(DataSheet))
            for field, laws in OIL_LAWS.items():
                yield from _laws(field, laws)
        if name == "motion":
            yield Place(
                "load, entrainment = { ... }", first_paragraph(Oscillation).removesuffix("."), keys_of(Oscillation)
            )


def _laws(field: str, laws: Registry) -> Iterator[Place]:
    for name, law in laws.items():
        if fields(law):
            text = first_paragraph(law).removesuffix(".")
            yield Place(f'{field} = {{ law = "{name}" }}', text, keys_of(law))


def _roughness() -> Iterator[Place]:
    own = _explained("surface", SURFACE, "1 or 2", "1")
    shape = Key("shape", " or ".join(SHAPES), "which shape", NEEDED)
    yield Place("[[roughness]]", TOP["roughness"].text, (shape, own))
    for name, record in SHAPES.items():
        reading = keys_of(FILES[name]) if name in FILES else ()
        yield Place(f'shape = "{name}"', first_paragraph(record).removesuffix("."), (*keys_of(record), *reading))


def keys_of(record: Any) -> tuple[Key, ...]:
    """The keys that stand for the fields of a record (a class)."""
    hints, said, kinds = get_type_hints(record), meanings(record), marks(record)
    found = []
    for item in fields(record):
        mark, meaning = kinds.get(item.name), said.get(item.name, Meaning(""))
        default = _default(record, item, meaning)
        found.append(_explained(item.name, meaning, _kind(record, item.name, hints[item.name], mark), default, mark))
    return tuple(found)


def _explained(name: str, meaning: Meaning, kind: str, default: str, mark: object = None) -> Key:
    if meaning.example is not None:
        example = show(meaning.example)
    elif default not in ("", NEEDED):
        example = default
    else:
        example = show(mark.example) if isinstance(mark, Unit) else ""
    return Key(name, kind, meaning.text, default, example)


def _kind(record: Any, name: str, hint: Any, mark: Unit | Bounds | None) -> str:
    """The kind of a value in words."""
    inside = law_fields(record)
    if isinstance(mark, Unit):
        events = ", ".join((*STOPS, "")) if name == "until" else ""
        return f"{events}{kind_of(mark)}"
    if mark is not None:
        return kind_of(mark)
    if name in OIL_LAWS and not inside:
        return f"{', '.join(law for law, kind in OIL_LAWS[name].items() if hasattr(kind, 'of'))} or table"
    words = {HeightMap: "name of a file", bool: "true or false", Signal: SIGNAL, DataSheet: "name or table"}
    options = get_args(hint) or (hint,)
    if literals := [option for option in (hint, *options) if get_origin(option) is Literal]:
        return " or ".join(map(str, get_args(literals[0])))
    return next((word for kind, word in words.items() if kind in options), "table" if name in inside else "text")


def _default(record: Any, item: Any, meaning: Meaning) -> str:
    """What holds where the key is left out, as it is written."""
    if record is Solver:
        return _by_name({method: getattr(solver, item.name) for method, solver in SOLVERS.items()}, item.name)
    if record is Time and item.name in ("start_approach", "until"):
        return show(START_APPROACH) if item.name == "start_approach" else _by_name(ENDS, item.name)
    if item.default is MISSING and item.default_factory is MISSING:
        return "" if record is Thermal else NEEDED  # a named oil and named materials complete it
    value = item.default
    if value in (None, "", ()) or (isinstance(value, float) and not isfinite(value)):
        return ""
    is_quantity = isinstance(marks(record).get(item.name), Unit) and isinstance(meaning.example, str)
    return show(meaning.example) if is_quantity else show(value)


def _by_name(values: Mapping[Any, Any], name: str) -> str:
    """Defaults that differ between methods or kinds of contact, each with those that have it."""
    if name == "method":
        return ", ".join(f'"{methods[0]}" ({kind})' for kind, methods in METHODS.items())
    groups: dict[str, list[str]] = {}
    for owner, value in values.items():
        if value is not None:
            groups.setdefault(show(value), []).append(str(owner))
    if len(groups) == 1 and len(next(iter(groups.values()))) == len(values):
        return next(iter(groups))
    return ", ".join(f"{value} ({', '.join(owners)})" for value, owners in groups.items())


# -- as text ----------------------------------------------------------------------------------------------------------


def table(found: Iterable[Place]) -> str:
    """The table of the keys of some places in Markdown."""
    lines = ["| section | key | value | meaning | default |", "| --- | --- | --- | --- | --- |"]
    for title, text, keys in found:
        lines.append(f"| `{title}` | | | {_cell(text)} | |")
        for key in keys:
            lines.append(
                f"| | `{key.name}` | {key.kind} | {_cell(key.meaning)} | {_code(key.default)} |".replace("  ", " ")
            )
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    """A text in a table, where a line between bars would end its cell."""
    return text.replace("|", "\\|")


def _code(default: str) -> str:
    return default if default in ("", NEEDED) or "(" in default else f"`{default}`"
