"""Who may speak with the explorer: whoever has the token of the address, from a page of the same origin.

The token stands in the address that is printed. The first answer moves it into a cookie that no script reads and no
other site sends. A socket needs the cookie and, as browsers say where a page comes from, the origin of this server.
"""

from __future__ import annotations

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any, TypeAlias
from urllib.parse import parse_qs

Message: TypeAlias = MutableMapping[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[Message]]
Send: TypeAlias = Callable[[Message], Awaitable[None]]
Application: TypeAlias = Callable[[Message, Receive, Send], Awaitable[None]]

MOST_SOCKETS = 32
"""Tabs that are served at the same time."""
_POLICY = [
    (b"content-security-policy", b"frame-ancestors 'self'"),
    (b"x-frame-options", b"SAMEORIGIN"),
    (b"referrer-policy", b"no-referrer"),
]
_ADDRESS_NEEDED = "open the address that `hjsolve explore` printed, with its token\n"
_OTHER_ORIGIN = "a page of another site may not speak with this server\n"


class Gate:
    """An ASGI application in front of another one.

    Args:
        application: what is guarded.
        token: in the address, and then in the cookie.
        port: of the server.
        hosts: names that the server is called by.
    """

    def __init__(self, application: Application, token: str, port: int, hosts: tuple[str, ...]):
        self._application, self._token = application, token
        self._cookie = f"hjsolve-{port}"
        self._origins = {f"http://{host}:{port}" for host in hosts}
        self._sockets = 0

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Answer, refuse or pass on."""
        if scope["type"] == "http":
            await self._page(scope, receive, send)
        elif scope["type"] == "websocket":
            await self._socket(scope, receive, send)
        else:
            await self._application(scope, receive, send)

    async def _page(self, scope: Message, receive: Receive, send: Send) -> None:
        origin = _header(scope, b"origin")
        if origin and origin not in self._origins:
            await _answer(send, 403, _OTHER_ORIGIN)
        elif scope["path"] == "/" and self._is_token(_queried(scope)):
            cookie = f"{self._cookie}={self._token}; Path=/; HttpOnly; SameSite=Strict"
            await _answer(send, 303, "", [(b"location", b"/"), (b"set-cookie", cookie.encode())])
        elif self._has_cookie(scope):

            async def guarded(message: Message) -> None:
                if message["type"] == "http.response.start":
                    message = {**message, "headers": [*message.get("headers", []), *_POLICY]}
                await send(message)

            await self._application(scope, receive, guarded)
        else:
            await _answer(send, 403, _ADDRESS_NEEDED)

    async def _socket(self, scope: Message, receive: Receive, send: Send) -> None:
        if _header(scope, b"origin") not in self._origins or not self._has_cookie(scope):
            await send({"type": "websocket.close", "code": 1008})  # before it is accepted: 403
        elif self._sockets >= MOST_SOCKETS:
            await send({"type": "websocket.close", "code": 1013})
        else:
            self._sockets += 1
            try:
                await self._application(scope, receive, send)
            finally:
                self._sockets -= 1

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), self._token.encode())

    def _has_cookie(self, scope: Message) -> bool:
        try:
            found = SimpleCookie(_header(scope, b"cookie")).get(self._cookie)
        except CookieError:
            return False
        return found is not None and self._is_token(found.value)


def _header(scope: Message, name: bytes) -> str:
    values = [value for key, value in scope.get("headers", []) if key == name]
    return b"; ".join(values).decode("latin-1")


def _queried(scope: Message) -> str:
    return parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]


async def _answer(send: Send, status: int, text: str, headers: list[tuple[bytes, bytes]] | None = None) -> None:
    plain = [(b"content-type", b"text/plain; charset=utf-8"), (b"cache-control", b"no-store"), *_POLICY]
    await send({"type": "http.response.start", "status": status, "headers": [*plain, *(headers or [])]})
    await send({"type": "http.response.body", "body": text.encode()})
