"""Small cases and reference data shared by the tests."""

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr
from typer.testing import CliRunner

from ertel.apps.cli import app
from ertel.inputs.case_files import parse_case
from ertel.model.case import Case
from ertel.model.state import Method, State


def impact(M: float, L: float, nodes: int, **sections: dict[str, Any]) -> Case:
    """A dimensionless Roelands impact on the 2-D grid; sections are merged over the defaults."""
    source: dict[str, Any] = {"contact": {"kind": "impact", "M": M, "L": L}, "solver": {"nodes": nodes}}
    for name, values in sections.items():
        source[name] = {**source.get(name, {}), **values}
    return parse_case(source)


def march(method: Method, step: float, steps: int) -> list[State]:
    """Levels of a fixed-step run, newest first."""
    levels = [method.start()]
    for _ in range(steps):
        levels.insert(0, method.advance(levels[:3], step))
        assert levels[0].status.ok
    return levels


def ertel_(*arguments: str, code: int = 0) -> Any:
    """The command line, expected to end with a code."""
    result = CliRunner().invoke(app, list(arguments), catch_exceptions=False)
    assert result.exit_code == code, result.output
    return result


def names(directory: Path) -> set[str]:
    return {path.name for path in directory.iterdir()}


def physics(data: xr.Dataset) -> xr.Dataset:
    """The data without what differs between runs: date, wall time."""
    return data.drop_attrs(deep=False)


def stop_after(items: int) -> Callable[[object], bool]:
    """An observer that asks for a stop after so many items."""
    seen = itertools.count(1)
    return lambda item: next(seen) >= items
