"""Numbers: every exact kind is taken as what it says, everything else is refused in one line."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import mpmath
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from hjsolve.errors import ExpressionError
from hjsolve.formulas.read import number

EXACT = [
    (3, sp.Integer(3)),
    (-0.5, sp.Rational(-1, 2)),
    (0.1, sp.Rational(3602879701896397, 2**55)),
    (5e-324, sp.Rational(1, 2**1074)),
    ("0.1", sp.Rational(1, 10)),
    ("-1/24", sp.Rational(-1, 24)),
    ("+1.5e-3", sp.Rational(3, 2000)),
    ("pi/3", sp.pi / 3),
    (" sqrt(2) ", sp.sqrt(2)),
    (Fraction(2, 7), sp.Rational(2, 7)),
    (Decimal("0.1"), sp.Rational(1, 10)),
    (Decimal("-3e2"), sp.Integer(-300)),
    (mpmath.mpf("0.75"), sp.Rational(3, 4)),
    (mpmath.mpf(-6), sp.Integer(-6)),
    (mpmath.mpf(0), sp.Integer(0)),
    (sp.Rational(1, 3), sp.Rational(1, 3)),
    (sp.Float(0.1), sp.Rational(3602879701896397, 2**55)),
    (2 * sp.pi, 2 * sp.pi),
]


@pytest.mark.parametrize(("value", "expected"), EXACT, ids=lambda value: str(value)[:20])
def test_a_number_is_exact(value, expected):
    result = number(value, source="k")
    assert result == expected
    assert not result.has(sp.Float)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_float_is_the_binary_number_it_is(value):
    assert Fraction(*map(int, number(value, source="k").as_numer_denom())) == Fraction(value)


def test_numpy_scalars_are_numbers():
    numpy = pytest.importorskip("numpy")
    assert number(numpy.float64(0.1), source="k") == number(0.1, source="k")
    assert number(numpy.float32(0.1), source="k") == sp.Rational(13421773, 2**27)
    assert number(numpy.int64(-7), source="k") == -7
    assert number(numpy.array(1.5), source="k") == sp.Rational(3, 2)
    assert number(numpy.longdouble(1) / 4, source="k") == sp.Rational(1, 4)
    for value in (numpy.bool_(True), numpy.complex128(1), numpy.array([1.0]), numpy.float64("nan")):
        with pytest.raises(ExpressionError):
            number(value, source="k")


REFUSED = [
    True,
    None,
    [1],
    [10**5000],
    b"1",
    1j,
    float("nan"),
    float("inf"),
    Decimal("nan"),
    Decimal("inf"),
    mpmath.mpf("inf"),
]
REFUSED += [mpmath.mpf("nan"), mpmath.mpc(1), Decimal("1e999999999"), mpmath.mpf(2) ** 10**9, 10**5000, "", "x", "nan"]
REFUSED += [
    "inf",
    10**5000,
    "1e9999",
    "2 m",
    "sqrt(-1)",
    sp.oo,
    sp.nan,
    sp.I,
    sp.zoo,
    sp.asin(2),
    sp.Symbol("x"),
    sp.true,
]


@pytest.mark.timeout(60)
@pytest.mark.parametrize("value", REFUSED, ids=lambda value: type(value).__name__)
def test_what_is_not_one_finite_real_number_is_refused(value):
    with pytest.raises(ExpressionError, match="initial r"):
        number(value, source="initial r")


def test_a_variable_that_a_library_differentiates_by_is_no_number():
    """A tracer of JAX has shape and item(): the number alone would have the derivative 0."""

    class Traced:
        shape = ()

        def item(self):
            return 0.5

        def __float__(self):
            raise TypeError("traced")

    with pytest.raises(ExpressionError, match="k: expected one finite real number, got Traced"):
        number(Traced(), source="k")
