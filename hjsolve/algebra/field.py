"""The field of functions a system lives in: exact elements with factored denominators, relations and derivatives.

An element is  coefficient · numerator · Π base_k^{e_k}  with a rational coefficient, an integer polynomial as
numerator and integer exponents of registered base polynomials. Sums expand only what their terms do not share, so
metrics that are products (ellipsoidal coordinates, spherical coordinates) stay products under multiplication and
differentiation.

Functions that are not rational enter as generators with the relations that hold between them:

    s² = 1 − c²  (sin, cos),   s² = c² − 1  (sinh, cosh),   g^k = R  (roots),

and nothing for exp, log, inverse functions and undetermined functions, which count as independent. A numerator is
kept reduced modulo the relations. Every relation used is true on the coordinates' domain, hence: *a numerator that
reduces to zero is a proof that the function is zero wherever it is defined*. A numerator that does not is a proof of
nothing; that takes a witness.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from math import lcm

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.element import Element as Element
from hjsolve.algebra.element import Generator as Generator
from hjsolve.algebra.element import RootRelation as RootRelation
from hjsolve.algebra.factoring import factors_of
from hjsolve.algebra.poly import Budget, Poly, WorkLimitError

MAX_POWER = 1000


class Field:
    """Generators, relations and bases, growing as expressions are read; see the module's text.

    ``Field`` is the one mutable value of this package: a table of names that only grows. Elements are immutable.
    """

    def __init__(self, budget: Budget | None = None):
        self.budget = budget or Budget()
        self.generators: list[Generator] = []
        self.bases: list[Poly] = []
        self._numbers: dict[sp.Expr, int] = {}
        self._base_numbers: dict[tuple[tuple[int, int], ...], int] = {}
        self._splits: dict[tuple[tuple[int, int], ...], tuple[tuple[int, int], ...]] = {}
        self._relations: dict[int, RootRelation] = {}
        self._base_values: dict[int, int] = {}
        self._mask = 0
        self.zero = Element(self, Fraction(0), {}, {})
        self.one = Element(self, Fraction(1), {0: 1}, {})

    # generators ------------------------------------------------------------------------------------------------------

    def number_of(self, atom: sp.Expr) -> int | None:
        """Return number of the generator that stands for this expression, if there is one.

        Args:
            atom: the expression a generator stands for.
        """
        return self._numbers.get(atom)

    def adjoin(self, generator: Generator) -> int:
        """Add a generator and return its number.

        Args:
            generator: one that the field does not have.
        """
        k = len(self.generators)
        self.generators.append(generator)
        self._numbers[generator.atom] = k
        if generator.root is not None:
            self._relations[k] = generator.root
            self._mask |= (poly.FIELD >> 1 & ~1) << (poly.BITS * k)
        return k

    def generator(self, k: int) -> Element:
        """Return generator k as an element."""
        return self._reduced_factors(Fraction(1), {0: 1}, {self._base(poly.variable(k)): 1})

    @property
    def guard(self) -> int:
        """Guard mask of the present generators."""
        return poly.guard_bits(len(self.generators))

    # making elements -------------------------------------------------------------------------------------------------

    def coerce(self, value: Element | int | Fraction) -> Element:
        """Return a number as an element.

        Args:
            value: a rational number.
        """
        if isinstance(value, Element):
            return value
        return Element(self, Fraction(value), {0: 1}, {}) if value else self.zero

    def from_poly(
        self, a: Poly, coefficient: Fraction = Fraction(1), factors: Mapping[int, int] | None = None
    ) -> Element:
        """Element coefficient · a · Π factors, normalised.

        The polynomial is reduced modulo the relations, primitive, without monomial content.

        Args:
            coefficient: rational.
            factors: number of a registered base → exponent.
        """
        a = self.reduce(a)
        if not a or not coefficient:
            return self.zero
        exponents = dict(factors or {})
        if (n := poly.content(a)) != 1:
            a = {m: c // n for m, c in a.items()}
            coefficient = coefficient * n
        if common := poly.monomial_content(a):
            a = {m - common: c for m, c in a.items()}
            for k, e in poly.exponents(common):
                b = self._base(poly.variable(k))
                exponents[b] = exponents.get(b, 0) + e
        return self._reduced_factors(coefficient, a, exponents)

    def monomial(self, m: int, coefficient: Fraction, factors: Mapping[int, int]) -> Element:
        """Return coefficient · monomial · Π factors with nothing multiplied out: sin²/sin² is 1, not (1 − cos²)/sin².

        Args:
            m: packed exponents of the generators.
            coefficient: rational.
            factors: number of a registered base → exponent.
        """
        exponents = dict(factors)
        for k, e in poly.exponents(m):
            b = self._base(poly.variable(k))
            exponents[b] = exponents.get(b, 0) + e
        return self._reduced_factors(coefficient, {0: 1}, exponents)

    def _reduced_factors(self, coefficient: Fraction, a: Poly, exponents: dict[int, int]) -> Element:
        """Bring the exponents of roots into 0 … order − 1, so that √R·√R is R and 1/√R is √R/R."""
        exponents = {b: e for b, e in exponents.items() if e}
        for b, e in list(exponents.items()):
            base = self.bases[b]
            if len(base) > 1:
                continue
            k = poly.generators(base)[0]
            g = self.generators[k]
            if g.kind == "root" and g.root is not None and not 0 <= e < g.root.order:
                whole, part = divmod(e, g.root.order)
                exponents[b] = part
                kept = Element(self, coefficient, a, {b: e for b, e in exponents.items() if e})
                return self.product([kept, self.power(self.from_poly(g.root.radicand), whole)])
        return Element(self, coefficient, a, exponents)

    def reduce(self, a: Poly) -> Poly:
        """Return normal form of a polynomial modulo the relations."""
        if not self._mask or not any(m & self._mask for m in a):
            return a
        for k in sorted(self._relations, reverse=True):
            relation = self._relations[k]
            high: dict[int, Poly] = {}
            low: Poly = {}
            for m, c in a.items():
                n = poly.exponent(m, k) // relation.order
                if n:
                    m -= (n * relation.order) << (poly.BITS * k)
                    high.setdefault(n, {})[m] = c
                else:
                    low[m] = c
            for n, part in high.items():
                low = poly.add(low, poly.mul(part, self._poly_power(relation.radicand, n), self.budget))
            if high:
                a = low
        return a

    def _poly_power(self, a: Poly, n: int) -> Poly:
        """aⁿ, reduced, n ≥ 0."""
        if n > 1 and n * max(e for m in a for _, e in [(0, 0), *poly.exponents(m)]) > poly.MAX_DEGREE:
            raise WorkLimitError(f"the exponents of a power {n} would be too large for exact arithmetic")
        if len(a) == 1:
            ((m, c),) = a.items()
            return self.reduce({n * m: c**n})
        if n > MAX_POWER:
            raise WorkLimitError(f"a power {n} would have to be expanded")
        result: Poly = {0: 1}
        while n:
            if n & 1:
                result = self.reduce(poly.mul(result, a, self.budget))
            n >>= 1
            if n:
                a = self.reduce(poly.mul(a, a, self.budget))
        return result

    # bases -----------------------------------------------------------------------------------------------------------

    def _base(self, a: Poly) -> int:
        """Return number of a primitive base polynomial, registered when new."""
        name = poly.key(a)
        if name not in self._base_numbers:
            self._base_numbers[name] = len(self.bases)
            self.bases.append(a)
        return self._base_numbers[name]

    def split(self, a: Poly) -> tuple[tuple[int, int], ...]:
        """Write a primitive polynomial with positive leading coefficient as Π base^e over registered bases.

        Args:
            a: a primitive polynomial with positive leading coefficient.
        """
        if a == {0: 1}:
            return ()
        name = poly.key(a)
        if name not in self._splits:
            self._splits[name] = self._split(a)
        return self._splits[name]

    def _split(self, a: Poly) -> tuple[tuple[int, int], ...]:
        found: dict[int, int] = {}
        seen = poly.support(a)
        for b, base in enumerate(list(self.bases)):
            while len(base) > 1 and not poly.support(base) & ~_fill(seen) and len(a) > 1:
                quotient = poly.exact_quotient(a, base, self.guard, self.budget)
                if quotient is None:
                    break
                found[b] = found.get(b, 0) + 1
                a = quotient
        for factor, e in factors_of(a):
            if factor != {0: 1}:
                b = self._base(factor)
                found[b] = found.get(b, 0) + e
        return tuple(found.items())

    def factored(self, x: Element) -> Element:
        """Return the same element with its numerator moved into the factors."""
        if len(x.numerator) <= 1:
            return x
        factors = dict(x.factors)
        for b, e in self.split(x.numerator):
            factors[b] = factors.get(b, 0) + e
        return Element(self, x.coefficient, {0: 1}, {b: e for b, e in factors.items() if e})

    # arithmetic ------------------------------------------------------------------------------------------------------

    def product(self, elements: Sequence[Element]) -> Element:
        """Product; numerators are multiplied out, factors stay factored."""
        coefficient, a = Fraction(1), {0: 1}
        factors: dict[int, int] = {}
        for x in elements:
            if x.is_zero:
                return self.zero
            coefficient *= x.coefficient
            a = poly.mul(a, x.numerator, self.budget)
            for b, e in x.factors.items():
                factors[b] = factors.get(b, 0) + e
        return self.from_poly(a, coefficient, factors)

    def power(self, x: Element, n: int) -> Element:
        """xⁿ; the numerator becomes a factor when n is negative or large.

        Args:
            n: the exponent, a whole number of either sign.

        Raises:
            ZeroDivisionError: x is zero and n is negative.
        """
        if n == 0:
            return self.one
        if x.is_zero:
            if n < 0:
                raise ZeroDivisionError("division by an expression that is identically zero")
            return x
        if n == 1:
            return x
        y = self.factored(x)
        return self._reduced_factors(y.coefficient**n, {0: 1}, {b: n * e for b, e in y.factors.items()})

    def total(self, elements: Iterable[Element]) -> Element:
        """Return the sum over the common denominator; factors that all terms share are not expanded."""
        terms = [x for x in elements if not x.is_zero]
        if not terms:
            return self.zero
        if len(terms) == 1:
            return terms[0]
        names = {b for x in terms for b in x.factors}
        shared = {b: min(x.factors.get(b, 0) for x in terms) for b in names}
        denominator = lcm(*(x.coefficient.denominator for x in terms))
        numerator: Poly = {}
        for x in terms:
            n = x.coefficient.numerator * (denominator // x.coefficient.denominator)
            part = x.numerator
            for b in names:
                if e := x.factors.get(b, 0) - shared[b]:
                    part = self.reduce(poly.mul(part, self._poly_power(self.bases[b], e), self.budget))
            numerator = poly.add(numerator, part, n)
        return self.from_poly(numerator, Fraction(1, denominator), shared)

    def cancelled(self, x: Element) -> Element:
        """Return the same element after dividing the numerator by the denominators that divide it exactly."""
        if len(x.numerator) <= 1:
            return x
        a, factors = x.numerator, dict(x.factors)
        for b in [b for b, e in factors.items() if e < 0 and len(self.bases[b]) > 1]:
            while factors[b] < 0 and (q := self._quotient(a, b)) is not None:
                a, factors[b] = q, factors[b] + 1
        return self.from_poly(a, x.coefficient, factors)

    def expanded(self, x: Element) -> Element:
        """Return the same element with its positive factors multiplied into the numerator."""
        a, factors = x.numerator, {}
        for b, e in x.factors.items():
            if e > 0 and len(self.bases[b]) > 1:
                a = self.reduce(poly.mul(a, self._poly_power(self.bases[b], e), self.budget))
            else:
                factors[b] = e
        return self.from_poly(a, x.coefficient, factors)

    def _quotient(self, a: Poly, b: int) -> Poly | None:
        """Quotient of a by base b where that is exact; values at one integer point rule most cases out."""
        divisor = self._value_of(b)
        if divisor and poly.value_modulo(a, divisor):
            return None
        return poly.exact_quotient(a, self.bases[b], self.guard, self.budget)

    def _value_of(self, b: int) -> int:
        if b not in self._base_values:
            self._base_values[b] = abs(poly.value(self.bases[b]))
        return self._base_values[b]


def _fill(seen: int) -> int:
    """Return every bit of every field that is non-zero in ``seen``."""
    return sum(poly.FIELD << (poly.BITS * k) for k, _ in poly.exponents(seen))
