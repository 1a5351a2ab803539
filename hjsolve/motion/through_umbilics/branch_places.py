"""Is a place where h = 0 one where only the coordinates branch? Umbilics of an ellipsoid, foci of elliptic coordinates.

With T = ½ h (a q̇₁² + b q̇₂²), a of q₁ and b of q₂ alone, and h = f(q₁) + g(q₂) zero at (e₁, e₂), all even about e₁ and
e₂, places are functions of (u + i v)², du = √a dq₁, dv = √b dq₂, and T and V are regular there when f and −g are one
function of u² and −v²: then h, and p₁² a⁻¹ + p₂² b⁻¹ = 2 h (E − V), vanish together on u² + v² = 0. Two conditions say
so along h(q₁, q₂) = 0 with q₁ − e₁ imaginary and q₂ real,

    (∂₁h)²/a + (∂₂h)²/b = 0,        p₁²/a + p₂²/b = 0;

they are looked at with 40 digits at two places (an identity of analytic functions that fails somewhere fails almost
everywhere), evenness is decided exactly.
"""

from __future__ import annotations

from functools import lru_cache

import sympy as sp

from hjsolve.mechanics.system import System, kinetic_rest, linear_terms, mass_matrix
from hjsolve.separation import Zero, is_zero

_DIGITS, _TOLERANCE = 40, 20  # decimal; second derivatives lose fewer than the difference
_SAMPLES = ("0.11", "0.17")
_SECONDS = 3.0
_INFINITE = (sp.zoo, sp.nan, sp.oo, -sp.oo)


Known = tuple[tuple[sp.Symbol, sp.Expr], ...]
"""Parameters and their exact numbers."""


@lru_cache(maxsize=64)
def metric_ratio(system: System, known: Known, place: tuple[sp.Expr, ...]) -> sp.Expr | None:
    """Return a/b at a place where M₁₁ = h a and M₂₂ = h b vanish; None where the place does not look like a branch.

    Args:
        system: of two coordinates.
        known: parameters and their exact numbers.
        place: e₁, e₂, exact.
    """
    values, M, q = dict(known), mass_matrix(system), [c.symbol for c in system.coordinates]
    if M.rows != 2 or M[0, 1] != 0 or any(a != 0 for a in linear_terms(system)) or system.relativity is not None:
        return None
    V = system.potential - kinetic_rest(system)
    at = dict(zip(q, place, strict=True))
    for f in (M[0, 0], M[1, 1]):
        if not _vanishes(f.subs(at).subs(values)):
            return None
    for f in (M[0, 0], M[1, 1], V):
        for s, e in at.items():
            if not _vanishes(f - f.xreplace({s: 2 * e - s})):
                return None
    bends = [sp.diff(f, q[0], 2).subs(at).subs(values) for f in (M[0, 0], M[1, 1])]
    if any(b.has(*_INFINITE) or _vanishes(b) for b in bends):
        return None
    return sp.sympify(bends[0] / bends[1])


def _vanishes(f: sp.Expr) -> bool:
    return bool(f == 0 or (not f.has(*_INFINITE) and isinstance(is_zero(f, budget=_SECONDS), Zero)))


@lru_cache(maxsize=64)
def branches_only(
    system: System, known: Known, place: tuple[sp.Expr, ...], squares: tuple[sp.Expr, ...]
) -> bool:  # fmt: skip
    """Tell whether T and V are regular at a place of which ``metric_ratio`` has a value.

    Args:
        system: of two coordinates.
        known: parameters and their exact numbers.
        place: e₁, e₂, exact.
        squares: p₁²(q₁) and p₂²(q₂), of numbers and coordinates alone.
    """
    M, q = mass_matrix(system).subs(dict(known)), [s.symbol for s in system.coordinates]
    first, second, beyond = M[0, 0], M[1, 1], sp.diff(M[0, 0], q[1])
    slopes = [sp.diff(first, q[0]), sp.diff(second, q[1]), sp.diff(second, q[0])]

    def number(f: sp.Expr, one: sp.Expr, two: sp.Expr) -> sp.Expr:
        return sp.N(f.subs({q[0]: one, q[1]: two}), _DIGITS, maxn=8 * _DIGITS)

    at = dict(zip(q, place, strict=True))
    bends = sp.diff(first, q[0], 2) / sp.diff(first, q[1], 2)
    start = sp.Rational(float(sp.sqrt(abs(sp.N(bends.subs(at), 15)))))  # a fraction: a Float would keep 15 digits
    for sample in _SAMPLES:
        one = place[0] + sp.I * sp.Rational(sample)
        two = place[1] + start * sp.Rational(sample)
        for _ in range(60):
            off, slope = number(first, one, two), number(beyond, one, two)
            if slope == 0:
                return False
            step = sp.re(off / slope)
            two = sp.N(two - step, _DIGITS)
            if abs(step) < sp.Float(10) ** (5 - _DIGITS):
                break
        else:
            return False
        along, across, other = (number(f, one, two) for f in slopes)
        ratio = along / other
        sums = ((along**2, ratio**3 * across**2), (number(squares[0], one, two), ratio * number(squares[1], one, two)))
        if any(abs(x + y) > sp.Float(10) ** (-_TOLERANCE) * (abs(x) + abs(y)) for x, y in sums):
            return False
    return True
