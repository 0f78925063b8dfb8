"""`ertel sweep`, `traction` and `fit`: what they print and write, their exit codes, how they go on, what is refused."""

import csv
import json
import re
import shutil
import signal

import pytest
from app_runs import ROLLING, STUDY, raising, refused
from cases import LEFT, SMALL_IMPACT, ertel_, names
from matplotlib.figure import Figure

import ertel
from ertel.case.status import Status
from ertel.runs.directory import STOP, ask_to_stop, read_progress
from ertel.runs.files import StoreError, sealed, unsealed
from ertel.runs.fit_result import FitResult, open_study
from ertel.runs.store import RunStore
from ertel.runs.study_result import StudyResult

FIT = """
case = "drop.toml"
[unknowns]
"lubricant.eta0" = { bounds = ["5 mPa*s", "1 Pa*s"], prior = ["20 mPa*s", "1 mPa*s"] }
[[measurements]]
file = "pressure.csv"
"""
GOES_ON = "ertel: interrupted; the same command continues"
SWEEP, FITTED = ("sweep", "loads.toml", "--jobs", "1"), ("fit", "film.toml", "--jobs", "1")
TRACTION = ("traction", "ball.toml", "--slide-to-roll", "0:0.04:3")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A working directory with a study, a case for a traction curve, and a fit."""
    monkeypatch.chdir(tmp_path)
    drop = SMALL_IMPACT.replace("nodes = 33", 'method = "radial"\nnodes = 17').replace("0.01", "0.1\nuntil = 0.02")
    (tmp_path / "loads.toml").write_text(STUDY)
    (tmp_path / "ball.toml").write_text(ROLLING.replace("nodes = 65", "nodes = 33"))
    (tmp_path / "drop.toml").write_text(drop)
    (tmp_path / "film.toml").write_text(FIT)
    (tmp_path / "pressure.csv").write_text("t_us,p_c_kPa,sigma_kPa\n-37,10,1e6\n")
    return tmp_path


def rows(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def test_a_study_from_its_file_to_its_table(here):
    done = ertel_(*SWEEP)
    assert done.stderr == "2 runs, 2 of them to do\n"
    title, head, *table, said, film, start, stored = done.stdout.splitlines()
    assert title == "loads" and head.split()[0] == "M" and [row.split()[0] for row in table] == ["20", "40"]
    assert said == "2 runs: 2 converged; 2 with warnings" and "warnings" in head.split()  # 17 nodes are few
    assert all("(and 1 other run)" in warning for warning in (film, start))
    assert stored == "Stored in sweeps/loads, with sweep.zarr and sweep.csv"  # too short for key numbers to draw
    directory = rows(here / "sweeps/loads/sweep.csv")[0]["directory"]
    assert ertel_("show", f"sweeps/loads/{directory}").stdout.startswith("loads: M = 20, L = 5 (radial")
    again = ertel_(*SWEEP, "--json", "--set", "contact.M=[40, 60]")
    assert again.stderr == "2 runs, 1 of them to do\n"
    found = [(run["M"], run["status"]) for run in json.loads(again.stdout)["runs"]]
    assert found == [(40.0, "converged"), (60.0, "converged")]
    picture = here / "sweeps/loads/sweep.png"
    picture.write_text("of numbers that are no longer there")
    assert ertel_(*SWEEP, "-q").stderr == "" and len(names(here / "sweeps/loads/runs")) == 3
    assert not picture.exists()
    refused(*SWEEP, "--prune", "--part", "1/2")
    assert ertel_(*SWEEP, "--prune").stderr.splitlines()[1:] == ["deleted runs that the study no longer has: 1"]
    kept = {row["directory"].removeprefix("runs/") for row in rows(here / "sweeps/loads/sweep.csv")}
    assert names(here / "sweeps/loads/runs") == kept and len(kept) == 2
    shutil.copytree(here / "sweeps/loads" / directory, here / "zz")
    _, run, study = ertel_("ls").stdout.splitlines()  # the runs of the study are one row, below the others
    assert run.startswith("zz ") and re.match("sweeps/loads +study over M +2 of 2 runs done ", study)
    assert len(json.loads(ertel_("ls", "--json").stdout)) == 3
    summary = here / "sweeps/loads" / directory / "summary.json"
    summary.write_bytes(sealed({**unsealed(summary.read_bytes()), "status": Status.FILM_VANISHED.value}))
    assert "1 of 2 runs done, 1 failed" in ertel_("ls").stdout


@pytest.mark.parametrize("where", ["study", pytest.param("run", marks=pytest.mark.slow)])
def test_a_file_stops_a_study_as_ctrl_c_does(here, monkeypatch, where):
    """In the directory of the study it stops all runs, in that of a run this one."""
    original, study = RunStore.__call__, here / "sweeps/loads"

    def take(self, step):
        original(self, step)
        if step.state.counts.steps == 1 and not (study / "asked").exists():
            (study / "asked").touch()
            ask_to_stop(study if where == "study" else self.directory)

    with monkeypatch.context() as patch:
        patch.setattr(RunStore, "__call__", take)
        done = ertel_(*SWEEP, code=130)
    assert done.stderr.splitlines()[-1] == GOES_ON
    other = "1 missing" if where == "study" else "1 converged"
    assert "1 interrupted" in done.stdout and other in done.stdout
    ask_to_stop(study)  # of before: it says nothing
    assert "2 runs: 2 converged" in ertel_(*SWEEP).stdout
    assert not list(study.rglob(STOP))


def test_a_part_gathers_nothing(here):
    """What a killed study has left is taken up; beside a study there may be other files."""
    (here / "study/runs").mkdir(parents=True)
    done = ertel_(*SWEEP, "--part", "2/2", "--out", "study")
    assert done.stderr == "2 runs, 1 of them to do in part 2 of 2\n" and done.stdout == ""
    assert names(here / "study") == {"runs"} and len(names(here / "study/runs")) == 1
    assert ertel_(*SWEEP, "--out", "study").stderr == "2 runs, 1 of them to do\n"
    (here / "study/notes.txt").write_text("mine")
    ertel_(*SWEEP, "-q", "--out", "study")
    broken = sorted((here / "study/runs").iterdir())[0]
    (broken / "case.toml").write_text("[contact]\nM = 1\nL = 1\n")
    done = ertel_(*SWEEP, "--out", "study", "--set", "contact.M=[20, 40, 60]", code=1)
    assert "3 runs: 2 converged, 1 failed" in done.stdout
    last = done.stderr.splitlines()[-1]
    assert last.startswith(f"ertel: 1 of 3 runs failed: runs/{broken.name}; ertel show study/runs/")


def test_a_curve_is_printed_and_stored_and_shown_by_the_same_command(here, monkeypatch):
    curve = here / "traction" / "ball"
    text = ertel_(*TRACTION).stdout
    for part in ("3 points over the slide-to-roll ratio", "mu_r", "h_c (nm)", "Film: solved once", "traction/ball"):
        assert part in text
    assert names(curve) == LEFT | {"runs", "traction.zarr", "traction.csv", "traction.png"}
    assert [float(row["slide_to_roll"]) for row in rows(curve / "traction.csv")] == [0.0, 0.02, 0.04]
    assert (curve / "traction.png").read_bytes().startswith(b"\x89PNG")
    [run] = (curve / "runs").iterdir()
    monkeypatch.setattr(StudyResult, "plot", lambda self: Figure())  # what is drawn is tested with studies
    monkeypatch.setattr("ertel.runs.store.drive", None)  # nothing is solved again
    assert ertel_(*TRACTION).stdout == text
    data = json.loads(ertel_(*TRACTION, "--json").stdout)
    assert [point["slide_to_roll"] for point in data["points"]] == [0.0, 0.02, 0.04]
    assert data["points"][0]["mu_sliding"] == 0.0
    assert ertel_(*TRACTION, "--quiet").output == ""
    with monkeypatch.context() as patch:  # a picture that fails: one line, and all numbers
        patch.setattr(Figure, "savefig", raising(RuntimeError("no font")))
        failed = ertel_(*TRACTION, code=1)
    assert failed.stdout.splitlines()[:-1] == text.splitlines()[:-1]
    [line] = failed.stderr.splitlines()
    assert line.startswith("ertel: warning: ") and "traction.png is not drawn (no font)" in line
    assert names(curve) == LEFT | {"runs", "traction.zarr", "traction.csv"}
    checkpoint = run / "checkpoint.npz"
    checkpoint.write_bytes(checkpoint.read_bytes().replace(b"newton", b"nawton"))
    assert "checkpoint.npz: is damaged (its checksum does not agree)" in ertel_(*TRACTION, code=2).stderr


def test_a_fit_is_printed_and_stored_and_goes_on(here, monkeypatch):
    """Also after an interruption behind its first run."""
    place, finish = here / "fits" / "film", RunStore.finish

    def finish_and_interrupt(store, summary):
        finish(store, summary)
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(FitResult, "plot", lambda self: Figure())  # what is drawn is tested with fits
    with monkeypatch.context() as patch:
        patch.setattr(RunStore, "finish", finish_and_interrupt)
        assert ertel_(*FITTED, code=130).stderr.splitlines()[-1] == GOES_ON
    assert names(place) - LEFT == {"runs", "progress.json"} and len(names(place / "runs")) == 1
    [first] = place.glob("runs/*/summary.json")
    before = first.stat().st_mtime_ns
    assert (read_progress(place)["status"], read_progress(place)["step"]) == ("running", 0)
    text = ertel_(*FITTED, "--keep", "all").stdout
    for part in ("fit of drop", "20 mPa*s", "5 %", "the prior does, to 5 %", "with fit.zarr, fit.csv and fit.png"):
        assert part in text
    assert names(place) == LEFT | {"runs", "progress.json", "fit.zarr", "fit.csv", "fit.png"}
    assert first.stat().st_mtime_ns == before and len(names(place / "runs")) > 1  # no run is computed twice
    with (place / "fit.png").open("rb") as picture, (place / "fit.csv").open() as table:
        assert picture.read(4) == b"\x89PNG" and table.readline().startswith("measurement,quantity,conditions")
    progress = read_progress(place)
    assert (progress["status"], progress["done"]) == ("converged", 1.0) and progress["step"] > 0
    assert progress["message"].endswith("eta0 = 20 mPa*s")
    monkeypatch.setattr("ertel.runs.store.drive", None)  # nothing is computed again
    [unknown] = json.loads(ertel_(*FITTED, "--json").stdout)["unknowns"]
    assert unknown["value"] == pytest.approx(0.02, rel=1e-3) and unknown["unit"] == "Pa*s"
    assert names(place / "runs") == {open_study(place).case.digest}  # that of the values


@pytest.mark.parametrize(
    ("command", "file"),
    [
        (SWEEP, "sweep.csv"),
        *((TRACTION, name) for name in ("case.toml", "traction.csv", "traction.png", "traction.json")),
    ],
)
def test_files_of_the_user_are_left_alone(here, command, file):
    """Also a curve of an earlier version, which is traction.json."""
    (here / "mine").mkdir()
    (here / "mine" / file).write_text("mine")
    complaint = f"{here / 'mine'}: holds other files ({file}); give a new or empty directory, or that of an earlier"
    assert f"--out {complaint}" in refused(*command, "--out", "mine")
    if command is SWEEP:
        with pytest.raises(StoreError, match=re.escape(f"directory {complaint} study")):
            ertel.sweep("loads.toml", "mine")
    assert names(here / "mine") == {file} and (here / "mine" / file).read_text() == "mine"


@pytest.mark.parametrize("speeds", ["0.001:x:5", "5:5:5"])
def test_speeds_of_a_stribeck_curve_are_named_as_they_are_typed(here, speeds):
    law = 'surfaces.asperities={ law = "exponential", pressure = "3 GPa", length = "40 nm" }'
    touching = ("--set", "contact.slide_to_roll=0.1", "--set", law)
    assert f'--speed = "{speeds}' in refused("stribeck", "ball.toml", *touching, "--speed", speeds)
