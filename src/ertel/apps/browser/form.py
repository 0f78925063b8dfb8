"""A new case: the fields that a user fills in, the case that they make, and ertel's answer before it is run.

A field is a key of case files, from which it has its meaning, unit and default, or a choice that opens others.  The
values go to ertel as they are written, so that its own messages answer them: a quantity has its unit, "10 mm".  A case
that is there already is shown in the same fields, and what they do not have in further ones.
"""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from ertel.apps.browser.folder import Folder
from ertel.apps.terminal import capital
from ertel.case.conditions import RADII
from ertel.case.methods import METHODS, NEW, Method, Supports, of_kind
from ertel.case.records import inner_laws, show
from ertel.case.sections import SECTIONS
from ertel.inputs import materials, oils
from ertel.inputs.case_files import apply_overrides, parse_case
from ertel.inputs.layout import NEEDED, TOP, DataSheet, Key, keys_of, section, shape_keys, shape_place
from ertel.inputs.quantities import parse_quantity, split
from ertel.inputs.templates import OIL
from ertel.physics.geometry import geometry
from ertel.physics.registry import SHAPES, Registry
from ertel.physics.units import Meaning, Unit
from ertel.results.numbers import differences
from ertel.results.variables import in_celsius, with_prefix
from ertel.runs.outlook import outlook

OWN, SHEET, NAMED = "own", "sheet", "named"  # oils: by values and by data sheet, in place of a name; from the library
ROUND, ELLIPTIC, CYLINDERS = "round", "elliptic", "cylinders"
# which open the keys of their tables
SHAPE, LAW, ASPERITIES = "roughness.shape", "lubricant.rheology.law", "surfaces.asperities.law"
NO_LAW = {LAW: "none, or that of a named oil", ASPERITIES: "do not touch"}
MATERIALS = {name: name for name in ("steel", *materials.names())}
OPTIONS: Mapping[str, Mapping[str, str]] = {  # with their labels, the first one first
    "contact.kind": {"impact": "Impact", "rolling": "Rolling"},
    "given": {"si": "Quantities", "moes": "M and L"},
    "bodies": {"ball": "ball on a plane", "balls": "two balls", "ellipse": "ellipse", "four-radii": "four radii"}
    | {CYLINDERS: "cylinders, on a line"},
    "impact_by": {"by-speed": "its speed", "by-height": "the height of its fall"},
    "contact.material_1": MATERIALS,
    "contact.material_2": MATERIALS,
    "lubricant.oil": {OWN: "by its viscosity", SHEET: "by its data sheet", **{name: name for name in oils.names()}},
    "thermal": {"": "not computed", "warm": "computed"},
    SHAPE: {"": "smooth", **{shape: shape for shape in SHAPES}},
    "time.until": {"max-approach": "maximum approach", "rebound": "rebound"},
}
BODIES = dict(zip(OPTIONS["bodies"], (*RADII, ("radius", "length")), strict=True))  # their keys in [contact]
CHOICES = ("contact.kind", "given", "bodies", "impact_by", "solver.method", "thermal")  # whose values show other fields
# groups that are open when one is used
FOLDED = ("Layer of oil, for a starved contact", "Temperatures", "Roughness", "Surfaces that touch")
LAYER, HEAT, ROUGHNESS, TOUCH = FOLDED
FURTHER, MOST_FURTHER = "Further keys of this case", 100
UNNAMED = ("schema", "name")  # keys that are none of the form: the run has a name of its own
ROUGH = ("sigma", "sigma_1", "sigma_2", "boundary_friction", "hardness")
ROWS = (  # group, the choices that show its fields, and these by their paths in case files, or as choices of the form
    ("", "", "contact.kind given"),
    ("Contact", "moes", "contact.M contact.L contact.radius_ratio contact.length_ratio"),
    ("Contact", "si", "bodies"),
    *(("Contact", f"si {bodies}", " ".join(f"contact.{key}" for key in keys)) for bodies, keys in BODIES.items()),
    ("Contact", "rolling elliptic", "contact.entrainment_angle"),
    ("Contact", "si impact round", "contact.ball_density"),
    *(("Contact", f"si impact {bodies}", "contact.mass") for bodies in (ELLIPTIC, CYLINDERS)),
    ("Contact", "si impact", "impact_by"),
    ("Contact", "si impact by-speed", "contact.speed"),
    ("Contact", "si impact by-height", "contact.drop_height"),
    ("Contact", "si rolling", "contact.load contact.mean_speed contact.slide_to_roll"),
    ("Contact", "moes rolling", "motion.slide_to_roll"),
    ("Materials", "si", "contact.material_1 contact.material_2"),
    ("Oil", "si", "lubricant.oil"),
    ("Oil", f"si {NAMED}", "lubricant.temperature"),
    ("Oil", f"si {OWN}", "lubricant.eta0 lubricant.alpha"),
    ("Oil", "si rolling", LAW),
    (LAYER, "", "lubricant.layer lubricant.layer_1 lubricant.layer_2"),
    (HEAT, "si heated", "thermal"),
    (ROUGHNESS, "", SHAPE),
    (TOUCH, "si", f"surfaces.{' surfaces.'.join(ROUGH)} {ASPERITIES}"),
    ("Computation", "", "solver.method solver.nodes"),
    ("Computation", "impact", "time.until"),
)
LABELS = {
    "eta0": "Viscosity", "alpha": "Pressure-viscosity coefficient", LAW: "Shear thinning", "sigma": "Rms roughness",
    "sigma_1": "Rms roughness of surface 1", "sigma_2": "Rms roughness of surface 2", ASPERITIES: "Asperities",
}  # fmt: skip
NAME_FILES = ("file", "oils", "case")  # keys of surfaces and measurements, of oils of one's own, of a fit
# at first, of the rows
EMPTY = ("radius_ratio", "length_ratio", "entrainment_angle", "slide_to_roll", "layer", "layer_1", "layer_2", *ROUGH)
ONE_OF = ("wavelength_x", "depth")  # keys of shapes that are filled at first besides those that are needed
KEYS = {f"{name}.{key.name}": key for name in SECTIONS for key in section(name).keys} | {
    LAW: next(key for key in section("lubricant").keys if key.name == "rheology"),
    "thermal": Key("thermal", None, meaning=Meaning(SECTIONS["thermal"].text)),
    ASPERITIES: next(key for key in section("surfaces").keys if key.name == "asperities"),
    SHAPE: replace(shape_keys()[0], meaning=TOP["roughness"]),
}


def decides(name: str) -> bool:
    """Whether other fields depend on the value of a field."""
    return name in (*CHOICES, "lubricant.oil", SHAPE) or name.endswith(".law")


class Field(NamedTuple):
    """A field that is shown.

    group: of fields on the page.  value: the first one.  options: the values with their labels; empty for a text.  key:
    None for a choice that is not in case files.
    """

    group: str
    label: str
    value: str
    options: Mapping[str, str] | None
    key: Key | None

    @property
    def help(self) -> str:
        """Name, kind of value, default and meaning, as `ertel run --help-keys` says them."""
        if self.key is None:
            return ""
        return f"{self.key.title}: {self.key.meaning.text}" if self.key.hint else self.key.meaning.text


def _field(group: str, name: str, key: Key | None, is_filled: bool, is_opened: bool = False) -> Field:
    """The field of a key of case files, or of a choice.  is_opened: by a law or a data sheet: named by its meaning."""
    last = name.rpartition(".")[2]
    said = key.meaning.text if key and is_opened else last.replace("_", " ")
    label = LABELS.get(name) or (not is_opened and LABELS.get(last)) or capital(re.split("[,;:]", said)[0])
    options, value = OPTIONS.get(name), ""
    if key and key.law and name.endswith(".law"):
        options = _laws(name, key.law)
    elif key and key.choices and not options:
        options = {"": f"usual, {_typed(key.default)}", **{str(choice): str(choice) for choice in key.choices}}
    if key and is_filled:
        value = OIL.get(last) or _example(key)
    return Field(group, label, next(iter(options)) if options else value, options, key)


def _laws(name: str, laws: Registry) -> Mapping[str, str]:
    """The laws of a field with their labels; only those that stand alone where it is a part of another law."""
    known = laws if name in NO_LAW else inner_laws(laws)
    none = {"": NO_LAW[name]} if name in NO_LAW else {}
    return none | {law: getattr(known[law], "title", law.title()) for law in known}


def _typed(written: str) -> str:
    """A value of a case file as it is typed here."""
    return written.strip('"')


def _example(key: Key) -> str:
    """An example as it is typed here, with a unit where there is one."""
    if isinstance(key.mark, Unit) and not isinstance(key.meaning.example, str):
        return key.mark.example
    return _typed(key.example)


def _readable(written: str, key: Key | None) -> str:
    """A value as it is typed here: "5000000.0 Pa" is "5 MPa", where that is the very same number."""
    number, unit = split(written)
    if key and isinstance(key.mark, Unit) and unit == key.mark.unit:
        short = with_prefix(*in_celsius(float(number), unit))
        with suppress(ValueError):
            return short if parse_quantity(short, key.mark) == parse_quantity(written, key.mark) else written
    return written


def _keys_opened(name: str, key: Key | None, value: str) -> Sequence[Key]:
    """The keys of the table that a choice opens: of a shape, a law, a data sheet, or a section that may be left out."""
    if name == SHAPE and value in SHAPES:
        return (*shape_place(value).keys, *shape_keys()[1:])
    if key and key.law and value in key.law and name.endswith(".law"):
        return keys_of(key.law[value])
    if value == SHEET:
        return keys_of(DataSheet)
    return section(name).keys if name in SECTIONS and value else ()


def _values_in(data: Mapping[str, Any], place: str = "") -> Iterator[tuple[str, str]]:
    """The values of a case as they are written, by the names of their fields."""
    for key, value in data.items():
        name = f"{place}{key}"
        if isinstance(value, list) and len(value) == 1 and isinstance(value[0], Mapping):
            [value] = value  # the roughness
        if isinstance(value, Mapping):
            yield from _values_in(value, f"{name}.")
        elif name not in UNNAMED:
            yield f"{name}.law" if f"{name}.law" in KEYS else name, _typed(show(value))


class Form:
    """The fields of the form.  values: all as text, by the names of the fields."""

    def __init__(self) -> None:
        self.values = {name: next(iter(options)) for name, options in OPTIONS.items()}
        self._further: Sequence[str] = ()
        self.choose("contact.kind", self.values["contact.kind"])

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> "Form":
        """The form of a case as plain data.  Raises ValueError where it has no fields for a key: a second roughness."""
        form, known = cls(), dict(_values_in(data))
        keys = {*known}
        bodies = [name for name, radii in BODIES.items() if keys >= {f"contact.{radius}" for radius in radii}]
        kind: Any = known.get("contact.kind", "impact")
        known = {"solver.method": of_kind(kind)[0].name} | known if kind in OPTIONS["contact.kind"] else {}
        if known.get("solver.method") not in METHODS:
            raise ValueError("the form needs a kind of contact and a method that there are; see the answer to the text")
        given = {
            **dict.fromkeys(OPTIONS, ""),
            "contact.kind": kind,
            "given": "moes" if "contact.M" in keys else "si",
            "bodies": bodies[-1] if bodies else "ball",
            "impact_by": "by-height" if "contact.drop_height" in keys else "by-speed",
            "lubricant.oil": SHEET if "lubricant.oil.nu40" in keys else OWN,
            "thermal": "warm" if "thermal" in data else "",
            **known,
        }
        form.values = {**given}  # from here on new fields would begin with examples
        shown = form.shown()
        form.values = dict.fromkeys(shown, "") | given
        form._further = [name for name in known if name not in shown]
        if len(form._further) > MOST_FURTHER:
            raise ValueError(f"{len(form._further)} keys have no field of their own; this case stays a text")
        other = [each["field"] for each in differences(data, form.data())]
        if left := [name for name in other if name not in (*UNNAMED, "solver.method")]:
            raise ValueError(f"the form has no field for {left[0]}; this case stays a text")
        form.values |= {name: _readable(form.values[name], field.key) for name, field in form.shown().items()}
        return form

    @property
    def shape(self) -> str:
        """The shape of the contact of the bodies: `ROUND`, `ELLIPTIC` or that of `CYLINDERS`."""
        return {"ball": ROUND, "balls": ROUND, CYLINDERS: CYLINDERS}.get(self.values["bodies"], ELLIPTIC)

    @property
    def method(self) -> Method:
        """The method that is chosen."""
        return self._suited(METHODS[self.values["solver.method"]])

    def _suited(self, method: Method) -> Method:
        return method.of(geometry(0.0 if self.shape == CYLINDERS else 1.0))

    def _is_able(self, supports: Supports) -> bool:
        able = (supports.roughness or not self.values[SHAPE]) and (supports.touch or not self.values.get(ASPERITIES))
        return able and (supports.ellipse or self.shape == ROUND)

    def choose(self, name: str, value: str) -> None:
        """Change a field.  With what is chosen the methods change that suit it, with these and the bodies the grid."""
        self.values[name] = value
        methods = [method.name for method in self.methods]
        if self.values.get("solver.method") not in methods:
            self.choose("solver.method", methods[0])
        elif name in ("solver.method", "bodies"):
            self.choose("solver.nodes", str(self.method.new_nodes) if self.shape != ELLIPTIC else "")

    @property
    def methods(self) -> Sequence[Method]:
        """The methods that suit what is chosen, the usual one first."""
        kind: Any = self.values["contact.kind"]
        able = of_kind(kind, lambda method: self._is_able(method.supports))
        return sorted(able, key=lambda method: method is not NEW[kind])

    def options(self, name: str) -> Mapping[str, str]:
        """The values from which a field is chosen, with their labels; empty for a text."""
        known = self.shown()[name].options or {}
        if name == "solver.method":
            known = {method.name: self._suited(method).title for method in self.methods}
        value = self.values[name]
        return {**known, value: value or "not given"} if known and value not in known else known

    def hint(self, name: str) -> str:
        """The text in an empty field: the value that holds then, or an example."""
        key = self.shown()[name].key
        is_amount = key is not None and isinstance(key.mark, Unit) and key.mark.scale
        if key is None or (is_amount and not key.default and self.values["given"] == "moes"):
            return ""
        return f"such as {_example(key)}" if key.default in ("", NEEDED) else _typed(key.default)

    def shown(self) -> dict[str, Field]:
        """The fields that the choices so far leave to be filled in, by name.  Those that are new get their values."""
        choices = {self.values[name] for name in CHOICES}
        choices |= {"heated"} if self.method.supports.thermal else set()
        choices |= {OWN if self.values["lubricant.oil"] == OWN else NAMED, self.shape}
        found: dict[str, Field] = {}
        for group, when, names in ROWS:
            for name in names.split() if choices.issuperset(when.split()) else ():
                key, is_filled = KEYS.get(name), name.rpartition(".")[2] not in EMPTY
                found |= self._fields_of(name, key, _field(group, name, key, is_filled))
        for name in self._further:
            about = _field(FURTHER, name, KEYS.get(name), is_filled=False)
            found.setdefault(name, about._replace(label=capital(re.sub(r"[._]", " ", name))))
        self.values = {name: field.value for name, field in found.items()} | self.values
        return found

    def _fields_of(self, name: str, key: Key | None, field: Field) -> Iterator[tuple[str, Field]]:
        """A field, and those of the table that its value opens."""
        yield name, field
        table = name.removesuffix(".law").removesuffix(".shape")
        for inner in _keys_opened(name, key, self.values.get(name, "")):
            path, is_filled = f"{table}.{inner.name}", inner.default == NEEDED or inner.name in ONE_OF
            path += ".law" if inner.law else ""
            is_named = name != SHAPE and name not in SECTIONS
            yield from self._fields_of(path, inner, _field(field.group, path, inner, is_filled, is_named))

    def data(self) -> dict[str, Any]:
        """The case as plain data, as a case file has it; what is left empty is left out."""
        data: dict[str, Any] = {}
        shown = self.shown()
        for name in shown:
            *place, key = name.split(".")
            text, table = self.values[name].strip(), data
            if name in SECTIONS and text:
                data[name] = {}
            elif place and text not in ("", OWN, SHEET):
                for part in place:
                    table = table.setdefault(part, {})
                table |= apply_overrides({}, [f"{key}={text}"])
        for name, about in shown.items():
            section, _, key = name.removesuffix(".law").partition(".")
            law = data.get(section, {}).get(key)
            if about.key and about.key.law and str in about.key.options and isinstance(law, dict) and len(law) == 1:
                data[section][key] = law["law"]  # its name alone
        return data | {"roughness": [data["roughness"]]} if "roughness" in data else data

    def field_of(self, message: str) -> str | None:
        """The shown field that a message of ertel names first, contact.radius = ...; None where there is none."""
        place = re.sub(r"\[\d+\]", "", re.split(r"[ :,]", message)[0])  # roughness[1].amplitude, layer[1][2]
        return next((name for name in (place, f"{place}.law", f"{place}.shape") if name in self.shown()), None)


# -- the answer of ertel -----------------------------------------------------------------------------------------------


def outlook_of(data: Mapping[str, Any], folder: Folder) -> dict[str, Any]:
    """The answer of `ertel check` to a case.  Raises ConfigError, and Outside for files outside the folder."""
    require_inside(data, folder, folder.root)
    return outlook(parse_case(data, folder.root))


def require_inside(data: Mapping[str, Any], folder: Folder, place: Path) -> None:
    """Refuse a case or a study that names files outside of the folder, from a place in it.  Raises Outside."""
    for table, key in with_files(data):
        for name in table[key] if isinstance(table[key], list) else [table[key]]:
            folder.inside(str(place / str(name)))


def relocated(data: Mapping[str, Any], before: Path, now: Path) -> dict[str, Any]:
    """The plain data of a case whose files were named relative to one folder: now relative to another."""
    moved = deepcopy(dict(data))
    for table, key in with_files(moved):
        if isinstance(table[key], str):
            table[key] = os.path.relpath(os.path.realpath(before / table[key]), now)
    return moved


def with_files(data: Any) -> Iterator[tuple[dict[str, Any], str]]:
    """The tables of a case, a study or a fit that name a file or a list of files, each with its key."""
    for key, value in data.items():
        if key in NAME_FILES and isinstance(value, str | list):
            yield data, key
        for table in value if isinstance(value, list) else [value]:
            if isinstance(table, dict):
                yield from with_files(table)
