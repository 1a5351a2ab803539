"""A slice of the campaign of random motions (``benchmarks/campaign.py``): no claimed error is below the true one.

Each index draws another system of the catalog. Truth here is the same motion at 25 digits; the whole campaign, and every
state against Hamilton's equations in quadruple precision, is ``python benchmarks/campaign.py``. On every tenth motion
the 25 digits themselves are compared with Taylor series of Hamilton's equations.
"""

from __future__ import annotations

import os

import pytest
import sympy as sp
from mpmath import mp

from benchmarks import campaign
from hjsolve import catalog
from hjsolve.formulas.read import number
from tests.reference import mechanics
from tests.reference.taylor import Flow
from tests.support import random_motions

SLICE = range(7, 10_000, 601)
"""Another system each time: 601 and their number have no common divisor."""


@pytest.fixture(autouse=True)
def _without_heyoka(monkeypatch):
    monkeypatch.setattr(campaign, "twin", lambda: None)


def judged(seed, indices):
    findings = [campaign.judge(seed, index, limit=8) for index in indices]
    assert [(f.entry, f.lies) for f in findings if f.lies] == []
    assert [(f.entry, f.message) for f in findings if f.status == "crash"] == []
    return findings


@pytest.mark.nightly_cases("1", "2", "3")
@pytest.mark.parametrize("part", range(4))
def test_no_claim_of_a_random_motion_is_false(part):
    findings = [f for f in judged(1, SLICE[part::4]) if f.status != "too_long"]  # how many depends on the machine
    refused = [(f.entry, f.status, f.message) for f in findings if f.status != "ok"]
    assert len(refused) <= 1, refused
    assert all(f.claims >= 5 for f in findings if f.status == "ok")


def exact(value):
    return mp.mpf(sp.N(value, 45))


@pytest.mark.parametrize("index", [64 + 84, 38 + 2 * 84, 31 + 84, 34 + 84])
def test_the_truth_at_25_digits_obeys_hamiltons_equations(index):
    draw = random_motions.draw(1, index)
    system = catalog.describe(draw.entry).system
    motion = random_motions.solution(draw.entry).motion(**draw.arguments, digits=25)
    t = 0.4 * float(next(iter(motion.periods.values())).value) if motion.periods else 0.7
    state = motion.at(t)
    with mp.workdps(45):
        values = {p.name: number(draw.parameters.get(p.name, p.value), source=p.name) for p in system.parameters}
        symbols = {sp.Symbol(n): exact(v) for n, v in values.items()}
        H, names = mechanics.hamiltonian(draw.entry), [c.name for c in system.coordinates]
        begin = [exact(number(draw.q[n], source=n)) for n in names]
        begin += [exact(motion.initial.values[system.coordinate(n).momentum]) for n in names]
        flow = Flow(H, [sp.Symbol(n) for n in names], [sp.Symbol(f"p_{n}") for n in names], symbols, begin, digits=30)
        truth = flow.at(mp.mpf(t))
        for n, q, p in zip(names, truth[: len(names)], truth[len(names) :], strict=True):
            assert abs(state.unwrapped(n) - q) <= mp.mpf("1e-23") * (1 + abs(q)), n
            assert abs(state.p[n] - p) <= mp.mpf("1e-23") * (1 + abs(p)), n


@pytest.mark.nightly
@pytest.mark.timeout(0)
@pytest.mark.skipif(os.environ.get("HYPOTHESIS_PROFILE") != "nightly", reason="half an hour")
def test_no_claim_of_a_thousand_random_motions_is_false():
    judged(2, range(1000))
