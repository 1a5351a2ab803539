"""Reports: one document about a system and a motion, written as HTML, Markdown, JSON, text or LaTeX.

In: anything the library makes. Out: one file, written whole or not at all.
Read ``document/blocks.py`` first (what a report says), then ``content.py`` and ``write.py``; ``sections`` make its
parts, ``formulas`` and ``drawings`` what they hold, ``formats`` the text of a file.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hjsolve.reports.document.files import SUFFIXES as SUFFIXES
    from hjsolve.reports.write import report as report

__all__ = ["SUFFIXES", "report"]


def __getattr__(name: str) -> Any:
    """Import the writers when they are first used: the sections of formulas alone need no numpy (PEP 562)."""
    if name == "SUFFIXES":
        from hjsolve.reports.document import files

        return files.SUFFIXES
    if name in __all__:
        from hjsolve.reports import write

        return getattr(write, name)
    raise AttributeError(f"module 'hjsolve.reports' has no attribute {name!r}")
