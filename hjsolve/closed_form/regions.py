"""Where on the x-axis a motion is: between which roots of P, or ends of the domain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import mpmath
import sympy as sp

from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.sampling import Sample
from hjsolve.closed_form.signs import Signs
from hjsolve.display.shown import Shown

DIGITS = 50
_SAME = mpmath.mpf(10) ** -25


@dataclass(frozen=True, repr=False)
class RootInterval(Shown):
    """An interval of the x-axis on which P > 0.

    Attributes:
        curve: whose x.
        place: the x of the sample.
        roots: the real roots of P, ascending, numbers at the sample.
        lower: its lower end: ("root", index among the real roots), ("rest", index) where the motion would never arrive,
            or ("end", 0).
        upper: its upper end, likewise.
        kind: libration, rotation, escape, boundary or asymptotic.
        whole: whether the motion stays on it; False where it goes on through the place at which the variable is cut.
    """

    curve: MomentumCurve
    place: mpmath.mpf
    roots: tuple[mpmath.mpf, ...]
    lower: tuple[str, int]
    upper: tuple[str, int]
    kind: str
    whole: bool

    @property
    def key(self) -> tuple[object, ...]:
        """What makes two regions alike: the number of roots and the ends."""
        return len(self.roots), self.lower, self.upper

    def orientation(self, signs: Signs) -> int:
        """ε: the sign of S φ′ here.

        Args:
            signs: of the sample.
        """
        value = signs.number(self.curve.square.subs(self.curve.x, sp.Float(self.place, DIGITS)))
        return (1 if value > 0 else -1) * (1 if self.curve.substitution.increasing else -1)

    def conditions(self, signs: Signs) -> dict[sp.Expr, int]:
        """The signs of leading coefficient, discriminant, and of P and P′ at the ends of the domain, deg P ≤ 2.

        They fix how many roots there are in the domain, and so where the motion can be.

        Args:
            signs: of the sample.
        """
        own = Signs(signs.values, self.place)
        P, s = self.curve.polynomial, self.curve.substitution
        if P.degree() > 2:
            return {}
        own.sign(P.LC())
        if P.degree() == 2:
            own.sign(sp.discriminant(P.as_expr(), self.curve.x))
        for end in (s.lower, s.upper):
            if end.is_finite:
                own.sign(sp.factor(P.as_expr().subs(self.curve.x, end)))
                if P.degree() == 2:
                    own.sign(sp.factor(P.diff(self.curve.x).as_expr().subs(self.curve.x, end)))
        return own.decided


def real_roots(curve: MomentumCurve, values: dict[sp.Symbol, sp.Expr]) -> tuple[list[mpmath.mpf], bool]:
    """The real roots of P inside the domain's closure, ascending, and whether two roots are the same.

    Args:
        curve: whose P.
        values: of the constants.
    """
    with mpmath.workdps(DIGITS):
        coefficients = [mpmath.mpf(sp.N(c.xreplace(values), DIGITS)) for c in curve.polynomial.all_coeffs()]
    real, double = _roots_of(tuple(coefficients))
    return [*real], double


@lru_cache(maxsize=1024)
def _roots_of(coefficients: tuple[mpmath.mpf, ...]) -> tuple[tuple[mpmath.mpf, ...], bool]:
    """The real roots of a polynomial, ascending, and whether two roots are the same."""
    with mpmath.workdps(DIGITS):
        size, first = max(abs(c) for c in coefficients), 0
        while first < len(coefficients) and abs(coefficients[first]) < size * _SAME:
            first += 1
        if len(coefficients) - first < 2:
            return (), False
        roots = _complex_roots(coefficients[first:])
        scale = max(abs(r) for r in roots) or mpmath.mpf(1)
        double = any(abs(a - b) < scale * _SAME for k, a in enumerate(roots) for b in roots[:k])
        return tuple(sorted(r.real for r in roots if abs(r.imag) <= scale * _SAME)), double


def _complex_roots(coefficients: tuple[mpmath.mpf, ...]) -> list[mpmath.mpc]:
    """All roots; in doubles first, and from there by Newton's rule: simple roots are soon had."""
    import numpy as np

    starts = np.roots([complex(c / coefficients[0]) for c in coefficients])
    found = []
    for start in starts:
        z = mpmath.mpmathify(complex(start))
        for _ in range(12):
            value, slope = mpmath.polyval(coefficients, z, derivative=True)
            step = value / slope if slope else mpmath.mpf(1)
            z -= step
            if abs(step) <= abs(z) * mpmath.mpf(10) ** (-DIGITS + 4) or value == 0:
                break
        else:
            return list(mpmath.polyroots([*coefficients], maxsteps=300, extraprec=400))
        found.append(z)
    gaps = [abs(a - b) for k, a in enumerate(found) for b in found[:k]]
    if gaps and min(gaps) < max(abs(z) for z in found) * mpmath.mpf(10) ** -6:
        return list(mpmath.polyroots([*coefficients], maxsteps=300, extraprec=400))
    return found


def root_interval_of(curve: MomentumCurve, sample: Sample) -> RootInterval | None:
    """Where a motion is; None where P is not positive there, or has a double root.

    Args:
        curve: of the coordinate.
        sample: the motion.
    """
    s, q, values = curve.substitution, curve.coordinate.symbol, dict(sample.values)
    if curve.polynomial.has_free(*(k for k in values)) and any(c.has(sp.nan) for c in curve.polynomial.coeffs()):
        return None
    with mpmath.workdps(DIGITS):
        start = sample.places[curve.coordinate.name]
        place = mpmath.mpf(sp.N(s.place.subs(q, start).xreplace(values), DIGITS))
        roots, double = real_roots(curve, values)
        if double or curve.polynomial.as_expr().xreplace(values).subs(curve.x, sp.Float(place, DIGITS)) <= 0:
            return None
        low, high = (_number(end, values) for end in (s.lower, s.upper))
        marks = _marks(curve, roots, values, low, high)
        below = [mark for mark in marks if mark[0] < place]
        above = [mark for mark in marks if mark[0] > place]
        lower = below[-1][1] if below else ("end", 0)
        upper = above[0][1] if above else ("end", 0)
    both = {lower[0], upper[0]}
    if "rest" in both:
        kind = "asymptotic"
    elif both == {"root"}:
        kind = "libration"
    elif s.closed:
        kind = "rotation"
    else:
        ends = [end for end, (what, _) in ((low, lower), (high, upper)) if what == "end"]
        far = [_number_of_q(curve, end, values) for end in ends]
        kind = "escape" if any(mpmath.isinf(f) for f in far) else "boundary"
    return RootInterval(curve, place, tuple(roots), lower, upper, kind, not (s.closed and both == {"root", "end"}))


def _marks(
    curve: MomentumCurve, roots: list[mpmath.mpf], values: dict[sp.Symbol, sp.Expr], low: mpmath.mpf, high: mpmath.mpf
) -> list[tuple[mpmath.mpf, tuple[str, int]]]:  # fmt: skip
    """Where a motion turns, at roots of P inside the domain, or comes to rest, at zeros of S at finite q; ascending."""

    def inside(r: mpmath.mpf) -> bool:
        gap = _SAME * (1 + abs(r))
        return bool(low + gap < r < high - gap)

    found = [(r, ("root", k)) for k, r in enumerate(roots) if inside(r)]
    top = sp.numer(sp.together(curve.square))
    if top.has(curve.x):
        zeros = _polynomial_roots(sp.Poly(top, curve.x), values)
        rests = sorted({mpmath.nstr(z, 30): z for z in zeros}.values())
        for k, z in enumerate(rests):
            edge = abs(z - low) <= _SAME * (1 + abs(z)) or abs(z - high) <= _SAME * (1 + abs(z))
            if inside(z) or (edge and curve.substitution.closed):
                found.append((z, ("rest", k)))
    return sorted(found)


def _polynomial_roots(polynomial: sp.Poly, values: dict[sp.Symbol, sp.Expr]) -> list[mpmath.mpf]:
    """The real roots of any polynomial, at numbers."""
    coefficients = [mpmath.mpf(sp.N(c.xreplace(values), DIGITS)) for c in polynomial.all_coeffs()]
    if len(coefficients) < 2:
        return []
    roots = mpmath.polyroots(coefficients, maxsteps=300, extraprec=600)
    scale = max(abs(r) for r in roots) or mpmath.mpf(1)
    return [r.real for r in roots if abs(r.imag) <= scale * mpmath.mpf(10) ** -12]


def _number(end: sp.Expr, values: dict[sp.Symbol, sp.Expr]) -> mpmath.mpf:
    if end in (sp.oo, -sp.oo):
        return mpmath.inf if end is sp.oo else -mpmath.inf
    return mpmath.mpf(sp.N(end.xreplace(values), DIGITS))


def _number_of_q(curve: MomentumCurve, end: mpmath.mpf, values: dict[sp.Symbol, sp.Expr]) -> mpmath.mpf:
    """The q at an end of the domain."""
    lower, upper = curve.ends
    s = curve.substitution
    at_lower = (end == _number(s.lower, values)) == s.increasing
    return _number(lower if at_lower else upper, values)


def region_exists(curve: MomentumCurve, like: RootInterval, values: dict[sp.Symbol, sp.Expr]) -> bool:
    """Whether P has, for other constants, as many real roots and a region between the same of them in the domain.

    Args:
        curve: whose P.
        like: the region.
        values: of the constants.
    """
    with mpmath.workdps(DIGITS):
        roots, double = real_roots(curve, values)
        if double or len(roots) != len(like.roots):
            return False
        low, high = (_number(end, values) for end in (curve.substitution.lower, curve.substitution.upper))
        marks = {key: value for value, key in _marks(curve, roots, values, low, high)}
        if any(side[0] != "end" and side not in marks for side in (like.lower, like.upper)):
            return False
        start, stop = marks.get(like.lower, low), marks.get(like.upper, high)
        if any(start < value < stop for value in marks.values()):
            return False
        place = _between(start, stop)
        value = curve.polynomial.as_expr().xreplace(values).subs(curve.x, sp.Float(place, DIGITS))
        return bool(sp.N(value, DIGITS) > 0)


def _between(start: mpmath.mpf, stop: mpmath.mpf) -> mpmath.mpf:
    if mpmath.isinf(start) and mpmath.isinf(stop):
        return mpmath.mpf("0.123")
    if mpmath.isinf(start):
        return stop - 1 - abs(stop)
    return start + 1 + abs(start) if mpmath.isinf(stop) else (start + stop) / 2
