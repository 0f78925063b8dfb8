"""Open the app: the server on loopback, and the pages."""

import socket
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import app, ui

from ertel.apps.browser.compare_page import compare_page
from ertel.apps.browser.folder import Folder
from ertel.apps.browser.guard import LOOPBACK, Guard
from ertel.apps.browser.home_page import home_page
from ertel.apps.browser.new_page import new_page
from ertel.apps.browser.pictures import Artist
from ertel.apps.browser.processes import Processes
from ertel.apps.browser.run_page import run_page
from ertel.apps.browser.site import LOGO, Site, frame

PAGES: dict[str, Callable[..., Any]] = {"/": home_page, "/new": new_page, "/run": run_page, "/compare": compare_page}
ICON = (
    LOGO.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ')
    .replace("<circle", '<g fill="none" stroke="#0b5673" stroke-width="3"><circle')
    .replace("</svg>", "</g></svg>")
)


def root_of(site: Site) -> Callable[[], None]:
    """What builds a page of the app."""
    return partial(frame, site, PAGES)


def is_free(port: int) -> bool:
    """Whether a server can listen on a port of this machine."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((LOOPBACK, port))
        except OSError:
            return False
    return True


def serve(folder: Path, port: int, show: bool, ready: Callable[[], None]) -> list[str]:
    """Serve the app until it is closed; the names of the runs that go on.  ready: called when it answers.

    Raises ValueError where the folder is none.
    """
    site = Site(Folder.at(folder), Processes(Folder.at(folder)), Artist())
    site.serve()
    app.on_startup(site.artist.begin)
    app.on_shutdown(site.artist.close)
    app.on_startup(ready)
    app.add_middleware(Guard, port=port)
    with suppress(KeyboardInterrupt):  # by which the server hands on a signal that ended it
        ui.run(
            root_of(site),
            host=LOOPBACK,
            port=port,
            title="ertel",
            favicon=ICON,
            show=show,
            reload=False,
            tailwind=False,
            show_welcome_message=False,
            reconnect_timeout=30.0,
            message_history_length=200,
        )
    return [site.folder.name_of(run) for run in site.processes.ours()]
