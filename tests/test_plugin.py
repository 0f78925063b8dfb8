"""Laws and shapes of others: the template of a package with them, and a first contribution, a law in its own file."""

import sys
import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
import test_architecture as rules

import ertel
from ertel.physics import laws
from ertel.physics.registry import DENSITY_LAWS, SHAPES, VISCOSITY_LAWS, Registry

PLUGIN = Path(__file__).parents[1] / "examples/plugin"
ANNOUNCED = tomllib.loads((PLUGIN / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
CASE = {
    "contact": {"kind": "rolling", "radius": "10 mm", "load": "20 N", "mean_speed": "1 m/s", "E_prime": "220 GPa"},
    "lubricant": {
        "eta0": "40 mPa*s",
        "alpha": "22 / GPa",
        "viscosity": {"law": "mcewen", "alpha": "22 / GPa", "q": 12},
    },
    "solver": {"method": "transient", "nodes": 65},
    "roughness": [{"shape": "scratch", "depth": "200 nm", "width": "60 um", "x": "-200 um"}],
}


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> dict[str, Registry]:
    """The registries, by group, as if the package were installed; nothing of it is left behind."""
    monkeypatch.syspath_prepend(PLUGIN)
    registries = {registry.group: registry for registry in (VISCOSITY_LAWS, SHAPES)}
    assert ANNOUNCED.keys() == registries.keys()
    for group, names in ANNOUNCED.items():
        points = {name: EntryPoint(name, value, group) for name, value in names.items()}
        monkeypatch.setattr(registries[group], "_announced", points)
        monkeypatch.setattr(registries[group], "_records", dict(registries[group]._records))
    return registries


def test_the_entry_points_lead_to_a_law_and_a_shape(installed: dict[str, Registry]) -> None:
    loaded = {name: installed[group][name] for group, names in ANNOUNCED.items() for name in names}
    law = loaded["mcewen"](alpha=2e-8, q=8.0)
    assert (law.viscosity(1.0) - 1.0) == pytest.approx(2e-8, rel=1e-6)  # alpha at ambient pressure
    assert law.viscosity(1e9) == pytest.approx(3.5**8, rel=1e-12)
    scratch = loaded["scratch"](depth=0.02, width=0.5)
    heights = scratch.heights(np.array([-0.25, 0.0, 0.25]), np.zeros((2, 1)))
    assert heights == pytest.approx(np.array([[-0.01, -0.02, -0.01]] * 2)) and scratch.size == 0.5


@pytest.mark.usefixtures("installed")
def test_case_files_take_its_names_and_units() -> None:
    case = ertel.parse_case(CASE)
    assert case.lubricant.viscosity(0.0) == 1.0 and case.lubricant.viscosity(1.0) > 1000.0
    text = ertel.to_toml(case)
    assert 'law = "mcewen"' in text and 'shape = "scratch"' in text
    wrong = {**CASE["lubricant"], "viscosity": {"law": "mcewen", "alpha": "22 / GPa", "q": -1}}
    with pytest.raises(ertel.ConfigError, match=r"^lubricant\.viscosity\.q = -1: must be greater than 0"):
        ertel.parse_case({**CASE, "lubricant": wrong})


FIRST_LAW = '''"""Murnaghan's density."""

from dataclasses import dataclass

from ertel.physics.registry import DENSITY_LAWS, OfAnyOil


@DENSITY_LAWS.register("first")
@dataclass(frozen=True)
class First(OfAnyOil):
    """rho/rho0 = (1 + 10 p/K0)^(1/10), K0 = 1.2 GPa."""

    def density(self, p: object) -> object:
        return (1.0 + p / 1.2e8) ** 0.1  # type: ignore[operator]
'''


def test_a_law_in_a_file_of_its_own_passes_the_house_rules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is found in its folder, known by its name in cases, and nothing else has to be touched."""
    (tmp_path / "first.py").write_text(FIRST_LAW)
    name = f"{laws.__name__}.first"
    monkeypatch.setattr(DENSITY_LAWS, "_records", dict(DENSITY_LAWS._records))
    monkeypatch.setattr(laws, "__path__", [*laws.__path__, str(tmp_path)])
    monkeypatch.setitem(sys.modules, name, None)
    del sys.modules[name]  # monkeypatch puts back that it was not there
    exec(Path(str(laws.__file__)).read_text(), {"__name__": laws.__name__, "__path__": laws.__path__})
    case = ertel.parse_case({"contact": {"kind": "rolling", "M": 20, "L": 5}, "lubricant": {"density": "first"}})
    assert case.oil.density_law.density(1.2e8) == 2**0.1
    monkeypatch.setitem(rules.FILES, "physics.laws.first", tmp_path / "first.py")
    monkeypatch.setattr(rules, "INSIDE", [*rules.INSIDE, "physics.laws.first"])
    rules.test_arrows_point_down()
    rules.test_one_public_name_in_one_module()
    rules.test_files_are_neither_long_nor_crumbs()
    rules.test_the_budget_of_code()
    rules.test_public_names_are_explained()
    rules.test_every_module_says_what_it_is_for()
    rules.test_the_ground_floor_needs_no_more_than_arrays()
