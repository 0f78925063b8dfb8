"""Texts made of the layout: new case files that run at once and explain all other keys, and the table of all keys."""

from collections.abc import Iterable, Iterator, Mapping
from textwrap import wrap
from typing import Any

from ertel.case.conditions import FOREIGN, Kind
from ertel.case.records import show
from ertel.case.sections import ENDS, SOLVERS
from ertel.inputs.layout import NEEDED, Key, Place, places

SCHEMA_FILE = "ertel.schema.json"
WIDTH, MEANING_FROM = 120, 36  # columns
STEEL = {"E1": "210 GPa", "nu1": 0.3, "E2": "210 GPa", "nu2": 0.3}
OIL = {"eta0": "20 mPa*s", "alpha": "20 / GPa"}
GIVEN: Mapping[Kind, Mapping[str, Mapping[str, Any]]] = {  # what a new case file gives
    "impact": {
        "[contact]": {
            "kind": "impact",
            "radius": "10 mm",
            "ball_density": "7850 kg/m^3",
            "speed": "0.1 m/s",
            **STEEL,
        },
        "[lubricant]": OIL,
        "[solver]": {"method": "radial", "nodes": 401},
        "[time]": {"until": "max-approach"},
    },
    "rolling": {
        "[contact]": {"kind": "rolling", "radius": "10 mm", "load": "40 N", "mean_speed": "0.5 m/s", **STEEL},
        "[lubricant]": OIL,
        "[solver]": {"method": "steady", "nodes": 257},
    },
}
ABOUT: Mapping[Kind, str] = {
    "impact": "A ball hits an oiled surface.",
    "rolling": "A ball rolls, and if wanted slides, on an oiled surface.",
}
SHAPE = "spot"


def template(kind: Kind, name: str) -> str:
    """A new case file.  kind: "impact" or "rolling".  name: of the file, for the comments at its head."""
    lines = [
        f"#:schema ./{SCHEMA_FILE}",
        f"# {ABOUT[kind]}",
        "#",
        f"#   ertel check {name}        what follows from it, without running it",
        f"#   ertel run {name}",
        "#",
        "# Keys in comments are optional; some exclude others, see ertel check. Quantities have a unit, any",
        "# that you like; amounts without one are in the units of the case: lengths a, heights a^2/R, times t0.",
    ]
    given = GIVEN[kind]
    for place in places():
        is_told = place.title.startswith("[") or place.title == f'shape = "{SHAPE}"'
        if is_told and not _is_of_other(place.text, kind):
            lines += _section(place, given, kind)
    return "\n".join(lines) + "\n"


def _section(place: Place, given: Mapping[str, Mapping[str, Any]], kind: Kind) -> Iterator[str]:
    """The lines of a section; one of which nothing is given is a comment as a whole."""
    values = given.get(place.title, {})
    mark = "" if values else "# "
    if place.title.startswith("["):
        yield ""
        yield from _line(f"{mark}{place.title}", place.text)
    foreign = FOREIGN[kind] if place.title == "[contact]" else ()
    ours = [key for key in place.keys if key.name not in foreign and not _is_of_other(key.meaning.text, kind)]
    for key in sorted(ours, key=lambda key: key.name not in values):
        yield from _line(_written(key, values, _examples(place.title, kind)), key.meaning.text)


def _is_of_other(meaning: str, kind: Kind) -> bool:
    """Whether a meaning says that a key or a section is for the other kind of contact only."""
    other = "rolling" if kind == "impact" else "impact"
    return meaning.startswith(f"{other}:")


def _written(key: Key, values: Mapping[str, Any], examples: Mapping[str, str]) -> str:
    if key.name in values:
        return f"{key.name} = {show(values[key.name])}"
    return f"# {key.name} = {examples.get(key.name) or key.example or show(SHAPE)}"


def _examples(title: str, kind: Kind) -> Mapping[str, str]:
    """Examples that depend on the kind of contact: the defaults of its method, and its end."""
    if title == "[solver]":
        usual = SOLVERS[GIVEN[kind][title]["method"]]
        return {name: show(value) for name, value in vars(usual).items() if value is not None}
    return {"until": show(ENDS[kind])} if title == "[time]" else {}


def _line(text: str, meaning: str) -> Iterator[str]:
    """A line with its meaning behind it, or above where that is too long."""
    whole = f"{text:{MEANING_FROM}} # {meaning}"
    if len(whole) <= WIDTH:
        yield whole
    else:
        yield from (f"# {part}" for part in wrap(meaning, WIDTH - 2))
        yield text


# -- the table of all keys --------------------------------------------------------------------------------------------


def table(found: Iterable[Place]) -> str:
    """The table of the keys of some places in Markdown."""
    lines = ["| section | key | value | meaning | default |", "| --- | --- | --- | --- | --- |"]
    for title, text, keys in found:
        lines.append(f"| `{title}` | | | {_cell(text)} | |")
        for key in keys:
            lines.append(
                f"| | `{key.name}` | {key.kind} | {_cell(key.meaning.text)} | {_code(key.default)} |".replace("  ", " ")
            )
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    """A text in a table, where a line between bars would end its cell."""
    return text.replace("|", "\\|")


def _code(default: str) -> str:
    return default if default in ("", NEEDED) or "(" in default else f"`{default}`"
