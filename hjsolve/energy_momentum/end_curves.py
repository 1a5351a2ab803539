"""Critical curves at fixed places: at the ends of a domain, and where a symmetry makes P² stationary in q."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64
from hjsolve.energy_momentum.coordinate_kinds import CoordinateKinds
from hjsolve.energy_momentum.critical_curves import CriticalCurve, Window, real_roots_of_rows
from hjsolve.energy_momentum.multiple_roots import real_roots
from hjsolve.lowering import lower

_LARGEST = 10**7


def end_polynomials(own: CoordinateKinds) -> list[tuple[str, sp.Expr]]:
    """N at the ends of the domain, as polynomials in the two constants, and what is at that end.

    Args:
        own: the coordinate; nothing is found where its P² is not a polynomial, or where it is an angle.
    """
    if own.polynomial is None or own.polynomial.closed:
        return []
    s, N = own.polynomial.substitution, own.polynomial.polynomial
    domain = own.solution.system.coordinate(own.name).domain
    found = []
    ends = (s.lower, s.upper) if s.increasing else (s.upper, s.lower)
    for end, t in zip(("lower", "upper"), ends):
        value = sp.expand(N.subs(s.x, t)) if t.is_finite else sp.Poly(N, s.x).LC()
        bound = domain.lower if end == "lower" else domain.upper
        found.append(("edge of escape" if bound is None else "end of the domain", value))
    return found


def curves_at_ends(own: CoordinateKinds, window: Window) -> list[CriticalCurve]:
    """Return the curves on which P² vanishes at an end of the domain."""
    x, y = own.constants
    found: list[CriticalCurve] = []
    known: list[tuple[str, sp.Expr]] = []
    for kind, value in end_polynomials(own):
        if not value.has(x, y):
            continue
        for factor, _ in sp.factor_list(value, x, y)[1]:
            if (kind, factor) not in known:
                known.append((kind, factor))
                found += _zeros_of(own, kind, factor, window)
    return found


def _zeros_of(own: CoordinateKinds, kind: str, factor: sp.Expr, window: Window) -> list[CriticalCurve]:
    x, y = own.constants
    none = np.zeros(0)
    if not factor.has(y) or not factor.has(x):
        here, which = (x, 0) if factor.has(x) else (y, 1)
        roots = [float(r) for r in real_roots(sp.Poly(factor, here))]
        along = np.linspace(*window[1 - which], 2)
        lines = [(np.full(2, r), along) if which == 0 else (along, np.full(2, r)) for r in roots]
        return [CriticalCurve(kind, own.name, across, up, none, factor) for across, up in lines]
    across = np.linspace(*window[0], 401)
    rows = lower(sp.Poly(factor, y).all_coeffs(), [x]).run(Float64(), [across])
    table = np.stack([np.broadcast_to(c, across.shape) for c in rows], axis=1)
    heights = real_roots_of_rows(table)
    return [
        CriticalCurve(kind, own.name, across[good], column[good], none, factor)
        for column in heights.T if (good := np.isfinite(column)).sum() > 1
    ]  # fmt: skip


# ------------------------------------------------------------------------------------------------ symmetric places
def symmetric_curves(own: CoordinateKinds, window: Window) -> list[CriticalCurve]:
    """Return the curves P²(q; x, y) = 0 of places q at which ∂P²/∂q = 0 for all x and y.

    An equator, the line of two centres.
    """
    if own.polynomial is None:
        return []
    s, N = own.polynomial.substitution, own.polynomial.polynomial
    found = []
    slopes = sp.Poly(sp.diff(N, s.x), *own.constants).coeffs()
    common = sp.Integer(0)
    for slope in slopes:
        common = sp.gcd(common, slope)
    for t in real_roots(sp.Poly(common, s.x)) if common.has(s.x) else ():
        if s.lower < t < s.upper:
            exact = sp.nsimplify(t, rational=True, tolerance=1e-25)
            place = float(sp.N(s.inverse.subs(s.x, exact)))
            found += _resting(own, sp.diff(N, s.x, 2).subs(s.x, exact), sp.expand(N.subs(s.x, exact)), place, window)
    if own.polynomial.closed and s.upper.is_finite:  # t has its largest value at the opposite place: t = sin q/2
        bend, level = -sp.diff(N, s.x).subs(s.x, s.upper), sp.expand(N.subs(s.x, s.upper))
        found += _resting(own, bend, level, float(sp.N(s.inverse.subs(s.x, s.upper))), window)
    if own.polynomial.closed and s.upper is sp.oo:
        top, slope, bend = (sp.Poly(N, s.x).nth(sp.degree(N, s.x) - k) for k in range(3))
        if slope == 0:
            found += _resting(own, bend, top, float(sp.N(sp.limit(s.inverse, s.x, sp.oo))), window)
    return found


def _scaled(level: sp.Expr, constants: Sequence[sp.Symbol]) -> sp.Expr:
    """Return a multiple with short coefficients, where there is one.

    The place itself may be known to 30 digits only.
    """
    polynomial = sp.Poly(level, *constants)
    first = polynomial.LC()
    if not all(c.is_Rational for c in polynomial.coeffs()):
        return level
    terms = {powers: _short(c / first) for powers, c in polynomial.terms()}
    return sp.Poly(terms, *constants).as_expr()


def _short(value: sp.Rational) -> sp.Rational:
    """Return the fraction with a small denominator that a number is, to 20 digits; itself where it is none."""
    near = Fraction(int(value.p), int(value.q)).limit_denominator(_LARGEST)
    short = sp.Rational(near.numerator, near.denominator)
    return short if abs(short - value) < sp.Rational(1, 10**20) * max(1, abs(value)) else value


def _resting(own: CoordinateKinds, bend: sp.Expr, level: sp.Expr, place: float, window: Window) -> list[CriticalCurve]:
    """Return the zeros of a level, each part named by the sign of the bend there."""
    if not level.has(*own.constants):
        return []
    found = []
    tape = lower([bend], [*own.constants])
    for factor, _ in sp.factor_list(_scaled(level, own.constants), *own.constants)[1]:
        for curve in _zeros_of(own, "separatrix", factor, window):
            x, y = (np.linspace(v[0], v[-1], 401) if len(v) == 2 else v for v in (curve.x, curve.y))
            with np.errstate(all="ignore"):
                stable = np.broadcast_to(np.asarray(tape.run(Float64(), [x, y])[0], float), x.shape) < 0
            for part in np.split(np.arange(len(x)), np.flatnonzero(np.diff(stable.astype(int))) + 1):
                kind = "relative equilibrium" if stable[part[0]] else "separatrix"
                found.append(CriticalCurve(kind, own.name, x[part], y[part], np.full(len(part), place), factor))
    return found
