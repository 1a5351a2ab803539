"""A value, or the name of a system, of thousands of letters was repeated as a whole in the one line that refuses it."""

from __future__ import annotations

import pytest

from hjsolve.command_line.main import main


@pytest.mark.parametrize(
    "arguments",
    [
        ["motion", "kepler-planar", "--q", "x" + "9" * 3000, "--momentum", "x=1"],
        ["sweep", "a" * 5000, "-o", "x"],
        ["check", "a" * 5000],
    ],
)
def test_an_endless_word_is_shortened(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert len(told) < 700
    assert "..." in told
