"""The journal of a sweep: a line of JSON for every part, with the digest of its bytes, written before the part is.

The digest decides whether a part is good. A line that is not a note of a part counts for nothing, and is reported; of
several lines of one part the last counts.
"""

from __future__ import annotations

import json
import os
import re
from dataclasses import asdict, dataclass
from pathlib import Path

from hjsolve.catalog.regular_files import bytes_of, opened_regular

JOURNAL = "_journal.jsonl"
_ROOM, _ROOM_OF_A_PART = 10_000_000, 1_000
"""Bytes that a journal may have: a line has about a hundred, and a part has one line for each time it was computed."""
_SHA256 = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class NotedPart:
    """What was written as a part.

    Attributes:
        part: its number.
        sha256: digest of its file.
    """

    part: int
    sha256: str


@dataclass(frozen=True)
class Journal:
    """The file."""

    path: Path

    def digests(self, parts: int) -> tuple[dict[int, str], int]:
        """Read the digest of each part, and how many lines are no notes of parts.

        Args:
            parts: how many the sweep has.

        Returns:
            Number of the part → digest; and the number of lines that count for nothing.

        Raises:
            InvalidInputError: the journal is a link, not a regular file, or far longer than such a journal can be.
        """
        found: dict[int, str] = {}
        try:
            text = bytes_of(self.path, _ROOM + _ROOM_OF_A_PART * parts, follow=False)
        except FileNotFoundError:
            return found, 0
        lines = [line for line in text.splitlines() if line.strip()]
        notes = [note for line in lines if (note := _note(line)) is not None and note.part < parts]
        found.update((note.part, note.sha256) for note in notes)
        return found, len(lines) - len(notes)

    def note(self, noted: NotedPart) -> None:
        """Append a line. It begins on a new one, whatever a killed process left before it.

        Args:
            noted: what is about to be written.
        """
        with opened_regular(self.path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, follow=False) as file:
            file.write(b"\n" + json.dumps(asdict(noted)).encode() + b"\n")


def _note(line: bytes) -> NotedPart | None:
    """Return what a line says; None where it is not a note of a part, whatever its types are."""
    try:
        held = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not isinstance(held, dict) or held.keys() != {"part", "sha256"}:
        return None
    number, digest = held["part"], held["sha256"]
    sound = type(number) is int and number >= 0 and isinstance(digest, str) and _SHA256.fullmatch(digest)
    return NotedPart(number, digest) if sound else None
