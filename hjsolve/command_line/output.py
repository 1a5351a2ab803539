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
        self._failed: OSError | None = None

    def write(self, text: str) -> int:
        """Write a text."""
        try:
            return self._stream.write(visible(text))
        except OSError as error:  # argparse would pass over it
            self._failed = error
            raise

    def flush(self) -> None:
        """Write what is held back.

        Raises:
            OSError: now, or when something was written before.
        """
        if self._failed is not None:
            raise self._failed
        self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)
