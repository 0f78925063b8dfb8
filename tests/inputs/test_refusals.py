"""A wrong case is refused in one short line that begins with the place; data/refusals.toml has the cases."""

import re
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from app_runs import refused
from cases import REFUSALS, SHEET

import ertel
from ertel.case.records import show
from ertel.inputs.case_files import ConfigError, load_case, parse_case

REFUSED = [row for rows in REFUSALS["refused"].values() for row in rows]
Data = dict[str, Any]


def changed(base: str, changes: Data) -> Data:
    """A case of the table with these changes; "-" takes a key away."""
    made = dict(REFUSALS["cases"][base])
    for name, change in changes.items():
        old = made.get(name, {})
        made[name] = {**old, **change} if isinstance(change, dict) and isinstance(old, dict) else change
        if isinstance(made[name], dict):
            made[name] = {key: value for key, value in made[name].items() if value != "-"}
    return {name: section for name, section in made.items() if section != "-"}


def message(sections: Data, folder: Any = ".") -> str:
    with pytest.raises(ConfigError) as caught:
        parse_case(sections, folder)
    assert str(caught.value).isprintable() and len(str(caught.value)) < 600
    return str(caught.value)


@pytest.mark.parametrize(
    ("place", "word", "base", "changes"), REFUSED, ids=[f"{place}: {word}" for place, word, *_ in REFUSED]
)
def test_place_and_remedy_are_named(place: str, word: str, base: str, changes: Data, tmp_path) -> None:
    np.save(tmp_path / "map.npy", np.eye(20))
    found = message(changed(base, changes), tmp_path)
    assert re.match(re.escape(place) + "( = |: | and )", found) and word in found, found


def test_the_same_sentence_at_every_entrance(tmp_path: Path) -> None:
    """Of a mapping, a file, a run in Python and the commands, which write nothing."""
    file = tmp_path / "case.toml"
    for base, changes, expected in REFUSALS["golden"]["messages"]:
        data = changed(base, changes)
        file.write_text(tomli_w.dumps(data))
        for entrance in (parse_case, ertel.simulate, lambda given: ertel.run(given, tmp_path / "run")):
            with pytest.raises(ConfigError, match=f"^{re.escape(expected)}$"):
                entrance(data)
        with pytest.raises(ConfigError, match=f"^{re.escape(expected)}$"):
            load_case(file)
        for command in (("check", str(file)), ("run", str(file), "--out", str(tmp_path / "run"))):
            assert refused(*command) == f"ertel: {expected}\n"
    assert [path.name for path in tmp_path.iterdir()] == ["case.toml"]


HOSTILE = ["x" * 10**6, ["x" * 10**5] * 10, {"k" * 10**6: 1}, 10**400, -(10**400), [[[]]], "\x1b[31m\u202e"]
PLACES = "contact.M lubricant.eta0 lubricant.viscosity lubricant.reference solver.nodes solver.method solver.fold "
PLACES += "motion.load motion.entrainment time.until time.step output.interval name contact lubricant solver motion "
PLACES += "roughness time output schema"


def test_messages_stay_short_and_printable() -> None:
    for place in PLACES.split():
        section, _, key = place.partition(".")
        for value in (*HOSTILE, date(2020, 1, 1)):
            table = {**REFUSALS["cases"]["moes"].get(section, {}), key: value} if key else value
            assert message({**REFUSALS["cases"]["moes"], section: table}).startswith(section)
    for key in ("<number>", "<points>", "<table>", "<name>", "", "a.b", "two\nlines", "k" * 10**6):
        for place, data in (("", {key: 1}), ("solver.", {"solver": {key: 1}})):
            assert message({**REFUSALS["cases"]["moes"], **data}).startswith(f"{place}{show(key)} = 1: unknown key")
    for sheet in ({"k" * 3000: 1.0}, {"nu40": 10**400}):
        data = changed("bodies", {"lubricant": {"oil": SHEET | sheet, "temperature": "60 degC"}})
        assert message(data).startswith("lubricant.oil.")
    points = message(changed("rolling", {"motion": {"load": {"smooth": [[each, 1] for each in range(10_001)]}}}))
    assert "10001 points; at most 10000" in points
