"""What draws or differentiates public values: rooms above them, which the package makes known when it is imported.

A value asks for a renderer when it is drawn, so that nothing that draws is loaded before; and a motion for its
derivatives, which are worked out by a room above that of motions.
"""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

_LOADERS: dict[str, Callable[[], ModuleType]] = {}


def register(name: str, load: Callable[[], ModuleType]) -> None:
    """Make a renderer known.

    Args:
        name: by which values ask for it.
        load: imports it.
    """
    _LOADERS[name] = load


def renderer(name: str) -> ModuleType:
    """Return a renderer: the module whose functions draw.

    Args:
        name: ``plots``, ``notebook`` or ``derivatives``.
    """
    return _LOADERS[name]()
