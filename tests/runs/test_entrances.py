"""Cases for public functions: plain data, a file, own laws and shapes, numbers of NumPy; anything else is refused."""

import re
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any

import numpy as np
import pytest

import ertel
from ertel.inputs.studies import parse_study
from ertel.physics import units
from ertel.physics.surfaces import Feature
from ertel.results.dataset import provenance

DATA = {"contact": {"M": 200, "L": 10}, "solver": {"method": "radial", "nodes": 33}, "time": {"until": 0.05}}
CASE = ertel.parse_case(DATA)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_case_may_be_a_path_or_a_mapping(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(ertel.to_toml(CASE))
    for given in (CASE, DATA, file, str(file)):
        assert ertel.simulate(given).case == CASE
    assert ertel.run(str(file), tmp_path / "run").case == ertel.run(DATA, tmp_path / "run").case == CASE


OF_A_CASE = "case = {}: must be a Case, a mapping, or the path of a case file$"


@pytest.mark.parametrize(
    ("function", "more", "said"),
    [
        (ertel.simulate, [], OF_A_CASE),
        (ertel.run, ["nowhere"], OF_A_CASE),
        (ertel.to_toml, [], OF_A_CASE),
        (ertel.respond, [[]], OF_A_CASE),
        (ertel.respond_linearly, [[]], OF_A_CASE),
        (ertel.respond_in_rolling, [[]], OF_A_CASE),
        (partial(ertel.traction, slide_to_roll=[0.1]), [], OF_A_CASE),
        (ertel.parse_case, [], "data = {}: must be a mapping; load_case reads"),
        (ertel.load_case, [], "path = {}: must be the path of a case file; parse_case takes"),
        (ertel.sweep, ["nowhere"], "study = {}: must be the path of a case file, or a mapping"),
        (ertel.open, [], "directory = {}: must be the path of a run directory"),
    ],
)
def test_anything_else_is_one_sentence(function, more, said):
    for given in (5, b"case.toml"):
        with pytest.raises(ertel.ConfigError, match="^" + said.format(re.escape(repr(given)))):
            function(given, *more)


@pytest.mark.parametrize("jobs", [1.5, "2", 0])
def test_who_does_the_runs(jobs, tmp_path):
    with pytest.raises(ertel.ConfigError, match=r"^jobs = .*: must be one or more, a whole number$"):
        ertel.sweep({**DATA, "contact": {"M": [20, 30], "L": 5}}, tmp_path / "nowhere", jobs=jobs)
    assert not (tmp_path / "nowhere").exists()


def test_numbers_of_numpy_in_plain_data():
    data = {
        "contact": {"M": np.float32(200), "L": np.int64(10)},
        "solver": {"method": np.str_("radial"), "nodes": np.int64(33)},
        "time": {"until": np.float64(0.05)},
    }
    case = ertel.parse_case(data)
    assert case == CASE and case.digest == CASE.digest
    points = [(np.int64(0), np.float32(1)), (np.float64(1), np.int64(2))]
    signal = ertel.parse_case({"contact": {"M": 20, "L": 5}, "motion": {"load": points}})
    assert signal.motion.load(0.5) == 1.5
    for M in (list(np.array([100, 200])), np.str_("100:200:2")):
        study = parse_study({**data, "contact": {"M": M, "L": np.int64(10)}})
        assert [case.contact.M for case in study.cases] == [100, 200]


@ertel.viscosity_laws.register("stored-power")
@dataclass(frozen=True)
class Power:
    """eta/eta0 = (1 + p/p1)^n."""

    p1: Annotated[float, units.STRESS]
    n: float
    table: tuple[float, ...] = ()
    reference = "nobody, unpublished"

    def viscosity(self, p: Any) -> Any:
        return (1.0 + p / self.p1) ** self.n


@ertel.shapes.register("stored-step")
@dataclass(frozen=True)
class Step:
    height: Annotated[units.Amount, units.HEIGHT]
    width: Annotated[units.Amount, units.WIDTH] = 0.5

    def heights(self, X: Any, Y: Any) -> Any:
        return self.height * np.tanh(X / self.width) + 0.0 * Y


def test_a_users_law_and_shape_are_those_of_plain_data():
    law = {"law": "stored-power", "p1": "0.5 GPa", "n": 11}
    step = {"shape": "stored-step", "height": 0.01}
    case = ertel.parse_case({"contact": {"M": 200, "L": 10}, "lubricant": {"viscosity": law}, "roughness": [step]})
    oil = ertel.Oil(viscosity=Power(p1=5e8, n=11.0))
    assert ertel.impact(M=200, L=10, oil=oil, roughness=[Step(0.01)]) == case == ertel.Case.from_data(case.to_data())
    assert case.features == (Feature(Step(0.01)),)
    assert float(case.lubricant.viscosity(1.0)) == pytest.approx((1.0 + case.lubricant.p_h / 5e8) ** 11)
    written = case.to_data()
    assert written["lubricant"]["viscosity"] == {**law, "p1": "500000000.0 Pa"}
    assert written["roughness"] == [{**step, "width": 0.5, "surface": 1}]
    assert "nobody, unpublished" in provenance(case)["references"]
    with_table = replace(case, oil=replace(oil, viscosity=Power(5e8, 11.0, (1.0, 2.0))))
    assert with_table.to_data()["lubricant"]["viscosity"]["table"] == [1.0, 2.0]
    assert ertel.Case.from_data(with_table.to_data()) == with_table
