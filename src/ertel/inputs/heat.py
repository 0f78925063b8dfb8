"""The section [thermal] of a case: completed from the oil and the materials that the case names.

    [lubricant]                   [contact]                     [thermal]
    oil = "squalane"              material_1 = "steel"          temperature_1 = "60 degC"
    temperature = "40 degC"       material_2 = "glass"

A value that is given explicitly wins over that of the library.
"""

from collections.abc import Mapping
from typing import Any

from ertel.case.case import Case
from ertel.case.estimates import LARGEST_NEWTONIAN_STRESS, newtonian_stress
from ertel.case.records import ConfigError, show
from ertel.case.thermal import Thermal
from ertel.inputs import library, names
from ertel.inputs.quantities import parse_temperature
from ertel.physics.oils import NamedOil
from ertel.physics.units import CONDUCTIVITY, DENSITY, EXPANSION, HEAT_CAPACITY, TEMPERATURE, Unit, marks

TEMPERATURES = tuple(key for key, mark in marks(Thermal).items() if mark is TEMPERATURE)


def with_thermal_data(data: Mapping[str, Any]) -> dict[str, Any]:
    """The plain data of a case, its section [thermal] complete: temperatures in K, data of the named oil and bodies.

    Raises ConfigError, naming the key and what to give, for what is missing and for what is no temperature.
    """
    written = data.get("thermal")
    if not isinstance(written, Mapping):
        return dict(data)
    lubricant, contact = (_table(data, name) for name in ("lubricant", "contact"))
    given = dict(written)
    if "temperature" in lubricant:
        given.setdefault("temperature", lubricant["temperature"])
    for key in TEMPERATURES:
        if key in given:
            given[key] = _kelvin(key, given[key])
    if "temperature" in lubricant and given["temperature"] != _kelvin("temperature", lubricant["temperature"]):
        raise ConfigError(
            f"thermal.temperature = {show(written['temperature'])}: differs from lubricant.temperature = "
            f"{show(lubricant['temperature'])}, for which eta0 and alpha hold; leave thermal.temperature out"
        )
    found = {**_oil(lubricant, given), **_body(1, contact), **_body(2, contact), **given}
    for key, mark in marks(Thermal).items():
        if key not in found and key not in ("temperature_1", "temperature_2"):
            raise ConfigError(_missing(key, mark, lubricant, contact))
    return {**data, "thermal": found}


def require_rheology(case: Case, lubricant: object) -> None:
    """Refuse temperatures of a sliding contact whose oil is Newtonian only because the case does not say how it thins.

    lubricant: the section as it is written.  With rheology = "newtonian" they are computed.  Raises ConfigError.
    """
    given = isinstance(lubricant, Mapping) and "rheology" in lubricant
    stress = newtonian_stress(case) if case.thermal and case.oil.is_newtonian and not given else 0.0
    if stress > LARGEST_NEWTONIAN_STRESS:
        raise ConfigError(
            "lubricant.rheology: missing; [thermal] needs it, because a Newtonian oil would have a mean shear stress "
            f"of about {stress / 1e6:.2g} MPa here and oils begin to thin at some MPa; give for example "
            '{ law = "ree-eyring", tau0 = "5 MPa" }, or "newtonian" to have that heat computed'
        )


def _table(data: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    section = data.get(name)
    return section if isinstance(section, Mapping) else {}


def _kelvin(key: str, value: Any) -> str:
    """A temperature in K with its unit."""
    try:
        if not isinstance(value, str):
            raise ValueError('must be a temperature with its unit, "40 degC" or "313.15 K"')
        return _text(parse_temperature(value), TEMPERATURE)
    except ValueError as error:
        raise ConfigError(f"thermal.{key} = {show(value)}: {error}") from error


def _oil(lubricant: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, str]:
    """What is known of the oil that is named or has a data sheet, at the temperature of the inlet."""
    oil = _known(lubricant.get("oil"))
    if oil is None or "temperature" not in given:
        return {}
    found = {"beta": _text(oil.thinning_at(parse_temperature(given["temperature"])), EXPANSION)}
    return (
        found if oil.thermal is None else {**found, "conductivity": _text(oil.thermal.data.conductivity, CONDUCTIVITY)}
    )


def _known(written: object) -> NamedOil | None:
    """The oil, if it is one; what is wrong with it is said elsewhere."""
    try:
        return names.oil_of(written)
    except ConfigError:
        return None


def _body(number: int, contact: Mapping[str, Any]) -> dict[str, str]:
    name = contact.get(f"material_{number}")
    if name not in library.material_names():
        return {}
    material = library.material(name)
    found = {f"density_{number}": _text(material.elasticity.data.density, DENSITY)}
    if material.thermal is None:
        return found
    known = material.thermal.data
    return found | {
        f"heat_capacity_{number}": _text(known.heat_capacity, HEAT_CAPACITY),
        f"conductivity_{number}": _text(known.conductivity, CONDUCTIVITY),
    }


def _text(value: float, unit: Unit) -> str:
    return f"{value!r} {unit.unit}"


def _missing(key: str, mark: object, lubricant: Mapping[str, Any], contact: Mapping[str, Any]) -> str:
    """What to do for a key that nothing gives."""
    assert isinstance(mark, Unit)
    number = key[-1] if key[-2] == "_" else ""
    place, name = ("contact", f"material_{number}") if number else ("lubricant", "oil")
    named = (contact if number else lubricant).get(name)
    if key == "temperature":
        return 'thermal.temperature: missing; give that of the oil in the inlet, for example "40 degC"'
    wanted = f'give it, for example "{mark.example}"'
    if named is None:
        return f"thermal.{key}: missing; {wanted}, or name the {name.partition('_')[0]}, {place}.{name}"
    return f"thermal.{key}: missing; the library has none for {place}.{name} = {show(named)}, {wanted}"
