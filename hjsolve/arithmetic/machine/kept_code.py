"""Where machine code of kernels stays between processes: the user's own cache folder, one file for each kernel.

numba's own cache looks whether the file of a function has changed, not the files of the functions that it calls, and
trusts what it reads. So ours is named by everything that machine code depends on: the text of all kernels, the
versions of Python, numba and llvmlite, the types of the arguments, and the processor. A file begins with a digest of
what follows: one that is cut short, or in which a bit is wrong, is compiled anew. A file is there completely or not at
all.

``HJSOLVE_CACHE_DIR`` names another folder than ``$NUMBA_CACHE_DIR/hjsolve``, ``$XDG_CACHE_HOME/hjsolve`` or
``~/.cache/hjsolve``; 0 keeps nothing. As machine code is run, the folder must belong to the user, and nobody else may
write in it. Where it can be read and not written, what it holds is used.
"""

from __future__ import annotations

import os
import pickle
import stat
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numba.core.codegen import CPUCodegen
    from numba.core.compiler import CompileResult
    from numba.core.cpu import CPUContext
    from numba.core.typing.templates import Signature

_ROOM = Path(__file__).parent
_ROOMS = (
    _ROOM,
    _ROOM.parents[1] / "ensembles" / "engine" / "kernels",
    _ROOM.parents[1] / "two_point" / "kepler" / "kernels",
)
_OTHERS = 0o022
_DIGEST = 32
_SAID = "hjsolve: compiling its loops, once for this installation ('hjsolve setup' does it beforehand)\n"


def keep(dispatcher: Any, function: Callable[..., object]) -> None:
    """Let the machine code of a function stay on disk.

    Args:
        dispatcher: what numba made of it; nothing is compiled yet.
        function: the function itself.
    """
    dispatcher._cache = KeptCode(f"{function.__module__}.{function.__qualname__}")


@cache
def fingerprint() -> str:
    """Return a name that no other text of the kernels, version of numba or of Python has."""
    own = sha256(f"{sys.version}\n{version('numba')}\n{version('llvmlite')}\n{version('numpy')}\n".encode())
    for room in _ROOMS:
        for path in sorted(room.rglob("*.py")):
            own.update(f"{path.relative_to(room)}\n".encode() + path.read_bytes())
    for name in ("double_double.py", "error_free.py"):  # which ``pairs`` compiles
        own.update((_ROOM.parent / name).read_bytes())
    return own.hexdigest()[:24]


@cache
def folder() -> Path | None:
    """Return the folder of the machine code of just these kernels, made where it is not there yet; None for none."""
    base = _base()
    if base is None:
        return None
    found = base / f"kernels-{fingerprint()}"
    try:
        found.mkdir(mode=0o700, parents=True, exist_ok=True)
        return found if _private(found) else None
    except OSError:
        return None


def _base() -> Path | None:
    given = os.environ.get("HJSOLVE_CACHE_DIR")
    if given in ("", "0"):
        return None
    try:
        if given:
            return Path(given).expanduser()
        other = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or "~/.cache"
        return Path(other).expanduser() / "hjsolve"
    except RuntimeError:  # a user without a home
        return None


def _private(place: Path) -> bool:
    """Tell whether a folder belongs to the user, and nobody else may write in it."""
    if not hasattr(os, "getuid"):
        return True
    found = place.stat()
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & _OTHERS


class KeptCode:
    """The machine code of one function, for all types of its arguments; what numba asks where it would ask its cache.

    Attributes:
        name: of the function, with its module.
    """

    def __init__(self, name: str):
        self.name = name

    @property
    def cache_path(self) -> str | None:
        """The folder."""
        place = folder()
        return None if place is None else str(place)

    def _path(self, signature: Signature, codegen: CPUCodegen) -> Path | None:
        place = folder()
        key = sha256(repr((signature, codegen.magic_tuple())).encode()).hexdigest()[:16]
        return None if place is None else place / f"{self.name}-{key}"

    def load_overload(self, signature: Signature, context: CPUContext) -> CompileResult | None:
        """Return what numba compiled for a signature; None where it is not on disk, or not whole.

        Args:
            signature: types of the arguments and of the result.
            context: numba's, of the processor.
        """
        from numba.core.compiler import CompileResult

        context.refresh()
        path = self._path(signature, context.codegen())
        content = b"" if path is None else _read(path)
        if not content:
            _say()
            return None
        return CompileResult._rebuild(context, *pickle.loads(content))  # noqa: S301  ours: see _private

    def save_overload(self, signature: Signature, result: Any) -> None:
        """Write what numba compiled for a signature, where that is possible.

        Args:
            signature: types of the arguments and of the result.
            result: what numba compiled.
        """
        from numba.core.serialize import dumps

        path = self._path(signature, result.codegen)
        if path is None or result.lifted or result.library.has_dynamic_globals:
            return
        try:
            _write(path, dumps(result._reduce()))
        except OSError:  # a full disk, a folder that is read-only: compiled again in the next process
            return

    def flush(self) -> None:
        """Nothing is held here: each signature has its file."""


def _read(path: Path) -> bytes:
    """Return what a file holds after its digest; nothing where the digest is another."""
    try:
        content = path.read_bytes()
    except OSError:
        return b""
    return content[_DIGEST:] if sha256(content[_DIGEST:]).digest() == content[:_DIGEST] else b""


def _write(path: Path, content: bytes) -> None:
    handle, name = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(sha256(content).digest() + content)
        Path(name).replace(path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise


@cache
def _say() -> None:
    """Say on a terminal, once in a process, that compiling takes some seconds."""
    if sys.stderr is not None and sys.stderr.isatty():
        sys.stderr.write(_SAID)
