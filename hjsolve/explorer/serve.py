"""The server: one page on this machine, processes behind it that compute."""

from __future__ import annotations

import math
import secrets
import socket
from pathlib import Path

from hjsolve import arguments
from hjsolve.errors import InvalidInputError, MissingExtraError
from hjsolve.explorer.first_question import question_about

HOST = "127.0.0.1"
_NAMES = (HOST, "localhost")
_MOST_PAGES = 64
"""Pages that are open, or were opened in the last minute."""


def serve_explorer(
    subject: str | Path | None = None,
    *,
    port: int = 0,
    show: bool = True,
    seconds: float = 20.0,
    megabytes: int = 1024,
    workers: int = 2,
) -> None:
    """Serve the explorer until it is interrupted.

    Args:
        subject: what it opens with: id of a catalog entry, path of an entry or a scene; None for a double well.
        port: on this machine; 0 for any that is free.
        show: open the page in a browser.
        seconds: one question may take.
        megabytes: one question may take.
        workers: processes that compute.

    Raises:
        MissingExtraError: NiceGUI is not installed.
        InvalidInputError: there is no such subject, the port is none or is taken, or a limit makes no sense.
    """
    arguments.whole(port, "--port", 0, 65535)
    arguments.whole(megabytes, "--memory", 1)
    arguments.whole(workers, "workers", 1)
    if not 0 < arguments.seconds(seconds, "--seconds") < math.inf:
        raise InvalidInputError(f"--seconds: a number of seconds above 0 is needed, not {seconds:g}")
    try:
        from nicegui import Client, app, ui
    except ImportError as missing:
        raise MissingExtraError('the explorer needs NiceGUI: pip install "hjsolve[explore]"') from missing
    from starlette.middleware.trustedhost import TrustedHostMiddleware

    from hjsolve.explorer.bounded_log import bound_logs
    from hjsolve.explorer.gate import Gate
    from hjsolve.explorer.page import ExplorerPage
    from hjsolve.explorer.worker import Workers

    question = question_about(subject)
    chosen = _free(port)
    pool = Workers(workers, seconds, megabytes)

    @ui.page("/")
    def page() -> None:
        if len(Client.instances) > _MOST_PAGES:
            ui.label(f"{_MOST_PAGES} pages are open; close some, wait a minute and load this one again")
        else:
            ExplorerPage(pool, question)

    token = secrets.token_urlsafe(24)
    address = f"/?token={token}"
    app.add_middleware(Gate, token=token, port=chosen, hosts=_NAMES)
    app.add_middleware(TrustedHostMiddleware, allowed_hosts=list(_NAMES))
    bound_logs()
    app.on_startup(pool.begin)
    app.on_shutdown(pool.end)
    print(f"hjsolve explore: http://{HOST}:{chosen}{address} (Ctrl-C ends it)", flush=True)
    ui.run(
        host=HOST, port=chosen, title="hjsolve explore", show=address if show else False, reload=False,
        show_welcome_message=False, uvicorn_logging_level="error", dark=None,
    )  # fmt: skip


def _free(port: int) -> int:
    """Return the port, or one that is free."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError as taken:
            raise InvalidInputError(f"--port {port}: it is taken; give another, or none for a free one") from taken
        return int(probe.getsockname()[1])
