"""`ertel sweep`: what it prints and writes, its exit codes, and how it goes on."""

import csv
import json
import re
from pathlib import Path

import pytest
from app_runs import refused
from cases import ertel_, names

import ertel
from ertel.runs.directory import STOP, ask_to_stop
from ertel.runs.files import StoreError
from ertel.runs.store import RunStore

STUDY = """
[contact]
M = [20, 40]
L = 5
[solver]
method = "radial"
nodes = 17
[time]
until = 0.02
tolerance = 0.1
[sweep]
mode = "product"
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A working directory with a study."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loads.toml").write_text(STUDY)
    return tmp_path


def test_a_study_from_its_file_to_its_table(here):
    done = ertel_("sweep", "loads.toml", "--jobs", "1")
    assert done.stderr == "2 runs, 2 of them to do\n"
    title, head, *rows, said, film, start, mass, stored = done.stdout.splitlines()
    assert title == "loads" and head.split()[0] == "M" and [row.split()[0] for row in rows] == ["20", "40"]
    assert said == "2 runs: 2 converged; 2 with warnings" and "warnings" in head.split()  # 17 nodes are few
    for warning in (film, start, mass):
        assert warning.startswith("Warning: runs/") and warning.endswith("(and 1 other run)")
    assert stored == "Stored in sweeps/loads, with sweep.zarr and sweep.csv"  # too short for key numbers to draw
    with (here / "sweeps/loads/sweep.csv").open() as file:
        directories = [row["directory"] for row in csv.DictReader(file)]
    shown = ertel_("show", f"sweeps/loads/{directories[0]}").stdout
    assert shown.startswith("loads: M = 20, L = 5 (radial")
    again = ertel_("sweep", "loads.toml", "--json", "--set", "contact.M=[40, 60]", "--jobs", "1")
    assert again.stderr == "2 runs, 1 of them to do\n"
    found = [(run["M"], run["status"]) for run in json.loads(again.stdout)["runs"]]
    assert found == [(40.0, "converged"), (60.0, "converged")]
    picture = here / "sweeps/loads/sweep.png"
    picture.write_text("of numbers that are no longer there")
    ertel_("sweep", "loads.toml", "--jobs", "1", "-q")
    assert not picture.exists()


@pytest.mark.parametrize("where", ["study", "run"])
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
        done = ertel_("sweep", "loads.toml", "--jobs", "1", code=130)
    assert done.stderr.splitlines()[-1] == "ertel: interrupted; the same command continues"
    other = "1 missing" if where == "study" else "1 converged"
    assert "1 interrupted" in done.stdout and other in done.stdout
    ask_to_stop(study)  # of before: it says nothing
    again = ertel_("sweep", "loads.toml", "--jobs", "1")
    assert "2 runs: 2 converged" in again.stdout
    assert not list(study.rglob(STOP))


def test_a_part_gathers_nothing(here):
    done = ertel_("sweep", "loads.toml", "--part", "2/2", "--jobs", "1", "--out", "study")
    assert done.stderr == "2 runs, 1 of them to do in part 2 of 2\n" and done.stdout == ""
    assert names(here / "study") == {"runs"} and len(names(here / "study/runs")) == 1
    assert ertel_("sweep", "loads.toml", "--out", "study", "--jobs", "1").stderr == "2 runs, 1 of them to do\n"


def test_files_of_the_user_are_left_alone(here):
    """Also from Python.  A study may have other files beside it, and a killed one goes on."""
    (here / "mine").mkdir()
    (here / "mine/sweep.csv").write_text("mine")
    complaint = f"{here / 'mine'}: holds other files (sweep.csv); give a new or empty directory, or that of an earlier"
    assert f"--out {complaint} study" in refused("sweep", "loads.toml", "--out", "mine")
    with pytest.raises(StoreError, match=re.escape(f"directory {complaint} study")):
        ertel.sweep("loads.toml", "mine")
    assert names(here / "mine") == {"sweep.csv"} and (here / "mine/sweep.csv").read_text() == "mine"
    (here / "study/runs").mkdir(parents=True)
    ertel_("sweep", "loads.toml", "--jobs", "1", "-q", "--out", "study")
    (here / "study/notes.txt").write_text("mine")
    ertel_("sweep", "loads.toml", "--jobs", "1", "-q", "--out", "study")


def test_runs_that_fail_are_named_and_the_others_go_on(here):
    ertel_("sweep", "loads.toml", "-q", "--jobs", "1")
    broken = sorted((here / "sweeps/loads/runs").iterdir())[0]
    (broken / "case.toml").write_text("[contact]\nM = 1\nL = 1\n")
    done = ertel_("sweep", "loads.toml", "--jobs", "1", "--set", "contact.M=[20, 40, 60]", code=1)
    assert "3 runs: 2 converged, 1 failed" in done.stdout
    last = done.stderr.splitlines()[-1]
    assert last.startswith(f"ertel: 1 of 3 runs failed: runs/{broken.name}; ertel show sweeps/loads/runs/")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "contact.M=20"], "the study has one case only: give a list"),
        (["--set", "contact.M=[20, 'x']"], 'contact.M = "x": must be a number (in the case with contact.M = "x")'),
        (["--set", "sweep.mode=grid"], 'sweep.mode = "grid": allowed: product, zip'),
        (["--part", "3/2"], "--part 3/2: must be I/N"),
        (["--scheduler", "tcp://a:1", "--scheduler-file", "b"], "scheduler = "),
        (["--jobs", "0"], "Invalid value for '--jobs'"),
    ],
)
def test_wrong_input_is_one_sentence_and_runs_nothing(here, arguments, message):
    assert message in refused("sweep", "loads.toml", "-q", *arguments)
    assert not list(Path().glob("sweeps/*/runs/*"))
