"""Letters of P in its named roots, by Vieta's formulas: what cancels next to a root far away, without it.

Where the leading coefficient a of P = axⁿ + bxⁿ⁻¹ + cxⁿ⁻² + … is small, as with a small energy, one root is near −b/a
and a x₁² + b x₁ is a small difference: − a x₁ (x₂ + … + xₙ). Letters that are linear in b and c are written by a and
the roots, b = − a Σ xⱼ and c = a Σ xⱼ xₖ.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import mpmath
import sympy as sp

from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.regions import Where, ordered_real_roots, with_named
from hjsolve.precision import mp

_FAR = 2**-10
"""Part of a letter at which the root that it sends to infinity is far away."""
_DIGITS = 30
"""Of what is only looked at for digits lost."""


def in_roots(expression: sp.Expr, roots: Mapping[sp.Poly, Mapping[sp.Symbol, int]]) -> sp.Expr:
    """Return an expression with letters of P by its leading coefficient and its roots, where all of these have names.

    Args:
        expression: of letters and roots.
        roots: polynomial → root → its number.
    """
    for P, numbers in roots.items():
        # of one family alone: a product over roots of two names would be another polynomial
        for named in _families(P, numbers):
            if expression.free_symbols & set(named):
                table = _letters(P, named)
                expression = expression.xreplace({s: e for s, e in table.items() if s in expression.free_symbols})
    return expression


def _families(P: sp.Poly, numbers: Mapping[sp.Symbol, int]) -> Iterator[list[sp.Symbol]]:
    """Yield the roots in order; two coordinates with the same P each have names for them."""
    families = dict[str, list[sp.Symbol]]()
    for symbol in sorted(numbers, key=numbers.__getitem__):
        families.setdefault(symbol.name.rpartition("_")[0], []).append(symbol)
    yield from (named for named in families.values() if len(named) == P.degree())


def _letters(P: sp.Poly, named: Sequence[sp.Symbol]) -> dict[sp.Symbol, sp.Expr]:
    """Return letters that are linear in the second and the third coefficient, by roots and what is left of letters."""
    leading, found = P.LC(), dict[sp.Symbol, sp.Expr]()
    # Vieta: b = −a Σ xⱼ, c = a Σ xⱼxₖ; a letter found from b is already written by roots in c
    for k in (1, 2):
        own = sp.expand(P.all_coeffs()[k]).xreplace(found)
        # the k-th elementary symmetric function of the roots
        value = (-1) ** k * leading * sp.Add(*(sp.Mul(*some) for some in combinations(named, k)))
        free = own.free_symbols - leading.free_symbols - set(named)
        letter = next((s for s in sorted(free, key=str) if sp.degree(own, s) == 1), None)
        if letter is not None:
            found[letter] = sp.cancel((value - own.subs(letter, 0)) / own.coeff(letter))
    return found


def far_points(where: Where, example: Mapping[sp.Symbol, mpmath.mpf]) -> list[dict[sp.Symbol, mpmath.mpf]]:
    """Return motions next to that of the example, with the same real roots, of which one is far away.

    Args:
        where: symbol → its definition.
        example: symbol → its value at a motion of the regime.
    """
    points, given = list[dict[sp.Symbol, mpmath.mpf]](), {s: v for s, v in example.items() if s not in where}
    polynomials = dict.fromkeys(meaning[0] for meaning in where.values() if isinstance(meaning, tuple))
    letters = dict.fromkeys(s for P in polynomials for s in P.LC().free_symbols if _sends_far(P, s) and s in given)
    for letter in letters:
        with mp.workdps(_DIGITS):
            point = _with_names(where, {**given, letter: given[letter] * _FAR})
        if point is not None:
            points.append(point)
    return points


def _sends_far(P: sp.Poly, letter: sp.Symbol) -> bool:
    leading, second = P.all_coeffs()[:2]
    # a x² + b x + …: with a → 0 one root goes to −b/a, the others to those of what is left
    return bool(leading.subs(letter, 0) == 0 and second.subs(letter, 0) != 0)


def _with_names(where: Where, point: Mapping[sp.Symbol, mpmath.mpf]) -> dict[sp.Symbol, mpmath.mpf] | None:
    """Return a point with the values of the names that are real there; None where a root is not."""
    try:
        known = with_named(needed_names(where, where)[0], point, _DIGITS)
    except IndexError:
        return None
    polynomials = {meaning[0] for symbol, meaning in where.items() if isinstance(meaning, tuple) and symbol in known}
    # a root that is complex there has no number among real roots: another regime
    return known if all(len(ordered_real_roots(P, known, _DIGITS)) == P.degree() for P in polynomials) else None
