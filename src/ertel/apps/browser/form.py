"""A new case: the fields that a user fills in, the case that they make, and ertel's answer before it is run.

The values go to ertel as they are written, so that its own messages answer them: a quantity has its unit, "10 mm".
"""

import os
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any, NamedTuple

from ertel.apps.browser.folder import Folder
from ertel.inputs import materials, oils
from ertel.inputs.case_files import apply_overrides, parse_case
from ertel.inputs.templates import GIVEN
from ertel.runs.outlook import outlook

OWN, NAMED = "own", "named"  # oils: by values, "own" also in place of its name; from the library
NEWTONIAN = "newtonian"
OILS = {OWN: "by its viscosity", **{name: name for name in oils.names()}}
MATERIALS = {name: name for name in materials.names()}
RHEOLOGIES = {NEWTONIAN: "Newtonian", "ree-eyring": "Ree-Eyring"}
ENDS = {"max-approach": "maximum approach", "rebound": "rebound"}
METHODS: Mapping[str, dict[str, str]] = {
    "impact": {"radial": "radial: seconds", "2d": "plane: minutes"},
    "rolling": {"steady": "steady", "transient": "in time"},
}
GRIDS: Mapping[str, tuple[str, ...]] = {
    "radial": ("129", "257", "401", "801"),
    "2d": ("65", "129", "257", "385", "513"),
    "steady": ("65", "129", "257", "513"),
    "transient": ("65", "129", "193", "257"),
}
USUAL = 1  # the place in `GRIDS` of a grid that answers within a minute
DECIDE = ("kind", "given", "oil", "rheology", "method")  # fields on which others depend


class Field(NamedTuple):
    """A field, which has the name of its key in case files.

    section: of the key.  group: of fields on the page.  value: the first one.  when: the choices that show the field,
    all of them, see `Form.shown`.  options: the values with their labels; empty for a text.
    """

    section: str
    group: str
    label: str
    value: str
    when: str = ""
    options: Mapping[str, str] | None = None


BALL, ROLLED, OIL = GIVEN["impact"]["[contact]"], GIVEN["rolling"]["[contact]"], GIVEN["impact"]["[lubricant]"]
FIELDS = {
    "kind": Field("contact", "", "Kind", "impact", options={"impact": "Impact", "rolling": "Rolling"}),
    "given": Field("", "", "Given", "si", options={"si": "Quantities", "moes": "M and L"}),
    "M": Field("contact", "Contact", "Load parameter M", "1000", "moes"),
    "L": Field("contact", "Contact", "Lubricant parameter L", "10", "moes"),
    "radius": Field("contact", "Contact", "Ball radius", BALL["radius"], "si"),
    "ball_density": Field("contact", "Contact", "Ball density", BALL["ball_density"], "si impact"),
    "speed": Field("contact", "Contact", "Impact speed", BALL["speed"], "si impact"),
    "load": Field("contact", "Contact", "Load", ROLLED["load"], "si rolling"),
    "mean_speed": Field("contact", "Contact", "Mean speed", ROLLED["mean_speed"], "si rolling"),
    "slide_to_roll": Field("contact", "Contact", "Slide-to-roll ratio", "", "si rolling"),
    "material_1": Field("contact", "Materials", "Ball", "steel", "si", MATERIALS),
    "material_2": Field("contact", "Materials", "Plane", "steel", "si", MATERIALS),
    "oil": Field("lubricant", "Oil", "Oil", OWN, "si", OILS),
    "temperature": Field("lubricant", "Oil", "Temperature", "40 degC", f"si {NAMED}"),
    "eta0": Field("lubricant", "Oil", "Viscosity", OIL["eta0"], f"si {OWN}"),
    "alpha": Field("lubricant", "Oil", "Pressure-viscosity coefficient", OIL["alpha"], f"si {OWN}"),
    "rheology": Field("lubricant", "Oil", "Rheology", NEWTONIAN, "si rolling", RHEOLOGIES),
    "tau0": Field("lubricant", "Oil", "Eyring stress", "5 MPa", "si rolling ree-eyring"),
    "layer": Field("lubricant", "Oil", "Layer of oil on the surfaces", ""),
    "method": Field("solver", "Computation", "Method", "radial"),
    "nodes": Field("solver", "Computation", "Nodes", GRIDS["radial"][USUAL]),
    "until": Field("time", "Computation", "End", "max-approach", "impact", ENDS),
}


class Form:
    """The fields of the form, all as text.  values: by the names of the fields."""

    def __init__(self, **values: str):
        self.values = {name: str(field.value) for name, field in FIELDS.items()} | values

    def choose(self, name: str, value: str) -> None:
        """Change a field.  With the kind of contact the method changes, with the method the grid."""
        self.values[name] = value
        if name == "kind":
            self.choose("method", next(iter(METHODS[value])))
        elif name == "method":
            self.choose("nodes", GRIDS[value][USUAL])

    def options(self, name: str) -> Mapping[str, str] | None:
        """The values from which a field is chosen, with their labels; None for a text."""
        if name == "method":
            return METHODS[self.values["kind"]]
        if name == "nodes":
            return {nodes: nodes for nodes in GRIDS[self.values["method"]]}
        return FIELDS[name].options

    def shown(self) -> list[str]:
        """The fields that the choices so far leave to be filled in."""
        oil = OWN if self.values["oil"] == OWN else NAMED
        choices = {oil, *(self.values[name] for name in ("kind", "given", "rheology"))}
        return [name for name, field in FIELDS.items() if field.group and choices.issuperset(field.when.split())]

    def data(self) -> dict[str, Any]:
        """The case as plain data, as a case file has it; what is left empty is left out."""
        given = {name: self.values[name].strip() for name in ("kind", *self.shown())}
        law, tau0 = given.pop("rheology", NEWTONIAN), given.pop("tau0", None)
        texts = {name: text for name, text in given.items() if text not in ("", OWN)}
        data = apply_overrides({}, [f"{FIELDS[name].section}.{name}={text}" for name, text in texts.items()])
        if tau0 is not None:
            data.setdefault("lubricant", {})["rheology"] = {"law": law, "tau0": tau0}
        return data


def field_of(message: str) -> str | None:
    """The field of the form that a message of ertel names first, contact.radius = ...; None where there is none."""
    section, _, rest = message.partition(".")
    name = rest.split(" ")[0].rstrip(":").rpartition(".")[2].partition("[")[0]  # layer[1][2] is a point of a track
    return name if name in FIELDS and FIELDS[name].section == section else None


# -- the answer of ertel -----------------------------------------------------------------------------------------------


def outlook_of(data: Mapping[str, Any], folder: Folder) -> dict[str, Any]:
    """The answer of `ertel check` to a case.  Raises ConfigError, and Outside for files outside the folder."""
    for table in _with_files(data):
        folder.inside(table["file"])
    return outlook(parse_case(data, folder.root))


def relocated(data: Mapping[str, Any], before: Path, now: Path) -> dict[str, Any]:
    """The plain data of a case whose files were named relative to one folder: now relative to another."""
    moved = deepcopy(dict(data))
    for table in _with_files(moved):
        table["file"] = os.path.relpath(os.path.realpath(before / table["file"]), now)
    return moved


def _with_files(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The tables of a case that name a file."""
    tables = data.get("roughness")
    if not isinstance(tables, list):
        return []
    return [table for table in tables if isinstance(table, dict) and isinstance(table.get("file"), str)]
