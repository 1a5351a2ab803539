"""A page printed to PDF by an installed browser of Chromium's family, without a window."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from hjsolve.errors import InvalidInputError

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge")
_ALONE = (
    "--headless",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-pdf-header-footer",
)
_SECONDS = 120


def browser(target: Path) -> str:
    """Return the browser that prints.

    Args:
        target: the file that is wanted, for the message.

    Returns:
        Its path.

    Raises:
        InvalidInputError: there is none.
    """
    found = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if found is None:
        page = target.with_suffix(".html")
        raise InvalidInputError(
            f"{target}: a PDF is printed by Chromium, Chrome or Edge, and none of them was found; "
            f"write {page} and print it from a browser's menu"
        )
    return found


def printed(page: str, target: Path) -> bytes:
    """Return the PDF of a page.

    Args:
        page: HTML that needs no other file.
        target: the file that is wanted, for messages.

    Raises:
        InvalidInputError: there is no browser, or it did not print.
    """
    program = browser(target)
    with tempfile.TemporaryDirectory(prefix="hjsolve-") as folder:
        source, made = Path(folder) / "page.html", Path(folder) / "page.pdf"
        source.write_text(page, encoding="utf-8")
        root = getattr(os, "geteuid", lambda: 1)() == 0  # Chromium's sandbox refuses to work for root
        command = [program, *_ALONE, *(["--no-sandbox"] if root else []), f"--user-data-dir={folder}/profile"]
        try:
            subprocess.run(  # noqa: S603 - a browser of this machine, on a page made here
                [*command, f"--print-to-pdf={made}", source.as_uri()], capture_output=True, timeout=_SECONDS, check=True
            )
            return made.read_bytes()
        except (OSError, subprocess.SubprocessError) as error:
            raise InvalidInputError(
                f"{target}: {program} did not print the page ({type(error).__name__}); "
                f"write {target.with_suffix('.html')} and print it from the browser's menu"
            ) from error
