"""Differences that lose digits in doubles, as quotients: 1 − x₃ where a root is next to 1, sums of complete integrals.

With all roots of P named, c − x₃ = P(c)/(a (c − x₁)(c − x₂)), a the leading coefficient; of a complex pair α ± iβ the
last two factors are (c − α)² + β². Where P(c) is one term nothing is subtracted in it: of the spherical pendulum P(1)
is p_φ², and x₃ is next to 1 where the pendulum nearly passes the vertical.

Of a root that is named and written in radicals, x₁ = √((u + √D)/v), 1 − x₁ is (v − u − √D)/(v (1 + x₁)), and v − u − √D
is a quotient again: of cos θ₁ in Kerr's field ((v − u)² − D)/(v − u + √D), where (v − u)² − D is a product with p_φ².
Sums of complete integrals: ``complete_integrals.py``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from types import MappingProxyType

import mpmath
import sympy as sp
from sympy.core.relational import Relational

from hjsolve.closed_form.arcs import arcs_by_tangents, radicands_of
from hjsolve.closed_form.common_factors import grouped
from hjsolve.closed_form.complete_integrals import CompleteIntegrals, roots_by_polynomial
from hjsolve.closed_form.evaluation import number_of
from hjsolve.closed_form.incomplete_integrals import IncompleteIntegrals
from hjsolve.closed_form.named_forms import NamedForms
from hjsolve.closed_form.named_quantities import written_out
from hjsolve.closed_form.numbers import at_example
from hjsolve.closed_form.pairs_by_division import deflated_pair, remaining_pair
from hjsolve.closed_form.radicands_by_roots import RadicandsByRoots
from hjsolve.closed_form.regions import Where
from hjsolve.closed_form.tidy import elliptic, longer_than, operations
from hjsolve.precision import mp

_LONGEST = 60
"""Operations of a sum that is looked at: a longer one may take sympy seconds."""

_MOST_TERMS = 24
"""Terms of u² − D that are factored: more than ten never came out short (Vinti's forms, Stark's), and took seconds."""


class ForDoubles:
    """Forms of one regime, and the definitions of their names, written so that doubles lose fewer digits.

    Args:
        where: symbol → its definition.
        example: symbol → its value at a motion of the regime, of constants and of names: signs and order are its.
        forms: of the regime, whose radicands arcs are written by.
        places: coordinate, or lower limit → its x, in which P is a polynomial.
    """

    def __init__(
        self, where: Where, example: Mapping[sp.Symbol, mpmath.mpf], forms: Iterable[sp.Expr] = (),
        places: Mapping[sp.Symbol, sp.Expr] = MappingProxyType({}),
    ):  # fmt: skip
        self.where, self._integrals = where, CompleteIntegrals(where, example)
        self._example = example
        self._roots = {s: value for s, value in example.items() if isinstance(where.get(s), tuple)}
        self._radicals = {s: value for s, value in example.items() if isinstance(where.get(s), sp.Expr)}
        plain = [meaning for meaning in where.values() if not isinstance(meaning, tuple)]
        self._radicands = radicands_of([*forms, *plain])
        self._by_roots, self._incomplete = RadicandsByRoots(where, places), IncompleteIntegrals(where)
        self._complements = dict[sp.Symbol, sp.Expr | None]()
        self._known = dict[sp.Expr, sp.Expr]()  # definitions that several forms rest on are arranged once

    @classmethod
    def of(cls, form: NamedForms) -> ForDoubles:
        """Return it for a regime.

        Args:
            form: of the regime.
        """
        places = dict[sp.Symbol, sp.Expr]()
        for curve, _ in form.regime.regions:
            q, place = curve.coordinate.symbol, curve.substitution.place
            start = form.solution.lower_limits[curve.coordinate.name]
            places |= {q: place, start: place.subs(q, start)}
        return cls(form.where, at_example(form, form.where), form.named().values(), places)

    def form(self, expression: sp.Expr) -> sp.Expr:
        """Return an equal expression that loses fewer digits.

        Args:
            expression: of a form, or a definition.
        """
        if expression not in self._known:
            self._known[expression] = self._arranged(expression)
        return self._known[expression]

    def _arranged(self, expression: sp.Expr) -> sp.Expr:
        made = self._by_roots(self._integrals.arranged(self._incomplete.arranged(expression)))
        conditions = {c: sp.Dummy() for c in made.atoms(Relational)}  # any digits decide them, and no quotient within
        plain = arcs_by_tangents(made.xreplace(conditions), self.where, self._radicands)
        plain = plain.xreplace(self._gaps(plain) | self._gaps_of_radicals(plain))
        plain = plain.xreplace({a: b for a in plain.atoms(sp.Add) if (b := _small(a)) is not a})
        return plain.xreplace({name: c for c, name in conditions.items()})

    def definitions(self, wanted: Iterable[sp.Symbol]) -> dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]:
        """Return the definitions of names, and of those that they rest on.

        Args:
            wanted: symbols of a form.
        """
        found, waiting = dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]](), [*wanted]
        while waiting:
            symbol = waiting.pop()
            if symbol in found or symbol not in self.where:
                continue
            meaning = self.where[symbol]
            if isinstance(meaning, tuple):
                found[symbol] = meaning
                waiting += meaning[0].free_symbols_in_domain
            else:
                found[symbol] = made = self._part_of_pair(meaning) or self.form(meaning)
                waiting += made.free_symbols
        return found

    def _gaps(self, expression: sp.Expr) -> dict[sp.Expr, sp.Expr]:
        """Return the differences of numbers and roots of P that are such quotients."""
        found, named, roots = dict[sp.Expr, sp.Expr](), roots_by_polynomial(self.where), self._roots
        for gap in expression.atoms(sp.Add):
            c, x = gap.as_coeff_Add()
            sign, x = x.as_coeff_Mul()
            meaning = self.where.get(x) if x.is_Symbol and c != 0 and sign in (1, -1) else None
            if not isinstance(meaning, tuple) or x not in roots:
                continue
            P, c = meaning[0], -sign * c
            others = [*{k: s for s, k in named[P].items() if k != meaning[1]}.values()]
            value, rest = sp.factor(P.as_expr().subs(P.gen, c)), self._rest(P, [x, *others], c)
            # P(c) of several terms cancels by itself: the lost digits would be moved, not kept
            if value.is_Add or value == 0 or rest is None or not all(s in roots for s in others):
                continue
            side = sp.Integer(1 if roots[x] > c else -1)
            # between c and x another root would be the one that is near
            if any(abs(roots[s] - c) < abs(roots[x] - c) for s in others if (roots[s] - c) * side > 0):
                continue
            quotient = -sign * value / (P.LC() * rest * sp.Mul(*(c - s for s in others)))
            beyond = [s for s in others if (roots[s] - c) * side < 0]
            if not beyond:  # no root can come nearer to c
                found[gap] = quotient
                continue
            nearest = min(beyond, key=lambda s: abs(roots[s] - c))
            found[gap] = sp.Piecewise((quotient, side * (x - c) < side * (c - nearest)), (gap, True))
        return found

    def _rest(self, P: sp.Poly, real: Sequence[sp.Symbol], c: sp.Expr) -> sp.Expr | None:
        """Return what P(c) by its leading coefficient is without real roots: 1, or the modulus of a pair's c − x."""
        if len(real) == P.degree():
            return sp.S.One
        if len(real) != P.degree() - 2 or P.degree() > 4 or not P.free_symbols_in_domain <= self._example.keys():
            return None
        ((_, across),) = remaining_pair(P, real)
        if mp.im(number_of(across, self._example)) != 0:  # real roots without names
            return None
        along, across = deflated_pair(P, real)
        return (c - along) ** 2 + across**2

    def _gaps_of_radicals(self, expression: sp.Expr) -> dict[sp.Expr, sp.Expr]:
        """Return the differences of ±1 and a root written in radicals that lose fewer digits as quotients."""
        found = dict[sp.Expr, sp.Expr]()
        for gap in expression.atoms(sp.Add):
            one, x = gap.as_coeff_Add()
            sign, x = x.as_coeff_Mul()
            if abs(one) != 1 or abs(sign) != 1 or x not in self._radicals or -one * sign * self._radicals[x] <= 0:
                continue
            if x not in self._complements:
                self._complements[x] = _complement(written_out(self.where[x], self.where))
            rest = self._complements[x]  # 1 − x²
            if rest is not None:
                # c (c − x) = (1 − x²)/(1 + c x) with c = ±1, the nearer to x: nothing cancels in 1 + c x
                found[gap] = one * rest / (1 - one * sign * x)
        return found

    def _part_of_pair(self, meaning: sp.Expr) -> sp.Expr | None:
        """Return the real or imaginary part of the pair that is left next to named real roots; None of another one."""
        for P, numbers in roots_by_polynomial(self.where).items():
            real = sorted(meaning.free_symbols & numbers.keys(), key=numbers.__getitem__)
            if len(real) == P.degree() - 2 and real:
                (pair,) = remaining_pair(P, real)
                if meaning in pair:
                    return deflated_pair(P, real)[pair.index(meaning)]
        return None


def _complement(x: sp.Expr) -> sp.Expr | None:
    """Return 1 − x² of x = √((u + √D)/v) without a difference of u and √D; None of another one."""
    square = x**2
    if longer_than(square, _LONGEST) or not any(_root_of_sum(t) for a in square.atoms(sp.Add) for t in a.args):
        return None
    top, bottom = sp.fraction(sp.together(1 - square))
    top = sp.expand(top)
    made = _small(top) if top.is_Add else top
    return None if made is top else made / sp.factor(bottom)


@lru_cache(maxsize=4096)  # forms of one regime, and regimes of one system, have most of their sums in common
def _small(total: sp.Expr) -> sp.Expr:
    """Write u + √D as (u² − D)/(u − √D) where the signs differ, if that is short; keep squares in sums as squares."""
    if total.is_positive or elliptic(total) or longer_than(total, _LONGEST):
        return total
    if (squares := _difference_of_squares(total)) is not None:
        return squares
    rooted = [t for t in total.args if _root_of_sum(t)]
    if len(rooted) != 1:
        return grouped(total)
    (root,) = rooted
    rest = total - root
    square = sp.expand(rest**2) - sp.expand(root**2)
    if len(sp.Add.make_args(square)) > _MOST_TERMS:
        return total
    above = sp.factor(square)
    longest = max((len(a.args) for a in above.atoms(sp.Add)), default=1)
    # u² − D keeps a long sum: the cancellation was moved, not mended
    if longest > len(sp.Add.make_args(rest)) + 1 or longer_than(above, operations(total)):
        return total
    return sp.Piecewise((total, rest * root >= 0), (above / (rest - root), True))


def _root_of_sum(term: sp.Expr) -> bool:
    """Whether a term is a multiple of √(a + …)."""
    return any(p.base.is_Add and p.exp == sp.S.Half for p in sp.Mul.make_args(term) if p.is_Pow)


def _difference_of_squares(total: sp.Expr) -> sp.Expr | None:
    """Return (x − b)(x + b) for x² − b² with x = (u + √D)/v, which is next to b; None of another sum.

    The turning points of an isochrone: r² = s² − b², s a root of a quadratic, next to b where p_θ → 0.
    """
    sides = list[tuple[sp.Expr, sp.Expr]]()
    for term in total.args:
        c, rest = term.as_coeff_Mul()
        powers = [f.as_base_exp() for f in sp.Mul.make_args(rest)]
        if any(not (power.is_Integer and power.is_even) for _, power in powers):
            return None
        sides.append((c, sp.sqrt(abs(c)) * sp.Mul(*(base ** (power / 2) for base, power in powers))))
    if len(sides) != 2 or sides[0][0] * sides[1][0] > 0:
        return None
    (_, b), (_, x) = sorted(sides, key=lambda side: side[0])
    if not any(_root_of_sum(t) for a in (x, b) for e in a.atoms(sp.Add) for t in e.args):
        return None
    value = sp.S.One
    for side in (-1, 1):
        top, bottom = sp.fraction(sp.together(x + side * b))
        top = sp.expand(top, deep=False)
        value *= (_small(top) if top.is_Add else top) / bottom
    return value
