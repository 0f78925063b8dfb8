"""`ertel traction`: table, files, interruption and going on, and what is refused."""

import csv
import json
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from app_runs import refused
from cases import LEFT, ertel_, names
from matplotlib.figure import Figure

import ertel
from ertel.case.status import Status
from ertel.results.study_result import StudyResult
from ertel.runs.drive import drive
from ertel.runs.store import RunStore

CASE = """
[contact]
kind = "rolling"
radius = "10 mm"
E_prime = "226 GPa"
load = "20 N"
mean_speed = "1 m/s"
[lubricant]
eta0 = "40 mPa*s"
alpha = "20 / GPa"
[solver]
nodes = 33
"""
FILES = LEFT | {"runs", "traction.zarr", "traction.csv", "traction.png"}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.toml").write_text(CASE)
    (tmp_path / "drop.toml").write_text("[contact]\nM = 20\nL = 10\n[solver]\nnodes = 33\n")
    return tmp_path


@pytest.fixture
def empty_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is drawn is tested with the curves."""
    monkeypatch.setattr(StudyResult, "plot", lambda curve: Figure())


def rows(directory: Path) -> list[dict[str, str]]:
    with (directory / "traction.csv").open() as file:
        return list(csv.DictReader(file))


def test_a_curve_is_printed_and_stored_and_shown_by_the_same_command(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command, curve = ("traction", "ball.toml", "--slide-to-roll", "0:0.04:3"), here / "traction" / "ball"
    text = ertel_(*command).stdout
    for part in ("3 points over the slide-to-roll ratio", "mu_r", "h_c (nm)", "Film: solved once", "traction/ball"):
        assert part in text
    assert names(curve) == FILES
    assert [float(row["slide_to_roll"]) for row in rows(curve)] == [0.0, 0.02, 0.04]
    assert (curve / "traction.png").read_bytes().startswith(b"\x89PNG")
    [run] = (curve / "runs").iterdir()
    monkeypatch.setattr("ertel.runs.store.drive", None)  # nothing is solved again
    assert ertel_(*command).stdout == text
    data = json.loads(ertel_(*command, "--json").stdout)
    assert [point["slide_to_roll"] for point in data["points"]] == [0.0, 0.02, 0.04]
    assert data["points"][0]["mu_sliding"] == 0.0
    assert ertel_(*command, "--quiet").output == ""
    checkpoint = run / "checkpoint.npz"
    checkpoint.write_bytes(checkpoint.read_bytes().replace(b"newton", b"nawton"))
    assert "checkpoint.npz: is damaged (its checksum does not agree)" in ertel_(*command, code=2).stderr


def test_an_interrupted_curve_goes_on(here: Path, monkeypatch: pytest.MonkeyPatch, empty_picture: None) -> None:
    command = ("traction", "ball.toml", "--mean-speed", "0.5:2 m/s:2:log", "--set", "contact.slide_to_roll=0.02")
    ertel_(*command, "--out", "whole", "-q")
    finish = RunStore.finish

    def finish_and_interrupt(store: RunStore, summary: Any) -> None:
        finish(store, summary)
        signal.raise_signal(signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(RunStore, "finish", finish_and_interrupt)
        result = ertel_(*command, "--out", "cut", code=130)
    assert "interrupted; the same command continues" in result.stderr
    assert "1 points over the mean speed, not complete" in result.stdout
    assert [row["status"] for row in rows(here / "cut")] == ["converged", "missing"]
    ertel_(*command, "--out", "cut", "-q")
    assert rows(here / "cut") == rows(here / "whole")
    assert [float(row["mean_speed_m_per_s"]) for row in rows(here / "cut")] == pytest.approx([0.5, 2.0])


def test_a_curve_with_other_values_keeps_the_films_that_it_shares(here: Path, empty_picture: None) -> None:
    ertel_("traction", "ball.toml", "--load", "20:40 N:2", "--out", "curve", "-q")
    ertel_("traction", "ball.toml", "--load", "20:40 N:3", "--out", "curve", "-q")
    assert [float(row["load_N"]) for row in rows(here / "curve")] == [20.0, 30.0, 40.0]
    assert len(names(here / "curve" / "runs")) == 3
    for row in rows(here / "curve"):
        assert ertel.open(here / "curve" / row["directory"]).case.contact.load == float(row["load_N"])
    (here / "curve" / "notes.txt").write_text("beside a curve there may be other files")
    before = (here / "curve" / "traction.csv").read_text()
    ertel_("traction", "ball.toml", "--load", "30,40", "--out", "curve", "-q")
    assert [float(row["load_N"]) for row in rows(here / "curve")] == [30.0, 40.0]  # the table is of the last request
    assert all(line in before for line in (here / "curve" / "traction.csv").read_text().splitlines())
    assert len(names(here / "curve" / "runs")) == 3  # and the films are kept


@pytest.mark.parametrize("name", ["case.toml", "traction.csv", "traction.png", "traction.json"])
def test_files_of_the_user_are_left_alone(here: Path, name: str) -> None:
    """Also a curve of an earlier version, which is traction.json."""
    (here / "mine").mkdir()
    (here / "mine" / name).write_text("mine")
    said = refused("traction", "ball.toml", "--slide-to-roll", "0:0.04:3", "--out", "mine")
    assert f"--out {here / 'mine'}: holds other files ({name}); give a new or empty directory" in said
    assert names(here / "mine") == {name} and (here / "mine" / name).read_text() == "mine"


def test_a_film_that_does_not_converge_fails(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stalled(*arguments: Any) -> Any:
        return replace(drive(*arguments), status=Status.NEWTON_STALLED)

    monkeypatch.setattr("ertel.runs.store.drive", stalled)
    result = ertel_("traction", "ball.toml", "--slide-to-roll", "0:0.04:3", code=1)
    assert "failed: the film did not converge at slide_to_roll = 0, 0.02, 0.04" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("ball.toml", "give exactly one of slide_to_roll, mean_speed, load; got none"),
        ("ball.toml --slide-to-roll 0:1:3 --load 1:2:3", "got slide_to_roll and load"),
        ("ball.toml --slide-to-roll 0:1", 'slide_to_roll = "0:1": must be FIRST:LAST:NUMBER'),
        ("ball.toml --slide-to-roll 0:1:3 --film two", 'film = "two": allowed: each, once'),
        ("drop.toml --slide-to-roll 0:1:3", "a traction curve is of a steady contact"),
        ("ball.toml --slide-to-roll 0:1:3 --set solver.nodes=66", "solver.nodes = 66: must be"),
    ],
)
def test_wrong_input_is_refused_in_a_sentence(here: Path, arguments: str, said: str) -> None:
    assert said in refused("traction", *arguments.split())
    assert not (here / "traction").exists()
