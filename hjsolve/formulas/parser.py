"""The parser of formulas: tokens → sympy, by recursive descent over numbers, declared names and a list of functions.

The grammar is Python's for + - * / ** and brackets, with a velocity written ``dot(q)``, ``q'`` or ``qdot``, and a
product without its operator where no two readers would read it differently. Numbers are exact: a decimal is the
rational it spells. That what is built stays real, finite and small is checked in
``hjsolve.formulas.checked_arithmetic``.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.errors import ExpressionError
from hjsolve.formulas import checked_arithmetic
from hjsolve.formulas.checked_arithmetic import FUNCTIONS, Node
from hjsolve.formulas.polar_angle import without_polar_angles
from hjsolve.formulas.tokens import (
    FormulaText,
    Token,
    coordinate_of_velocity,
    instead_of_word,
    is_known_elsewhere,
    nearest_name,
)

MAX_DEPTH = 50
_ABSOLUTE_VALUES, _SIGNS = ("abs", "Abs", "fabs"), ("sign", "sgn")
RESERVED = frozenset({*FUNCTIONS, "pi", "dot"})


_NO_FUNCTIONS: Mapping[str, sp.Expr] = {}


class Parser:
    """Recursive descent over the tokens; one method for each level of Python's precedence."""

    def __init__(
        self,
        source: FormulaText,
        tokens: list[Token],
        names: Mapping[str, sp.Expr],
        velocities: Mapping[str, sp.Symbol],
        functions: Mapping[str, sp.Expr] = _NO_FUNCTIONS,
        *,
        kinks: bool = False,
    ):
        self._source, self._tokens, self._names, self._velocities = source, tokens, names, velocities
        self._functions, self._kinks = functions, kinks
        self._index, self._depth = 0, 0
        self._exponent = ""  # of the factor read last, where it is a power

    @property
    def _next(self) -> Token:
        return self._tokens[self._index]

    def _take(self, *texts: str) -> Token | None:
        token = self._next
        if token.kind == "operator" and token.text in texts:
            self._index += 1
            return token
        return None

    def _fail(self, token: Token) -> checked_arithmetic.Fail:
        return lambda message: self._source.error(message, token.position)

    def formula(self) -> sp.Expr:
        """Return the whole text as one formula.

        Raises:
            ExpressionError: the text goes on behind the formula, or is none.
        """
        node = self._sum()
        if self._next.kind != "end":
            raise self._unexpected(self._next)
        return without_polar_angles(node.expression)

    def _deeper(self, token: Token) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._source.error(f"brackets and powers nest deeper than {MAX_DEPTH} levels", token.position)

    def _sum(self) -> Node:
        start = self._next
        self._deeper(start)
        nodes = [self._product()]
        while operator := self._take("+", "-"):
            node = self._product()
            nodes.append(node if operator.text == "+" else checked_arithmetic.negative(node))
        self._depth -= 1
        return nodes[0] if len(nodes) == 1 else checked_arithmetic.total(nodes, self._fail(start))

    def _product(self) -> Node:
        """Return a product; a sign stays in front of it, so that -(a + b)*c does not become (-a - b)*c."""
        start, operator = self._next, None
        node, negative = self._signed()
        nodes = [node]
        while (following := self._take("*", "/")) or self._operator_is_left_out(operator):
            operator = following
            node, minus = self._signed() if operator else (self._power(), False)
            divides = operator is not None and operator.text == "/"
            nodes.append(checked_arithmetic.reciprocal(node, self._fail(operator or start)) if divides else node)
            negative ^= minus
        if len(nodes) == 1:
            return checked_arithmetic.negative(nodes[0]) if negative else nodes[0]
        sign = [checked_arithmetic.leaf(sp.S.NegativeOne)] if negative else []
        return self._smooth(checked_arithmetic.product([*sign, *nodes], self._fail(start)), start)

    def _operator_is_left_out(self, operator: Token | None) -> bool:
        """Return whether the factor read last is followed by another one without an operator, as in ``2 m g``.

        Args:
            operator: in front of the factor read last.

        Raises:
            ExpressionError: it is, and may be read as something else: 1/2 m, x^2y, x 2, f (x).
        """
        before, following = self._tokens[self._index - 1], self._next
        if following.kind not in ("number", "name") and following.text != "(":
            return False
        if before.kind == "number" and following.kind == "number":
            raise self._source.error("two numbers follow each other", following.position)
        if not self._names and following.kind == "name" and following.text not in {*FUNCTIONS, "pi"}:
            turn = following.text.lower().startswith("deg")
            cure = (
                f"write {before.text}*pi/180 for {before.text} degrees"
                if turn
                else "convert it to the units of the system"
            )
            raise self._source.error(f"a value is a number alone, without a unit; {cure}", following.position)
        left, right = ("(...)" if token.text in "()" else token.text[:40] for token in (before, following))
        message = f"an operator is missing; write {left}*{right} for a product"
        if operator is not None and operator.text == "/":
            message = f"this may be read in two ways; write /{left}*{right} or /({left}*{right})"
        elif self._exponent and not (self._exponent == "number" and self._blank_before(following)):
            message = f"this may be read in two ways; write **{left}*{right} or **({left}*{right})"
        elif self._is_a_factor(before, following):
            return True
        raise self._source.error(message, following.position)

    def _is_a_factor(self, before: Token, following: Token) -> bool:
        """Return whether a product is the only reading of two tokens: not of ``x 2``, ``f (x)`` or two lines."""
        opens = following.text == "(" and (before.kind == "number" or before.text == ")")
        same_line = "\n" not in self._source.text[before.position : following.position]
        return same_line and (opens or following.kind == "name")

    def _blank_before(self, token: Token) -> bool:
        return self._source.text[token.position - 1].isspace()

    def _signed(self) -> tuple[Node, bool]:
        """Return a factor without its signs, and whether they make it negative."""
        negative = False
        while sign := self._take("+", "-"):
            negative ^= sign.text == "-"
        return self._power(), negative

    def _power(self) -> Node:
        base = self._atom()
        operator = self._take("**")
        if operator is None:
            self._exponent = ""
            return base
        self._deeper(operator)
        first = self._next
        exponent, negative = self._signed()
        self._depth -= 1
        self._exponent = "number" if first.kind == "number" and self._tokens[self._index - 1] is first else "formula"
        return self._smooth(
            checked_arithmetic.power(
                base, checked_arithmetic.negative(exponent) if negative else exponent, self._fail(operator)
            ),
            operator,
        )

    def _smooth(self, node: Node, token: Token) -> Node:
        """Return a node, once it has no absolute value where none may stand."""
        if not self._kinks and checked_arithmetic.has_absolute_value(node.expression):
            message = "this is an absolute value such as sqrt(x**2); write x, on a domain where it keeps its sign"
            raise self._source.error(message, token.position)
        return node

    def _atom(self) -> Node:
        token = self._next
        self._index += 1
        if token.kind == "number":
            return checked_arithmetic.literal(token.text, self._fail(token))
        if token.kind == "name":
            return self._named(token)
        if token.text == "(":
            node = self._sum()
            self._close(token)
            return node
        self._index -= 1
        raise self._unexpected(token)

    def _named(self, token: Token) -> Node:
        opened = self._next.text == "("
        if token.text in self._names:
            if opened:
                message = f"{token.text} is not a function; write {token.text}*(...) for a product"
                raise self._source.error(message, token.position)
            return self._primed(token) if self._next.text == "'" else checked_arithmetic.leaf(self._names[token.text])
        if token.text in FUNCTIONS:
            return self._call(token)
        if token.text == "atan2" and opened:
            return self._polar_angle(token)
        if opened and (token.text in _ABSOLUTE_VALUES or (self._kinks and token.text in _SIGNS)):
            return self._root_of_square(token)
        if token.text == "dot" and opened:
            return self._velocity(token)
        if token.text == "pi":
            return checked_arithmetic.leaf(sp.pi)
        if token.text in self._functions:
            return self._undetermined(token)
        coordinate = "" if opened else coordinate_of_velocity(token.text, self._velocities)
        if coordinate:
            return checked_arithmetic.leaf(self._velocities[coordinate])
        near = nearest_name(token.text, [*FUNCTIONS, *self._functions]) if opened else ""
        names, speeds = ([near], []) if near else (list(self._names), list(self._velocities))
        message = instead_of_word(token.text, names, speeds, FUNCTIONS)
        argument, closing = ([*self._tokens, *self._tokens[-1:] * 2])[self._index + 1 : self._index + 3]
        free = opened and not near and not is_known_elsewhere(token.text)
        if free and self._velocities and argument.text in self._velocities and closing.text == ")":
            applied = f"{token.text}({argument.text})"
            message += f'; for a function left undetermined declare functions=["{applied}"]'
        raise self._source.error(message, token.position)

    def _undetermined(self, token: Token) -> Node:
        """Return a declared undetermined function, with the arguments it was declared with."""
        declared = self._functions[token.text]
        written = [t for argument in declared.args for t in (str(argument), ",")][:-1]
        tokens = [t.text for t in self._tokens[self._index : self._index + len(written) + 2]]
        if tokens != ["(", *written, ")"]:
            raise self._source.error(f"{token.text} is declared as {declared}; write {declared}", token.position)
        self._index += len(tokens)
        return checked_arithmetic.leaf(declared)

    def _velocity(self, token: Token) -> Node:
        name, closing = self._tokens[self._index + 1 : self._index + 3]
        if not self._velocities:
            raise self._source.error("a velocity cannot stand here", token.position)
        if name.kind != "name" or closing.text != ")":
            raise self._source.error("dot takes the name of one coordinate, dot(q)", token.position)
        if name.text not in self._velocities:
            known = ", ".join(f"dot({q})" for q in self._velocities)
            raise self._source.error(f"{name.text!r} is not a coordinate; velocities are {known}", name.position)
        self._index += 3
        return checked_arithmetic.leaf(self._velocities[name.text])

    def _primed(self, name: Token) -> Node:
        """Return a velocity written with a prime, ``theta'``."""
        prime = self._next
        self._index += 1
        if not self._velocities:
            raise self._source.error("a velocity cannot stand here", prime.position)
        if name.text not in self._velocities:
            known = ", ".join(f"{q}'" for q in self._velocities)
            raise self._source.error(f"{name.text!r} is not a coordinate; velocities are {known}", prime.position)
        if self._next.text == "'":
            raise self._source.error("accelerations do not occur in T and V; write one prime", self._next.position)
        return checked_arithmetic.leaf(self._velocities[name.text])

    def _polar_angle(self, token: Token) -> Node:
        opening = self._next
        self._index += 1
        y = self._sum()
        if not self._take(","):
            raise self._source.error("atan2 takes two arguments, atan2(y, x)", token.position)
        x = self._sum()
        self._close(opening)
        return checked_arithmetic.polar_angle(y, x, self._fail(token))

    def _root_of_square(self, token: Token) -> Node:
        """Return an absolute value, where it is the base of a power; |x|**(2/3) is the real root of (x**2)**(1/3)."""
        opening = self._next
        self._index += 1
        argument = self._sum()
        self._close(opening)
        if self._kinks and token.text in _SIGNS:
            return checked_arithmetic.sign_of(argument)
        if not self._kinks and self._next.text != "**":
            raise self._source.error(instead_of_word(token.text, (), (), FUNCTIONS), token.position)
        return checked_arithmetic.absolute_value(argument)

    def _call(self, token: Token) -> Node:
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
        return self._smooth(checked_arithmetic.call(token.text, argument, self._fail(token)), token)

    def _close(self, opening: Token) -> None:
        if self._take(")"):
            return
        if self._next.kind == "end":
            raise self._source.error("this bracket is never closed", opening.position)
        raise self._unexpected(self._next)

    def _without_brackets(self, token: Token) -> ExpressionError:
        following, name = self._next, token.text
        if following.text == "**":
            return self._source.error(f"write {name}(x)**2 for the power of a {name}", token.position)
        argument = following.text[:40] if following.kind in ("name", "number") else "x"
        return self._source.error(f"{name} needs brackets; write {name}({argument})", token.position)

    def _unexpected(self, token: Token) -> ExpressionError:
        before = self._tokens[max(self._index - 1, 0)]
        message = f"{token.text[:40]!r} cannot stand here; a number or a name is missing"
        if token.kind == "end":
            message = "the formula ends too early; a number, a name or a bracket is missing"
        elif token.text == "'":
            message = "a prime stands behind the name of a coordinate, x' for dot(x)"
        elif token.text == ",":
            message = "a comma cannot stand here; a decimal comma is written as a point"
        elif token.text == ")" and (before.kind != "operator" or before.text == ")"):
            message = "this bracket was never opened"
        return self._source.error(message, token.position)
