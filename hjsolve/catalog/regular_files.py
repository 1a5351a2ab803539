"""Files of others: regular ones only, read to a limit, and opened so that neither a pipe nor a device can hold us.

A name that a user types may be a pipe that nobody writes to, a device without an end, a sparse file of terabytes, or a
link to any of them. What is opened here never waits, and never takes more memory than it is told to.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import BinaryIO

from hjsolve.errors import InvalidInputError

_NEVER_WAIT = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
_AS_IT_IS = getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
_NO_LINK = getattr(os, "O_NOFOLLOW", 0)


def opened_regular(path: str | Path, flags: int = os.O_RDONLY, *, follow: bool = True, shown: str = "") -> BinaryIO:
    """Open a regular file, without waiting for anybody.

    Args:
        flags: of ``os.open``, such as ``os.O_RDWR | os.O_CREAT``; nothing is truncated unless they say so.
        follow: whether the path itself may be a link.
        shown: what the file is called in errors; its path unless given.

    Returns:
        The open file.

    Raises:
        InvalidInputError: it is a folder, a pipe, a device or a socket, or a link that may not be followed.
        OSError: the system refuses it.
    """
    shown = shown or str(path)
    if not follow and Path(path).is_symlink():
        raise InvalidInputError(f"{shown}: is a link; put a regular file in its place, or delete it")
    number = os.open(path, flags | _NEVER_WAIT | _AS_IT_IS | (0 if follow else _NO_LINK), 0o666)
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise InvalidInputError(f"{shown}: is not a regular file; give a file that is on a disk")
    if flags & (os.O_WRONLY | os.O_RDWR):
        return os.fdopen(number, "ab" if flags & os.O_APPEND else "rb+" if flags & os.O_RDWR else "wb")
    return os.fdopen(number, "rb")


def bytes_of(path: str | Path, limit: int, *, follow: bool = True, shown: str = "") -> bytes:
    """Read a regular file whole.

    Args:
        limit: bytes that it may have.
        follow: whether the path itself may be a link.
        shown: what the file is called in errors; its path unless given.

    Raises:
        InvalidInputError: it is not a regular file, or longer than the limit.
        OSError: the system refuses it.
    """
    with opened_regular(path, follow=follow, shown=shown) as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise InvalidInputError(f"{shown or path}: is longer than {limit} bytes; give a smaller file")
    return data
