"""The keys of case files: explained at the records, and from there in the table of the documents."""

import subprocess
import sys
from dataclasses import fields
from inspect import signature
from pathlib import Path

import pytest

from ertel.case import case
from ertel.case.definition import SECTIONS
from ertel.case.sections import SOLVERS
from ertel.inputs import layout, oils
from ertel.inputs.layout import DataSheet
from ertel.inputs.quantities import parse_quantity, parse_temperature
from ertel.physics.lubricant import DENSITY_PRESSURE, P0_ROELANDS
from ertel.physics.units import STRESS, TEMPERATURE, Unit, marks, meanings

PAGE = Path(__file__).parents[2] / "examples" / "README.md"
PLACES = {place.title: place for place in layout.places()}


def key(place: str, name: str) -> layout.Key:
    return next(found for found in PLACES[place].keys if found.name == name)


def test_the_table_of_the_documents_is_the_printed_one():
    """To renew it: `ertel schema --table`."""
    page = PAGE.read_text(encoding="utf-8")
    start, end = "<!-- keys -->\n", "<!-- end of the keys -->"
    printed = [sys.executable, "-m", "ertel", "schema", "--table"]  # a process of its own: other tests register laws
    told = subprocess.run(printed, capture_output=True, text=True, check=True, encoding="utf-8").stdout
    assert page[page.index(start) + len(start) : page.index(end)].strip() == told.strip()


def test_the_table_has_all_sections():
    sections = {title.strip("[]") for title in PLACES if title.startswith("[")}
    assert sections == set(case.KEYS) - {"name", "schema"}


@pytest.mark.parametrize("title", [title for title in PLACES if "test" not in title])
def test_every_key_is_explained(title):
    """A new field of a record needs a `Meaning`."""
    assert [found.name for found in PLACES[title].keys if not found.meaning.text] == []


def test_keys_of_a_data_sheet():
    assert {item.name for item in fields(DataSheet)} == signature(oils.data_sheet).parameters.keys() - {"temperature"}


@pytest.mark.parametrize(
    ("place", "name", "default"),
    [
        ("[solver]", "nodes", "257"),
        ("[solver]", "half_width", "2.0 (2d), 4.0 (radial), 3.0 (steady, transient)"),
        ("[solver]", "method", '"2d" (impact), "steady" (rolling)'),
        ("[solver]", "fold", "true"),
        ("[time]", "until", '"max-approach" (impact), 6.0 (rolling)'),
        ("[time]", "start_approach", "-1.0"),
        ("[contact]", "radius", ""),
        ("[output]", "interval", "0.1"),
    ],
)
def test_defaults_are_said(place, name, default):
    assert key(place, name).default == default


def test_the_defaults_of_the_methods_differ_where_it_is_said():
    assert {solver.half_width for solver in SOLVERS.values()} == {2.0, 3.0, 4.0}


@pytest.mark.parametrize("name", SECTIONS)
def test_examples_can_be_read(name):
    """Examples of quantities have the unit of their key, and sizes that it takes."""
    record = SECTIONS[name].record
    for field, meaning in meanings(record).items():
        mark = marks(record).get(field)
        if isinstance(mark, Unit) and isinstance(meaning.example, str) and field != "until":
            is_temperature = mark is TEMPERATURE  # which has an offset
            assert parse_temperature(meaning.example) if is_temperature else parse_quantity(meaning.example, mark.in_si)


@pytest.mark.parametrize(
    ("place", "name", "value"),
    [
        ("[lubricant]", "p0", P0_ROELANDS),
        ('density = { law = "dowson-higginson" }', "p1", DENSITY_PRESSURE),
        ('rheology = { law = "limited" }', "ambient", 4e6),
    ],
)
def test_defaults_that_are_quantities(place, name, value):
    assert parse_quantity(key(place, name).default.strip('"'), STRESS) == value
