"""A derivation ends with its time, and says what it left out."""

from __future__ import annotations

import pytest

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.time_limit import check_time, out_of_time, within_seconds


def test_the_inner_limit_never_outlasts_the_outer() -> None:
    with within_seconds(1e-9), within_seconds(100):
        assert out_of_time()
        with pytest.raises(NoFormError, match="longer than 1e-09 s"):
            check_time()
    assert not out_of_time()
    check_time()


def test_what_was_not_done_in_time_says_so() -> None:
    entry = hjsolve.catalog.describe("schwarzschild")
    motion = hjsolve.solve("schwarzschild").motion(**entry.motions["default"].arguments)
    form = own_form(motion, seconds=0.3)
    assert form is not None
    assert form.why_not
    assert any("took longer than 0.3 s" in str(reason) for reason in form.why_not.values())
    assert "time_law" in form.why_not or form.time_law is not None


def test_fewer_regimes_in_less_time() -> None:
    assert len(hjsolve.closed_forms("kepler-planar", seconds=1e-3)) < len(hjsolve.closed_forms("kepler-planar"))


@pytest.mark.parametrize(("options", "told"), [({"digits": 3}, "digits"), ({"seconds": 0}, "seconds")])
def test_refused_at_the_door(options: dict, told: str) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match=told):
        hjsolve.closed_forms("harmonic-oscillator", **options)


@pytest.mark.nightly
def test_more_digits_are_verified_when_asked() -> None:
    form = hjsolve.closed_forms("pendulum", digits=80)[0]
    assert not [reason for reason in form.why_not.values() if "not verified" in str(reason)]
    assert form.periods
