"""The server of the app on loopback, which answers only the browser that was given the token, and only its own pages.

Every process on this machine reaches a local port, also those of other users, and every page that is open in the
browser can send requests there.  So a request needs

* the path under which all pages of this start of the app are, which nobody can guess.  A browser sends the cookies of
  one port to all ports of a host, but only to the paths that they are for, so no other server sees the app's;
* the token of this start, which the address carries that `ertel app` prints, and then a cookie for that path;
* the name of this machine's own loopback in the header Host: another name may have been made to lead here;
* an Origin and a Sec-Fetch-Site of the app itself, where the browser sends them: other pages cannot choose these.

All answers forbid other pages to show them in a frame, and the browser to name their address elsewhere.
"""

import os
import time
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from hmac import compare_digest
from pathlib import Path
from secrets import token_urlsafe
from tempfile import NamedTemporaryFile
from threading import Thread
from typing import Any

from nicegui import app, helpers, ui
from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ertel.apps.browser.folder import Folder
from ertel.apps.browser.new_page import NewCase, home_page
from ertel.apps.browser.pictures import Worker, keep_small
from ertel.apps.browser.processes import Processes
from ertel.apps.browser.run_pages import Comparison, RunPage
from ertel.apps.browser.site import LOGO, Site, frame
from ertel.apps.browser.study_page import MeasuredPage, StudyPage

LOOPBACK = "127.0.0.1"
OURS = (LOOPBACK, "localhost")
TOKEN = "token"
REFUSED = "Open the app by the address that ertel app printed in its terminal: it carries the token of this app.\n"
HEADERS = {
    "Content-Security-Policy": "frame-ancestors 'none'",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
}
# No redirection: browsers send no strict cookie after one that another page began, such as that of `doorway`.
NO_ICON = '<link rel="icon" href="data:,">'  # or the browser asks for /favicon.ico, which is refused
DOORWAY = f'<!doctype html><title>ertel</title>{NO_ICON}<meta http-equiv="refresh" content="0; url={{address}}">'
ENTRANCE = DOORWAY + '<a href="{address}">ertel</a>'
PAGES: dict[str, Any] = {
    "/": home_page, "/new": NewCase, "/run": RunPage, "/study": StudyPage, "/compare": Comparison,
    "/measured": MeasuredPage,
}  # fmt: skip


# -- who is answered --------------------------------------------------------------------------------------------------


class Guard:
    """An ASGI application that passes what may be answered to another, also websockets, and refuses the rest.

    root: the path of the first page, with a slash at both ends.
    """

    def __init__(self, app: ASGIApp, port: int, root: str, token: str):
        self._app, self._root, self._token = app, root, token
        self._hosts = {f"{name}:{port}" for name in OURS}
        self._cookie = f"ertel-{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] in ("http", "websocket"):
            await self._answer(HTTPConnection(scope))(scope, receive, _with_headers(send))
        else:
            await self._app(scope, receive, send)

    def _answer(self, asked: HTTPConnection) -> ASGIApp:
        path = asked.scope["path"]
        if asked.headers.get("host") in self._hosts and path.startswith(self._root):
            is_first = asked.scope["type"] == "http" and path == self._root
            if is_first and self._is_token(asked.query_params.get(TOKEN)):
                return self._entrance()
            if _is_own(asked) and self._is_token(asked.cookies.get(self._cookie)):
                return self._pass
        return PlainTextResponse(REFUSED, 403)

    async def _pass(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on; its path without the root is what pages are known by."""
        await self._app({**scope, "root_path": self._root.rstrip("/")}, receive, send)

    def _is_token(self, given: str | None) -> bool:
        return given is not None and compare_digest(given.encode(), self._token.encode())

    def _entrance(self) -> Response:
        """The page that gives the cookie and leads to the first page, whose address has no token."""
        page = HTMLResponse(ENTRANCE.format(address=self._root), headers={"Cache-Control": "no-store"})
        page.set_cookie(self._cookie, self._token, path=self._root, httponly=True, samesite="strict")
        return page


def _is_own(asked: HTTPConnection) -> bool:
    """True if a request comes from a page of the app or from the user, as far as the browser tells."""
    origin, site = asked.headers.get("origin"), asked.headers.get("sec-fetch-site")
    is_known = site in (None, "same-origin", "none") or asked.scope["type"] == "websocket"  # which has an Origin
    return is_known and origin in (None, f"http://{asked.headers['host']}")


def _with_headers(send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] in ("http.response.start", "websocket.http.response.start"):
            MutableHeaders(scope=message).update(HEADERS)
        await send(message)

    return sent


# -- the server -------------------------------------------------------------------------------------------------------


def root_of(site: Site) -> Callable[[], None]:
    """The function that builds a page of the app."""
    return partial(frame, site, PAGES)


@contextmanager
def doorway(folder: Path, address: str) -> Iterator[Path]:
    """A page that leads to an address, in a file that only its user can read.

    The browser is given its name: the arguments of a process are shown to every user of a machine.  The file is in the
    folder, because browsers that are confined, as snaps are, read no temporary files.
    """
    place = folder if os.access(folder, os.W_OK) else None
    with NamedTemporaryFile("w", dir=place, prefix=".ertel-app-", suffix=".html", encoding="utf-8") as file:
        file.write(DOORWAY.format(address=address))
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
    the folder is none or the port is taken.
    """
    if helpers.is_port_open(LOOPBACK, port):
        raise ValueError(f"--port {port}: is taken, perhaps by this app in another terminal; choose another port")
    root, token = f"/{token_urlsafe()}/", token_urlsafe()
    address = f"http://{LOOPBACK}:{port}{root}?{TOKEN}={token}"
    keep_small()
    site = Site(Folder.at(folder), Processes(Folder.at(folder)), Worker())
    site.serve_pictures()
    app.on_startup(site.worker.begin)
    app.on_shutdown(site.worker.close)
    app.on_startup(lambda: ready(address))
    app.add_middleware(Guard, port=port, root=root, token=token)
    with suppress(KeyboardInterrupt), doorway(site.folder.root, address) as page:
        # a KeyboardInterrupt is how the server hands on a signal that ended it
        if show:
            Thread(target=_open_browser, args=(port, page), daemon=True).start()
        ui.run(
            root_of(site),
            host=LOOPBACK,
            port=port,
            title="ertel",
            favicon=LOGO,
            show=False,
            reload=False,
            tailwind=False,
            show_welcome_message=False,
            reconnect_timeout=30.0,
            message_history_length=200,
        )
    return [site.folder.name_of(run) for run in site.processes.ours()]
