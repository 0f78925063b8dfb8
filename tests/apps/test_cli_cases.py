"""`ertel new`, `check`, `oils`, `about`, and `run --help-keys`; completion, --flush and progress.json."""

import json
import re
import tomllib
from contextlib import nullcontext
from pathlib import Path

import jsonschema
import pytest
import typer
from app_runs import given, refused
from cases import ertel_, impact, names
from typer.testing import CliRunner

import ertel
from ertel.apps.cli import app
from ertel.apps.tables import film_rows
from ertel.apps.terminal import placing, print_text
from ertel.inputs import materials, oils
from ertel.inputs.case_files import load_case
from ertel.inputs.templates import SCHEMA_FILE, json_schema, template
from ertel.results.figures import MADE_BY
from ertel.results.numbers import Number
from ertel.results.variables import FILMS, VARIABLES
from ertel.runs import outlook, store
from ertel.runs.directory import PROGRESS, read_progress

EXAMPLES = Path(__file__).parents[2] / "examples"
HEAD = re.compile(r"(?:# )?(\[+\w+\]+) ")
COMMENTED = re.compile(r"# ([a-zA-Z]\w* = .*)")


@pytest.mark.parametrize(
    ("kind", "short"),
    [
        ("impact", "time.until=0.02"),
        ("rolling", "contact.load=2 N"),  # a thick film
        pytest.param("rolling", "solver.nodes=65", marks=pytest.mark.slow),  # under its own load
    ],
)
def test_new_writes_a_case_that_loads_and_runs(here, kind, short):
    assert ertel_("new", kind).stdout.split() == [f"{kind}.toml", SCHEMA_FILE]
    case = load_case(here / f"{kind}.toml")
    assert (case.kind, case.name) == (kind, kind)
    assert (here / f"{kind}.toml").read_text().startswith(f"#:schema ./{SCHEMA_FILE}\n")
    assert json.loads((here / SCHEMA_FILE).read_text()) == json_schema()
    ertel_("run", f"{kind}.toml", *given("solver.nodes=33", "solver.tolerance=0.03", short), "--quiet")
    assert "summary.json" in names(here / "runs" / kind)


def test_new_overwrites_nothing(here):
    (here / SCHEMA_FILE).write_text("mine")
    assert ertel_("new", "impact", "mine.toml").stdout == "mine.toml\n"
    (here / "mine.toml").write_text("mine")
    assert "mine.toml exists already" in refused("new", "rolling", "mine.toml")
    assert [(here / name).read_text() for name in ("mine.toml", SCHEMA_FILE)] == ["mine", "mine"]


@pytest.mark.parametrize("kind", ["impact", "rolling"])
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


@pytest.mark.parametrize("name", ["rolling", "steel_ball_impact", "moes_impact", "micro_cavity", "ball_bearing"])
def test_check_of_examples(name):
    file = EXAMPLES / f"{name}.toml"
    found, case = json.loads(ertel_("check", str(file), "--json").stdout), load_case(file)
    assert found["parameters"]["M"] == case.parameters.M
    assert found["digest"] == case.digest
    assert bool(found["films"]) == (case.kind == "rolling")
    assert found["memory"]["needed"] > 5e8
    assert bool(found["time"]["steps"]) != case.is_steady


def test_the_library_of_oils():
    text, data = ertel_("oils").output, json.loads(ertel_("oils", "--json").output)
    assert all(name in text for name in (*oils.names(), *materials.names()))
    assert "…" not in text
    assert "14.9" in next(line for line in text.splitlines() if line.startswith("squalane"))
    assert [oil["name"] for oil in data["oils"]] == list(oils.names())
    one = json.loads(ertel_("oils", "squalane", "--json").output)
    assert one in data["oils"] and one["viscosity"]["nu40"] == 18.73e-6
    for name in (*oils.names(), *materials.names()):
        entry = ertel_("oils", name).output
        assert entry.startswith(f"{name}: ") and entry.count("source: ") >= 2
    assert 'NAME = "wood": allowed: iso-vg-100' in refused("oils", "wood")


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


def test_about_a_run(ball):
    text = ertel_("show", "my run", "--about").stdout
    for said in ("my run", load_case(ball / "case.toml").digest, ertel.__version__, "converged, after"):
        assert said in text
    assert re.search(r"^machine +\S", text, re.MULTILINE) and re.search(r"^jaxlib +\S", text, re.MULTILINE)
    assert json.loads(ertel_("show", "my run", "--about", "--json").stdout)["ertel"] == ertel.__version__


def test_the_entries_to_cite_say_what_the_file_for_it_says():
    text, plain = ertel_("about", "--cite").stdout, (EXAMPLES.parent / "CITATION.cff").read_text("utf-8")
    assert f"version = {{{ertel.__version__}}}" in text
    assert text.count("@") == 2 and text.count("{") == text.count("}")
    said = re.findall(r'title: "(.*)"', plain) + re.findall(r"(?:family-names|  - name|journal): (.*)", plain)
    assert said and [each for each in said if each not in text.replace("{EHL}", "EHL")] == []


def completed(*words):
    """What a shell would offer for the last word."""
    environment = {"_ERTEL_COMPLETE": "complete_zsh", "_TYPER_COMPLETE_ARGS": " ".join(("ertel", *words))}
    return CliRunner().invoke(app, [], env=environment, prog_name="ertel").stdout


def test_completion_of_names_is_by_ertel_and_of_paths_by_the_shell():
    for words, name in ((("plot", "ball", "--what", "fi"), "film"), (("check", "--set", "solver.n"), "solver.nodes=")):
        assert name in completed(*words)
    for command in ("show", "check"):
        assert completed(command, "runs/sm").strip() == "_files"


def test_progress_of_an_interrupted_run_and_where_it_cannot_be_written(here):
    run = store.RunStore.create(here / "run", load_case("ball.toml"))
    store.compute(run, [lambda item: bool(item.record)])
    found = read_progress(here / "run")
    assert (found["status"], found["seconds_left"]) == ("interrupted", None) and 0 < found["done"] < 1
    (here / "run" / PROGRESS).unlink()
    (here / "run" / PROGRESS).mkdir()
    assert store.compute(run)["status"] == "converged"
    assert read_progress(here / "run") is None
    assert not list((here / "run").glob("*.partial"))


def test_a_table_replaces_no_file_that_only_has_the_mark(tmp_path):
    """The mark is that of pictures; a text of the user may speak of it."""
    notes = tmp_path / "notes.txt"
    notes.write_text(f"drawn by {MADE_BY}")
    for content, outcome in (("x_m,h_m", pytest.raises(typer.Exit)), (f"picture, {MADE_BY}", nullcontext())):
        with outcome, placing(tmp_path) as place:
            (place / notes.name).write_text(content)
    assert notes.read_text() == content


@pytest.mark.parametrize(
    ("name", "value", "color"), [("NO_COLOR", "1", False), ("NO_COLOR", "", None), ("TERM", "dumb", False)]
)
def test_a_terminal_that_wants_no_styles_gets_none(name, value, color, monkeypatch):
    styles = []
    monkeypatch.setattr("typer.secho", lambda _, **style: styles.append(style))
    for each, text in {"NO_COLOR": "", "TERM": "xterm", name: value}.items():
        monkeypatch.setenv(each, text)
    print_text("steel_ball", bold=True)
    assert styles == [{"color": color, "bold": True}]


def test_a_film_that_is_not_known_is_not_in_the_table_of_formulas():
    films = [Number(name, VARIABLES[name], 0.1, error=error) for name, error in (("H_c", 0.01), ("H_min", 0.09))]
    rows = film_rows(impact(1000.0, 10.0, 65), [], dict(zip(FILMS, films, strict=True)))
    assert rows[1] == ["computed", "0.1", "+-10.0%", "", ""]
