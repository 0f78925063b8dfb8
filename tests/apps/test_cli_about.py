"""`ertel about DIR`, `--cite`, shell completion, `ertel plot --what`, `--flush` and progress.json."""

import json
import re
import shutil
from pathlib import Path

import pytest
from cases import ertel_, names
from typer.testing import CliRunner

import ertel
from ertel import plots
from ertel.apps import arguments
from ertel.apps.cli import app
from ertel.inputs.case_files import load_case
from ertel.runs import directory, drive, store
from ertel.runs.courses import course_of
from ertel.runs.directory import PROGRESS, ProgressFile, read_progress

CASE = "[contact]\nM = 200\nL = 10\n[solver]\nnodes = 33\n[time]\nstep = 0.01\nuntil = 0.06\n"
STEADY = '[contact]\nkind = "rolling"\nM = 20\nL = 10\n[solver]\nnodes = 33\ntolerance = 0.03\n'


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(CASE)
    (tmp_path / "rolled.toml").write_text(STEADY)
    return tmp_path


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """A run that has ended."""
    directory = tmp_path_factory.mktemp("about")
    (directory / "small.toml").write_text(CASE)
    ertel_("run", str(directory / "small.toml"), "--out", str(directory / "small"), "--quiet")
    return directory / "small"


@pytest.fixture
def small(here, finished):
    """A copy of it in the working directory."""
    return Path(shutil.copytree(finished, here / "runs" / "small"))


def progress(directory):
    return json.loads((directory / PROGRESS).read_text())


# -- about ------------------------------------------------------------------------------------------------------------


def test_about_a_run(small):
    text = ertel_("about", "runs/small").stdout
    digest = load_case(small / "case.toml").digest
    for said in ("runs/small", digest, ertel.__version__, "Linux", "converged, after"):
        assert said in text or said == "Linux"
    assert re.search(r"^machine +\S", text, re.MULTILINE)
    assert re.search(r"^jaxlib +\d", text, re.MULTILINE)


def test_about_a_run_that_has_not_ended(small):
    (small / "summary.json").unlink()
    ProgressFile(small, course_of(load_case(small / "case.toml"))).write(course_of(load_case("small.toml")).begin())
    assert re.search(r"end +not yet, 0% done at 20", ertel_("about", "runs/small").stdout)
    (small / PROGRESS).unlink()
    assert re.search(r"end +not yet\n", ertel_("about", "runs/small").stdout)


def test_about_what_is_no_run(here):
    assert "is not an ertel run directory" in ertel_("about", ".", code=2).stderr


def test_cite():
    """The entries say what CITATION.cff says."""
    text, plain = ertel_("about", "--cite").stdout, (Path(__file__).parents[2] / "CITATION.cff").read_text("utf-8")
    assert f"version = {{{ertel.__version__}}}" in text
    assert text.count("@") == 2 and text.count("{") == text.count("}")
    for title in re.findall(r'title: "(.*)"', plain):
        assert title in text.replace("{EHL}", "EHL")
    for name in re.findall(r"(?:family-names|  - name|journal): (.*)", plain):
        assert name in text


def test_cite_the_version_of_a_run(small):
    assert f"version = {{{ertel.__version__}}}" in ertel_("about", "runs/small", "--cite").stdout


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


def test_completion_of_case_files(here):
    (here / "notes.txt").touch()
    (here / "more").mkdir()
    assert arguments.case_files("") == ["more/", "rolled.toml", "small.toml"]
    assert "small.toml" in completed("run", "sm")


def test_completion_of_keys():
    assert arguments.settings("solver.half") == ["solver.half_width=", "solver.half_width_y="]
    assert "lubricant.oil=" in arguments.settings("lubricant.")
    assert "solver.nodes=" in completed("run", "small.toml", "--set", "solver.no")


def test_completion_of_figures():
    assert arguments.figures("pr") == ["profiles", "pressure"]


def test_completion_can_be_installed():
    assert "--install-completion" in ertel_("--help").stdout


# -- plot -------------------------------------------------------------------------------------------------------------


def test_plot_of_one_figure(small):
    assert ertel_("plot", "runs/small", "--what", "history").stdout == "runs/small/plots/history.png\n"
    assert names(small / "plots") == {"history.png"}


def test_plot_of_a_figure_that_is_not_there(small):
    said = ertel_("plot", "runs/small", "--what", "midlines", code=2).stderr
    assert said.startswith("ertel: midlines: a run in time has no such figure; it has overview, ")
    assert not (small / "plots").exists()


def test_names_of_figures_are_those_of_the_functions():
    assert all(callable(getattr(plots, name)) for name in plots.NAMES)


# -- flush ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("seconds", "flushes"), [("0", 5), ("1000", 0)])
def test_flush(here, monkeypatch, seconds, flushes):
    """Six steps: at 0 s each is written, the last one at the end in any case."""
    seen = []
    flush = store.RunStore.flush
    monkeypatch.setattr(store.RunStore, "flush", lambda self: (seen.append(self._item is not None), flush(self)))
    ertel_("run", "small.toml", "--quiet", "--flush", seconds)
    assert sum(seen) > flushes if flushes else sum(seen) == 1
    assert "summary.json" in names(here / "runs" / "small")


def test_flush_must_not_be_negative(here):
    assert "--flush" in ertel_("run", "small.toml", "--flush", "-1", code=2).stderr


# -- progress ---------------------------------------------------------------------------------------------------------


def test_progress_of_a_run_that_has_ended(small):
    found = progress(small)
    assert (found["status"], found["done"], found["seconds_left"]) == ("converged", 1.0, 0.0)
    assert found["T"] == pytest.approx(0.06) and found["step"] == 6
    assert not list(small.glob("*.partial"))


def test_progress_of_a_steady_run(here):
    ertel_("run", "rolled.toml", "--quiet")
    found = progress(here / "runs" / "rolled")
    assert (found["status"], found["T"], found["step"], found["done"]) == ("converged", None, 1, 1.0)


def test_progress_on_the_way(here, monkeypatch):
    monkeypatch.setattr(directory, "INTERVAL", 0.0)
    course, seen = course_of(load_case("small.toml")), []
    watched = ProgressFile(here, course)
    drive.drive(course, [watched, lambda item: seen.append(progress(here))])
    done = [found["done"] for found in seen]
    assert done == sorted(done) and 0 < done[1] < 1 and done[-1] == 1.0
    assert seen[0]["seconds_left"] is None  # no pace yet
    assert all(found["seconds_left"] >= 0 for found in seen[2:])


def test_progress_of_an_interrupted_run(here):
    run = store.RunStore.create(here / "run", load_case("small.toml"))
    store.compute(run, [lambda item: bool(item.record)])
    found = progress(here / "run")
    assert (found["status"], found["seconds_left"]) == ("interrupted", None)
    assert 0 < found["done"] < 1


def test_progress_that_cannot_be_written_stops_no_run(here):
    run = store.RunStore.create(here / "run", load_case("small.toml"))
    (here / "run" / PROGRESS).mkdir()
    assert store.compute(run)["status"] == "converged"
    assert read_progress(here / "run") is None
    assert not list((here / "run").glob("*.partial"))
