"""Runs that cannot be read, in the app and in `ertel ls`: each is a row that says so, and nothing else is disturbed."""

import asyncio
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest
from app_runs import CHILD, SUMMARY, is_alive, make_run, until, write_progress
from cases import ertel_

pytest.importorskip("nicegui")
from nicegui.testing import user_simulation

from ertel.apps.browser import pictures, server
from ertel.apps.browser.folder import Folder
from ertel.apps.browser.pictures import PlotRequest, Worker, stamp_of
from ertel.apps.browser.processes import Phase, Processes
from ertel.apps.browser.site import Site
from ertel.runs.files import sealed

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the app stops runs by SIGINT")


def written(content):
    return lambda path: path.write_bytes(content)


def cut(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def loop(path):
    path.unlink(missing_ok=True)
    path.symlink_to(path.name)


def pipe(path):
    path.unlink(missing_ok=True)
    os.mkfifo(path)


def folder(path):
    path.unlink(missing_ok=True)
    path.mkdir()


def huge(path):
    path.touch()
    os.truncate(path, 10**9)  # without taking space


def progress(**content):
    return lambda path: write_progress(path.parent, **content)


def sealed_summary(**changes):
    return written(sealed({**SUMMARY, **changes}))


ODD = {"loop": loop, "pipe": pipe, "folder": folder}  # in place of a file
CASES = {
    **ODD, "cut": written(b"[contact"), "huge": huge, "latin": written(b"name = '\xe9'"), "empty": written(b""),
    "type": written(b"contact = 5"), "deep": written(b"a=" + b"[" * 5000),
}  # fmt: skip
SUMMARIES = {
    **ODD, "cut": cut, "huge": huge, "latin": written(b"\xe9"), "list": written(b"[1]"), "number": written(b"5"),
    "deep": written(b"[" * 100_000), "nan": written(b'{"M": NaN, "checksum": "0"}'), "nothing": written(sealed({})),
    "status": sealed_summary(status=5), "kind": sealed_summary(kind=["x"]), "M": sealed_summary(M="x"),
    "warnings": sealed_summary(warnings=[5]), "H_min": sealed_summary(H_min=None),
}  # fmt: skip
PROGRESS = {
    **ODD, "list": written(b"[1]"), "latin": written(b"\xe9"), "deep": written(b"[" * 100_000), "huge": huge,
    "done": progress(done="x"), "nan": progress(done=float("nan")), "step": progress(step=None), "T": progress(T="x"),
    "process": progress(process=2**70), "left": progress(seconds_left=[]), "all": progress(process=-1),
    "killed": progress(),
}  # fmt: skip
FORMS = {f"case-{n}": ("case.toml", form) for n, form in CASES.items()}
FORMS |= {f"summary-{n}": ("summary.json", form) for n, form in SUMMARIES.items()}
HARMLESS = {f"progress-{n}": ("progress.json", form) for n, form in PROGRESS.items()}


@pytest.fixture(autouse=True)
def never_for_ever():
    """An error instead of a test that waits for a pipe."""

    def late(*_):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(200)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The app in a folder with one run of each form and some more that is odd."""
    place = tmp_path_factory.mktemp("folder")
    good = make_run(place / "good")
    for name, (file, form) in (FORMS | HARMLESS).items():
        (place / name / "run.zarr").mkdir(parents=True)
        for needed in ("case.toml", "summary.json")[: 2 if name in FORMS else 1]:
            shutil.copy(good / needed, place / name)
        form(place / name / file)
    (place / "loop").symlink_to("loop")
    (place / "a\udce9").mkdir()
    pipe(place / "pipe.toml"), loop(place / "loop.toml"), folder(place / "folder.toml")
    (place / "\udce9.toml").touch()
    return Site(Folder.at(place), Processes(Folder.at(place)), Worker(lambda: ThreadPoolExecutor(1)))


def test_a_run_that_cannot_be_read_is_a_row_that_says_so(site):
    odd = make_run(site.folder.root / "a\udce9" / "run\udce9")
    phases = {entry.name: entry.status.phase for entry in site.entries()}
    shutil.rmtree(odd)
    assert phases.pop("good") is Phase.FINISHED
    assert phases.pop("a\ufffd/run\ufffd") is Phase.DAMAGED
    assert {name for name, phase in phases.items() if phase is Phase.DAMAGED} == FORMS.keys()
    assert {name for name, phase in phases.items() if phase is Phase.INTERRUPTED} == HARMLESS.keys()
    assert site.folder.case_files() == []
    told = {run["directory"]: run["status"] for run in json.loads(ertel_("ls", str(site.folder.root), "--json").stdout)}
    assert {name for name, status in told.items() if status == "damaged"} == FORMS.keys()
    assert {name for name, status in told.items() if status == "unfinished"} == HARMLESS.keys()


@pytest.mark.asyncio
async def test_no_page_fails(site):
    damaged = ("case-pipe", "summary-M")
    async with user_simulation(root=server.root_of(site)) as user:
        for name in ("good", *damaged, "progress-pipe", "progress-process"):
            await user.open(f"/run?name={name}")
            await user.should_see(marker="phase")
            await user.should_not_see("500")
            if name in damaged:
                await user.should_see("cannot be read")
        for page in ("/", "/compare?a=case-pipe&b=summary-pipe", "/new?case=pipe.toml", "/run?name=loop"):
            await user.open(page)
            await user.should_see("summary-nan")  # in the list
            await user.should_not_see("500")


# -- data -------------------------------------------------------------------------------------------------------------


DATA = {
    "root-pipe": ("zarr.json", pipe), "root-cut": ("zarr.json", cut), "root-huge": ("zarr.json", huge),
    "root-list": ("zarr.json", written(b"[]")), "chunk-pipe": ("H/c/0/0", pipe), "chunk-cut": ("H/c/0/0", cut),
    "chunk-folder": ("H/c/0/0", folder), "chunk-loop": ("H/c/0/0", loop), "time-pipe": ("time/c/0", pipe),
}  # fmt: skip


@pytest.mark.parametrize("form", DATA)
def test_damaged_data_are_no_picture(tmp_path, form):
    run = make_run(tmp_path / "run")
    file, damage = DATA[form]
    damage(run / "run.zarr" / file)
    plots = Worker(lambda: ThreadPoolExecutor(1))
    with pytest.raises(ValueError, match="ertel show") as error:
        asyncio.run(plots.draw(PlotRequest(run, "overview", kind="svg", stamp=stamp_of(run))))
    assert type(error.value) is ValueError


# -- the process that draws -------------------------------------------------------------------------------------------


def test_who_asks_for_a_picture_that_is_being_drawn_waits_for_it(monkeypatch):
    """And a movie may take longer than a file that is read."""
    drawn = []
    monkeypatch.setattr(pictures, "LIMIT", 0.01)
    monkeypatch.setattr(pictures, "draw_picture", lambda request: (time.sleep(0.1), drawn.append(request))[0])

    async def asked():
        worker, movie = Worker(lambda: ThreadPoolExecutor(1)), PlotRequest(Path("a"), "film", choice="movie")
        await asyncio.gather(*(worker.draw(movie) for _ in range(3)))

    asyncio.run(asked())
    assert len(drawn) == 1


def test_what_takes_too_long_is_ended_and_the_next_is_drawn(monkeypatch):
    """As reading a pipe does; it is not tried again, so that others need not wait for it a second time."""

    async def asked():
        worker = Worker(lambda: ProcessPoolExecutor(1, get_context("spawn")))
        await worker.result_of(abs, -1)  # it has begun
        monkeypatch.setattr(pictures, "LIMIT", 1.0)
        for _ in range(2):
            with pytest.raises(ValueError, match="takes too long to read"):
                await worker.result_of(time.sleep, 100)
        monkeypatch.setattr(pictures, "LIMIT", 60.0)
        assert await worker.result_of(abs, -2) == 2
        with pytest.raises(ValueError, match="takes too long to read"):
            await worker.result_of(abs, 100)  # whatever else is asked about it
        worker._endless[frozenset({"slow"})] = time.monotonic() + 600.0
        slow = PlotRequest(Path("slow"), "film")
        for request in (slow, PlotRequest(Path("a"), "film", beside=slow)):
            with pytest.raises(ValueError, match="takes too long to read"):
                await worker.draw(request)
        worker.close()

    begin = time.monotonic()
    asyncio.run(asked())
    assert time.monotonic() - begin < 90.0


DRAWS = """
import sys, time
from concurrent.futures import wait
from ertel.apps.browser.pictures import Worker
worker = Worker()
wait([worker._executor.submit(int)])
print(*worker._executor._processes, flush=True)
time.sleep(60)
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are looked for in /proc")
def test_the_process_that_draws_ends_with_an_app_that_is_killed():
    with subprocess.Popen([sys.executable, "-c", DRAWS], stdout=subprocess.PIPE, text=True, env=CHILD) as app:
        drawing = int(app.stdout.readline())
        assert is_alive(drawing)
        app.kill()
    until(lambda: not is_alive(drawing))
