"""Files of measured surfaces and profiles in a case: formats, units, trend, gaps, and what is said of wrong ones."""

import struct
import sys
import tracemalloc
import zipfile
from collections.abc import Mapping
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from cases import REFUSALS

from ertel.case.case import Case
from ertel.case.height_map import HeightMap, Measured
from ertel.inputs.case_files import ConfigError, load_case, parse_case
from ertel.physics.units import Quantity
from ertel.results.diagnostics import case_warnings

pytestmark = pytest.mark.skipif(find_spec("SurfaceTopography") is None, reason="files are written by SurfaceTopography")

BALL = {"radius": "10 mm", "ball_density": "7850 kg/m^3", "speed": "0.1 m/s", "E_prime": "231 GPa"}
CONTACT = {"contact": {"kind": "impact", **BALL}, "lubricant": {"eta0": "20 mPa*s", "alpha": "20 / GPa"}}
LENGTHS = 600e-6, 400e-6  # m, of the map along x and y
X, Y = (np.arange(30) + 0.5) / 30, (np.arange(20)[:, None] + 0.5) / 20
WAVE = 1e-8 * np.cos(2 * np.pi * X * 4) * np.cos(2 * np.pi * Y * 3)  # m, rows along y: four and three waves
TILT = 1e-6 * np.linspace(-1, 1, 30) + 5e-7 * np.linspace(-1, 1, 20)[:, None] + 3e-6
BOW = 1e-6 * np.linspace(-1, 1, 30) ** 2
SMOOTH = 1e-7 * np.linspace(-1, 1, 30) * np.linspace(0, 1, 20)[:, None]  # harmonic, so that filling is exact
NMS = np.random.default_rng(0).integers(0, 2**16 - 2, (12, 16), dtype="<u2")
PLACED: dict[str, Any] = {"unit": "m", "length_x": "600 um"}
# NetCDF, a matrix as text, X3P (ISO 5436-2) and Gwyddion's, as SurfaceTopography writes them, by their unit
WITH_UNITS = {"um.nc": "um", "nm.nc": "nm", "a.txt": "um", "a.asc": "nm", "a.x3p": "um", "a.gwy": "um"}
# XYZ, three columns; a matrix as text, whose points are square; an array of NumPy, with rows along y
WITHOUT = {"disc.xyz": {"unit": "um"}, "plain.txt": {**PLACED, "unit": "nm"}}
WITHOUT["disc.npy"] = {"unit": "m", "length_y": "400 um"}


def written(path: Path, heights: np.ndarray, unit: str = "um") -> None:
    """A file of SurfaceTopography with heights in metres, gaps where they are nan; its arrays have x first."""
    from SurfaceTopography import Topography  # here: it takes seconds, and each worker imports this file

    factor = {"um": 1e6, "nm": 1e9}[unit]
    sides = tuple(length * factor for length in LENGTHS)
    found = Topography(np.ma.masked_invalid(heights.T * factor), sides, unit=unit)
    writers = {".nc": found.to_netcdf, ".x3p": found.to_x3p, ".gwy": found.to_gwy}
    writers.get(path.suffix, found.to_matrix)(str(path))


def holed(heights: np.ndarray, rows: Any, columns: Any) -> np.ndarray:
    found = heights.copy()
    found[rows, columns] = np.nan
    return found


@pytest.fixture(scope="module")
def surfaces(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with files of many kinds, right ones and wrong ones."""
    from SurfaceTopography.IO.NMS import _HEADER_SIZE

    place = tmp_path_factory.mktemp("surfaces")
    for name, unit in WITH_UNITS.items():
        written(place / name, WAVE, unit)
    columns = [np.tile(np.arange(30) * 20.0, 20), np.repeat(np.arange(20) * 20.0, 30), 1e6 * WAVE.ravel()]
    np.savetxt(place / "disc.xyz", np.column_stack(columns))
    np.savetxt(place / "plain.txt", 1e9 * WAVE)
    written(place / "gaps.nc", holed(SMOOTH, slice(7, 9), slice(11, 14)))
    written(place / "few gaps.nc", holed(WAVE, 3, slice(4, 7)))
    written(place / "holes.nc", holed(WAVE, slice(12), slice(None)))
    arrays = {"disc": WAVE, "line": WAVE[0], "flat": np.full((20, 30), 3e-6), "high": np.full((20, 30), 0.1)}
    arrays["infinite"] = np.where(WAVE == WAVE.max(), np.inf, WAVE)
    for name, array in arrays.items():
        np.save(place / f"{name}.npy", array)
    (place / "disc.dat").write_bytes((place / "disc.npy").read_bytes())
    np.savez(place / "disc.npz", WAVE)
    for name in ("broken.al3d", "broken.npy"):
        (place / name).write_bytes(b"no surface")
    (place / "noise.bin").write_bytes(np.random.default_rng(0).bytes(5000))
    content = bytearray(_HEADER_SIZE) + NMS.tobytes()
    struct.pack_into("<2d", content, 16, 0.0, 1.0)  # um, of the lowest and the highest point
    struct.pack_into("<2I2d", content, 1368, 16, 12, 0.01, 0.01)  # points, and their distance in mm
    for name in ("map.nms", "map.dat"):
        (place / name).write_bytes(content)
    return place


def case_of(folder: Path, contact: Mapping[str, Any] = CONTACT, **table: Any) -> Case:
    return parse_case({**contact, "roughness": [{"shape": "measured", **table}]}, folder)


def read(folder: Path, contact: Mapping[str, Any] = CONTACT, **table: Any) -> Measured:
    (feature,) = case_of(folder, contact, **table).roughness
    assert isinstance(feature.shape, Measured)
    return feature.shape


def heights(shape: Measured) -> np.ndarray:
    """In metres."""
    assert isinstance(shape.rms, Quantity)
    return shape.file.heights / shape.file.rms * shape.rms.value


def lengths(shape: Measured) -> list[float]:
    return [side.value for side in (shape.length_x, shape.length_y) if isinstance(side, Quantity)]


@pytest.mark.parametrize(("name", "told"), [*((name, {}) for name in WITH_UNITS), *WITHOUT.items()])
def test_heights_lengths_and_units_are_those_of_the_file_or_told(surfaces, name, told) -> None:
    found = read(surfaces, file=name, **told)
    assert lengths(found) == pytest.approx(LENGTHS)
    np.testing.assert_allclose(heights(found), WAVE, rtol=1e-7, atol=1e-15)


def test_a_map_is_scaled_to_an_rms_and_a_length(surfaces) -> None:
    found = read(surfaces, file="um.nc", rms="50 nm", length_x="300 um")
    assert found.rms == Quantity(5e-8, "m")
    assert lengths(found) == pytest.approx([300e-6, 200e-6])
    # A case without dimensions takes it in its own units.
    table = {"shape": "measured", "file": "um.nc"}
    moes = {"contact": {"M": 1000, "L": 10}, "roughness": [{**table, "rms": 0.01, "length_x": 3.0}]}
    (feature,) = parse_case(moes, surfaces).features
    assert (feature.shape.rms, feature.shape.length_x, feature.shape.length_y) == (0.01, 3.0, pytest.approx(2.0))
    with pytest.raises(ConfigError, match=r"^roughness\[1\].length_x = .*: a dimensionless case has no m"):
        parse_case({**moes, "roughness": [table]}, surfaces)


@pytest.mark.parametrize(
    ("detrend", "form"),
    [({}, TILT), ({"detrend": "plane"}, TILT), ({"detrend": "curvature"}, TILT + BOW), ({"detrend": "mean"}, 5e-6)],
)
def test_the_form_of_the_body_is_taken_off(tmp_path, detrend, form) -> None:
    written(tmp_path / "disc.nc", WAVE + form)
    found = heights(read(tmp_path, file="disc.nc", **detrend))
    np.testing.assert_allclose(found, WAVE, atol=0.03 * WAVE.max())  # the plane also fits a little of the waves


def test_gaps_are_filled_from_their_rims_and_counted(surfaces, tmp_path) -> None:
    np.testing.assert_allclose(heights(read(surfaces, file="gaps.nc", detrend="none")), SMOOTH, atol=1e-14)
    case = case_of(surfaces, file="few gaps.nc")
    (said,) = [sentence for sentence in case_warnings(case) if "gaps" in sentence]
    assert said.startswith("roughness[1]: 3 of the 600 points of the map were gaps")
    for name, heights_ in case.maps.items():  # as in a run directory
        (tmp_path / name).write_bytes(heights_.to_bytes())
    again = parse_case(case.to_data(), tmp_path)
    assert again == case == Case.from_data(case.to_data(), case.maps)
    with pytest.raises(ValueError, match=r"^roughness\[1\].file = .*: its heights are not given with the case$"):
        Case.from_data(case.to_data())
    assert case_warnings(again) == case_warnings(case)


@pytest.mark.parametrize(("table", "message"), REFUSALS["maps"], ids=str)
def test_what_is_wrong_is_said(surfaces, table, message) -> None:
    with pytest.raises(ConfigError) as caught:
        read(surfaces, **table)
    assert str(caught.value).startswith(f"roughness[1].{message}")
    assert "\n" not in str(caught.value)


def test_without_the_package_it_is_said_what_to_install(surfaces, monkeypatch) -> None:
    """What needs no trend and no gaps to be seen to is read all the same."""
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    for table in ({"file": "um.nc"}, {"file": "disc.npy", "unit": "m", "length_x": 1.0}):
        with pytest.raises(ConfigError, match=r"^roughness\[1\]\..* pip install 'ertel\[surfaces\]'$"):
            read(surfaces, **table)
    plain = read(surfaces, file="disc.npy", detrend="none", **PLACED)
    np.testing.assert_allclose(heights(plain), WAVE, atol=1e-20)


def test_an_array_has_its_rows_along_y_and_a_map_of_nanofocus_its_name_whatever_else_they_are(surfaces) -> None:
    """SurfaceTopography reads an array with its rows along x; NanoFocus writes no mark: any bytes may be such a map."""
    placed = {"length_x": "600 um", "length_y": "400 um", "unit": "um", "detrend": "none"}
    np.testing.assert_array_equal(read(surfaces, file="disc.dat", **placed).file.heights, WAVE)
    shape = read(surfaces, file="map.nms", detrend="none")
    assert lengths(shape) == pytest.approx([160e-6, 120e-6])
    assert heights(shape) == pytest.approx(1e-6 * NMS / (2**16 - 2), abs=1e-9)


def test_a_case_depends_on_the_heights_and_not_on_the_path(tmp_path) -> None:
    """The file is looked for beside the case file, wherever the program runs."""
    cases = {}
    for folder, factor in (("here", 1.0), ("there", 1.0), ("other", 1.01)):
        (tmp_path / folder).mkdir()
        written(tmp_path / folder / f"{folder}.nc", WAVE + (factor - 1) * TILT**2 / 1e-6)
        table = {"shape": "measured", "file": f"{folder}.nc", "length_x": 3.0, "rms": 0.01}
        content = tomli_w.dumps({"contact": {"M": 1000, "L": 10}, "roughness": [table]})
        (tmp_path / folder / "case.toml").write_text(content, encoding="utf-8")
        cases[folder] = load_case(tmp_path / folder / "case.toml", ['name="same"'])
    assert cases["here"] == cases["there"] != cases["other"]
    assert cases["here"].digest == cases["there"].digest != cases["other"].digest


def test_the_file_that_ertel_wrote_is_taken_as_it_is(tmp_path) -> None:
    """Its trend is off already: a second time would change it."""
    table = {"length_x": "0.2 mm", "rms": "0.1 um"}
    own = HeightMap(WAVE + TILT)
    (tmp_path / own.name).write_bytes(own.to_bytes())
    assert read(tmp_path, file=own.name, length_y="0.2 mm", **table).file == own
    with pytest.raises(ConfigError, match=r'^roughness\[1\].detrend = "mean": was already applied when ertel wrote'):
        read(tmp_path, file=own.name, detrend="mean", length_y="0.2 mm", **table)
    with pytest.raises(ConfigError, match=r"^roughness\[1\].length_y: missing"):
        read(tmp_path, file=own.name, **table)


# -- profiles ---------------------------------------------------------------------------------------------------------

ROLLER = {"kind": "rolling", "radius": "10 mm", "load": "2 kN", "mean_speed": "1 m/s", "E_prime": "226 GPa"}
POINT = {"contact": ROLLER, "lubricant": CONTACT["lubricant"], "solver": {"method": "transient"}}
LINE = {**POINT, "contact": {**ROLLER, "length": "10 mm"}}
PLACES = (np.arange(240) + 0.5) / 240 - 0.5
RIDGES = 1e-8 * np.cos(2 * np.pi * 6 * PLACES)  # m, along 600 um
SLOPE = 3e-6 + 2e-6 * PLACES
ARCH = SLOPE + 5e-6 * PLACES**2


def columns(path: Path, *numbers: np.ndarray, header: str = "") -> None:
    np.savetxt(path, np.column_stack(numbers), fmt="%.9g", header=header, comments="")


def is_profile(shape: Measured, expected: np.ndarray) -> bool:
    assert lengths(shape) == pytest.approx([600e-6], rel=1e-9) and heights(shape).shape == (1, 240)
    return np.abs(heights(shape)[0] - expected).max() < 1e-14


def test_the_files_of_a_profile(tmp_path) -> None:
    """Two columns, one, one row, an array, and a file of SurfaceTopography, all of the same heights."""
    from SurfaceTopography import UniformLineScan

    x = 0.6 * (PLACES + 0.5)  # mm
    columns(tmp_path / "units.txt", x, 1e6 * RIDGES, header="x (mm)  z (um)")
    columns(tmp_path / "stylus.asc", 1e3 * x, 1e6 * RIDGES)
    columns(tmp_path / "heights.txt", 1e9 * RIDGES)
    np.savetxt(tmp_path / "row.txt", 1e9 * RIDGES[None], fmt="%.9g")
    np.save(tmp_path / "row.npy", RIDGES)
    UniformLineScan(1e6 * RIDGES, 600.0, unit="um").to_netcdf(tmp_path / "scan.nc")
    spaced = {"unit": "nm", "spacing": "2.5 um"}
    told = {"units.txt": {}, "stylus.asc": {"unit": "um"}, "heights.txt": spaced, "row.txt": spaced, "scan.nc": {}}
    for name, table in {**told, "row.npy": {"unit": "m", "length_x": "0.6 mm"}}.items():
        assert is_profile(read(tmp_path, LINE, file=name, **table, detrend="none"), RIDGES), name


@pytest.mark.parametrize(
    ("detrend", "form", "degree"), [("", SLOPE, 1), ("plane", SLOPE, 1), ("curvature", ARCH, 2), ("mean", 5e-6, 0)]
)
def test_the_form_is_taken_off_a_profile(tmp_path, monkeypatch, detrend, form, degree) -> None:
    """The polynomial that fits best, also to the waves; without any other package."""
    np.save(tmp_path / "row.npy", RIDGES + form)
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    told = {"detrend": detrend} if detrend else {}
    left = RIDGES - np.polyval(np.polyfit(PLACES, RIDGES, degree), PLACES)
    assert is_profile(read(tmp_path, LINE, file="row.npy", unit="m", spacing="2.5 um", **told), left)


def test_gaps_of_a_profile_are_filled_by_straight_lines_and_counted(tmp_path) -> None:
    line = 1e-7 * PLACES
    gaps = np.isin(np.arange(240), (7, 8, 100))
    columns(tmp_path / "gaps.txt", 600 * PLACES, np.where(gaps, np.nan, 1e6 * line))
    found = case_of(tmp_path, LINE, file="gaps.txt", unit="um", detrend="none", cutoff="100 um")
    ((name, content),) = found.maps.items()
    np.testing.assert_allclose(content.heights[0], 1e6 * line, atol=1e-9)
    (said,) = [sentence for sentence in case_warnings(found) if sentence.startswith("roughness[1]")]
    assert said.startswith("roughness[1]: 3 of the 240 points of the profile were gaps")
    (tmp_path / name).write_bytes(content.to_bytes())  # as in a run directory
    again = parse_case(found.to_data(), tmp_path)
    assert again == found == Case.from_data(found.to_data(), found.maps) and again.digest == found.digest


def test_a_profile_and_a_map_have_their_contacts(tmp_path) -> None:
    columns(tmp_path / "stylus.asc", 600 * PLACES, 1e6 * RIDGES)
    np.save(tmp_path / "row.npy", ARCH)
    np.save(tmp_path / "map.npy", np.outer(np.arange(1, 9), RIDGES))
    ridges = case_of(tmp_path, POINT, file="stylus.asc", unit="um").features[0].shape
    found = ridges.heights(np.linspace(-0.5, 0.5, 9), np.linspace(-3.0, 3.0, 4)[:, None])
    assert np.ptp(found[0]) > 0 and np.array_equal(found, np.broadcast_to(found[0], (4, 9)))
    for table, message in (
        ({"file": "stylus.asc", "unit": "m"}, r".length_x = .* m: is above a metre; give unit, or length_x"),
        ({"file": "map.npy", "unit": "m", "spacing": "2 um"}, ": varies along y; a line takes .*, or a profile"),
        ({"file": "row.npy", "unit": "m", "spacing": "2.5 um", "detrend": "curvature"}, ".detrend = .* round-off"),
    ):
        with pytest.raises(ConfigError, match=rf"^roughness\[1\]{message}"):
            case_of(tmp_path, LINE, **table)
    small = "the profile is smaller than the contact (without its taper 1.6 a, the contact 2 a)"
    for length, speaks in (("300 um", True), (None, False)):
        found = case_of(tmp_path, LINE, file="stylus.asc", unit="um", length_x=length)
        assert any(small in sentence for sentence in case_warnings(found)) == speaks
        assert speaks or not any("the profile is" in sentence for sentence in case_warnings(found))


def test_some_readers_log_all_bytes_of_a_file(tmp_path, caplog) -> None:
    (tmp_path / "stylus.txt").write_bytes(bytes(range(256)) * 20)
    with pytest.raises(ConfigError, match="SurfaceTopography cannot read it"):
        read(tmp_path, file="stylus.txt")
    assert caplog.text == ""


# -- files that would fill the memory ---------------------------------------------------------------------------------

ALLOWED = "a map of 4 to 4096 points a side, or a profile of 4 to 1048576"
IN_A_LINE = "has more than 4096 numbers in a line; a map has at most 4096 points a side"


def refused(folder: Path, name: str, message: str, most: float = 5e6, **table: Any) -> None:
    """Refuse a file with at most so many bytes of Python and NumPy at once."""
    import SurfaceTopography  # noqa: F401  (its own memory does not count)

    tracemalloc.start()
    try:
        with pytest.raises(ConfigError) as caught:
            read(folder, file=name, **table)
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()
    assert str(caught.value).startswith(f'roughness[1].file = "{name}": {message}')


@pytest.mark.parametrize("name", ["disc.npy", "heights-0123456789abcdef.npy"])
@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ((100_000, 100_000), f"heights: is 100000 x 100000; must be {ALLOWED}"),
        ((10**9,), f"heights: is 1000000000; must be {ALLOWED}"),
        ((1, 10**6), "is not an array of numbers, 1 x 1000000 of float64 in 8 bytes"),
        ((4000, 4000), "is not an array of numbers, 4000 x 4000 of float64 in 8 bytes"),
    ],
)
def test_an_array_is_refused_by_its_header(tmp_path, name, shape, message) -> None:
    with (tmp_path / name).open("wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": shape})
        file.write(bytes(8))
    refused(tmp_path, name, message, **(PLACED if name == "disc.npy" else {}))


@pytest.mark.parametrize("separator", [" ", ",", "\t", "; "])
@pytest.mark.parametrize("encoding", ["ascii", "utf-16"])
def test_a_line_of_many_numbers_is_refused_before_it_is_read(tmp_path, separator, encoding) -> None:
    (tmp_path / "wide.txt").write_bytes(f"# Width: 1 mm\n{('1' + separator) * 300_000}\n".encode(encoding))
    refused(tmp_path, "wide.txt", IN_A_LINE, most=40e6)


def test_many_lines_of_numbers_are_refused_before_they_are_read(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("ertel.inputs.height_maps.MOST_NUMBERS", 5000)
    np.savetxt(tmp_path / "long.txt", np.ones((51, 100)))
    refused(tmp_path, "long.txt", "has more than 5000 numbers; a map has at most 4096 points a side")
    np.savetxt(tmp_path / "fits.txt", np.random.default_rng(0).normal(size=(50, 100)), header="some words")
    assert read(tmp_path, file="fits.txt", unit="um", length_x="1 mm").file.heights.shape == (50, 100)


BRANCHES = b"<b/>" * 3_000_000
UNPACKED, LARGE = "unpacks to 1.9 GB; must be at most 0.6 GB", "in it is 12 MB of XML; must be at most 10 MB"


@pytest.mark.parametrize(
    ("name", "members", "declared", "most", "message"),
    [
        ("bomb.x3p", {"main.xml": b"<a/>" * 999, "data.bin": b""}, 1_900_000_000, 5e6, UNPACKED),
        ("tree.x3p", {"main.xml": b"<a>" + BRANCHES + b"</a>"}, None, 5e6, f"main.xml {LARGE}"),
        ("tree.plux", {"recipe.txt": b"\n <a>" + BRANCHES + b"</a>"}, None, 5e6, f"recipe.txt {LARGE}"),
        ("wide.zip", {"scan.dat": b"1 " * 3_000_000}, None, 40e6, IN_A_LINE),
        ("table.xlsx", {"[Content_Types].xml": b"<a/>"}, None, 5e6, "is an office document, which has no map"),
        ("liar.x3p", {"main.xml": b"<a>" + b"<b/>" * 10_000_000}, 1000, 20e6, "SurfaceTopography cannot read it"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_zip_archive_is_refused_by_what_it_unpacks_to(tmp_path, name, members, declared, most, message) -> None:
    """The directory declares gigabytes here; the members have them in an attack."""
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, data in members.items():
            archive.writestr(member, data)
    size = len(next(iter(members.values())))  # of the first member, as the directory has it
    packed = content.getvalue().replace(size.to_bytes(4, "little"), (declared or size).to_bytes(4, "little"))
    (tmp_path / name).write_bytes(packed)
    refused(tmp_path, name, message, most)


def test_a_file_is_refused_by_its_size_and_by_the_shape_that_it_declares(tmp_path) -> None:
    with (tmp_path / "large.al3d").open("wb") as file:
        file.truncate(700_000_000)  # takes no place
    refused(tmp_path, "large.al3d", "is too large; must have at most 600 MB")
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "wide.h5", "w") as file:  # chunks that were never written take no place
        file.create_dataset("heights", shape=(5, 100_000_000), chunks=(5, 1000), dtype="f8")
    refused(tmp_path, "wide.h5", f"heights: is 100000000 x 5; must be {ALLOWED}", **PLACED)
