"""The library of oils and materials: data files, and how they are read.

A data file is TOML.  Each of its tables gives data of one kind, their `source`, the temperatures `coldest` and
`hottest` between which they are valid, and often a `note` on their accuracy.  What has
no trustworthy source is left out of the file.
"""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from functools import cache
from importlib.resources import files
from typing import Any

from ertel.case.records import ConfigError, show
from ertel.inputs.quantities import parse_quantity, parse_temperature
from ertel.physics.fluidity import Carreau
from ertel.physics.materials import Elasticity, LimitingStress, Material, NamedOil, Sourced, Strength, ThermalData
from ertel.physics.temperature_laws import (
    DoolittleOfTemperature,
    Expansion,
    ModulusOfTemperature,
    PowerOfViscosity,
    SoKlaus,
    Vogel,
    Walther,
)
from ertel.physics.units import Unit, marks

LAWS: Mapping[str, Callable[..., Any]] = {
    "astm-d341": Walther,
    "vogel": Vogel,
    "so-klaus": SoKlaus,
    "power-of-viscosity": PowerOfViscosity,
    "modulus": ModulusOfTemperature,
    "doolittle": DoolittleOfTemperature,
}
OIL_TABLES: Mapping[str, tuple[str, Any]] = {  # table of an oil's file: field of NamedOil, record or None for a law
    "viscosity": ("viscosity", None),
    "density": ("density", Expansion),
    "pressure": ("pressure", None),
    "carreau": ("shear", Carreau),
    "limiting_stress": ("limiting_stress", LimitingStress),
    "thermal": ("thermal", ThermalData),
}
MATERIAL_TABLES: Mapping[str, tuple[str, Any]] = {
    "elasticity": ("elasticity", Elasticity),
    "thermal": ("thermal", ThermalData),
    "strength": ("strength", Strength),
}


def oil_names() -> tuple[str, ...]:
    """The names of the oils of the library."""
    return _names("oils")


def material_names() -> tuple[str, ...]:
    """The names of the materials of the library."""
    return _names("materials")


def oil(name: str) -> NamedOil:
    """An oil of the library.  Raises ConfigError for a name that is not there."""
    return _oil(_known("oil", name, oil_names()))


def material(name: str) -> Material:
    """A material of the library.  Raises ConfigError for a name that is not there."""
    return _material(_known("material", name, material_names()))


@cache
def _oil(name: str) -> NamedOil:
    text, tables = _read("oils", name, OIL_TABLES)
    return NamedOil(name, text, **tables)


@cache
def _material(name: str) -> Material:
    text, tables = _read("materials", name, MATERIAL_TABLES)
    return Material(name, text, **tables)


# -- reading ----------------------------------------------------------------------------------------------------------


@cache
def _names(folder: str) -> tuple[str, ...]:
    found = (entry.name for entry in (files(__name__) / folder).iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in found if name.endswith(".toml")))


def _known(noun: str, name: object, names: tuple[str, ...]) -> str:
    if not isinstance(name, str) or name not in names:
        raise ConfigError(f"{noun} = {show(name)}: allowed: {', '.join(names)}")
    return name


def _read(folder: str, name: str, known: Mapping[str, tuple[str, Any]]) -> tuple[str, dict[str, Any]]:
    """The text of a data file and its tables, by field of the record."""
    data = tomllib.loads((files(__name__) / folder / f"{name}.toml").read_text(encoding="utf-8"))
    text = data.pop("text")
    return text, {known[key][0]: _sourced(table, known[key][1]) for key, table in data.items()}


def _sourced(table: dict[str, Any], record: Any) -> Sourced[Any]:
    """A table with its source and range; its keys are the fields of the record, or of the law that it names."""
    source, note = table.pop("source"), table.pop("note", "").strip()
    coldest, hottest = (parse_temperature(table.pop(key)) for key in ("coldest", "hottest"))
    made = record or LAWS[table.pop("law")]
    return Sourced(_record(made, table), source, coldest, hottest, note)


def _record(record: Any, table: Mapping[str, Any]) -> Any:
    kinds, names = marks(record), [item.name for item in fields(record)]
    needed = [item.name for item in fields(record) if item.default is MISSING]
    if set(table) - set(names) or set(needed) - set(table):
        raise ValueError(f"{record.__name__}: has {', '.join(table)}; needs {', '.join(names)}")
    return record(**{key: _value(value, kinds.get(key)) for key, value in table.items()})


def _value(value: Any, mark: object) -> float:
    return parse_quantity(value, mark) if isinstance(mark, Unit) else float(value)
