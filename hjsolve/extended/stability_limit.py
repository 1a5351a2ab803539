"""Where a linear system becomes stable as one of its parameters changes.

The exponents come in pairs ±λ, the roots in s = λ² of p(s) = det(M s + (G − Gᵀ) √s + K). The motion is stable where all
of them are real, negative and simple (Greenwood (3-129)). That can change only where two roots meet, one passes 0 or
one comes from infinity: at the real zeros of disc_s(p), of p(0) and of det M. Between two such values one exact test
at a rational value decides; the zeros themselves are isolated exactly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import sympy as sp

from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError, InvalidSystemError
from hjsolve.extended.gyroscopic import LAMBDA, LinearModes, is_stable
from hjsolve.motion.initial_data import parameter_values

_DIGITS = 20


@dataclass(frozen=True, repr=False)
class StableRange(Shown):
    """An open interval of a parameter in which the answer is the same.

    Attributes:
        lower, upper: its ends, exact algebraic numbers; −∞ and ∞ beyond the last ones.
        stable: whether no motion grows there.
    """

    lower: sp.Expr
    upper: sp.Expr
    stable: bool

    def __str__(self) -> str:
        """Return the interval and the answer."""
        ends = [str(sp.N(end, 8)) for end in (self.lower, self.upper)]
        return f"{ends[0]} to {ends[1]}: {'stable' if self.stable else 'not stable'}"


def stability_ranges(modes: LinearModes, parameter: str) -> tuple[StableRange, ...]:
    """Return the intervals of a parameter with the same answer to the question of stability, from −∞ to ∞.

    Args:
        modes: of the system, whose other parameters keep the values they have there.
        parameter: the name of the one that changes.

    Raises:
        InvalidInputError: the system has no such parameter, or it does not change the exponents.
        InvalidSystemError: the characteristic equation does not depend on the parameter by a polynomial with rational
            coefficients.
    """
    symbol = modes.system.symbols.get(parameter)
    if symbol is None or symbol not in modes.polynomial.free_symbols:
        raise InvalidInputError(f"stability: the exponents do not depend on a parameter {parameter[:40]}")
    s = sp.Symbol("s")
    others = {x: v for x, v in modes.values.items() if x != symbol}
    p = sp.expand(modes.polynomial.subs(others).subs(LAMBDA, sp.sqrt(s)))
    if not p.is_polynomial(s, symbol) or not sp.Poly(p, s, symbol).domain.is_Numerical:
        raise InvalidSystemError(f"stability: the exponents are not an algebraic function of {parameter}")
    in_s = sp.Poly(p, s)
    events = [in_s.LC(), in_s.nth(0)] + ([sp.discriminant(p, s)] if in_s.degree() > 1 else [])
    product = sp.Poly(sp.Mul(*(e for e in events if e != 0)), symbol, domain="QQ")
    ends = [-sp.oo, *_real_zeros(product), sp.oo]
    found: list[StableRange] = []
    for lower, upper in pairwise(ends):
        stable = _stable_at(modes, parameter, others, _between(lower, upper))
        if stable is None:
            continue
        joined = found and found[-1].stable == stable and found[-1].upper == lower
        if joined and (not stable or _stable_at(modes, parameter, others, lower)):
            found[-1] = StableRange(found[-1].lower, upper, stable)
        else:
            found.append(StableRange(lower, upper, stable))
    return tuple(found)


def _real_zeros(product: sp.Poly) -> list[sp.Expr]:
    """Return the distinct real zeros, in order."""
    if product.degree() < 1:
        return []
    zeros = {zero for factor, _ in product.factor_list()[1] for zero in factor.real_roots(multiple=True)}
    return sorted(zeros, key=lambda zero: sp.N(zero, 2 * _DIGITS))


def _between(lower: sp.Expr, upper: sp.Expr) -> sp.Rational:
    """Return a rational number inside an interval, with few digits."""
    if lower == -sp.oo and upper == sp.oo:
        return sp.Integer(1)
    if lower == -sp.oo:
        return sp.Integer(sp.floor(sp.N(upper, _DIGITS))) - 1
    if upper == sp.oo:
        return sp.Integer(sp.ceiling(sp.N(lower, _DIGITS))) + 1
    middle, width = sp.Rational(str(sp.N((lower + upper) / 2, _DIGITS))), sp.N(upper - lower, _DIGITS)
    return middle.limit_denominator(int(4 / width) + 2)


def _stable_at(modes: LinearModes, parameter: str, others: Mapping[sp.Symbol, sp.Expr], value: sp.Expr) -> bool | None:
    """Whether it is stable at a value; None where the value contradicts what was declared, or has no radicals."""
    if value.has(sp.CRootOf):
        return None
    given = {x.name: v for x, v in others.items()} | {parameter: value}
    try:
        return is_stable(modes.system, parameter_values(modes.system, given))
    except InvalidSystemError:
        return None
