"""Numbers at the doors: lengths and times of a case in SI need units, and quantities of pint keep theirs."""

from dataclasses import fields, is_dataclass

import numpy as np
import pint
import pytest

import ertel
from ertel.case.records import ConfigError
from ertel.inputs.case_files import parse_case
from ertel.physics.motion import Oscillation
from ertel.physics.registry import SHAPES
from ertel.physics.units import Quantity, Unit, marks

REGISTRY = pint.UnitRegistry()
Q = REGISTRY.Quantity
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
