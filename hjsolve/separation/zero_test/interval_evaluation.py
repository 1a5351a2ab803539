"""Enclosures of expressions at rational points, and the search for a witness: a point where zero is excluded.

The result is a proof: the true value lies between ``lower`` and ``upper`` (``algebra.intervals``).
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial

import mpmath
import sympy as sp

from hjsolve.algebra.intervals import NoEnclosureError, enclose
from hjsolve.algebra.poly import Budget
from hjsolve.algebra.signs import Bounds
from hjsolve.display.shown import Shown
from hjsolve.precision import mp

PRECISIONS = (64, 160, 400)
POINTS = 24
UNKNOWNS = (sp.core.function.AppliedUndef, sp.Derivative, sp.Subs)


@dataclass(frozen=True, repr=False)
class Witness(Shown):
    """A point of the domain where an expression is proved not to be zero.

    Attributes:
        point: value of every symbol (and of every undetermined function, as ``f(r)``), rational.
        lower: lower end of an enclosure of the expression there.
        upper: upper end; both are on the same side of zero.
    """

    point: dict[str, sp.Rational]
    lower: mpmath.mpf
    upper: mpmath.mpf

    @property
    def excludes_zero(self) -> bool:
        """Whether the enclosure lies on one side of zero."""
        return bool(self.lower > 0 or self.upper < 0)


@dataclass(frozen=True)
class Region:
    """Where the symbols of a system may lie.

    Attributes:
        bounds: open interval of each coordinate; an end is None (infinite), a number, or a formula in parameters.
        defaults: values to try first, by symbol.
    """

    bounds: Mapping[sp.Symbol, Bounds] = field(default_factory=dict)
    defaults: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)

    def points(
        self, expression: sp.Expr, seed: int = 0, *, anywhere: bool = True
    ) -> Iterator[dict[sp.Expr, sp.Rational]]:
        """Rational points for the symbols and undetermined functions of an expression, simple ones first.

        Args:
            expression: whose symbols get values.
            seed: of the random ones.
            anywhere: True for places next to the ends of a domain and far out as well, where small things show.
        """
        free = expression.free_symbols
        unknowns = sorted((x for x in expression.atoms(*UNKNOWNS) if x.free_symbols <= free), key=sp.default_sort_key)
        ends = [end for pair in self.bounds.values() for end in pair if end is not None]
        symbols = free.union(*(end.free_symbols for end in ends))
        coordinates = sorted((s for s in symbols if s in self.bounds), key=str)
        parameters = sorted((s for s in symbols if s not in self.bounds), key=str)
        generator = random.Random(seed)  # noqa: S311
        for attempt in range(20 * POINTS):
            point = {s: self._parameter(s, attempt, i, generator) for i, s in enumerate(parameters)}
            stretched = anywhere and attempt % 4 > 1
            values = [self._coordinate(s, point, attempt, i, generator, stretched) for i, s in enumerate(coordinates)]
            if any(value is None for value in values):
                continue
            point.update({s: v for s, v in zip(coordinates, values, strict=True) if v is not None})
            for unknown in unknowns:
                point[unknown] = sp.Rational(generator.randrange(-60, 60) * 2 + 1, 32)
            yield point

    def _parameter(self, symbol: sp.Symbol, attempt: int, place: int, generator: random.Random) -> sp.Rational:
        default = self.defaults.get(symbol)
        if attempt == 0 and default is not None and default.is_Rational:
            return default
        if attempt < 3:
            value = sp.Rational(place + 1 + attempt, 1 + attempt)
        else:
            value = sp.Rational(generator.randrange(1, 64), generator.choice((4, 8, 16)))
        if symbol.is_integer:
            value = sp.ceiling(value)
        if symbol.is_negative or symbol.is_nonpositive:
            return -value
        return -value if symbol.is_nonnegative is None and attempt % 4 == 3 else value

    def _coordinate(
        self,
        symbol: sp.Symbol,
        point: Mapping[sp.Expr, sp.Rational],
        attempt: int,
        place: int,
        generator: random.Random,
        stretched: bool,
    ) -> sp.Rational | None:
        """Return a rational number inside the coordinate's interval.

        None when the interval is empty for these parameters.
        """
        lower, upper = (None if end is None else end.subs(point) for end in self.bounds[symbol])
        if any(end is not None and end.is_real is False for end in (lower, upper)):
            return None
        share = Fraction(place + 1, place + 3) if attempt < 2 else Fraction(generator.randrange(1, 64), 64)
        if stretched and (lower is None or upper is None):
            value = _stretched(share, lower, upper, (-1) ** attempt)
        elif lower is None and upper is None:
            value = sp.Rational((-1) ** attempt * (2 * share.numerator + place), share.denominator)
        elif upper is None:
            value = sp.ceiling(lower) + sp.Rational(share.numerator * 3, share.denominator)
        elif lower is None:
            value = sp.floor(upper) - sp.Rational(share.numerator * 3, share.denominator)
        else:
            low, high = float(lower), float(upper)
            inside = Fraction(low + (high - low) * float(share)).limit_denominator(256)
            value = sp.Rational(inside.numerator, inside.denominator)
        inside_lower = lower is None or bool(lower < value)
        return value if inside_lower and (upper is None or bool(value < upper)) else None


def _stretched(share: Fraction, lower: sp.Expr | None, upper: sp.Expr | None, side: int) -> sp.Rational:
    """Return a place anywhere on a line or half-line, next to its end as well as far out."""
    distance = sp.Rational(share.numerator, share.denominator - share.numerator)
    end = lower if upper is None else upper
    if end is None:
        return 4 * side * distance
    near = Fraction(float(end)).limit_denominator(256)
    start = sp.Rational(near.numerator, near.denominator)
    return start + distance if upper is None else start - distance


def find_witness(expression: sp.Expr, region: Region, budget: Budget | None = None) -> Witness | None:
    """Search rational points of the region for one where the expression is enclosed away from zero.

    Args:
        expression: what may not vanish.
        region: where the points are taken from.
        budget: of the search; without one only the number of points ends it.
    """
    return search(partial(enclose, expression), region.points(expression), budget)


def search(
    enclosure: Callable[[Mapping[sp.Expr, sp.Rational], int], tuple[mpmath.mpf, mpmath.mpf]],
    points: Iterable[dict[sp.Expr, sp.Rational]],
    budget: Budget | None = None,
) -> Witness | None:
    """Return the first of the points where an enclosure, of a point and a precision, excludes zero.

    Args:
        enclosure: lower and upper bound at a point, to a number of binary digits.
        points: those to try, in order.
    """
    tried = 0
    for point in points:
        try:
            for precision in PRECISIONS:
                lower, upper = enclosure(point, precision)
                if lower > 0 or upper < 0:
                    return Witness({sp.sstr(s): v for s, v in point.items()}, lower, upper)
        except NoEnclosureError:
            continue
        tried += 1
        if tried == POINTS or (budget is not None and budget.left < 0):
            break
    return None


def value_to_40_digits(expression: sp.Expr, region: Region) -> tuple[dict[str, sp.Rational], mpmath.mpf] | None:
    """Return a point of the region and the value of the expression there to 40 digits; None when no point has one.

    Args:
        expression: what is to be worked out.
        region: where the point is taken from.
    """
    for point in region.points(expression):
        try:
            lower, upper = enclose(expression, point, 400)
        except NoEnclosureError:
            continue
        with mp.workdps(40):
            return {sp.sstr(s): v for s, v in point.items()}, (lower + upper) / 2
    return None
