"""Who may ask: only pages that this app served, on the name of this machine's own loopback.

Another site that is open in the same browser could send requests to a local port, under a name of its own that leads
to this machine (which the header Host tells), or from its own page (which Origin tells).  Both are refused.
"""

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

LOOPBACK = "127.0.0.1"
OURS = (LOOPBACK, "localhost")

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[Message, Receive, Send], Awaitable[None]]


class Guard:
    """An ASGI application that passes to another what comes from the app's own pages, and refuses the rest."""

    def __init__(self, app: Application, port: int):
        self._app = app
        self._hosts = {f"{name}:{port}" for name in OURS}

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] not in ("http", "websocket") or self._is_ours(dict(scope["headers"])):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            text = b"This is the app of another page.\n"
            await send({"type": "http.response.start", "status": 403, "headers": [(b"content-type", b"text/plain")]})
            await send({"type": "http.response.body", "body": text})

    def _is_ours(self, headers: MutableMapping[bytes, bytes]) -> bool:
        host = headers.get(b"host", b"").decode("latin-1")
        origin = headers.get(b"origin", b"").decode("latin-1")
        return host in self._hosts and (not origin or origin.removeprefix("http://") in self._hosts)
