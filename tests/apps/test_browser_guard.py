"""Access to the app: by the token only, which other users of the machine cannot see, and by pages of the app only."""

import asyncio
import os
import stat
from pathlib import Path

import pytest
from app_runs import make_run, served, until

pytest.importorskip("nicegui")
import httpx
from nicegui.version import __version__ as NICEGUI
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from ertel.apps.browser.server import REFUSED, Guard

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the app stops runs by SIGINT")
OURS, COOKIE = {"host": "127.0.0.1:8642"}, {"cookie": "ertel-8642=right"}
SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport="
ADDRESSES = (
    "/", "/new", "/run?name=ball", "/compare", "/nothing", "/favicon.ico", "/pictures/0", "/?token=wrong", "/?token=",
    f"/_nicegui/{NICEGUI}/static/nicegui.js", f"/_nicegui/{NICEGUI}/components/input.js", f"{SOCKET}polling",
)  # fmt: skip


def answer(headers, kind="http", address="/", root="/way"):
    """What the guard does with a request: the status of its own answer with its headers, or "passed"."""
    told = []

    async def passed(scope, receive, send):
        told.append("passed" if scope["root_path"] == "/way" else scope)

    async def send(message):
        told.append((message.get("status"), dict(message.get("headers", []))))

    path, _, query = address.partition("?")
    found = [(name.encode(), value.encode()) for name, value in headers.items()]
    scope = {"type": kind, "method": "GET", "path": root + path, "query_string": query.encode(), "headers": found}
    asyncio.run(Guard(passed, 8642, "/way/", "right")(scope, None, send))
    return told[0]


def is_refused(*request):
    status, headers = answer(*request)
    return status == 403 and headers[b"x-frame-options"] == b"DENY"


def test_only_pages_of_the_app_are_answered():
    ours, theirs = {**OURS, **COOKIE}, {**COOKIE, "host": "evil.example:8642"}
    assert answer(ours) == answer({**COOKIE, "host": "localhost:8642"}) == "passed"
    assert answer({**ours, "origin": "http://127.0.0.1:8642"}, "websocket") == "passed"
    assert is_refused(theirs) and is_refused({**COOKIE, "host": "127.0.0.1:1"}) and is_refused(COOKIE)
    assert is_refused({**ours, "origin": "http://evil.example"}) and is_refused({**ours, "origin": "null"})
    assert is_refused(theirs, "websocket") and is_refused({**ours, "origin": "https://evil.example"}, "websocket")


@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_nobody_is_answered_without_the_path(kind):
    """A browser sends the cookies of all ports of a host to each of them, where the path is that of the cookie."""
    for root in ("", "/", "/other", "/wa", "/way2", "/WAY"):
        status, headers = answer({**OURS, **COOKIE}, kind, "/?token=right", root)
        assert status == 403 and b"set-cookie" not in headers


def test_requests_of_other_sites_are_refused():
    ours = {**OURS, **COOKIE}
    assert {answer({**ours, "sec-fetch-site": site}) for site in ("none", "same-origin")} == {"passed"}
    assert all(is_refused({**ours, "sec-fetch-site": site}, "http", "/new") for site in ("cross-site", "same-site"))


@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_nobody_is_answered_without_the_token(kind):
    for cookie in ({}, {"cookie": "ertel-8642=wrong"}, {"cookie": "ertel-1=right"}, {"cookie": 'ertel-8642="; ü'}):
        assert is_refused({**OURS, **cookie}, kind)
        assert is_refused({**OURS, **cookie}, kind, "/?token=wrong")
        assert is_refused({**OURS, **cookie}, kind, "/new?token=right")  # only the first page lets in
    assert is_refused({"host": "evil.example:8642"}, kind, "/?token=right")


def test_the_token_gives_a_cookie_that_no_script_and_no_other_site_can_use():
    status, headers = answer(
        {**OURS, "sec-fetch-site": "cross-site"}, "http", "/?token=right"
    )  # a page opens the browser
    assert (status, headers[b"cache-control"], headers[b"referrer-policy"]) == (200, b"no-store", b"no-referrer")
    assert headers[b"set-cookie"] == b"ertel-8642=right; HttpOnly; Path=/way/; SameSite=strict"


# -- a server ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """The app as a process with a run: the process, its address, and the place of all files."""
    place = tmp_path_factory.mktemp("app")
    make_run(place / "folder" / "ball")
    browser = place / "browser"
    browser.write_text(f'#!/bin/sh\necho "$@" > {place}/draft\nmv {place}/draft {place}/opened\n')
    browser.chmod(0o700)
    with served(place / "folder", BROWSER=f"{browser} %s") as (process, address):
        yield process, address, place
    assert list((place / "folder").glob(".ertel-app-*")) == []


@pytest.fixture
def client(server):
    """Someone without the token."""
    base = httpx.URL(server[1]).copy_with(query=None)  # under the app's path
    with httpx.Client(base_url=base, transport=httpx.HTTPTransport(retries=5)) as found:
        yield found


def socket_of(client):
    return str(client.base_url.join(f"{SOCKET}websocket".lstrip("/"))).replace("http", "ws", 1)


def test_every_address_is_refused_without_the_token(client):
    for address in ADDRESSES:
        found = client.get(address)
        assert (found.status_code, found.text) == (403, REFUSED), address
        assert found.headers["content-security-policy"] == "frame-ancestors 'none'"
    with pytest.raises(InvalidStatus) as error, connect(socket_of(client)):
        pass
    assert (error.value.response.status_code, error.value.response.body.decode()) == (403, REFUSED)


def test_the_address_with_the_token_lets_in(server, client):
    _, address, _ = server
    assert len(httpx.URL(address).params["token"]) >= 40
    root = client.base_url.path
    assert len(root) >= 42 and f'url={root}"' in client.get(address).text
    [cookie] = client.cookies.jar
    assert cookie.path == root  # no other server of this machine gets it
    assert client.get(str(client.base_url.copy_with(path="/"))).status_code == 403
    for page in ("/", "/new", "/run?name=ball", f"/_nicegui/{NICEGUI}/static/nicegui.js", f"{SOCKET}polling"):
        found = client.get(page)
        assert found.status_code == 200 and found.headers["x-frame-options"] == "DENY", page
        assert httpx.URL(address).params["token"] not in found.text
        assert f"{root}_nicegui" in found.text or page.startswith("/_")
    cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
    with connect(socket_of(client), additional_headers={"Cookie": cookie}) as opened:
        assert opened.recv(timeout=10).startswith("0{")


def test_the_token_is_in_no_process_list(server, client):
    """The browser is opened on a file of the user's own; every user can read the arguments of a process."""
    process, address, place = server
    client.get(address)
    until((place / "opened").exists)
    token, opened = httpx.URL(address).params["token"], (place / "opened").read_text().strip()
    page = Path(httpx.URL(opened).path)
    assert address in page.read_text() and stat.S_IMODE(page.stat().st_mode) == 0o600
    assert token not in opened
    arguments = [Path(f"/proc/{process.pid}/{name}").read_bytes() for name in ("cmdline", "environ")]
    assert not any(token.encode() in text for text in arguments)
