"""Reading sympy expressions into a ``Field``, writing elements back, and differentiating them.

Angles: sin and cos of n₁u₁ + n₂u₂ + … become polynomials in sin uₖ, cos uₖ, where uₖ is a monomial times the greatest
rational number that makes all nₖ seen integers; exp and the hyperbolic functions likewise. Roots: a radicand is split
into factors; those whose sign on the domain is proved get a root of their own (so √(ab) = √a·√b and √(P²) = P are
recognised where they are true), the others stay together. A function nobody knows, f(r), is a generator, and so is
each of its derivatives.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from fractions import Fraction
from functools import cache
from math import gcd

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.constants import constant_is_zero
from hjsolve.algebra.elementary import INVERSE_CIRCULAR, INVERSE_HYPERBOLIC, at_one_place, circular_pair, composed
from hjsolve.algebra.field import MAX_POWER, Element, Field, Generator, RootRelation
from hjsolve.algebra.intervals import NoEnclosureError, enclose
from hjsolve.algebra.logarithms import Logarithms
from hjsolve.algebra.poly import Budget, Poly, WorkLimitError
from hjsolve.algebra.relations import dependent
from hjsolve.algebra.roots import root
from hjsolve.algebra.shared_parts import slope_by
from hjsolve.algebra.signs import Bounds, atom_bounds
from hjsolve.errors import required

TRIGONOMETRIC = (sp.sin, sp.cos, sp.tan, sp.cot, sp.sec, sp.csc)
HYPERBOLIC = (sp.sinh, sp.cosh, sp.tanh, sp.coth, sp.sech, sp.csch)
MAX_MULTIPLE = 12
"""Of an angle: sin nu is a polynomial of degree n in sin u and cos u."""
MAX_EXPONENT = 100_000
"""Of exp u: one power. sympy joins exp(a) exp(b) to exp(a + b), which would be a function of its own beyond."""
MAX_SECONDS = 5.0
"""Of processor time, for relations between generators of one variable in one field."""
Pair = tuple[Element, Element]


class OutsideFieldError(WorkLimitError):
    """An expression that exact arithmetic cannot represent (complex numbers, piecewise functions)."""


class Reader:
    """Reads expressions of one system into its field.

    Args:
        expressions: what will be read; only looked through for the multiples of angles that occur.
        bounds: lower and upper end of each coordinate's domain; None is infinite.
        budget: work allowed.
        whole: keep tanh(a*(x - b)) a function of a*(x - b), which addition theorems would make one of a*x and of a*b
            that no longer can be worked out where a is large. What vanishes so, vanishes; not the other way round.
    """

    def __init__(
        self,
        expressions: Iterable[sp.Expr] = (),
        bounds: Mapping[sp.Symbol, Bounds] | None = None,
        budget: Budget | None = None,
        *,
        whole: bool = False,
    ):
        self.field = Field(budget)
        self._whole = whole
        self.bounds = dict(bounds or {})
        self._read: dict[sp.Expr, Element] = {}
        self._derivatives: dict[tuple[int, sp.Symbol], Element] = {}
        self._slope_by = cache(slope_by)
        self._written: dict[int, sp.Expr] = {}
        self._units: dict[tuple[str, sp.Expr], Fraction] = {}
        self._exponential: set[sp.Expr] = set()
        self._dependent: dict[sp.Expr, Element | None] = {}
        self.seconds_for_relations = MAX_SECONDS
        self._logarithms = Logarithms(self)
        for expression in expressions:
            self._look_through(expression)

    # looking for angles ----------------------------------------------------------------------------------------------

    def _look_through(self, expression: sp.Expr) -> None:
        for node in expression.atoms(*TRIGONOMETRIC):
            self._note("angle", node.args[0])
        for node in expression.atoms(*HYPERBOLIC):
            self._note("rapidity", node.args[0])
        for node in expression.atoms(sp.exp):
            self._note("rapidity", node.args[0])
            self._exponential |= {m for m, _ in rational_multiples(node.args[0])}
        for node in expression.atoms(sp.Pow, sp.log):
            inside = node.args[0]
            even = isinstance(node, sp.log) or (node.exp.is_Rational and node.exp.q % 2 == 0)
            if even and inside.is_Symbol and self.bounds.get(inside, (None, None)) == (None, None):
                self.bounds[inside] = (sp.S.Zero, None)  # where the expression is defined at all

    def _note(self, kind: str, argument: sp.Expr) -> None:
        for monomial, c in self._terms(kind, argument):
            self._units[kind, monomial] = rational_gcd(self._units.get((kind, monomial), abs(c)), c)

    def _terms(self, kind: str, argument: sp.Expr) -> list[tuple[sp.Expr, Fraction]]:
        """Return the argument as Σ coefficient · monomial.

        a shifted one is a monomial itself where it is kept whole.
        """
        terms = rational_multiples(argument)
        if self._whole and kind == "rapidity" and is_shifted(argument, set(self.bounds)):
            c = next(c for m, c in terms if not m.free_symbols.isdisjoint(self.bounds))
            return [(sp.Add(*(sp.Rational(d.numerator, d.denominator) * m / c for m, d in terms)), c)]
        return terms

    def _multiples(self, kind: str, argument: sp.Expr) -> list[tuple[int, sp.Expr]]:
        """Return the argument as Σ n_k u_k with integers n_k and unit angles u_k."""
        parts = []
        for monomial, c in self._terms(kind, argument):
            unit = self._units.setdefault((kind, monomial), abs(c))
            n = c / unit
            most = MAX_EXPONENT if kind == "rapidity" and monomial in self._exponential else MAX_MULTIPLE
            if n.denominator != 1 or abs(n) > most:  # a function of its own: what vanishes so vanishes
                n, unit = Fraction(1 if c > 0 else -1), abs(c)
            parts.append((int(n), sp.Rational(unit.numerator, unit.denominator) * monomial))
        return parts

    # reading ---------------------------------------------------------------------------------------------------------

    def element(self, expression: sp.Expr) -> Element:
        """Read an expression.

        Args:
            expression: in the symbols of the field.

        Raises:
            OutsideFieldError: it holds something that is not a real function known here.
            WorkLimitError: reading it needs more work than the budget allows.
            ZeroDivisionError: it divides by something that is identically zero.
        """
        found = self._read.get(expression)
        if found is None:
            self.field.budget.check()
            found = self._read[expression] = self._element(expression)
        return found

    def _element(self, x: sp.Expr) -> Element:
        if x.is_Rational:
            return self.field.coerce(Fraction(int(x.p), int(x.q)))
        if x.is_Float:
            return self.element(sp.Rational(x))
        if x.is_Symbol:
            return self._symbol(x)
        if x.is_Add:
            if x.is_number and x.has(sp.Function) and _is_zero(x):
                return self.field.zero
            return self.field.total([self.element(a) for a in x.args])
        if x.is_Mul:
            return self.field.product([self.field.factored(self.element(a)) for a in x.args])
        if x.is_Pow:
            return self._power(x.base, x.exp)
        if handler := _HANDLERS.get(x.func):
            return handler(self, x.args[0])
        return self._opaque(x)

    def _symbol(self, x: sp.Symbol) -> Element:
        low, high = atom_bounds(x, self.bounds)
        return self.adjoined(Generator(x, "symbol", low=low, high=high))

    def adjoined(self, g: Generator) -> Element:
        """Return the element of a generator, adjoined to the field when it is new."""
        k = self.field.number_of(g.atom)
        if k is not None:
            return self.field.generator(k)
        if g.atom not in self._dependent:
            self._prepare(g.atom)
            self._dependent[g.atom] = dependent(self, g)
        known = self._dependent[g.atom]
        return self.field.generator(self.field.adjoin(g)) if known is None else known

    def _prepare(self, atom: sp.Expr) -> None:
        """Let the sines and cosines of a root's or inverse function's variable join first: it may depend on them."""
        if len(atom.free_symbols) != 1 or isinstance(atom, (*TRIGONOMETRIC, *HYPERBOLIC, sp.exp)):
            return
        for kind, monomial in list(self._units):
            unit = self._units[kind, monomial]
            if monomial.free_symbols == atom.free_symbols and monomial.is_Symbol:
                self._pair(kind, sp.Rational(unit.numerator, unit.denominator) * monomial)

    def _opaque(self, x: sp.Expr) -> Element:
        """Anything else that is real: an inverse function, an undetermined function, a derivative of one, π."""
        known = isinstance(x, (sp.Function, sp.Derivative, sp.Subs, sp.NumberSymbol, sp.Integral))
        if not known or isinstance(x, sp.Piecewise) or x.has(sp.I, sp.nan, sp.zoo, sp.oo):
            raise OutsideFieldError(f"{sp.sstr(x)[:80]} has no exact arithmetic here")
        low, high = atom_bounds(x, self.bounds)
        return self.adjoined(Generator(x, "other", low=low, high=high))

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> Element:
        if base is sp.E:
            return self._exp(exponent)
        if exponent.is_Integer:
            if abs(int(exponent)) > MAX_POWER:
                raise WorkLimitError(f"the exponent {exponent} is too large for exact arithmetic")
            return self.field.power(self.element(base), int(exponent))
        if exponent.is_Rational:
            return root(self, self.element(base), int(exponent.p), int(exponent.q))
        result = self.field.one
        for monomial, c in rational_multiples(exponent):
            if monomial == 1:
                result = result * self._power(base, sp.Rational(c.numerator, c.denominator))
                continue
            unit = sp.Rational(1, c.denominator) * monomial
            atom = sp.Pow(base, unit)
            low = Fraction(0) if base.is_positive else None
            result = result * self.adjoined(Generator(atom, "other", low=low)) ** c.numerator
        return result

    def _exp(self, argument: sp.Expr) -> Element:
        result = self.field.one
        for n, unit in self._multiples("rapidity", argument):
            atom = composed(sp.exp(unit)) if unit.has(*INVERSE_HYPERBOLIC) else sp.exp(unit)
            if not isinstance(atom, sp.exp):
                result = result * self.element(atom) ** n
                continue
            result = result * self.adjoined(Generator(atom, "other", low=Fraction(0))) ** n
        return result

    def _pair(self, kind: str, argument: sp.Expr) -> Pair:
        """(sine, cosine) of an argument, circular or hyperbolic."""
        field = self.field
        s, c = field.zero, field.one
        sign = -1 if kind == "angle" else 1
        for n, unit in self._multiples(kind, argument):
            s1, c1 = self._unit_pair(kind, unit)
            sn, cn = field.zero, field.one
            for _ in range(abs(n)):
                sn, cn = sn * c1 + cn * s1, cn * c1 + sn * s1 * sign
            if n < 0:
                sn = -sn
            s, c = s * cn + c * sn, c * cn + s * sn * sign
        return s, c

    def _unit_pair(self, kind: str, unit: sp.Expr) -> Pair:
        monomial = unit.as_coeff_Mul()[1]
        if kind == "angle" and isinstance(monomial, INVERSE_CIRCULAR) and unit.as_coeff_Mul()[0].q <= 2:
            cosine, sine = circular_pair(unit)
            return self.element(sine), self.element(cosine)
        if kind == "rapidity" and (monomial in self._exponential or isinstance(monomial, INVERSE_HYPERBOLIC)):
            e = self._exp(unit)
            return (e - e**-1) * Fraction(1, 2), (e + e**-1) * Fraction(1, 2)
        sine, cosine = (sp.sin, sp.cos) if kind == "angle" else (sp.sinh, sp.cosh)
        s_atom, c_atom = sine(unit), cosine(unit)
        turned = isinstance(-s_atom, sine) and (-s_atom).args[0] == -unit  # sympy's own choice of the sign
        if turned:
            s_atom = -s_atom
        if not isinstance(s_atom, sine) or not isinstance(c_atom, cosine):
            return self.element(s_atom), self.element(c_atom)
        low, high = atom_bounds(c_atom, self.bounds)
        c = self.adjoined(Generator(c_atom, c_atom.func.__name__, low=low, high=high))
        k = required(self.field.number_of(c_atom))
        square = {2 << (poly.BITS * k): -1, 0: 1} if kind == "angle" else {2 << (poly.BITS * k): 1, 0: -1}
        low, high = atom_bounds(s_atom, self.bounds)
        s = self.adjoined(Generator(s_atom, s_atom.func.__name__, RootRelation(2, square), k, low, high))
        return (-s if turned else s), c

    def _log(self, argument: sp.Expr) -> Element:
        parts = sp.expand_log(sp.log(argument))
        if not isinstance(parts, sp.log):
            return self.element(parts)
        return self._logarithms.of(parts, self.element(parts.args[0]))

    # derivatives and writing -----------------------------------------------------------------------------------------

    def diff(self, x: Element, symbol: sp.Symbol) -> Element:
        """∂x/∂symbol."""
        return self.field.total(self.diff_terms(x, symbol))

    def diff_terms(self, x: Element, symbol: sp.Symbol) -> list[Element]:
        """∂x/∂symbol as a sum that is left as it is: one term for each factor that holds the symbol.

        Args:
            x: an element of the field.
        """
        field = self.field
        slope = self._poly_diff(x.numerator, symbol)
        kept = Element(field, x.coefficient, {0: 1}, x.factors)
        terms = [] if slope.is_zero else [field.product([slope, kept])]
        for b, e in x.factors.items():
            slope = self._poly_diff(field.bases[b], symbol)
            if not slope.is_zero:
                lowered = {**x.factors, b: e - 1}
                kept = Element(field, x.coefficient * e, x.numerator, {k: n for k, n in lowered.items() if n})
                terms.append(field.product([slope, kept]))
        return terms

    def log_diff(self, x: Element, symbol: sp.Symbol) -> Element:
        """∂ ln x/∂symbol: only the factors that hold the symbol enter."""
        return self.field.total(self.log_diff_terms(x, symbol))

    def log_diff_terms(self, x: Element, symbol: sp.Symbol) -> list[Element]:
        """∂ ln x/∂symbol as a sum that is left as it is."""
        field = self.field
        terms = []
        for b, e in field.factored(x).factors.items():
            slope = self._poly_diff(field.bases[b], symbol)
            if not slope.is_zero:
                terms.append(field.product([slope, Element(field, Fraction(e), {0: 1}, {b: -1})]))
        return terms

    def _poly_diff(self, a: Poly, symbol: sp.Symbol) -> Element:
        field = self.field
        terms = []
        for k in poly.generators(a):
            slope = self.generator_diff(k, symbol)
            if not slope.is_zero:
                terms.append(field.product([field.from_poly(poly.partial(a, k)), slope]))
        return field.total(terms)

    def generator_diff(self, k: int, symbol: sp.Symbol) -> Element:
        """Return ∂(generator k)/∂symbol.

        Args:
            k: the index of a generator of the field.
        """
        if (k, symbol) not in self._derivatives:
            atom = self.field.generators[k].atom
            depends = symbol in atom.free_symbols
            self._derivatives[k, symbol] = self.element(self._slope_by(symbol)(atom)) if depends else self.field.zero
        return self._derivatives[k, symbol]

    def write(self, x: Element) -> sp.Expr:
        """Return the element as a sympy expression: coefficient · factors · numerator, nothing expanded."""
        c = sp.Rational(x.coefficient.numerator, x.coefficient.denominator)
        parts = [self.write_poly(self.field.bases[b]) ** e for b, e in sorted(x.factors.items())]
        return sp.Mul(c, *parts, self.write_poly(x.numerator))

    def write_poly(self, a: Poly) -> sp.Expr:
        """Return a polynomial as a sympy expression."""
        generators = self.field.generators
        terms = (sp.Mul(c, *[generators[k].atom ** e for k, e in poly.exponents(m)]) for m, c in a.items())
        return sp.Add(*terms)


def _is_zero(x: sp.Expr) -> bool:
    """Return a proof that a constant is zero."""
    try:
        lower, upper = enclose(x, {}, 64)
    except NoEnclosureError:
        return False
    return lower <= 0 <= upper and constant_is_zero(at_one_place(x)) is True


def _pair_handler(kind: str, combine: Callable[[Element, Element], Element]) -> Callable[[Reader, sp.Expr], Element]:
    def handler(reader: Reader, argument: sp.Expr) -> Element:
        return combine(*reader._pair(kind, argument))

    return handler


_COMBINATIONS: tuple[Callable[[Element, Element], Element], ...] = (
    lambda s, _: s,
    lambda _, c: c,
    lambda s, c: s / c,
    lambda s, c: c / s,
    lambda _, c: c**-1,
    lambda s, _: s**-1,
)

_HANDLERS: dict[object, Callable[[Reader, sp.Expr], Element]] = {
    **{f: _pair_handler("angle", h) for f, h in zip(TRIGONOMETRIC, _COMBINATIONS, strict=True)},
    **{f: _pair_handler("rapidity", h) for f, h in zip(HYPERBOLIC, _COMBINATIONS, strict=True)},
    sp.exp: Reader._exp,
    sp.log: Reader._log,
    sp.Abs: lambda reader, x: root(reader, reader.element(x) ** 2, 1, 2),
    sp.acos: lambda reader, x: (reader.element(sp.pi) / 2) - reader.element(sp.asin(x)),
    sp.sign: lambda reader, x: reader.element(x) / reader.element(sp.Abs(x)),
}


def is_shifted(argument: sp.Expr, coordinates: Collection[sp.Symbol]) -> bool:
    """Tell whether an argument is that of one coordinate, moved by something that holds none."""
    parts = [part.free_symbols.intersection(coordinates) for part in sp.Add.make_args(sp.expand(argument))]
    return len(parts) > 1 and not all(parts) and len(set().union(*parts)) == 1


def rational_multiples(x: sp.Expr) -> list[tuple[sp.Expr, Fraction]]:
    """Return an expression as Σ coefficient · monomial with rational coefficients.

    Args:
        x: an argument of a function, or an exponent.
    """
    pairs = sp.expand(x).as_coefficients_dict().items()
    return [(m, Fraction(int(c.p), int(c.q))) for m, c in pairs if c.is_Rational and c != 0]


def rational_gcd(a: Fraction, b: Fraction) -> Fraction:
    """Return the greatest rational number of which both are integer multiples.

    Args:
        a, b: not both zero.
    """
    return Fraction(gcd(a.numerator * b.denominator, b.numerator * a.denominator), a.denominator * b.denominator)
