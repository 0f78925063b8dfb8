"""The section [thermal] of a case: completed from the oil and the materials that the case names.

    [lubricant]                   [contact]                     [thermal]
    oil = "squalane"              material_1 = "steel"          temperature_1 = "60 degC"
    temperature = "40 degC"       material_2 = "glass"

A value that is given explicitly wins over that of the library.
"""

from collections.abc import Mapping
from typing import Any

from ertel.case.case import Case
from ertel.case.derived import LARGEST_NEWTONIAN_STRESS, newtonian_stress
from ertel.case.records import ConfigError, named, show
from ertel.case.sections import Thermal
from ertel.inputs import library, names
from ertel.inputs.layout import READER
from ertel.physics.units import Unit, marks

PLACES = ("lubricant", "contact")  # sections that name an oil and materials


def with_thermal_data(data: Mapping[str, Any]) -> dict[str, Any]:
    """The plain data of a case, its section [thermal] complete with the data of the named oil and bodies.

    Raises ValueError, naming the key and what to give, for what is missing and for what is not a temperature.
    """
    written = data.get("thermal")
    if not isinstance(written, Mapping):
        return dict(data)
    lubricant, contact = (found if isinstance(found := data.get(name), Mapping) else {} for name in PLACES)
    given = {key: value for key, value in written.items() if value is not None}
    if "temperature" in lubricant:
        given.setdefault("temperature", lubricant["temperature"])
    T = _temperature(given, lubricant)
    in_si = {**_of_oil(lubricant, T), **_of_body(1, contact), **_of_body(2, contact)}
    units = {key: mark.unit for key, mark in marks(Thermal).items() if isinstance(mark, Unit)}
    found = {**{key: f"{value!r} {units[key]}" for key, value in in_si.items()}, **given}
    for key, mark in marks(Thermal).items():
        if key not in found and key not in ("temperature_1", "temperature_2"):
            raise ValueError(_missing(key, mark, lubricant, contact))
    return {**data, "thermal": found}


def _temperature(given: Mapping[str, Any], lubricant: Mapping[str, Any]) -> float | None:
    """The temperature of the inlet (K), which must be that of the named oil; None if it is missing."""
    T: float | None = READER.values(Thermal, {"temperature": given.get("temperature")}, "thermal").get("temperature")
    inlet = READER.values(Thermal, {"temperature": lubricant.get("temperature")}, "lubricant").get("temperature")
    if "temperature" in lubricant and T != inlet:
        raise ValueError(
            f"thermal.temperature = {show(given['temperature'])}: differs from lubricant.temperature = "
            f"{show(lubricant['temperature'])}, for which eta0 and alpha hold; leave thermal.temperature out"
        )
    return T


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


def _of_oil(lubricant: Mapping[str, Any], T: float | None) -> dict[str, float]:
    """Data of the oil that is named or has a data sheet, at T (K)."""
    if T is None or "oil" not in lubricant:
        return {}
    oil = named("lubricant", names.oil_of, lubricant["oil"])
    thermal = {} if oil.thermal is None else {"conductivity": oil.thermal.data.conductivity}
    return {"beta": oil.thinning_at(T), **thermal}


def _of_body(number: int, contact: Mapping[str, Any]) -> dict[str, float]:
    """Data of a body whose material is named."""
    name = contact.get(f"material_{number}")
    if name not in library.material_names():
        return {}
    material = library.material(name)
    found = {f"density_{number}": material.elasticity.data.density}
    if material.thermal is not None:
        found[f"heat_capacity_{number}"] = material.thermal.data.heat_capacity
        found[f"conductivity_{number}"] = material.thermal.data.conductivity
    return found


def _missing(key: str, mark: object, lubricant: Mapping[str, Any], contact: Mapping[str, Any]) -> str:
    """The message for a key that nothing gives."""
    assert isinstance(mark, Unit)
    number = key[-1] if key[-2] == "_" else ""
    place, name = ("contact", f"material_{number}") if number else ("lubricant", "oil")
    given = (contact if number else lubricant).get(name)
    if key == "temperature":
        return 'thermal.temperature: missing; give that of the oil in the inlet, for example "40 degC"'
    wanted = f'give it, for example "{mark.example}"'
    if given is None:
        return f"thermal.{key}: missing; {wanted}, or name the {name.partition('_')[0]}, {place}.{name}"
    return f"thermal.{key}: missing; the library has none for {place}.{name} = {show(given)}, {wanted}"
