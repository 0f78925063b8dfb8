"""Access control of the app: only the browser that was given the token is answered, and only to pages of the app.

Every process on this machine reaches a local port, also those of other users, and every page that is open in the
browser can send requests there.  So a request needs

* the token of this start of the app, which the address carries that `ertel app` prints, and then a cookie;
* the name of this machine's own loopback in the header Host: another name may have been made to lead here;
* an Origin and a Sec-Fetch-Site of the app itself, where the browser sends them: other pages cannot choose these.

All answers forbid other pages to show them in a frame, and the browser to name their address elsewhere.
"""

from hmac import compare_digest

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

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
ENTRANCE = '<!doctype html><title>ertel</title><meta http-equiv="refresh" content="0; url=/"><a href="/">ertel</a>'


def address_with(token: str, port: int) -> str:
    """The address that lets a browser in."""
    return f"http://{LOOPBACK}:{port}/?{TOKEN}={token}"


class Guard:
    """An ASGI application that passes what may be answered to another, also websockets, and refuses the rest."""

    def __init__(self, app: ASGIApp, port: int, token: str):
        self._app, self._token = app, token
        self._hosts = {f"{name}:{port}" for name in OURS}
        self._cookie = f"ertel-{port}"  # cookies are shared by all ports

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] in ("http", "websocket"):
            await self._answer(HTTPConnection(scope))(scope, receive, _with_headers(send))
        else:
            await self._app(scope, receive, send)

    def _answer(self, asked: HTTPConnection) -> ASGIApp:
        if asked.headers.get("host") in self._hosts:
            if (
                asked.scope["type"] == "http"
                and asked.scope["path"] == "/"
                and self._is_token(asked.query_params.get(TOKEN))
            ):
                return self._entrance()
            if _is_own(asked) and self._is_token(asked.cookies.get(self._cookie)):
                return self._app
        return PlainTextResponse(REFUSED, 403)

    def _is_token(self, given: str | None) -> bool:
        return given is not None and compare_digest(given.encode(), self._token.encode())

    def _entrance(self) -> Response:
        """The page that gives the cookie and leads to the first page, whose address has no token."""
        page = HTMLResponse(ENTRANCE, headers={"Cache-Control": "no-store"})
        page.set_cookie(self._cookie, self._token, httponly=True, samesite="strict")
        return page


def _is_own(asked: HTTPConnection) -> bool:
    """Whether a request comes from a page of the app or from the user, as far as the browser tells."""
    origin, site = asked.headers.get("origin"), asked.headers.get("sec-fetch-site")
    is_known = site in (None, "same-origin", "none") or asked.scope["type"] == "websocket"  # which has an Origin
    return is_known and origin in (None, f"http://{asked.headers['host']}")


def _with_headers(send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] in ("http.response.start", "websocket.http.response.start"):
            MutableHeaders(scope=message).update(HEADERS)
        await send(message)

    return sent
