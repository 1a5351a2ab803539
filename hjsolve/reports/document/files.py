"""Where a report goes: the file is checked before anything is computed, and written whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hjsolve import arguments
from hjsolve.errors import InvalidInputError
from hjsolve.reports.document import pdf

SUFFIXES = (".html", ".pdf", ".md", ".json", ".txt", ".tex")
_LONGEST_TITLE = 200


def checked_path(path: str | Path, suffixes: tuple[str, ...] = SUFFIXES) -> Path:
    """Check where a report shall go before anything is computed.

    Returns:
        The path.

    Raises:
        InvalidInputError: unknown suffix, a directory, a folder that does not exist or cannot be written to; a PDF
            where no browser prints it.
    """
    arguments.refuse_other(path, (str, os.PathLike), "path", 'the file to write is needed, such as "orbit.html"')
    target = Path(path)
    if target.suffix.lower() not in suffixes:
        given = f'"{target.suffix}"' if target.suffix else "none"
        raise InvalidInputError(f"{target}: the suffix must be one of {', '.join(suffixes)}, not {given}")
    folder = target.parent
    with readable_errors(target):
        if target.is_dir():
            raise InvalidInputError(f"{target}: is a directory; give a file name")
        if not folder.is_dir():
            raise InvalidInputError(f"{target}: the folder {folder} does not exist; create it first")
        if not os.access(folder, os.W_OK) or (target.exists() and not os.access(target, os.W_OK)):
            raise InvalidInputError(f"{target}: cannot be written here; choose another place")
    if target.suffix.lower() == ".pdf":
        pdf.browser(target)
    return target


def checked_title(title: str) -> str:
    """Check the title of a report.

    Args:
        title: one line; empty for the system's own.

    Returns:
        The title, without room at its ends.

    Raises:
        InvalidInputError: no text, more than one line, or letters that cannot be printed.
    """
    arguments.refuse_other(title, str, "title", 'a line of text is needed, such as "Exercise 3"')
    plain = title.strip()
    if len(plain) > _LONGEST_TITLE or not plain.isprintable():
        raise InvalidInputError(f"title: write one line of at most {_LONGEST_TITLE} letters that can be printed")
    return plain


def replace(target: Path, content: str | bytes) -> None:
    """Write a file completely and only then put it in its place; a link is followed, and stays a link.

    Args:
        content: its text, written as UTF-8, or its bytes.

    Raises:
        OSError: it cannot be written; then nothing has changed.
    """
    place = target.resolve() if target.is_symlink() else target
    name = place.parent / f".{place.name}.{secrets.token_hex(6)}"
    handle = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
            file.flush()
            os.fsync(file.fileno())
        if place.exists():
            name.chmod(place.stat().st_mode & 0o777)
        name.replace(place)
    finally:  # nothing is left next to the target, whatever went wrong
        with suppress(OSError):
            name.unlink(missing_ok=True)


@contextmanager
def readable_errors(target: Path) -> Iterator[None]:
    """Turn an error of the operating system into one line about the file.

    Raises:
        InvalidInputError: the file cannot be written, or its name cannot be used.
    """
    try:
        yield
    except InvalidInputError:
        raise
    except OSError as error:
        raise InvalidInputError(f"{target}: cannot be written ({error.strerror or type(error).__name__})") from error
    except ValueError as error:
        raise InvalidInputError(f"{str(target)!r}: is not a usable file name") from error
