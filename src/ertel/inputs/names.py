"""Oils and materials by name in a case: replaced by their numbers, which then define the case.

    [contact]                        [lubricant]
    material_1 = "steel"             oil = "squalane"
    material_2 = "glass"             temperature = "40 degC"

An oil that is not in the library is described by its data sheet:

    oil = { nu40 = "68 mm^2/s", nu100 = "8.7 mm^2/s", density = "880 kg/m^3" }

A value that is given explicitly wins over that of the library.  An oil brings its law of shear thinning, see
`oil_rheology`.  The case holds numbers only, so that a stored run does
not change with the library; the name of the oil and its temperature stay in `lubricant.reference`.
"""

from collections.abc import Mapping
from inspect import Parameter, signature
from typing import Any

from ertel.case.records import oil_data, show, show_key
from ertel.inputs import library, oils
from ertel.inputs.messages import ConfigError
from ertel.inputs.oil_rheology import completed
from ertel.physics.oils import RHEOLOGY, NamedOil
from ertel.physics.units import DENSITY, STRESS

OIL_KEYS, MATERIAL_KEYS = ("oil", "temperature"), ("material_1", "material_2")
OF_PRESSURE = ("alpha", "z", "p0")  # a given one makes the law Roelands', unless the law is given too
DIMENSIONLESS = ("M", "L", "lambda_bar", "alpha_bar")


def without_names(data: Mapping[str, Any]) -> dict[str, Any]:
    """The plain data of a case with the numbers of the oil and the materials that it names.

    Raises ConfigError, naming the field, for a name that is not in the library or a temperature outside its data.
    """
    found = dict(data)
    for section, keys, resolve in (("lubricant", OIL_KEYS, _lubricant), ("contact", MATERIAL_KEYS, _contact)):
        written = found.get(section)
        if isinstance(written, Mapping) and any(key in written for key in keys):
            try:
                found[section] = resolve(written, data)
            except ConfigError as error:
                raise ConfigError(f"{section}.{error}") from error
    return found


def _only_newtonian(data: Mapping[str, Any]) -> str:
    """Why a case takes Newtonian oils only; empty if it takes others."""
    contact, solver = (found if isinstance(found := data.get(name), Mapping) else {} for name in ("contact", "solver"))
    if any(key in contact for key in DIMENSIONLESS):
        return "because a dimensionless case has no stresses in Pa"
    return 'because solver.method = "radial" takes no other oils' if solver.get("method") == "radial" else ""


def _lubricant(written: Mapping[str, Any], data: Mapping[str, Any]) -> dict[str, Any]:
    given = {key: value for key, value in written.items() if key not in OIL_KEYS}
    if "oil" not in written:
        raise ConfigError(
            f"temperature = {show(written['temperature'])}: needs lubricant.oil, one of {', '.join(oils.names())}; or "
            "give eta0 and alpha at the temperature of the inlet instead"
        )
    oil = oil_of(written["oil"])
    if "temperature" not in written:
        raise ConfigError(f'temperature: missing; oil = {show(written["oil"])} needs it, for example "40 degC"')
    temperature = written["temperature"]
    if not isinstance(temperature, str):
        raise ConfigError(f'temperature = {show(temperature)}: must be a temperature with its unit, such as "40 degC"')
    reason = _only_newtonian(data)
    known = oil_data(oils.oil_at(oil, temperature, "newtonian" if reason or "rheology" in given else None))
    if reason and "rheology" not in given:
        known["reference"] += f"{RHEOLOGY}Newtonian, {reason}."
    law = completed(given.get("rheology", known["rheology"]), oil, library.parse_temperature(temperature))
    if any(key in given for key in OF_PRESSURE) and not isinstance(known["viscosity"], str):
        known["viscosity"] = "roelands"
    if given and "reference" not in given:
        known["reference"] += f" Given: {', '.join(given)}."
        known["reference"] += "".join(f"{RHEOLOGY}{source}." for source in law.sources)
    return {**known, **given, "rheology": law.law}


def oil_of(written: Any) -> NamedOil:
    """The oil of a name, or of a data sheet.  Raises ConfigError, naming the key `oil`, where it is neither."""
    if not isinstance(written, Mapping):
        return oils.get(written)
    known = signature(oils.sheet).parameters
    if unknown := [key for key in written if key not in known]:
        raise ConfigError(f"oil.{show_key(unknown[0])}: unknown key; a data sheet has {', '.join(known)}")
    if missing := [key for key, value in known.items() if value.default is Parameter.empty and key not in written]:
        raise ConfigError(f'oil.{missing[0]}: missing; a data sheet has nu40, nu100 ("68 mm^2/s") and density')
    try:
        return oils.sheet(**written)
    except ConfigError as error:
        raise ConfigError(f"oil.{error}") from error


def _contact(written: Mapping[str, Any], data: Mapping[str, Any]) -> dict[str, Any]:
    given = {key: value for key, value in written.items() if key not in MATERIAL_KEYS}
    known: dict[str, Any] = {}
    for number, key in enumerate(MATERIAL_KEYS, 1):
        if key not in written:
            continue
        if any(name in given for name in DIMENSIONLESS):
            raise ConfigError(f"{key} = {show(written[key])}: a dimensionless contact has no materials; leave it out")
        try:
            body = library.material(written[key]).elasticity.data
        except ConfigError as error:
            raise ConfigError(str(error).replace("material = ", f"{key} = ", 1)) from error
        if "E_prime" not in given:
            known |= {f"E{number}": f"{body.E!r} {STRESS.unit}", f"nu{number}": body.nu}
        if key == "material_1" and given.get("kind", "impact") == "impact" and "mass" not in given:
            known["ball_density"] = f"{body.density!r} {DENSITY.unit}"
    return {**known, **given}
