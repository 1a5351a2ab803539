"""The first lines of many: a reader mends ten faults at a time, and a terminal is not a place for sixty thousand."""

from __future__ import annotations

from collections.abc import Iterable

from hjsolve.display.visible_text import visible

MOST_LINES = 10


def few_lines(lines: Iterable[str], most: int = MOST_LINES) -> str:
    r"""Join lines, and say how many more there are; control and bidirectional characters become escapes.

    Args:
        lines: a sentence each.
        most: how many are shown.

    Example:
        >>> few_lines(["a", "b", "c"], most=2)
        'a\nb\nand 1 more'
    """
    told = list(lines)
    more = len(told) - most
    return "\n".join([*map(visible, told[:most]), *((f"and {more} more",) if more > 0 else ())])
