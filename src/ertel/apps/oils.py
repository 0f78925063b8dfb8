"""The output of `ertel oils`: the library of oils and materials, and all data of one of them with their sources."""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from ertel.apps.tables import console, print_rows
from ertel.case.records import ConfigError, show
from ertel.inputs import materials, oils
from ertel.physics.materials import Material, NamedOil, Sourced, celsius
from ertel.physics.units import COMPLIANCE, KINEMATIC_VISCOSITY, TEMPERATURE, Unit, marks
from ertel.results.variables import with_prefix

WARM, HOT = 313.15, 373.15  # K, the temperatures of data sheets
CAPTION = "(eta0 in mPa s, alpha in 1/GPa, at 40 and 100 degC; ertel oils NAME: all data, with source and range)"
TITLES = {"shear": "shear thinning", "limiting_stress": "limiting stress"}


def find(name: str) -> NamedOil | Material:
    """The oil or the material of a name.  Raises ConfigError for a name that is not there."""
    if name in oils.names():
        return oils.get(name)
    if name in materials.names():
        return materials.get(name)
    raise ConfigError(f"NAME = {show(name)}: allowed: {', '.join((*oils.names(), *materials.names()))}")


def print_library() -> None:
    """The oils at 40 and 100 degC, and the materials."""
    rows = [["oil", "eta0 at 40", "at 100", "alpha at 40", "at 100", "valid"]]
    for name in oils.names():
        oil = oils.get(name)
        warm, hot = oil.at(WARM), oil.at(HOT)
        viscosities = [f"{1e3 * (one.eta0 or 0.0):.3g}" for one in (warm, hot)]
        alphas = [f"{1e9 * (one.alpha or 0.0):.3g}" for one in (warm, hot)]
        rows.append([name, *viscosities, *alphas, _range(*oil.temperatures)])
    print_rows(rows)
    print(f"{CAPTION}\n")
    rows = [["material", "E", "nu", "density"]]
    for name in materials.names():
        body = materials.get(name).elasticity.data
        rows.append([name, f"{body.E / 1e9:.3g} GPa", f"{body.nu:g}", f"{body.density:g} kg/m^3"])
    print_rows(rows)


def print_entry(entry: NamedOil | Material) -> None:
    """All data of an oil or a material, each part with its range, its source and a note."""
    out = console()
    out.print(f"{entry.name}: {entry.text}", style="bold")
    for title, part in _parts(entry):
        out.print(f"\n{title}, {_range(part.coldest, part.hottest)}: {part.data.title}")
        for key, text in _values(part.data):
            out.print(f"  {key} = {text}")
        out.print(f"  source: {part.source}")
        if part.note:
            out.print(f"  note: {' '.join(part.note.split())}")


def as_data(entry: NamedOil | Material) -> dict[str, Any]:
    """All data of an oil or a material in SI, for JSON."""
    found: dict[str, Any] = {"name": entry.name, "text": entry.text}
    for title, part in _parts(entry):
        own = {item.name: getattr(part.data, item.name) for item in fields(part.data)}
        ends = {"coldest": part.coldest, "hottest": part.hottest}
        found[title] = {"law": part.data.title, **own, **ends, "source": part.source, "note": part.note}
    return found


def library_data() -> dict[str, list[dict[str, Any]]]:
    """All oils and materials in SI, for JSON."""
    return {
        "oils": [as_data(oils.get(name)) for name in oils.names()],
        "materials": [as_data(materials.get(name)) for name in materials.names()],
    }


def _parts(entry: NamedOil | Material) -> Iterator[tuple[str, Sourced[Any]]]:
    for name, part in vars(entry).items():
        if isinstance(part, Sourced):
            yield TITLES.get(name, name), part


def _values(data: Any) -> Iterator[tuple[str, str]]:
    kinds: Mapping[str, object] = marks(type(data))
    for item in fields(data):
        value = getattr(data, item.name)
        if value is not None:
            yield item.name, _text(value, kinds.get(item.name))


def _text(value: float, mark: object) -> str:
    if mark is TEMPERATURE:
        return celsius(value)
    if mark is KINEMATIC_VISCOSITY:
        return f"{1e6 * value:.4g} mm^2/s"
    if mark is COMPLIANCE:
        return f"{1e9 * value:.4g} 1/GPa"
    return with_prefix(value, mark.unit) if isinstance(mark, Unit) else f"{value:g}"


def _range(coldest: float, hottest: float) -> str:
    if coldest == hottest:
        return celsius(coldest)
    return f"{celsius(coldest).removesuffix(' degC')} to {celsius(hottest)}"
