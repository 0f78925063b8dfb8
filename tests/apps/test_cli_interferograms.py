"""ertel plot --interferogram: pictures and movies with the right names, and flags that do not go together."""

import sys
from types import SimpleNamespace

import pytest
from app_runs import refused
from cases import ertel_, names
from made_up import BALL_FALLS, BALL_ROLLS, MOES_FALLS, dry_impact, steady
from PIL import Image

from ertel.plots import interferograms as page
from ertel.runs.store import RunStore


@pytest.fixture(scope="module")
def data():
    ball = dry_impact(BALL_FALLS).isel(frame=slice(0, 50, 16))
    return {"ball": ball, "moes": dry_impact(MOES_FALLS), "rolls": steady(BALL_ROLLS)}


@pytest.fixture
def runs(tmp_path, monkeypatch, data):
    """Runs that were never computed, by the name of their directory."""

    def opened(directory):
        return SimpleNamespace(dataset=lambda: data[directory.name])

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(RunStore, "open", opened)
    monkeypatch.setattr(page, "PIXELS", 40)
    return tmp_path


@pytest.mark.parametrize("sight", ["two-beam", "white"])  # a movie shows the other
def test_picture(runs, sight):
    printed = ertel_("plot", "ball", "--interferogram", sight, "--at", "1").stdout.split()
    assert printed == [f"ball/plots/interferogram-{sight}.png"]
    assert names(runs / "ball" / "plots") == {f"interferogram-{sight}.png"}


def test_movies(runs):
    for kind in ("gif", "webp"):
        ertel_("plot", "ball", "--interferogram", "mono", "--wavelength", "653 nm", "--format", kind, "--out", "movies")
        with Image.open(runs / "movies" / f"interferogram-mono.{kind}") as movie:
            assert movie.n_frames == 4


def test_mp4(runs):
    pytest.importorskip("imageio_ffmpeg", reason="writes MP4, of the extra movie")
    ertel_("plot", "ball", "--interferogram", "mono", "--format", "mp4")
    assert (runs / "ball" / "plots" / "interferogram-mono.mp4").read_bytes()[4:8] == b"ftyp"


def test_mp4_needs_its_extra(runs, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert "ertel[movie]" in refused("plot", "ball", "--interferogram", "mono", "--format", "mp4")
    assert names(runs) == set()


@pytest.mark.parametrize(
    ("directory", "flags", "said"),
    [
        ("ball", "--format gif", "--format gif: only an interferogram can be a movie; add --interferogram mono"),
        ("ball", "--format gif --interferogram mono --at end", "--at end: a movie shows all times"),
        ("ball", "--wavelength 532nm", "--wavelength 532nm: only for --interferogram mono or two-beam"),
        ("ball", "--wavelength 532nm --interferogram white", "only for --interferogram mono or two-beam"),
        ("ball", "--wavelength green --interferogram mono", '--wavelength green: must be a quantity above zero with a'),
        ("ball", "--wavelength 5mm --interferogram mono", "wavelength = 0.005 m: must be from 2e-7 to 1e-5 m"),
        ("moes", "--interferogram mono", "the run is dimensionless, and light needs a film in nm; run a case in SI"),
        ("rolls", "--interferogram mono --format webp", "a steady contact does not move"),
    ],
)  # fmt: skip
def test_refused(runs, directory, flags, said):
    assert said in refused("plot", directory, *flags.split())
    assert names(runs) == set()
