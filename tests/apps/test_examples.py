"""The examples run: each case file loads, each script gives the number that it is about."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

from ertel.inputs.case_files import load_case
from ertel.model.case import METHODS

EXAMPLES = Path(__file__).parents[2] / "examples"


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_case_files_load(path: Path) -> None:
    case = load_case(path)
    assert case.solver.method in METHODS[case.kind]


def test_own_lubricant() -> None:
    """Less stiff than Roelands' at high pressure, the oil flees for longer: the trapped film is thinner."""
    roelands, power = script("own_lubricant").central_films(nodes=65)
    assert roelands == pytest.approx(0.151, rel=0.01)
    assert 0.5 * roelands < power < roelands
