"""Poles that cancel, written so that no digit is lost next to them: log(1 + r)/r, (1 − exp(−r))/r, (√(1 + r²) − 1)/r².

Next to r = 0 the functions of r are rounded to parts of 1, and divided by r. With

    log(1 + u) = arsinh(u (1 + 1/(1 + u))/2),   log(s + √(s² + 1)) = arsinh s
    exp(u) = 1 + 2 exp(u/2) sinh(u/2),          cosh u = 1 + 2 sinh²(u/2),     cos u = 1 − 2 sin²(u/2)
    √w = c + (w − c²)/(√w + c)

(Abramowitz and Stegun 4.6.20, 4.5.20, 4.3.25) the ones cancel in exact numbers, and what stays is small with u. Roots,
cosines and hyperbolic cosines may always be written so. An arsinh has branch points that the logarithm has not, and
exp(u/2) sinh(u/2) overflows, or over a wide disk is not enclosed, where exp(u) is small: these two are for motions that
come near the pole.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

import sympy as sp

_NEAR = (sp.log, sp.exp)
_ALWAYS = (sp.cosh, sp.cos)
_NEARER, _SMALL, _WIDE = 2**13, sp.Rational(1, 1000), 30
"""How much nearer to q = 0 than the start p² is looked at; |u|/2 that loses digits, and that is too far out."""
_LONGEST = 400
"""Operations of a formula above which it is left as it stands."""


def without_removable_poles(F: sp.Expr, q: sp.Symbol, *, near: bool = False) -> sp.Expr:
    """Write the terms of a sum over powers of q, or of q − c, so that they keep their digits where the power is zero.

    Args:
        near: whether exponentials and logarithms are written so too.

    Returns:
        An equal formula for real q where F is real; F itself where no pole cancels.
    """
    functions = (*_ALWAYS, *_NEAR) if near else _ALWAYS
    known = {part for part in F.atoms(*functions, sp.Pow) if part.has(q) and (not part.is_Pow or part.exp == sp.S.Half)}
    if not known or sp.count_ops(F) > _LONGEST:
        return F
    kept, poles = [], defaultdict[tuple[sp.Expr, sp.Expr], list[sp.Expr]](list)
    for term in sp.Add.make_args(_multiplied_out(F)):
        pole = next(((b, n) for b, n in term.as_powers_dict().items() if _is_pole(b, n, q)), None)
        if pole is None:
            kept.append(term)
        else:
            poles[pole].append(term)
    changed = False
    for (base, power), terms in poles.items():
        place = -base.subs(q, 0) / sp.diff(base, q)
        for group in _groups(terms, base**power, place, q):
            above = sp.Add(*(term / base**power for term in group))
            regular = _small(above, known, place, q)
            changed = changed or regular is not None
            kept.append(_multiplied_out((above if regular is None else regular) * base**power))
    return sp.Add(*kept) if changed else F


def _multiplied_out(e: sp.Expr) -> sp.Expr:
    """Multiply the products of a sum out, but not what stands inside functions."""
    return sp.Add(
        *(sp.expand(t, deep=False, power_exp=False, power_base=False, log=False) for t in sp.Add.make_args(e))
    )


def _groups(terms: list[sp.Expr], pole: sp.Expr, place: sp.Expr, q: sp.Symbol) -> list[list[sp.Expr]]:
    """Return all terms over a pole, or, where together they do not vanish there, those with each coefficient."""
    if sp.expand(sp.Add(*(term / pole for term in terms)).subs(q, place)) == 0:
        return [terms]
    groups = defaultdict[sp.Expr, list[sp.Expr]](list)
    for term in terms:
        groups[term.as_independent(q, as_Add=False)[0].as_coeff_Mul()[1]].append(term)
    return list(groups.values())


def _is_pole(base: sp.Expr, power: sp.Expr, q: sp.Symbol) -> bool:
    return bool(power.is_Integer and power < 0 and base.is_polynomial(q) and sp.degree(base, q) == 1)


def _small(above: sp.Expr, known: set[sp.Expr], place: sp.Expr, q: sp.Symbol) -> sp.Expr | None:
    """Return a sum that vanishes at a place as a sum of such terms; None where it does not, or nothing changes."""
    parts = sorted(known & above.atoms(sp.Function, sp.Pow), key=sp.default_sort_key)
    new = {part: written for part in parts if (written := _about(part, part.subs(q, place))) is not None}
    if not new or sp.expand(above.subs(q, place)) != 0:
        return None
    hidden = {part: constant + sp.Dummy() for part, (constant, _) in new.items()}
    opened = _multiplied_out(above.xreplace(hidden))
    return opened.xreplace({hidden[part] - constant: small for part, (constant, small) in new.items()})


def _about(part: sp.Expr, value: sp.Expr) -> tuple[sp.Expr, sp.Expr] | None:
    """Return (value at the place, what is small next to it); None where nothing is known."""
    u = part.args[0]
    if isinstance(part, sp.log) and value == 0:
        return sp.S.Zero, _logarithm(u)
    if isinstance(part, sp.exp) and value == 1:
        return sp.S.One, 2 * sp.exp(u / 2) * sp.sinh(u / 2)
    if isinstance(part, sp.cosh) and value == 1:
        return sp.S.One, 2 * sp.sinh(u / 2) ** 2
    if isinstance(part, sp.cos) and value == 1:
        return sp.S.One, -2 * sp.sin(u / 2) ** 2
    if part.is_Pow and value.is_positive:
        return value, sp.cancel(part.base - value**2) / (part + value)
    return None


def along_motion(F: sp.Expr, q: sp.Symbol, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Write p² of one motion for what it comes near: the form of the pole where digits are lost next to it.

    Args:
        F: p²(q).
        values: symbol → exact number, of the start, the constants and the parameters.

    Returns:
        F, or an equal formula.
    """
    written = without_removable_poles(F, q, near=True)
    small = [f.args[0] for f in written.atoms(sp.sinh, sp.asinh) - F.atoms(sp.sinh, sp.asinh)]
    if not small:
        return F

    def largest(place: sp.Expr) -> sp.Float:
        return max(abs(sp.N(u.xreplace({**values, q: place}), 30)) for u in small)

    here = values[q]
    closer = here / _NEARER
    reached = closer if sp.N(written.xreplace({**values, q: closer}), 30) > 0 else here
    return written if largest(reached) < _SMALL and largest(here) < _WIDE else F


def _logarithm(w: sp.Expr) -> sp.Expr:
    """Return log(w), small next to w = 1, as an arsinh."""
    for root in (t for t in sp.Add.make_args(w) if t.is_Pow and t.exp == sp.S.Half):
        s = w - root
        if sp.expand(root.base - s**2) == 1:
            return sp.asinh(s)
    u = sp.expand(w - 1)
    return sp.asinh(u * (1 + 1 / w) / 2)
