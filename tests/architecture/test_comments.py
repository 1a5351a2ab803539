"""Rooms that hold the numerical kernels say why at each step, and no comment says again what the code says."""

from __future__ import annotations

import io
import re
import tokenize

import pytest

from tests.support.sources import ROOT

ROOMS = ("certified", "ensembles/engine", "one_coordinate", "time_law")
FEWEST = 40
"""Comments in a thousand lines."""


def comments(text: str) -> list[str]:
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return [token.string for token in tokens if token.type == tokenize.COMMENT]


def repeating(text: str) -> list[str]:
    """Comments without a formula whose words all stand in the line below."""
    lines, found = text.splitlines(), []
    for number, line in enumerate(lines):
        comment = line.strip()
        if comment.startswith("# ") and comment.isascii() and not re.search(r"[=*/^:]|\bfmt\b|---", comment):
            below = next((x for x in lines[number + 1 :] if not x.strip().startswith("#")), "")
            words = set(re.findall(r"[a-z]{3,}", comment.lower()))
            if words and words <= set(re.findall(r"[a-z]{3,}", below.lower())):
                found.append(comment)
    return found


@pytest.mark.parametrize("room", ROOMS)
def test_kernels_say_why(room: str) -> None:
    texts = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "hjsolve" / room).rglob("*.py"))]
    count, lines = sum(len(comments(text)) for text in texts), sum(len(text.splitlines()) for text in texts)
    assert count * 1000 >= FEWEST * lines, f"{room}: {count} comments in {lines} lines"
    assert not [comment for text in texts for comment in repeating(text)]


def test_a_comment_that_repeats_the_code_is_found() -> None:
    assert repeating("# loop over orbits\nfor orbit in loop_over_orbits(orbits):\n    pass\n") == ["# loop over orbits"]
    assert not repeating("# the largest comes last: one rounding\ntotal = small + large\n")
