"""Guarded arithmetic: sums, products, powers and functions of sympy expressions that stay real, finite and small.

Beside each expression the value of a constant is carried at 60 digits, so that a division by zero, a logarithm of a
negative number or 9**9**9 is found *before* sympy sees it; and three sizes, so that nothing is built that sympy would
take long to look at: the number of terms when expanded, how deep functions and roots nest, and the exponents.
Every function takes ``fail``, which makes the error to raise from a message.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import ceil, comb, prod
from typing import NamedTuple

import mpmath
import sympy as sp
from mpmath import libmp

from hjsolve.errors import ExpressionError
from hjsolve.formulas.polar_angle import MAX_MULTIPLE, angle_of_point, largest_multiple
from hjsolve.formulas.tokens import MAX_DIGITS
from hjsolve.precision import multiprecision

MAX_BITS = 7_000
MAX_EXPONENT = 100
MAX_NESTING = 3
MAX_DEGREE_OF_ARGUMENT = 24
MAX_TERMS = 5_000
_MAX_EXPONENT_UNPROVED = 10
_MAX_DENOMINATOR = 10**12
_MAX_ROOT_BITS = 350
_MAX_TERMS_OF_POWER = 500
_MAX_ANGLE = 10**15
_MAX_LOGARITHM = 2_500
_OF_LOGARITHMS = frozenset({"exp", "sinh", "cosh", "tanh", "coth", "sech", "csch"})
_CONTEXT = multiprecision(libmp.dps_to_prec(60))
_HUGE = _CONTEXT.mpf(10) ** MAX_DIGITS
_TINY = 1 / _HUGE
_VANISHING = _CONTEXT.mpf(10) ** -40

Fail = Callable[[str], ExpressionError]

FUNCTIONS: dict[str, Callable[[sp.Expr], sp.Expr]] = {
    "sin": sp.sin,
    "cos": sp.cos,
    "tan": sp.tan,
    "cot": lambda x: sp.cos(x) / sp.sin(x),
    "sec": lambda x: 1 / sp.cos(x),
    "csc": lambda x: 1 / sp.sin(x),
    "asin": sp.asin,
    "acos": sp.acos,
    "atan": sp.atan,
    "sinh": sp.sinh,
    "cosh": sp.cosh,
    "tanh": sp.tanh,
    "coth": lambda x: sp.cosh(x) / sp.sinh(x),
    "sech": lambda x: 1 / sp.cosh(x),
    "csch": lambda x: 1 / sp.sinh(x),
    "asinh": sp.asinh,
    "acosh": sp.acosh,
    "atanh": sp.atanh,
    "exp": sp.exp,
    "log": sp.log,
    "sqrt": sp.sqrt,
    "cbrt": sp.cbrt,
}


class Node(NamedTuple):
    """A subexpression.

    Attributes:
        expression: in sympy.
        value: at 60 digits where it is constant, else None.
        terms: upper bound of the number of its terms when its numerators are expanded.
        below: the same for its denominators.
        nesting: how deep functions, roots and variable powers nest in it.
        degree: upper bound of its degree as a polynomial in names and functions.
    """

    expression: sp.Expr
    value: mpmath.mpf | None = None
    terms: int = 1
    nesting: int = 0
    degree: int = 0
    below: int = 1


def leaf(expression: sp.Expr) -> Node:
    """Return the node of a name or a constant.

    Args:
        expression: a symbol, or a constant without arguments.
    """
    return Node(expression, degree=1) if expression.free_symbols else Node(expression, _value(expression))


def literal(text: str, fail: Fail) -> Node:
    """Return the exact rational that an integer or a decimal spells.

    Args:
        text: as scanned.
        fail: makes the error of a message, with the place in the text.
    """
    exact = Fraction(text)
    return _checked(Node(sp.Rational(exact.numerator, exact.denominator)), fail)


def negative(node: Node) -> Node:
    """Return −a.

    Args:
        node: a, with its value where it has one.
    """
    return node._replace(expression=-node.expression, value=None if node.value is None else -node.value)


def total(nodes: Sequence[Node], fail: Fail) -> Node:
    """Return the sum a + b + …, in one step.

    Args:
        nodes: the terms.
        fail: makes the error of a message, with the place in the text.
    """
    if all(n.expression.is_Rational for n in nodes):
        return _checked(Node(sum((n.expression for n in nodes), sp.S.Zero)), fail)
    value = None if any(n.value is None for n in nodes) else _CONTEXT.fsum(n.value for n in nodes)
    terms, nesting, degree = sum(n.terms for n in nodes), max(n.nesting for n in nodes), max(n.degree for n in nodes)
    below = max(n.below for n in nodes)
    return _checked(Node(sp.Add(*(n.expression for n in nodes)), value, terms, nesting, degree, below), fail)


def product(nodes: Sequence[Node], fail: Fail) -> Node:
    """Return the product a·b·…, in one step.

    Args:
        nodes: the factors.
        fail: makes the error of a message, with the place in the text.
    """
    if all(n.expression.is_Rational for n in nodes):
        return _checked(Node(prod((n.expression for n in nodes), start=sp.S.One)), fail)
    value = None if any(n.value is None for n in nodes) else _CONTEXT.fprod(n.value for n in nodes)
    terms, nesting, degree = prod(n.terms for n in nodes), max(n.nesting for n in nodes), sum(n.degree for n in nodes)
    below = prod(n.below for n in nodes)
    _check_sizes(max(terms, below), nesting, fail)
    return _checked(Node(sp.Mul(*(n.expression for n in nodes)), value, terms, nesting, degree, below), fail)


def reciprocal(node: Node, fail: Fail) -> Node:
    """1/a.

    Args:
        node: a.
        fail: makes the error of a message, with the place in the text.

    Raises:
        ExpressionError: a is zero, or 1/a is beyond the limits of a formula.
    """
    if node.expression.is_zero:
        raise fail("a division by zero")
    return power(node, leaf(sp.S.NegativeOne), fail)


def power(base: Node, exponent: Node, fail: Fail) -> Node:
    """a**b.

    Args:
        base, exponent: a and b.
        fail: makes the error of a message, with the place in the text.

    Raises:
        ExpressionError: the power is not real, or beyond the limits of a formula (terms, degree, nesting, size).
    """
    n = exponent.value
    _check_base(base, n, fail)
    if n is not None:
        _check_exponent(base, exponent, n, fail)
    else:
        _check_numbers(exponent, fail)
    value = None
    if base.value is not None and n is not None:
        whole = int(n) if exponent.expression.is_Integer else n
        value = _within(_defined(lambda: _CONTEXT.power(base.value, whole), "this power", fail), fail)
    terms, below = (
        (1 if x == 1 else x if n is None else comb(x + int(abs(n)) - 1, int(abs(n)))) for x in (base.terms, base.below)
    )
    if terms > max(_MAX_TERMS_OF_POWER, base.terms) or below > max(_MAX_TERMS_OF_POWER, base.below):
        raise fail(f"expanded, this power has more than {_MAX_TERMS_OF_POWER} terms")
    nesting, degree = max(base.nesting, exponent.nesting), base.degree if n is None else ceil(base.degree * abs(n))
    if not exponent.expression.is_Integer:
        nesting += 1
        _check_argument(base, fail)
        _check_argument(exponent, fail)
    _check_sizes(max(terms, below), nesting, fail)
    if n is not None and n < 0:
        terms, below = below, terms
    expression = _built(lambda: sp.Pow(base.expression, exponent.expression), "this power", fail)
    return _checked(Node(expression, value, terms, nesting, degree, below), fail)


def call(name: str, argument: Node, fail: Fail) -> Node:
    """One of ``FUNCTIONS``.

    Args:
        argument: what it is taken of.
        fail: makes the error of a message, with the place in the text.

    Raises:
        ExpressionError: the value is not real, or beyond the limits of a formula (argument, nesting, size).
    """
    if name == "sqrt":
        return power(argument, leaf(sp.S.Half), fail)
    if name == "cbrt":
        if argument.value is not None and argument.value < 0:
            return negative(call(name, negative(argument), fail))
        return power(argument, leaf(sp.Rational(1, 3)), fail)
    value = None
    if argument.value is not None:
        if abs(argument.value) > (_MAX_LOGARITHM if name in _OF_LOGARITHMS else _MAX_ANGLE) and name != "log":
            raise fail(f"the argument of {name} is too large")
        value = _within(_defined(lambda: getattr(_CONTEXT, name)(argument.value), name, fail), fail)
    elif name == "exp" and argument.expression.has(sp.log):
        _check_numbers(argument, fail)
    elif name == "log" and argument.expression.is_nonpositive:
        raise fail("log is not real here: its argument is never positive")
    _check_argument(argument, fail)
    if largest_multiple(argument.expression) > MAX_MULTIPLE:
        raise fail(f"multiples of atan2 beyond {MAX_MULTIPLE} cannot stand inside a function")
    _check_sizes(1, argument.nesting + 1, fail)
    expression = _built(lambda: FUNCTIONS[name](argument.expression), name, fail)
    return _checked(Node(expression, value, 1, argument.nesting + 1, 0 if value is not None else 1), fail)


def absolute_value(node: Node) -> Node:
    """Return |a|, which only V may keep outside a real root; the parser refuses it elsewhere."""
    return node._replace(expression=sp.Abs(node.expression), value=None if node.value is None else abs(node.value))


def sign_of(node: Node) -> Node:
    """sign(a), which only V may keep."""
    value = None if node.value is None else _CONTEXT.sign(node.value)
    return node._replace(expression=sp.sign(node.expression), value=value)


def polar_angle(y: Node, x: Node, fail: Fail) -> Node:
    """atan2(y, x), the angle of the point (x, y) in (−π, π].

    Args:
        y, x: the coordinates of the point, in the order of the C library.
        fail: makes the error of a message, with the place in the text.

    Raises:
        ExpressionError: both are zero, or beyond the limits of a formula (argument, nesting, size).
    """
    if y.expression.is_zero and x.expression.is_zero:
        raise fail("atan2(0, 0) has no value")
    value = None
    if y.value is not None and x.value is not None:
        value = _within(_CONTEXT.atan2(y.value, x.value), fail)
    for argument in (y, x):
        _check_argument(argument, fail)
    nesting = max(y.nesting, x.nesting) + 1
    _check_sizes(1, nesting, fail)
    expression = _built(lambda: angle_of_point(y.expression, x.expression), "atan2", fail)
    return _checked(Node(expression, value, 1, nesting, 0 if value is not None else 1), fail)


def _check_base(base: Node, n: mpmath.mpf | None, fail: Fail) -> None:
    if base.expression.is_zero and not (n is not None and n >= 0):
        raise fail("zero to a negative or variable power has no value")
    if base.value is None:
        return
    if n is None and base.value < 0:
        raise fail("a negative number to a variable power is not real")
    if n is not None and n < 0 and abs(base.value) < _VANISHING and not base.expression.is_Rational:
        raise fail("a division by a number that cannot be distinguished from zero")


def _check_exponent(base: Node, exponent: Node, n: mpmath.mpf, fail: Fail) -> None:
    if exponent.expression.is_Rational and exponent.expression.q > _MAX_DENOMINATOR:
        raise fail("an exponent may have at most 12 decimals")
    bits = _bits(base.expression.as_coeff_Mul()[0])
    if bits > 1 and bits * abs(n) > MAX_BITS:
        raise fail(f"the power is beyond 1e±{MAX_DIGITS}; choose other units")
    if base.expression.is_Rational:
        return
    if abs(n) > MAX_EXPONENT:
        raise fail(f"exponents beyond ±{MAX_EXPONENT} are not accepted")
    if abs(n) > _MAX_EXPONENT_UNPROVED and base.value is None and not base.expression.is_extended_real:
        raise fail(f"exponents beyond ±{_MAX_EXPONENT_UNPROVED} need a base that is real on the whole domain")


def _check_argument(node: Node, fail: Fail) -> None:
    if _bits(node.expression) > _MAX_ROOT_BITS:
        raise fail("a number with more than 100 digits cannot stand inside a function, a root or an exponent")
    if node.degree > MAX_DEGREE_OF_ARGUMENT:
        raise fail(f"powers beyond {MAX_DEGREE_OF_ARGUMENT} cannot stand inside a function, a root or an exponent")


def _check_numbers(exponent: Node, fail: Fail) -> None:
    """Check a number n in a variable exponent, which may become the power aⁿ."""
    if any(abs(number) > MAX_EXPONENT for number in exponent.expression.atoms(sp.Rational)):
        raise fail(f"exponents beyond ±{MAX_EXPONENT} are not accepted")


def _check_sizes(terms: int, nesting: int, fail: Fail) -> None:
    if terms > MAX_TERMS:
        raise fail(f"expanded, this has more than {MAX_TERMS} terms")
    if nesting > MAX_NESTING:
        raise fail(f"functions and roots nest deeper than {MAX_NESTING} levels")


def _defined(compute: Callable[[], mpmath.mpf], what: str, fail: Fail) -> mpmath.mpf:
    """Return a constant's value, or the error that says why it has none."""
    try:
        value = compute()
    except (ValueError, ZeroDivisionError, OverflowError, libmp.NoConvergence):
        raise fail(f"{what} has no finite value here") from None
    if isinstance(value, _CONTEXT.mpc):
        raise fail(f"{what} is not real here")
    if not _CONTEXT.isfinite(value):
        raise fail(f"{what} has no finite value here")
    return value


def _built(compute: Callable[[], sp.Expr], what: str, fail: Fail) -> sp.Expr:
    """Return what sympy makes of it; its automatic evaluation fails on constants that look like a pole."""
    try:
        return compute()
    except (ArithmeticError, AttributeError, TypeError, ValueError, NotImplementedError, RecursionError):
        raise fail(f"{what} cannot be evaluated here; simplify its argument") from None


def _within(value: mpmath.mpf, fail: Fail) -> mpmath.mpf:
    if value and not _TINY <= abs(value) <= _HUGE:
        raise fail(f"the number is beyond 1e±{MAX_DIGITS}; choose other units")
    return value


def _checked(node: Node, fail: Fail) -> Node:
    """Return the node, once it is finite, real and of a size that can be worked with."""
    expression, value = node.expression, node.value
    if expression.is_Rational and _bits(expression) <= MAX_BITS:  # nothing else can be wrong with a number
        return Node(expression, _within(_value(expression), fail))
    if expression.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
        raise fail("the value is not finite (a division by zero, or a pole)")
    if expression.has(sp.I):
        raise fail("the value is not real")
    if _bits(expression.as_coeff_Mul()[0]) > MAX_BITS:
        raise fail(f"the number is beyond 1e±{MAX_DIGITS}; choose other units")
    if any(map(_is_high_power, sp.Mul.make_args(expression))):
        raise fail(f"exponents beyond ±{MAX_EXPONENT} are not accepted")
    if value is not None:
        _within(value, fail)
    _check_sizes(max(node.terms, node.below), node.nesting, fail)
    return node


def has_absolute_value(expression: sp.Expr) -> bool:
    """Return whether an absolute value occurs in it, other than in a real root such as (x**2)**(1/3) = |x|**(2/3)."""
    roots = {e: sp.S.One for e in expression.atoms(sp.Pow) if isinstance(e.base, sp.Abs) and e.exp.is_integer is False}
    return bool(expression.xreplace(roots).has(sp.Abs, sp.sign, sp.arg, sp.re, sp.im))


def _value(expression: sp.Expr) -> mpmath.mpf:
    """Return the value of a constant at 60 digits."""
    if expression.is_Rational:
        return _CONTEXT.mpf(int(expression.p)) / int(expression.q)
    return _CONTEXT.convert(expression.evalf(60))


def _is_high_power(factor: sp.Expr) -> bool:
    return bool(factor.is_Pow and factor.exp.is_Rational and abs(factor.exp) > MAX_EXPONENT and factor.free_symbols)


def _bits(expression: sp.Expr) -> int:
    if not expression.is_Rational:
        return 0
    return max(int(expression.p).bit_length(), int(expression.q).bit_length())
