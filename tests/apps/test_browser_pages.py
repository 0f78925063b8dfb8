"""The pages of the app without a browser: NiceGUI's simulated user, on a made-up run and a process that stands in."""

import json
import os
import re
from html.parser import HTMLParser

import pytest

pytest.importorskip("nicegui")
from app_runs import SUMMARY, all_of, make_fit, make_run, one, shown
from nicegui import app, ui

from ertel.apps.arguments import Measured
from ertel.apps.browser import new_page, pictures
from ertel.apps.browser.processes import Phase
from ertel.apps.browser.site import address_of
from ertel.case.rules import plain_name
from ertel.results.study_table import StudyRun, study_dataset
from ertel.runs.directory import CASE
from ertel.runs.files import sealed

pytest_plugins = "app_user"
pytestmark = [pytest.mark.asyncio, pytest.mark.skipif(os.name == "nt", reason="no locks")]


async def picture(user, before=""):
    """The address of the picture on the page, once it is another one than before, and what the server answers."""
    await shown(lambda: one(user, "picture").props.get("src", before) != before)
    address = one(user, "picture").props["src"]
    return address, await user.http_client.get(address)


async def test_the_first_page_lists_the_runs_and_a_page_of_no_run_says_so(user):
    for page, text in (
        ("/", "finished · impact, M 1000, L 10"),
        ("/run?name=../../etc", "lies outside"),
        ("/run?name=runs/nothing", "runs/nothing is not a run"),
    ):
        await user.open(page)
        await user.should_see(text)


async def test_bad_input_is_answered_in_the_words_of_ertel(user):
    await user.open("/new")
    await shown(lambda: one(user, "run").enabled)
    one(user, "contact.speed").set_value("10 m/s")
    await user.should_see("steel of the hardness", retries=50)  # a warning
    one(user, "contact.radius").set_value("10 furlong")
    await user.should_see('contact.radius = "10 furlong"', retries=50)
    field = one(user, "contact.radius")
    assert field.props["error"] and field.props["error-message"] == "must be between 1e-06 and 100 m"
    assert not one(user, "run").enabled
    one(user, "contact.radius").set_value("12 mm")
    await user.should_see(marker="ready", retries=50)
    assert not one(user, "contact.radius").props["error"]


async def test_a_case_is_run_stopped_and_resumed(user, site):
    await user.open("/new")
    await shown(lambda: one(user, "run").enabled)
    one(user, "name").set_value("mine")
    user.find(marker="run").click()
    run = site.folder.root / "runs" / "mine"
    await shown(run.exists)
    await user.should_see("mine")
    assert 'radius = "10 mm"' in (site.folder.root / "mine.toml").read_text()
    await shown(lambda: one(user, "phase").text == "running")
    status = site.processes.status(run)
    process = status.progress["process"]  # Ctrl-C in the terminal of the app is none of its business
    assert os.getsid(process) == process != os.getsid(0)
    assert status.done == 0.4 and site.processes.ours() == [run]
    with pytest.raises(ValueError, match="nothing to resume"):
        site.processes.resume(run)
    user.find(marker="stop").click()
    await shown(lambda: one(user, "phase").text == "interrupted")
    await user.should_see("it can be resumed")
    with pytest.raises(ValueError, match="nothing to stop"):
        site.processes.stop(run)
    user.find(marker="start").click()
    await shown(lambda: one(user, "phase").text == "finished")
    assert site.processes.ours() == []
    await user.should_see("coefficient of restitution")
    os.utime(run / "run.zarr" / "zarr.json")  # the last maps are written
    await shown(lambda: one(user, "slider").value == 8)  # the page has followed the run: to maximum approach


async def test_a_page_of_a_run(user, site):
    """The slider chooses the map, interferograms have a light, and all can be had as files."""
    await user.open("/run?name=runs/ball")
    first, _ = await picture(user)
    await user.should_see("nothing is under the pointer")
    slider = one(user, "slider")
    assert (slider.value, slider.props["max"]) == (8, 12)  # begins at maximum approach
    user.find(marker="download-case").click()
    case = await user.download.next()
    assert case.text == (site.folder.root / "runs" / "ball" / CASE).read_text()
    user.find(marker="download-pdf").click()
    assert (await user.download.next()).content == b"pdf maps at max-approach"
    slider.set_value(5)
    await user.should_see("T = 1.550")
    second, answer = await picture(user, first)
    assert answer.text == "png maps at 1.55"
    assert (await user.http_client.get("/pictures/unknown")).status_code == 404
    await user.should_not_see(marker="choice-interferogram")
    user.find(ui.tabs).elements.pop().set_value("interferogram")
    await user.should_see(marker="choice-interferogram")
    third, _ = await picture(user, second)
    one(user, "choice-interferogram").set_value("movie white")
    _, movie = await picture(user, third)
    assert movie.text == "webp interferogram at None" and movie.headers["content-type"] == "image/webp"


async def test_a_run_is_deleted_after_a_question(user, site):
    run, other = (site.folder.root / "runs" / name for name in ("ball", "other"))
    make_run(other)
    await user.open("/run?name=runs/ball")
    await user.should_see("finished")
    user.find(marker="delete").click()
    await user.should_see("Delete runs/ball?")
    user.find("Cancel").click()
    assert run.exists()
    user.find(marker="delete").click()
    await shown(lambda: all_of(user, "delete-it"))
    user.find(marker="delete-it").click()
    await user.should_see("Impact and rolling of lubricated point and line contacts", retries=50)  # the page has ended
    assert not run.exists() and site.folder.runs() == [other]
    key = re.search('data-run="([0-9a-f]+)"', one(user, "runs").content)[1]
    user.find(marker="runs").trigger("click", key)
    await user.should_see("Delete runs/other?")
    user.find("Cancel").click()
    assert other.exists()


async def test_a_fit_is_started_stopped_and_goes_on_to_its_values(user, site, tmp_path):
    root, fit = site.folder.root, site.folder.root / "fits" / "film"
    make_fit(root, tmp_path / "aside" / "fit")
    await user.open("/")
    await user.should_see("not started · fit")
    await user.open("/study?name=fits/film")
    assert "[[measurements]]" in one(user, "listing").text and one(user, "phase").text == "not started"
    user.find(marker="start").click()
    await shown(lambda: one(user, "phase").text == "running")
    await user.should_see("point 2 of the search")
    user.find(marker="stop").click()
    await shown(lambda: one(user, "phase").text == "interrupted")
    await user.should_not_see(marker="outcome")
    user.find(marker="start").click()
    await shown(lambda: all_of(user, "outcome"))
    assert one(user, "phase").text == "finished"
    outcome = one(user, "outcome").content
    for text in ("<td>97.6 mPa*s</td>", "<td>alpha</td>", "fix alpha*eta0", "3 data, chi square", "hardly decided"):
        assert text in outcome
    assert float(re.findall(r"<td>(-?[0-9.]+)</td>", outcome)[1]) < -0.99  # the correlation of eta0 with alpha
    _, answer = await picture(user)
    assert answer.text == "png study at None"
    await shown(lambda: "finished · fit of eta0, alpha" in one(user, "runs").content)
    assert site.folder.run("fits/film/runs/0123456789abcdef") not in site.folder.runs()  # it is that of the fit
    (fit / "fit.zarr" / "zarr.json").write_text("{")
    await user.open("/study?name=fits/film")
    await user.should_see("The outcome of this study cannot be read", retries=50)
    site.processes.delete(fit)
    assert not fit.exists() and site.processes.status(fit).phase is Phase.NEW


async def test_a_study_is_one_row_and_its_rows_are_links_unless_their_run_was_deleted(user, site):
    study = site.folder.root / "sweeps" / "speeds"
    runs = [StudyRun({}, [], "converged", f"runs/{name}") for name in ("0123456789abcdef", "fedcba9876543210")]
    speeds = {"mean_speed": ([0.2, 0.4], {"units": "m/s", "long_name": "mean speed"})}
    make_run(study / runs[0].directory)
    data = study_dataset("product", speeds, runs, {"title": "speeds", "kind": "rolling"})
    data.to_zarr(study / "sweep.zarr", consolidated=False)
    (study / "sweep.csv").write_text("status\nconverged\nconverged\n")
    await user.open("/study?name=sweeps/speeds")
    await shown(lambda: all_of(user, "outcome"))
    address = address_of("/run", name=f"sweeps/speeds/{runs[0].directory}")
    first, second = re.findall("<tr><td>.*?</tr>", one(user, "outcome").content)
    assert f'<td><a href="{address}">0.2</a></td>' in first and f'<a href="{address}">runs/01234567</a>' in first
    assert "<a" not in second and second.endswith("<td>deleted</td></tr>")
    listed = one(user, "runs").content
    assert "finished · study over mean_speed" in listed and runs[0].directory not in listed
    assert listed.index(">ball<") < listed.index(">speeds<")
    await user.open(address)
    await user.should_see("A run of sweeps/speeds")


async def test_a_traction_curve_is_started_from_a_steady_run(user, site):
    steady = {**SUMMARY, "kind": "rolling", "method": "steady", "warnings": [], "restitution": None}
    (site.folder.root / "runs" / "ball" / "summary.json").write_bytes(sealed(steady))
    await user.open("/run?name=runs/ball")
    user.find(marker="traction").click()
    await shown(lambda: all_of(user, "ratios"))
    one(user, "ratios").set_value("--out")
    user.find(marker="start-curve").click()
    curve = site.folder.root / "traction" / "ball"
    await shown(lambda: all_of(user, "phase") and one(user, "phase").text == "running")
    *_, asked, _, place = site.processes._started[curve].arguments
    assert (asked, place) == ("--slide-to-roll=--out", str(curve))
    assert [run.name for run in site.processes.ours()] == ["ball"]
    assert [entry.path for entry in site.entries()] != [curve]
    user.find(marker="stop").click()
    await shown(lambda: not site.processes.ours())


async def test_a_fit_of_files_outside_is_not_started(user, site, tmp_path):
    make_fit(site.folder.root, tmp_path / "aside" / "fit")
    file = site.folder.root / "film.toml"
    file.write_text(file.read_text().replace("film.csv", "../film.csv"))
    await user.open("/study?name=fits/film")
    user.find(marker="start").click()
    await user.should_see("../film.csv: lies outside")
    assert site.processes.ours() == []
    await user.open("/study?name=fits/ball")
    await user.should_see("fits/ball is not a study")


async def test_a_file_is_added_and_nothing_is_overwritten(user, site):
    """The page of a fit, a study or a case follows; what is too long, or not TOML, is not written."""
    root = site.folder.root
    for name, text, page in (
        ("film.toml", "[unknowns]\n", "fits/film"),
        ("film.toml", "[unknowns]\n[measurements]\n", "fits/film-2"),
        ("../speeds.toml", "[sweep]\n", "sweeps/_speeds"),
    ):
        await user.open("/")
        user.find(marker="upload").trigger("change", [name, text])
        await shown(lambda text=text: text in {listing.text for listing in all_of(user, "listing")})
        assert root / page in site.folder.studies()
    assert (root / "film.toml").read_text() == "[unknowns]\n"
    before = sorted(root.iterdir())
    for name, text, message in (
        ("long.toml", "#" * (new_page.LARGEST_UPLOAD + 1), "long.toml: must be a text of at most 200 kB"),
        ("long.toml", None, "long.toml: must be a text of at most 200 kB"),
        ("odd.toml", "[sweep", "odd.toml is not valid TOML"),
        ("film.csv", "PK\3\4", "film.csv: is not a text; export it as one, such as CSV"),
        ("film.html", "x,h", "film.html: must be a case, a study or a fit, .toml, or columns, .csv, .txt"),
    ):
        await user.open("/")
        user.find(marker="upload").trigger("change", [name, text])
        await user.should_see(message)
    assert sorted(root.iterdir()) == before


async def test_what_was_measured_is_added_and_compared(user, site, monkeypatch):
    """A file as an instrument wrote it; what is known of it goes to the process that draws."""
    asked = []
    drawn = pictures.Picture(b"", None, "rms difference 0")
    monkeypatch.setattr(pictures, "draw_picture", lambda request: asked.append(request) or drawn)
    content = "x (um);h (nm)\n0;100\n".encode("utf-16")
    await user.open("/")
    user.find(marker="upload").trigger("change", ["../.film.CSV", content.decode("latin-1")])
    await shown(lambda: all_of(user, "readout") and one(user, "readout").text == "rms difference 0")
    (file,) = site.folder.measurements()
    assert file.name == "_.film.csv" and file.read_bytes() == content
    one(user, "given-column").set_value("x=Radius [um]; h=nm")
    one(user, "given-at").set_value("60 us")
    given = Measured(at="60 us", column=("x=Radius [um]", "h=nm"))
    await shown(lambda: asked[-1].measured == (file, "x", given))
    assert asked[-1].run == site.folder.root / "runs" / "ball"
    one(user, "given-index").set_value("1,48")
    await user.should_see("index = '1,48': must be a number")
    count = len(asked)
    await user.open("/measured?file=../../etc/passwd&run=../../etc")
    await user.should_see("is not a file of columns (CSV) in this folder")
    await user.should_see("lies outside")
    assert one(user, "file").value == file.name and len(asked) == count


async def test_two_runs_are_compared_at_one_time(user, site):
    make_run(site.folder.root / "runs" / "other")

    def at_its_time(address):  # the first side is drawn before the second one is read, at no time
        return address in site.worker.kept and b"at None" not in site.worker.kept[address].content

    await user.open("/compare?a=runs/ball&b=runs/other")
    both = all_of(user, "picture")
    await shown(lambda: all(at_its_time(each.props.get("src")) for each in both))
    assert one(user, "slider").value == 8  # at maximum approach
    before = [each.props["src"] for each in both]
    texts = [(await user.http_client.get(address)).text for address in before]
    assert texts == ["png film at 2.45 beside other", "png film at 2.45 beside ball"]
    one(user, "slider").set_value(3)
    await shown(lambda: not {*before} & {each.props["src"] for each in both})


async def test_closing_the_app_can_stop_its_runs(user, site, monkeypatch):
    """It says which runs go on, and leaves them alone unless it is told to stop them."""
    closed = []
    monkeypatch.setattr(app, "shutdown", lambda: closed.append(True))
    run = site.processes.start("mine", "text")
    await shown(lambda: site.processes.status(run).phase is Phase.RUNNING)
    await user.open("/")
    user.find(marker="close").click()
    await user.should_see("Still running: runs/mine.")
    user.find("Stop the runs and close").click()
    await shown(lambda: closed)
    await shown(lambda: site.processes.status(run).phase is Phase.INTERRUPTED)


# -- names ------------------------------------------------------------------------------------------------------------

NAMES = (
    'x" onfocus="alert(1)" autofocus="',
    "x' onfocus='alert(1)' y='",
    "<img src=x onerror=alert(1)>",
    "`${alert(1)}`",
    "</script><script>alert(1)</script>",
    "{{ 1 }} :x=[alert(1)]",
)
IN_FILES = [name.replace("/", "|") for name in NAMES]


class Rows(HTMLParser):
    """The tags, the names of attributes, the texts and the hints of the list, as a browser reads it."""

    def __init__(self):
        super().__init__()
        self.tags, self.names, self.texts = set(), set(), set()

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        self.names |= {name for name, _ in attributes}
        self.texts |= {value for name, value in attributes if name == "title"}

    def handle_data(self, data):
        self.texts.add(data)


def properties(user):
    return {name for element in user.client.elements.values() for name in element._to_dict().get("props", {})}


async def test_the_name_of_a_case_and_a_message_are_text(user, site):
    case = (site.folder.root / "runs" / "ball" / CASE).read_text()
    await user.open("/new")
    await shown(lambda: one(user, "run").enabled)
    usual = properties(user)
    for name in NAMES:
        (site.folder.root / "odd.toml").write_text(f"name = {json.dumps(plain_name(name))}\n{case}")
        await user.open("/new?case=odd.toml")
        user.find(ui.tabs).elements.pop().set_value("text")
        await shown(lambda: one(user, "run").enabled)
        assert one(user, "name").props["placeholder"] == plain_name(name)
        assert properties(user) <= usual
        given = json.dumps(name)
        one(user, "text").set_value(f"{case.partition('[lubricant]')[0]}[lubricant]\noil = {given}\n")
        await shown(lambda given=given: any(given in fault.text for fault in all_of(user, "fault")))
        assert properties(user) <= usual


async def test_the_names_of_files_and_directories_are_text(user, site):
    """Those of a case file, of a run, and of the study that has it."""
    make_run(site.folder.root / "other")
    (site.folder.root / "other.toml").touch()
    pages = {"/": set(), address_of("/run", name="other"): set(), address_of("/compare", a="other"): set()}
    for page in pages:
        await user.open(page)
        pages[page] = properties(user)
    runs = [f"{name}/{name}" for name in IN_FILES]
    for name, run in zip(IN_FILES, runs, strict=True):
        (site.folder.root / f"{name}.toml").touch()
        make_run(site.folder.root / run)
        pages[address_of("/run", name=run)] = pages[address_of("/run", name="other")]
    for page, usual in pages.items():
        html = (await user.http_client.get(page)).text
        assert not any(text in html for text in ("<img src=x", "`${alert", "<script>alert"))
        await user.open(page)
        rows = Rows()
        rows.feed(one(user, "runs").content)
        assert {*IN_FILES, *runs} <= rows.texts  # with its hints
        assert rows.tags == {"div", "a", "i", "button"}
        assert rows.names == {"class", "href", "title", "aria-hidden", "type", "data-run", "aria-label"}
        assert properties(user) <= usual
