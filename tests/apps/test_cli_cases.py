"""`ertel new`, `check`, `oils`, `about`, and `run --help-keys`; completion, --flush and progress.json."""

import json
import re
import tomllib
from pathlib import Path

import jsonschema
import pytest
from app_runs import CASE_FILES, given, refused, write_progress
from cases import ertel_, names
from typer.testing import CliRunner

import ertel
from ertel.apps import arguments
from ertel.apps.cli import app
from ertel.case.sections import SOLVERS
from ertel.inputs import materials, oils
from ertel.inputs.case_files import load_case, parse_case
from ertel.inputs.layout import places
from ertel.inputs.templates import SCHEMA_FILE, json_schema, template
from ertel.runs import directory, drive, outlook, store
from ertel.runs.directory import PROGRESS, ProgressFile, read_progress
from ertel.runs.drive import run_of

EXAMPLES = Path(__file__).parents[2] / "examples"
KINDS = ("impact", "rolling")
HEAD = re.compile(r"(?:# )?(\[+\w+\]+) ")
COMMENTED = re.compile(r"# ([a-zA-Z]\w* = .*)")


# -- new --------------------------------------------------------------------------------------------------------------


SHORT = {
    "impact": ("time.until=0.02",),
    "rolling": ("contact.load=2 N",),  # a thick film
    "rolling under its own load": ("solver.nodes=65",),
}
RUNS = [pytest.param(name, marks=[] if name in KINDS else pytest.mark.slow) for name in SHORT]


@pytest.mark.parametrize("name", RUNS)
def test_new_writes_a_case_that_loads_and_runs(here, name):
    kind = name.split()[0]
    assert ertel_("new", kind).stdout.split() == [f"{kind}.toml", SCHEMA_FILE]
    case = load_case(here / f"{kind}.toml")
    assert (case.kind, case.name) == (kind, kind)
    assert (here / f"{kind}.toml").read_text().startswith(f"#:schema ./{SCHEMA_FILE}\n")
    assert json.loads((here / SCHEMA_FILE).read_text()) == json_schema()
    ertel_("run", f"{kind}.toml", *given("solver.nodes=33", "solver.tolerance=0.03", *SHORT[name]), "--quiet")
    assert "summary.json" in names(here / "runs" / kind)


def test_new_overwrites_nothing(here):
    (here / SCHEMA_FILE).write_text("mine")
    assert ertel_("new", "impact", "mine.toml").stdout == "mine.toml\n"
    (here / "mine.toml").write_text("mine")
    assert "mine.toml exists already" in refused("new", "rolling", "mine.toml")
    assert [(here / name).read_text() for name in ("mine.toml", SCHEMA_FILE)] == ["mine", "mine"]


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_in_a_comment_is_valid_by_itself(kind):
    validator = jsonschema.Draft202012Validator(json_schema())
    section, tried = "", 0
    for line in template(kind, "case.toml").splitlines():
        if head := HEAD.match(line):
            section = head[1]
        elif (key := COMMENTED.match(line)) and section != "[[roughness]]":  # which needs its shape
            data = tomllib.loads(f"{section}\n{key[1]}")
            assert [error.message for error in validator.iter_errors({"contact": {}, **data})] == []
            tried += 1
    assert tried > 35


def test_the_roughness_in_comments_is_valid():
    text = template("rolling", "case.toml")
    lines = [line.removeprefix("# ") for line in text[text.index("# [[roughness]]") :].split("\n\n")[0].splitlines()]
    shape = [line for line in lines if not line.startswith("height")]  # in place of depth
    data = tomllib.loads(text + "\n".join(shape))
    data["solver"]["method"] = "transient"
    assert parse_case(data).roughness[0].shape.radius


@pytest.mark.parametrize("kind", KINDS)
def test_the_template_has_all_keys_of_its_kind(kind):
    text = template(kind, "case.toml")
    contact = text[text.index("[contact]") : text.index("[lubricant]")]
    other = KINDS[1 - KINDS.index(kind)]
    for key in next(place.keys for place in places() if place.title == "[contact]"):
        there = re.search(rf"^(# )?{key.name} = ", contact, re.MULTILINE) is not None
        assert there != key.meaning.text.startswith(f"{other}:"), key.name


# -- schema -----------------------------------------------------------------------------------------------------------


def test_schema():
    assert json.loads(ertel_("new", "--schema").stdout) == json_schema()


def test_keys_in_the_help():
    text = ertel_("run", "--help-keys").stdout
    assert "[contact]  the two bodies" in text
    assert "  nodes  (integer; default 257)\n      nodes per side" in text


# -- check ------------------------------------------------------------------------------------------------------------


def checked(name, *changes):
    return json.loads(ertel_("check", str(EXAMPLES / f"{name}.toml"), "--json", *given(*changes)).stdout)


@pytest.mark.parametrize("name", ["rolling", "steel_ball_impact", "moes_impact", "micro_cavity", "ball_bearing"])
def test_check_of_examples(name):
    found, case = checked(name), load_case(EXAMPLES / f"{name}.toml")
    assert found["parameters"]["M"] == case.parameters.M
    assert found["digest"] == case.digest
    assert bool(found["films"]) == (case.kind == "rolling")
    assert found["memory"]["needed"] > 5e8
    assert bool(found["time"]["steps"]) != case.is_steady


def test_check_says_what_a_run_would_say():
    """The sentence of the run's own warning: 33 nodes do not resolve the front."""
    said = ertel_("check", str(EXAMPLES / "steel_ball_impact.toml"), "--set", "solver.nodes=33").stdout
    assert re.search(r"Warning: the film is not resolved at the front \(2\.\d cells .* use solver.nodes >= 1\d\d", said)


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("rolling", "solver.inlet=4.4", "centre of the contact is not a node"),
        ("rolling", "solver.nodes=65", "the film is not resolved in the inlet"),
        ("moes_impact", "time.start_approach=-0.01", "the initial gap 0.01"),
        ("micro_cavity", "solver.nodes=65", "the roughness is not resolved"),
        ("rolling", 'contact.load="38.9 MN"', "the contact is not small (a = 1"),
    ],
)
def test_warnings_without_a_run(name, change, said):
    assert any(said in warning for warning in checked(name, change)["warnings"])


def test_check_of_a_grid_of_4097_nodes():
    assert checked("rolling", "solver.nodes=4097")["grid"]["nodes"] == 4097


def test_a_grid_beyond_the_memory_is_said(monkeypatch):
    monkeypatch.setattr("ertel.runs.outlook.memory_available", lambda: 1e9)
    first, *_ = checked("rolling", "solver.nodes=2049")["warnings"]
    assert re.match(r"solver.nodes = 2049 needs about \S+ GB of memory, the machine has 1 GB; ", first)


@pytest.mark.parametrize(
    ("change", "bounds"),
    [
        ('contact.radius="10 furlong"', "1e-06 and 100 m"),
        ('contact.speed="300 km/s"', "1e-09 and 10000 m/s"),
        ('contact.E1="210 mPa"', "1 and 1e+14 Pa"),
        ('contact.ball_density="7850 Mg/m^3"', "0.1 and 100000 kg/m^3"),
        ('lubricant.eta0="40 MPa*s"', "1e-07 and 1e+06 Pa*s"),
        ('lubricant.alpha="22 / Pa"', "1e-13 and 1e-05 1/Pa"),
    ],
)
def test_absurd_sizes_are_refused(change, bounds):
    said = refused("check", str(EXAMPLES / "steel_ball_impact.toml"), "--set", change)
    assert change.replace("=", " = ") in said and f"must be between {bounds}" in said


def test_both_radii_together_may_be_absurd(here):
    text = (EXAMPLES / "rolling.toml").read_text().replace('radius = "10 mm"', 'radius_1 = "9 km"\nradius_2 = "9 km"')
    (here / "far.toml").write_text(text)
    assert "contact: its values together give R = 4500.0, which must be between" in refused("check", "far.toml")


@pytest.mark.parametrize(
    "changes",
    [
        ["contact.radius=2 um", "contact.speed=1 mm/s"],  # the tip of an indenter
        ["contact.radius=2 m", "contact.speed=10 m/s"],
        ["contact.E1=100 kPa", "contact.E2=100 kPa"],  # a gel
        ["contact.E1=1.1 TPa", "contact.E2=1.1 TPa"],  # diamond
        ["lubricant.eta0=1 mPa*s", "lubricant.alpha=0.5 / GPa"],  # water
        ["lubricant.eta0=2 kPa*s", "lubricant.alpha=60 / GPa"],  # a cold traction fluid
    ],
    ids=str,
)
def test_real_contacts_are_not_refused(changes):
    load_case(EXAMPLES / "steel_ball_impact.toml", changes)


# -- oils -------------------------------------------------------------------------------------------------------------


def test_the_library_of_oils():
    text, data = ertel_("oils").output, json.loads(ertel_("oils", "--json").output)
    assert all(name in text for name in (*oils.names(), *materials.names()))
    assert "…" not in text
    assert "14.9" in next(line for line in text.splitlines() if line.startswith("squalane"))
    assert [oil["name"] for oil in data["oils"]] == list(oils.names())
    one = json.loads(ertel_("oils", "squalane", "--json").output)
    assert one in data["oils"]
    assert one["viscosity"]["nu40"] == 18.73e-6
    for name in (*oils.names(), *materials.names()):
        entry = ertel_("oils", name).output
        assert entry.startswith(f"{name}: ")
        assert entry.count("source: ") >= 2
    assert 'NAME = "wood": allowed: iso-vg-100' in refused("oils", "wood")


# -- how long a run takes ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "changes", "measured"),
    [
        ("moes_impact", ["solver.method=2d", "time.until=max-approach"], 178),
        ("moes_impact", ["solver.method=2d", "time.until=max-approach", "time.tolerance=1e-3"], 77),
        ("moes_impact", ["solver.method=2d"], 417),
        ("steel_ball_impact", [], 259),
        ("micro_cavity", [], 295),
        ("micro_cavity", ["time.step=0.01"], 360),
    ],
)
def test_steps_are_those_that_were_counted(name, changes, measured):
    """Counted on 33 nodes; within a factor of 1.5."""
    case = load_case(EXAMPLES / f"{name}.toml", ["solver.nodes=33", *changes])
    assert measured / 1.5 < outlook.expected_steps(case) < 1.5 * measured


def test_seconds_of_the_benchmarks():
    """benchmarks/README.md: 0.29 s a step on 1025 nodes per side, 6.8 s for steady rolling, both of M = 1000."""
    impact = load_case(EXAMPLES / "moes_impact.toml", ["solver.method=2d", "solver.nodes=1025"])
    a_step = (outlook.expected_seconds(impact) - outlook.SECONDS_TO_START) / outlook.expected_steps(impact)
    assert a_step == pytest.approx(0.29, rel=0.5)
    rolling = load_case(EXAMPLES / "rolling.toml", ["solver.nodes=1025"])
    assert outlook.expected_seconds(rolling) - outlook.SECONDS_TO_START == pytest.approx(6.8, rel=0.5)


def test_an_oscillation_needs_steps():
    case = load_case(EXAMPLES / "reversal.toml", ["motion.entrainment={ mean = 1, amplitude = 0.5, period = 0.01 }"])
    assert outlook.expected_steps(case) == pytest.approx(16 * 8 / 0.01, rel=0.01)


def test_the_usual_tolerance_is_that_of_the_counts():
    assert SOLVERS["2d"].tolerance == 1e-3


# -- about ------------------------------------------------------------------------------------------------------------


def test_about_a_run(ball):
    text = ertel_("show", "my run", "--about").stdout
    for said in ("my run", load_case(ball / "case.toml").digest, ertel.__version__, "converged, after"):
        assert said in text
    for name in ("machine", "jaxlib"):
        assert re.search(rf"^{name} +\S", text, re.MULTILINE)


def test_about_a_run_that_has_not_ended(ball):
    (ball / "summary.json").unlink()
    write_progress(ball, done=0.0)
    assert re.search(r"end +not yet, 0% done at 20", ertel_("show", "my run", "--about").stdout)
    (ball / PROGRESS).unlink()
    assert re.search(r"end +not yet\n", ertel_("show", "my run", "--about").stdout)


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
    for command in ("show", "plot", "resume"):
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
