"""The library of oils and materials, and oils from a data sheet: `ertel.oils`, and for `ertel.materials`.

>>> from ertel import oils
>>> oils.names()
('iso-vg-100', 'iso-vg-68', 'mineral-100', 'naphthenic-100', 'pao-100', 'polyglycol', 'squalane')
>>> round(oils.at("squalane", "40 degC").eta0, 4)
0.0149
>>> round(oils.data_sheet(nu40="68 mm^2/s", nu100="8.6 mm^2/s", density=880, temperature="60 degC").eta0, 4)
0.0243

All data of an oil, with their sources and ranges, are in `oils.get("squalane")`.

A data file of the library is TOML.  Each of its tables gives data of one kind, their `source`, the temperatures
`coldest` and `hottest` between which they are valid, and often a `note` on their accuracy.  What has no trustworthy
source is left out of the file.
"""

import tomllib
from collections.abc import Callable, Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from ertel.case.reading import Reader
from ertel.case.records import ConfigError, refusing, show
from ertel.inputs.layout import READER, DataSheet
from ertel.inputs.quantities import NumberOrText, number_or_quantity, parse_temperature
from ertel.physics.fluidity import Carreau, Fluidity
from ertel.physics.lubricant import Oil
from ertel.physics.materials import Elasticity, LimitingStress, Material, NamedOil, Sourced, Strength, ThermalData
from ertel.physics.temperature_laws import (
    ZERO_CELSIUS,
    DoolittleOfTemperature,
    Expansion,
    ModulusOfTemperature,
    PowerOfViscosity,
    SoKlaus,
    Vogel,
    Walther,
)

__all__ = ["at", "data_sheet", "get", "names"]

FOLDER = files("ertel.inputs") / "library"
COLDEST, HOTTEST = ZERO_CELSIUS, ZERO_CELSIUS + 150.0  # of a data sheet: D341 is a straight line here
LAWS: Mapping[str, Callable[..., Any]] = {
    "astm-d341": Walther,
    "vogel": Vogel,
    "so-klaus": SoKlaus,
    "power-of-viscosity": PowerOfViscosity,
    "modulus": ModulusOfTemperature,
    "doolittle": DoolittleOfTemperature,
}
DATA: Mapping[str, Any] = {  # by table of a data file, which otherwise names a law
    "density": Expansion,
    "shear": Carreau,
    "limiting_stress": LimitingStress,
    "thermal": ThermalData,
    "elasticity": Elasticity,
    "strength": Strength,
}
RECORDS = {"oils": NamedOil, "materials": Material}  # by folder of the library; their fields are the tables


def names() -> tuple[str, ...]:
    """The names of the oils of the library."""
    return _names("oils")


def material_names() -> tuple[str, ...]:
    """The names of the materials of the library."""
    return _names("materials")


def get(name: str) -> NamedOil:
    """An oil of the library.  Raises ConfigError for a name that is not there."""
    return _entry("oil", name)


def material(name: str) -> Material:
    """A material of the library.  Raises ConfigError for a name that is not there."""
    return _entry("material", name)


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
    given = dict(
        nu40=nu40, nu100=nu100, density=density, expansion=expansion, alpha=alpha, reference=reference or "data sheet"
    )
    try:
        sheet = Reader(number_or_quantity).record(DataSheet, given, "data_sheet")
    except ValueError as error:
        raise ConfigError(str(error).removeprefix("data_sheet.")) from error
    return oil_at(oil_of_sheet(sheet), temperature)


def oil_of_sheet(sheet: DataSheet, place: str = "") -> NamedOil:
    """The oil of a data sheet at all temperatures; see `data_sheet`.

    place: before the names of the keys in messages.  Raises ConfigError for viscosities that do not fall.
    """
    try:
        viscosity = Walther(sheet.nu40, sheet.nu100)
    except ValueError as error:
        raise ConfigError(f"{place}{error}") from error
    return NamedOil(
        sheet.reference or "data sheet",
        "an oil from its data sheet",
        _whole(viscosity, "ASTM D341."),
        _whole(Expansion(sheet.density, sheet.expansion), "data sheet."),
        _whole(SoKlaus(), "So and Klaus' correlation (ASLE Trans 1980;23:409-421).")
        if sheet.alpha is None
        else _whole(PowerOfViscosity(sheet.alpha, 1.0, 0.0), "alpha as given."),
    )


def _whole(data: Any, source: str) -> Sourced[Any]:
    return Sourced(data, source, COLDEST, HOTTEST)


def oil_at(oil: NamedOil, temperature: NumberOrText, rheology: str | Fluidity | None = None) -> Oil:
    """An oil at a temperature; rheology as in `at`.  Raises ConfigError for a temperature outside its data."""
    with refusing("temperature", temperature):
        T = parse_temperature(temperature)
    try:
        return oil.at(T, rheology)
    except ValueError as error:
        message = str(error).replace(f"temperature = {T:g} K", f"temperature = {show(temperature)}")
        raise ConfigError(message) from error


# -- reading the library -----------------------------------------------------------------------------------------------


@cache
def _names(folder: str) -> tuple[str, ...]:
    entries = (entry.name for entry in (FOLDER / folder).iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in entries if name.endswith(".toml")))


def _entry(noun: str, name: object) -> Any:
    allowed = _names(f"{noun}s")
    if not isinstance(name, str) or name not in allowed:
        raise ConfigError(f"{noun} = {show(name)}: allowed: {', '.join(allowed)}")
    return _read(f"{noun}s", name)


@cache
def _read(folder: str, name: str) -> Any:
    """The oil or the material in a data file."""
    data = tomllib.loads((FOLDER / folder / f"{name}.toml").read_text(encoding="utf-8"))
    text = data.pop("text")
    return RECORDS[folder](name, text, **{key: _sourced(table, key, f"{name}.{key}") for key, table in data.items()})


def _sourced(table: dict[str, Any], key: str, place: str) -> Sourced[Any]:
    """A table with its source and range; its other keys are the fields of its record, or of the law that it names."""
    source, note = table.pop("source"), table.pop("note", "").strip()
    coldest, hottest = (parse_temperature(table.pop(end)) for end in ("coldest", "hottest"))
    record = LAWS[table.pop("law")] if "law" in table else DATA[key]
    return Sourced(READER.record(record, table, place), source, coldest, hottest, note)
