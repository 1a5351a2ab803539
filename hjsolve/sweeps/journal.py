"""The journal of a sweep: a line of JSON for every part that was written, so that no part need be opened again.

A line that a killed process left unfinished is no JSON and counts for nothing; the part is looked into then. Of several
lines of one part the last counts.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

JOURNAL = "_journal.jsonl"


@dataclass(frozen=True)
class NotedPart:
    """What is known of a part.

    Attributes:
        part: its number.
        size: of its file, bytes.
        sha256: digest of its file, as it was written.
        statuses: word of a status → orbits, and ``recomputed`` → orbits computed singly.
    """

    part: int
    size: int
    sha256: str
    statuses: Mapping[str, int]


@dataclass(frozen=True)
class Journal:
    """The file."""

    path: Path

    def parts(self) -> dict[int, NotedPart]:
        """Number of a part → what is known of it."""
        found: dict[int, NotedPart] = {}
        if self.path.exists():
            for line in self.path.read_bytes().splitlines():
                try:
                    noted = NotedPart(**json.loads(line))
                except (ValueError, TypeError):
                    continue
                found[noted.part] = noted
        return found

    def note(self, noted: NotedPart) -> None:
        """Append a line. It begins on a new one, whatever a killed process left before it.

        Args:
            noted: what is known of a part.
        """
        with self.path.open("ab") as file:
            file.write(b"\n" + json.dumps(asdict(noted)).encode() + b"\n")
