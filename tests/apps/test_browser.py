"""The app without its pages: its folder, its processes, its form, its pictures, and what it does not import."""

import asyncio
import os
import re
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from app_runs import CASE, make_run, until, write_progress
from cases import ertel_, python
from matplotlib.figure import Figure

from ertel.apps import browser
from ertel.apps.arguments import Measured
from ertel.apps.browser import form
from ertel.apps.browser.folder import Folder, Outside, study_of
from ertel.apps.browser.form import OPTIONS, Form
from ertel.apps.browser.pictures import PlotRequest, Worker, stamp_of
from ertel.apps.browser.processes import Phase, Processes
from ertel.inputs import oils
from ertel.inputs.case_files import ConfigError, load_case, parse_case, read_toml, to_toml
from ertel.inputs.quantities import parse_quantity
from ertel.physics.fluidity import Limited, ReeEyring
from ertel.physics.units import RADIUS, STRESS
from ertel.plots.drawing import Picture
from ertel.results.profiles import profile
from ertel.runs.directory import is_asked_to_stop
from ertel.runs.files import locked
from ertel.runs.store import RunStore

pytestmark = pytest.mark.skipif(os.name == "nt", reason="no locks")


# -- the folder -------------------------------------------------------------------------------------------------------


def test_nothing_outside_the_folder(tmp_path):
    inside = tmp_path / "mine"
    inside.mkdir()
    other = make_run(tmp_path / "other")
    (inside / "link").symlink_to(other)
    folder = Folder.at(inside)
    for name in ("../other", str(other), "link", "a/../../other", "\0"):
        with pytest.raises(Outside):
            folder.inside(name)
    (inside / "film.toml").write_text("[unknowns]")
    (inside / "fits").symlink_to(tmp_path)
    assert folder.runs() == folder.studies() == folder.case_files() == []
    for name in (".", "nothing", "x" * 5000):
        with pytest.raises(ValueError, match="is not a run"):
            folder.run(name)
    for place, message in ((tmp_path / "nothing", "is not a folder"), (other, "is a run; open the app in its folder")):
        with pytest.raises(ValueError, match=message):
            Folder.at(place)


@pytest.mark.parametrize(
    "named",
    [
        {"roughness": [{"shape": "measured", "file": "/etc/passwd"}]},
        {"lubricant": {"oil": "mine", "oils": "/etc/passwd", "temperature": "40 degC"}},
    ],
)
def test_files_of_a_case_outside_the_folder(tmp_path, named):
    with pytest.raises(Outside, match="/etc/passwd"):
        form.outlook_of({**CASE, **named}, Folder.at(tmp_path))


def test_a_new_case_takes_no_name_twice(tmp_path):
    (tmp_path / "runs" / "ball-2").mkdir(parents=True)
    files = [Folder.at(tmp_path).write("ball", b"text", "runs")[0].name for _ in range(2)]
    assert files == ["ball.toml", "ball-3.toml"]


# -- processes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [os.getpid(), 0, -1], ids=["ours", "none", "negative"])
def test_runs_of_other_programs_are_told_by_their_lock(tmp_path, monkeypatch, number):
    """A killed run leaves "running" behind; only the lock tells whether a process computes it.

    It is asked to stop by a file.  No process is signalled: the number may be that of another one by now, or one on
    another machine.  A file with a number that no process has counts as none.
    """
    run, processes = make_run(tmp_path / "run", finished=False), Processes(Folder.at(tmp_path))
    signalled = []
    monkeypatch.setattr(os, "kill", lambda *arguments: signalled.append(arguments))
    write_progress(run, process=number)
    assert processes.status(run).phase is Phase.INTERRUPTED
    with locked(run):
        assert processes.status(run).phase is (Phase.RUNNING if number > 0 else Phase.COMPILING)
        processes.stop(run)
        assert processes.status(run).phase is Phase.STOPPING
        assert is_asked_to_stop(run)
        with pytest.raises(ValueError, match="run: is asked to stop already"):
            processes.stop(run)
        write_progress(run, status="interrupted")
        (run / "stop").unlink()
        assert processes.status(run).phase is Phase.COMPILING
    assert processes.status(run).phase is Phase.INTERRUPTED
    with pytest.raises(ValueError, match="nothing to stop"):
        processes.stop(run)
    assert signalled == []


def test_a_run_that_does_not_hear_is_ended(tmp_path):
    """It was started here, so that its process is known: before it computes, and where it is asked again."""
    quiet = [sys.executable, "-c", "import time; time.sleep(30)"]
    processes = Processes(Folder.at(tmp_path), quiet)
    run = processes.start("ball", "text")
    assert processes.status(run).phase is Phase.COMPILING and processes.ours() == [run]
    processes.stop(run)
    until(lambda: not processes.ours(), 5)
    assert processes.status(run).phase is Phase.INTERRUPTED
    deaf = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(1, flush=True); time.sleep(30)"
    processes = Processes(Folder.at(tmp_path), [sys.executable, "-c", deaf])
    run = make_run(tmp_path / "deaf", finished=False)
    processes.resume(run)
    with locked(run):
        for _ in range(2):
            processes.stop(run)
            assert is_asked_to_stop(run)
        until(lambda: not processes.ours(), 5)
    assert processes.status(run).phase is Phase.INTERRUPTED


def test_runs_and_studies_are_deleted_whole_and_never_while_they_run(tmp_path):
    folder = Folder.at(tmp_path)
    processes, study = Processes(folder), tmp_path / "speeds"
    runs = [make_run(study / "runs" / name) for name in ("0123456789abcdef", "fedcba9876543210")]
    alone = make_run(tmp_path / "runs" / "0123456789abcdef")
    assert [study_of(run, folder.root) for run in (*runs, alone)] == [study, study, None]
    assert study_of(make_run(tmp_path / "sub" / "runs" / "ball"), folder.root) is None
    for place in (runs[1], study):
        with locked(place), pytest.raises(ValueError, match=f"{folder.name_of(place)}: is running; stop it"):
            processes.delete(place)
    with locked(runs[1]), pytest.raises(ValueError, match="speeds: is running"):
        processes.delete(study)
    for file in ("sweep.csv", "convergence.csv", "notes.txt"):
        (study / file).touch()
    with pytest.raises(ValueError, match=r"speeds: holds other files \(notes.txt\)"):
        processes.delete(study)
    (study / "notes.txt").unlink()
    drawn = study / "runs" / runs[0].name / "plots"
    drawn.mkdir()
    Picture().savefig(drawn / "film.png")
    Figure().savefig(drawn / "pressure.png")
    with pytest.raises(ValueError, match=rf"holds other files \(runs/{runs[0].name}/plots/pressure.png\)"):
        processes.delete(study)
    (drawn / "pressure.png").unlink()
    own = (f"runs/{runs[0].name}/{name}" for name in ("plots/a.png", "plots/a.csv", "export/a.csv", "export/run.csv"))
    mine = (".env", ".git/HEAD", "fit.ipynb", "traction.xlsx", "runs/a.csv", "runs/mine/film.png", "sweep.zarr/a.py")
    for file in (*own, *mine, f"runs/{runs[0].name}/notes.txt", f"runs/{runs[0].name}/run.zarr/c/a"):
        (study / file).parent.mkdir(parents=True, exist_ok=True)
        (study / file).touch()
        with pytest.raises(ValueError, match=rf"speeds: holds other files \({file}\); move them away first"):
            processes.delete(study)
        (study / file).unlink()
    (study / "sweep.csv").unlink()
    (study / "sweep.csv").symlink_to(tmp_path)
    processes.delete(runs[0])
    assert not runs[0].exists() and runs[1].exists()
    processes.delete(study)
    processes.delete(alone)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["runs", "sub"]


# -- the form ---------------------------------------------------------------------------------------------------------


def chosen(**choices):
    """The form after some choices, one after the other; of a path without its dots."""
    form = Form()
    for name, value in choices.items():
        form.choose(name.replace("__", "."), value)
    return form


@pytest.mark.parametrize("kind", ["impact", "rolling"])
@pytest.mark.parametrize(
    "choices",
    [
        {"given": "moes"},
        *({"bodies": bodies} for bodies in OPTIONS["bodies"]),
        {"impact_by": "by-height"},
        {"roughness__shape": "waviness", "roughness__wavelength_x": "", "roughness__wavelength_y": "50 um"},
        {"roughness__shape": "self-affine", "roughness__surface": "2", "contact__slide_to_roll": "2"},
        {"thermal": "warm", "lubricant__oil": "squalane"},
        {"lubricant__oil": "sheet"},
        {"surfaces__asperities__law": "greenwood-tripp", "surfaces__sigma": "40 nm"},
    ],
)
def test_the_form_begins_with_a_case(kind, choices):
    """Whatever is chosen; a method that the other kind does not have goes with the kind."""
    case = parse_case(chosen(**choices, contact__kind=kind).data())
    assert case.kind == kind
    assert case.contact.ratio == {"ellipse": 0.25}.get(choices.get("bodies"), case.contact.ratio)
    assert len(case.roughness) == ("roughness__shape" in choices)
    assert (case.thermal is not None) == (kind == "rolling" and "thermal" in choices)
    assert (case.contact.drop_height is not None) == (kind == "impact" and "impact_by" in choices)


def test_laws_and_data_sheets_are_fields():
    law = {"lubricant__rheology__law": "limited", "lubricant__rheology__base__law": "ree-eyring"}
    form = chosen(contact__kind="rolling", lubricant__oil="sheet", **law)
    assert "lubricant.rheology.base.tau0" in form.shown()
    assert "at 40 degC" in form.shown()["lubricant.oil.nu40"].label
    found = parse_case(form.data()).oil
    sheet = {key: form.values[f"lubricant.oil.{key}"] for key in ("nu40", "nu100", "density")}
    assert found.eta0 == oils.data_sheet(**sheet, temperature=form.values["lubricant.temperature"]).eta0
    assert found.rheology == Limited(ReeEyring(5e6), 0.05)


@pytest.mark.parametrize("file", sorted((Path(__file__).parents[2] / "examples").glob("*.toml")), ids=lambda f: f.stem)
def test_the_form_shows_a_case_that_is_there(file):
    """As it is written, and as a run directory has it; the fields make the very same case."""
    case = load_case(file)
    for data in (read_toml(file), tomllib.loads(to_toml(case))):
        form = Form.of(data)
        assert parse_case(form.data(), file.parent).digest == case.digest
        if file.stem == "squalane":
            assert form.values["contact.radius"] == "9.525 mm"  # in a run directory 0.009525 m


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({**CASE, "roughness": [{"shape": "spot"}, {"shape": "spot"}]}, "no field for roughness"),
        ({"contact": 3}, "no field for contact"),
        ({"contact": {"kind": "slide"}}, "needs a kind of contact"),
        ({"solver": {"method": "guess"}}, "and a method that there are"),
    ],
)
def test_what_has_no_fields_stays_a_text(data, message):
    with pytest.raises(ValueError, match=message):
        Form.of(data)


@pytest.mark.parametrize(
    ("choices", "field"),
    [
        ({"contact__radius": "10 furlong"}, "contact.radius"),
        ({"bodies": "ellipse", "contact__radius_y": "-1 mm"}, "contact.radius_y"),
        ({"impact_by": "by-height", "contact__drop_height": "1"}, "contact.drop_height"),
        ({"roughness__shape": "spot", "roughness__depth": "deep"}, "roughness.depth"),
        ({"contact__kind": "rolling", "thermal": "warm"}, "thermal.temperature"),
        ({"contact__kind": "rolling", "roughness__shape": "spot"}, "roughness.surface"),
        ({"lubricant__oil": "sheet", "lubricant__oil__nu40": "68 mm"}, "lubricant.oil.nu40"),
    ],
)
def test_messages_name_their_field(choices, field):
    form = chosen(**choices)
    with pytest.raises(ConfigError) as error:
        parse_case(form.data())
    assert form.field_of(str(error.value)) == field


def test_each_key_of_the_form_has_the_help_of_the_command():
    told = " ".join(ertel_("run", "--help-keys").stdout.split())
    form = chosen(contact__kind="rolling", thermal="warm", roughness__shape="spot", given="moes")
    for name, field in {**form.shown(), **Form().shown()}.items():
        assert (field.key is None) == (name in ("given", "bodies", "impact_by"))
        assert field.label and (field.key is None or field.key.meaning.text in told)
    assert form.hint("lubricant.layer_1") == "" and Form().hint("lubricant.layer_1") == "such as 1 um"
    assert form.hint("roughness.x") == "0.0"


# -- the command ------------------------------------------------------------------------------------------------------


def test_the_command_without_the_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "nicegui", None)
    monkeypatch.delitem(sys.modules, "ertel.apps.browser.server", raising=False)
    monkeypatch.delattr(browser, "server", raising=False)
    monkeypatch.delitem(sys.modules, "requests", raising=False)
    assert "pip install 'ertel[app]'" in ertel_("app", code=2).stderr
    assert sys.modules.get("requests", "not imported")  # and not None: who reads measured surfaces imports it


# -- pictures ---------------------------------------------------------------------------------------------------------


@pytest.fixture
def plots():
    """Draws in this process."""
    found = Worker(lambda: ThreadPoolExecutor(1))
    yield found
    found.close()


UNITS = {"x": RADIUS, "y": RADIUS, "h": RADIUS, "p": STRESS}  # with a sign


def test_readout_of_a_picture(tmp_path, plots):
    """Film and pressure of the run at the place that a map shows, also where equal scales make the map wider."""
    run = make_run(tmp_path / "run")
    data, stamp = RunStore.open(run).dataset(), stamp_of(run)
    request = PlotRequest(run, "maps", "max-approach", dots=20, stamp=stamp)
    for figure in ("maps", "film"):
        beside = PlotRequest(run, figure, 0.05, stamp=stamp) if figure == "film" else None
        found = asyncio.run(plots.draw(replace(request, figure=figure, beside=beside))).readout
        assert len(found.boxes) == (2 if figure == "maps" else 1)
        assert found.at(-1.0, -1.0) == ""  # beside the maps
        (left, right, low, high), edges = found.boxes[-1]
        x, y = edges[0] + 0.7 * (edges[1] - edges[0]), edges[2] + 0.4 * (edges[3] - edges[2])
        at = data.isel(frame=8).interp(r=np.hypot(x, y) / data["r"].si_factor)
        film, pressure = (float(at[name]) * data[name].si_factor for name in ("H", "P"))
        told = found.at(left + 0.7 * (right - left), 1.0 - low - 0.4 * (high - low))
        read = {name: parse_quantity(value, UNITS[name]) for name, value in re.findall("(.) = ([^,]+)", told)}
        assert read == pytest.approx({"x": x, "y": y, "h": film, "p": pressure}, rel=5e-3)


def test_a_measurement_beside_a_run(tmp_path, plots):
    run, file = make_run(tmp_path / "run"), tmp_path / "film.csv"
    film = profile(RunStore.open(run).dataset(), "max-approach")
    np.savetxt(file, np.transpose([film["x"] * 1e6, film["h"] * 1e9]), header="x_um h_nm", comments="")
    request = PlotRequest(run, "measured", dots=20, stamp=1, measured=(file, "x", Measured(at="max-approach")))
    found = asyncio.run(plots.draw(request))
    assert found.content[:4] == b"\x89PNG" and found.readout is None
    assert re.search(r"film.csv: .*maximum approach.*: rms difference \S+ .m \(0.0% of the mean\)", found.words)
    wrong = replace(request, measured=(file, "x", Measured(column=("x=Radius",))))
    with pytest.raises(ValueError, match=r"film.csv: column 'x' in 'Radius': has an unknown unit"):
        asyncio.run(plots.draw(wrong))


def test_errors_are_plain(tmp_path, plots):
    """An error that matplotlib's company knows would bring matplotlib into the web process."""
    run = make_run(tmp_path / "run")
    with pytest.raises(ValueError, match="has no such figure") as error:
        asyncio.run(plots.draw(PlotRequest(run, "midlines", stamp=stamp_of(run))))
    assert type(error.value) is ValueError and error.value.__context__ is None
    with pytest.raises(ValueError, match="nothing is written yet"):
        asyncio.run(plots.info(tmp_path))


LIGHT = """
import sys
from pathlib import Path
from ertel.apps.browser import server
from ertel.apps.browser.folder import Folder, summary_of
from ertel.apps.browser.form import Form, outlook_of
from ertel.apps.browser.pictures import PlotRequest, draw_picture, run_info, stamp_of
from ertel.apps.browser.processes import Processes
from ertel.results.numbers import key_numbers

folder = Folder.at(Path(sys.argv[1]))
(run,) = folder.runs()
key_numbers(summary_of(run))
Processes(folder).status(run)
heavy = "jax", "matplotlib", "xarray", "zarr", "pandas", "scipy", "pint"
print([name for name in heavy if name in sys.modules])
run_info(run, stamp_of(run))
outlook_of(Form().data(), folder)
draw_picture(PlotRequest(run, "maps", "max-approach", dots=20, stamp=stamp_of(run)))
print([name for name in ("jax", "scipy.optimize", "scipy.interpolate") if name in sys.modules])
"""


def test_neither_process_of_the_app_imports_jax(tmp_path):
    """The web process imports nothing else that is heavy; the other one not what maps do without."""
    make_run(tmp_path / "run")
    assert python("-c", LIGHT, str(tmp_path)).stdout.splitlines()[-2:] == ["[]", "[]"]
