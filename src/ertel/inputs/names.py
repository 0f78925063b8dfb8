"""Oils and materials by name in a case: replaced by their numbers, which then define the case.

    [contact]                        [lubricant]
    material_1 = "steel"             oil = "squalane"
    material_2 = "glass"             temperature = "40 degC"

An oil that is not in the library is described by its data sheet:

    oil = { nu40 = "68 mm^2/s", nu100 = "8.7 mm^2/s", density = "880 kg/m^3" }

A value that is given explicitly wins over that of the library.  The case holds numbers only, so that a stored run does
not change with the library; the name of the oil and its temperature stay in `lubricant.reference`.

A named oil whose law of shear thinning is in the library at this temperature has that law, unless the case names
another one or is one that only Newtonian oils have: dimensionless, or by the radial method.  All other oils are
Newtonian unless the case names a law, whose data may come from the oil too:

    rheology = { law = "carreau", n = 0.5 }     # G from the library; "newtonian": none

The section [thermal] takes from the oil and from the materials what it does not give.
"""

from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from ertel.case.case import Case
from ertel.case.estimates import LARGEST_NEWTONIAN_STRESS, newtonian_stress
from ertel.case.methods import METHODS, as_written
from ertel.case.reading import Reader
from ertel.case.records import ConfigError, data_of, law_fields, named, oil_data, show, with_unit
from ertel.case.sections import Thermal
from ertel.inputs import oils
from ertel.inputs.layout import READER, DataSheet, Machines, Materials, NamedLubricant, field_names
from ertel.inputs.quantities import parse_temperature
from ertel.physics.fluidity import Carreau, Limited
from ertel.physics.materials import RHEOLOGY, NamedOil, Sourced
from ertel.physics.units import DENSITY, STRESS, Unit, fields_of, marks

OIL_KEYS, MATERIAL_KEYS = field_names(NamedLubricant), field_names(Materials)
OF_PRESSURE = ("alpha", "z", "p0")  # a given one makes the law Roelands', unless the law is given too
FOLLOWING = ("slide_to_roll", "speed_1", "speed_2", "radius", "radius_1", "radius_2")  # from a gear or a cam, too
DIMENSIONLESS = ("M", "L", "lambda_bar", "alpha_bar")


def without_names(data: Mapping[str, Any], folder: Path = Path(), reader: Reader = READER) -> dict[str, Any]:
    """The plain data of a case with the numbers of the oil and the materials that it names.

    folder: that in which the file lubricant.oils lies.  reader: of quantities.  Raises ValueError, naming the field,
    for a name that is not in the library, a temperature outside its data, and data of [thermal] that are missing.
    """
    data = _with_machine(data)
    (lubricant,) = _tables(data, "lubricant")
    if isinstance(file := lubricant.get("oils"), str):
        data = {**data, "lubricant": {**lubricant, "oils": str(folder / file)}}
    resolved = _with_thermal_data(_with_hardness(data), reader)
    for section, keys, resolve in (("lubricant", OIL_KEYS, _lubricant), ("contact", MATERIAL_KEYS, _contact)):
        written = data.get(section)
        if isinstance(written, Mapping) and any(key in written for key in keys):
            resolved[section] = named(section, resolve, written, data)
    return resolved


def _with_hardness(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """The data with the hardness of the softer named body, for asperities that have none of their own."""
    surfaces, contact = _tables(data, "surfaces", "contact")
    bodies = [oils.material(contact[key]) for key in MATERIAL_KEYS if contact.get(key) in oils.material_names()]
    asperities = surfaces.get("asperities")
    if isinstance(asperities, Mapping) and asperities.get("law") == "exponential":
        return data  # it does not say the area that touches
    known = [body.strength.data.hardness for body in bodies if body.strength]
    if not known or not asperities or surfaces.get("hardness") is not None:
        return data
    return {**data, "surfaces": {**surfaces, "hardness": with_unit(min(known), STRESS)}}


def _with_machine(data: Mapping[str, Any]) -> dict[str, Any]:
    """The data with the sections that follow from a machine part in [motion]."""
    (motion,) = _tables(data, "motion")
    given = [name for name in field_names(Machines) if name in motion]
    if not given:
        return dict(data)
    place, data = f"motion.{given[0]}", {**data, "motion": {key: motion[key] for key in motion if key not in given}}
    if len(given) > 1:
        raise ConfigError(f"{place}: is given together with motion.{given[1]}; allowed: one of them")
    part = READER.record(fields_of(Machines)[given[0]].options[0], motion[given[0]], place)
    for name, section in named(place, lambda: part.passage.sections).items():
        (table,) = _tables(data, name)
        for key in (*section, *FOLLOWING) if name in ("contact", "motion") else ():
            if key in table and key != "kind":
                raise ConfigError(f"{name}.{key} = {show(table[key])}: follows from {place}; leave it out")
        for key in {"kind", "method"} & section.keys():
            if table.get(key, section[key]) != section[key]:
                raise ConfigError(
                    f"{name}.{key} = {show(table[key])}: {place} makes a rolling contact in time; leave it out"
                )
        data[name] = {**section, **table}
    return dict(data)


def _tables(data: Mapping[str, Any], *names: str) -> Iterator[Mapping[str, Any]]:
    """Some sections of a case; an empty one for what is missing or not a table."""
    for name in names:
        section = data.get(name)
        yield section if isinstance(section, Mapping) else {}


def _only_newtonian(data: Mapping[str, Any]) -> str:
    """Why a case takes Newtonian oils only; empty if it takes others."""
    contact, solver = _tables(data, "contact", "solver")
    if any(key in contact for key in DIMENSIONLESS):
        return "because a dimensionless case has no stresses in Pa"
    method = METHODS.get(str(solver.get("method")))
    return f"because {as_written([method])} takes no other oils" if method and not method.supports.thinning else ""


def _lubricant(written: Mapping[str, Any], data: Mapping[str, Any]) -> dict[str, Any]:
    given = {key: value for key, value in written.items() if key not in OIL_KEYS}
    if "oils" in written and "oil" not in written:
        raise ConfigError(f"oils = {show(written['oils'])}: needs lubricant.oil, the name of an oil in it")
    if "oil" not in written:
        needs = f"needs lubricant.oil, one of {', '.join(oils.names())}"
        instead = "or give eta0 and alpha at the temperature of the inlet instead"
        raise ConfigError(f"temperature = {show(written['temperature'])}: {needs}; {instead}")
    oil = oil_of(written)
    if "temperature" not in written:
        raise ConfigError(f'temperature: missing; oil = {show(written["oil"])} needs it, for example "40 degC"')
    temperature = written["temperature"]
    if not isinstance(temperature, str):
        raise ConfigError(f'temperature = {show(temperature)}: must be a temperature with its unit, such as "40 degC"')
    reason = _only_newtonian(data)
    numbers = oil_data(oils.oil_at(oil, temperature, "newtonian" if reason or "rheology" in given else None))
    if reason and "rheology" not in given:
        numbers["reference"] += f"{RHEOLOGY}Newtonian, {reason}."
    rheology, sources = completed(given.get("rheology", numbers["rheology"]), oil, parse_temperature(temperature))
    if any(key in given for key in OF_PRESSURE) and not isinstance(numbers["viscosity"], str):
        numbers["viscosity"] = "roelands"
    if given and "reference" not in given:
        numbers["reference"] += f" Given: {', '.join(given)}."
        numbers["reference"] += "".join(f"{RHEOLOGY}{source}." for source in sources)
    return {**numbers, **given, "rheology": rheology}


def oil_of(lubricant: Mapping[str, Any]) -> NamedOil:
    """The oil that [lubricant] names, or describes by its data sheet.  Raises ValueError, naming the key."""
    written, file = lubricant["oil"], lubricant.get("oils")
    if isinstance(written, Mapping):
        return oils.oil_of_sheet(READER.record(DataSheet, written, "oil"), "oil.")
    if not isinstance(file, str | None):
        raise ConfigError(f"oils = {show(file)}: must be the path of a file of oils")
    try:
        return oils.get(written, file)
    except ConfigError as error:  # of the name, or of the file
        raise ConfigError(str(error) if str(error).startswith("oil = ") else f"oils: {error}") from error


def _contact(written: Mapping[str, Any], data: Mapping[str, Any]) -> dict[str, Any]:
    given = {key: value for key, value in written.items() if key not in MATERIAL_KEYS}
    numbers: dict[str, Any] = {}
    for number, key in enumerate(MATERIAL_KEYS, 1):
        if key not in written:
            continue
        if any(name in given for name in DIMENSIONLESS):
            raise ConfigError(f"{key} = {show(written[key])}: a dimensionless contact has no materials; leave it out")
        try:
            body = oils.material(written[key]).elasticity.data
        except ConfigError as error:
            raise ConfigError(str(error).replace("material = ", f"{key} = ", 1)) from error
        if "E_prime" not in given:
            numbers |= {f"E{number}": f"{body.E!r} {STRESS.unit}", f"nu{number}": body.nu}
        if key == "material_1" and given.get("kind", "impact") == "impact" and "mass" not in given:
            numbers["ball_density"] = f"{body.density!r} {DENSITY.unit}"
    return {**numbers, **given}


# -- laws of shear thinning whose data come from a named oil ----------------------------------------------------------

OF_OILS: Mapping[str, tuple[Any, str]] = {  # name of a law: its record, and the field of NamedOil with its data
    "carreau": (Carreau, "shear"),
    "limited": (Limited, "limiting_stress"),
}


def completed(law: Any, oil: NamedOil, T: float, place: str = "rheology") -> tuple[Any, tuple[str, ...]]:
    """The plain data of a law of shear thinning, with what they leave out taken from the oil's data at T (K).

    Returns also the sources of what was taken.  Raises ConfigError if the oil lacks these data, or has them at other
    temperatures only.
    """
    table = {"law": law} if isinstance(law, str) else law
    name = table.get("law") if isinstance(table, Mapping) else None
    if not isinstance(name, str) or name not in OF_OILS:
        return law, ()
    record, field = OF_OILS[name]
    table = dict(table)
    sources: tuple[str, ...] = ()
    for key in law_fields(record):
        if key in table:
            table[key], inside = completed(table[key], oil, T, f"{place}.{key}")
            sources += inside
    needed = (item.name for item in fields(record) if item.default is MISSING)
    missing = [key for key in needed if key not in table and key not in law_fields(record)]
    if not missing:
        return table, sources
    part: Sourced[Any] | None = getattr(oil, field)
    names = " and ".join(missing)
    complaint = part.missing_at(T, names, oil.name) if part else f"the library has no {names} of {oil.name}"
    if part is None or complaint:
        advice = f'give {{ law = "{name}", {", ".join(f"{key} = ..." for key in missing)} }}'
        raise ConfigError(f"{place} = {show(law)}: {complaint}; {advice}")
    data = data_of(part.data)
    return {**table, **{key: data[key] for key in missing}}, (*sources, part.source.rstrip("."))


# -- temperatures: [thermal] completed from the oil and the materials that the case names -----------------------------


def _with_thermal_data(data: Mapping[str, Any], reader: Reader) -> dict[str, Any]:
    """The plain data of a case, its section [thermal] complete with the data of the named oil and bodies.

    Raises ValueError, naming the key and what to give, for what is missing and for what is not a temperature.
    """
    if not isinstance(data.get("thermal"), Mapping):
        return dict(data)
    lubricant, contact = _tables(data, "lubricant", "contact")
    given = {key: value for key, value in data["thermal"].items() if value is not None}
    if "temperature" in lubricant:
        given.setdefault("temperature", lubricant["temperature"])
    T = _inlet_temperature(given, lubricant, reader)
    units = {key: mark for key, mark in marks(Thermal).items() if isinstance(mark, Unit)}
    library = _of_the_library(lubricant, contact, T)
    completed = {**{key: with_unit(value, units[key]) for key, value in library.items()}, **given}
    needed = {item.name for item in fields(Thermal) if item.default is MISSING}
    missing = [key for key in units if key in needed and key not in completed]
    if T is None and "oil" in lubricant:  # which has these at a temperature
        missing = [key for key in missing if key == "temperature" or key.endswith(("_1", "_2"))]
    if missing:
        more = f"; missing are also {', '.join(missing[1:])}" if missing[1:] else ""
        advice = _advice(missing[0], units[missing[0]], lubricant, contact)
        raise ValueError(f"thermal.{missing[0]}: missing; {advice}{more}")
    return {**data, "thermal": completed}


def _inlet_temperature(given: Mapping[str, Any], lubricant: Mapping[str, Any], reader: Reader) -> float | None:
    """The temperature of the inlet (K), which must be that of the named oil; None if it is missing."""
    T, of_oil = (
        reader.values(Thermal, {"temperature": section.get("temperature")}, name).get("temperature")
        for name, section in (("thermal", given), ("lubricant", lubricant))
    )
    if of_oil is not None and T != of_oil:
        other = f"lubricant.temperature = {show(lubricant['temperature'])}, for which eta0 and alpha hold"
        given_T = f"thermal.temperature = {show(given['temperature'])}"
        raise ValueError(f"{given_T}: differs from {other}; leave thermal.temperature out")
    return T


def _of_the_library(lubricant: Mapping[str, Any], contact: Mapping[str, Any], T: float | None) -> dict[str, float]:
    """Data in SI of the named oil (or of a data sheet) at T (K), and of the named bodies."""
    data: dict[str, float] = {}
    if T is not None and "oil" in lubricant:
        oil = named("lubricant", oil_of, lubricant)
        data |= {"beta": oil.thinning_at(T), "density": oil.density_at(T), "expansion": oil.expansion_at(T)}
        data |= vars(oil.thermal.data) if oil.thermal else {}
    for number, key in enumerate(MATERIAL_KEYS, 1):
        if contact.get(key) in oils.material_names():
            body = oils.material(contact[key])
            solid = {"density": body.elasticity.data.density, **(vars(body.thermal.data) if body.thermal else {})}
            data |= {f"{name}_{number}": value for name, value in solid.items()}
    return data


def _advice(key: str, unit: Unit, lubricant: Mapping[str, Any], contact: Mapping[str, Any]) -> str:
    """Advice for a key of [thermal] that is missing."""
    if key == "temperature":
        return 'give that of the oil in the inlet, for example "40 degC"'
    place, name, section = ("lubricant", "oil", lubricant)
    if key.endswith(("_1", "_2")):
        place, name, section = ("contact", f"material_{key[-1]}", contact)
    example = f'give it, for example "{unit.example}"'
    if section.get(name) is None:
        return f"{example}, or name the {name.partition('_')[0]}, {place}.{name}"
    return f"the library has none for {place}.{name} = {show(section[name])}, {example}"


def require_rheology(case: Case, lubricant: object) -> None:
    """Refuse temperatures of a sliding contact whose oil is Newtonian only because the case does not say how it thins.

    lubricant: the section as it is written.  With rheology = "newtonian" they are computed.  Raises ConfigError.
    """
    given = isinstance(lubricant, Mapping) and "rheology" in lubricant
    stress = newtonian_stress(case) if case.thermal and case.oil.is_newtonian and not given else 0.0
    if stress > LARGEST_NEWTONIAN_STRESS:
        mean = f"a Newtonian oil would have a mean shear stress of about {stress / 1e6:.2g} MPa here"
        why = f"[thermal] needs it, because {mean} and oils begin to thin at some MPa"
        example = '{ law = "ree-eyring", tau0 = "5 MPa" }, or "newtonian" to have that heat computed'
        raise ConfigError(f"lubricant.rheology: missing; {why}; give for example {example}")
