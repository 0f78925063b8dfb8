"""Laws of shear thinning whose data come from a named oil.

    oil = "squalane"
    temperature = "25 degC"                     # with the law of the library
    rheology = { law = "carreau", n = 0.5 }     # a value given explicitly wins; "newtonian": none

A named oil whose law of shear thinning is in the library at this temperature has that law, unless the case names
another one or is one that only Newtonian oils have: dimensionless, or by the radial method.  All other oils are
Newtonian unless the case names a law.
"""

from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any, NamedTuple

from ertel.case.records import data_of, law_fields, show
from ertel.inputs.messages import ConfigError
from ertel.physics.fluidity import Carreau, Limited
from ertel.physics.oils import NamedOil, Sourced

OF_OILS: Mapping[str, tuple[Any, str]] = {  # name of a law: its record, and the field of NamedOil with its data
    "carreau": (Carreau, "shear"),
    "limited": (Limited, "limiting_stress"),
}


class Completed(NamedTuple):
    """The plain data of a law, and the sources of what the oil's data filled in; none if nothing was missing."""

    law: Any
    sources: tuple[str, ...] = ()


def completed(law: Any, oil: NamedOil, T: float, place: str = "rheology") -> Completed:
    """The plain data of a law of shear thinning, with what they leave out taken from the oil's data at T (K).

    Raises ConfigError if the oil lacks these data, or has them at other temperatures only.
    """
    table = {"law": law} if isinstance(law, str) else law
    name = table.get("law") if isinstance(table, Mapping) else None
    if not isinstance(name, str) or name not in OF_OILS:
        return Completed(law)
    record, field = OF_OILS[name]
    inside = {key: completed(table[key], oil, T, f"{place}.{key}") for key in law_fields(record) if key in table}
    sources = tuple(source for found in inside.values() for source in found.sources)
    table = {**table, **{key: found.law for key, found in inside.items()}}
    missing = [key for key in _needed(record) if key not in table]
    if not missing:
        return Completed(table, sources)
    part = getattr(oil, field)
    if complaint := _complaint(part, oil.name, T, " and ".join(missing)):
        advice = f'give {{ law = "{name}", {", ".join(f"{key} = ..." for key in missing)} }}'
        raise ConfigError(f"{place} = {show(law)}: {complaint}; {advice}")
    data = data_of(part.data)
    return Completed({**table, **{key: data[key] for key in missing}}, (*sources, part.source.rstrip(".")))


def _complaint(part: Sourced[Any] | None, oil: str, T: float, wanted: str) -> str:
    """Why the data of an oil cannot be used, or "" if they can."""
    if part is None:
        return f"the library has no {wanted} of {oil}"
    return part.missing_at(T, wanted, oil)


def _needed(record: Any) -> list[str]:
    """The numbers that a law must be given."""
    return [item.name for item in fields(record) if item.default is MISSING and item.name not in law_fields(record)]
