"""What a user fills in for a new case, as plain text, and the case file that it makes.

The values go to ertel as they are written, so that its own messages answer them: a quantity has its unit, "10 mm".
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

import tomli_w

from ertel.inputs.case_files import apply_overrides
from ertel.inputs.library import material_names, oil_names
from ertel.inputs.templates import GIVEN
from ertel.model.conditions import Kind

OWN = "own"  # in place of the name of an oil or a material
OILS = {OWN: "by its viscosity", **{name: name for name in oil_names()}}
MATERIALS = {name: name for name in material_names()}
METHODS: Mapping[Kind, Mapping[str, str]] = {
    "impact": {"radial": "radial: seconds", "2d": "plane: minutes"},
    "rolling": {"steady": "steady", "transient": "in time"},
}
GRIDS: Mapping[str, tuple[int, ...]] = {
    "radial": (129, 257, 401, 801),
    "2d": (65, 129, 257, 385, 513),
    "steady": (65, 129, 257, 513),
    "transient": (65, 129, 193, 257),
}
USUAL = {"radial": 257, "2d": 129, "steady": 129, "transient": 129}  # nodes: an answer within a minute
ENDS = {"max-approach": "maximum approach", "rebound": "rebound"}


@dataclass
class Form:
    """The fields of the form, all as text.  Each is named as its key in case files, with its section in `SECTION`."""

    name: str = ""
    kind: Kind = "impact"
    given: Literal["si", "moes"] = "si"
    M: str = "1000"
    L: str = "10"
    radius: str = str(GIVEN["impact"]["[contact]"]["radius"])
    ball_density: str = str(GIVEN["impact"]["[contact]"]["ball_density"])
    speed: str = str(GIVEN["impact"]["[contact]"]["speed"])
    load: str = str(GIVEN["rolling"]["[contact]"]["load"])
    mean_speed: str = str(GIVEN["rolling"]["[contact]"]["mean_speed"])
    slide_to_roll: str = ""
    material_1: str = "steel"
    material_2: str = "steel"
    oil: str = OWN
    temperature: str = "40 degC"
    eta0: str = str(GIVEN["impact"]["[lubricant]"]["eta0"])
    alpha: str = str(GIVEN["impact"]["[lubricant]"]["alpha"])
    method: str = "radial"
    nodes: str = str(USUAL["radial"])
    until: str = "max-approach"

    def choose_kind(self, kind: Kind) -> None:
        """Change the kind of contact; the method and the grid become the usual ones for it."""
        self.kind = kind
        self.choose_method(next(iter(METHODS[kind])))

    def choose_method(self, method: str) -> None:
        """Change the method; the grid becomes the usual one for it."""
        self.method, self.nodes = method, str(USUAL[method])

    @property
    def shown(self) -> tuple[str, ...]:
        """The fields that go into the case file."""
        contact = ("M", "L") if self.given == "moes" else self._quantities()
        ends = ("until",) if self.kind == "impact" else ()
        return ("kind", *contact, *self._oil(), "method", "nodes", *ends)

    def _quantities(self) -> tuple[str, ...]:
        driven = ("ball_density", "speed") if self.kind == "impact" else ("load", "mean_speed", "slide_to_roll")
        return ("radius", *driven, "material_1", "material_2")

    def _oil(self) -> tuple[str, ...]:
        if self.given == "moes":
            return ()
        return ("eta0", "alpha") if self.oil == OWN else ("oil", "temperature")

    def data(self) -> dict[str, Any]:
        """The case as plain data, as a case file has it; what is left empty is left out."""
        given = {name: str(getattr(self, name)).strip() for name in self.shown}
        items = [f"{SECTION[name]}.{name}={text}" for name, text in given.items() if text]
        return apply_overrides({"name": self.name.strip()} if self.name.strip() else {}, items)

    def text(self) -> str:
        """The case file."""
        return tomli_w.dumps(self.data())


SECTION = {
    **dict.fromkeys((item.name for item in fields(Form)), "contact"),
    **dict.fromkeys(("oil", "temperature", "eta0", "alpha"), "lubricant"),
    **dict.fromkeys(("method", "nodes"), "solver"),
    "until": "time",
}


def field_of(message: str) -> str | None:
    """The field of the form that a message of ertel names first, contact.radius = ...; None where there is none."""
    section, _, rest = message.partition(".")
    name = rest.split(" ")[0].rstrip(":")
    return name if SECTION.get(name) == section else None


def read_text(text: str) -> dict[str, Any]:
    """The plain data of a case file.  Raises ValueError with the line where it is no TOML."""
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ValueError(f"the text is not valid TOML: {str(error)[:200]}") from error


def files_of(data: Mapping[str, Any]) -> list[Path]:
    """The files that a case reads: those of measured surfaces."""
    tables = data.get("roughness", [])
    found = [table.get("file") for table in tables if isinstance(table, dict)] if isinstance(tables, list) else []
    return [Path(name) for name in found if isinstance(name, str)]
