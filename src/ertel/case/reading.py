"""The one reader of plain data: from the content of a case file, or of a stored case, to records.

It reads the annotations of the fields.  `records` writes what it reads.  Every message names the place, the value as
it is written, and what is allowed.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from difflib import get_close_matches
from math import inf
from os import fstat
from pathlib import Path
from typing import Any, TypeVar

from ertel.case import records
from ertel.case.height_map import NO_MAPS, HeightMap
from ertel.case.records import ConfigError, check_value, is_number, named, refusing, shortened, show
from ertel.case.sections import SECTIONS
from ertel.physics.asperities import AsperityLaw
from ertel.physics.fluidity import Fluidity
from ertel.physics.lubricant import Density, Viscosity
from ertel.physics.motion import Oscillation, Polyline, Signal, Smooth, constant
from ertel.physics.registry import ASPERITY_LAWS, OIL_LAWS, SHAPES
from ertel.physics.surfaces import Feature
from ertel.physics.units import FINITE, MUST_BE_GIVEN, Amount, Bounds, Field, Mark, Quantity, Unit, fields_of

T = TypeVar("T")
Data = Mapping[str, Any]
UTF_16 = b"\xff\xfe", b"\xfe\xff"  # marks of the order of its bytes
MOST_POINTS = 10_000  # of a signal or a table: more take longer to read than to solve
SIGNAL_TEXT = "a number, an array of [T, value], or a table { smooth } or { mean, amplitude, period, phase }"
LAWS = {Viscosity: OIL_LAWS["viscosity"], Density: OIL_LAWS["density"], Fluidity: OIL_LAWS["rheology"]}
LAWS[AsperityLaw] = ASPERITY_LAWS
UNBOUNDED = {int: Bounds(whole=True, most=inf), float: Bounds(most=inf)}  # numbers of laws of one's own, without a mark
THINNING = 'shear thinning is written lubricant.rheology = { law = "ree-eyring", tau0 = "5 MPa" }'
LINE = "a line contact is that of a length: give contact.length, or radius_ratio = 0 without dimensions"
NOT_THERE = {  # keys and names that a tribologist may try and that ertel does not support, with an explanation
    **dict.fromkeys(("line", "line contact"), LINE),
    **dict.fromkeys(("line_load", "load_per_length"), "give load, that on the whole length, and length"),
    "ellipticity": "give radius_ratio = R_x/R_y, or the radii radius_x and radius_y",
    "tau0": THINNING,
    "eyring": THINNING,
    "carreau": THINNING,
    "friction": "every run has its friction; there is nothing to give",
    "spin": "ertel does not know spin; the surfaces move along x",
    "beta": "the data for temperatures are in the section [thermal]",
    "starvation": "give the thickness of the oil on the surfaces, lubricant.layer",
}


def quantity_in_si(value: object, unit: Unit) -> float:
    """A quantity as `records` writes it, a number and the SI unit; or a number in this unit."""
    if is_number(value):
        return float(value)  # type: ignore[arg-type]
    number, _, written = str(value).partition(" ")
    if written == unit.unit:
        with suppress(ValueError):
            return float(number)
    raise ValueError(f"must be a number and the unit {unit.unit}")


def parse_number(value: Any, bounds: Bounds) -> float:
    """A plain number within bounds; an int stays an int if the number must be whole."""
    check_value(value, bounds)
    return value if bounds.whole else float(value)


def regular_content(path: Path, most: int) -> bytes:
    """The content of a regular file (a pipe may never end).  Raises ValueError, without the name of the file."""
    size, content = -1, b""
    try:
        if path.is_file() or not path.exists():
            with path.open("rb") as file:
                size = fstat(file.fileno()).st_size
                content = file.read(size) if size <= most else b""
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        where = "" if path.is_absolute() else f" in {shortened(str(path.parent.absolute()))}"
        raise ValueError(f"cannot be read{where}, {reason}") from error
    if size < 0:
        raise ValueError("is not a regular file")
    if size > most:
        raise ValueError(f"is too large; must have at most {most / 1e6:g} MB")
    return content


def decoded(content: bytes) -> str:
    """A text in UTF-8, UTF-16 or Latin-1.  Raises ValueError, without the name of the file, for other data."""
    codings, zeros = ("utf-16-be", "utf-16-le"), [content[parity:2000:2].count(0) for parity in (0, 1)]
    wide = "utf-16" if content[:2] in UTF_16 else codings[zeros[1] > zeros[0]] if any(zeros) else ""
    try:
        text = content.decode(wide or "utf-8-sig")
    except UnicodeDecodeError:
        text = "\0" if wide else content.decode("latin-1")
    if "\0" in text or content.startswith(b"PK\3\4"):
        raise ValueError("is not a text; export it as one, such as CSV")
    return text


def check_keys(
    table: Mapping[str, Any], allowed: Sequence[str], place: str = "", elsewhere: Callable[[str], Any] = lambda _: ()
) -> None:
    """Raise ConfigError, with a hint, for a key that is not allowed.

    place: the section, empty for the file itself.  elsewhere: gives the places in which a key of that name is allowed.
    """
    for name, value in table.items():
        if name not in allowed:
            where = f"{place}.{records.show_key(name)}" if place else records.show_key(name)
            hint = hint_for(str(name), allowed, elsewhere(name))
            raise ConfigError(f"{where} = {show(value)}: unknown key; {hint}")


def hint_for(name: str, known: Sequence[str], elsewhere: Sequence[str] = ()) -> str:
    """A hint for a name that is not known: what may be meant, here or elsewhere, and what is allowed."""
    if name in NOT_THERE:
        return NOT_THERE[name]
    close = elsewhere or get_close_matches(name, known, n=1)
    return (f"did you mean {records.alternatives(close)}? " if close else "") + f"allowed: {', '.join(known)}"


@dataclass(frozen=True)
class Reader:
    """A reader of records.

    Parameters
    ----------
    quantity : callable
        Reads a quantity (its value and unit as it is written, and the unit of its field) as a number in SI; raises
        ValueError for anything else.
    maps : mapping
        Measured heights by the names that stand for them.
    named : mapping
        Further keys by record, those of names that are resolved before the data are read; for messages.
    """

    quantity: Callable[[object, Unit], float] = quantity_in_si
    maps: Mapping[str, HeightMap] = field(default_factory=lambda: NO_MAPS)
    named: Mapping[Any, tuple[str, ...]] = field(default_factory=dict)

    def record(self, record: Callable[..., T], data: Any, place: str, also: tuple[str, ...] = ()) -> T:
        """A record from plain data.

        Parameters
        ----------
        record : type
            A dataclass whose annotations say how its fields are written.
        data : mapping
            Plain data; a key whose value is None is left out.
        place : str
            Its section, for messages.
        also : tuple of str
            Keys of the data that belong to no field.

        Raises
        ------
        ValueError
            At the first error.
        """
        if not isinstance(data, Mapping):
            raise ConfigError(f"{place} = {show(data)}: must be a {'table' if '.' in place else f'section, [{place}]'}")
        known = fields_of(record)
        if not data.keys() <= {*known, *also}:
            check_keys(data, (*self.keys(record), *also), place, self.full_names)
        values = self.values(record, data, place)
        for name, each in known.items():
            if name not in values and each.usual is MUST_BE_GIVEN:
                raise ConfigError(f"{place}.{name}: missing")
        return named(place, record, **values)

    def keys(self, record: Any) -> tuple[str, ...]:
        """The keys of a record (a class), those of names first."""
        return *self.named.get(record, ()), *fields_of(record)

    def full_names(self, key: str) -> list[str]:
        """SECTION.KEY for each section that has a key of this name."""
        return [f"{name}.{key}" for name, section in SECTIONS.items() if key in self.keys(section.record)]

    def values(self, record: Any, data: Data, place: str) -> dict[str, Any]:
        """The values of those fields of a record (a class) that the data give."""
        given = {name: each for name, each in fields_of(record).items() if data.get(name) is not None}
        return {name: self._value(data[name], each, f"{place}.{name}") for name, each in given.items()}

    def _value(self, value: Any, of: Field, place: str) -> Any:
        """The value of a field."""
        options, mark, names = of.options, of.mark, of.choices
        if any(type(value) is type(name) and value == name for name in names):
            return value
        with refusing(place, value):
            if law := next((option for option in options if option in LAWS), None):
                return self.law(value, law, place, by_name=str in options)
            if Signal in options and not (float in options and is_number(value)):
                return self.signal(value, place)
            if (line := records.points_in(options)) and (float not in options or isinstance(value, list | tuple)):
                return self.polyline(line, value, place)
            return self._plain_value(value, options, mark, names)

    def _plain_value(self, value: Any, options: Sequence[Any], mark: Mark | None, names: Sequence[str]) -> Any:
        if isinstance(value, list) and Ellipsis not in options:
            raise ValueError("must be one value; a list of values makes a study (ertel sweep)")
        if isinstance(mark, Unit):
            try:
                return self.amount(value, mark) if mark.scale else self.quantity(value, mark)
            except ValueError as error:
                raise ValueError(f"{error}{''.join(f', or {show(name)}' for name in names)}") from error
        if names:
            allowed = f"allowed: {records.alternatives(map(repr, names))}"
            raise ValueError(f"{NOT_THERE[value]}; {allowed}" if value == "line" else allowed)
        if HeightMap in options:
            if not isinstance(value, str):
                raise ValueError("must be a string")
            if value not in self.maps:
                raise ValueError("its heights are not given with the case")
            return self.maps[value]
        for kind, text in ((bool, "true or false"), (str, "a string")):
            if kind in options:
                if not isinstance(value, kind):
                    raise ValueError(f"must be {text}")
                return value
        if Ellipsis in options:  # numbers of a law with a table
            if not isinstance(value, list | tuple):
                raise ValueError("must be an array")
            return tuple(self._plain_value(item, options[:1], None, ()) for item in value)
        return parse_number(value, mark or UNBOUNDED[int if int in options else float])

    def amount(self, value: object, unit: Unit) -> Amount:
        """A number in the units of the case, or a quantity in SI."""
        if isinstance(value, str):
            return Quantity(self.quantity(value, unit.in_si), unit.unit)
        check_value(value, unit)
        return value if isinstance(value, Quantity) else float(value)  # type: ignore[arg-type]

    def signal(self, data: Any, place: str) -> Signal:
        """A signal from a number, a list of [T, value], or a table { smooth } or { mean, amplitude, period, phase }."""
        if isinstance(data, Mapping) and [*data] == ["smooth"]:
            with refusing(f"{place}.smooth", data["smooth"]):
                return self.polyline(Smooth, data["smooth"], f"{place}.smooth")
        if isinstance(data, Mapping):
            return self.record(Oscillation, data, place)
        if is_number(data):
            return constant(parse_number(data, FINITE))
        if not isinstance(data, list | tuple) or not data:
            raise ValueError(f"must be {SIGNAL_TEXT}")
        return self.polyline(Polyline, data, place)

    def polyline(self, kind: type[Polyline], data: Any, place: str) -> Polyline:
        """A signal, a track or a table from its points."""
        (x, value), points = kind.NAMES, []
        if not isinstance(data, list | tuple):
            raise ValueError(f"must be an array of [{x}, {value}]")
        if len(data) > MOST_POINTS:
            raise ValueError(f"has {len(data)} points; at most {MOST_POINTS}")
        for number, point in enumerate(data, 1):
            where = f"{place}[{number}]"
            with refusing(where, point):
                if not isinstance(point, list | tuple) or len(point) != 2:
                    raise ValueError(f"must be [{x}, {value}]")
            parts = enumerate(zip(point, kind.MARKS, strict=True), 1)
            points.append(tuple(self._value(part, Field(x, float, mark), f"{where}[{i}]") for i, (part, mark) in parts))
        return kind(tuple(points))

    def law(self, data: Any, kind: Any, place: str, by_name: bool = True) -> Any:
        """A law from a table with its name under `law`; or its name, if its data are those of the oil.

        kind: its protocol.  by_name: whether a name will do; without it the law is inside of another one.
        """
        if by_name and isinstance(data, str):
            return data  # the oil knows which names will do
        laws: Mapping[str, Any] = LAWS[kind] if by_name else records.inner_laws(LAWS[kind])
        if not isinstance(data, Mapping):
            name = "a name, or " if by_name else ""
            raise ValueError(f"must be {name}a table with a law and its data")
        law = laws[_known(data, "law", laws, place)]
        return self.record(law, data, place, ("law",))

    def feature(self, data: Any, place: str) -> Feature:
        """A feature, its shape by a registered name."""
        if not isinstance(data, Mapping):
            raise ConfigError(f"{place} = {show(data)}: must be a table with a shape; allowed: {', '.join(SHAPES)}")
        shape: Any = SHAPES[_known(data, "shape", SHAPES, place)]
        surface = data.get("surface", 1)
        if type(surface) is not int or surface not in (1, 2):
            raise ConfigError(f"{place}.surface = {show(surface)}: allowed: 1 or 2")
        return Feature(self.record(shape, data, place, ("shape", "surface")), surface)  # type: ignore[arg-type]


def _known(data: Data, key: str, records: Mapping[str, Any], place: str) -> str:
    """The name of a record under a key."""
    name = data.get(key)
    if isinstance(name, str) and name in records:
        return name
    written = ": missing" if name is None else f" = {show(name)}"
    raise ConfigError(f"{place}.{key}{written}; allowed: {', '.join(records)}")
