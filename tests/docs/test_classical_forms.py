"""The page of classical systems is what its command prints; two systems in the commit lane, all of them nightly."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.classical_forms import LINES, written

PAGE = Path(__file__).parents[2] / "docs" / "classical-forms.md"


@pytest.mark.nightly_cases(*(line.entry for line in LINES if line.entry not in ("kepler-planar", "pendulum")))
@pytest.mark.parametrize("line", LINES, ids=[line.entry for line in LINES])
def test_a_system_is_written_as_the_command_writes_it(line: object) -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert written(line) in text, "run: python docs/classical_forms.py > docs/classical-forms.md"  # type: ignore[arg-type]
