"""`ertel about DIR`, `--cite`, shell completion, `--flush` and progress.json."""

import re
from pathlib import Path

import pytest
from app_runs import CASE_FILES, refused, write_progress
from cases import ertel_, names
from typer.testing import CliRunner

import ertel
from ertel.apps import arguments
from ertel.apps.cli import app
from ertel.inputs.case_files import load_case
from ertel.runs import directory, drive, store
from ertel.runs.directory import PROGRESS, ProgressFile, read_progress
from ertel.runs.drive import run_of

# -- about ------------------------------------------------------------------------------------------------------------


def test_about_a_run(ball):
    text = ertel_("about", "my run").stdout
    for said in ("my run", load_case(ball / "case.toml").digest, ertel.__version__, "converged, after"):
        assert said in text
    for name in ("machine", "jaxlib"):
        assert re.search(rf"^{name} +\S", text, re.MULTILINE)
    assert f"version = {{{ertel.__version__}}}" in ertel_("about", "my run", "--cite").stdout
    assert "is not an ertel run directory" in refused("about", ".")


def test_about_a_run_that_has_not_ended(ball):
    (ball / "summary.json").unlink()
    write_progress(ball, done=0.0)
    assert re.search(r"end +not yet, 0% done at 20", ertel_("about", "my run").stdout)
    (ball / PROGRESS).unlink()
    assert re.search(r"end +not yet\n", ertel_("about", "my run").stdout)


def test_cite():
    """The entries say what CITATION.cff says."""
    text, plain = ertel_("about", "--cite").stdout, (Path(__file__).parents[2] / "CITATION.cff").read_text("utf-8")
    assert f"version = {{{ertel.__version__}}}" in text
    assert text.count("@") == 2 and text.count("{") == text.count("}")
    for title in re.findall(r'title: "(.*)"', plain):
        assert title in text.replace("{EHL}", "EHL")
    for name in re.findall(r"(?:family-names|  - name|journal): (.*)", plain):
        assert name in text


# -- completion -------------------------------------------------------------------------------------------------------


def completed(*words):
    """What a shell would offer for the last word."""
    environment = {"_ERTEL_COMPLETE": "complete_zsh", "_TYPER_COMPLETE_ARGS": " ".join(("ertel", *words))}
    return CliRunner().invoke(app, [], env=environment, prog_name="ertel").stdout


def test_completion_of_run_directories(here):
    for name in ("runs/small", "runs/smooth", "runs/other", ".hidden"):
        (here / name).mkdir(parents=True)
    for name in ("runs/small", "runs/smooth"):
        (here / name / "case.toml").touch()
    assert arguments.run_directories("") == ["runs/"]
    assert arguments.run_directories("runs/") == ["runs/other/", "runs/small", "runs/smooth"]
    assert arguments.run_directories("nowhere/") == []
    for command in ("show", "plot", "resume", "about"):
        said = completed(command, "runs/sm")
        assert "runs/small" in said and "runs/smooth" in said and "other" not in said


def test_completion_of_case_files_keys_and_figures(here):
    (here / "notes.txt").touch()
    (here / "more").mkdir()
    assert arguments.case_files("") == sorted(["more/", *CASE_FILES])
    assert "small.toml" in completed("run", "sm")
    assert arguments.settings("solver.half") == ["solver.half_width=", "solver.half_width_y="]
    assert "lubricant.oil=" in arguments.settings("lubricant.")
    assert "solver.nodes=" in completed("run", "small.toml", "--set", "solver.no")
    assert sorted(arguments.figures("pr")) == ["pressure", "profiles"]


# -- flush ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("seconds", "flushes"), [("0", 5), ("1000", 0)])
def test_flush(here, monkeypatch, seconds, flushes):
    """Six steps: at 0 s each is written, the last one at the end in any case."""
    seen = []
    flush = store.RunStore.flush
    monkeypatch.setattr(store.RunStore, "flush", lambda self: (seen.append(self._item is not None), flush(self)))
    ertel_("run", "ball.toml", "--quiet", "--flush", seconds)
    assert sum(seen) > flushes if flushes else sum(seen) == 1
    assert "summary.json" in names(here / "runs" / "ball")


# -- progress; that of a steady run is tested with the rolling contacts ------------------------------------------------


def test_progress_of_a_run_that_has_ended(ball):
    progress = read_progress(ball)
    assert (progress["status"], progress["done"], progress["seconds_left"]) == ("converged", 1.0, 0.0)
    assert progress["T"] == pytest.approx(0.06) and progress["step"] == 6
    assert not list(ball.glob("*.partial"))


def test_progress_on_the_way(here, monkeypatch):
    monkeypatch.setattr(directory, "INTERVAL", 0.0)
    course, seen = run_of(load_case("ball.toml")), []
    drive.drive(course, [ProgressFile(here, course), lambda item: seen.append(read_progress(here))])
    done = [found["done"] for found in seen]
    assert done == sorted(done) and 0 < done[1] < 1 and done[-1] == 1.0
    assert seen[0]["seconds_left"] is None  # no pace yet
    assert all(found["seconds_left"] >= 0 for found in seen[2:])


def test_progress_of_an_interrupted_run_and_where_it_cannot_be_written(here):
    run = store.RunStore.create(here / "run", load_case("ball.toml"))
    store.compute(run, [lambda item: bool(item.record)])
    found = read_progress(here / "run")
    assert (found["status"], found["seconds_left"]) == ("interrupted", None)
    assert 0 < found["done"] < 1
    (here / "run" / PROGRESS).unlink()
    (here / "run" / PROGRESS).mkdir()
    assert store.compute(run)["status"] == "converged"
    assert read_progress(here / "run") is None
    assert not list((here / "run").glob("*.partial"))
