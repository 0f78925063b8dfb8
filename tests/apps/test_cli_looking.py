"""`ertel ls`, `compare` and `export`, and `plot --interferogram`: pictures and movies with the right names."""

import csv
import json
import os
import re
import struct
import zlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from app_runs import given, refused
from cases import REFUSALS, SMALL_IMPACT, ertel_
from made_up import BALL_FALLS, dry_impact
from matplotlib.figure import Figure
from PIL import Image

import ertel
from ertel.apps.reports import _value, drawn, page_of
from ertel.optics import Interferometer, Monochromatic, Rig
from ertel.physics import hertz
from ertel.physics.lubricant import DowsonHigginson
from ertel.plots import interferograms as page
from ertel.results.numbers import Number
from ertel.results.study_table import StudyRun, study_dataset
from ertel.results.variables import VARIABLES
from ertel.runs import directory
from ertel.runs.store import RunStore
from ertel.runs.studies import write_study
from ertel.runs.study_result import StudyResult

RADIAL = ["solver.method=radial", "solver.nodes=17", "time.tolerance=0.1", "output.interval=10"]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run on the plane, a radial one and one without dimensions in a folder below, and a file among them."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "ball.toml").write_text(SMALL_IMPACT + "until = 0.1\n[output]\ninterval = 0.05\n")
    ertel_("run", str(folder / "ball.toml"), "-q", "--out", str(folder / "plane"))
    ertel_("run", str(folder / "ball.toml"), "-q", "--out", str(folder / "below" / "radial"), *given(*RADIAL))
    case = ertel.impact(M=20, L=5, method="radial", nodes=17, until=0.02)
    ertel.run(case, folder / "below" / "moes")
    return folder


def test_runs_are_listed_with_their_numbers(runs):
    head, *rows = ertel_("ls", str(runs)).stdout.splitlines()
    assert {"run", "case", "status", "written", "M", "L"} <= {*head.split()}
    assert [row.split()[0] for row in rows] == ["below/moes", "below/radial", "plane"]
    assert "ball, radial" in rows[1] and "converged" in rows[1] and "ball, 2d" in rows[2]
    *_, plane = json.loads(ertel_("ls", str(runs), "--json").stdout)
    assert (plane["directory"], plane["status"], plane["done"], plane["method"]) == ("plane", "converged", 1.0, "2d")
    thinnest = ertel.open(runs / "plane").summary["si"]["extremes"]["H_min"]["h_min_m"]
    found = plane["numbers"]["h_min_extreme"]
    assert (found["value"], found["units"]) == (pytest.approx(thinnest), "m")


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such names")
def test_a_run_of_any_name_and_time_is_one_row(tmp_path, monkeypatch):
    """Some file systems keep times, by mistake of a clock or by intent, that no calendar has."""
    run = tmp_path / "first\nsecond"
    (run / "run.zarr").mkdir(parents=True)
    (run / "case.toml").write_text(SMALL_IMPACT)
    monkeypatch.setattr("ertel.apps.looking.LATEST", 1e9)
    _, row = ertel_("ls", str(tmp_path)).stdout.splitlines()
    assert row.startswith(r"first\nsecond  ") and "unfinished 0%  2001-09-0" in row


def test_two_runs_side_by_side_and_in_one_figure(runs, tmp_path):
    picture = tmp_path / "both.png"
    told = ertel_("compare", str(runs / "plane"), str(runs / "below" / "radial"), "--plot", str(picture)).stdout
    assert re.search(r'^solver.method +"2d" +"radial"$', told, re.M)
    assert re.search(r"^thinnest film of the run +h_min_extreme +\S+ [nµ]m +\S+ [nµ]m +[+-]\d+\.\d\d%$", told, re.M)
    assert told.splitlines()[-1] == str(picture)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_exports_hold_the_whole_run(runs, tmp_path):
    ertel_("export", str(runs / "plane"), "--to", "netcdf", "--out", str(tmp_path))
    with xr.open_dataset(tmp_path / "run.nc", engine="scipy") as found:
        stored = ertel.open(runs / "plane").dataset
        assert set(found.variables) == set(stored.variables)
        assert all(np.array_equal(found[name], stored[name], equal_nan=True) for name in stored.variables)
        assert found.attrs["digest"] == stored.attrs["digest"]
        assert found["H"].attrs["long_name"] == "film thickness"
    ertel_("export", str(runs / "plane"), "--to", "netcdf", "--out", str(tmp_path))  # over a file of its own
    xr.Dataset(attrs={"title": "not by ertel 1"}).to_netcdf(tmp_path / "run.nc", engine="scipy")
    assert "is another file" in refused("export", str(runs / "plane"), "--to", "netcdf", "--out", str(tmp_path))
    ertel_("export", str(runs / "plane"), "--to", "csv", "--si", "--out", str(tmp_path))
    with (tmp_path / "history.csv").open() as file:
        rows = list(csv.DictReader(file))
    stored = ertel.open(runs / "plane").si
    assert [float(row["h_min_m"]) for row in rows] == stored["h_min"].values.tolist()
    assert [float(row["t_s"]) for row in rows] == stored["t"].values.tolist()
    # The bytes as the format has them: x runs fastest.
    ertel_("export", str(runs / "plane"), "--to", "vtk", "--out", str(tmp_path))
    stored = ertel.open(runs / "plane").dataset
    times = re.findall(r'timestep="([^"]+)"', (tmp_path / "maps.pvd").read_text())
    assert [float(time) for time in times] == stored["frame"].values.tolist()
    head, _, body = (tmp_path / "maps_0001.vti").read_bytes().partition(b'<AppendedData encoding="raw">\n_')
    said = head.decode()
    for part in ('WholeExtent="0 32 0 32 0 0"', 'Origin="-2.0 -2.0 0.0 "', 'Spacing="0.125 0.125'):
        assert part in said
    offset = int(re.search(r'Name="H".*offset="(\d+)"', said)[1])
    [size] = struct.unpack_from("<Q", body, offset)
    values = np.frombuffer(body, "<f8", size // 8, offset + 8)
    assert np.array_equal(values, stored["H"].values[1].ravel())


def test_files_that_ertel_did_not_write_stay(runs, tmp_path):
    """A photograph, a table, what links lead to; those of an earlier command are replaced."""
    plane, photo, table = str(runs / "plane"), tmp_path / "film.png", tmp_path / "history.csv"
    photo.write_bytes(b"\x89PNG\r\n\x1a\n of a camera")
    table.write_text("t_s,h_m\n1,2\n")
    for command, file in ((("plot", "--what", "film"), photo), (("export",), table)):
        given_ = command[0], plane, *command[1:], "--out", str(tmp_path)
        before = file.read_bytes()
        why = "is another file" if file is table else "has no mark of ertel (a picture of an earlier version has none)"
        assert f"{file}: {why}; move it, or add --overwrite" in refused(*given_)
        assert file.read_bytes() == before
        ertel_(*given_, "--overwrite")
        assert ertel_(*given_).stdout == f"{file}\n" and file.read_bytes() != before
    picture, again = tmp_path / "pressure.svg", ("plot", plane, "--what", "pressure", "--format", "svg")
    Figure().savefig(picture, metadata={"Title": "drawn beside ertel"})  # of a user of Matplotlib
    before = picture.read_bytes()
    assert f"{picture}: has no mark of ertel" in refused(*again, "--out", str(tmp_path))
    assert picture.read_bytes() == before
    picture.unlink()
    for _ in range(2):
        ertel_(*again, "--out", str(tmp_path))
    picture.unlink()
    own = tmp_path / "own.csv"
    table.rename(own)
    table.symlink_to(own)
    before = own.read_bytes() + b"7"  # with the same columns
    own.write_bytes(before)
    assert f"{table}: is another file; move it, or add --overwrite" in refused("export", plane, "--out", str(tmp_path))
    ertel_("export", plane, "--out", str(tmp_path), "--overwrite")
    assert own.read_bytes() == before and not table.is_symlink()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["film.png", "history.csv", "own.csv"]


def test_a_run_of_somebody_else_does_not_say_where_pictures_go(runs, tmp_path):
    (runs / "plane" / "export").symlink_to(tmp_path)
    assert "plane/export: is a symbolic link" in refused("export", str(runs / "plane"))
    (runs / "plane" / "export").unlink()
    (runs / "plane" / "plots").symlink_to(tmp_path)
    plane = str(runs / "plane")
    assert "plane/plots: is a symbolic link" in ertel_("compare", plane, plane, "--plot", code=2).stderr
    (runs / "plane" / "plots").unlink()
    assert not list(tmp_path.iterdir())


def test_a_run_on_one_page(runs, tmp_path):
    told = ertel_("report", str(runs / "plane"), "-o", str(tmp_path / "page.pdf")).stdout
    pdf = (tmp_path / "page.pdf").read_bytes()
    assert told == f"{tmp_path / 'page.pdf'}\n" and pdf.startswith(b"%PDF") and b"/Count 1" in pdf
    for name, in_si in (("plane", (r"contact.radius +10 mm", r"contact.mass +0.03267 kg")), ("below/moes", ())):
        page, run = page_of(runs / name), ertel.open(runs / name)
        assert run.case.digest in page.source and page.picture is not None
        case, computed = ("\n".join(column) for column in page.columns)
        assert "lubricant" in case and f"{run.case.kind}, {run.case.method.in_words}: converged" in computed
        assert all(re.search(line, case) for line in in_si)


def test_a_name_that_begins_with_a_number_has_no_prefix():
    told = {"2000 rpm": "2000 rpm", "20000 series": "20000 series", "2024": "2024", "40 degC": "40 degC"}
    told |= {"313.15 K": "40 degC", "5e6 Pa": "5 MPa"}
    assert {text: _value(text) for text in told} == told


def test_a_study_on_one_page(tmp_path):
    """Its table and its picture; and many lines are cut, so that the page stays one."""
    numbers = {"h_c": Number("h_c", VARIABLES["H_c"], 1e-7, "m")}
    found = [StudyRun(numbers, ["the grid is coarse"] * 99, "converged", "runs/none")] * 90
    speeds = {"mean_speed": ([float(n) for n in range(90)], {"long_name": "mean speed", "units": "m/s"})}
    about = {"title": "speeds", "kind": "rolling", "warnings": [f"run {n}: the grid is coarse" for n in range(99)]}
    write_study(StudyResult(study_dataset("product", speeds, found, about)), tmp_path)
    page = page_of(tmp_path)
    figure = drawn(page)
    shown = " ".join(text.get_text() for text in figure.texts)
    assert "speeds" in shown and "h_c (nm)" in shown and "more lines" in shown and page.picture is not None
    boxes = sorted((text.get_window_extent() for text in figure.texts), key=lambda box: box.y0)
    picture = figure.axes[0].get_window_extent()
    assert boxes[0].y0 > 0 and boxes[1].y0 > boxes[0].y1  # the source, and the notes above it
    assert boxes[1].y1 < picture.y0 and picture.y1 < boxes[2].y0


RIG = Interferometer(Rig(), Monochromatic(532e-9))


def film(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A flat film in a circle of 130 um, outside of it the gap of a ball, and a constriction on one side."""
    r = np.maximum(np.hypot(x, y) / 130e-6, 1.0)
    gap = 1.78e-6 / np.pi * (np.sqrt(r**2 - 1) - (2 - r**2) * np.arccos(1 / r))
    return 230e-9 + gap - 60e-9 * np.exp(-(((x - 98e-6) / 33e-6) ** 2) - (y / 117e-6) ** 2)


@pytest.mark.parametrize(
    ("name", "line", "turn", "shift"),
    [("frame.png", "y", 0.0, (0.0, 0.0)), ("frame.tif", "120 deg", np.pi / 6, (-21.5, 12.0))],
)
def test_a_frame_gives_its_light_and_its_film(tmp_path, name, line, turn, shift):
    """A frame with noise, turned and shifted, of oil that is compressed: its centre, and the film within its noise."""
    column, row = np.meshgrid(np.arange(400.0) - 199.5 - shift[0], np.arange(360.0) - 179.5 - shift[1])
    x, y = 1.2e-6 * (column * np.cos(turn) + row * np.sin(turn)), 1.2e-6 * (row * np.cos(turn) - column * np.sin(turn))
    density = DowsonHigginson().density(5e8 * hertz.pressure(np.hypot(x, y) / 130e-6))
    light = 40 + 500 * RIG.intensity(film(x, y), density)
    light += np.random.default_rng(0).normal(0, 3, light.shape)
    Image.fromarray(light.clip(0, 255).astype(np.uint8)).save(tmp_path / name)
    out, given_ = tmp_path / "line.csv", [str(tmp_path / name), "--pixel", "1.2 um", "--line", line]
    told = ertel_("fringes", *given_, "--out", str(out)).stderr
    found = [float(word) for word in re.findall(r"column (\S+), row ([\d.]+);", told)[0]]
    assert found == pytest.approx([199.5 + shift[0], 179.5 + shift[1]], abs=4.0)
    seen = ertel.Measurement.read(out, optics=RIG)
    assert seen.quantity == "intensity" and 0.7 < seen.sigma[0] < 3.0 and len(seen.x) > 200
    loaded = ["--hertz", "0.5 GPa, 130 um"]
    ertel_("fringes", *given_, "--film", "235 nm", *loaded, "--out", str(out), "--overwrite")
    measured = ertel.Measurement.read(out)
    truth = film(0.0 * measured.x, measured.x)
    off = np.abs(measured.values - truth)
    assert len(measured.x) > 60 and np.median(off) < 5e-9 and off.max() < 20e-9  # a pixel is 20 nm outside


def test_a_profile_is_exported_and_compared_with_its_run(runs, tmp_path):
    """What the run itself gave differs from it by nothing; moved and lifted it is aligned again."""
    plane, out = str(runs / "plane"), str(tmp_path)
    done = ertel_("export", plane, "--what", "profile", "--at", "-35 us", "--along", "y", "--out", out)
    path = tmp_path / "profile_y_-35_us.csv"
    assert done.stdout == f"{path}\n" and re.match("along y, -35 µs, between the maps at .* and .* µs", done.stderr)
    assert path.read_text().startswith("y_m,h_m,p_Pa,h_oil_m,t_s\n")
    assert json.loads(ertel_("compare", plane, str(path), "--at", "-35 us", "--json").stdout)["rms"] < 1e-18
    rows = np.loadtxt(path, delimiter=",", skiprows=1)[4:-4]
    moved = tmp_path / "moved.csv"
    np.savetxt(moved, [(y * 1e6 + 2, h * 1e9 + 30) for y, h, *_ in rows], delimiter=",")
    given_ = ["--column", "y=um", "--column", "h=nm", "--align", "centre, offset", "--at", "-35 us"]
    said = ertel_("compare", plane, str(moved), *given_, "--plot", str(tmp_path / "both.png")).stdout
    assert "centre 2 µm; offset 30 nm" in said and said.endswith("both.png\n")
    assert (tmp_path / "both.png").read_bytes().startswith(b"\x89PNG")
    assert ertel_("compare", plane, str(moved), *given_, "--plot").stdout.endswith("plots/compared-moved.png\n")
    assert ertel_("compare", plane, str(moved), "--plot", *given_).stdout.endswith("plots/compared-moved.png\n")
    indexed = ["--align", "index", "--index", "1.5", "--at", "-35 us", "--json"]
    assert json.loads(ertel_("compare", plane, str(path), *indexed).stdout)["shift"]["index"] == pytest.approx(1.5)
    (tmp_path / "x.csv").write_text(path.read_text().replace("y_m", "x_m"))
    narrow = ["--measured", str(tmp_path / "x.csv"), "--at", "-35 us", "--columns", "1"]
    seen = ertel_("plot", plane, "--out", out, *narrow)
    assert seen.stdout == f"{tmp_path / 'profiles.png'}\n"


@pytest.mark.parametrize(("command", "said"), REFUSALS["commands"], ids=str)
def test_refused(runs, monkeypatch, command, said):
    monkeypatch.chdir(runs)
    (runs / "film.csv").write_text("place,film\n1,2\n")
    Image.fromarray(np.full((20, 20), np.nan, np.float32)).save(runs / "nan.tif")
    noise = Image.fromarray(np.random.default_rng(1).integers(0, 256, (150, 200), np.uint8))
    noise.save(runs / "noise.png")
    noise.save(runs / "two.tif", save_all=True, append_images=[noise])
    header = b"IHDR" + struct.pack(">IIBBBBB", 60000, 60000, 8, 0, 0, 0, 0)
    checksum = struct.pack(">I", zlib.crc32(header))
    (runs / "bomb.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\r" + header + checksum + b"\0\0\0\0IDAT")
    assert said in refused(*command.split())
    assert not list(runs.rglob("export"))


def test_movies_of_fringes_and_of_the_film(tmp_path, monkeypatch):
    data = dry_impact(BALL_FALLS).isel(frame=slice(0, 50, 16))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(RunStore, "open", lambda directory: SimpleNamespace(dataset=lambda: data))
    monkeypatch.setattr(page, "PIXELS", 40)
    ertel_("plot", "ball", "--interferogram", "mono", "--wavelength", "653 nm", "--format", "webp", "--out", "movies")
    with Image.open(tmp_path / "movies" / "interferogram-mono.webp") as movie:
        assert movie.n_frames == 4
    monkeypatch.setattr("ertel.plots.movies.SECONDS", 0.1)
    ertel_("plot", "ball", "--what", "film", "--format", "gif", "--rate", "20")
    with Image.open(file := tmp_path / "ball" / "plots" / "film.gif") as movie:
        assert (movie.n_frames, movie.info["duration"]) == (2, 50)
        movie.save(tmp_path / "own.gif", save_all=True)
    monkeypatch.setattr("ertel.plots.movies.SECONDS", 0.05)
    ertel_("plot", "ball", "--what", "film", "--format", "gif", "--rate", "20")  # ertel's own is replaced
    assert not directory.others_in(tmp_path / "ball")
    (tmp_path / "own.gif").replace(file)
    assert "film.gif: has no mark of ertel" in refused("plot", "ball", "--what", "film", "--format", "gif")
    assert directory.others_in(tmp_path / "ball") == ["plots/film.gif"]
