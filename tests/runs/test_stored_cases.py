"""A law and a shape of one's own in a case: from a file, from Python, and as plain data with its source."""

from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import pytest

import ertel
from ertel.inputs.case_files import load_case
from ertel.physics import units
from ertel.physics.surfaces import Feature
from ertel.results.dataset import provenance


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
        return self.height * (1.0 + np.tanh(X / self.width)) / 2 + 0.0 * Y


OWN = """
contact = { M = 200, L = 10 }
lubricant = { viscosity = { law = "stored-power", p1 = "0.5 GPa", n = 11 } }
roughness = [{ shape = "stored-step", height = 0.01 }]
"""


def test_a_users_law_and_shape_are_those_of_case_files(tmp_path):
    (tmp_path / "own.toml").write_text(OWN)
    case, oil = load_case(tmp_path / "own.toml"), ertel.Oil(viscosity=Power(p1=5e8, n=11.0))
    assert case.features == (Feature(Step(0.01)),)
    assert float(case.lubricant.viscosity(1.0)) == pytest.approx((1.0 + case.lubricant.p_h / 5e8) ** 11)
    assert ertel.impact(M=200, L=10, oil=oil, roughness=[Step(0.01)]) == case == ertel.Case.from_data(case.to_data())
    written = case.to_data()
    assert written["lubricant"]["viscosity"] == {"law": "stored-power", "p1": "500000000.0 Pa", "n": 11.0}
    assert written["roughness"] == [{"shape": "stored-step", "height": 0.01, "width": 0.5, "surface": 1}]
    assert "nobody, unpublished" in provenance(case)["references"]
    with_table = replace(case, oil=replace(oil, viscosity=Power(5e8, 11.0, (1.0, 2.0))))
    assert with_table.to_data()["lubricant"]["viscosity"]["table"] == [1.0, 2.0]
    assert ertel.Case.from_data(with_table.to_data()) == with_table
