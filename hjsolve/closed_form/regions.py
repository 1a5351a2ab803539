"""Where on the x-axis a motion is: between which roots of P, or ends of the domain."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import mpmath
import sympy as sp

from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.evaluation import evaluator, magnitude, many_digits, number_of
from hjsolve.closed_form.sampling import Sample
from hjsolve.closed_form.signs import Signs
from hjsolve.display.shown import Shown
from hjsolve.precision import mp

DIGITS = 50
"""Of roots where only their order is asked."""
Numbers = Mapping[sp.Symbol, mpmath.mpf]
Where = Mapping[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]
"""Name → its definition: an expression, or (polynomial, index of the real root)."""
_SAME = mp.mpf(10) ** -22
"""Of themselves, how near two numbers are the same: a double root of coefficients with 50 digits splits by 1e-25 √κ,
and this leaves six digits to the condition κ. It is one for any number of digits: roots are numbered, and must be as
many."""
_CANCELLED = mp.mpf(10) ** -25
"""Of its terms, what is left of a coefficient that is zero: named roots in it have 30 digits at least."""
_APART = mp.mpf(10) ** -6
"""Of themselves, how near two roots may be that Newton's rule found: two starts may have led to the same one."""
_OTHER_SIZE = 10
"""Powers of 2 between roots that are found by themselves: three digits of each are a start for Newton's rule."""
_OF_DOUBLES = mp.mpf(10) ** -12
"""Of itself, how far a place may be beyond a turning point: it may be a double that was worked out from others."""


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
        with mp.workdps(DIGITS):
            value = number_of(self.curve.square, {**signs.numbers, self.curve.x: self.place})
        return (1 if value > 0 else -1) * (1 if self.curve.substitution.increasing else -1)

    def conditions(self, signs: Signs) -> dict[sp.Expr, int]:
        """Return the signs of leading coefficient, discriminant, and of P and P′ at the ends of the domain, deg P ≤ 2.

        They fix how many roots there are in the domain, and so where the motion can be.

        Args:
            signs: of the sample.
        """
        own = Signs(signs.values, self.place)
        own.sign(self.curve.substitution.condition)
        P, s = self.curve.polynomial, self.curve.substitution
        if P.degree() > 2:
            return own.decided
        own.sign(P.LC())
        if P.degree() == 2:
            own.sign(sp.discriminant(P.as_expr(), self.curve.x))
        for end in (s.lower, s.upper):
            if end.is_finite:
                own.sign(sp.factor(P.as_expr().subs(self.curve.x, end)))
                if P.degree() == 2:
                    own.sign(sp.factor(P.diff(self.curve.x).as_expr().subs(self.curve.x, end)))
        return own.decided


def real_roots(curve: MomentumCurve, numbers: Numbers) -> tuple[list[mpmath.mpf], bool]:
    """Return the real roots of P, ascending, and whether two roots are the same.

    Args:
        curve: whose P.
        numbers: symbol → value, of the constants.
    """
    real, double = _roots_of(_coefficients(curve.polynomial, numbers, DIGITS), DIGITS)
    return [*real], double


def ordered_real_roots(polynomial: sp.Poly, numbers: Numbers, digits: int) -> tuple[mpmath.mpf, ...]:
    """Return the real roots of a polynomial, ascending.

    Args:
        polynomial: with coefficients in the constants.
        numbers: symbol → value, with as many digits and more.
        digits: to which they are found.
    """
    return _roots_of(_coefficients(polynomial, numbers, digits + 10), digits + 10)[0]


def with_named(
    where: Where, numbers: Numbers, digits: int, real: Callable[[mpmath.mpc], mpmath.mpf] = mp.re
) -> dict[sp.Symbol, mpmath.mpf]:  # fmt: skip
    """Return numbers with those of names, as far as what they rest on is known.

    Args:
        where: name → its definition, each after those that it uses.
        numbers: of parameters and constants.
        digits: to which roots are found.
        real: what is taken of a definition's value. Names of pairs of conjugate roots are real; the rounding of a
            square root of a negative number is not.

    Raises:
        IndexError: there are fewer real roots than a name says.
    """
    known = dict(numbers)
    for symbol, meaning in where.items():
        if isinstance(meaning, tuple):
            polynomial, index = meaning
            if sp.Tuple(*polynomial.all_coeffs()).free_symbols <= known.keys():
                known[symbol] = ordered_real_roots(polynomial, known, digits)[index]
        elif meaning.free_symbols <= known.keys():
            known[symbol] = real(number_of(meaning, known))
    return known


def _coefficients(polynomial: sp.Poly, numbers: Numbers, digits: int) -> tuple[mpmath.mpf, ...]:
    """Return the coefficients; 0 where their terms cancel, as that of x² at E = V₀."""
    with mp.workdps(digits):
        held = polynomial.all_coeffs()
        found = evaluator(*held, *map(magnitude, held)).at(numbers)
        pairs = zip(found[: len(held)], found[len(held) :], strict=True)
        # by its own terms, and not by the greatest coefficient: x is in the user's units, and so is each of them
        return tuple(mp.mpf(0) if abs(c) <= size * _CANCELLED else c for c, size in pairs)


@lru_cache(maxsize=4096)
def _roots_of(coefficients: tuple[mpmath.mpf, ...], digits: int) -> tuple[tuple[mpmath.mpf, ...], bool]:
    """Return the real roots of a polynomial, ascending, and whether two roots are the same."""
    # √ of a negative parameter: there is no such motion, and nothing may be said of its roots
    if any(isinstance(c, mp.mpc) or not mp.isfinite(c) for c in coefficients):
        return (), True
    with mp.workdps(digits):
        held = [k for k, c in enumerate(coefficients) if c != 0]
        if not held:
            return (), False
        # a leading coefficient that is zero at these constants (E = 0) is a root at infinity
        roots = complex_roots(coefficients[held[0] :], digits)
        # two by two: next to a root at 1e30 all others would be the same
        double = any(_same(a, b) for k, a in enumerate(roots) for b in roots[:k])
        return tuple(sorted(mp.re(r) for r in roots if abs(mp.im(r)) <= abs(r) * _SAME)), double


def _same(a: mpmath.mpc, b: mpmath.mpc) -> bool:
    """Return whether two numbers are equal but for rounding, in any unit."""
    return bool(a == b or abs(a - b) <= max(abs(a), abs(b)) * _SAME) and not mp.isinf(a - b)


def complex_roots(coefficients: Sequence[mpmath.mpf], digits: int) -> list[mpmath.mpc]:
    """Return all roots, in mpmath's present precision: those at 0 first, as often as they occur.

    In units of the geometric mean |cₙ/c₀|^{1/n} of the others, so that doubles and tolerances hold for any unit of x. A
    power of 2: the coefficients are not rounded by it.

    Args:
        coefficients: of the highest power first, which is not 0.
        digits: of the roots.
    """
    n = max(k for k, c in enumerate(coefficients) if c != 0)
    zeros, coefficients = [mp.mpf(0)] * (len(coefficients) - 1 - n), coefficients[: n + 1]
    # Newton's rule, from doubles, would fail for the two roots of E x² + kx − L² with E → 0
    if n <= 2:
        return [*zeros, *(_quadratic_roots(coefficients) if n else [])]
    unit = mp.mpf(2) ** int(mp.nint(mp.log(abs(coefficients[n] / coefficients[0]), 2) / n))
    scaled = tuple(c * unit ** (n - k) for k, c in enumerate(coefficients))
    return [*zeros, *(unit * z for z in _roots_by_newton(scaled, digits))]


def _roots_by_newton(coefficients: tuple[mpmath.mpf, ...], digits: int) -> list[mpmath.mpc]:
    """Return all roots; in doubles first, and from there by Newton's rule: simple roots are soon found."""
    found = []
    for z in _starts(coefficients):
        for _ in range(14):
            value, slope = mp.polyval(coefficients, z, derivative=True)
            step = value / slope if slope else mp.mpf(1)
            z -= step
            # Newton's rule doubles digits: the next step would be rounding
            if abs(step) <= abs(z) * mp.mpf(10) ** (4 - digits) or value == 0:
                break
        else:
            return _roots_together(coefficients, digits)
        found.append(z)
    # two starts may lead to the same root, and the other would be lost
    if any(abs(a - b) < max(abs(a), abs(b)) * _APART for k, a in enumerate(found) for b in found[:k]):
        return _roots_together(coefficients, digits)
    return found


def _starts(coefficients: tuple[mpmath.mpf, ...]) -> list[mpmath.mpc]:
    """Return roots in doubles, those of one size by themselves: next to one of 1e300 all others would be rounding.

    The sizes are the slopes of the Newton polygon, the upper hull of (k, log |cₖ|) (Bini, Numer. Algorithms 13 (1996)
    179): edges of about the same slope are one group, and roots of other groups change its roots by their ratio.
    """
    import numpy as np

    heights = {k: mp.log(abs(c), 2) for k, c in enumerate(coefficients) if c != 0}
    hull = list[int]()
    for k, height in heights.items():
        while len(hull) > 1 and (height - heights[hull[-1]]) * (hull[-1] - hull[-2]) >= (
            heights[hull[-1]] - heights[hull[-2]]
        ) * (k - hull[-1]):
            hull.pop()
        hull.append(k)
    slopes = [(heights[j] - heights[i]) / (j - i) for i, j in pairwise(hull)]
    # the first and the last coefficient are not 0, so that the hull goes from one to the other
    cuts = [0, *(hull[n + 1] for n, (a, b) in enumerate(pairwise(slopes)) if a - b > _OTHER_SIZE)]
    found = list[mpmath.mpc]()
    for i, j in zip(cuts, [*cuts[1:], hull[-1]], strict=True):
        unit = mp.mpf(2) ** int(mp.nint((heights[j] - heights[i]) / (j - i)))
        # eigenvalues of the companion matrix: right to 1e-16 of the greatest root of the group
        part = [complex(coefficients[k] / coefficients[i] / unit ** (k - i)) for k in range(i, j + 1)]
        found += [unit * mp.mpmathify(complex(start)) for start in np.roots(part)]
    return found


def _roots_together(coefficients: tuple[mpmath.mpf, ...], digits: int) -> list[mpmath.mpc]:
    """Return all roots, found at once by the method of Durand and Kerner, whose tolerance is that of the greatest."""
    found = list[mpmath.mpc]()
    for z in mp.polyroots([*coefficients], maxsteps=300, extraprec=400):
        value, slope = mp.polyval(coefficients, z, derivative=True)
        # a small simple root gets its last digits by Newton's rule; of a double one P′ is 0, and the step is rounding
        step = value / slope if slope else mp.mpf(0)
        found.append(z - step if abs(step) < abs(z) * mp.mpf(10) ** (-digits // 2) else z)
    return found


def _quadratic_roots(coefficients: Sequence[mpmath.mpf]) -> list[mpmath.mpc]:
    if len(coefficients) == 2:
        return [mp.mpc(-coefficients[1] / coefficients[0])]
    a, b, c = coefficients
    with mp.extradps(30):
        root = mp.sqrt(mp.mpc(b * b - 4 * a * c))
        # −(b + sign(b) √D)/2a and c by it: −b and √D are of one sign, so that nothing cancels
        far = -(b + (root if b >= 0 else -root)) / 2
        return [far / a, c / far if far != 0 else far]


def root_interval_of(curve: MomentumCurve, sample: Sample) -> RootInterval | None:
    """Return where a motion is; None where P is not positive there, or has a double root.

    Args:
        curve: of the coordinate.
        sample: the motion.
    """
    s, q, numbers = curve.substitution, curve.coordinate.symbol, many_digits(sample.values, DIGITS)
    if any(c.has(sp.nan) for c in curve.polynomial.coeffs()):
        return None
    with mp.workdps(DIGITS):
        # a substitution such as u = √(r² + a²) is real for some values of the letters only
        if not number_of(s.condition, numbers) > 0:
            return None
        start = sample.places[curve.coordinate.name]
        place = number_of(s.place, {**numbers, q: number_of(start, {})})
        roots, double = real_roots(curve, numbers)
        # a double root is a rest, or a separatrix: another curve with the factor in S, a special case, holds for it
        if double or not _value(curve, place, numbers) > 0:
            return None
        low, high = (number_of(end, numbers) for end in (s.lower, s.upper))
        marks = _marks(curve, roots, numbers, low, high)
        below = [mark for mark in marks if mark[0] < place]
        above = [mark for mark in marks if mark[0] > place]
        lower = below[-1][1] if below else ("end", 0)
        upper = above[0][1] if above else ("end", 0)
    both = {lower[0], upper[0]}
    # dt = dq S/√P …: at a zero of S the momentum vanishes to first order, and the time to it is infinite
    if "rest" in both:
        kind = "asymptotic"
    # simple roots on both sides: p² changes sign there and the motion turns back
    elif both == {"root"}:
        kind = "libration"
        if not in_its_well(curve, sample):
            return None  # the same turning points in x as in its own well
    # of an angle, without a root on the circle
    elif s.closed:
        kind = "rotation"
    else:
        ends = [end for end, (what, _) in ((low, lower), (high, upper)) if what == "end"]
        far = [_number_of_q(curve, end, numbers) for end in ends]
        kind = "escape" if any(mp.isinf(f) for f in far) else "boundary"
    return RootInterval(curve, place, tuple(roots), lower, upper, kind, not (s.closed and both == {"root", "end"}))


def place_of_rest(curve: MomentumCurve, key: tuple[str, int], numbers: Numbers) -> mpmath.mpf:
    """Return the x at which an asymptotic motion would come to rest.

    Args:
        curve: of the coordinate.
        key: the end of a region, ("rest", index).
        numbers: symbol → value, of the constants.
    """
    with mp.workdps(DIGITS):
        roots, _ = real_roots(curve, numbers)
        low, high = (number_of(end, numbers) for end in (curve.substitution.lower, curve.substitution.upper))
        return next(value for value, mark in _marks(curve, roots, numbers, low, high) if mark == key)


def in_its_well(curve: MomentumCurve, sample: Sample) -> bool:
    """Return whether a motion is in the well about the middle of the curve's turn, of which an angle has several.

    Args:
        curve: of the coordinate.
        sample: the motion.
    """
    s = curve.substitution
    if s.turns == 1:
        return True
    q, numbers = sample.places[curve.coordinate.name], many_digits(sample.values, DIGITS)
    with mp.workdps(DIGITS):
        away = (number_of(q, {}) - middle_of(curve, numbers)) / (2 * mp.pi)
        return bool(abs(away - mp.nint(away)) * 2 * s.turns <= 1)


def _value(curve: MomentumCurve, place: mpmath.mpf, numbers: Numbers) -> mpmath.mpf:
    """P at a place."""
    return mp.polyval(_coefficients(curve.polynomial, numbers, DIGITS), place)


def _marks(
    curve: MomentumCurve, roots: list[mpmath.mpf], numbers: Numbers, low: mpmath.mpf, high: mpmath.mpf
) -> list[tuple[mpmath.mpf, tuple[str, int]]]:  # fmt: skip
    """Where a motion turns, at roots of P inside the domain, or comes to rest, at zeros of S at finite q; ascending."""

    def inside(r: mpmath.mpf) -> bool:
        return bool(low < r < high) and not _same(r, low) and not _same(r, high)

    found = [(r, ("root", k)) for k, r in enumerate(roots) if inside(r)]
    top = _numerator(curve.square, curve.x)
    if top is not None:
        rests = sorted({mp.nstr(z, 30): z for z in ordered_real_roots(top, numbers, DIGITS)}.values())
        for k, z in enumerate(rests):
            if inside(z) or (curve.substitution.closed and (_same(z, low) or _same(z, high))):
                found.append((z, ("rest", k)))
    return sorted(found)


@lru_cache(maxsize=512)
def _numerator(square: sp.Expr, x: sp.Symbol) -> sp.Poly | None:
    """Return the numerator of S as a polynomial, every root once; None where it is free of x."""
    top = sp.numer(sp.together(square))
    return sp.Poly(top, x).sqf_part() if top.has(x) else None


def _number_of_q(curve: MomentumCurve, end: mpmath.mpf, numbers: Numbers) -> mpmath.mpf:
    """Return the q at an end of the domain."""
    lower, upper = curve.ends
    s = curve.substitution
    at_lower = (end == number_of(s.lower, numbers)) == s.increasing
    return number_of(lower if at_lower else upper, numbers)


def region_exists(curve: MomentumCurve, like: RootInterval, numbers: Numbers) -> bool:
    """Whether P has, for other constants, as many real roots and a region between the same of them in the domain.

    Args:
        curve: whose P.
        like: the region.
        numbers: symbol → value, of the constants.
    """
    with mp.workdps(DIGITS):
        roots, double = real_roots(curve, numbers)
        if double or len(roots) != len(like.roots):
            return False
        low, high = (number_of(end, numbers) for end in (curve.substitution.lower, curve.substitution.upper))
        if mp.im(low) != 0 or mp.im(high) != 0:
            return False  # outside the horizon of a black hole that has none
        marks = {key: value for value, key in _marks(curve, roots, numbers, low, high)}
        if any(side[0] != "end" and side not in marks for side in (like.lower, like.upper)):
            return False
        start, stop = marks.get(like.lower, low), marks.get(like.upper, high)
        # another root between the same two numbers of roots: the motion turns back there
        if any(start < value < stop for value in marks.values()):
            return False
        return bool(_value(curve, _between(start, stop), numbers) > 0)


def holds_place(curve: MomentumCurve, like: RootInterval, place: mpmath.mpf, numbers: Numbers) -> bool:
    """Return whether a place of the coordinate is in a region that exists, turning points among it.

    Args:
        curve: whose P.
        like: the region.
        place: the q.
        numbers: symbol → value, of the constants.
    """
    s = curve.substitution
    with mp.workdps(DIGITS):
        turn = number_of(s.turn, numbers) if s.closed else mp.mpf(0)
        tolerance = max(abs(place), turn) * _OF_DOUBLES
        if s.closed and abs(place - middle_of(curve, numbers)) > turn / 2 + tolerance:
            return False
        first, last = (number_of(end, numbers) for end in curve.ends)
        # an end that is not real, as a horizon with a > M: there is no domain, and no place in it
        if mp.im(first) != 0 or mp.im(last) != 0:
            return False
        if not s.closed and not first - tolerance <= place <= last + tolerance:
            return False  # cos θ is that of another angle beyond the poles
        roots, _ = real_roots(curve, numbers)
        low, high = (number_of(end, numbers) for end in (s.lower, s.upper))
        if mp.im(low) != 0 or mp.im(high) != 0:
            return False
        marks = {key: value for value, key in _marks(curve, roots, numbers, low, high)}
        q = curve.coordinate.symbol
        x, slope = evaluator(s.place, sp.diff(s.place, q)).at({**numbers, q: place})
        if isinstance(x, mp.mpc) or mp.isnan(x):
            return True  # at the place where the variable is infinite, an end of the domain
        start, stop = marks.get(like.lower, low), marks.get(like.upper, high)
        # what the tolerance of q is in x, and the rounding of x; of a turning point at 0 by the width of the region
        tolerance = tolerance * abs(slope) + abs(x) * _OF_DOUBLES if mp.isfinite(slope) else abs(x) * _OF_DOUBLES
        if mp.isfinite(start) and mp.isfinite(stop):
            tolerance += abs(stop - start) * _OF_DOUBLES
        return bool(start - tolerance <= x <= stop + tolerance)


def middle_of(curve: MomentumCurve, numbers: Numbers) -> mpmath.mpf:
    """Return the angle in the middle of the turn on which the variable of a closed curve is monotone.

    Args:
        curve: of an angle.
        numbers: symbol → value, of the constants.
    """
    s = curve.substitution
    return number_of(s.inverse.subs(s.x, 0), numbers)


def _between(start: mpmath.mpf, stop: mpmath.mpf) -> mpmath.mpf:
    if mp.isinf(start) and mp.isinf(stop):
        return mp.mpf("0.123")
    if mp.isinf(start):
        return stop - 1 - abs(stop)
    return start + 1 + abs(start) if mp.isinf(stop) else (start + stop) / 2
