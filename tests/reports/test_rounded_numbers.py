"""A printed number says no more than its error allows, and its interval holds the truth."""

from __future__ import annotations

from decimal import Decimal

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.printed_digits import raised
from hjsolve.display.progress import duration
from hjsolve.reports.sections.rounded_numbers import (
    decimal,
    quantity,
    rounded_outward,
    shortest,
)


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (6.283185307179586, 3.1e-15, ("6.283185307179586", "4e-15")),
        (1.0, 1.15e-16, ("1.00000000000000000", "1.2e-16")),
        (0.0, 1e-17, ("0", "1.1e-17")),
        (1.2, 0, ("1.2", "")),
        (100.0, 0, ("100", "")),
        (5.0, 7.0, ("5", "7")),
        (123456789.123, 1e-3, ("1.234567891230e8", "1.1e-3")),
        (float("inf"), 0, ("∞", "")),
        (float("nan"), 0, ("undefined", "")),
        (1.0, float("nan"), ("1", "unknown")),
    ],
)
def test_value_and_error_are_rounded_together(value: float, error: float, shown: tuple[str, str]) -> None:
    number = quantity(Estimate(value, error))
    assert (number.value, number.error) == shown


@given(
    st.floats(min_value=-1e30, max_value=1e30).filter(lambda x: abs(x) > 1e-250),
    st.floats(min_value=1e-280, max_value=1e25),
)
def test_the_printed_interval_holds_the_whole_interval(value: float, error: float) -> None:
    number = quantity(Estimate(value, error))
    middle, half = Decimal(number.value), Decimal(number.error)
    assert middle - half <= decimal(value) - decimal(error)
    assert middle + half >= decimal(value) + decimal(error)
    assert half <= 3 * decimal(error)


def test_many_digits_are_kept() -> None:
    with mpmath.workdps(60):
        value, error = mpmath.pi + 0, mpmath.mpf(10) ** -50
        assert quantity(Estimate(value, error)).value.startswith("3.14159265358979323846264338327950288419716939937")


@given(st.floats(min_value=-1e20, max_value=1e20).filter(lambda x: abs(x) > 1e-200))
def test_bounds_are_rounded_outward(value: float) -> None:
    def number(text: str) -> Decimal:
        figures = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻−", "0123456789--")
        return Decimal(text.replace("×10", "e").translate(figures))

    assert number(rounded_outward(value, up=False)) <= decimal(value) <= number(rounded_outward(value, up=True))


def test_small_things() -> None:
    assert shortest(0.1) == "0.1"
    assert shortest(1e-9) == "1e-9"
    assert raised("-1.5e-9") == "−1.5×10⁻⁹"
    assert [duration(t) for t in (2e-4, 0.0375, 1.23, 45.0)] == ["200 µs", "38 ms", "1.2 s", "45 s"]


def test_a_negative_number_of_many_digits_keeps_its_sign():
    """mpmath's man_exp is that of the absolute value."""
    from hjsolve.arithmetic.floats import multiprecision
    from hjsolve.arithmetic.printed_digits import decimal, shortest

    context = multiprecision(120)
    assert decimal(context.mpf("-2.25")) == decimal(-2.25)
    assert shortest(context.mpf("-2.25")) == "-2.25"
    assert quantity(Estimate(context.mpf("-2.25"), context.mpf(10) ** -20)).value.startswith("-2.25")
