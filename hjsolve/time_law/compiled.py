"""Whether compiled loops serve: the extra ``fast``, taken when it is installed and there is enough to do."""

from __future__ import annotations

import os
import sys
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from types import ModuleType

WORTH = 50_000
"""Fewer times than this do not pay for loading numba (0.3 s, once a process); after that everything is compiled."""

_MODULE = "hjsolve.time_law.compiled_loops"


def kernels(points: int) -> ModuleType | None:
    """Return the compiled loops, or None where numpy is to do the work.

    Args:
        points: how many numbers are to be worked out.

    Returns:
        The module ``hjsolve.time_law.compiled_loops``; None without the extra ``fast``, for a small task while numba
        is not loaded yet, or where the environment says ``HJSOLVE_COMPILED=0``.
    """
    if os.environ.get("HJSOLVE_COMPILED") == "0" or (_MODULE not in sys.modules and points < WORTH) or not _numba():
        return None
    from hjsolve.time_law import compiled_loops as module

    return module


@cache
def _numba() -> bool:
    return find_spec("numba") is not None
