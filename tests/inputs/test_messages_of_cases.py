"""Which field a message names where several could be wrong, and digests that stored studies rest on."""

import numpy as np
import pytest

from ertel.inputs.case_files import ConfigError, parse_case

ROLLING = {"kind": "rolling", "radius": "10 mm", "load": "30 N", "mean_speed": "1 m/s", "E_prime": "226 GPa"}
SHEET = {"nu40": "68 mm^2/s", "nu100": "8.7 mm^2/s", "density": 1000}
MAP = {"shape": "measured", "file": "map.npy", "length_xx": "500 um", "unit": "um"}


@pytest.mark.parametrize(
    ("sections", "said"),
    [
        ({"roughness": False}, r"^roughness = false: must be an array"),
        ({"roughness": [{"shape": "measured", "file": 0}]}, r"^roughness\[1\]\.file = 0: must be a string"),
        ({"roughness": [MAP]}, r"^roughness\[1\]\.length_xx = .*did you mean length_x"),
        ({"lubricant": {"oil": SHEET, "temperature": "60 degC"}, "thermal": {}}, r"^lubricant\.oil\.density = 1000"),
        (
            {"lubricant": {"temperature": 65}, "thermal": {"temperature": "40 degC"}},
            r"^lubricant\.temperature = 65: m",
        ),
    ],
    ids=["roughness", "file", "misspelt", "sheet", "temperature"],
)
def test_message_names_the_field(sections, said, tmp_path):
    np.save(tmp_path / "map.npy", np.eye(20))
    with pytest.raises(ConfigError, match=said):
        parse_case({"contact": ROLLING, "lubricant": {"eta0": "40 mPa*s", "alpha": "20 / GPa"}} | sections, tmp_path)


def test_digest_of_a_default_domain_stays_to_the_last_bit():
    radii = {"radius_x_1": "12.8 mm", "radius_y_1": "100 mm", "radius_x_2": "21.7 mm", "entrainment_angle": "30 deg"}
    speeds = {"load": "250 N", "speed_1": "2.01 m/s", "speed_2": "2.27 m/s"}
    case = parse_case(
        {
            "contact": {"kind": "rolling", "E_prime": "226 GPa"} | radii | speeds,
            "lubricant": {"eta0": "40 mPa*s", "alpha": "20 / GPa"},
        }
    )
    assert case.digest == "730e79645d2e31ad"
