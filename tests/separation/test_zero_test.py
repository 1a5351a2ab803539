"""The zero test: zeros are proved, near-zeros are refuted with a certificate, and nothing hangs."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from hjsolve.algebra import poly
from hjsolve.algebra.intervals import NoEnclosureError, enclose
from hjsolve.algebra.modular import PRIMES, products_vanish
from hjsolve.algebra.poly import Budget
from hjsolve.algebra.reader import Reader
from hjsolve.separation.zero_test.interval_evaluation import Region, find_witness
from hjsolve.separation.zero_test.zero_test import NonZero, Unproved, Zero, is_zero

x, y, t = sp.symbols("x y t", real=True)
u, v, a, b, n = sp.symbols("u v a b n", positive=True)
f, g = sp.Function("f"), sp.Function("g")

ZEROS = {
    "nested radical of two roots": sp.sqrt(u + v + 2 * sp.sqrt(u * v)) - sp.sqrt(u) - sp.sqrt(v),
    "nested radical with a number": sp.sqrt(2 * u**2 + v**2 + 2 * sp.sqrt(2) * u * v) - sp.sqrt(2) * u - v,
    "double angle": sp.sin(2 * x) - 2 * sp.sin(x) * sp.cos(x),
    "half angle": sp.tan(x / 2) - sp.sin(x) / (1 + sp.cos(x)),
    "sum of angles": sp.cos(x + y - t) - sp.re(sp.expand(sp.cos(x + y - t), trig=True)),
    "seventh multiple": sp.cos(7 * x) - sp.chebyshevt(7, sp.cos(x)),
    "hyperbolic Pythagoras": sp.cosh(u) ** 2 - sp.sinh(u) ** 2 - 1,
    "hyperbolic against exp": sp.exp(2 * u) * sp.exp(-u) - sp.cosh(u) - sp.sinh(u),
    "fraction": (u**3 - v**3) / (u - v) - u**2 - u * v - v**2,
    "perfect square under a root": sp.sqrt((a * sp.cosh(u) * sp.cos(x) + a) ** 2 + (a * sp.sinh(u) * sp.sin(x)) ** 2)
    - a * (sp.cosh(u) + sp.cos(x)),
    "product of roots": sp.sqrt(u**2 * v + u * v**2) - sp.sqrt(u * v) * sp.sqrt(u + v),
    "reciprocal root": 1 / sp.sqrt(x**2 + y**2 + 1) - sp.sqrt(x**2 + y**2 + 1) / (x**2 + y**2 + 1),
    "cube roots": (u + v) ** sp.Rational(4, 3) / (u + v) ** sp.Rational(1, 3) - u - v,
    "numbers under roots": sp.sqrt(6) * x
    - sp.sqrt(2) * sp.sqrt(3) * x
    + sp.sqrt(sp.Rational(8, 9))
    - 2 * sp.sqrt(2) / 3,
    "logarithms": sp.log(u * v**2 / a) - sp.log(u) - 2 * sp.log(v) + sp.log(a),
    "symbolic exponents": u**n * u ** (2 * n + 1) - u ** (3 * n) * u,
    "derivative of atan": sp.diff(sp.atan(x / u), x) - u / (x**2 + u**2),
    "product rule of an unknown function": sp.diff(f(u) ** 2 * u, u) - f(u) ** 2 - 2 * u * f(u) * f(u).diff(u),
    "wave equation": sp.diff(f(x) * g(y), x, y) - f(x).diff(x) * g(y).diff(y),
    "absolute value": sp.Abs(x) ** 2 - x**2,
    "arcsine and arccosine": sp.asin(x) + sp.acos(x) - sp.pi / 2,
    "nested root of numbers": sp.sqrt(5 + 2 * sp.sqrt(6)) - sp.sqrt(2) - sp.sqrt(3),
    "nested root, difference": sp.sqrt(u + 2 - sp.sqrt((u + 2) ** 2 - 4)) - sp.sqrt(u / 2 + 2) + sp.sqrt(u / 2),
    "nested root": sp.sqrt(u + 2 + sp.sqrt((u + 2) ** 2 - 4)) - sp.sqrt(u / 2) - sp.sqrt(u / 2 + 2),
}

SMALL = sp.Rational(1, 10**30)
NON_ZEROS = {
    "double angle": ZEROS["double angle"] + SMALL * x,
    "fraction": ZEROS["fraction"] + SMALL,
    "root": ZEROS["perfect square under a root"] + SMALL * sp.cos(x),
    "logarithms": ZEROS["logarithms"] + SMALL,
    "unknown functions": f(u) - f(v),
    "unknown derivative": f(u).diff(u) - f(u),
    "angle in degrees": sp.sin(x) - x + x**3 / 6 - x**5 / 120,
    "root of a square": sp.sqrt(x**2) - x,
    "large numbers": (10**40 + 1) * x - 10**40 * x,
    "exponentials": sp.exp(x) * sp.exp(y) - sp.exp(x * y),
    "zero modulo the primes of the filter": PRIMES[0] * PRIMES[1] * x * y,
    "inverse functions": sp.atan(x) - sp.asin(x / sp.sqrt(1 + x**2)) + SMALL * x,
}


@pytest.mark.parametrize("name", list(ZEROS))
def test_an_identity_is_proved(name):
    assert is_zero(ZEROS[name]) == Zero()


@pytest.mark.parametrize("name", list(NON_ZEROS))
def test_what_is_not_zero_is_refuted_by_a_witness_even_at_1e_30(name):
    answer = is_zero(NON_ZEROS[name])
    assert isinstance(answer, NonZero)
    assert answer.witness.excludes_zero


@pytest.mark.parametrize("name", list(ZEROS))
def test_no_zero_has_a_witness(name):
    assert find_witness(ZEROS[name], Region(dict.fromkeys((x, y, t), (None, None)))) is None


def test_what_cannot_be_settled_is_left_open_with_its_value():
    expression = sp.Integral(sp.exp(-(x**2)), (x, 0, y)) - sp.erf(y) * sp.sqrt(sp.pi) / 2
    answer = is_zero(expression)
    assert isinstance(answer, Unproved)
    hidden = sp.acosh(2 * u**2 + 1) - 2 * sp.asinh(u)
    answer = is_zero(hidden)
    assert isinstance(answer, Zero)


def test_the_witness_respects_domains_and_signs():
    a, c = sp.Symbol("a", positive=True), sp.Symbol("c", negative=True)
    region = Region({u: (a, 2 * a), x: (sp.Integer(3), None), y: (None, sp.Integer(-2))}, {a: sp.Rational(5, 3)})
    answer = is_zero(u * x * y * a * c + SMALL, region)
    point = answer.witness.point
    assert point["a"] == sp.Rational(5, 3)
    assert point["a"] < point["u"] < 2 * point["a"]
    assert point["c"] < 0
    assert point["x"] > 3
    assert point["y"] < -2


@pytest.mark.timeout(120)
def test_an_enormous_expansion_stops_at_its_budget():
    symbols = sp.symbols("z0:14", real=True)
    monster = sp.Add(*symbols) ** 60 - sp.Add(*symbols, 1) ** 60
    for expression in (monster, sp.Add(*(sp.sin(s) for s in symbols)) ** 90 + monster.args[0] ** 2):
        assert is_zero(expression, budget=1.0) != Zero()


def test_an_expired_budget_gives_no_verdict_of_zero():
    assert not isinstance(is_zero(ZEROS["fraction"], budget=Budget(deadline=0.0)), Zero)


def test_division_by_a_hidden_zero_is_not_taken_for_zero():
    assert not isinstance(
        is_zero((x - x * (sp.sin(y) ** 2 + sp.cos(y) ** 2)) / (1 - sp.sin(y) ** 2 - sp.cos(y) ** 2)), Zero
    )


# ------------------------------------------------------------ enclosures

FUNCTIONS = [
    sp.sin, sp.cos, sp.tan, sp.cot, sp.sec, sp.csc, sp.sinh, sp.cosh, sp.tanh, sp.coth, sp.sech, sp.csch, sp.exp,
    sp.log, sp.Abs, sp.sign, sp.atan, sp.asin, sp.acos, sp.asinh, sp.acosh, sp.atanh, sp.sqrt, lambda z:
    z**sp.Rational(5, 3), lambda z: z**-3, lambda z: z**sp.Rational(-3, 2), lambda z: sp.pi * z + sp.E,
]  # fmt: skip


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("place", [sp.Rational(2, 7), sp.Rational(9, 4), sp.Rational(-5, 3)])
def test_an_enclosure_contains_the_value_and_is_narrow(function, place):
    value = function(place).evalf(80)
    if not value.is_real:
        with pytest.raises(NoEnclosureError):
            enclose(function(x), {x: place}, 100)
        return
    lower, upper = enclose(function(x), {x: place}, 100)
    with mpmath.workdps(60):
        exact = mpmath.mpf(str(value))
        assert lower <= exact <= upper
        assert upper - lower <= abs(exact) * mpmath.mpf(2) ** -90


def test_a_pole_and_an_unknown_function_have_no_enclosure():
    for expression in (1 / (x - x), 1 / (x - 2), sp.log(x - 3), sp.gamma(x)):
        with pytest.raises(NoEnclosureError):
            enclose(sp.sympify(expression), {x: sp.Integer(2)}, 64) if expression != sp.nan else enclose(sp.zoo, {}, 64)


# ------------------------------------------------------------ exact arithmetic

COEFFICIENTS = st.integers(-6, 6)
MONOMIALS = st.tuples(st.integers(0, 3), st.integers(0, 3), st.integers(0, 2))
POLYNOMIALS = st.dictionaries(MONOMIALS, COEFFICIENTS, max_size=6)


def packed(terms):
    return {sum(e << (poly.BITS * k) for k, e in enumerate(m)): c for m, c in terms.items() if c}


def as_sympy(a):
    symbols = (x, y, t)
    return sp.Add(*(c * sp.Mul(*(symbols[k] ** e for k, e in poly.exponents(m))) for m, c in a.items()))


@given(POLYNOMIALS, POLYNOMIALS)
def test_polynomial_arithmetic_agrees_with_sympy(first, second):
    a, b = packed(first), packed(second)
    product = poly.mul(a, b, Budget())
    assert sp.expand(as_sympy(product) - as_sympy(a) * as_sympy(b)) == 0
    assert sp.expand(as_sympy(poly.add(a, b, -3)) - as_sympy(a) + 3 * as_sympy(b)) == 0
    for k, s in enumerate((x, y, t)):
        assert sp.expand(as_sympy(poly.partial(a, k)) - as_sympy(a).diff(s)) == 0


@given(POLYNOMIALS, POLYNOMIALS, COEFFICIENTS.filter(bool))
def test_division_is_exact_or_refused(first, second, extra):
    a, b = packed(first), packed(second)
    if not a or not b:
        return
    product, guard = poly.mul(a, b, Budget()), poly.guard_bits(3)
    assert poly.exact_quotient(product, b, guard, Budget()) == a
    disturbed = poly.add(product, {0: extra})
    quotient = poly.exact_quotient(disturbed, b, guard, Budget()) if disturbed else None
    if quotient is not None:
        assert sp.expand(as_sympy(quotient) * as_sympy(b) - as_sympy(disturbed)) == 0


EXPRESSIONS = [
    sp.sqrt(x**2 + y**2 + 1) / sp.sin(x),
    sp.log(x**2 + y**2 + 2) * sp.exp(3 * x - y / 2),
    sp.asin(x / 5) + sp.atanh(x / 5) * sp.acosh(u + 2),
    (u - v / 7) ** sp.Rational(3, 2) / (u + v),
    sp.sqrt(25 - x**2) * sp.tan(x * y) + sp.Abs(x - 9),
    u**n * sp.cosh(x + u) / (1 + sp.coth(u)),
    sp.cbrt(u * v**2 + 1) - sp.sech(x) ** 3 + sp.csc(y) * sp.cot(x),
]
HERE = {x: sp.Rational(3, 7), y: sp.Rational(8, 5), u: sp.Rational(5, 3), v: sp.Rational(2, 9), n: sp.Rational(7, 4)}


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_reading_writing_and_differentiating_keep_the_value(expression):
    reader = Reader([expression])
    element = reader.element(expression)
    pairs = [(reader.write(element), expression)]
    pairs += [(reader.write(reader.diff(element, s)), expression.diff(s)) for s in expression.free_symbols]
    pairs += [
        (reader.write(reader.log_diff(element, s)), expression.diff(s) / expression) for s in expression.free_symbols
    ]
    for ours, theirs in pairs:
        difference, value = (ours - theirs).evalf(50, subs=HERE), theirs.evalf(50, subs=HERE)
        assert abs(difference) < 1e-44 * (1 + abs(value))


def test_signs_are_proved_on_the_domain_only():
    w = sp.Symbol("w", real=True)
    root = sp.sqrt((w - a) ** 2 * (w + a))
    inside = Reader([root], {w: (a, None)})
    assert inside.element(root - (w - a) * sp.sqrt(w + a)).is_zero
    below = Reader([root], {w: (-a, a)})
    assert below.element(root - (a - w) * sp.sqrt(w + a)).is_zero
    anywhere = Reader([root], {w: (None, None)})
    assert not anywhere.element(root - (w - a) * sp.sqrt(w + a)).is_zero
    assert not anywhere.element(root + (w - a) * sp.sqrt(w + a)).is_zero


def test_a_sign_that_changes_inside_the_domain_is_not_used():
    w = sp.Symbol("w", real=True)
    for low in (sp.Rational(-1, 2), sp.Rational(-1, 1000)):
        reader = Reader([w], {w: (low, None)})
        assert not reader.element(sp.sqrt((w + w**3) ** 2) - w - w**3).is_zero
    assert Reader([w], {w: (sp.S.Zero, None)}).element(sp.sqrt((w + w**3) ** 2) - w - w**3).is_zero


def test_the_filter_modulo_primes_respects_all_relations():
    expression = sp.sqrt(x**2 + y**2) * sp.cbrt(u) * sp.sin(x) * sp.cosh(y)
    reader = Reader([expression])
    e = reader.element(expression)
    assert products_vanish(reader.field, [[e, e], [-reader.element(sp.expand(expression**2))]]) is True
    assert products_vanish(reader.field, [[e, e], [-reader.element(sp.expand(expression**2) + x)]]) is False


def test_floats_are_the_binary_numbers_they_are():
    reader = Reader([x])
    assert reader.element(sp.Float(0.1)).coefficient == Fraction(0.1)
    assert is_zero(sp.Float(0.5) * x - x / 2) == Zero()
