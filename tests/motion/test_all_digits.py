"""Digits asked are digits had: every libration of the catalog at 30 and at 100 digits, against forms at 120 digits."""

from __future__ import annotations

import pytest
from mpmath import mp

import hjsolve
from hjsolve import catalog
from tests.reference.forms import THOROUGH, form
from tests.reference.regenerate import motions
from tests.support.entries import described, kinds_of_motions

GROUPS = {"period": "periods", "action": "actions", "frequency": "frequencies"}
SAMPLE = ("pendulum", "kepler-planar", "spherical-pendulum")
LIBRATIONS = [
    name for name in catalog.ids("separable") if "libration" in kinds_of_motions(name).get("default", {}).values()
]


@pytest.mark.entries
@pytest.mark.parametrize(
    "name",
    [n if n in SAMPLE else pytest.param(n, marks=[pytest.mark.nightly, pytest.mark.timeout(0)]) for n in LIBRATIONS],
)
def test_thirty_and_a_hundred_digits_are_right_to_the_last(name):
    entry = described(name)
    solution = hjsolve.solve(entry.system)
    thirty, hundred = (solution.motion(**entry.initial.arguments, digits=d) for d in (30, 100))
    with mp.workdps(130):
        for group in ("constants", *GROUPS.values()):
            for key, better in getattr(hundred, group).items():
                ours = getattr(thirty, group)[key]
                assert abs(ours.value - better.value) <= ours.error, (group, key)
                assert ours.error <= mp.mpf("1.01e-30") * abs(better.value) or not better.value
        if name in THOROUGH:
            mp.dps = 120
            known = form(name)(*(getattr(next(motions(name)), part) for part in ("parameters", "q", "p")))
            for quantity, (truth, _) in known.items():
                kind, _, key = quantity.partition(".")
                if kind in GROUPS:
                    found = getattr(hundred, GROUPS[kind])[key]
                    assert abs(found.value - truth) <= found.error + mp.mpf("1e-115") * abs(truth), quantity
