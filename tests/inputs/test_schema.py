"""The keys of case files: the table in the documents names all of them with their defaults, and no others."""

import re
from collections.abc import Mapping
from dataclasses import MISSING, fields
from math import isfinite
from pathlib import Path
from typing import Any

import pytest

from ertel.inputs.schema import NAMED, case_file, keys_of
from ertel.model.conditions import Conditions
from ertel.model.sections import Drive, Output, Solver, Time
from ertel.model.thermal import Thermal
from ertel.physics.lubricant import Oil
from ertel.physics.surfaces import RingWaviness, Spot, Waviness

TABLE = Path(__file__).parents[2] / "examples" / "README.md"
SECTIONS: Mapping[str, Any] = {  # as the table calls them: the record, and keys that it does not have
    "[contact]": (Conditions, NAMED["Contact"]),
    "[lubricant]": (Oil, NAMED["Lubricant"]),
    "[solver]": (Solver, ()),
    "[motion]": (Drive, ()),
    "[[roughness]]": (None, ("shape", "surface")),
    "waviness:": (Waviness, ()),
    "rings:": (RingWaviness, ()),
    "spot:": (Spot, ()),
    "[time]": (Time, ()),
    "[output]": (Output, ()),
    "[thermal]": (Thermal, ()),
    "(top)": (None, ("name", "schema")),
}
SAME_SECTION = ("", "impact:", "rolling:")


def rows() -> list[tuple[str, list[str], str]]:
    """The table: section, keys and default of each row."""
    found, section = [], ""
    lines = [line for line in TABLE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    start = lines.index("| section | key | meaning | default |") + 2
    for line in lines[start:]:
        first, keys, _, default = (cell.strip() for cell in line.split("|")[1:-1])
        section = section if first in SAME_SECTION else first.strip("`")
        found.append((section, re.findall("`(.*?)`", keys), default))
    return found


def test_the_sections_are_those_of_the_schema():
    in_table = {section.strip("[]") for section, *_ in rows() if section.startswith("[")}
    assert in_table | {"name", "schema"} == set(keys_of(case_file()))


@pytest.mark.parametrize("section", SECTIONS)
def test_the_table_has_every_key_and_no_other(section):
    record, more = SECTIONS[section]
    known = {*more, *(item.name for item in fields(record))} if record else set(more)
    assert {key for name, keys, _ in rows() if name == section for key in keys} == known


@pytest.mark.parametrize("section", [name for name, (record, _) in SECTIONS.items() if record])
def test_the_table_has_the_defaults(section):
    defaults = {item.name: item.default for item in fields(SECTIONS[section][0])}
    for keys, said in ((keys, said) for name, keys, said in rows() if name == section):
        for value in (defaults[key] for key in keys if key in defaults and key != "p0"):
            if isinstance(value, bool) or (isinstance(value, str) and value):
                assert str(value).lower() in said, keys
            elif isinstance(value, int | float) and value is not MISSING and isfinite(value):
                assert value in [float(number) for number in re.findall(r"-?\d[\d.]*(?:e-?\d+)?", said)], keys
