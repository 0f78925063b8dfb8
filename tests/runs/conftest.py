"""Stored runs that several files of tests share."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="session")
def kinds(tmp_path_factory: pytest.TempPathFactory) -> Any:
    from stored_runs import CASES, Kind  # not above: what they import reads the environment

    return {name: Kind(name, tmp_path_factory.mktemp("runs")) for name in CASES}


@pytest.fixture
def impact(kinds: Any) -> Any:
    return kinds["impact"]


@pytest.fixture
def steady(kinds: Any) -> Any:
    return kinds["steady"]


@pytest.fixture(scope="session")
def grids(kinds: Any) -> Any:
    from ertel.solvers.steady import nested

    return list(nested(kinds["steady"].case))


@pytest.fixture
def copy(tmp_path: Path) -> Callable[..., Path]:
    return lambda directory, name="run": Path(shutil.copytree(directory, tmp_path / name))
