"""√P at a place by the roots of P, where these have names: next to a turning point all terms of a form round alike.

W varies as (x₁ − x)^{3/2} next to a turning point, and each of its terms as √(x₁ − x): the algebraic one through √P,
the integrals through the distance from x₁. With P from its coefficients both know x₁ − x to other roundings, and what
is left of their sum is their difference: 1e5 units of the last place by the condition in escapes of Hénon and Heiles.
With √P over the same distance the rounding of x₁ drops out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import sympy as sp

from hjsolve.closed_form.complete_integrals import roots_by_polynomial
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pairs_by_division import remaining_pair
from hjsolve.closed_form.regions import Where
from hjsolve.closed_form.tidy import elliptic, longer_than

_LONGEST = 80
"""Operations of a radicand that is compared with P: a longer one may take sympy seconds."""


class RadicandsByRoots:
    """The radicands of forms of one regime.

    Args:
        where: symbol → its definition.
        places: coordinate, or lower limit → its x.
    """

    def __init__(self, where: Where, places: Mapping[sp.Symbol, sp.Expr]):
        self._places = places
        self._factors = [*_factored(where)]
        self._known = dict[sp.Expr, sp.Expr]()

    def __call__(self, expression: sp.Expr) -> sp.Expr:
        """Return an equal expression, every √P at a place in it over the roots.

        Args:
            expression: of a form.
        """
        if not self._factors:
            return expression
        held = {p for p in expression.atoms(sp.Pow) if p.exp.is_Rational and p.exp.q == 2 and p.base.is_Add}
        return expression.xreplace({p: made**p.exp for p in held if (made := self._by_roots(p.base)) is not p.base})

    def _by_roots(self, base: sp.Expr) -> sp.Expr:
        if base not in self._known:
            self._known[base] = self._found(base)
        return self._known[base]

    def _found(self, base: sp.Expr) -> sp.Expr:
        held = [q for q in self._places if base.has(q)]
        if len(held) != 1 or elliptic(base) or longer_than(base, _LONGEST):
            return base
        place, x = self._places[held[0]], sp.Dummy("x", real=True)
        own = base.subs(place, x)
        if own.has(held[0]) or not own.is_polynomial(x):
            return base
        radicand = sp.Poly(own, x)
        for P, factors in self._factors:
            if radicand.degree() == P.degree():
                # the same radicand up to a factor, which stays outside of the product over the roots
                c = radicand.LC() / P.LC()
                if all(sp.expand(sp.numer(sp.together(a - c * b))) == 0
                       for a, b in zip(radicand.all_coeffs(), P.all_coeffs(), strict=True)):  # fmt: skip
                    return radicand.LC() * factors.subs(P.gen, place)
        return base


def _factored(where: Where) -> Iterator[tuple[sp.Poly, sp.Expr]]:
    """Yield the polynomials whose roots all have names, and each by its leading coefficient as a product over them."""
    for P, numbers in roots_by_polynomial(where).items():
        real = sorted({k: s for s, k in numbers.items()}.values(), key=numbers.__getitem__)
        try:
            pairs = remaining_pair(P, real)
        except NoFormError:
            continue
        named = {meaning: s for s, meaning in where.items() if isinstance(meaning, sp.Expr)}
        if all(part in named for pair in pairs for part in pair):
            across = ((P.gen - named[re]) ** 2 + named[im] ** 2 for re, im in pairs)
            yield P, sp.Mul(*(P.gen - r for r in real), *across)
