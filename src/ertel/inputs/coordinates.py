"""The coordinates of a study: the values that vary, quantities in SI, with what a reader must know of them."""

from collections.abc import Mapping, Sequence
from typing import Any

from ertel.case.records import OIL_LAWS, show
from ertel.inputs.layout import SECTIONS, DataSheet
from ertel.inputs.quantities import parse_quantity
from ertel.inputs.studies import Axis, Place, Study
from ertel.physics.motion import Oscillation
from ertel.physics.registry import SHAPES
from ertel.physics.units import Mark, Unit, marks, meanings

Coordinate = tuple[list[float] | list[str], dict[str, str]]  # values, and attributes: long_name, field, units


def coordinates(study: Study) -> dict[str, Coordinate]:
    """The values along each axis by its name: the last part of its key, more of it where two are alike.

    What is no number, a law or the name of an oil, is a text.
    """
    short = [str(axis.place[-1]) for axis in study.axes]
    found = {}
    for axis, name in zip(study.axes, short, strict=True):
        unique = name if short.count(name) == 1 else "_".join(_spoken(part) for part in axis.place)
        found[unique] = _coordinate(axis, _records(axis.place, study.data))
    return found


def _spoken(part: str | int) -> str:
    """A part of a place; tables are counted from one, as in messages."""
    return str(part + 1) if isinstance(part, int) else part


def _coordinate(axis: Axis, records: Sequence[Any]) -> Coordinate:
    key = str(axis.place[-1])
    mark = next((marks(record)[key] for record in records if key in marks(record)), None)
    meaning = next((meanings(record)[key].text for record in records if key in meanings(record)), key)
    about = {"long_name": meaning, "field": axis.field}
    if all(isinstance(value, int | float) for value in axis.values):
        unit = mark.own if isinstance(mark, Unit) and mark.scale else ""
        return [float(value) for value in axis.values], {
            **about,
            "units": "1",
            **({"in_units_of": unit} if unit else {}),
        }
    in_si = _in_si(axis.values, mark)
    if in_si is not None and isinstance(mark, Unit):
        return in_si, {**about, "units": mark.unit}
    return [value if isinstance(value, str) else show(value) for value in axis.values], about


def _in_si(values: Sequence[Any], mark: Mark | None) -> list[float] | None:
    """Quantities in SI; None where they are none, or not all of them."""
    if not isinstance(mark, Unit) or not all(isinstance(value, str) for value in values):
        return None
    try:
        return [parse_quantity(value, mark.in_si) or 0.0 for value in values]
    except ValueError:  # an event in the place of a time
        return None


def _records(place: Place, data: Mapping[str, Any]) -> list[Any]:
    """The records (classes) whose fields a key may be."""
    section, *inner = place
    if section == "roughness":
        shape = data["roughness"][inner[0]].get("shape")
        return [SHAPES[shape]] if shape in SHAPES else []
    if len(inner) == 1:
        part = SECTIONS[str(section)]
        return [record for record in (part.named, part.record) if record]
    if section == "motion":
        return [Oscillation]
    if inner[0] == "oil":
        return [DataSheet]
    return _law(inner, data[str(section)])


def _law(inner: Sequence[Any], table: Mapping[str, Any]) -> list[Any]:
    """The law whose key a place in [lubricant] is; a law may stand inside of another one."""
    laws: Mapping[str, Any] = OIL_LAWS.get(str(inner[0]), {})
    for part in inner[:-1]:
        table = table[part]
    law = table.get("law")
    return [laws[law]] if isinstance(law, str) and law in laws else []
