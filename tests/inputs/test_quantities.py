"""Quantities with units: what they are in SI, what is refused, plain numbers in a case; see data/quantities.toml."""

import tomllib
from dataclasses import fields, is_dataclass
from math import inf, isclose
from typing import Any

import numpy as np
import pint
import pytest
from cases import DATA
from hypothesis import given
from hypothesis import strategies as st

import ertel
from ertel.case.records import ConfigError
from ertel.inputs import quantities
from ertel.inputs.case_files import parse_case
from ertel.inputs.layout import READER
from ertel.inputs.quantities import parse_quantity, parse_values
from ertel.physics import units
from ertel.physics.motion import Oscillation
from ertel.physics.registry import SHAPES
from ertel.physics.units import FINITE, LENGTH, POSITION, WIDTH, Quantity, Unit, marks

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


@pytest.mark.parametrize(("mark", "given", "said"), [*TEXTS["wrong_values"], ("LOAD", [None], "must be numbers in N")])
def test_wrong_values_are_refused_with_their_place(mark: str, given: Any, said: str) -> None:
    with pytest.raises(ConfigError, match=rf"^load.*{said}"):
        parse_values("load", given, getattr(units, mark))


# -- in a case --------------------------------------------------------------------------------------------------------

Q = pint.UnitRegistry().Quantity
ROLLING = {"kind": "rolling", "radius": "10 mm", "load": "40 N", "mean_speed": "0.5 m/s", "E_prime": "220 GPa"}
OIL = {"eta0": "40 mPa*s", "alpha": "20 / GPa"}
NEEDED = {  # what a shape needs besides
    "waviness": {"amplitude": "20 nm", "wavelength_x": "50 um", "front": "-90 um"},
    "rings": {"amplitude": "20 nm", "wavelength": "50 um"},
    "spot": {"radius": "50 um", "depth": "20 nm"},
    "self-affine": {"rms": "20 nm", "hurst": 0.8, "shortest": "30 um", "longest": "60 um", "front": "-90 um"},
}
NEEDED["self-affine"]["ramp"] = "9 um"


def amount_keys(record):
    found = marks(record)
    return [item.name for item in fields(record) if isinstance(found.get(item.name), Unit) and found[item.name].scale]


KEYS = [("lubricant", {}, key) for key in ("layer", "layer_1", "layer_2")]
KEYS += [(name, table, key) for name, table in NEEDED.items() for key in amount_keys(SHAPES[name])]
KEYS += [("motion", {"mean": 1, "amplitude": 0.1, "period": "1 ms"}, key) for key in amount_keys(Oscillation)]


def test_the_table_has_all_shapes():
    assert {name for name in NEEDED if is_dataclass(SHAPES[name])} == set(NEEDED)
    assert len(KEYS) > 15


@pytest.mark.parametrize(("section", "table", "key"), KEYS)
def test_a_plain_number_for_a_length_or_a_time_of_a_case_in_si_is_refused(section, table, key):
    number = 8.0 if key == "period" else 0.3
    data = {"contact": ROLLING, "lubricant": OIL, "solver": {"method": "transient"}}
    table = {other: value for other, value in table.items() if {other, key} != {"depth", "height"}} | {key: number}
    if section == "lubricant":
        data["lubricant"] = OIL | table
    elif section == "motion":
        data["motion"] = {"load": table}
    else:
        data["roughness"] = [{"shape": section, "surface": 2, **table}]
    with pytest.raises(ConfigError, match=rf"{key} = {number}: is a plain number; in a case in SI it needs its unit"):
        parse_case(data)


def test_points_and_records_of_python_likewise():
    keys = {key: value for key, value in ROLLING.items() if key != "kind"} | {"oil": ertel.Oil(0.04, 20e-9)}
    for more in (
        {"layer": 8.5e-6},
        {"layer": [["0 um", 1e-6], ["50 um", "1 um"]]},
        {"motion": {"load": [[0, 1], [5e-3, 2]]}, "method": "transient"},
        {"roughness": [ertel.Feature(ertel.Spot(ertel.quantity("50 um"), depth=2e-8), 2)], "method": "transient"},
    ):
        with pytest.raises(ConfigError, match="is a plain number"):
            ertel.rolling(**keys, **more)
    assert ertel.rolling(**keys, layer=Q(2, "um")).oil.layer == ertel.quantity("2 um")
    spot = ertel.Spot(radius=Q(50, "um"), depth=Q(20, "nm"))
    (feature,) = ertel.rolling(**keys, roughness=[ertel.Feature(spot, 2)], method="transient").features
    assert feature.shape.radius == pytest.approx(50e-6 / ertel.rolling(**keys).scales.a)


def test_quantities_of_pint_keep_their_unit():
    keys = {**ROLLING, "radius": Q(10, "mm"), "load": Q(0.04, "kN")}
    assert parse_case({"contact": keys, "lubricant": OIL}) == parse_case({"contact": ROLLING, "lubricant": OIL})
    assert ertel.quantity(Q(20, "nm")) == Quantity(2e-8, "m")
    heights = np.random.default_rng(0).normal(size=(16, 16))
    shape = ertel.Measured.of(Q(heights, "nm"), Q(2, "um"))
    assert shape.length_x.value == pytest.approx(32e-6)
    assert shape.rms.value == pytest.approx(shape.file.rms)
    assert shape.file.rms == pytest.approx(1e-9 * np.sqrt(np.mean(heights**2)), rel=0.2)
    film = ertel.Measurement("profile", "h", Q([100.0, 101.0], "nm"), Q([0.0, 1.0], "um"), Q(2, "nm"), at=Q(60, "us"))
    assert (film.values.tolist(), film.x.tolist()) == (pytest.approx([1e-7, 1.01e-7]), pytest.approx([0.0, 1e-6]))
    assert (film.sigma, film.at) == (pytest.approx(2e-9), "6e-05 s")
    assert ertel.Measurement.number("h_c", Q(3.6, "um")).values == pytest.approx(3.6e-6)
    with pytest.raises(ValueError, match="has the wrong dimension"):
        ertel.Measurement.number("h_c", Q(3.6, "s"))
    assert ertel.oils.at("squalane", Q(40, "degC")) == ertel.oils.at("squalane", "40 degC")
    sheet = {"nu40": "68 cSt", "nu100": "8.7 cSt", "density": 880}
    one, other = (ertel.oils.data_sheet(**sheet, temperature=each) for each in (Q(333.15, "K"), "60 degC"))
    assert one == other
