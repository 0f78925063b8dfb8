"""What the tests of the programs share: a directory with cases, two runs that have ended, and the app for one user.

Nothing of ertel is imported at the top: pytest reads this file before JAX is set up where it is given the folder alone.
"""

import asyncio
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest
import pytest_asyncio


@pytest.fixture(autouse=True)
def _no_garbage_is_looked_for(monkeypatch):
    """NiceGUI's simulated user looks twice for it, in all that other tests have left: half of the time of a page."""
    if simulation := sys.modules.get("nicegui.testing.general"):
        monkeypatch.setattr(simulation, "gc", SimpleNamespace(collect=lambda: 0))


@pytest.fixture
def here(tmp_path, monkeypatch):
    from app_runs import CASE_FILES

    monkeypatch.chdir(tmp_path)
    for name, text in CASE_FILES.items():
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.fixture(scope="session")
def runs(tmp_path_factory):
    """Finished runs and what they printed: small, to maximum approach, and ball, six steps in SI."""
    from app_runs import CASE_FILES
    from cases import ertel_

    directory, printed = tmp_path_factory.mktemp("runs"), {}
    for name in ("small", "ball"):
        (directory / f"{name}.toml").write_text(CASE_FILES[f"{name}.toml"])
        printed[name] = ertel_("run", str(directory / f"{name}.toml"), "--out", str(directory / name)).stdout
    return directory, printed


@pytest.fixture
def ball(here, runs):
    """A copy of the ball's run in the working directory, under a name that a shell must quote."""
    return shutil.copytree(runs[0] / "ball", here / "my run")


@pytest.fixture
def site(tmp_path, monkeypatch):
    """The app in a folder with one run; ertel run and pictures are stand-ins; all goes faster than for users."""
    pytest.importorskip("nicegui")
    from app_runs import make_run, stand_in
    from nicegui import ui

    from ertel.apps.browser import new_page, pictures
    from ertel.apps.browser.folder import Folder
    from ertel.apps.browser.processes import Processes
    from ertel.apps.browser.site import Site

    def stand_in_picture(request):
        beside = f" beside {request.beside.run.name}" if request.beside else ""
        content = f"{request.kind} {request.figure} at {request.at}{beside}"
        readout = SimpleNamespace(at=lambda across, down: "nothing is under the pointer")
        return pictures.Picture(content.encode(), None if beside else readout)

    timer = ui.timer
    monkeypatch.setattr(ui, "timer", lambda seconds, *more, **options: timer(seconds / 10, *more, **options))
    monkeypatch.setattr(new_page, "PAUSE", 0.02)
    monkeypatch.setattr(pictures, "draw_picture", stand_in_picture)
    make_run(tmp_path / "folder" / "runs" / "ball")
    (tmp_path / "aside").mkdir()
    folder = Folder.at(tmp_path / "folder")
    processes = Processes(folder, stand_in(tmp_path / "aside"))
    return Site(folder, processes, pictures.Worker(lambda: ThreadPoolExecutor(1)))


@pytest_asyncio.fixture
async def user(site):
    """Someone who looks at the app."""
    from nicegui import background_tasks
    from nicegui.testing import user_simulation

    from ertel.apps.browser import server

    async with user_simulation(root=server.root_of(site)) as found:
        site.serve_pictures()
        yield found
        for _ in range(3):  # one that loads a page outlives the first time, and the end would wait two seconds for it
            for task in list(background_tasks.running_tasks):
                task.cancel()
            await asyncio.sleep(0.01)
