"""Exact values of an expression at a point, with radicals kept formal.

The equation d(K·dV) = 0 is linear in the constants of K. Its coefficients are derivatives of V; at a rational point
x they are elements of the algebra F[g₁, g₂, …]/(g_i^{q_i} − ρ_i(x)), where F = Q(parameters) or an algebraic number
field, the g_i are the radicals of V and ρ_i their radicands. The basis monomials of the algebra are kept apart, so
that every point gives one exact linear equation for each of them. Functions that are algebraically independent of the
coordinates (exponentials, the tangent of half an angle, logarithms, undetermined functions) become independent
random numbers at every point.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import product
from math import floor, lcm
from random import Random

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.polys.domains.domain import Domain
from sympy.polys.rings import PolyElement

from hjsolve.algebra.reader import HYPERBOLIC, TRIGONOMETRIC
from hjsolve.algebra.shared_parts import holds, parts
from hjsolve.algebra.time_limit import check_time
from hjsolve.coordinates.killing.constant_field import FieldElement, Ground, Rows, ground_field, numerator_alone
from hjsolve.errors import InvalidSystemError

Key = tuple[tuple[int, int, int], ...]
"""A monomial in the radicals: g_i^(p/q) as (i, p, q), 0 < p < q, in the order of i."""
Element = dict[Key, FieldElement]


class ZeroDivisorError(Exception):
    """The point chosen is not regular; another one is taken."""


def _terms(argument: sp.Expr) -> list[tuple[sp.Rational, sp.Expr]]:
    """Write an argument as a sum of rational multiples of monomials."""
    return [term.as_coeff_Mul(rational=True) for term in sp.Add.make_args(sp.expand(argument))]


def _prepare(expression: sp.Expr, coordinates: Sequence[sp.Symbol]) -> sp.Expr:
    """Rewrite hyperbolic functions by exponentials, circular ones by sin and cos; sign u = |u|/u; split off phases."""
    if expression.has(sp.Piecewise, sp.Heaviside, sp.floor, sp.Min, sp.Max):
        raise InvalidSystemError("find_coordinates: the potential must be one analytic expression, not piecewise")
    for function in _held(expression, HYPERBOLIC):
        expression = expression.replace(function, lambda u, f=function: f(u).rewrite(sp.exp))
    for function in _held(expression, TRIGONOMETRIC[2:]):
        expression = expression.replace(function, lambda u, f=function: f(u).rewrite(sp.cos, sp.sin).rewrite(sp.sin))
    if _held(expression, [sp.DiracDelta]):
        expression = expression.replace(sp.DiracDelta, lambda *_: sp.S.Zero)

    def split(function: sp.Function) -> sp.Expr:
        def apart(argument: sp.Expr) -> sp.Expr:
            phase, moving = sp.expand(argument).as_independent(*coordinates, as_Add=True)
            if phase == 0 or moving == 0:
                return function(argument)
            if function is sp.exp:
                return sp.exp(phase) * sp.exp(moving)
            c, s = sp.cos(phase), sp.sin(phase)
            return (
                c * sp.sin(moving) + s * sp.cos(moving)
                if function is sp.sin
                else c * sp.cos(moving) - s * sp.sin(moving)
            )

        return apart

    for function in _held(expression, [sp.exp, sp.sin, sp.cos]):
        expression = expression.replace(function, split(function))
    return expression.replace(sp.sign, lambda u: sp.Abs(u) / u) if _held(expression, [sp.sign]) else expression


def _held(expression: sp.Expr, functions: Iterable[type[sp.Function]]) -> list[type[sp.Function]]:
    """Return those of some functions that an expression holds."""
    every = parts([expression])
    return [function for function in functions if any(isinstance(part, function) for part in every)]


@dataclass(frozen=True)
class Generators:
    """What an expression is made of besides the coordinates: common denominators of exponents and of angles."""

    coordinates: tuple[sp.Symbol, ...]
    ground: Ground
    denominators: Mapping[tuple[str, sp.Expr], int]


def collected_generators(expressions: Sequence[sp.Expr], coordinates: Sequence[sp.Symbol]) -> Generators:
    """Collect the exponentials, angles and symbolic powers of some prepared expressions.

    Args:
        expressions: as ``prepared`` leaves them.
        coordinates: the symbols that are no constants.
    """
    found: dict[tuple[str, sp.Expr], int] = {}

    def note(kind: str, argument: sp.Expr) -> None:
        for coefficient, monomial in _terms(argument):
            found[kind, monomial] = lcm(found.get((kind, monomial), 1), int(coefficient.q))

    for node in parts(expressions):
        if isinstance(node, sp.exp):
            note("exp", node.args[0])
        elif isinstance(node, sp.sin | sp.cos):
            note("angle", node.args[0])
        elif node.is_Pow and not node.exp.is_Rational:
            for coefficient, rest in _terms(node.exp):
                key = ("power", sp.Pow(node.base, rest, evaluate=False))
                found[key] = lcm(found.get(key, 1), int(coefficient.q))
    return Generators(tuple(coordinates), ground_field(expressions, coordinates), found)


class PointAlgebra:
    """Evaluation of expressions at one point; every result is an element {monomial in the radicals: field element}."""

    def __init__(self, made_of: Generators, random: Random):
        self.made_of, self.random = made_of, random
        self.field, self.numbers = made_of.ground.field, made_of.ground.plain
        self.plain = {q: self._rational() for q in made_of.coordinates}
        self.point = {q: self.numbers.convert(value) for q, value in self.plain.items()}
        self.roots: dict[sp.Expr, int] = {}
        self.radicands: list[Element] = []
        self.values: dict[sp.Expr, Element] = {}
        self.free: dict[tuple[str, sp.Expr], FieldElement] = {}
        self._products: dict[tuple[Key, Key], Element] = {}
        self._inverses: dict[sp.Expr, Element] = {}

    def _rational(self) -> sp.Rational:
        return sp.Rational(self.random.randint(-40, 40) * 2 + 1, self.random.choice((1, 2, 3)))

    def _number(self) -> FieldElement:
        return self.numbers.convert(self._rational())

    def _transcendental(self, kind: str, argument: sp.Expr) -> FieldElement:
        if (kind, argument) not in self.free:
            self.free[kind, argument] = self._number()
        return self.free[kind, argument]

    # ---- arithmetic -------------------------------------------------------------------------------------------
    def constant(self, number: FieldElement) -> Element:
        """Return an element of the field as one of the algebra."""
        return {(): number} if number else {}

    def add(self, a: Element, b: Element) -> Element:
        """Return a + b."""
        total = dict(a)
        for key, value in b.items():
            new = total.get(key, self.numbers.zero) + value
            if new:
                total[key] = new
            else:
                total.pop(key, None)
        return total

    def multiply(self, a: Element, b: Element) -> Element:
        """Return a·b, reduced by g^q = ρ."""
        check_time()
        total: Element = {}
        for (k1, v1), (k2, v2) in product(a.items(), b.items()):
            number = v1 * v2
            for key, value in self._monomial(k1, k2).items():
                term = number * value
                new = total[key] + term if key in total else term
                if new:
                    total[key] = new
                else:
                    total.pop(key, None)
        return total

    def _monomial(self, first: Key, second: Key) -> Element:
        """Return the product of two monomials in the radicals."""
        if (first, second) not in self._products:
            self._products[first, second] = self._reduced(first, second)
        return self._products[first, second]

    def _reduced(self, first: Key, second: Key) -> Element:
        exponents = _exponents(first)
        for index, exponent in _exponents(second).items():
            exponents[index] = exponents.get(index, Fraction(0)) + exponent
        result: Element = {_key({i: e - 1 if e >= 1 else e for i, e in exponents.items()}): self.numbers.one}
        for index, exponent in exponents.items():
            if exponent >= 1:
                result = self.multiply(self.radicands[index], result)
        return result

    def power(self, a: Element, n: int) -> Element:
        """Return aⁿ for an integer n.

        Args:
            a: an element of the algebra, with an inverse where n is negative.
        """
        if n < 0:
            return self.power(self.inverse(a), -n)
        result: Element | None = None
        while n:
            if n & 1:
                result = a if result is None else self.multiply(result, a)
            a, n = (self.multiply(a, a) if n > 1 else a), n >> 1
        return self.constant(self.numbers.one) if result is None else result

    def inverse(self, a: Element) -> Element:
        """Return 1/a by linear algebra over the field in the smallest subalgebra that holds a.

        Args:
            a: sum of products of the radicals, coefficients in the field.

        Raises:
            ZeroDivisorError: a is zero, or divides zero.
        """
        if not a:
            raise ZeroDivisorError
        if len(a) == 1:
            ((key, value),) = a.items()
            result = self.constant(_quotient(self.numbers.one, value, self.field))
            for index, exponent in _exponents(key).items():
                result = self.multiply(result, {_key({index: 1 - exponent}): self.numbers.one})
                result = self.multiply(result, self.inverse(self.radicands[index]))
            return result
        basis = self._subalgebra(a)
        columns = [self.multiply(a, {key: self.numbers.one}) for key in basis]
        rows = [[column.get(key, self.numbers.zero) for column in columns] for key in basis]
        solution = _solve(rows, [self.numbers.one if key == () else self.numbers.zero for key in basis], self.field)
        return {key: value for key, value in zip(basis, solution, strict=True) if value}

    def _subalgebra(self, a: Element) -> list[Key]:
        denominators: dict[int, int] = {}
        queue = list(a)
        while queue:
            for index, _, q in queue.pop():
                if index not in denominators:
                    queue.extend(self.radicands[index])
                denominators[index] = lcm(denominators.get(index, 1), q)
        grids = [[(i, Fraction(e, q)) for e in range(q)] for i, q in sorted(denominators.items())]
        return [_key(dict(combination)) for combination in product(*grids)]

    # ---- evaluation -------------------------------------------------------------------------------------------
    def evaluate(self, expression: sp.Expr) -> Element:
        """Return the value of a prepared expression at the point.

        Args:
            expression: as ``prepared`` leaves it.
        """
        if expression not in self.values:
            check_time()
            self.values[expression] = self._value(expression)
        return self.values[expression]

    def _value(self, node: sp.Expr) -> Element:
        if node in self.point:
            return self.constant(self.point[node])
        if node.is_Add:
            return reduce(self.add, map(self.evaluate, node.args))
        if node.is_Mul:
            return reduce(self.multiply, map(self.evaluate, node.args))
        if not holds(node, self.made_of.coordinates) and not isinstance(node, AppliedUndef | sp.Subs | sp.Derivative):
            return self.constant(self.made_of.ground.convert(node))
        if node.is_Pow and node.exp.is_Rational:
            return self._root(node.base, Fraction(int(node.exp.p), int(node.exp.q)))
        if isinstance(node, sp.Abs):
            return self._root(
                node.args[0] ** 2 if not node.args[0].is_Pow else sp.Pow(node.args[0], 2, evaluate=False),
                Fraction(1, 2),
            )
        if isinstance(node, sp.exp):
            return self._product("exp", _terms(node.args[0]))
        if node.is_Pow:
            terms = [(c, sp.Pow(node.base, rest, evaluate=False)) for c, rest in _terms(node.exp) if rest != 1]
            whole = [c for c, rest in _terms(node.exp) if rest == 1]
            factor = (
                self._root(node.base, Fraction(int(whole[0].p), int(whole[0].q)))
                if whole
                else self.constant(self.numbers.one)
            )
            return self.multiply(factor, self._product("power", terms))
        if isinstance(node, sp.sin | sp.cos):
            cosine, sine = self._circle(_terms(node.args[0]))
            return self.constant(sine if isinstance(node, sp.sin) else cosine)
        return self.constant(self._transcendental("other", node))

    def _product(self, kind: str, terms: list[tuple[sp.Rational, sp.Expr]]) -> Element:
        value = self.numbers.one
        for coefficient, monomial in terms:
            base = self._transcendental(kind, monomial)
            value *= base ** int(coefficient * self.made_of.denominators[kind, monomial])
        return self.constant(value)

    def _circle(self, terms: list[tuple[sp.Rational, sp.Expr]]) -> tuple[FieldElement, FieldElement]:
        cosine, sine = self.numbers.one, self.numbers.zero
        for coefficient, monomial in terms:
            t = self._transcendental("angle", monomial)
            one = self.numbers.one
            c, s = (one - t * t) / (one + t * t), 2 * t / (one + t * t)
            turns = int(coefficient * self.made_of.denominators["angle", monomial])
            for _ in range(abs(turns)):
                cosine, sine = (
                    (cosine * c - sine * s, sine * c + cosine * s)
                    if turns > 0
                    else (cosine * c + sine * s, sine * c - cosine * s)
                )
        return cosine, sine

    def _root(self, base: sp.Expr, exponent: Fraction) -> Element:
        whole = floor(exponent)
        result = self.power(self._inverse_of(base) if whole < 0 else self.evaluate(base), abs(whole))
        if exponent == whole:
            return result
        if base not in self.roots:
            radicand = self.evaluate(base)
            self.roots[base] = len(self.radicands)
            self.radicands.append(radicand)
        return self.multiply(result, {_key({self.roots[base]: exponent - whole}): self.numbers.one})

    def _inverse_of(self, base: sp.Expr) -> Element:
        if base not in self._inverses:
            self._inverses[base] = self.inverse(self.evaluate(base))
        return self._inverses[base]


def _exponents(key: Key) -> dict[int, Fraction]:
    return {index: Fraction(p, q) for index, p, q in key}


def _key(exponents: Mapping[int, Fraction]) -> Key:
    return tuple(sorted((i, e.numerator, e.denominator) for i, e in exponents.items() if e))


def _quotient(a: FieldElement, b: FieldElement, field: Domain) -> FieldElement:
    """Return a/b; a polynomial in the parameters is a polynomial again where the denominator is a number."""
    quotient = a / (field.convert(b) if isinstance(b, PolyElement) else b)
    return numerator_alone(quotient)


def _solve(rows: Rows, right: list[FieldElement], field: Domain) -> list[FieldElement]:
    """Solve a square linear system over a field by elimination."""
    size = len(rows)
    table = [[*row, value] for row, value in zip(rows, right, strict=True)]
    for column in range(size):
        pivot = next((r for r in range(column, size) if table[r][column]), None)
        if pivot is None:
            raise ZeroDivisorError
        table[column], table[pivot] = table[pivot], table[column]
        lead = table[column][column]
        table[column] = [_quotient(entry, lead, field) for entry in table[column]]
        for r in range(size):
            if r != column and table[r][column]:
                check_time()
                factor = table[r][column]
                table[r] = [a - factor * b for a, b in zip(table[r], table[column], strict=True)]
    return [row[size] for row in table]


def prepared(expressions: Sequence[sp.Expr], coordinates: Sequence[sp.Symbol]) -> list[sp.Expr]:
    """Rewrite expressions so that only the functions known to ``PointAlgebra`` occur.

    Args:
        coordinates: the symbols that are no constants.
    """
    return [_prepare(expression, coordinates) for expression in expressions]
