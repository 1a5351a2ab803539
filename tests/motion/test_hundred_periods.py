"""Spherical pendulum and Lagrange top over a hundred nutations, against Taylor series of Hamilton's equations at 40 digits."""

from __future__ import annotations

import mpmath
import pytest
from mpmath import mp

import hjsolve
from tests.reference.regenerate import motions


@pytest.mark.nightly_cases("lagrange-top-shares1", "spherical-pendulum-shares0")
@pytest.mark.parametrize(
    ("name", "fractions"),
    [
        ("spherical-pendulum", (0.31, 2.77)),
        ("lagrange-top", (0.31, 2.77)),
        *(
            pytest.param(n, (9.77, 71.43, 100.0), marks=[pytest.mark.nightly, pytest.mark.timeout(0)])
            for n in ("spherical-pendulum", "lagrange-top")
        ),
    ],
)
def test_states_over_many_periods_agree_with_the_integrated_equations_to_1e_13(name, fractions):
    entry = hjsolve.catalog.describe(name)
    motion = hjsolve.solve(entry.system).motion(**entry.initial.arguments)
    with mp.workdps(60):
        twin = next(motions(name))
        flow = twin.flow()
        for fraction in fractions:
            t = fraction * motion.periods["theta"].value
            state, truth = motion.at(t), flow.at(mp.mpf(t))
            for k, n in enumerate(twin.names):
                q = mp.mpf(state.q[n]) + 2 * mp.pi * state.turns.get(n, 0)
                p = truth[len(twin.names) + k]
                assert abs(q - truth[k]) <= min(mp.mpf(state.error.q[n]), mp.mpf("1e-13"))
                assert abs(mpmath.mpf(state.p[n]) - p) <= min(mp.mpf(state.error.p[n]), mp.mpf("1e-13"))
