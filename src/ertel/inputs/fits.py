"""Fits: the numbers of a case that are to be found from measurements, and the file that says so.

    case = "ball.toml"                          # beside this file
    laws = ["roelands", "barus"]                # of viscosity: a fit under each; may be left out

    [unknowns]
    "lubricant.eta0" = { bounds = ["5 mPa*s", "1 Pa*s"] }
    "lubricant.alpha" = { bounds = ["5 / GPa", "60 / GPa"], prior = ["22 / GPa", "2 / GPa"] }

    [[measurements]]
    file = "film.csv"                           # and what else `Measurement.read` takes
    at = "max-approach"

    [[measurements]]
    quantity = "restitution"                    # one number, or a list of them
    value = [0.87, 0.83]
    sigma = 0.01
    set = { "contact.drop_height" = ["10 mm", "20 mm"] }    # where the conditions differ from those of the case

An unknown is any positive number of a case, with its bounds, and a prior where something is known already: a value and
its standard deviation.  It is a number of the case as it is stored, in which the oil and the materials are replaced by
their numbers, on the grid of that case.

Fringes are measured with a rig, as users write it there and on the command line:

    light = "mono"                              # or "two-beam", "white"
    wavelength = "532 nm"
    coatings = "chromium 8 nm, silica 200 nm"   # on the glass, from the glass to the oil; or an index, "2.1 50 nm"
    index = 1.48                                # of the oil at ambient pressure

What is left out is as in `optics.Rig`.  Other metals, glass, surfaces and lamps are for Python:
`optics.Interferometer`.
"""

from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from math import inf, isnan, nan, sqrt
from os import PathLike
from pathlib import Path
from typing import Any

from ertel.case.case import Case
from ertel.case.reading import check_keys, hint_for
from ertel.case.records import ConfigError, refusing, show
from ertel.inputs.case_files import (
    CaseLike,
    as_case,
    case_data,
    in_the_case,
    parse_case,
    path_of,
    put,
    read_toml,
    written,
)
from ertel.inputs.layout import READER
from ertel.inputs.quantities import marked_value, plain_data, quantity_of, split
from ertel.optics import CHROMIUM, SILICA, Constant, Interferometer, Layer, Light, Monochromatic, Rig, TwoBeams, White
from ertel.optics.light import GREEN
from ertel.optics.rig import COATINGS, OIL_INDEX
from ertel.physics.registry import VISCOSITY_LAWS
from ertel.physics.units import FINITE, Unit

KEYS = {"case": (str, '"ball.toml"'), "unknowns": (dict, "[unknowns]"), "measurements": (list, "[[measurements]]")}

LAWS = "laws"
COMPUTATION = ("solver", "time", "output")  # sections that conditions leave as they are

Settings = Mapping[str, Any]  # values of a case by their paths, "contact.speed"


@dataclass(frozen=True)
class Unknown:
    """A number of a case that is to be found.

    field: its path in the case, contact.radius.  unit: of all its values, the SI unit, "" of a plain number.  prior:
    value and standard deviation, or None.  start: where the search begins.
    """

    field: str
    unit: str
    lower: float
    upper: float
    prior: tuple[float, float] | None
    start: float

    def in_case(self, value: float) -> float | str:
        """A value as a case has it."""
        return f"{float(value)!r} {self.unit}" if self.unit else float(value)


def load_fit(
    path: str | Path, overrides: Sequence[str] = ()
) -> tuple["WrittenCase", list[tuple[str, dict[str, Any]]], Any, Any]:
    """The case of a fit in a TOML file, the tables of its measurements with their places, its unknowns and its laws.

    overrides: of the case, "solver.nodes=65".  Raises ConfigError.
    """
    path = path_of("fit", path, "the file of a fit")
    data = read_toml(path)
    check_keys(data, (*KEYS, LAWS))
    for key, (kind, example) in KEYS.items():
        if not isinstance(data.get(key), kind):
            raise ConfigError(f"{key} = {show(data.get(key, ''))}: must be given, as {example}")
    places = [(f"measurements[{number}]", item) for number, item in enumerate(data["measurements"], 1)]
    tables = [(place, table) for place, item in places for table in _one_by_one(place, item)]
    return WrittenCase.of(path.parent / data["case"], overrides), tables, data["unknowns"], data.get(LAWS, ())


def _one_by_one(place: str, table: Any) -> Iterator[dict[str, Any]]:
    """The tables of the measurements for which one with lists of values and conditions stands."""
    if not isinstance(table, Mapping) or not isinstance(table.get("set", {}), Mapping):
        raise ConfigError(f"{place} = {show(table)}: must be a table, and so must its set")
    size = len(table["value"]) if isinstance(table.get("value"), list) else 1

    def each(name: str, value: Any) -> list[Any]:
        if isinstance(value, list) and name in listed and len(value) != size:
            raise ConfigError(f"{place}.{name} = {show(value)}: must have {size} values, as many as value")
        return value if isinstance(value, list) and name in listed else [value] * size

    settings = table.get("set", {})
    listed = {"value", "sigma", *settings} if "value" in table else set()
    for index in range(size):
        one = {name: each(name, value)[index] for name, value in table.items() if name != "set"}
        yield {**one, "set": {name: each(name, value)[index] for name, value in settings.items()}}


def parse_unknowns(given: Any, case: Case) -> tuple[Unknown, ...]:
    """The unknowns by their paths: { bounds, prior } or a pair of bounds each.  Raises ConfigError, naming the path."""
    if not isinstance(given, Mapping) or not given:
        example = '{"lubricant.eta0": ("5 mPa*s", "1 Pa*s")}'
        raise ConfigError(f"unknowns = {written(given)}: must be paths with their bounds, such as {example}")
    return tuple(_unknown(str(field), plain_data(value), case) for field, value in given.items())


def _unknown(field: str, given: Any, case: Case) -> Unknown:
    if field.partition(".")[0] in COMPUTATION:
        raise ConfigError(f"unknowns.{field}: belongs to the computation, and data do not fix it; give it in the case")
    place, allowed = f"unknowns.{field}", 'bounds must be two positive values with units, ["LEAST", "MOST"]'
    table = given if isinstance(given, Mapping) else {"bounds": given}
    check_keys(table, ("bounds", "prior"), place)
    with refusing(place, given):
        pair = table.get("bounds")
        if not isinstance(pair, list) or len(pair) != 2:
            raise ValueError(allowed)
        (lower, unit), (upper, other) = (_stored(case, field, value) for value in pair)
        if not 0 < lower < upper or unit != other:
            raise ValueError(f"{allowed}, the smaller one first")
    prior, usual = None, _number(case.to_data(), field)[0]
    if "prior" in table:
        with refusing(f"{place}.prior", table["prior"]):
            prior = _prior(table["prior"], unit, lower, upper)
    inside = usual if lower <= usual <= upper else sqrt(lower * upper)
    return Unknown(field, unit, lower, upper, prior, prior[0] if prior else inside)


def _prior(given: Any, unit: str, lower: float, upper: float) -> tuple[float, float]:
    mark = Unit(unit, f"1 {unit}") if unit else FINITE
    value, sigma = (marked_value(each, mark) for each in given) if isinstance(given, list) else (nan, nan)
    if not (lower <= value <= upper and sigma > 0):
        raise ValueError("must be a value within the bounds, and its standard deviation")
    return value, sigma


def _stored(case: Case, field: str, value: Any) -> tuple[float, str]:
    """A value in SI and its unit, as a case has it that is given this value.  Raises ConfigError."""
    number, unit = _number(with_settings(case, {field: value}).to_data(), field)
    if not number < inf:
        raise ConfigError(f"unknowns.{field} = {show(value)}: must be a number of the case")
    return number, unit


def _number(data: Any, field: str) -> tuple[float, str]:
    """The number at a path and its unit; nan where there is none."""
    for part in field.split("."):
        data = data.get(part) if isinstance(data, Mapping) else None
    if isinstance(data, str) and split(data)[0]:
        return float(split(data)[0]), split(data)[1]
    return (float(data), "") if type(data) in (int, float) else (nan, "")


@dataclass(frozen=True)
class WrittenCase:
    """A case, and the plain data from which it was resolved, with the names of oils and materials.

    data: None of a `Case`, which knows numbers only.  folder: that in which files lie that the data name.
    """

    case: Case
    data: Mapping[str, Any] | None = None
    folder: Path = Path()

    @classmethod
    def of(cls, given: CaseLike, overrides: Sequence[str] = ()) -> "WrittenCase":
        """The case that is given as such, as plain data, or as the path of a case file.  Raises ConfigError."""
        if isinstance(given, Mapping):
            return cls(as_case(given), plain_data(given))
        if isinstance(given, Case) or not isinstance(given, str | PathLike):
            return cls(as_case(given))
        data = case_data(given, overrides)
        return cls(parse_case(data, Path(given).parent), data, Path(given).parent)

    def under(self, settings: Settings) -> Case:
        """The case under other conditions, resolved again, on the same grid.  Raises ConfigError as `with_settings`."""
        if self.data is None or not settings:
            return with_settings(self.case, settings)
        kept = {name: table for name, table in self.case.to_data().items() if name in COMPUTATION}
        data = deepcopy({**self.data, **kept})
        with in_the_case(settings):
            for field, value in settings.items():
                put(data, field.split("."), plain_data(value))
            return parse_case(data, self.folder)

    def with_law(self, law: str) -> "WrittenCase":
        """The case with another law of viscosity.  Raises ConfigError."""
        data = None if self.data is None else deepcopy(dict(self.data))
        if data is not None:
            put(data, ["lubricant", "viscosity"], law)
        return replace(self, case=self.under({"lubricant.viscosity": law}), data=data)

    def has(self, field: str, value: Any) -> bool:
        """Whether this is the value at a path of the case, as it is written or stored."""
        if not isnan(_number(self.case.to_data(), field)[0]):
            return True
        data: Any = self.data
        for part in field.split("."):
            data = data.get(part) if isinstance(data, Mapping) else None
        return bool(data == plain_data(value))


def laws_of(given: Any) -> list[str]:
    """The names of the laws of viscosity under which a fit is made.  Raises ConfigError."""
    laws, known = list(given) if isinstance(given, list | tuple) else [given], tuple(VISCOSITY_LAWS)
    if wrong := [law for law in laws if law not in known]:
        raise ConfigError(f"laws = {show(wrong[0])}: {hint_for(str(wrong[0]), known)}")
    return laws


def with_settings(case: Case, settings: Settings) -> Case:
    """A case with other values at paths.  Raises ConfigError, with these values, where it is not allowed."""
    data = case.to_data()
    with in_the_case(settings):
        for field, value in settings.items():
            put(data, field.split("."), plain_data(value))
        return Case.from_data(data, case.maps, READER)


# -- optical rigs ------------------------------------------------------------------------------------------------------

RIG = ("light", "wavelength", "coatings", "index")  # the keys of a rig
LIGHTS: Mapping[str, type[Rig]] = {"mono": Rig, "two-beam": TwoBeams, "white": Rig}
MEDIA: Mapping[str, Any] = {"chromium": CHROMIUM, "silica": SILICA}
LENGTH = Unit("m", "532 nm")


def interferometer(
    light: str = "mono", wavelength: str | None = None, coatings: str | None = None, index: float | None = None
) -> Interferometer:
    """The rig and the light that a user describes.

    Parameters
    ----------
    light : "mono", "two-beam" or "white"
        Of one wavelength, the same without the light that crosses the film more than once, or daylight.
    wavelength : str, optional
        With a unit; default 532 nm.
    coatings : str, optional
        Media with their thicknesses, from the glass to the oil, or "none"; default "chromium 8 nm".  A medium is
        chromium, silica, or the index of another one that is transparent, "2.1 50 nm".
    index : float, optional
        Of the oil at ambient pressure.

    Returns
    -------
    Interferometer

    Raises
    ------
    ValueError
        A value is not allowed; the message names it.
    """
    if light not in LIGHTS:
        raise ValueError(f"light = {light!r}: {hint_for(light, tuple(LIGHTS))}")
    if light == "white" and wavelength:
        raise ValueError(f"wavelength = {wavelength!r}: white light has none; leave it out")
    length = quantity_of("wavelength", wavelength or f"{GREEN} m", LENGTH)
    lamp: Light = White() if light == "white" else Monochromatic(length)
    parts = [] if coatings == "none" else [each.split(maxsplit=1) for each in (coatings or "").split(",")]
    layers = tuple(_layer(*part) for part in parts) if coatings else COATINGS
    return Interferometer(LIGHTS[light](coatings=layers, oil_index=index or OIL_INDEX), lamp)


def _layer(medium: str = "", thickness: str = "") -> Layer:
    is_index = medium.replace(".", "", 1).isdecimal() and float(medium) > 0.0
    if not is_index and medium not in MEDIA:
        raise ValueError(f"coatings = {medium!r}: {hint_for(medium, tuple(MEDIA))} or an index, each with thickness")
    return Layer(Constant(float(medium)) if is_index else MEDIA[medium], quantity_of("coatings", thickness, LENGTH))
