"""The library of oils and materials, and oils from a data sheet: `ertel.oils`, and for `ertel.materials`.

>>> from ertel import oils
>>> oils.names()[:5]
('iso-vg-100', 'iso-vg-68', 'machine-oil-heavy', 'machine-oil-light', 'mineral-100')
>>> round(oils.at("squalane", "40 degC").eta0, 4)
0.0149
>>> round(oils.data_sheet(nu40="68 mm^2/s", nu100="8.6 mm^2/s", density=880, temperature="60 degC").eta0, 4)
0.0243

All data of an oil, with their sources and ranges, are in `oils.get("squalane")`.

A data file of the library is TOML.  Each of its tables gives data of one kind, their `source`, the temperatures
`coldest` and `hottest` between which they are valid, and often a `note` on their accuracy.  What has no trustworthy
source is left out of the file.

A user's own oils stand in a file of their own, a table for each, with the same tables in it, or with the keys of a data
sheet and its source as `reference`::

    [gear-oil]
    reference = "data sheet of March 2024"
    nu40 = "68 mm^2/s"
    nu100 = "8.7 mm^2/s"
    density = "880 kg/m^3"

Those in ertel/oils.toml in the folder of a user's configuration (`own_file`; on Linux ~/.config, or XDG_CONFIG_HOME)
are in the library; a case may name another file, lubricant.oils.  The resolved case holds their numbers and not their
names.
"""

import tomllib
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, fields, replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any

from platformdirs import user_config_path

from ertel.case.reading import check_keys, regular_content
from ertel.case.records import ConfigError, refusing, show
from ertel.inputs.layout import IN_SI, READER, DataSheet
from ertel.inputs.quantities import NumberOrText, parse_temperature, plain_data
from ertel.physics import temperature_laws
from ertel.physics.fluidity import Carreau, Fluidity
from ertel.physics.lubricant import Oil
from ertel.physics.materials import Elasticity, LimitingStress, Material, NamedOil, Sourced, Strength, ThermalData
from ertel.physics.units import TEMPERATURE

__all__ = ["at", "data_sheet", "get", "names", "read_file"]

FOLDER = Path(__file__).with_name("library")
COLDEST = temperature_laws.ZERO_CELSIUS  # of a data sheet: D341 is a straight line from here
HOTTEST = COLDEST + 150.0  # to here
LAWS: Mapping[str, Mapping[str, Callable[..., Any]]] = {  # by table of a data file, and by name
    "viscosity": {"astm-d341": temperature_laws.Walther, "vogel": temperature_laws.Vogel},
    "pressure": {
        "so-klaus": temperature_laws.SoKlaus,
        "power-of-viscosity": temperature_laws.PowerOfViscosity,
        "modulus": temperature_laws.ModulusOfTemperature,
        "doolittle": temperature_laws.DoolittleOfTemperature,
    },
}
DATA: Mapping[str, Any] = {  # by table of a data file, where that names no law
    "density": temperature_laws.Expansion,
    "shear": Carreau,
    "limiting_stress": LimitingStress,
    "thermal": ThermalData,
    "elasticity": Elasticity,
    "strength": Strength,
}
RECORDS: Mapping[str, Any] = {"oil": NamedOil, "material": Material}  # by noun; their fields are the tables
LARGEST_FILE = 1_000_000  # bytes


@dataclass(frozen=True)
class Origin:
    """The source of the data of a table, and the temperatures between which they hold (K)."""

    source: str
    coldest: Annotated[float, TEMPERATURE]
    hottest: Annotated[float, TEMPERATURE]
    note: str = ""


ABOUT = tuple(item.name for item in fields(Origin))


def names() -> tuple[str, ...]:
    """The names of the oils of the library, and of those in the user's own file.

    Warns, and leaves these out, where that file cannot be read.
    """
    own: Iterable[str] = ()
    try:
        own = _own()
    except ConfigError as error:
        warnings.warn(f"own oils are left out: {error}", stacklevel=1)  # of this line: once
    return tuple(sorted((*_files("oil"), *own)))


def material_names() -> tuple[str, ...]:
    """The names of the materials of the library."""
    return tuple(_files("material"))


def get(name: str, file: str | Path | None = None) -> NamedOil:
    """An oil of the library, or of a user's own file.  Raises ConfigError for a name that is not there.

    file: that of own oils; left out, the one in the folder of the user's configuration, which is then read only for a
    name that the library has not.
    """
    library = _library("oil")
    own = read_file(file) if file is not None else {} if isinstance(name, str) and name in library else _own()
    return _entry("oil", name, {**dict(sorted(own.items())), **library})


def read_file(file: str | Path) -> dict[str, NamedOil]:
    """The oils in a user's own file, by name.

    Raises ConfigError, naming the file and the key, where it cannot be read, for keys and values that are not allowed,
    for data without a source, and for the name of an oil of the library.
    """
    path = Path(file)
    try:
        tables = tomllib.loads(regular_content(path, LARGEST_FILE).decode("utf-8-sig"))
    except ValueError as error:
        raise ConfigError(f"the file of oils {path}: {error}") from error
    if taken := sorted(tables.keys() & _library("oil").keys()):
        raise ConfigError(f"{path}: {taken[0]}: the library has an oil of this name; choose another")
    return {name: _own_oil(name, table, f"{path}: {name}") for name, table in tables.items()}


def own_file() -> Path:
    """The file with a user's own oils, which need not be there."""
    return user_config_path("ertel", appauthor=False) / "oils.toml"


def _own() -> dict[str, NamedOil]:
    return read_file(own_file()) if own_file().exists() else {}


def _own_oil(name: str, table: Any, place: str) -> NamedOil:
    if not isinstance(table, Mapping) or "nu40" not in table:
        return _built(NamedOil, name, table, place)
    sheet = READER.record(DataSheet, table, place)
    if not sheet.reference:
        raise ConfigError(f"{place}.reference: missing; it is the source of the data")
    oil = oil_of_sheet(sheet, f"{place}.")
    viscosity = replace(oil.viscosity, source=f"{sheet.reference}; ASTM D341.")
    return replace(oil, name=name, text=sheet.reference, viscosity=viscosity)


def material(name: str) -> Material:
    """A material of the library.  Raises ConfigError for a name that is not there."""
    return _entry("material", name, _library("material"))


def at(name: str, temperature: NumberOrText, rheology: str | Fluidity | None = None) -> Oil:
    """An oil of the library at a temperature, for `ertel.impact` and `ertel.rolling`.

    Parameters
    ----------
    name : str
        One of `names()`.
    temperature : float or str
        Temperature of the oil in the inlet, in K or as a text, "40 degC".
    rheology : str or record, optional
        A law of shear thinning, or "newtonian", as dimensionless cases and the radial method need it.  Without it the
        oil has the law that the library has of it at this temperature; where it has none, the oil is Newtonian.

    Raises ConfigError, naming the argument, for an unknown name and for a temperature outside the oil's data.
    """
    return oil_at(get(name), temperature, rheology)


def data_sheet(
    nu40: NumberOrText,
    nu100: NumberOrText,
    density: NumberOrText,
    temperature: NumberOrText,
    expansion: NumberOrText | None = None,
    alpha: NumberOrText | None = None,
    reference: str = "",
) -> Oil:
    """A mineral oil from its data sheet, at a temperature.

    Its viscosity is by ASTM D341, alpha by So and Klaus' correlation unless it is given (for its scatter see
    `ertel.physics.temperature_laws.SoKlaus`; it is made for mineral oils), the pressure laws by Roelands and by Dowson
    and Higginson.

    Parameters
    ----------
    nu40, nu100 : float or str
        Kinematic viscosities at 40 and 100 degC (m^2/s, or "68 mm^2/s").
    density : float or str
        Density at 15 degC (kg/m^3).
    temperature : float or str
        Temperature of the oil in the inlet, in K or as a text, "40 degC"; from 0 to 150 degC.
    expansion : float or str
        Coefficient of thermal expansion (1/K); API's value for lubricating oils if it is not given.
    alpha : float or str
        Pressure-viscosity coefficient (1/Pa) at this temperature, if it is known.
    reference : str
        Name and source of the data sheet.

    Raises ConfigError, naming the argument, for a value that is not allowed.
    """
    given = {"nu40": nu40, "nu100": nu100, "density": density, "expansion": expansion, "alpha": alpha}
    try:
        sheet = IN_SI.record(DataSheet, {**given, "reference": reference}, "data_sheet")
    except ValueError as error:
        raise ConfigError(str(error).removeprefix("data_sheet.")) from error
    return oil_at(oil_of_sheet(sheet), temperature)


def oil_of_sheet(sheet: DataSheet, place: str = "") -> NamedOil:
    """The oil of a data sheet at all temperatures; see `data_sheet`.

    place: before the names of the keys in messages.  Raises ConfigError for viscosities that do not fall.
    """
    try:
        viscosity = temperature_laws.Walther(sheet.nu40, sheet.nu100)
    except ValueError as error:
        raise ConfigError(f"{place}{error}") from error
    return NamedOil(
        sheet.reference or "data sheet",
        "an oil from its data sheet",
        _whole(viscosity, "ASTM D341."),
        _whole(temperature_laws.Expansion(sheet.density, sheet.expansion), "data sheet."),
        _whole(temperature_laws.SoKlaus(), "So and Klaus' correlation (ASLE Trans 1980;23:409-421).")
        if sheet.alpha is None
        else _whole(temperature_laws.PowerOfViscosity(sheet.alpha, 1.0, 0.0), "alpha as given."),
    )


def _whole(data: Any, source: str) -> Sourced[Any]:
    return Sourced(data, source, COLDEST, HOTTEST)


def oil_at(oil: NamedOil, temperature: NumberOrText, rheology: str | Fluidity | None = None) -> Oil:
    """An oil at a temperature; rheology as in `at`.  Raises ConfigError for a temperature outside its data."""
    temperature = plain_data(temperature)
    with refusing("temperature", temperature):
        T = parse_temperature(temperature)
    try:
        return oil.at(T, rheology)
    except ValueError as error:
        message = str(error).replace(f"temperature = {T:g} K", f"temperature = {show(temperature)}")
        raise ConfigError(message) from error


# -- reading the library -----------------------------------------------------------------------------------------------


def _files(noun: str) -> Mapping[str, Path]:
    """The files of the oils or of the materials of the library by name."""
    return {file.stem: file for file in sorted((FOLDER / f"{noun}s").glob("*.toml"))}


@cache
def _library(noun: str) -> Mapping[str, Any]:
    """The oils or the materials of the library by name."""
    tables = {name: tomllib.loads(file.read_text(encoding="utf-8")) for name, file in _files(noun).items()}
    return {name: _built(RECORDS[noun], name, table, name) for name, table in tables.items()}


def _entry(noun: str, name: object, entries: Mapping[str, Any]) -> Any:
    if isinstance(name, str):  # "ISO VG 68" is iso-vg-68
        written = name.strip().lower().replace(" ", "-")
        name = name if name in entries else next((each for each in entries if each.lower() == written), name)
    if not isinstance(name, str) or name not in entries:
        raise ConfigError(f"{noun} = {show(name)}: allowed: {', '.join(entries)}")
    return entries[name]


def _built(record: Any, name: str, data: Any, place: str) -> Any:
    """The oil or the material that tables define.  place: before their names in messages."""
    if not isinstance(data, Mapping):
        raise ConfigError(f"{place} = {show(data)}: must be a table")
    tables = {item.name: item for item in fields(record) if item.name != "name"}
    check_keys(data, tuple(tables), place)
    for key, item in tables.items():
        if key not in data and item.default is MISSING:
            raise ConfigError(f"{place}.{key}: missing")
    parts = {key: _sourced(table, key, f"{place}.{key}") for key, table in data.items() if key != "text"}
    return record(name, str(data["text"]), **parts)


def _sourced(table: Any, key: str, place: str) -> Sourced[Any]:
    """A table with its source and range; its other keys are the fields of its record, or of the law that it names."""
    if not isinstance(table, Mapping):
        raise ConfigError(f"{place} = {show(table)}: must be a table")
    about = READER.record(Origin, {name: table[name] for name in ABOUT if name in table}, place)
    content, record = {name: value for name, value in table.items() if name not in ABOUT}, DATA.get(key)
    if record is None:
        law = content.pop("law", None)
        if law not in LAWS[key]:
            raise ConfigError(f"{place}.law = {show(law)}: allowed: {', '.join(LAWS[key])}")
        record = LAWS[key][law]
    data = READER.record(record, content, place)
    return Sourced(data, about.source, about.coldest, about.hottest, about.note.strip())
