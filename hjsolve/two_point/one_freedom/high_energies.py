"""Bounds on the time to a turning point and back for all energies from some E on, where V grows without a bound.

With E = V(b), and c such that V″ ≥ 0 from c on, V lies below its chord: E − V ≥ (E − V_c)(b − q)/(b − c), so

    ∫_c^b μ dq/√(E − V) ≤ 2μ (b − c)/√(V(b) − V(c)),

which falls with b where (b − c) V′ ≥ 2(V − V_c). As no speed exceeds that at the least V,

    ∫_a^b μ dq/√(E − V) ≥ μ (b − a)/√(V(b) − V_min),

which rises where (b − a) V′ ≤ 2(V − V_min). Signs beyond a place are proved by asymptotic expansions.
"""

from __future__ import annotations

import numpy as np
import sympy as sp

from hjsolve.arithmetic.asymptotic_expansion import BITS
from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.interval import Interval
from hjsolve.arithmetic.sign_at_infinity import sign_before, sign_beyond
from hjsolve.lowering import lower
from hjsolve.two_point.one_freedom.travel_time import Line, Segment, outward

HIGHEST = 1e300
"""Stands for infinity as an energy."""
_CELLS = 400
_LESS = 2.0**20
"""The chord begins where V is so many times less."""
_BELOW = 0.99
UNKNOWN = Segment(Interval(0.0, np.inf), Interval(-np.inf, np.inf), turns=None, end=np.nan)


def far_time(line: Line, start: float, sign: int, E: float) -> Segment:
    """Enclose the time from a place to the turning point beyond it for all energies from E on.

    Args:
        line: V and μ.
        start: the place.
        sign: 1 upwards, −1 downwards.
        E: the least energy.
    """
    escaping = outward(line, start, sign, Interval(E, HIGHEST), _CELLS)
    if escaping.turns is False:
        return escaping
    if line.formulas[4] != 0:  # the mass depends on the place
        return UNKNOWN
    here = outward(line, start, sign, Interval(E, E), _CELLS)
    before = outward(line, start, sign, Interval(E / _LESS, E / _LESS), _CELLS) if E > 0 else here
    if here.turns is not True or before.turns is not True:
        return UNKNOWN
    b, c, begin = here.end, before.end, start
    # the turning points for E are a little before these places, and V there a little less than V(b)
    μ = float(line.over(np.array([start]), np.array([start]), 1)[3].high[0])
    infinite = not np.isfinite(line.high if sign > 0 else line.low)
    low, high = 0.0, np.inf
    Vc = line.value(c)
    if infinite and _signs(line, sign, c, _curvature(line)) > 0 and _signs(line, sign, c, _slope(line, sign)) > 0:
        if _signs(line, sign, b, _excess(line, c, Vc.low)) > 0 and Vc.high < E:
            # √(E − V_c) at the turning point itself, which is within a part in 10⁵ of b
            high = _across(line, start, c, sign, E) + 2 * μ * abs(b - c) / np.sqrt(E - Vc.high)
    elif not infinite and _rises_at_end(line, sign, c):
        end = line.high if sign > 0 else line.low
        if Vc.high < E:
            high = _across(line, start, c, sign, E) + 2 * μ * abs(end - c) / np.sqrt(E - Vc.high)
    if infinite and _signs(line, sign, b, _slope(line, sign)) > 0:
        V_min = _least(line, begin, b, sign)
        near = outward(line, start, sign, Interval(E * _BELOW, E * _BELOW), _CELLS)
        if near.turns and abs(near.end) < abs(b) and _signs(line, sign, near.end, -_excess(line, begin, V_min)) > 0:
            # from a place a little before on the bound rises, so it holds at the turning point of E too
            top = line.value(near.end).high
            low = μ * abs(near.end - begin) / np.sqrt(max(top - V_min, EPS)) * (1 - 1e-9)
    return Segment(Interval(low, high * (1 + 1e-9)), Interval(-np.inf, np.inf), turns=True, end=b)


def _curvature(line: Line) -> sp.Expr:
    return line.formulas[2]


def _slope(line: Line, sign: int) -> sp.Expr:
    return sign * line.formulas[1]


def _excess(line: Line, c: float, Vc: float) -> sp.Expr:
    """(q − c) V′ − 2(V − V_c), which does not depend on the direction."""
    V, slope = line.formulas[:2]
    return (line.q - sp.Rational(c)) * slope - 2 * (V - sp.Rational(Vc))


def _signs(line: Line, sign: int, start: float, formula: sp.Expr) -> int:
    """Return the sign of a formula beyond a place; 0 where it is not proved."""
    return sign_beyond(lower([sp.expand(formula)], [line.q]), [], sign, sign * start)


def _rises_at_end(line: Line, sign: int, c: float) -> bool:
    """Whether V rises and is convex from a place to the end of the domain."""
    context = multiprecision(BITS)
    end = line.high if sign > 0 else line.low
    distance = abs(context.mpf(end) - context.mpf(c))
    return all(
        sign_before(lower([formula], [line.q]), [], context.mpf(end), sign, distance) > 0
        for formula in (_slope(line, sign), _curvature(line))
    )


def _across(line: Line, start: float, c: float, sign: int, E: float) -> float:
    """Return an upper bound on the time from the start to c at energies from E on."""
    grid = np.linspace(start * sign, c * sign, _CELLS)
    V, *_ = line.over(grid[:-1], grid[1:], sign)
    μ = line.over(grid[:1], grid[:1], sign)[3]
    y = E - V.high
    return float(np.sum(np.diff(grid) * μ.high[0] / np.sqrt(y))) if np.all(y > 0) else np.inf


def _least(line: Line, start: float, b: float, sign: int) -> float:
    """Return a lower bound on V between two places."""
    grid = np.linspace(start * sign, b * sign, _CELLS)
    return float(np.min(line.over(grid[:-1], grid[1:], sign)[0].low))
