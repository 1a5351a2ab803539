"""Text that can be shown anywhere: no character in it moves a cursor, colours a terminal or reverses a line.

Such characters are control characters (Unicode category Cc) other than line ends and tabs, the marks of bidirectional
text (Unicode Annex 9), and the separators of lines and paragraphs U+2028 and U+2029.
"""

from __future__ import annotations

import re

_HIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069]")


def hidden_character(text: str) -> str:
    """Return the first character that must not be shown as it stands, as an escape; nothing where there is none."""
    found = _HIDDEN.search(text)
    return _escape(found) if found else ""


def visible(text: str) -> str:
    r"""Write such characters as escapes.

    Example:
        >>> visible("a\x1b[31m")
        'a\\u001b[31m'
    """
    return _HIDDEN.sub(_escape, text)


def _escape(found: re.Match[str]) -> str:
    return f"\\u{ord(found[0]):04x}"
