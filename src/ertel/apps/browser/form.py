"""A new case: the fields that a user fills in, the case that they make, and ertel's answer before it is run.

A field is a key of case files, from which it has its meaning, unit and default, or a choice that opens others.  The
values go to ertel as they are written, so that its own messages answer them: a quantity has its unit, "10 mm".
"""

import os
import re
from collections.abc import Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any, NamedTuple

from ertel.apps.browser.folder import Folder
from ertel.case.definition import SECTIONS
from ertel.case.records import inner_laws
from ertel.inputs import materials, oils
from ertel.inputs.case_files import apply_overrides, parse_case
from ertel.inputs.layout import NEEDED, TOP, Key, keys_of, section, shape_keys, shape_place
from ertel.inputs.templates import GIVEN
from ertel.physics.registry import FLUIDITY_LAWS, SHAPES
from ertel.physics.units import Meaning, Unit
from ertel.runs.outlook import outlook

OWN, NAMED = "own", "named"  # oils: by values, "own" also in place of its name; from the library
OILS = {OWN: "by its viscosity", **{name: name for name in oils.names()}}
MATERIALS = {name: name for name in materials.names()}
ROUND, ELLIPTIC = "round", "elliptic"
BODIES = {"ball": "ball on a plane", "balls": "two balls", "ellipse": "ellipse", "four-radii": "four radii"}
DROPS = {"by-speed": "its speed", "by-height": "the height of its fall"}
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
CHOICES = ("contact.kind", "given", "bodies", "drop", "solver.method", "thermal")  # whose values open other fields
SHAPE, LAW = "roughness.shape", "lubricant.rheology.law"  # which open those of their tables
DECIDE = (*CHOICES, "lubricant.oil", SHAPE, LAW)  # fields on which others depend
FOLDED = ("Layer of oil, for a starved contact", "Temperatures", "Roughness")  # groups that are open when one is used
LAYER, HEAT, ROUGHNESS = FOLDED


class Field(NamedTuple):
    """A field, by the path of its key in case files.

    group: of fields on the page.  label: left out, it is made of the name of the key.  when: the choices that show the
    field, all of them, see `Form.shown`.  options: the values with their labels; empty for a text.  value: the first
    one; left out, that of new case files or the example of the key.  key: None for a choice that is not in case files.
    """

    group: str
    label: str = ""
    when: str = ""
    options: Mapping[str, str] | None = None
    value: str | None = None
    key: Key | None = None

    @property
    def help(self) -> str:
        """Name, kind of value, default and meaning, as `ertel run --help-keys` says them."""
        return f"{self.key.title}: {self.key.meaning.text}" if self.key else ""


def _written(value: object) -> str:
    """A value of a case file as it is typed here."""
    return str(value).strip('"')


TEMPLATE = {  # what new case files give
    f"{title.strip('[]')}.{name}": _written(value)
    for given in GIVEN.values()
    for title, table in given.items()
    for name, value in table.items()
}


def _completed(field: Field, name: str, key: Key | None) -> Field:
    """The field of a key, with what follows from the key."""
    if key is None:
        return field
    label = field.label or key.name.replace("_", " ").capitalize()
    value = TEMPLATE.get(name, _written(key.example)) if field.value is None else field.value
    options = field.options
    if key.choices and not options:
        usual = {"": f"usual, {_written(key.default)}" if key.default else "as usual"}
        options = usual | {str(choice): str(choice) for choice in key.choices}
    return field._replace(label=label, value=value, key=key, options=options)


KEYS = {f"{name}.{key.name}": key for name in SECTIONS for key in section(name).keys}
KEYS |= {
    LAW: KEYS["lubricant.rheology"],
    "thermal": Key("thermal", Meaning(SECTIONS["thermal"][2]), bool),
    SHAPE: shape_keys()[0]._replace(meaning=TOP["roughness"]),
}
OPTIONAL = ""  # the value of a field that may stay empty
ONE_OF = ("wavelength_x", "depth")  # keys of shapes that may be left out, but not with the other one that they have
FIELDS = {
    name: _completed(field, name, KEYS.get(name))
    for name, field in {
        "contact.kind": Field("", "Kind", "", {"impact": "Impact", "rolling": "Rolling"}, "impact"),
        "given": Field("", "Given", "", {"si": "Quantities", "moes": "M and L"}, "si"),
        "contact.M": Field("Contact", "Load parameter M", "moes"),
        "contact.L": Field("Contact", "Lubricant parameter L", "moes"),
        "contact.radius_ratio": Field("Contact", "Ratio of radii, of an ellipse", "moes", value=OPTIONAL),
        "bodies": Field("Contact", "Bodies", "si", BODIES, "ball"),
        "contact.radius": Field("Contact", "Ball radius", "si ball"),
        "contact.radius_1": Field("Contact", "Radius of ball 1", "si balls"),
        "contact.radius_2": Field("Contact", "Radius of ball 2", "si balls"),
        "contact.radius_x": Field("Contact", "Radius along x", "si ellipse"),
        "contact.radius_y": Field("Contact", "Radius along y", "si ellipse"),
        "contact.radius_x_1": Field("Contact", "Radius of body 1 along x", "si four-radii"),
        "contact.radius_y_1": Field("Contact", "Radius of body 1 along y", "si four-radii"),
        "contact.radius_x_2": Field("Contact", "Radius of body 2 along x", "si four-radii"),
        "contact.radius_y_2": Field("Contact", "Radius of body 2 along y", "si four-radii"),
        "contact.entrainment_angle": Field("Contact", "Angle of entrainment", "rolling elliptic", value=OPTIONAL),
        "contact.ball_density": Field("Contact", when="si impact round"),
        "contact.mass": Field("Contact", "Mass of the moving body", "si impact elliptic"),
        "drop": Field("Contact", "Impact given by", "si impact", DROPS, "by-speed"),
        "contact.speed": Field("Contact", "Impact speed", "si impact by-speed"),
        "contact.drop_height": Field("Contact", when="si impact by-height"),
        "contact.load": Field("Contact", when="si rolling"),
        "contact.mean_speed": Field("Contact", when="si rolling"),
        "contact.slide_to_roll": Field("Contact", "Slide-to-roll ratio", "si rolling", value=OPTIONAL),
        "motion.slide_to_roll": Field("Contact", "Slide-to-roll ratio", "moes rolling", value=OPTIONAL),
        "contact.material_1": Field("Materials", "Ball or body 1", "si", MATERIALS, "steel"),
        "contact.material_2": Field("Materials", "Plane or body 2", "si", MATERIALS, "steel"),
        "lubricant.oil": Field("Oil", "Oil", "si", OILS, OWN),
        "lubricant.temperature": Field("Oil", "Temperature", f"si {NAMED}"),
        "lubricant.eta0": Field("Oil", "Viscosity", f"si {OWN}"),
        "lubricant.alpha": Field("Oil", "Pressure-viscosity coefficient", f"si {OWN}"),
        LAW: Field("Oil", "Shear thinning", "si rolling", value=OPTIONAL),
        "lubricant.layer": Field(LAYER, "On both surfaces together", value=OPTIONAL),
        "lubricant.layer_1": Field(LAYER, "On surface 1", value=OPTIONAL),
        "lubricant.layer_2": Field(LAYER, "On surface 2", value=OPTIONAL),
        "thermal": Field(HEAT, "Temperatures", "si steady", {"": "not computed", "warm": "computed"}, ""),
        SHAPE: Field(ROUGHNESS, "Shape", value=OPTIONAL),
        "solver.method": Field("Computation", "Method", value="radial"),
        "solver.nodes": Field("Computation", "Nodes", value=GRIDS["radial"][USUAL]),
        "time.until": Field("Computation", "End", "impact", ENDS),
    }.items()
}


def _keys_opened(name: str, value: str) -> Sequence[Key]:
    """The keys of the table that a choice opens: of a shape, a law, or a section that may be left out."""
    if name == SHAPE and value:
        return (*shape_place(value).keys, *shape_keys()[1:])
    if name == LAW and value:
        return keys_of(FLUIDITY_LAWS[value])
    return section(name).keys if name in SECTIONS and value else ()


class Form:
    """The fields of the form.  values: all as text, by the names of the fields."""

    def __init__(self) -> None:
        self.values = {name: field.value or "" for name, field in FIELDS.items()}

    @property
    def is_round(self) -> bool:
        """Whether the contact of the bodies is a circle."""
        return self.values["bodies"] in ("ball", "balls")

    @property
    def needs_plane(self) -> bool:
        """Whether an impact cannot be computed along the radius."""
        return not self.is_round or bool(self.values[SHAPE])

    def choose(self, name: str, value: str) -> None:
        """Change a field.  With what is chosen the methods change that suit it, with these and the bodies the grid."""
        self.values[name] = value
        methods = list(self.options("solver.method") or ())
        if self.values["solver.method"] not in methods:
            self.choose("solver.method", methods[0])
        elif name in ("solver.method", "bodies"):
            nodes = GRIDS[self.values["solver.method"]][USUAL]
            self.choose("solver.nodes", nodes if self.is_round else "")

    def options(self, name: str) -> Mapping[str, str] | None:
        """The values from which a field is chosen, with their labels; None for a text."""
        match name:
            case "solver.method":
                methods = METHODS[self.values["contact.kind"]]
                return {method: methods[method] for method in methods if method != "radial" or not self.needs_plane}
            case "solver.nodes":
                return {"": "as usual", **{nodes: nodes for nodes in GRIDS[self.values["solver.method"]]}}
            case "roughness.shape":
                return {"": "smooth", **{shape: shape for shape in SHAPES}}
            case "lubricant.rheology.law":
                return {"": "none, or that of a named oil", **{law: law for law in inner_laws(FLUIDITY_LAWS)}}
        return self.shown()[name].options

    def hint(self, name: str) -> str:
        """The text in an empty field: the value that holds then, or an example."""
        key = self.shown()[name].key
        is_amount = key is not None and isinstance(key.mark, Unit) and key.mark.scale
        if key is None or (is_amount and not key.default and self.values["given"] == "moes"):
            return ""
        return f"such as {_written(key.example)}" if key.default in ("", NEEDED) else _written(key.default)

    def shown(self) -> dict[str, Field]:
        """The fields that the choices so far leave to be filled in, by name.  Those that are new get their values."""
        choices = {self.values[name] for name in CHOICES}
        choices |= {OWN if self.values["lubricant.oil"] == OWN else NAMED, ROUND if self.is_round else ELLIPTIC}
        found: dict[str, Field] = {}
        for name, field in FIELDS.items():
            if not choices.issuperset(field.when.split()):
                continue
            found[name] = field
            table = name.rpartition(".")[0] or name
            for key in _keys_opened(name, self.values[name]):
                value = None if key.default == NEEDED or key.name in ONE_OF else OPTIONAL
                found[f"{table}.{key.name}"] = _completed(Field(field.group, value=value), "", key)
        self.values = {name: field.value or "" for name, field in found.items()} | self.values
        return found

    def data(self) -> dict[str, Any]:
        """The case as plain data, as a case file has it; what is left empty is left out."""
        data: dict[str, Any] = {}
        for name in self.shown():
            *place, key = name.split(".")
            text, table = self.values[name].strip(), data
            if name in SECTIONS and text:
                data[name] = {}
            elif place and text not in ("", OWN):
                for part in place:
                    table = table.setdefault(part, {})
                table |= apply_overrides({}, [f"{key}={text}"])
        return data | {"roughness": [data["roughness"]]} if "roughness" in data else data

    def field_of(self, message: str) -> str | None:
        """The shown field that a message of ertel names first, contact.radius = ...; None where there is none."""
        place = re.sub(r"\[\d+\]", "", re.split(r"[ :,]", message)[0])  # roughness[1].amplitude, layer[1][2]
        return next((name for name in (place, f"{place}.law", f"{place}.shape") if name in self.shown()), None)


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
