"""The gate of the explorer: a token, a cookie, an origin, and a bound on sockets; nothing behind it is reached without."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

import hjsolve.explorer.gate as gates
from hjsolve.errors import InvalidInputError
from hjsolve.explorer.gate import Gate
from hjsolve.explorer.serve import serve_explorer

TOKEN, PORT = "a-token_of-no-one", 8123
COOKIE = (b"cookie", f"other=1; hjsolve-{PORT}={TOKEN}".encode())
HERE, EVIL = (b"origin", f"http://127.0.0.1:{PORT}".encode()), (b"origin", b"http://evil.com")


class Behind:
    """What is guarded: counts, answers, and keeps sockets open until it is told."""

    def __init__(self) -> None:
        self.reached, self.close = 0, asyncio.Event()

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        self.reached += 1
        if scope["type"] == "http":
            await send({"type": "http.response.start", "status": 200, "headers": [(b"x-own", b"1")]})
            await send({"type": "http.response.body", "body": b"page"})
        elif scope["type"] == "websocket":
            await send({"type": "websocket.accept"})
            await self.close.wait()


def ask(kind: str, *headers: tuple[bytes, bytes], path: str = "/", query: str = "") -> tuple[list[Any], int]:
    async def asked() -> tuple[list[Any], int]:
        sent, behind = list[Any](), Behind()
        behind.close.set()
        scope = {"type": kind, "path": path, "query_string": query.encode(), "headers": list(headers)}

        async def send(message: Any) -> None:
            sent.append(message)

        await Gate(behind, TOKEN, PORT, ("127.0.0.1", "localhost"))(scope, None, send)  # type: ignore[arg-type]
        return sent, behind.reached

    return asyncio.run(asked())


@pytest.mark.parametrize(
    ("headers", "path", "query"),
    [
        ((), "/", ""),
        ((), "/", "token="),
        ((), "/", "token=another"),
        ((), "/_nicegui/static/x.js", f"token={TOKEN}"),
        (((b"cookie", f"hjsolve-{PORT}=another".encode()),), "/", ""),
        (((b"cookie", f"hjsolve-{PORT + 1}={TOKEN}".encode()),), "/", ""),
        (((b"cookie", b"\xff=;;;"),), "/", ""),
        ((COOKIE, EVIL), "/_nicegui_ws/socket.io/", ""),
        ((COOKIE, (b"origin", b"null")), "/", ""),
        ((COOKIE, (b"origin", f"http://127.0.0.1:{PORT + 1}".encode())), "/", ""),
    ],
)
def test_a_request_without_the_token_or_of_another_origin_is_forbidden(headers, path, query) -> None:
    sent, reached = ask("http", *headers, path=path, query=query)
    assert (sent[0]["status"], reached) == (403, 0)
    assert TOKEN.encode() not in b"".join(m.get("body", b"") for m in sent)


def test_the_token_of_the_address_becomes_a_cookie_and_the_cookie_opens_the_page() -> None:
    (start, _), reached = ask("http", query=f"token={TOKEN}")
    headers = dict(start["headers"])
    assert (start["status"], headers[b"location"], reached) == (303, b"/", 0)
    assert headers[b"set-cookie"] == f"hjsolve-{PORT}={TOKEN}; Path=/; HttpOnly; SameSite=Strict".encode()
    (start, body), reached = ask("http", COOKIE)
    assert (start["status"], body["body"], reached) == (200, b"page", 1)
    headers = dict(start["headers"])
    assert headers[b"content-security-policy"] == b"frame-ancestors 'self'"
    assert headers[b"x-own"] == b"1"
    assert ask("http", COOKIE, HERE)[1] == 1


@pytest.mark.parametrize("headers", [(), (COOKIE,), (HERE,), (COOKIE, EVIL)])
def test_a_socket_needs_the_cookie_and_the_origin(headers) -> None:
    sent, reached = ask("websocket", *headers)
    assert ([m["type"] for m in sent], reached) == (["websocket.close"], 0)


def test_sockets_are_served_up_to_a_bound_and_again_once_one_is_closed(monkeypatch) -> None:
    monkeypatch.setattr(gates, "MOST_SOCKETS", 3)

    async def served() -> list[int]:
        behind = Behind()
        gate = Gate(behind, TOKEN, PORT, ("127.0.0.1",))
        scope = {"type": "websocket", "path": "/", "headers": [COOKIE, HERE]}

        async def quiet(_: Any) -> None: ...

        open_ = [asyncio.create_task(gate(scope, None, quiet)) for _ in range(5)]  # type: ignore[arg-type]
        await asyncio.sleep(0)
        counts = [behind.reached]
        behind.close.set()
        await asyncio.gather(*open_)
        await gate(scope, None, quiet)  # type: ignore[arg-type]
        return [*counts, behind.reached]

    assert asyncio.run(served()) == [3, 4]


@pytest.mark.parametrize(
    "limits",
    [{"port": -1}, {"port": 70000}, {"port": 1.5}, {"seconds": 0}, {"seconds": float("nan")}, {"megabytes": 0}],
)
def test_a_port_or_a_limit_that_makes_no_sense_is_refused(limits) -> None:
    pytest.importorskip("nicegui")
    with pytest.raises(InvalidInputError, match=r"--port|--seconds|--memory"):
        serve_explorer(None, show=False, **limits)


def test_a_page_asks_nothing_before_its_socket_is_there() -> None:
    ui = pytest.importorskip("nicegui").ui
    from nicegui import Client
    from nicegui.page import page as page_of

    from hjsolve.explorer.first_question import question_about
    from hjsolve.explorer.page import ExplorerPage

    asked = list[Any]()

    class Nobody:
        async def ask(self, question: Any) -> Any:
            asked.append(question)
            raise AssertionError

    async def no_fragment() -> str:
        return ""

    with Client(page_of("")) as client:
        page = ExplorerPage(Nobody(), question_about(None))  # type: ignore[arg-type]
        page.desk.put = asked.append  # type: ignore[method-assign]
        page._fragment = no_fragment  # type: ignore[method-assign]
    assert ui
    assert asked == []
    for _ in range(2):  # and once only, when a socket is lost and comes back
        for handler in client.connect_handlers:
            asyncio.run(handler())
    assert asked == [page.question]
    client.delete()
