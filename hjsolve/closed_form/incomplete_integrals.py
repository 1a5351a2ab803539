"""Sums of incomplete elliptic integrals for doubles: F and Π of a pole next to a root, put together before rounding.

With d the root that s = sin²φ sends to infinity, 1/(x − r) is 1/(d − r) + β/(1 − ns) with

    n = (d − r)(b − a)/((a − r)(b − d)).

Where the pole r is next to d, both terms grow as 1/(d − r) and n vanishes: a F + A Π(n) is a small difference. With

    Π(n, φ) = F + n J,  J = ⅓ sin³φ R_J(cos²φ, 1 − m sin²φ, 1, 1 − n sin²φ)  for |φ| ≤ π/2

it is (a + A) F + A n J, and d − r drops out of both coefficients. About a black hole a root of the radicand is next to
the horizon where p_t is small: coordinate time lost 1e7 units of the last place, W 4e8.

Byrd and Friedman (1971) 310–336; DLMF 19.25.14.
"""

from __future__ import annotations

import sympy as sp

from hjsolve.closed_form.regions import Where
from hjsolve.closed_form.tidy import linear_in, longer_than
from hjsolve.functions import CarlsonRJ

_LONGEST = 250
"""Operations of a coefficient that is factored: longer ones may take sympy seconds."""
INCOMPLETE = (sp.elliptic_f, sp.elliptic_e, sp.elliptic_pi)


class IncompleteIntegrals:
    """The incomplete integrals of forms of one regime.

    Args:
        where: symbol → its definition.
    """

    def __init__(self, where: Where):
        self._where = where
        self._pairs = dict[tuple[sp.Expr, sp.Expr], sp.Expr | None]()

    def arranged(self, expression: sp.Expr) -> sp.Expr:
        """Return an equal expression, every pole that is next to a root put together with F.

        Args:
            expression: of a form.
        """
        if not any(len(i.args) == 3 for i in expression.atoms(sp.elliptic_pi)):
            return expression
        total = linear_in(expression, lambda i: isinstance(i, INCOMPLETE) and _amplitude(i) is not None)
        if total is None:
            return expression
        # beyond ±π/2 Π counts half turns, which R_J does not
        moved = {i: A for i, A in total.items() if isinstance(i, sp.elliptic_pi) and self._small(i.args[1])}
        for integral, A in moved.items():
            n, χ, m = integral.args
            first = sp.elliptic_f(χ, m)
            together = self._together(total.get(first, sp.S.Zero), A, n)
            if together is None:
                continue
            total[first], weight = together
            del total[integral]
            s = sp.sin(χ)
            part = s**3 * CarlsonRJ(sp.cos(χ) ** 2, 1 - m * s**2, 1, 1 - n * s**2) / 3
            total[part] = total.get(part, sp.S.Zero) + weight
        return sp.Add(*(one * c for one, c in total.items())) if any(i not in total for i in moved) else expression

    def _small(self, χ: sp.Expr) -> bool:
        """Whether an amplitude is known to be between ±π/2."""
        return isinstance(self._where.get(χ, χ), sp.asin)

    def _together(self, a: sp.Expr, A: sp.Expr, n: sp.Expr) -> tuple[sp.Expr, sp.Expr] | None:
        """Return the coefficients of F and J; None where no part of a cancels with A next to a root."""
        own, n = _in_factors(self._written(A)), _in_factors(self._written(n))
        if longer_than(own, _LONGEST):
            return None
        gaps = _sums(sp.numer(n)) & _sums(sp.denom(own))
        parts = self._parts(a)
        # the term that came with this pole; the whole coefficient, where it is one quotient
        choices = [(part, [p for p in parts if p is not part]) for part in parts]
        choices.append((self._written(a), []))
        for held, left in choices if gaps else ():
            if not longer_than(held, _LONGEST) and not gaps & _sums(sp.denom(total := _in_factors(held + own))):
                return sp.Add(*left, total), _in_factors(own * n)
        return None

    def _parts(self, coefficient: sp.Expr) -> list[sp.Expr]:
        """Return the terms of a coefficient, each with its factors."""
        factors = sp.Mul.make_args(self._written(coefficient))
        sums = [f for f in factors if f.is_Add]
        longest = max(sums, key=lambda f: len(f.args), default=None)
        if longest is None:
            return [sp.Mul(*factors)]
        rest = sp.Mul(*(f for f in factors if f is not longest))
        return [rest * term for term in longest.args]

    def _written(self, coefficient: sp.Expr) -> sp.Expr:
        """Return a coefficient with the definitions of its own names, as c₄, but for roots and rates."""
        names = {f for f in sp.Mul.make_args(coefficient) if f.is_Symbol and f.name.startswith(("c", "nu"))}
        return coefficient.xreplace({s: e for s in names if isinstance(e := self._where.get(s), sp.Expr)})


def _amplitude(integral: sp.Expr) -> sp.Expr | None:
    arguments = {sp.elliptic_pi: 3}.get(type(integral), 2)
    return integral.args[-2] if len(integral.args) == arguments else None


def _sums(product: sp.Expr) -> set[sp.Expr]:
    """Return the factors that are sums, whatever their sign."""
    bases = (factor.as_base_exp()[0] for factor in sp.Mul.make_args(product))
    return {max(base, -base, key=sp.default_sort_key) for base in bases if base.is_Add}


def _in_factors(e: sp.Expr) -> sp.Expr:
    """Return a sum as one quotient in factors, its radicals letters: r₊ = M + √(M² − a²) is not multiplied out."""
    radicals = {p for p in e.atoms(sp.Pow) if p.exp.is_Rational and p.exp.q == 2}
    names = {p.base: sp.Dummy(positive=True) for p in radicals}
    plain = e.xreplace({p: names[p.base] ** (2 * p.exp) for p in radicals})
    return sp.factor(sp.together(plain)).xreplace({d: sp.sqrt(base) for base, d in names.items()})
