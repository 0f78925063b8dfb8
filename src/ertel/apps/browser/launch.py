"""Open the app: the server on loopback, and the pages."""

import os
import socket
import time
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from secrets import token_urlsafe
from tempfile import NamedTemporaryFile
from threading import Thread
from typing import Any

from nicegui import app, helpers, ui

from ertel.apps.browser.compare_page import compare_page
from ertel.apps.browser.folder import Folder
from ertel.apps.browser.guard import LOOPBACK, Guard, address_with
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


@contextmanager
def doorway(folder: Path, address: str) -> Iterator[Path]:
    """A page that leads to an address, in a file that only its user can read.

    The browser is given its name: the arguments of a process are shown to every user of a machine.  The file is in the
    folder, because browsers that are confined, as snaps are, read no temporary files.
    """
    place = folder if os.access(folder, os.W_OK) else None
    with NamedTemporaryFile("w", dir=place, prefix=".ertel-app-", suffix=".html", encoding="utf-8") as file:
        file.write(f'<!doctype html><title>ertel</title><meta http-equiv="refresh" content="0; url={address}">')
        file.flush()
        yield Path(file.name)


def _open_browser(port: int, page: Path) -> None:
    """Open a page when the server listens."""
    while not helpers.is_port_open(LOOPBACK, port):
        time.sleep(0.1)
    webbrowser.open(page.as_uri())


def serve(folder: Path, port: int, show: bool, ready: Callable[[str], None]) -> list[str]:
    """Serve the app until it is closed; the names of the runs that go on.

    ready: called with the address when the app answers.  show: also open it in the browser.  Raises ValueError where
    the folder is none.
    """
    token = token_urlsafe()
    address = address_with(token, port)
    site = Site(Folder.at(folder), Processes(Folder.at(folder)), Artist())
    site.serve()
    app.on_startup(site.artist.begin)
    app.on_shutdown(site.artist.close)
    app.on_startup(lambda: ready(address))
    app.add_middleware(Guard, port=port, token=token)
    with suppress(KeyboardInterrupt), doorway(site.folder.root, address) as page:
        # a KeyboardInterrupt is how the server hands on a signal that ended it
        if show:
            Thread(target=_open_browser, args=(port, page), daemon=True).start()
        ui.run(
            root_of(site),
            host=LOOPBACK,
            port=port,
            title="ertel",
            favicon=ICON,
            show=False,
            reload=False,
            tailwind=False,
            show_welcome_message=False,
            reconnect_timeout=30.0,
            message_history_length=200,
        )
    return [site.folder.name_of(run) for run in site.processes.ours()]
