"""The server: one page on this machine, processes behind it that compute."""

from __future__ import annotations

import socket
from pathlib import Path

from hjsolve.errors import InvalidInputError, MissingExtraError
from hjsolve.explorer.first_question import question_about

HOST = "127.0.0.1"


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
        InvalidInputError: there is no such subject, or the port is taken.
    """
    try:
        from nicegui import app, ui
    except ImportError as missing:
        raise MissingExtraError('the explorer needs NiceGUI: pip install "hjsolve[explore]"') from missing
    from starlette.middleware.trustedhost import TrustedHostMiddleware

    from hjsolve.explorer.page import ExplorerPage
    from hjsolve.explorer.worker import Workers

    question = question_about(subject)
    chosen = _free(port)
    pool = Workers(workers, seconds, megabytes)

    @ui.page("/")
    def page() -> None:
        ExplorerPage(pool, question)

    app.add_middleware(TrustedHostMiddleware, allowed_hosts=[HOST, "localhost"])
    app.on_startup(pool.begin)
    app.on_shutdown(pool.end)
    print(f"hjsolve explore: http://{HOST}:{chosen} (Ctrl-C ends it)", flush=True)
    ui.run(
        host=HOST, port=chosen, title="hjsolve explore", show=show, reload=False, show_welcome_message=False,
        uvicorn_logging_level="error", dark=None,
    )  # fmt: skip


def _free(port: int) -> int:
    """The port, or one that is free."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError as taken:
            raise InvalidInputError(f"--port {port}: it is taken; give another, or none for a free one") from taken
        return int(probe.getsockname()[1])
