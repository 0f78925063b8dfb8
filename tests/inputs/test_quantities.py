"""Quantities with units: what they are in SI, and that any other text is refused."""

from math import inf, isclose
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ertel.case.records import ConfigError
from ertel.inputs import quantities
from ertel.inputs.layout import READER
from ertel.inputs.quantities import parse_quantity, parse_values
from ertel.physics import units
from ertel.physics.units import COMPLIANCE, FINITE, LENGTH, LOAD, POSITION, VELOCITY, WIDTH, Bounds, Quantity, Unit


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
        with pytest.raises(ValueError, match="must be a finite number above zero, in units a, or a quantity such as"):
            READER.amount(value, WIDTH)
    for value in (10**400, 1e31, 1e-31):
        with pytest.raises(ValueError, match=r"^must be between 1e-06 and 1e\+06, in units a$"):
            READER.amount(value, WIDTH)


@pytest.mark.parametrize(
    "text",
    [
        *("0 mm", "-10 mm", "nan m", "inf m", "10", "mm", "", "1e999 m"),
        "1 m**(9**9**9)",
        "1 m^9^9",
        "1 m*9**9**9",
        " " * 3000,
        "1" + " " * 3000 + "m",
        "1 " + "m" * 10**6,
        "9" * 400 + " m",
        "1 km**99/mm**98",
        "1 parsec**30/m**29",
        "1e-99999999999999999999 m",
    ],
    ids=lambda text: text[:20],
)
def test_what_is_no_length_or_would_hang_is_refused(text):
    with pytest.raises(ValueError, match="must be|has an unknown unit"):
        parse_quantity(text, LENGTH)


@pytest.mark.parametrize(
    ("text", "mark", "value"),
    [
        *((text, LENGTH, 0.01) for text in ("10 mm", "10mm", " 1e-2 m ", "10000 µm", "1 cm")),
        *((text, COMPLIANCE, 22e-9) for text in ("22 / GPa", "22 1/GPa", "22e-9 1/Pa", "2.2e-8 m^2/N", "22/(GPa)")),
        *((text, COMPLIANCE, 22e-9) for text in ("0.022 / MPa", "22 GPa**-1", "22 GPa^-1", "22 (GPa)^(-1)")),
        *((text, COMPLIANCE, 22e-9) for text in ("22 µm·mm/N", "22e-9 m²/N", "22 /(kN/mm^2)")),
        *((text, COMPLIANCE, 22e-9) for text in ("22 GPa⁻¹", "2,2⋅10⁻⁸ m²/N", "22e\u22129 Pa⁻¹")),
        *((text, COMPLIANCE, 22e-9) for text in ("2.2\u00d710^-8 m2/N", "22 GPa-1")),
        *((text, units.VISCOSITY, 0.04) for text in ("40 mPas", "40 mPa⋅s", "40 mPa.s", "40 mPa-s", "0,04 Pa*s")),
        *((text, units.KINEMATIC_VISCOSITY, 68e-6) for text in ("68 mm2/s", "68 cSt", "ISO VG 68", "iso-vg 68")),
        *((text, units.DENSITY, 870) for text in ("870 kg/m3", "870 kg m⁻³", "870\u00a0kg/m³")),
        *((text, units.CONDUCTIVITY, 0.14) for text in ("0.14 W/mK", "0,14 W/m·K", "0.14 W m⁻¹ K⁻¹")),
        *((text, units.TEMPERATURE, 313.65) for text in ("40.5 ℃", "40,5 °C", "313,65 K")),
        *((text, units.ANGLE, 30.0) for text in ("30°", "30 deg")),
        ("\u22120.6 m/s", VELOCITY, -0.6),
        ("0,123 N", LOAD, 0.123),
        ("0.5 inch", LENGTH, 0.0127),
    ],
)
def test_quantities_as_papers_and_data_sheets_write_them(text, mark, value):
    assert isclose(parse_quantity(text, mark), value, rel_tol=1e-12)
    assert parse_quantity("18.6 mm", LENGTH) == 0.0186  # 18.6 * 0.001 is 0.018600000000000002 in floats


@pytest.mark.parametrize(
    ("text", "mark", "said"),
    [
        *((text, LOAD, "may part thousands") for text in ("1,234 N", "1,234.5 N", "1.234,5 N", "1,5,2 N")),
        ("ISO VG 68", units.VISCOSITY, "is a viscosity at 40 degC; give an oil by name"),
        *((text, LENGTH, "dimension") for text in ("10 kg", "10 degC")),
        *(
            (text, LENGTH, r"^must be between 1e-30 and 1e\+30 m$")
            for text in ("1e300 m", "1e-300 m", "1e31 m", "1e22 Gm")
        ),
    ],
)
def test_doubtful_quantities_other_dimensions_and_absurd_sizes_are_refused(text, mark, said):
    with pytest.raises(ValueError, match=said):
        parse_quantity(text, mark)


@given(st.text(max_size=12))
def test_any_text_as_a_length_is_a_length_or_refused(text):
    try:
        value = parse_quantity(text, LENGTH)
    except ValueError:
        return
    assert value is not None and 0 < value < inf


@pytest.mark.parametrize(
    ("given", "mark", "values"),
    [
        ("0:0.5:3", FINITE, [0, 0.25, 0.5]),
        ("0.5:-0.5:3", FINITE, [0.5, 0, -0.5]),
        ("1e-3 : 1e-1 : 3 : log", FINITE, [1e-3, 1e-2, 1e-1]),
        ("0, 0.01, 0.05", FINITE, [0, 0.01, 0.05]),
        ("0.1", FINITE, [0.1]),
        (0.1, FINITE, [0.1]),
        (np.linspace(0, 1, 3), FINITE, [0, 0.5, 1]),
        ("100 mm/s:10 m/s:3:log", VELOCITY, [0.1, 1, 10]),
        ("0.1:10:3:log", VELOCITY, [0.1, 1, 10]),
        ("100:300 mm/s:3", VELOCITY, [0.1, 0.2, 0.3]),
        ("100 mm/s:300:3", VELOCITY, [0.1, 0.2, 0.3]),
        (["5 N", 10], LOAD, [5, 10]),
    ],
    ids=str,
)
def test_several_values(given: Any, mark: Unit | Bounds, values: list[float]) -> None:
    assert parse_values("x", given, mark) == pytest.approx(values, rel=1e-14)
    assert parse_values("x", "-0.1:0.2:4", FINITE) == (-0.1, 0.0, 0.1, 0.2)
    assert parse_values("x", "-0.1:0.2:10", FINITE)[3] == 0.0


@pytest.mark.parametrize(
    ("given", "mark", "said"),
    [
        ("0:0.5", FINITE, "must be FIRST:LAST:NUMBER, or FIRST:LAST:NUMBER:log"),
        ("0:1:3:log", FINITE, "must both be above zero, or both below"),
        ("0, 0.5, 0.2", FINITE, "must rise or fall"),
        ("a:1:3", FINITE, '"a" must be a finite number'),
        ([], FINITE, "must be one value or more"),
        ("0.1 kg:1 kg:3", VELOCITY, "wrong dimension"),
        ([None], LOAD, "must be numbers in N"),
    ],
    ids=str,
)
def test_wrong_values_are_refused_in_a_sentence(given: Any, mark: Unit | Bounds, said: str) -> None:
    with pytest.raises(ConfigError, match=said) as error:
        parse_values("load", given, mark)
    assert str(error.value).startswith("load")
