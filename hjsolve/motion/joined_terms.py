"""p² as a sum of coefficients times different functions of q, so that what cancels does so in exact numbers.

L²/r² − 2b/r² keeps no digit of L² − 2b in doubles, and over an interval nothing is known of its sign; the square of a
top, (p_φ − p_ψ cos θ)²/sin² θ, is 0/0 at θ = 0 where p_φ = p_ψ. With x = cos θ partial fractions give

    (a − b x)²/(1 − x²) = (a − b)²/(2 (1 − x)) + (a + b)²/(2 (1 + x)) − b²,   1 − x = 2 sin²(θ/2),  1 + x = 2 cos²(θ/2).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import sympy as sp

_CLOSE = sp.Rational(1, 64)
"""A coefficient below that part of its terms is taken as one exact number."""
_LONGEST = 400
"""Operations of a formula above which it is left as it stands."""


@lru_cache(maxsize=256)
def by_half_angles(F: sp.Expr, q: sp.Symbol) -> sp.Expr:
    """Write the fractions of a formula over sin²q by half angles where the two poles, q = 0 and π, differ."""
    terms = sp.Add.make_args(F)
    poles = [t for t in terms if any(b.has(q) and b.has(sp.sin, sp.cos) for b in _below(t))]
    if not poles or sum(sp.count_ops(t) for t in poles) > _LONGEST:
        return F
    s, x = sp.Dummy("s"), sp.Dummy("x")
    fraction = sp.Add(*poles).xreplace({sp.sin(q): s, sp.cos(q): x})
    if fraction.has(q) or not fraction.is_rational_function(s, x):
        return F
    above, below = (_even(part, s, x) for part in sp.fraction(sp.together(fraction)))
    if above is None or below is None:
        return _by_cancelling(F, fraction, poles, q, s, x)
    residues = [sp.cancel((above / below * (1 - x**2)).subs(x, -x) - above / below * (1 - x**2))]
    if residues[0] == 0:  # sin² alone stands below the line, and the same at both poles
        return F
    parts = sp.apart(sp.cancel(above / below), x)
    half = {x - 1: -2 * sp.sin(q / 2) ** 2, x + 1: 2 * sp.cos(q / 2) ** 2}
    found = [_with_halves(part, half).xreplace({x: sp.cos(q)}) for part in sp.Add.make_args(sp.expand_mul(parts))]
    return sp.Add(*found, *(t for t in terms if t not in poles))


def _below(term: sp.Expr) -> list[sp.Expr]:
    return [f.as_base_exp()[0] for f in sp.Mul.make_args(sp.fraction(term)[1])]


def _even(part: sp.Expr, s: sp.Dummy, x: sp.Dummy) -> sp.Expr | None:
    """Return a polynomial in s² with 1 − x² in its place; None where it is odd."""
    found = sp.Integer(0)
    for (power,), c in sp.Poly(part, s).terms():
        if power % 2:
            return None
        found += c * (1 - x**2) ** (power // 2)
    return found


def _by_cancelling(
    F: sp.Expr, fraction: sp.Expr, poles: list[sp.Expr], q: sp.Symbol, s: sp.Dummy, x: sp.Dummy
) -> sp.Expr:
    """Return half angles where they cancel a factor, (1 − cos q)/sin q = tan(q/2); else the formula as it stands."""
    S, C = sp.Dummy("S"), sp.Dummy("C")
    whole = sp.cancel(fraction.xreplace({s: 2 * S * C, x: 1 - 2 * S**2}))
    below = {f.as_base_exp()[0] for f in sp.Mul.make_args(sp.fraction(whole)[1]) if f.has(S, C)}
    if below not in ({S}, {C}):  # a pole elsewhere, or both still there
        return F
    rest = [t for t in sp.Add.make_args(F) if t not in poles]
    return sp.Add(whole.xreplace({S: sp.sin(q / 2), C: sp.cos(q / 2)}), *rest)


def _with_halves(part: sp.Expr, half: Mapping[sp.Expr, sp.Expr]) -> sp.Expr:
    """Return a product with powers of 1 ± x below the line written by half angles."""
    above, below = sp.fraction(sp.together(part))
    coefficient, product = sp.factor(above), sp.Integer(1)
    for base, power in (f.as_base_exp() for f in sp.Mul.make_args(sp.factor(below))):
        product *= half.get(base, -half[-base] if -base in half else base) ** power
    return coefficient / product


def with_exact_coefficients(e: sp.Expr, q: sp.Symbol, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Put a rational number for each coefficient whose terms nearly cancel; the formula as it stands where none do.

    Args:
        e: p² or one of its kernels.
        values: symbol → exact number.
    """
    close, changed = [], False
    for function, coefficients in _terms(e, q):
        total = sp.Add(*coefficients)
        numbers = [c.xreplace(dict(values)) for part in coefficients for c in sp.Add.make_args(sp.expand(part))]
        if len(numbers) > 1 and all(n.is_Rational for n in numbers):
            exact = sp.Add(*numbers)
            if abs(exact) < _CLOSE * sum(abs(n) for n in numbers):
                total, changed = exact, True
        close.append(total * function)
    return sp.Add(*close) if changed else e


@lru_cache(maxsize=512)
def _terms(e: sp.Expr, q: sp.Symbol) -> tuple[tuple[sp.Expr, tuple[sp.Expr, ...]], ...]:
    """Return function of q → coefficients of the terms that hold it."""
    if sp.count_ops(e) > _LONGEST:
        return ()
    opened = sp.expand(e, power_base=False, power_exp=False, log=False)
    found: dict[sp.Expr, list[sp.Expr]] = {}
    for term in sp.Add.make_args(opened):
        coefficient, function = term.as_independent(q, as_Add=False)
        found.setdefault(function, []).append(coefficient)
    return tuple((function, tuple(coefficients)) for function, coefficients in found.items())
