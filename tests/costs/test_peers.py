"""The table of peers: what is missing is told, a wrong answer is an infinite error, ratios are against our own side."""

from __future__ import annotations

import math

import numpy as np
from mpmath import mpf

from benchmarks import peers


def test_a_rival_that_is_not_installed_is_told() -> None:
    assert peers.rival("no_such_package_at_all.part") is None
    assert "no_such_package_at_all" in peers.MISSING
    assert peers.rival("math") is math


def test_an_answer_that_is_no_number_is_an_infinite_error() -> None:
    assert peers.far(np.array([1.0, np.nan]), [mpf(1), mpf(2)], [0, 1]) == math.inf
    assert peers.far(np.array([1.0, 2.5]), [mpf(1), mpf(2)], [0, 1], relative=True) == 0.25


def test_all_sides_take_turns(monkeypatch) -> None:
    monkeypatch.setenv("HJSOLVE_COMPILED", "1")
    order: list[str] = []
    sides = [peers.Side(who, lambda who=who: order.append(who), lambda _: 0.5) for who in ("ours", "theirs")]
    rows = list(peers.contest("work", "case", 10, sides, 3))
    assert order == ["ours", "theirs"] * 4
    assert [row.who for row in rows] == ["ours", "theirs"]
    assert rows[0].ratio == 1
    assert rows[1].error == 0.5
