"""What a command prints: through a stream that shows control and bidirectional characters as escapes."""

from __future__ import annotations

from typing import Any, TextIO

from hjsolve.display.visible_text import visible


class VisibleStream:
    """A text stream in front of another one.

    Args:
        stream: where the text goes.
    """

    def __init__(self, stream: TextIO):
        self._stream = stream

    def write(self, text: str) -> int:
        """Write a text.

        Args:
            text: any.
        """
        return self._stream.write(visible(text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


__all__ = ["VisibleStream"]
