"""The conda recipe needs what pyproject.toml needs."""

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CONDA_NAMES = {"flatbuffers": "python-flatbuffers", "matplotlib": "matplotlib-base"}


def plain(requirement: str) -> tuple[str, frozenset[str]]:
    """Name and bounds of `name>=1,!=2` or `name >=1,!=2`."""
    requirement = requirement.partition("#")[0].replace(" ", "")
    end = min((requirement.find(sign) for sign in "<>!=" if sign in requirement), default=len(requirement))
    return CONDA_NAMES.get(requirement[:end], requirement[:end]), frozenset(requirement[end:].split(","))


def test_the_recipe_needs_the_same():
    lines = (ROOT / "recipe/recipe.yaml").read_text(encoding="utf-8").splitlines()
    start = lines.index("  run:") + 1
    needed = [line.strip().removeprefix("- ") for line in lines[start : lines.index("tests:")] if line.strip()]
    expected = [f"python{PROJECT['requires-python']}", *PROJECT["dependencies"]]
    assert {plain(one) for one in needed} == {plain(one) for one in expected}
