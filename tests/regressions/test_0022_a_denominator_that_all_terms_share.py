"""p² of the A-frame: thirteen terms over 4 sin²θ − 1, which vanishes at the end of the domain, where they cancel.

Intervals knew nothing of their sum on any cell near that end, and the search for a turning point took half a minute.
"""

from __future__ import annotations

import pytest
import sympy as sp

from hjsolve.lowering import over_one_denominator
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from tests.support import entries

x, a = sp.symbols("x a", real=True)


@pytest.mark.nightly
def test_a_motion_to_the_end_of_the_domain_is_found_in_few_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    calls, enclose = [], MomentumSquared.enclose
    monkeypatch.setattr(MomentumSquared, "enclose", lambda self, *cells: calls.append(1) or enclose(self, *cells))
    given = {"q": {"theta": 0.3834943254720452}, "velocity": {"theta": -0.4525303280294137},
             "parameters": {"m": 0.8940583360515237, "g": 0.5688089120512491, "l": 0.8229074146068331}}  # fmt: skip
    solution = entries.solution("a-frame")
    motion = solution.motion(**given)
    assert motion.kinds == {"theta": "boundary"}
    assert len(calls) <= 40  # more than 2000 before
    ours, exact = motion.boundary_times["theta"], solution.motion(**given, digits=25).boundary_times["theta"]
    assert abs(exact.value - ours.value) <= ours.error <= 1e-13


def test_only_a_denominator_of_all_terms_is_taken_out() -> None:
    shared = x**2 / (2 * x**2 - 2) - a / (x**2 - 1) + sp.sin(x) / (3 * x**2 - 3)
    whole = over_one_denominator(shared, x)
    assert not whole.is_Add
    assert sp.simplify(whole - shared) == 0
    for kept in (shared + 1, x**2 / (x + 1) + a / (x + 2), x / (a + 1) + x**2 / (a + 1), x**2, x / a + 1 / x):
        assert over_one_denominator(kept, x) == kept
