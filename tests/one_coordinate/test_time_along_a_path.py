"""A search on the way to infinity ends: what is not decided in its time is an error that says so, and nothing is kept."""

from __future__ import annotations

import pytest

import hjsolve
from hjsolve.one_coordinate import time_along_a_path
from hjsolve.one_coordinate.time_along_a_path import TooSlowError, stopwatch


def start() -> object:
    return hjsolve.solve("kepler-planar").motion(q={"r": "1.37", "theta": 0}, velocity={"r": 0, "theta": "1.9"})


def test_an_escape_says_what_was_not_decided_and_is_whole_the_next_time(monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as changed:
        changed.setattr(time_along_a_path, "SECONDS", 0.0)
        with pytest.raises(hjsolve.NotConvergedError, match=r"not decided in 0 s of the processor: .*beyond q = 1.37"):
            start()
    assert start().kinds["r"] == "escape"


def test_more_digits_have_more_time() -> None:
    now = [0.0]
    check, longer = (stopwatch(digits, lambda: now[0]) for digits in (15, 30))
    now[0] = 31.0
    longer(lambda: "p")
    with pytest.raises(TooSlowError, match="not decided in 30 s of the processor: p"):
        check(lambda: "p")
    now[0] = 121.0
    with pytest.raises(TooSlowError, match="120 s"):
        longer(lambda: "p")
