"""The app for one user, as fixtures: a folder with a run, and NiceGUI's simulated user who looks at it."""

import asyncio
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest
import pytest_asyncio
from app_runs import make_run, stand_in


@pytest.fixture
def site(tmp_path, monkeypatch):
    """The app in a folder with one run; ertel run and pictures are stand-ins; all goes faster than for users."""
    pytest.importorskip("nicegui")
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
