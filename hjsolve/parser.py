"""The parser of formulas: tokens → sympy, by recursive descent over numbers, declared names and a list of functions.

The grammar is Python's for + - * / ** and brackets. Numbers are exact: a decimal is the rational it spells. While it
reads, the parser carries the value of every constant subexpression at 60 digits, so that a division by zero, a
logarithm of a negative number or 9**9**9 is found *before* sympy sees it, and it bounds depth, exponents and the
number of terms a formula would have when expanded, so that every text ends in a formula or in one error at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import comb

import mpmath
import sympy as sp

from hjsolve.tokens import MAX_DIGITS, Source, Token, instead_of_word, nearest

MAX_DEPTH = 50
MAX_EXPONENT = 100
MAX_TERMS = 100_000
MAX_BITS = 7_000
_MAX_ROOT_BITS = 350
_HUGE = mpmath.mpf(10) ** MAX_DIGITS
_CONTEXT = mpmath.MPContext()
_CONTEXT.dps = 60

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
RESERVED = frozenset({*FUNCTIONS, "pi", "dot"})


@dataclass(frozen=True)
class _Node:
    """A subexpression, its value where it is constant (else None), and its number of terms when expanded."""

    expression: sp.Expr
    value: mpmath.mpf | None
    terms: int = 1


class Parser:
    """Recursive descent over the tokens; one method for each level of Python's precedence."""

    def __init__(
        self, source: Source, tokens: list[Token], names: Mapping[str, sp.Expr], velocities: Mapping[str, sp.Symbol]
    ):
        self._source, self._tokens, self._names, self._velocities = source, tokens, names, velocities
        self._index, self._depth = 0, 0

    @property
    def _next(self) -> Token:
        return self._tokens[self._index]

    def _take(self, *texts: str) -> Token | None:
        token = self._next
        if token.kind == "operator" and token.text in texts:
            self._index += 1
            return token
        return None

    def formula(self) -> sp.Expr:
        """The whole text as one formula."""
        node = self._sum()
        if self._next.kind != "end":
            raise self._unexpected(self._next)
        return node.expression

    def _sum(self) -> _Node:
        start = self._next
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._source.error(f"brackets and powers nest deeper than {MAX_DEPTH} levels", start.position)
        nodes = [self._product()]
        while operator := self._take("+", "-"):
            node = self._product()
            nodes.append(node if operator.text == "+" else self._negative(node))
        self._depth -= 1
        if len(nodes) == 1:
            return nodes[0]
        values = [node.value for node in nodes]
        value = None if None in values else _CONTEXT.fsum(values)
        return self._checked(start, sp.Add(*(n.expression for n in nodes)), value, sum(n.terms for n in nodes))

    def _product(self) -> _Node:
        start = self._next
        nodes = [self._signed()]
        while operator := self._take("*", "/"):
            node = self._signed()
            nodes.append(node if operator.text == "*" else self._inverse(node, operator))
        if len(nodes) == 1:
            return nodes[0]
        values = [node.value for node in nodes]
        value = None if None in values else _CONTEXT.fprod(values)
        terms = 1
        for node in nodes:
            terms = min(terms * node.terms, MAX_TERMS + 1)
        return self._checked(start, sp.Mul(*(n.expression for n in nodes)), value, terms)

    def _signed(self) -> _Node:
        negative = False
        while sign := self._take("+", "-"):
            negative ^= sign.text == "-"
        node = self._power()
        return self._negative(node) if negative else node

    def _power(self) -> _Node:
        base = self._atom()
        operator = self._take("**")
        if operator is None:
            return base
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._source.error(f"brackets and powers nest deeper than {MAX_DEPTH} levels", operator.position)
        exponent = self._signed()
        self._depth -= 1
        return self._raised(base, exponent, operator)

    def _atom(self) -> _Node:
        token = self._next
        self._index += 1
        if token.kind == "number":
            return self._followed(self._checked(token, exact := sp.Rational(token.text), _value(exact)))
        if token.kind == "name":
            return self._named(token)
        if token.text == "(":
            node = self._sum()
            self._close(token)
            return self._followed(node)
        raise self._unexpected(token)

    def _named(self, token: Token) -> _Node:
        opened = self._next.text == "("
        if token.text in FUNCTIONS and token.text not in self._names:
            return self._call(token)
        if token.text == "dot" and opened:
            return self._velocity(token)
        if token.text in self._names:
            if opened:
                raise self._source.error(
                    f"{token.text} is not a function; write {token.text}*(...) for a product", token.position
                )
            expression = self._names[token.text]
            return self._followed(_Node(expression, None if expression.free_symbols else _value(expression)))
        if token.text == "pi":
            return self._followed(_Node(sp.pi, +_CONTEXT.pi))
        if opened and nearest(token.text, FUNCTIONS):
            near = nearest(token.text, FUNCTIONS)
            message = instead_of_word(token.text, [near], [], FUNCTIONS)
        else:
            message = instead_of_word(token.text, self._names, self._velocities, FUNCTIONS)
        raise self._source.error(message, token.position)

    def _velocity(self, token: Token) -> _Node:
        name, closing = self._tokens[self._index + 1 : self._index + 3]
        if not self._velocities:
            raise self._source.error("a velocity cannot stand here", token.position)
        if name.kind != "name" or closing.text != ")":
            raise self._source.error("dot takes the name of one coordinate, dot(q)", token.position)
        if name.text not in self._velocities:
            known = ", ".join(f"dot({q})" for q in self._velocities)
            raise self._source.error(f"{name.text!r} is not a coordinate; velocities are {known}", name.position)
        self._index += 3
        return self._followed(_Node(self._velocities[name.text], None))

    def _call(self, token: Token) -> _Node:
        opening = self._take("(")
        if opening is None:
            raise self._without_brackets(token)
        if self._next.text == ")":
            raise self._source.error(f"{token.text} needs an argument, {token.text}(x)", token.position)
        argument = self._sum()
        if self._next.text == ",":
            raise self._source.error(
                f"{token.text} takes one argument; a decimal comma is written as a point", self._next.position
            )
        self._close(opening)
        return self._followed(self._applied(token, argument))

    def _applied(self, token: Token, argument: _Node) -> _Node:
        if token.text in ("sqrt", "cbrt"):
            return self._root(token, argument)
        value = argument.value
        if value is not None:
            value = self._guarded(token, lambda: getattr(_CONTEXT, token.text)(value))
        elif token.text == "log" and argument.expression.is_nonpositive:
            raise self._source.error("log is not real here: its argument is never positive", token.position)
        return self._checked(token, FUNCTIONS[token.text](argument.expression), value)

    def _root(self, token: Token, argument: _Node) -> _Node:
        if token.text == "cbrt" and argument.value is not None and argument.value < 0:
            return self._negative(self._root(token, self._negative(argument)))
        degree = sp.Integer(2 if token.text == "sqrt" else 3)
        return self._raised(argument, _Node(1 / degree, _value(1 / degree)), token)

    def _negative(self, node: _Node) -> _Node:
        return _Node(-node.expression, None if node.value is None else -node.value, node.terms)

    def _inverse(self, node: _Node, operator: Token) -> _Node:
        return self._raised(node, _Node(sp.S.NegativeOne, _CONTEXT.mpf(-1)), operator)

    def _raised(self, base: _Node, exponent: _Node, operator: Token) -> _Node:
        power = exponent.value
        if base.expression.is_zero and not (power is not None and power >= 0):
            what = "a division by zero" if operator.text == "/" else "zero to this power has no value"
            raise self._source.error(what, operator.position)
        if base.value is None:
            terms = self._terms(base, exponent, operator)
            return self._checked(operator, sp.Pow(base.expression, exponent.expression), None, terms)
        if power is None:
            if base.value < 0:
                raise self._source.error("a negative number to a variable power is not real", operator.position)
            return self._checked(operator, sp.Pow(base.expression, exponent.expression), None)
        if power < 0 and abs(base.value) < 1 / _CONTEXT.mpf(10) ** 40 and not base.expression.is_Rational:
            raise self._source.error("a division by a number that cannot be told from zero", operator.position)
        bits = _bits(base.expression)
        if bits > _MAX_ROOT_BITS and not exponent.expression.is_Integer:
            raise self._source.error("the root of a number with so many digits is not accepted", operator.position)
        if bits * abs(power) > MAX_BITS and base.expression.is_Rational and bits > 1:
            raise self._source.error(f"the power is beyond 1e±{MAX_DIGITS}; choose other units", operator.position)
        exact = int(power) if exponent.expression.is_Integer else power
        value = self._guarded(operator, lambda: _CONTEXT.power(base.value, exact))
        return self._checked(operator, sp.Pow(base.expression, exponent.expression), value)

    def _terms(self, base: _Node, exponent: _Node, operator: Token) -> int:
        """Terms of (a₁ + … + aₙ)ᵏ when expanded: the binomial coefficient (n+k−1 over k)."""
        if exponent.value is None:
            return base.terms
        if abs(exponent.value) > MAX_EXPONENT:
            raise self._source.error(f"exponents beyond ±{MAX_EXPONENT} are not accepted", operator.position)
        return comb(base.terms + (k := int(abs(exponent.value))) - 1, k) if base.terms <= MAX_TERMS else base.terms

    def _guarded(self, token: Token, compute: Callable[[], mpmath.mpf]) -> mpmath.mpf:
        """A constant's value, or the error that says why it has none."""
        try:
            value = compute()
        except (ValueError, ZeroDivisionError, OverflowError, mpmath.libmp.NoConvergence):
            raise self._source.error(f"{token.text} has no finite value here", token.position) from None
        if isinstance(value, _CONTEXT.mpc):
            raise self._source.error(f"{token.text} is not real here", token.position)
        return value

    def _checked(self, token: Token, expression: sp.Expr, value: mpmath.mpf | None, terms: int = 1) -> _Node:
        """The node, once it is finite, real and of a size that can be worked with."""
        if expression.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
            raise self._source.error("the value is not finite (a division by zero, or a pole)", token.position)
        if expression.has(sp.I):
            raise self._source.error("the value is not real", token.position)
        if expression.has(sp.Abs, sp.sign, sp.arg, sp.re, sp.im):
            raise self._source.error(
                "this is an absolute value such as sqrt(x**2); write x, on a domain where it keeps its sign",
                token.position,
            )
        if expression.is_Rational:
            value = _value(expression)
        if (value and not 1 / _HUGE <= abs(value) <= _HUGE) or _bits(expression) > MAX_BITS:
            raise self._source.error(f"the number is beyond 1e±{MAX_DIGITS}; choose other units", token.position)
        if any(map(_is_high_power, sp.Mul.make_args(expression))):
            raise self._source.error(f"exponents beyond ±{MAX_EXPONENT} are not accepted", token.position)
        if terms > MAX_TERMS:
            raise self._source.error(f"expanded, this has more than {MAX_TERMS} terms", token.position)
        return _Node(expression, value, terms)

    def _close(self, opening: Token) -> None:
        if self._take(")"):
            return
        if self._next.kind == "end":
            raise self._source.error("this bracket is never closed", opening.position)
        raise self._unexpected(self._next)

    def _followed(self, node: _Node) -> _Node:
        """The node, unless what follows it shows that an operator was left out."""
        following = self._next
        if following.kind not in ("number", "name") and following.text != "(":
            return node
        before = self._tokens[self._index - 1]
        if before.kind == "number" and following.kind == "number":
            raise self._source.error("two numbers follow each other", following.position)
        left, right = ("(...)" if token.text in "()" else token.text[:40] for token in (before, following))
        raise self._source.error(f"an operator is missing; write {left}*{right} for a product", following.position)

    def _without_brackets(self, token: Token) -> Exception:
        following, name = self._next, token.text
        if following.text == "**":
            return self._source.error(f"write {name}(x)**2 for the power of a {name}", token.position)
        argument = following.text[:40] if following.kind in ("name", "number") else "x"
        return self._source.error(f"{name} needs brackets; write {name}({argument})", token.position)

    def _unexpected(self, token: Token) -> Exception:
        before = self._tokens[self._tokens.index(token) - 1] if token.position else token
        message = f"{token.text[:40]!r} cannot stand here; a number or a name is missing"
        if token.kind == "end":
            message = "the formula ends too early; a number, a name or a bracket is missing"
        elif token.text == ",":
            message = "a comma cannot stand here; a decimal comma is written as a point"
        elif token.text == ")" and (before.kind != "operator" or before.text == ")"):
            message = "this bracket was never opened"
        return self._source.error(message, token.position)


def _value(expression: sp.Expr) -> mpmath.mpf:
    """The value of a constant at 60 digits."""
    if expression.is_Rational:
        return _CONTEXT.mpf(int(expression.p)) / int(expression.q)
    return _CONTEXT.convert(expression.evalf(60))


def _is_high_power(factor: sp.Expr) -> bool:
    return bool(factor.is_Pow and factor.exp.is_Rational and abs(factor.exp) > MAX_EXPONENT and factor.free_symbols)


def _bits(expression: sp.Expr) -> int:
    if not expression.is_Rational:
        return 0
    return max(int(expression.p).bit_length(), int(expression.q).bit_length())
