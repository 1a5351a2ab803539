"""Every integral is verified twice before it is shown: differentiated, and compared with the quadrature to 40 digits.

The quadrature is of N(q)/√P²(q) in the user's own coordinate, at exact constants of the regime; it knows nothing of
variables, roots or regimes. Between turning points q = m − h cos χ makes the integrand smooth and periodic, and equally
spaced nodes converge geometrically: three times as many have three times the digits. Inside, and in χ where one
turning point is so much nearer to a pole than the other that thousands of nodes would be needed, Gauss's rule is halved
until it no longer moves. A quadrature that does not settle is not a number. The integrals of a coordinate are verified
together: they share the momentum, the nodes and the elliptic functions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import mpmath
import sympy as sp
from mpmath.calculus.quadrature import GaussLegendre

from hjsolve.closed_form.evaluation import Evaluator, many_digits, number_of
from hjsolve.closed_form.pieces import CoordinateIntegrals, PieceIntegral
from hjsolve.closed_form.regions import RootInterval, ordered_real_roots, place_of_rest, with_named
from hjsolve.closed_form.time_limit import check_time
from hjsolve.precision import mp

DIGITS, GUARD = 40, 24
"""Digits that a form shows with a quadrature, and those that both may lose on the way."""
_MOST_NODES, _NODES, _HALVINGS_OF_A_PATH = 432, 4, 14
"""Nodes of a cycle, 16 trebled three times; mpmath's degree of Gauss's rule, of 24 nodes; 2⁻¹⁴ of a path is a pole."""
_RULE = GaussLegendre(mp)
"""Of Gauss; it remembers its nodes."""
_PARTS = ("0.31", "0.52", "0.77")
"""Of a region, where slopes are compared: on both sides of the middle, and at no place where anything is symmetric."""


Integrands = Callable[[mpmath.mpf], list[mpmath.mpf]]
"""A place ↦ what is integrated, of every integral."""


@dataclass(frozen=True)
class Compared:
    """An integral against the quadrature, its slopes against the integrand, its cycle against that of the quadrature.

    Attributes:
        flaw: what is wrong; empty where nothing is.
        difference: the largest, in units of what is allowed: at most 1 where nothing is wrong.
    """

    flaw: str = ""
    difference: float = 0.0

    def __or__(self, other: Compared) -> Compared:
        return Compared(self.flaw or other.flaw, max(self.difference, other.difference))


def flaws(piece: CoordinateIntegrals, keys: Sequence[sp.Symbol], digits: int = DIGITS) -> dict[sp.Symbol, str]:
    """Return what is wrong with integrals of a coordinate: no key of one that passes.

    Args:
        piece: the coordinate's integrals in a regime, with the sample they are tried at.
        keys: which of them.
        digits: to which they are compared.
    """
    return {key: one.flaw for key, one in compared(piece, keys, digits).items() if one.flaw}


def compared(
    piece: CoordinateIntegrals, keys: Sequence[sp.Symbol], digits: int = DIGITS
) -> dict[sp.Symbol, Compared]:  # fmt: skip
    """Return how integrals of a coordinate compare with the quadrature.

    Args:
        piece: the coordinate's integrals in a regime, with the sample they are tried at.
        keys: which of them.
        digits: to which they are compared.
    """
    found, left = dict[sp.Symbol, Compared](), dict[int, dict[sp.Symbol, PieceIntegral]]()
    for key, integral in _held(piece, keys):
        check_time()
        if integral.law is not None and integral.law.residual(integral.rational) != 0:
            found[key] = Compared("not verified: its derivative was not proved to be the integrand", math.inf)
            continue
        left.setdefault(id(integral.curve), {})[key] = integral
    for own in left.values():
        with mp.workdps(digits + GUARD):
            for key, one in _Trial(piece, own, digits).compared().items():
                found[key] = found.get(key, Compared()) | one
    return found


def _held(piece: CoordinateIntegrals, keys: Sequence[sp.Symbol]) -> list[tuple[sp.Symbol, PieceIntegral]]:
    """Return the integrals of keys, and those of which only the cycle has a form, perhaps on another curve."""
    return [(key, own[key]) for own in (piece.integrals, piece.cycles) for key in keys if key in own]


class _Trial:
    """The integrals of one curve, at the sample."""

    def __init__(self, piece: CoordinateIntegrals, own: Mapping[sp.Symbol, PieceIntegral], digits: int):
        self.piece, self.keys, self.integrals, self.digits = piece, list(own), list(own.values()), digits
        self.curve = curve = self.integrals[0].curve
        self.region = next(r for c, r in piece.regions if c is curve)
        q, self.numbers = curve.coordinate.symbol, sample_numbers(piece, digits + GUARD)
        # p² in the user's q, not P(x): a wrong change of variable shows
        bare = Evaluator([curve.substitution_square, *(i.numerator for i in self.integrals)])
        self.bare = bare.along(self.numbers, q)
        # slopes by the chain rule on the same lines: no step of a difference quotient limits their digits
        self.forms = Evaluator([i.value for i in self.integrals], q).along(self.numbers, q)

    def integrands(self, place: mpmath.mpf) -> list[mpmath.mpf]:
        """N/√P² of every integral."""
        square, *numerators = self.bare(place)
        root = mp.sqrt(square)
        return [N / root for N in numerators]

    def compared(self) -> dict[sp.Symbol, Compared]:
        """Return how antiderivatives compare, and the values over cycles of those that pass."""
        found = self._antiderivatives([k for k, own in enumerate(self.integrals) if own.value is not sp.nan])
        sound = [k for k, key in enumerate(self.keys) if not found.get(key, Compared()).flaw]
        for key, one in self._cycles([k for k in sound if self.integrals[k].cycle is not None]).items():
            found[key] = found.get(key, Compared()) | one
        return found

    def _antiderivatives(self, wanted: list[int]) -> dict[sp.Symbol, Compared]:
        if not wanted:
            return {}
        low, high = monotone_span(self.piece, self.integrals[0])
        places = [low + (high - low) * mp.mpf(part) for part in _PARTS]
        found = dict[sp.Symbol, Compared]()
        integrands = [self.integrands(place) for place in places]
        forms = [self.forms(place) for place in places]
        # all integrals at once: they have the nodes, and the root of p² there, in common
        expected = self._between(places[0], places[2], self.integrands)
        for k in wanted:
            key, size = self.keys[k], max(abs(values[k]) for values in integrands)
            # slopes see single places; values, below, see jumps of a branch between them
            slopes = [values[len(self.keys) + k] for values in forms]
            off = max(self._difference(s, f[k], size) for s, f in zip(slopes, integrands, strict=True))
            if off > 1:
                found[key] = Compared("not verified: its derivative is not the integrand at a place tried", off)
                continue
            begin, end = _real(forms[0][k]), _real(forms[2][k])
            size = max(abs(begin), abs(end), abs(expected[k]))
            found[key] = Compared(difference=off) | self._judged("it is", end - begin, expected[k], size)
        return found

    def _judged(self, what: str, got: mpmath.mpf, expected: mpmath.mpf, size: mpmath.mpf) -> Compared:
        off = self._difference(got, expected, size)
        words = f"not verified: {what} {_few(got)} where the quadrature is {_few(expected)}"
        return Compared(words if off > 1 else "", off)

    def _difference(self, one: mpmath.mpf, other: mpmath.mpf, size: mpmath.mpf) -> float:
        """Return a difference in units of what is allowed; infinite where a value is not a real number."""
        one = _real(one, size)
        if not (mp.isfinite(one) and mp.isfinite(other)) or isinstance(other, mp.mpc):
            return math.inf
        if one == other:
            return 0.0
        return float(abs(one - other) / size * mp.mpf(10) ** self.digits) if size else math.inf

    def _between(
        self, start: mpmath.mpf, stop: mpmath.mpf, integrands: Integrands, sizes: Sequence[mpmath.mpf] | None = None
    ) -> list[mpmath.mpf]:  # fmt: skip
        """Return the quadratures between two places, by Gauss's rule; nan where it does not settle.

        Args:
            start: where they begin.
            stop: where they end.
            integrands: a place ↦ all of them.
            sizes: what errors are measured by; None for each part's own value.
        """
        nodes = _RULE.get_nodes(-1, 1, _NODES, mp.prec)
        # two digits to spare for what halving adds up
        tiny = mp.mpf(10) ** (-self.digits - 2)

        def whole(a: mpmath.mpf, b: mpmath.mpf) -> list[mpmath.mpf]:
            middle, half = (a + b) / 2, (b - a) / 2
            rows = [(w, integrands(middle + half * x)) for x, w in nodes]
            return [half * mp.fsum(w * row[k] for w, row in rows) for k in range(len(self.keys))]

        def done(once: Sequence[mpmath.mpf], twice: Sequence[mpmath.mpf]) -> bool:
            of = sizes or [abs(a) + abs(b) for a, b in zip(once, twice, strict=True)]
            pairs = zip(once, twice, of, strict=True)
            return all(not mp.isfinite(a) or bool(abs(a - b) <= size * tiny) for a, b, size in pairs)

        def settled(a: mpmath.mpf, b: mpmath.mpf, once: list[mpmath.mpf], left: int) -> list[mpmath.mpf]:
            check_time()
            c = (a + b) / 2
            lower, upper = whole(a, c), whole(c, b)
            twice = [x + y for x, y in zip(lower, upper, strict=True)]
            if done(once, twice):
                return twice
            if left == 0:
                return [mp.nan] * len(once)
            parts = settled(a, c, lower, left - 1), settled(c, b, upper, left - 1)
            return [x + y for x, y in zip(*parts, strict=True)]

        return settled(start, stop, whole(start, stop), _HALVINGS_OF_A_PATH)

    def _cycles(self, wanted: list[int]) -> dict[sp.Symbol, Compared]:
        """Return how integrals over cycles compare."""
        if not wanted:
            return {}
        given = Evaluator([self.integrals[k].cycle for k in wanted]).at(self.numbers)
        expected = self._around()
        return {
            self.keys[k]: self._judged("a cycle is", got, *expected[k]) for k, got in zip(wanted, given, strict=True)
        }

    def _around(self) -> list[tuple[mpmath.mpf, mpmath.mpf]]:
        """∮ N dq/P by the midpoint rule, trebled until half of its digits no longer move; and ∮ |N| dq/P."""
        whole = self.region.kind == "rotation"
        if whole:
            middle, half = mp.mpf(0), number_of(self.curve.substitution.turn, self.numbers) / 2
        else:
            sides = (self.region.lower, self.region.upper)
            roots = ordered_real_roots(self.curve.polynomial, self.numbers, mp.dps)
            low, high = sorted(_place(self.integrals[0], roots[index], self.numbers) for _, index in sides)
            # q = m − h cos χ: dq/p is analytic and periodic in χ, as p ~ sin χ at both ends
            middle, half = (low + high) / 2, (high - low) / 2

        def terms(χ: mpmath.mpf) -> list[mpmath.mpf]:
            if whole:
                return self.integrands(middle + χ - half)
            cosine, sine = mp.cos_sin(χ)
            return [half * sine * f for f in self.integrands(middle - half * cosine)]

        turn, count, step = (2 * half if whole else mp.pi), 16, mp.mpf(1) / 2
        rows = [terms(turn * (k + step) / count) for k in range(count)]
        sums = _sums(rows, turn / count)
        while count < _MOST_NODES:
            check_time()
            sixth = step / 3
            rows += [terms(turn * (k + part) / count) for k in range(count) for part in (sixth, 5 * sixth)]
            # the nodes of a third of the spacing hold the old ones: nothing is worked out twice
            count, former = 3 * count, sums
            sums = _sums(rows, turn / count)
            # convergence is geometric: what n nodes know to 22 digits, 3n know to 66
            half_known = mp.mpf(10) ** (-self.digits // 2 - 2)
            if all(abs(a[0] - b[0]) <= a[1] * half_known for a, b in zip(sums, former, strict=True)):
                break
        else:
            # by ∮ |N| dq/p and not by its own value: a cycle of W's derivative may be zero
            sizes = [size for _, size in sums]
            sums = list(zip(self._between(mp.mpf(0), turn, terms, sizes), sizes, strict=True))
        # there and back; along an angle as often as P² repeats itself
        times = self.curve.substitution.turns if whole else 2
        return [(times * value, times * size) for value, size in sums]


def _sums(rows: list[list[mpmath.mpf]], weight: mpmath.mpf) -> list[tuple[mpmath.mpf, mpmath.mpf]]:
    columns = list(zip(*rows, strict=True))
    return [(weight * mp.fsum(c), weight * mp.fsum(c, absolute=True)) for c in columns]


def _few(value: mpmath.mpf) -> str:
    return str(mp.nstr(value, 20))


def _real(value: mpmath.mpf, size: mpmath.mpf = 1) -> mpmath.mpf:
    """Return a value without the imaginary rounding of a root; nan where it is more than that.

    Args:
        value: any.
        size: what its rounding is measured by, where it is not the value itself.
    """
    if not isinstance(value, mp.mpc):
        return value
    tiny = mp.mpf(10) ** -(mp.dps - 12)
    return value.real if abs(value.imag) <= tiny * (size + abs(value.real)) else mp.nan


def value_at(expression: sp.Expr, numbers: dict[sp.Symbol, mpmath.mpf]) -> mpmath.mpf:
    """Return an expression at numbers, by mpmath, in the precision that it works in; nan where it is not real.

    Args:
        expression: of a form.
        numbers: symbol → number, of every symbol.
    """
    return _real(Evaluator([expression]).at(numbers)[0])


def sample_numbers(piece: CoordinateIntegrals, digits: int = DIGITS + GUARD) -> dict[sp.Symbol, mpmath.mpf]:
    """Return the parameters, constants and named roots of the sample as numbers."""
    numbers = many_digits(piece.sample.values, digits)
    with mp.workdps(digits + GUARD):
        if piece.start is not None:
            numbers[piece.start] = number_of(piece.sample.places[piece.name], {})
        numbers = with_named(piece.where, numbers, digits, _real)
        numbers |= {symbol: _real(number_of(meaning, numbers)) for symbol, meaning in piece.rates.items()}
    return numbers


def sample_place(piece: CoordinateIntegrals) -> mpmath.mpf:
    """Return where a coordinate is at the sample."""
    with mp.workdps(DIGITS + GUARD):
        return number_of(piece.sample.places[piece.name], {})


def monotone_span(piece: CoordinateIntegrals, integral: PieceIntegral) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Return two places between which the motion is free of turning points, inside the region.

    Args:
        piece: the coordinate.
        integral: with the curve on which the region is meant.
    """
    region = next(r for c, r in piece.regions if c is integral.curve)
    numbers = many_digits(piece.sample.values, mp.dps)
    ends = [_end(region, side, numbers) for side in (region.lower, region.upper)]
    if ends[0] is None and ends[1] is None:
        x = [region.place - 1, region.place + 1]
        s = integral.curve.substitution
        low, high = (number_of(e, numbers) if e.is_finite else None for e in (s.lower, s.upper))
        x[0] = x[0] if low is None else (low + region.place) / 2
        x[1] = x[1] if high is None else (high + region.place) / 2
    else:
        other = region.place
        x = [ends[0] if ends[0] is not None else other, ends[1] if ends[1] is not None else other]
    q = sorted(_place(integral, end, numbers) for end in x)
    return q[0], q[1]


def _end(region: RootInterval, side: tuple[str, int], numbers: dict[sp.Symbol, mpmath.mpf]) -> mpmath.mpf | None:
    """Return a root, or a place of rest; None for an end of the domain."""
    if side[0] == "end":
        return None
    return region.roots[side[1]] if side[0] == "root" else place_of_rest(region.curve, side, numbers)


def _place(integral: PieceIntegral, x: mpmath.mpf | None, numbers: dict[sp.Symbol, mpmath.mpf]) -> mpmath.mpf:
    s = integral.curve.substitution
    return mp.re(number_of(s.inverse, {**numbers, s.x: x}))


def nearby(own: CoordinateIntegrals, integral: PieceIntegral) -> sp.Expr:
    """Another place of the same region, on the same side of the turning points.

    Args:
        own: the coordinate.
        integral: with the curve on which the region is meant.
    """
    low, high = monotone_span(own, integral)
    return sp.Rational(str(mp.nstr(low + (high - low) * mp.mpf("0.64"), 15)))
