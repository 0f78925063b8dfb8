"""The values along a curve: ranges and lists as users write them."""

from typing import Any

import numpy as np
import pytest

from ertel.case.records import ConfigError
from ertel.inputs.quantities import parse_values
from ertel.physics.units import FINITE, LOAD, VELOCITY, Bounds, Unit


@pytest.mark.parametrize(
    ("given", "mark", "values"),
    [
        ("0:0.5:3", FINITE, [0, 0.25, 0.5]),
        ("-0.5:0.5:3", FINITE, [-0.5, 0, 0.5]),
        ("0.5:0:3", FINITE, [0.5, 0.25, 0]),
        ("1e-3 : 1e-1 : 3 : log", FINITE, [1e-3, 1e-2, 1e-1]),
        ("0, 0.01, 0.05", FINITE, [0, 0.01, 0.05]),
        ("0.1", FINITE, [0.1]),
        (0.1, FINITE, [0.1]),
        (np.linspace(0, 1, 3), FINITE, [0, 0.5, 1]),
        ("0.1 m/s:10 m/s:3:log", VELOCITY, [0.1, 1, 10]),
        ("100 mm/s:10 m/s:3:log", VELOCITY, [0.1, 1, 10]),
        ("0.1:10:3:log", VELOCITY, [0.1, 1, 10]),
        ("100:300 mm/s:3", VELOCITY, [0.1, 0.2, 0.3]),
        ("100 mm/s:300:3", VELOCITY, [0.1, 0.2, 0.3]),
        (["5 N", 10], LOAD, [5, 10]),
    ],
    ids=str,
)
def test_values(given: Any, mark: Unit | Bounds, values: list[float]) -> None:
    assert parse_values("x", given, mark) == pytest.approx(values, rel=1e-14)


def test_a_range_through_zero_contains_zero() -> None:
    assert parse_values("x", "-0.1:0.2:4", FINITE) == (-0.1, 0.0, 0.1, 0.2)
    assert parse_values("x", "-0.1:0.2:10", FINITE)[3] == 0.0


@pytest.mark.parametrize(
    ("given", "mark", "said"),
    [
        ("0:0.5", FINITE, "must be FIRST:LAST:NUMBER, or FIRST:LAST:NUMBER:log"),
        ("0:0.5:3:lin", FINITE, "must be FIRST:LAST:NUMBER, or FIRST:LAST:NUMBER:log"),
        ("0:0.5:x", FINITE, "a whole number from 2 to 1000"),
        ("0:0.5:1", FINITE, "a whole number from 2 to 1000"),
        ("0:0.5:1e9", FINITE, "a whole number from 2 to 1000"),
        ("0:1:3:log", FINITE, "must both be above zero, or both below"),
        ("0:0:3", FINITE, "must rise or fall"),
        ("0, 0.5, 0.2", FINITE, "must rise or fall"),
        ("a:1:3", FINITE, '"a" must be a number'),
        ("0:inf:3", FINITE, "must be a finite number"),
        ("", FINITE, "must be a number"),
        ([], FINITE, "must be one value or more"),
        ([True], FINITE, "must be a number"),
        (range(1001), FINITE, "at most 1000"),
        ("0.1 kg:1 kg:3", VELOCITY, "wrong dimension"),
        ("0:5 N:3", LOAD, "above zero"),
        ([None], LOAD, "must be numbers in N"),
    ],
    ids=str,
)
def test_wrong_values_are_refused_in_a_sentence(given: Any, mark: Unit | Bounds, said: str) -> None:
    with pytest.raises(ConfigError, match=said) as error:
        parse_values("load", given, mark)
    assert str(error.value).startswith("load")
