"""Case files: what they may say, what they mean, and what is said about the ones that may not."""

import os
import tomllib
from copy import deepcopy
from math import pi
from pathlib import Path

import pytest
import tomli_w
from case_file_strategies import case_data, case_files, outcome
from cases import BALL, DATA, STEEL
from hypothesis import HealthCheck, given, settings

from ertel.case.case import Case
from ertel.inputs.case_files import ConfigError, apply_overrides, load_case, parse_case
from ertel.physics import lubricant

OVERRIDES = tomllib.loads((DATA / "overrides.toml").read_text(encoding="utf-8"))
MOES = {"M": 1000, "L": 10}
OIL = {"eta0": "0.1 Pa*s", "alpha": "22 / GPa"}


def test_physical_input_is_the_dimensional_example():
    """The dimensional example of reference/impact.json, to its five digits."""
    case = parse_case({"contact": BALL, "lubricant": OIL})
    si = case.scales
    found = [si.film, si.a, si.load, si.p_h, si.t0, case.parameters.lambda_bar, case.parameters.alpha_bar]
    expected = [3.74064e-06, 0.000193407, 109.181, 1393610000.0, 3.74064e-05, 0.0615385, 30.6595]
    assert found == pytest.approx(expected, rel=1e-5)
    contact = {"radius_1": "10 mm", "radius_2": "40 mm", "ball_density": "8 g/cm^3", "speed": "1 m/s", **STEEL}
    si = parse_case({"contact": contact, "lubricant": OIL}).scales
    assert (si.R, si.ball_mass) == pytest.approx((0.008, 8000 * 4 / 3 * pi * 0.01**3), rel=1e-9)


def test_ways_to_say_the_same_ball():
    density = 0.0326726 / (4 / 3 * pi * 0.01**3)
    height = 0.1**2 / (2 * 9.80665)
    other = {"radius_1": "20 mm", "radius_2": "20 mm", "mass": "32.6726 g", "drop_height": f"{height!r} m"}
    heavy = {k: v for k, v in BALL.items() if k != "mass"} | {"ball_density": f"{density!r} kg/m^3"}
    one = parse_case({"contact": BALL, "lubricant": OIL}).parameters
    for contact in (other | {"E_prime": "226.37 GPa"}, heavy):
        same = parse_case({"contact": contact, "lubricant": OIL}).parameters
        assert (same.M, same.L) == pytest.approx((one.M, one.L), rel=1e-12)
    radii = {"radius_x_1": "12.8 mm", "radius_y_1": "100 mm", "radius_x_2": "21.7 mm", "entrainment_angle": "30 deg"}
    speeds = {"load": "250 N", "speed_1": "2.01 m/s", "speed_2": "2.27 m/s"}
    contact = {"kind": "rolling", "E_prime": "226 GPa"} | radii | speeds
    case = parse_case({"contact": contact, "lubricant": {"eta0": "40 mPa*s", "alpha": "20 / GPa"}})
    assert case.digest == "730e79645d2e31ad"


ALPHA = lubricant.ALPHA
ROELANDS = lubricant.Roelands(ALPHA, lubricant.roelands_exponent(ALPHA, lubricant.ETA0), lubricant.P0_ROELANDS)


@pytest.mark.parametrize(
    ("oil", "viscosity", "density"),
    [
        ({}, ROELANDS, lubricant.DowsonHigginson()),
        ({"z": 0.6, "p0": "0.2 GPa"}, lubricant.Roelands(ALPHA, 0.6, 0.2e9), lubricant.DowsonHigginson()),
        ({"alpha": "20 / GPa", "z": 0.6}, lubricant.Roelands(20e-9, 0.6), lubricant.DowsonHigginson()),
        ({"viscosity": "barus", "density": "incompressible"}, lubricant.Barus(ALPHA), lubricant.Incompressible()),
    ],
)
def test_laws_of_a_dimensionless_case_have_the_typical_oil(oil, viscosity, density):
    case = parse_case({"contact": MOES, "lubricant": oil})
    assert case.lubricant == lubricant.Lubricant(viscosity, density, case.parameters.alpha_bar / case.oil.alpha)


@pytest.mark.parametrize("contact", [{"M": 500}, {"M": 500, "L": 0}, {"lambda_bar": 0.01}, BALL])
def test_an_isoviscous_oil_has_no_pressure_index_and_needs_no_alpha(contact):
    oil = {"viscosity": "isoviscous", "density": "incompressible", "eta0": "0.1 Pa*s"}
    case = parse_case({"contact": contact, "lubricant": oil})
    assert case.parameters.alpha_bar == 0
    assert case.lubricant.viscosity_law == lubricant.Isoviscous()


@pytest.mark.parametrize(("given", "settings", "expected"), OVERRIDES["overrides"])
def test_overrides_are_toml_or_text_and_one_value(given, settings, expected):
    before = deepcopy(given)
    assert apply_overrides(given, settings) == expected
    assert given == before


def test_wrong_overrides():
    with pytest.raises(ConfigError, match="nodes is not a section or a table"):
        apply_overrides({"solver": {"nodes": 129}}, ["solver.nodes.of=3"])
    assert apply_overrides({}, ["solver.nodes=" + "[" * 900 + "]" * 900])["solver"]["nodes"].startswith("[[[")
    for malformed in OVERRIDES["malformed"]:
        with pytest.raises(ConfigError, match=r"--set .*section\.key=value"):
            apply_overrides({}, [malformed])


def read(tmp_path: Path, content: bytes, name: str = "case.toml") -> Case:
    (tmp_path / name).write_bytes(content)
    return load_case(tmp_path / name)


SMALL = b"[contact]\nM = 1000\nL = 10\n"


@pytest.mark.parametrize("content", [b"\xef\xbb\xbf" + SMALL, SMALL.replace(b"\n", b"\r\n")], ids=["mark", "windows"])
def test_a_byte_order_mark_and_lines_of_windows_are_read(tmp_path, content):
    assert read(tmp_path, content) == parse_case({"contact": MOES})


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (SMALL.decode().encode("utf-16"), "must be text in UTF-8, but byte 1 is not"),
        (b"\xff\xfe", "not valid TOML"),
        (b"[contact", "not valid TOML"),
        (b"\x00" + SMALL, "not valid TOML"),
        (SMALL + b"x = " + b"[" * 900 + b"]" * 900, "arrays or tables are nested hundreds of times"),
        (SMALL + b"x = " + b"{a=" * 900 + b"1" + b"}" * 900, "arrays or tables are nested hundreds of times"),
        (b"x = 1" + b"0" * 5000 + b"\n" + SMALL, "an integer has thousands of digits"),
        (b".".join([b"a"] * 100_000) + b" = 1", "a key has more than 20 parts"),
        (b'"a" . ' * 100_000 + b"a = 1", "a key has more than 20 parts"),
        (SMALL + b"#" * 10**6, "is too large; must have at most 1 MB"),
        (b"[" + b"a" * 900_000 + b"]\n[" + b"a" * 900_000 + b"]", "is too large"),
        (b"[" + b"a" * 400_000 + b"]\n[" + b"a" * 400_000 + b"]", "Cannot declare ("),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_no_case_file_is_said_shortly(tmp_path, content, said):
    with pytest.raises(ConfigError) as caught:
        read(tmp_path, content)
    message = str(caught.value).replace(str(tmp_path), "")
    assert said in message
    assert len(message) < 250 and message.isprintable()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a POSIX system")
def test_a_folder_a_pipe_or_a_device_is_refused_and_not_waited_for(tmp_path):
    with pytest.raises(ConfigError, match=r"no\.toml cannot be read, no such file"):
        load_case(tmp_path / "no.toml")
    os.mkfifo(tmp_path / "pipe.toml")
    for path in (tmp_path, tmp_path / "pipe.toml", Path("/dev/zero")):
        with pytest.raises(ConfigError, match="is not a regular file"):
            load_case(path)


@pytest.mark.parametrize(
    ("name", "expected"),
    [("my ball", "my ball"), (".case", "case"), ("a:b", "a_b"), ("\x1b[1m", "_[1m"), ("..", "")],
)
def test_a_case_without_a_name_is_called_as_its_file_is(tmp_path, name, expected):
    assert read(tmp_path, SMALL, f"{name}.toml").name == expected


@pytest.mark.parametrize("examples", [120, pytest.param(2000, marks=pytest.mark.slow)])
def test_any_file_is_a_case_that_reads_back_or_refused_in_one_line(tmp_path: Path, examples: int) -> None:
    path = tmp_path / "case.toml"

    @settings(max_examples=examples, suppress_health_check=[HealthCheck.too_slow])  # where other work takes the cores
    @given(content=case_files() | case_data().map(lambda data: tomli_w.dumps(data).encode()))
    def is_a_case_or_refused(content: bytes) -> None:
        path.write_bytes(content)
        outcome(path)

    is_a_case_or_refused()
