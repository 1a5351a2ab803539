"""Where compiled programs stay between processes: numba's cache, beside a file in the user's own cache folder.

numba keeps machine code beside the file that a function comes from, and trusts it. So the file is named by everything
that the machine code depends on (its text, our loops, the versions of numba and Python), and the folder must belong to
the user alone. The text that is executed is never read back: the file only tells numba where its cache is.

``HJSOLVE_CACHE_DIR`` names another folder than ``$XDG_CACHE_HOME/hjsolve`` or ``~/.cache/hjsolve``; 0 keeps nothing.
Nothing is kept either where ``NUMBA_CACHE_DIR`` sends numba elsewhere, or the folder cannot be written.
"""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

_CODE = (
    "clearance.py",
    "compiled_clearance.py",
    "compiled_integrals.py",
    "compiled_pairs.py",
    "compiled_phase.py",
    "compiled_rule.py",
    "compiled_turning_points.py",
    "compiled_types.py",
    "elementary.py",
    "nodes.py",
)
_OTHERS = 0o022


def fingerprint(text: str) -> str:
    """Return a name for a program that no other text, version of numba or of Python, or state of our loops has.

    Args:
        text: the program.
    """
    return sha256(f"{_surroundings()}\n{text}".encode()).hexdigest()[:32]


@cache
def _surroundings() -> str:
    own = sha256()
    for name in _CODE:
        own.update(Path(__file__).with_name(name).read_bytes())
    return f"{sys.version}\n{version('numba')}\n{version('llvmlite')}\n{own.hexdigest()}"


def path_for(text: str) -> Path | None:
    """Return the file that stands for a program, written where it is not there yet; None where nothing is kept.

    Args:
        text: the program.
    """
    folder = _folder()
    if folder is None:
        return None
    path = folder / f"program_{fingerprint(text)}.py"
    try:
        for place in (folder, folder / "__pycache__"):
            place.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not _private(place):
                return None
        if not _same(path, text):
            _write(path, text)
    except OSError:
        return None
    return path


def is_cached(text: str, names: tuple[str, ...]) -> bool:
    """Tell whether the machine code of these functions of a program is there already; nothing is written.

    Args:
        text: the program.
        names: functions of it.
    """
    folder = _folder()
    if folder is None:
        return False
    path = folder / f"program_{fingerprint(text)}.py"
    try:
        if not (_private(folder) and _private(folder / "__pycache__") and _same(path, text)):
            return False
        return all(any((folder / "__pycache__").glob(f"{path.stem}.{name}*.nbi")) for name in names)
    except OSError:
        return False


def _folder() -> Path | None:
    given = os.environ.get("HJSOLVE_CACHE_DIR")
    if given in ("", "0") or os.environ.get("NUMBA_CACHE_DIR"):
        return None
    try:
        base = Path(given or os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
    except RuntimeError:  # a user without a home
        return None
    return (base if given else base / "hjsolve") / "programs"


def _private(folder: Path) -> bool:
    """Tell whether a folder belongs to the user, and nobody else may write in it."""
    found = folder.stat()
    owned = not hasattr(os, "getuid") or found.st_uid == os.getuid()
    return stat.S_ISDIR(found.st_mode) and owned and not (hasattr(os, "getuid") and found.st_mode & _OTHERS)


def _same(path: Path, text: str) -> bool:
    try:
        return path.read_bytes() == text.encode()
    except FileNotFoundError:
        return False


def _write(path: Path, text: str) -> None:
    """Write a file that is there completely or not at all."""
    handle, name = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(text.encode())
        Path(name).replace(path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise
