"""The template of a package with a law and a shape: its entry points lead somewhere, and case files take its names."""

import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

import ertel
from ertel.physics.registry import SHAPES, VISCOSITY_LAWS, Registry

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
