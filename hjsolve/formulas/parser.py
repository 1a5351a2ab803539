"""The parser of formulas: tokens → sympy, by recursive descent over numbers, declared names and a list of functions.

The grammar is Python's for + - * / ** and brackets. Numbers are exact: a decimal is the rational it spells. What is
built, and that it stays real, finite and small, is the business of ``hjsolve.formulas.checked_arithmetic``.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.errors import ExpressionError
from hjsolve.formulas import checked_arithmetic
from hjsolve.formulas.checked_arithmetic import FUNCTIONS, Node
from hjsolve.formulas.tokens import FormulaText, Token, instead_of_word, is_known_elsewhere, nearest_name

MAX_DEPTH = 50
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
    ):
        self._source, self._tokens, self._names, self._velocities = source, tokens, names, velocities
        self._functions = functions
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

    def _fail(self, token: Token) -> checked_arithmetic.Fail:
        return lambda message: self._source.error(message, token.position)

    def formula(self) -> sp.Expr:
        """The whole text as one formula.

        Raises:
            ExpressionError: the text goes on behind the formula, or is none.
        """
        node = self._sum()
        if self._next.kind != "end":
            raise self._unexpected(self._next)
        return node.expression

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
        """A product; a sign stays in front of it, so that -(a + b)*c does not become (-a - b)*c."""
        start = self._next
        node, negative = self._signed()
        nodes = [node]
        while operator := self._take("*", "/"):
            node, minus = self._signed()
            nodes.append(node if operator.text == "*" else checked_arithmetic.reciprocal(node, self._fail(operator)))
            negative ^= minus
        if len(nodes) == 1:
            return checked_arithmetic.negative(nodes[0]) if negative else nodes[0]
        sign = [checked_arithmetic.leaf(sp.S.NegativeOne)] if negative else []
        return checked_arithmetic.product([*sign, *nodes], self._fail(start))

    def _signed(self) -> tuple[Node, bool]:
        """A factor without its signs, and whether they make it negative."""
        negative = False
        while sign := self._take("+", "-"):
            negative ^= sign.text == "-"
        return self._power(), negative

    def _power(self) -> Node:
        base = self._atom()
        operator = self._take("**")
        if operator is None:
            return base
        self._deeper(operator)
        exponent, negative = self._signed()
        self._depth -= 1
        return checked_arithmetic.power(
            base, checked_arithmetic.negative(exponent) if negative else exponent, self._fail(operator)
        )

    def _atom(self) -> Node:
        token = self._next
        self._index += 1
        if token.kind == "number":
            return self._followed(checked_arithmetic.literal(token.text, self._fail(token)))
        if token.kind == "name":
            return self._named(token)
        if token.text == "(":
            node = self._sum()
            self._close(token)
            return self._followed(node)
        self._index -= 1
        raise self._unexpected(token)

    def _named(self, token: Token) -> Node:
        opened = self._next.text == "("
        if token.text in self._names:
            if opened:
                message = f"{token.text} is not a function; write {token.text}*(...) for a product"
                raise self._source.error(message, token.position)
            return self._followed(checked_arithmetic.leaf(self._names[token.text]))
        if token.text in FUNCTIONS:
            return self._call(token)
        if token.text == "dot" and opened:
            return self._velocity(token)
        if token.text == "pi":
            return self._followed(checked_arithmetic.leaf(sp.pi))
        if token.text in self._functions:
            return self._undetermined(token)
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
        """A declared undetermined function, with the arguments it was declared with."""
        declared = self._functions[token.text]
        written = [t for argument in declared.args for t in (str(argument), ",")][:-1]
        tokens = [t.text for t in self._tokens[self._index : self._index + len(written) + 2]]
        if tokens != ["(", *written, ")"]:
            raise self._source.error(f"{token.text} is declared as {declared}; write {declared}", token.position)
        self._index += len(tokens)
        return self._followed(checked_arithmetic.leaf(declared))

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
        return self._followed(checked_arithmetic.leaf(self._velocities[name.text]))

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
        return self._followed(checked_arithmetic.call(token.text, argument, self._fail(token)))

    def _close(self, opening: Token) -> None:
        if self._take(")"):
            return
        if self._next.kind == "end":
            raise self._source.error("this bracket is never closed", opening.position)
        raise self._unexpected(self._next)

    def _followed(self, node: Node) -> Node:
        """The node, unless what follows it shows that an operator was left out."""
        following = self._next
        if following.kind not in ("number", "name") and following.text != "(":
            return node
        before = self._tokens[self._index - 1]
        if before.kind == "number" and following.kind == "number":
            raise self._source.error("two numbers follow each other", following.position)
        if not self._names and following.kind == "name" and following.text not in {*FUNCTIONS, "pi"}:
            raise self._source.error("a value is a number alone, without a unit", following.position)
        left, right = ("(...)" if token.text in "()" else token.text[:40] for token in (before, following))
        raise self._source.error(f"an operator is missing; write {left}*{right} for a product", following.position)

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
        elif token.text == ",":
            message = "a comma cannot stand here; a decimal comma is written as a point"
        elif token.text == ")" and (before.kind != "operator" or before.text == ")"):
            message = "this bracket was never opened"
        return self._source.error(message, token.position)
