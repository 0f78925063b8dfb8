"""`ertel oils`: the library on the command line."""

import json

import pytest
from cases import ertel_

from ertel.inputs import materials, oils


def test_the_library():
    said = ertel_("oils").output
    assert all(name in said for name in (*oils.names(), *materials.names()))
    assert "…" not in said
    assert "14.9" in next(line for line in said.splitlines() if line.startswith("squalane"))


@pytest.mark.parametrize("name", [*oils.names(), *materials.names()])
def test_all_data_of_one(name):
    said = ertel_("oils", name).output
    assert said.startswith(f"{name}: ")
    assert said.count("source: ") >= 2


def test_json():
    data = json.loads(ertel_("oils", "--json").output)
    assert [oil["name"] for oil in data["oils"]] == list(oils.names())
    one = json.loads(ertel_("oils", "squalane", "--json").output)
    assert one in data["oils"]
    assert one["viscosity"]["nu40"] == 18.73e-6


def test_an_unknown_name():
    assert 'NAME = "wood": allowed: iso-vg-100' in ertel_("oils", "wood", code=2).output
