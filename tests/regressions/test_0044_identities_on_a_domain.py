"""Identities that are true on a domain came out undecided: half angles, logarithms of powers, inverse functions, numbers."""

import pytest
import sympy as sp

import hjsolve
from hjsolve.algebra.constants import NotAlgebraicError, algebraic_is_zero, constant_is_zero
from hjsolve.algebra.elementary import at_one_place
from hjsolve.algebra.one_variable import vanishes
from hjsolve.algebra.poly import Budget
from hjsolve.separation.zero_test.interval_evaluation import Region
from hjsolve.separation.zero_test.zero_test import NonZero, Zero, is_zero
from tests.support.random_identities import CONSTANTS, FAMILIES, identities
from tests.support.typed_identities import TYPED

pytestmark = pytest.mark.rotating_file(2)

x, y = sp.symbols("x y", real=True)
TAU = 2 * sp.pi


def read(text):
    return sp.sympify(text, {"x": x, "y": y}, rational=True)


ON_A_DOMAIN = [
    ("sqrt((1 - cos(x))/2) - sin(x/2)", (sp.S.Zero, TAU), (-TAU, sp.S.Zero)),
    ("log((x - 1)**2) - 2*log(1 - x)", (None, sp.S.One), None),
    ("atan((1 - x)/(1 + x)) + atan(x) - pi/4", (sp.S.Zero, None), (None, -sp.S.One)),
    ("acos(cos(x)) - x", (sp.S.Zero, sp.pi), (sp.pi, TAU)),
    ("sqrt(1 + sin(x)) - sin(x/2) - cos(x/2)", (-sp.pi / 2, 3 * sp.pi / 2), (3 * sp.pi / 2, 7 * sp.pi / 2)),
    ("sqrt(x - 2*sqrt(x - 1)) - sqrt(x - 1) + 1", (sp.Integer(2), None), (sp.S.One, sp.Integer(2))),
    ("asin(sqrt(1 - x**2)) - acos(x)", (sp.S.Zero, sp.S.One), (-sp.S.One, sp.S.Zero)),
    ("asinh(x) - log(x + sqrt(x**2 + 1))", (None, None), None),
    ("acosh(cosh(x)) - x", (sp.S.Zero, None), (None, sp.S.Zero)),
    ("2*atan(exp(x)) - pi/2 - atan(sinh(x))", (None, None), None),
]


@pytest.mark.parametrize(("text", "domain", "other"), ON_A_DOMAIN)
def test_an_identity_is_proved_on_its_domain_and_on_no_other(text, domain, other):
    assert isinstance(is_zero(read(text), Region({x: domain})), Zero)
    if other is not None:
        assert isinstance(is_zero(read(text), Region({x: other})), NonZero)
        assert isinstance(is_zero(read(text), Region({x: (None, None)})), NonZero)
    assert isinstance(is_zero(read(text) + sp.Rational(1, 10**25), Region({x: domain})), NonZero)
    assert not vanishes(read(text) + sp.Rational(1, 10**25), x, domain, Budget.seconds(5))


@pytest.mark.parametrize(
    ("text", "domain"),
    [
        ("x*y*(sqrt((1 - cos(x))/2) - sin(x/2))", "0 < x < 2*pi"),
        ("sin(y)*log((x - 1)**2) - 2*sin(y)*log(1 - x)", "x < 1"),
        ("x*y*atan((1 - x)/(1 + x)) + x*y*atan(x) - pi/4*x*y", "0 < x"),
        ("x*y*(acos(cos(x)) - x)", "0 < x < pi"),
        ("x*y*(4*atan(1/5) - atan(1/239) - pi/4)", "line"),
        ("x*y*(8*cos(2*pi/7)**3 + 4*cos(2*pi/7)**2 - 4*cos(2*pi/7) - 1)", "line"),
        ("x*y*(sinh(log(2)) - 3/4)", "line"),
        ("x*y*((2**(1/3) - 1)**(1/3) - (1/9)**(1/3) + (2/9)**(1/3) - (4/9)**(1/3))", "line"),
        ("sin(y)*(atan(x/y) + atan(y/x))", "0 < x"),
        ("x*y*(sqrt(x)*sqrt(y) - sqrt(x*y))", "line"),
    ],
)
def test_a_system_that_separates_by_such_an_identity_separates(text, domain):
    kinetic = "(dot(x)**2 + dot(y)**2)/2"
    system = hjsolve.System({"x": domain, "y": "0 < y"}, kinetic, f"{text} + x**2 + y**2")
    assert isinstance(hjsolve.separate(system), hjsolve.Separation)
    near = hjsolve.System({"x": domain, "y": "0 < y"}, kinetic, f"{text} + x**2 + y**2 + x*y/10**12")
    assert isinstance(hjsolve.separate(near), hjsolve.Obstruction)


@pytest.mark.parametrize("text", CONSTANTS)
def test_constants_are_decided_exactly_and_so_are_their_neighbours(text):
    assert constant_is_zero(at_one_place(read(text))) is True
    assert constant_is_zero(at_one_place(read(text) + sp.Rational(1, 10**30))) is not True
    assert constant_is_zero(at_one_place(read(text) + sp.pi)) is False


def test_the_separation_bound_lies_below_the_smallest_numbers_it_must_tell_from_zero():
    """√2 by its convergents: |p/q − √2| is about 1/q², and is never taken for zero."""
    p, q = 1, 1
    for _ in range(200):
        p, q = p + 2 * q, p + q
        assert not algebraic_is_zero(sp.Rational(p, q) - sp.sqrt(2))
    assert not algebraic_is_zero((sp.sqrt(2) - sp.Rational(p, q)) ** 4)
    with pytest.raises(NotAlgebraicError):
        algebraic_is_zero(sp.pi - 3)


def test_a_function_with_more_zeros_than_its_degree_suggests_is_not_zero():
    """Π (x − k) vanishes at many simple places; the count of places is above the number of its zeros."""
    product = sp.Mul(*(x - k for k in range(-12, 13)))
    assert not vanishes(sp.expand(product), x, (None, None), Budget.seconds(10))
    assert not vanishes(sp.sqrt(sp.expand(product**2) + 1) - 1, x, (None, None), Budget.seconds(10))


def test_what_is_defined_nowhere_is_not_called_zero_by_its_values():
    assert not vanishes(sp.sqrt(-1 - x**2) - sp.sqrt(-1 - x**2) * sp.sqrt(2) / 2, x, (None, None), Budget.seconds(5))


@pytest.mark.nightly
@pytest.mark.timeout(20)
def test_a_false_constant_of_nested_roots_is_refuted_at_once():
    """Squares of squares of the numbers in it had thousands of digits."""
    right, wrong = CONSTANTS[-1], CONSTANTS[-1].replace("- sqrt(5)", "+ sqrt(5)")
    assert isinstance(is_zero(read(right)), Zero)
    assert isinstance(is_zero(read(wrong)), NonZero)


@pytest.mark.parametrize(
    ("text", "domain"),
    [
        ("atan(x + 3) - acos(1/sqrt((x + 3)**2 + 1))", (None, None)),
        ("asin(3*x - 4*x**3) - 3*asin(x)", (None, -sp.Rational(1, 2))),
        ("sqrt((x - 40)**2) + x - 40", (None, None)),
        ("asin(x - 20) - atan(x)", (None, None)),
        ("log((x - pi)**2) - 2*log(x - pi) + asin(x - pi)", (sp.pi, None)),
    ],
)
def test_a_witness_is_looked_for_next_to_the_end_of_a_half_line_and_far_out(text, domain):
    assert isinstance(is_zero(read(text), Region({x: domain})), NonZero)


@pytest.mark.parametrize("templates", [FAMILIES, TYPED])
def test_random_identities_and_their_false_neighbours_are_never_mistaken(templates):
    decided = total = 0
    for known in identities(5, 30, templates):
        answer = is_zero(known.expression, Region(known.bounds), budget=4)
        assert not isinstance(answer, NonZero if known.true else Zero), known
        total += known.true
        decided += known.true and isinstance(answer, Zero)
    assert decided >= 0.7 * total
