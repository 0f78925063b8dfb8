"""The fields that a user fills in for a new case, as plain text, and the case that they make.

The values go to ertel as they are written, so that its own messages answer them: a quantity has its unit, "10 mm".
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal

from ertel.case.conditions import Kind
from ertel.inputs.case_files import apply_overrides
from ertel.inputs.library import material_names, oil_names
from ertel.inputs.templates import GIVEN

OWN = "own"  # in place of the name of an oil or a material
OILS = {OWN: "by its viscosity", **{name: name for name in oil_names()}}
MATERIALS = {name: name for name in material_names()}
METHODS: Mapping[Kind, dict[str, str]] = {
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
NEWTONIAN = "newtonian"
RHEOLOGIES = {NEWTONIAN: "Newtonian", "ree-eyring": "Ree-Eyring"}
DECIDE = ("kind", "given", "oil", "rheology", "method")  # fields on which others depend
TITLES = ("Contact", "Materials", "Oil", "Computation")
ENDS = {"max-approach": "maximum approach", "rebound": "rebound"}
LABELS = {
    "M": "Load parameter M",
    "L": "Lubricant parameter L",
    "radius": "Ball radius",
    "ball_density": "Ball density",
    "speed": "Impact speed",
    "load": "Load",
    "mean_speed": "Mean speed",
    "slide_to_roll": "Slide-to-roll ratio",
    "material_1": "Ball",
    "material_2": "Plane",
    "oil": "Oil",
    "temperature": "Temperature",
    "eta0": "Viscosity",
    "alpha": "Pressure-viscosity coefficient",
    "rheology": "Rheology",
    "tau0": "Eyring stress",
    "nodes": "Nodes",
    "method": "Method",
    "until": "End",
}


@dataclass
class Form:
    """The fields of the form, all as text.  Each is named as its key in case files, with its section in `SECTION`."""

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
    rheology: str = NEWTONIAN
    tau0: str = "5 MPa"
    method: str = "radial"
    nodes: str = str(USUAL["radial"])
    until: str = "max-approach"

    def choose(self, name: str, value: Any) -> None:
        """Change a field.  With the kind of contact the method changes, with the method the grid."""
        setattr(self, name, value)
        if name == "kind":
            self.choose("method", next(iter(METHODS[self.kind])))
        elif name == "method":
            self.nodes = str(USUAL[self.method])

    def groups(self) -> dict[str, tuple[str, ...]]:
        """The fields that the choices so far leave to be filled in, by the title of their group."""
        ends = ("until",) if self.kind == "impact" else ()
        groups: dict[str, tuple[str, ...]] = {"Contact": self._contact(), "Computation": ("method", "nodes", *ends)}
        if self.given == "si":
            groups |= {"Materials": ("material_1", "material_2"), "Oil": self._oil()}
        return {title: groups[title] for title in TITLES if title in groups}

    def options(self) -> dict[str, dict[str, str]]:
        """The values from which fields are chosen, with their labels."""
        return {
            "material_1": MATERIALS,
            "material_2": MATERIALS,
            "oil": OILS,
            "rheology": RHEOLOGIES,
            "method": METHODS[self.kind],
            "nodes": {str(n): str(n) for n in GRIDS[self.method]},
            "until": ENDS,
        }

    def _contact(self) -> tuple[str, ...]:
        if self.given == "moes":
            return ("M", "L")
        driven = ("ball_density", "speed") if self.kind == "impact" else ("load", "mean_speed", "slide_to_roll")
        return ("radius", *driven)

    def _oil(self) -> tuple[str, ...]:
        data = ("oil", "eta0", "alpha") if self.oil == OWN else ("oil", "temperature")
        if self.kind == "impact":  # the surfaces do not slide
            return data
        return (*data, "rheology") if self.rheology == NEWTONIAN else (*data, "rheology", "tau0")

    def data(self) -> dict[str, Any]:
        """The case as plain data, as a case file has it; what is left empty is left out."""
        names = ["kind", *(name for group in self.groups().values() for name in group)]
        given = {name: str(getattr(self, name)).strip() for name in names if name not in ("rheology", "tau0")}
        given = {name: text for name, text in given.items() if text not in ("", OWN)}
        data = apply_overrides({}, [f"{SECTION[name]}.{name}={text}" for name, text in given.items()])
        if "tau0" in names:
            data.setdefault("lubricant", {})["rheology"] = {"law": self.rheology, "tau0": self.tau0.strip()}
        return data


SECTION = {
    **dict.fromkeys((item.name for item in fields(Form)), "contact"),
    **dict.fromkeys(("oil", "temperature", "eta0", "alpha", "rheology", "tau0"), "lubricant"),
    **dict.fromkeys(("method", "nodes"), "solver"),
    "until": "time",
}


def field_of(message: str) -> str | None:
    """The field of the form that a message of ertel names first, contact.radius = ...; None where there is none."""
    section, _, rest = message.partition(".")
    name = rest.split(" ")[0].rstrip(":").rpartition(".")[2]
    return name if SECTION.get(name) == section else None


def read_text(text: str) -> dict[str, Any]:
    """The plain data of a case file.  Raises ValueError with the line where it is no TOML."""
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ValueError(f"the text is not valid TOML: {str(error)[:200]}") from error
