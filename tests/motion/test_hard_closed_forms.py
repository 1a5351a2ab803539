"""Hard cases with a closed form: q(t), periods, node counts, and claims against the truth at 60 digits."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.hard_cases import Case, cases, measure

pytestmark = pytest.mark.rotating_file(3)

CASES = cases()


@pytest.mark.rotating(12)
@pytest.mark.nightly_cases("three roots 1, 1.00000001, 1.0000000100000001")
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_position_and_period_are_right_and_the_claims_hold(case: Case) -> None:
    found = measure(case)  # asserts claimed ≥ true for every number

    assert found.error <= case.reach
    assert found.period_error <= 1e-14
    assert found.nodes <= case.nodes
    assert np.median(found.ratios) <= 100, "claims are typically within a factor of 100"


@pytest.mark.slow
@pytest.mark.nightly
@pytest.mark.parametrize("case", [c for c in CASES if c.reach <= 2e-14], ids=lambda case: case.name)
def test_thirty_digits_are_thirty_digits(case: Case) -> None:
    found = measure(case, digits=30)

    assert found.error <= 1e-28
    assert found.period_error <= 1e-30


def test_no_two_cases_share_a_name() -> None:
    assert len({case.name for case in CASES}) == len(CASES)
