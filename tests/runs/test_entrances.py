"""What public functions take for a case: a case, its plain data, a case file; NumPy's numbers; else one sentence."""

import re
from pathlib import Path

import numpy as np
import pytest

import ertel
from ertel.inputs.studies import parse_study

DATA = {"contact": {"M": 200, "L": 10}, "solver": {"method": "radial", "nodes": 33}, "time": {"until": 0.05}}


@pytest.fixture
def file(tmp_path) -> Path:
    path = tmp_path / "case.toml"
    path.write_text(ertel.to_toml(ertel.parse_case(DATA)))
    return path


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_case_may_be_a_path_or_a_mapping(file, tmp_path):
    case = ertel.parse_case(DATA)
    for given in (case, DATA, file, str(file)):
        assert ertel.simulate(given).case == case
    assert ertel.run(str(file), tmp_path / "run").case == ertel.run(DATA, tmp_path / "run").case == case


@pytest.mark.parametrize("given", [5, b"case.toml"])
def test_anything_else_is_one_sentence(given):
    said = f"^case = {re.escape(repr(given))}: must be a Case, a mapping, or the path of a case file$"
    for entrance, *more in ((ertel.simulate,), (ertel.run, "nowhere"), (ertel.to_toml,)):
        with pytest.raises(ertel.ConfigError, match=said):
            entrance(given, *more)
    for respond in (ertel.respond, ertel.respond_linearly, ertel.respond_in_rolling):
        with pytest.raises(ertel.ConfigError, match=said):
            respond(given, [])
    with pytest.raises(ertel.ConfigError, match=said):
        ertel.traction(given, slide_to_roll=[0.1])
    for reader, said in (
        (ertel.parse_case, "^data = .*: must be a mapping; load_case reads"),
        (ertel.load_case, "^path = .*: must be the path of a case file; parse_case takes"),
        (lambda study: ertel.sweep(study, "nowhere"), "^study = .*: must be the path of a case file, or a mapping"),
        (ertel.open, "^directory = .*: must be the path of a run directory"),
    ):
        with pytest.raises(ertel.ConfigError, match=said):
            reader(given)


@pytest.mark.parametrize("jobs", [1.5, "2", 0])
def test_who_does_the_runs(jobs, tmp_path):
    with pytest.raises(ertel.ConfigError, match=r"^jobs = .*: must be one or more, a whole number$"):
        ertel.sweep({**DATA, "contact": {"M": [20, 30], "L": 5}}, tmp_path / "nowhere", jobs=jobs)
    assert not (tmp_path / "nowhere").exists()


NUMPY = {
    "contact": {"M": np.float32(200), "L": np.int64(10)},
    "solver": {"method": np.str_("radial"), "nodes": np.int64(33)},
    "time": {"until": np.float64(0.05)},
}


def test_numbers_of_numpy_in_plain_data():
    case = ertel.parse_case(NUMPY)
    assert case == ertel.parse_case(DATA) and case.digest == ertel.parse_case(DATA).digest
    points = [(np.int64(0), np.float32(1)), (np.float64(1), np.int64(2))]
    signal = ertel.parse_case({"contact": {"M": 20, "L": 5}, "motion": {"load": points}})
    assert signal.motion.load(0.5) == 1.5
    for M in (list(np.array([100, 200])), np.str_("100:200:2")):
        study = parse_study({**NUMPY, "contact": {"M": M, "L": np.int64(10)}})
        assert [case.contact.M for case in study.cases] == [100, 200]
