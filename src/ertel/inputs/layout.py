"""The layout of case files: all sections and keys, read off the records of a case.

The table of keys, `--help-keys`, new case files and the JSON schema are printed from `places`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from inspect import getdoc
from math import isfinite
from typing import Annotated, Any, Literal, NamedTuple, get_args

from ertel.case.conditions import Conditions, Kind
from ertel.case.height_map import HeightMap, Measured
from ertel.case.methods import METHODS, of_kind
from ertel.case.reading import LAWS, Reader
from ertel.case.records import points_in, show
from ertel.case.sections import SECTIONS, START_APPROACH, Drive, Solver, Thermal, Time
from ertel.inputs.quantities import number_or_quantity, parse_quantity
from ertel.physics import units
from ertel.physics.cams import Cam
from ertel.physics.gears import Gear
from ertel.physics.lubricant import Oil
from ertel.physics.motion import Oscillation, Signal, Track
from ertel.physics.registry import ASPERITY_LAWS, OIL_LAWS, SHAPES, Registry
from ertel.physics.units import MUST_BE_GIVEN, Amount, Field, Meaning, Unit, fields_of

# -- keys that name an oil, a material or a file; `names` and `height_maps` replace them by numbers -------------------


@dataclass(frozen=True)
class Materials:
    """The materials of both bodies, in [contact]."""

    material_1: Annotated[
        str | None, Meaning("material of body 1, in an impact the ball; ertel oils lists the names", "steel")
    ] = None
    material_2: Annotated[str | None, Meaning("material of body 2", "glass")] = None


@dataclass(frozen=True)
class DataSheet:
    """An oil by its data sheet, in [lubricant]."""

    nu40: Annotated[float, units.KINEMATIC_VISCOSITY, Meaning("kinematic viscosity at 40 degC")]
    nu100: Annotated[float, units.KINEMATIC_VISCOSITY, Meaning("kinematic viscosity at 100 degC", "8.7 mm^2/s")]
    density: Annotated[float, units.DENSITY, Meaning("density at 15 degC", "880 kg/m^3")]
    expansion: Annotated[float | None, units.EXPANSION, Meaning("thermal expansion coefficient")] = None
    alpha: Annotated[float | None, units.COMPLIANCE, Meaning("pressure-viscosity coefficient, at all temperatures")] = (
        None
    )
    reference: Annotated[str, Meaning("source of the data", "data sheet of the oil")] = ""


@dataclass(frozen=True)
class NamedLubricant:
    """An oil by its name or its data sheet, in [lubricant]; keys that are given as well win over its data."""

    oil: Annotated[
        str | DataSheet | None,
        Meaning("name of an oil, ertel oils lists them, or a table with its data sheet", "squalane"),
    ] = None
    temperature: Annotated[float | None, units.TEMPERATURE, Meaning("temperature of the inlet; goes with oil")] = None
    oils: Annotated[str | None, Meaning("file of own oils, beside the case file; goes with oil", "my_oils.toml")] = None


@dataclass(frozen=True)
class Machines:
    """A part of a machine from which the motion follows, and of [contact] radii, load and speed, in [motion]."""

    gear: Annotated[Gear | None, Meaning("a pair of gears: their teeth meet from the first touch to the last")] = None
    cam: Annotated[Cam | None, Meaning("a cam that lifts a flat-faced follower")] = None


@dataclass(frozen=True)
class MeasuredFile:
    """Keys for reading the file of a measured map or profile, in [[roughness]]."""

    channel: Annotated[
        str | None, Meaning("which of the channels of the file; left out: its first one with heights", "Height")
    ] = None
    unit: Annotated[str | None, Meaning("unit of lengths and heights of a file that does not say it", "um")] = None
    spacing: Annotated[
        Amount | None,
        units.WIDTH,
        Meaning("distance of the points of a file that has no lengths, in place of length_x", "0.5 um"),
    ] = None
    detrend: Annotated[
        Literal["plane", "curvature", "mean", "none"] | None,
        Meaning("form removed from the heights; left out: plane", "curvature"),
    ] = None


# further keys of sections and shapes
NAMING = {Conditions: Materials, Oil: NamedLubricant, Drive: Machines, Measured: MeasuredFile}
TOP: Mapping[str, Meaning] = {  # keys of the file itself
    "name": Meaning("of the run's directory and titles; left out: that of the file", "steel_ball"),
    "schema": Meaning("version of this layout"),
    "roughness": Meaning("shapes on the surfaces, any number of them; their heights are added"),
}
TABLES = (DataSheet, Gear, Cam)  # records that are the value of one key
SURFACE = Meaning("surface on which the shape is and with which it moves")
NEEDED = "needed"


def field_names(record: Any) -> tuple[str, ...]:
    """The names of the fields of a record (a class)."""
    return tuple(fields_of(record))


READER = Reader(parse_quantity, named={record: field_names(further) for record, further in NAMING.items()})
IN_SI = replace(READER, quantity=number_or_quantity)  # of Python: quantities may be numbers in SI


# -- the walk over all keys -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Key(Field):
    """A key of a case file.

    default: as it is written; "" if the meaning says what holds without the key.
    """

    default: str = ""

    @property
    def example(self) -> str:
        """A value as it is written; "" if there is none."""
        if self.meaning.example is not None:
            return show(self.meaning.example)
        if self.default not in ("", NEEDED):
            return self.default
        return show(self.mark.example) if isinstance(self.mark, Unit) else ""

    @property
    def title(self) -> str:
        """Name, kind of value and default."""
        default = f"; default {self.default}" if self.default else ""
        return f"{self.name}  ({self.kind}{'; needed' if self.default == NEEDED else default})"

    @property
    def law(self) -> Registry | None:
        """The laws one of which the value is."""
        return next((LAWS[option] for option in self.options if option in LAWS), None)

    def keys_in(self, table: Mapping[str, Any]) -> tuple["Key", ...]:
        """The keys of a table that is the value: of a signal, a data sheet or a law."""
        if Signal in self.options:
            return keys_of(Oscillation)
        if record := next((record for record in TABLES if record in self.options), None):
            return keys_of(record)
        laws: Mapping[str, Any] = self.law or {}
        law = table.get("law")
        return keys_of(laws[law]) if isinstance(law, str) and law in laws else ()

    @property
    def kind(self) -> str:
        """The kind of a value in words."""
        if isinstance(self.mark, Unit):
            text = f"number ({self.mark.own}) or quantity" if self.mark.scale else "quantity"
            text += ", or [[y, thickness], ...]" * (Track in self.options)
            return ", ".join([*self.choices, text])
        if self.mark is not None and Signal not in self.options:
            return "integer" if self.mark.whole else "number"
        if self.law is not None:
            return f"{', '.join(able_names(self.law))} or table" if str in self.options else "table"
        if self.choices:
            return " or ".join(map(str, self.choices))
        words = {bool: "true or false", float: "number", int: "integer", HeightMap: "name of a file"}
        words |= {DataSheet: "name or table", Gear: "table", Cam: "table"}
        if Signal in self.options:
            return "number, [[T, value], ...] or table"
        if line := points_in(self.options):
            return f"[[{', '.join(line.NAMES)}], ...]"
        return next((words[option] for option in self.options if option in words), "text")


class Place(NamedTuple):
    """A section or a table of a case file: how it begins, what it is about, and its keys."""

    title: str
    text: str
    keys: tuple[Key, ...]


def places() -> Iterator[Place]:
    """All sections and tables of a case file, with the laws and shapes that are registered now."""
    schema = Key("schema", Literal[1], meaning=TOP["schema"], default="1")
    yield Place("(top)", "the case", (Key("name", str, meaning=TOP["name"]), schema))
    for name in SECTIONS:
        if name == "time":
            yield Place("[[roughness]]", TOP["roughness"].text, shape_keys())
            yield from (shape_place(shape) for shape in SHAPES)
        yield section(name)
        if name == "lubricant":
            yield _table("oil = { ... }", DataSheet)
            for field, laws in OIL_LAWS.items():
                for law in laws:
                    if fields(laws[law]):
                        yield _table(f'{field} = {{ law = "{law}" }}', laws[law])
        if name == "surfaces":
            yield from (_table(f'asperities = {{ law = "{law}" }}', ASPERITY_LAWS[law]) for law in ASPERITY_LAWS)
        if name == "motion":
            yield _table("load, entrainment, ... = { ... }", Oscillation)
            yield _table("gear = { ... }", Gear)
            yield _table("cam = { ... }", Cam)


def section(name: str) -> Place:
    """A section."""
    _, record, text = SECTIONS[name]
    return Place(f"[{name}]", text, (*(keys_of(NAMING[record]) if record in NAMING else ()), *keys_of(record)))


def shape_keys() -> tuple[Key, ...]:
    """The keys of all shapes."""
    shapes = Key("shape", Literal[*SHAPES], meaning=Meaning("which shape"), default=NEEDED)
    return shapes, Key("surface", Literal[1, 2], meaning=SURFACE, default="1")


def shape_place(name: str) -> Place:
    """The table of a shape, with the keys that say how its file is read."""
    place, shape = _table(f'shape = "{name}"', SHAPES[name]), SHAPES[name]
    return place._replace(keys=(*place.keys, *keys_of(NAMING[shape]))) if shape in NAMING else place


def _table(title: str, record: Any) -> Place:
    return Place(title, first_paragraph(record).removesuffix("."), keys_of(record))


def first_paragraph(record: Any) -> str:
    """The first paragraph of the docstring of a record, on one line."""
    return " ".join((getdoc(record) or "").partition("\n\n")[0].split())


def keys_of(record: Any) -> tuple[Key, ...]:
    """The keys that stand for the fields of a record (a class)."""
    keys = {name: Key(**vars(field), default=_default(record, field)) for name, field in fields_of(record).items()}
    if record is Solver:
        keys["method"] = replace(keys["method"], hint=Literal[*METHODS])
    return tuple(keys.values())


def able_names(laws: Registry) -> tuple[str, ...]:
    """The names of the laws whose data are those of the oil."""
    return tuple(name for name, law in laws.items() if hasattr(law, "of"))


def _default(record: Any, field: Field) -> str:
    """The value that holds where the key is left out, as it is written."""
    name, value, example = field.name, field.usual, field.meaning.example
    if record is Solver:
        return _by_owner({method.name: getattr(method.defaults, name) for method in METHODS.values()}, name)
    if record is Time and name in ("start_approach", "until"):
        ends = {method.kind: method.end for method in METHODS.values() if not method.is_steady}
        return show(START_APPROACH) if name == "start_approach" else _by_owner(ends, name)
    if value is MUST_BE_GIVEN:
        return "" if record is Thermal else NEEDED  # a named oil and named materials complete it
    if value in (None, "", ()) or (isinstance(value, float) and not isfinite(value)):
        return ""
    return show(example) if isinstance(field.mark, Unit) and isinstance(example, str) else show(value)


def _by_owner(values: Mapping[Any, Any], name: str) -> str:
    """Defaults that differ between methods or kinds of contact, each with those that have it."""
    if name == "method":
        return ", ".join(f'"{of_kind(kind)[0].name}" ({kind})' for kind in get_args(Kind))
    groups: dict[str, list[str]] = {}
    for owner, value in values.items():
        if value is not None:
            groups.setdefault(show(value), []).append(str(owner))
    if len(groups) == 1 and len(next(iter(groups.values()))) == len(values):
        return next(iter(groups))
    return ", ".join(f"{value} ({', '.join(owners)})" for value, owners in groups.items())
