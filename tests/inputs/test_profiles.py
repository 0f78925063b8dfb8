"""Measured profiles in a case: files, trend, gaps, what is refused, and a line contact that has one."""

import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ertel.case.case import Case
from ertel.case.height_map import Measured
from ertel.inputs.case_files import ConfigError, parse_case
from ertel.physics.units import Quantity
from ertel.results.diagnostics import case_warnings

pytestmark = pytest.mark.skipif(find_spec("SurfaceTopography") is None, reason="text is shown to SurfaceTopography")

ROLLER = {"radius": "10 mm", "length": "10 mm", "load": "2 kN", "mean_speed": "1 m/s", "E_prime": "226 GPa"}
LINE = {
    "contact": {"kind": "rolling", **ROLLER},
    "lubricant": {"eta0": "40 mPa*s", "alpha": "20 / GPa"},
    "solver": {"method": "transient"},
}
POINTS, LENGTH = 240, 600e-6  # m
PLACES = (np.arange(POINTS) + 0.5) / POINTS - 0.5
WAVE = 1e-8 * np.cos(2 * np.pi * 6 * PLACES)  # m
FORM = 3e-6 + 2e-6 * PLACES
BOW = FORM + 5e-6 * PLACES**2


def case(folder: Path, contact: Mapping[str, Any] = LINE, **table: Any) -> Case:
    return parse_case({**contact, "roughness": [{"shape": "measured", **table}]}, folder)


def profile(folder: Path, **table: Any) -> Measured:
    (feature,) = case(folder, **table).roughness
    assert isinstance(feature.shape, Measured)
    return feature.shape


def is_of_heights(shape: Measured, expected: np.ndarray) -> bool:
    assert isinstance(shape.rms, Quantity) and isinstance(shape.length_x, Quantity) and shape.length_y is None
    heights = shape.file.heights / shape.file.rms * shape.rms.value
    assert heights.shape == (1, POINTS)
    return abs(shape.length_x.value / LENGTH - 1) < 1e-9 and np.abs(heights[0] - expected).max() < 1e-14


def write(path: Path, *columns: np.ndarray, header: str = "") -> None:
    np.savetxt(path, np.column_stack(columns), fmt="%.9g", header=header, comments="")


def test_the_files_of_a_profile(tmp_path) -> None:
    """Two columns, one, one row, an array, and a file of SurfaceTopography, all of the same heights."""
    from SurfaceTopography import UniformLineScan

    x = 1e3 * LENGTH * (PLACES + 0.5)
    write(tmp_path / "units.txt", x, 1e6 * WAVE, header="x (mm)  z (um)")
    write(tmp_path / "stylus.asc", 1e3 * x, 1e6 * WAVE)
    write(tmp_path / "heights.txt", 1e9 * WAVE)
    np.savetxt(tmp_path / "row.txt", 1e9 * WAVE[None], fmt="%.9g")
    np.save(tmp_path / "row.npy", WAVE)
    UniformLineScan(1e6 * WAVE, 1e6 * LENGTH, unit="um").to_netcdf(tmp_path / "scan.nc")
    spaced = {"unit": "nm", "spacing": "2.5 um"}
    told = {"units.txt": {}, "stylus.asc": {"unit": "um"}, "heights.txt": spaced, "row.txt": spaced, "scan.nc": {}}
    for name, table in {**told, "row.npy": {"unit": "m", "length_x": "0.6 mm"}}.items():
        assert is_of_heights(profile(tmp_path, file=name, **table, detrend="none"), WAVE), name


@pytest.mark.parametrize(
    ("told", "form", "degree"),
    [
        ({}, FORM, 1),
        ({"detrend": "plane"}, FORM, 1),
        ({"detrend": "curvature"}, BOW, 2),
        ({"detrend": "mean"}, 5e-6, 0),
    ],
)
def test_the_form_of_the_body_is_taken_off(tmp_path, monkeypatch, told, form, degree) -> None:
    """The polynomial that fits best, also to the waves; without any other package."""
    np.save(tmp_path / "row.npy", WAVE + form)
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    left = WAVE - np.polyval(np.polyfit(PLACES, WAVE, degree), PLACES)
    assert is_of_heights(profile(tmp_path, file="row.npy", unit="m", spacing="2.5 um", **told), left)


def test_round_off_is_no_profile(tmp_path, caplog) -> None:
    np.save(tmp_path / "row.npy", BOW)
    with pytest.raises(ConfigError, match=r'^roughness\[1\].detrend = "curvature": leaves nothing but round-off'):
        profile(tmp_path, file="row.npy", unit="m", spacing="2.5 um", detrend="curvature")
    write(tmp_path / "stylus.asc", 1e6 * LENGTH * PLACES, 1e6 * WAVE)
    short = case_warnings(case(tmp_path, file="stylus.asc", unit="um", length_x="300 um"))
    assert any("the profile is smaller than the contact (without its taper 1.6 a, the contact 2 a)" in s for s in short)
    assert not any("the profile is" in s for s in case_warnings(case(tmp_path, file="stylus.asc", unit="um")))
    # Some readers log all bytes of a file.
    (tmp_path / "stylus.txt").write_bytes(bytes(range(256)) * 20)
    with pytest.raises(ConfigError, match="SurfaceTopography cannot read it"):
        profile(tmp_path, file="stylus.txt")
    assert caplog.text == ""


def test_gaps_are_filled_by_straight_lines_and_counted(tmp_path) -> None:
    line = 1e-7 * PLACES
    gaps = np.isin(np.arange(POINTS), (7, 8, 100))
    write(tmp_path / "gaps.txt", 1e6 * LENGTH * PLACES, np.where(gaps, np.nan, 1e6 * line))
    found = case(tmp_path, file="gaps.txt", unit="um", detrend="none", cutoff="100 um")
    (heights,) = found.maps.values()
    np.testing.assert_allclose(heights.heights[0], 1e6 * line, atol=1e-9)
    (said,) = [sentence for sentence in case_warnings(found) if sentence.startswith("roughness[1]")]
    assert said.startswith("roughness[1]: 3 of the 240 points of the profile were gaps")
    ((name, heights),) = found.maps.items()
    (tmp_path / name).write_bytes(heights.to_bytes())  # as in a run directory
    again = parse_case(found.to_data(), tmp_path)
    assert again == found == Case.from_data(found.to_data(), found.maps) and again.digest == found.digest


def test_a_profile_and_a_map_have_their_contacts(tmp_path) -> None:
    write(tmp_path / "stylus.asc", 1e6 * LENGTH * PLACES, 1e6 * WAVE)
    np.save(tmp_path / "map.npy", np.outer(np.arange(1, 9), WAVE))
    ball = {key: value for key, value in ROLLER.items() if key != "length"}
    point = {**LINE, "contact": {"kind": "rolling", **ball}}
    ridges = case(tmp_path, point, file="stylus.asc", unit="um").features[0].shape
    x, y = np.linspace(-0.5, 0.5, 9), np.linspace(-3.0, 3.0, 4)[:, None]
    heights = ridges.heights(x, y)
    assert np.ptp(heights[0]) > 0 and np.array_equal(heights, np.broadcast_to(heights[0], (4, 9)))
    with pytest.raises(ConfigError, match=r"length_x = .* m: is above a metre; give unit, or length_x"):
        case(tmp_path, file="stylus.asc", unit="m")
    with pytest.raises(ConfigError, match=r"^roughness\[1\]: varies along y; a line takes .*, or a profile"):
        case(tmp_path, file="map.npy", unit="m", spacing="2 um")
