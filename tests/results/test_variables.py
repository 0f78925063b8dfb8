"""Variables of a Dataset: their units, and the same in SI."""

import numpy as np
import pytest
from made_up import BALL_FALLS, MOES_FALLS, dry_impact

from ertel.case import rules
from ertel.inputs.case_files import parse_case
from ertel.results import variables
from ertel.results.dataset import Frame, assemble


def test_si_is_the_scales_times_the_dimensionless():
    case, x = parse_case(BALL_FALLS), np.linspace(-1, 1, 5)
    records = [{"T": T, **{name: float(k) for k, name in enumerate(variables.STEPS)}} for T in (0.1, 0.2)]
    maps = {name: np.full((5, 5), k) for k, name in enumerate(variables.MAPS, 1)}
    data = assemble(case, records, [Frame(0.1, maps, ""), Frame(0.2, maps, "end")], {"Y": x, "X": x})
    si, scales = variables.to_si(data), case.scales
    for name, new, factor, units in [
        ("H_c", "h_c", scales.film, "m"),
        ("P_max", "p_max", scales.p_h, "Pa"),
        ("F", "f", scales.load, "N"),
        ("V", "v", 0.1, "m/s"),
        ("time", "t", scales.t0, "s"),
        ("X", "x", scales.a, "m"),
        ("H", "h", scales.film, "m"),
        ("tau_x", "tau_x", scales.p_h * scales.a / scales.R, "Pa"),
        ("loss", "loss", scales.p_h * scales.a**2 / (scales.R * scales.t0), "W/m2"),
        ("mu_sliding", "mu_sliding", 1.0, "1"),
        ("power_loss", "power_loss", scales.load * scales.film / scales.t0, "W"),
        ("frame", "frame", scales.t0, "s"),
    ]:
        since = 1.0 if name in ("time", "frame") else 0.0  # the ball that starts at Delta = -1 touches at T = 1
        np.testing.assert_allclose(si[new].values, (data[name].values - since) * factor, rtol=1e-12)
        assert si[new].attrs["units"] == units
        assert si[new].attrs["long_name"] == data[name].attrs["long_name"]
    assert si["h"].dims == ("frame", "y", "x")
    assert si["newton_iterations"].equals(data["newton_iterations"].rename(time="t").assign_coords(t=si["t"]))
    with pytest.raises(ValueError, match="dimensionless"):
        variables.to_si(dry_impact(MOES_FALLS))


def test_the_rule_for_the_size_of_the_output_counts_all_maps():
    assert sum(not each.of_touch for each in variables.MAPS.values()) == rules.FIELDS


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1.4e9, "Pa", "1.4 GPa"),
        (6.7e-7, "m", "0.67 µm"),
        (6.7e-8, "m", "67 nm"),
        (0.1, "m/s", "0.1 m/s"),
        (0.0, "m", "0 m"),
        (98.5, "N", "98.5 N"),
        (8.7e-10, "m2", "870 µm²"),
        (0.00123, "1", "0.00123"),
        (2.05e-8, "1/Pa", "20.5 /GPa"),
        (6.8e-5, "m^2/s", "68 mm²/s"),
        (3e-3, "kg", "0.003 kg"),
    ],
)
def test_values_for_reading(value, unit, text):
    assert variables.with_prefix(value, unit) == text
