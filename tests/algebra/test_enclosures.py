"""Enclosures of expressions at rational points: the true value is inside, also where it is next to an end."""

from fractions import Fraction

import pytest
import sympy as sp

from hjsolve.algebra.intervals import NoEnclosureError, enclose
from hjsolve.precision import multiprecision

FUNCTIONS = ["exp", "log", "sin", "cos", "tan", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "sech", "coth"]


def exponential_from_below(x: Fraction) -> Fraction:
    """Return e^x, x > 0, from its Taylor series in whole units of 2⁻⁴⁰⁰⁰, every term rounded down."""
    total = term = 1 << 4000
    n = 0
    while term:
        n += 1
        term = term * x.numerator // (x.denominator * n)
        total += term
    return Fraction(total, 1 << 4000)


def test_an_exponential_next_to_a_number_of_the_precision_is_enclosed():
    # e^x lies 2e-4 units of 64 bits above a number of 64 bits: mpmath's own directed rounding takes that as upper end
    x = Fraction(630059, 512)
    _, upper = enclose(sp.exp(sp.Rational(x.numerator, x.denominator)), {}, 64)
    assert int(upper._mpf_[1]) * Fraction(2) ** upper._mpf_[2] > exponential_from_below(x)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_values_of_many_digits_lie_inside(name):
    x = sp.Symbol("x")
    context = multiprecision(400)
    for k in range(1, 60):
        place = sp.Rational(7 * k + 4, 5 if k % 2 else 17)
        if name == "acosh" and place <= 1:
            continue
        lower, upper = enclose(getattr(sp, name)(x), {x: place}, 64)
        truth = getattr(context, name)(context.mpf(int(place.p)) / int(place.q))
        assert lower < truth < upper
        assert upper - lower < abs(truth) * context.mpf(2) ** -48


@pytest.mark.parametrize("text", ["log(-2)", "log(0)", "acosh(1/2)", "asin(2)", "coth(0)", "exp(2**2000)"])
def test_what_has_no_finite_real_value_is_refused(text):
    expression = sp.parse_expr(text, evaluate=False)
    with pytest.raises(NoEnclosureError):
        enclose(expression, {}, 64)
