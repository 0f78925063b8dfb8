"""Texts made of the records: the table of all keys, and the JSON schema, which refuses wrong units and unknown keys."""

import tomllib
from copy import deepcopy
from dataclasses import fields
from inspect import signature
from pathlib import Path

import jsonschema
import pytest
from cases import SHEET, python

from ertel.case import case
from ertel.case.sections import SECTIONS
from ertel.inputs import layout, oils
from ertel.inputs.case_files import load_case
from ertel.inputs.layout import DataSheet
from ertel.inputs.quantities import parse_quantity
from ertel.inputs.templates import json_schema
from ertel.physics.lubricant import DENSITY_PRESSURE, P0_ROELANDS
from ertel.physics.registry import DENSITY_LAWS, FLUIDITY_LAWS, SHAPES, VISCOSITY_LAWS
from ertel.physics.units import STRESS, Unit, marks, meanings

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))
REGISTRIES = VISCOSITY_LAWS, DENSITY_LAWS, FLUIDITY_LAWS, SHAPES
# of tests that were imported before: their authors explain nothing
OF_TESTS = {name for known in REGISTRIES for name in known if not known[name].__module__.startswith("ertel.")}
PLACES = {place.title: place for place in layout.places()}
SCHEMA = json_schema()
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)


def test_the_table_of_the_documents_is_the_printed_one():
    """With all defaults.  To renew it: `python docs/keys.py`."""
    page = (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
    start, end = "<!-- keys -->\n", "<!-- end of the keys -->"
    told = python(str(ROOT / "docs" / "keys.py")).stdout  # a process of its own: other tests register laws
    assert page[page.index(start) + len(start) : page.index(end)].strip() == told.strip()


def properties(schema):
    """All keys in a schema and in the schemas in it, with what it says of them; without the tests' own laws."""
    if isinstance(schema, list):
        for item in schema:
            yield from properties(item)
    elif isinstance(schema, dict):
        keys = schema.get("properties", {})
        if not OF_TESTS & {keys.get(name, {}).get("const") for name in ("law", "shape")}:
            yield from keys.items()
        for item in schema.values():
            yield from properties(item)


def test_all_sections_are_there_and_every_key_is_explained():
    """A new field of a record needs a `Meaning`."""
    sections = {title.strip("[]") for title in PLACES if title.startswith("[")}
    assert sections == set(case.KEYS) - {"name", "schema"}
    assert {item.name for item in fields(DataSheet)} == signature(oils.data_sheet).parameters.keys() - {"temperature"}
    assert {key for key, value in properties(SCHEMA) if not value.get("description")} == {"law", "shape"}
    explained = [place for title, place in PLACES.items() if not any(f'"{name}"' in title for name in OF_TESTS)]
    assert [(place.title, key.name) for place in explained for key in place.keys if not key.meaning.text] == []


@pytest.mark.parametrize("name", SECTIONS)
def test_examples_of_quantities_can_be_read(name):
    """They have the unit of their key, and sizes that it takes."""
    record = SECTIONS[name].record
    for field, meaning in meanings(record).items():
        mark = marks(record).get(field)
        if isinstance(mark, Unit) and isinstance(meaning.example, str) and field != "until":
            assert parse_quantity(meaning.example, mark.in_si)


def test_defaults_that_are_written_by_hand_are_those_of_the_records():
    for place, name, value in (
        ("[lubricant]", "p0", P0_ROELANDS),
        ('density = { law = "dowson-higginson" }', "p1", DENSITY_PRESSURE),
        ('rheology = { law = "limited" }', "ambient", 4e6),
    ):
        (key,) = (found for found in PLACES[place].keys if found.name == name)
        assert parse_quantity(key.default.strip('"'), STRESS) == value


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_cases_and_valid(path):
    assert list(VALIDATOR.iter_errors(tomllib.loads(path.read_text(encoding="utf-8")))) == []
    found = load_case(path)
    assert found.name == path.stem
    assert found.on_half_grid().solver.nodes == (found.solver.nodes + 1) // 2


CASE = tomllib.loads((ROOT / "examples" / "micro_cavity.toml").read_text())
THIN = {"law": "limited", "base": {"law": "carreau", "G": "6 MPa", "n": 0.5}, "Lambda": 0.05}
RIGHT = [
    *[("contact.radius", "0.5 inch"), ("contact.mean_speed", "-9 cm / s")],
    *[("lubricant.alpha", "22 GPa^-1"), ("lubricant.eta0", "250 mPa s")],
    *[("lubricant.rheology", THIN), ("lubricant.rheology", "carreau")],
    ("lubricant.viscosity", {"law": "barus", "alpha": "22 / GPa"}),
    *[("lubricant.oil", SHEET), ("lubricant.temperature", "-5 degC")],
    *[("time.until", "max-approach"), ("time.until", "5 ms")],
    ("motion.load", [[0, 1], ["1 ms", 2.5]]),
    ("motion.load", {"mean": 1, "amplitude": 0.2, "period": "1 ms"}),
    *[("roughness.0.x", "-80 um"), ("surfaces.sigma", "Ra 40 nm")],
]
WRONG = [
    *[("contact.radius", value) for value in ("mm", "12.5", 0.0125)],
    *[("contact.radis", "1 mm"), ("contact.kind", "rowling"), ("contact.nu1", 0.7)],
    *[("lubricant.viscosity", "rolands"), ("lubricant.viscosity", {"law": "barus"})],
    ("lubricant.oil", {"nu40": "68 mm^2/s"}),
    *[("solver.nodes", 129.5), ("solver.nodes", True)],
    *[("time.until", "rebounds"), ("motion.load", [[0, 1, 2]])],
    *[("roughness.0.surface", 3), ("roughness.0.shape", "hole")],
    ("thermals", {}),
]


@pytest.mark.parametrize(("place", "value"), [*RIGHT, *WRONG], ids=str)
def test_what_is_right_and_what_is_wrong(place, value):
    data = deepcopy(CASE)
    *sections, key = place.split(".")
    target = data
    for section in sections:
        target = target[0] if section == "0" else target.setdefault(section, {})
    target[key] = value
    assert VALIDATOR.is_valid(data) == ((place, value) in RIGHT)
