"""Quantities with units: what they are in SI, and that any other text is refused; see data/quantities.toml."""

import tomllib
from math import inf, isclose
from typing import Any

import numpy as np
import pytest
from cases import DATA
from hypothesis import given
from hypothesis import strategies as st

from ertel.case.records import ConfigError
from ertel.inputs import quantities
from ertel.inputs.layout import READER
from ertel.inputs.quantities import parse_quantity, parse_values
from ertel.physics import units
from ertel.physics.units import FINITE, LENGTH, LOAD, POSITION, WIDTH, Quantity, Unit

TEXTS = tomllib.loads((DATA / "quantities.toml").read_text(encoding="utf-8"))
TOO_LONG = [" " * 3000, "1" + " " * 3000 + "m", "1 " + "m" * 10**6, "9" * 400 + " m"]


@pytest.mark.parametrize(("written", "unit"), units.PREFIXED)
def test_units_read_without_pint_are_those_of_pint(written, unit, monkeypatch):
    mark = next(mark for mark in vars(units).values() if isinstance(mark, Unit) and mark.unit == unit)
    quantities._factor.cache_clear()
    read = quantities._factor(written, mark)
    monkeypatch.setattr(quantities, "PREFIXED", {})
    quantities._factor.cache_clear()
    assert read == quantities._factor(written, mark) != 1


def test_an_amount_is_a_number_or_a_quantity():
    assert READER.amount(0.5, WIDTH) == 0.5
    assert READER.amount("50 um", WIDTH) == Quantity(5e-5, "m")
    assert READER.amount(-1, POSITION) == -1.0
    for value in (0, -1.0, inf, True, [1]):
        with pytest.raises(ValueError, match="must be a finite number above zero, in units a, or a quantity"):
            READER.amount(value, WIDTH)
    for value in (10**400, 1e31, 1e-31):
        with pytest.raises(ValueError, match=r"^must be between 1e-06 and 1e\+06, in units a$"):
            READER.amount(value, WIDTH)


@pytest.mark.parametrize(("mark", "value", "texts"), TEXTS["read"])
def test_quantities_as_papers_and_data_sheets_write_them(mark, value, texts):
    for text in texts:
        assert isclose(parse_quantity(text, getattr(units, mark)), value, rel_tol=1e-12), text
    assert parse_quantity("18.6 mm", LENGTH) == 0.0186  # 18.6 * 0.001 is 0.018600000000000002 in floats


@pytest.mark.parametrize(("mark", "said", "texts"), [*TEXTS["refused"], ("LENGTH", "must be a quantity", TOO_LONG)])
def test_what_is_no_quantity_doubtful_absurd_or_would_hang_is_refused(mark, said, texts):
    for text in texts:
        with pytest.raises(ValueError, match=said):
            parse_quantity(text, getattr(units, mark))


@given(st.text(max_size=12))
def test_any_text_as_a_length_is_a_length_or_refused(text):
    try:
        value = parse_quantity(text, LENGTH)
    except ValueError:
        return
    assert value is not None and 0 < value < inf


@pytest.mark.parametrize(("mark", "given", "values"), [*TEXTS["values"], ("FINITE", np.linspace(0, 1, 3), [0, 0.5, 1])])
def test_several_values(mark: str, given: Any, values: list[float]) -> None:
    assert parse_values("x", given, getattr(units, mark)) == pytest.approx(values, rel=1e-14)


def test_a_range_has_the_round_numbers_between_its_ends() -> None:
    assert parse_values("x", "-0.1:0.2:4", FINITE) == (-0.1, 0.0, 0.1, 0.2)
    assert parse_values("x", "-0.1:0.2:10", FINITE)[3] == 0.0


@pytest.mark.parametrize(("mark", "given", "said"), TEXTS["wrong_values"])
def test_wrong_values_are_refused_with_their_place(mark: str, given: Any, said: str) -> None:
    with pytest.raises(ConfigError, match=rf"^load.*{said}"):
        parse_values("load", given, getattr(units, mark))
    with pytest.raises(ConfigError, match=r"^load.* must be numbers in N"):
        parse_values("load", [None], LOAD)
