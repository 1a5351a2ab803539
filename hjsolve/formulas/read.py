"""What a user writes → exact sympy expressions: formulas as text, formulas as sympy, and numbers of every kind.

Nothing here evaluates text as Python. A formula in text goes through the parser of ``hjsolve.formulas.parser``; a sympy
expression is taken over node by node, symbols matched by name; a number becomes the exact real number it is.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from hjsolve.arguments import ascii_name
from hjsolve.errors import ExpressionError
from hjsolve.formulas.checked_arithmetic import FUNCTIONS, MAX_BITS, has_absolute_value
from hjsolve.formulas.parser import Parser
from hjsolve.formulas.polar_angle import without_polar_angles
from hjsolve.formulas.tokens import MAX_DIGITS, FormulaText, coordinate_of_velocity, instead_of_word, printable, scan

_ARITHMETIC: tuple[type, ...] = (sp.Symbol, sp.Add, sp.Mul, sp.Pow, type(sp.pi), type(sp.E))
_ELEMENTARY: tuple[type, ...] = (sp.exp, sp.log, sp.sin, sp.cos, sp.tan, sp.asin, sp.acos, sp.atan, sp.atan2, sp.Abs)
_HYPERBOLIC: tuple[type, ...] = (sp.sinh, sp.cosh, sp.tanh, sp.asinh, sp.acosh, sp.atanh)
_KINKED: tuple[type, ...] = (
    sp.sign, sp.Heaviside, sp.Piecewise, sp.functions.elementary.piecewise.ExprCondPair, sp.Max, sp.Min,
    sp.core.relational.Relational, sp.logic.boolalg.Boolean,
)  # fmt: skip
_KNOWN = _ARITHMETIC + _ELEMENTARY + _HYPERBOLIC
_NO_VELOCITIES: Mapping[str, sp.Symbol] = {}
_NO_FUNCTIONS: Mapping[str, sp.Expr] = {}
_MAX_PLACES = 4 * MAX_DIGITS
_TOO_LARGE = Fraction(2) ** (MAX_BITS + 1)
MAX_NODES = 20_000


def parse(
    text: str,
    names: Mapping[str, sp.Expr],
    *,
    velocities: Mapping[str, sp.Symbol] = _NO_VELOCITIES,
    functions: Mapping[str, sp.Expr] = _NO_FUNCTIONS,
    kinks: bool = False,
    source: str,
) -> sp.Expr:
    """Read a formula.

    Args:
        text: the formula, in ASCII and Greek letters; ``dot(q)``, ``q'`` and ``qdot`` are a velocity, ``pi`` the
            constant, ``**`` and ``^`` a power.
        names: the names that may occur and what they stand for; symbols are taken to be real.
        velocities: what ``dot(q)`` stands for, by the name of the coordinate; none are accepted when left out.
        functions: functions left undetermined, name → ``v1(r)`` as it must be written.
        kinks: whether absolute values and signs, abs(x) and sign(x), may occur.
        source: what the text is called in an error, e.g. ``potential``.

    Returns:
        The formula with exact numbers: a decimal is the rational it spells.

    Raises:
        ExpressionError: the text is not such a formula; the message says where, and what to write instead.

    Example:
        >>> parse("-k/r + 0.1*r**2", {"k": sp.Symbol("k"), "r": sp.Symbol("r")}, source="potential")
        -k/r + r**2/10
    """
    if not isinstance(text, str):
        raise ExpressionError(f"{source}: expected a text, got {type(text).__name__}", source=source)
    given = FormulaText(source, text)
    return Parser(given, scan(given), names, velocities, functions, kinks=kinks).formula()


def formula_of(given: object, names: Mapping[str, sp.Expr], *, source: str) -> sp.Expr:
    """Read a formula that came as text, as a number or as an expression of sympy.

    Args:
        names: the names that may occur and what they stand for.
        source: what it is called in an error.

    Raises:
        ExpressionError: it is none of these, or holds what ``parse`` would not accept.
    """
    if isinstance(given, str):
        return parse(given, names, source=source)
    if not isinstance(given, sp.Expr | int | float):
        raise ExpressionError(f"{source}: a formula is needed, as text or of sympy, not {type(given).__name__}")
    return admit(sp.sympify(given), names, source=source)


def admit(
    expression: sp.Expr,
    names: Mapping[str, sp.Expr],
    *,
    velocities: Mapping[str, sp.Symbol] = _NO_VELOCITIES,
    kinks: bool = False,
    source: str,
) -> sp.Expr:
    """Take over a sympy expression: symbols are matched by name, floats become the exact numbers they are.

    Args:
        expression: sums, products, powers and the functions of ``parse``; a velocity is ``Symbol("dot(q)")`` or, with
            coordinates that are functions of the time as of ``dynamicsymbols``, ``Derivative(q(t), t)``.
        names: the names that may occur and what they stand for.
        velocities: what ``Symbol("dot(q)")`` stands for, by the name of the coordinate.
        kinks: whether absolute values, signs and pieces may occur.
        source: what the expression is called in an error.

    Returns:
        The same expression in the symbols of ``names`` and ``velocities``.

    Raises:
        ExpressionError: it holds an undeclared symbol or something ``parse`` would not accept.
    """
    known = {**names, **{f"dot({name})": symbol for name, symbol in velocities.items()}}
    replaced: dict[sp.Basic, sp.Basic] = {}
    nodes = sp.preorder_traversal(expression)
    for count, node in enumerate(nodes):
        if count > MAX_NODES:
            raise ExpressionError(f"{source}: the expression has more than {MAX_NODES} nodes", source=source)
        if isinstance(node, sp.Symbol):
            replaced[node] = _declared(node, known, velocities, source, expression)
        elif isinstance(node, (sp.Derivative, AppliedUndef)) and not _is_undetermined(node, known):
            replaced[node] = _of_time(node, names, velocities, source)
            nodes.skip()
        elif isinstance(node, sp.Float):
            replaced[node] = sp.Rational(node)
        elif kinks and isinstance(node, _KINKED):
            continue
        elif not node.is_Rational and not isinstance(node, _KNOWN):
            _check_node(node, source, known)
    taken_over = expression.xreplace(replaced).replace(_is_reciprocal, _as_quotient)
    return _real(without_polar_angles(taken_over), source, kinks=kinks)


def _declared(
    symbol: sp.Symbol,
    known: Mapping[str, sp.Expr],
    velocities: Mapping[str, sp.Symbol],
    source: str,
    expression: sp.Expr,
) -> sp.Expr:
    name = ascii_name(symbol.name)
    if name in known:
        return known[name]
    coordinate = coordinate_of_velocity(name, velocities)
    if coordinate:
        return velocities[coordinate]
    names = [known_name for known_name in known if known_name.isidentifier()]
    raise _refused(source, instead_of_word(symbol.name, names, velocities, FUNCTIONS), expression)


def _of_time(node: sp.Basic, names: Mapping[str, sp.Expr], velocities: Mapping[str, sp.Symbol], source: str) -> sp.Expr:
    """Return the symbol of q(t) or of Derivative(q(t), t), where q is a coordinate and t no declared name."""
    derived = isinstance(node, sp.Derivative)
    inner = node.args[0] if derived else node
    times = {variable for variable, _ in node.variable_count} if derived else set(node.args)
    name = ascii_name(inner.func.__name__) if isinstance(inner, AppliedUndef) else ""
    time = next(iter(times))
    if len(times) > 1 or not isinstance(time, sp.Symbol) or time.name in names or inner.args != (time,) or not name:
        raise _refused(source, "a derivative of a coordinate q is Derivative(q(t), t), with nothing else in it", node)
    if name not in names:
        raise _refused(source, instead_of_word(name, names, velocities, FUNCTIONS), node)
    if name not in velocities and (derived or velocities):
        raise _refused(source, f"{name} is not a coordinate here, so it does not depend on {time}; write {name}", node)
    if derived and node.derivative_count > 1:
        raise _refused(source, "accelerations do not occur in T and V", node)
    return velocities[name] if derived else names[name]


def _check_node(node: sp.Basic, source: str, known: Mapping[str, sp.Basic]) -> None:
    if not (_is_reciprocal(node) or _is_undetermined(node, known)):
        raise _refused(source, f"{type(node).__name__} is not accepted; known are {', '.join(FUNCTIONS)}", node)


def _is_undetermined(node: sp.Basic, known: Mapping[str, sp.Basic]) -> bool:
    """Return whether the node is a function left undetermined, f(r), of declared names; q(t) is not."""
    if not isinstance(node, AppliedUndef) or node.func.__name__ in known:
        return False
    return all(symbol.name in known for symbol in node.free_symbols)


def _is_reciprocal(node: sp.Basic) -> bool:
    return isinstance(node, (sp.cot, sp.sec, sp.csc, sp.coth, sp.sech, sp.csch))


def _as_quotient(node: sp.Expr) -> sp.Expr:
    return FUNCTIONS[type(node).__name__](node.args[0])


def _real(expression: sp.Expr, source: str, *, kinks: bool = False) -> sp.Expr:
    if expression.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
        raise _refused(source, "the value is not finite", expression)
    if expression.has(sp.I):
        raise _refused(source, "the value is not real", expression)
    if not kinks and has_absolute_value(expression):
        raise _refused(source, "absolute values are not accepted; they have no derivative at zero", expression)
    return expression


def _refused(source: str, message: str, what: object) -> ExpressionError:
    shown = printable(str(what))
    return ExpressionError(f"{source}: {message} (in {shown[:60]})", source=source, text=shown[:200])


def number(value: object, *, source: str) -> sp.Expr:
    """Make a number exact.

    Args:
        value: an int, a float (the exact binary number it is), a Fraction, a Decimal, an mpf, a numpy scalar, a real
            sympy number, or a text such as ``"1.2"``, ``"1/24"``, ``"pi/3"``, ``"sqrt(2)"``.
        source: what the number is called in an error, e.g. ``parameter k``.

    Returns:
        The same number, exact: a Rational, or a constant expression such as pi/3.

    Raises:
        ExpressionError: it is not one finite real number.

    Example:
        >>> number("0.1", source="k"), number(0.5, source="k"), number("pi/3", source="k")
        (1/10, 1/2, pi/3)
    """
    if isinstance(value, str):
        return parse(value, {}, source=source)
    if isinstance(value, sp.Expr):
        return _constant(admit(value, {}, source=source), source)
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        value = _alone(value, source)
    exact = _ratio(value)
    if exact is None:
        raise ExpressionError(f"{source}: expected one finite real number, got {_shown(value)}", source=source)
    if max(abs(exact.numerator).bit_length(), exact.denominator.bit_length()) > MAX_BITS:
        raise ExpressionError(f"{source}: the number is beyond 1e±{MAX_DIGITS}; choose other units", source=source)
    return sp.Rational(exact.numerator, exact.denominator)


def _alone(value: Any, source: str) -> object:
    """Return the number in an array of shape ().

    Raises:
        ExpressionError: a library that differentiates, as JAX, sees a variable in it: its number has no derivative.
    """
    alone = value.item()
    if isinstance(alone, float):
        try:
            float(value)
        except TypeError:
            raise ExpressionError(
                f"{source}: expected one finite real number, got {_shown(value)}", source=source
            ) from None
    return alone


def _shown(value: object) -> str:
    if isinstance(value, (bool, int, float, complex, Decimal)):
        return f"{type(value).__name__} {str(value)[:40]}"
    return f"{type(value).__name__}"


def _constant(expression: sp.Expr, source: str) -> sp.Expr:
    """Return the expression, once its value at 20 digits is a finite real number."""
    if expression.is_Rational:
        return expression
    value = expression.evalf(20)
    if not (value.is_Float and value.is_finite):
        raise _refused(source, "expected one finite real number", expression)
    return expression


def _ratio(value: object) -> Fraction | None:
    """Return the exact rational a number is; None for what is not a finite real number."""
    if isinstance(value, bool):
        return None
    if isinstance(value, numbers.Rational):
        return Fraction(int(value.numerator), int(value.denominator))
    if isinstance(value, Decimal):
        return _ratio_of_decimal(value)
    if hasattr(value, "_mpf_"):
        return _ratio_of_mpf(*value._mpf_)
    if isinstance(value, numbers.Real) and math.isfinite(value) and hasattr(value, "as_integer_ratio"):
        return Fraction(*map(int, value.as_integer_ratio()))
    return None


def _ratio_of_decimal(value: Decimal) -> Fraction | None:
    if not value.is_finite():
        return None
    _, digits, exponent = value.as_tuple()
    return Fraction(value) if abs(int(exponent)) + len(digits) <= _MAX_PLACES else _TOO_LARGE


def _ratio_of_mpf(sign: int, mantissa: int, exponent: int, bits: int) -> Fraction | None:
    """(−1)^sign · mantissa · 2^exponent, mpmath's own form; an infinity or nan has mantissa 0 and exponent ≠ 0."""
    if not mantissa:
        return Fraction(0) if not exponent else None
    if abs(exponent) + bits > 2 * MAX_BITS:
        return _TOO_LARGE
    return (-1) ** sign * int(mantissa) * Fraction(2) ** int(exponent)
