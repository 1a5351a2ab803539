"""Enclosures of expressions at rational points, and the search for a witness: a point where zero is excluded.

Interval arithmetic with outward rounding (mpmath's ``libmp.mpi_*``), written as a walk over the sympy tree, so that the
result is a proof: the true value lies between ``lower`` and ``upper``. No float enters the decision.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Any

import mpmath
import sympy as sp
from mpmath import libmp

from ..algebra.poly import Budget
from ..algebra.signs import Bounds

Interval = tuple[Any, Any]
PRECISIONS = (64, 160, 400)
POINTS = 24
UNKNOWNS = (sp.core.function.AppliedUndef, sp.Derivative, sp.Subs)


class NoEnclosureError(ArithmeticError):
    """The expression has no finite real enclosure at this point."""


@dataclass(frozen=True)
class Witness:
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

    def points(self, expression: sp.Expr, seed: int = 0) -> Iterator[dict[sp.Expr, sp.Rational]]:
        """Rational points for the symbols and undetermined functions of an expression, simple ones first."""
        free = expression.free_symbols
        unknowns = sorted((x for x in expression.atoms(*UNKNOWNS) if x.free_symbols <= free), key=sp.default_sort_key)
        ends = [end for pair in self.bounds.values() for end in pair if end is not None]
        symbols = free.union(*(end.free_symbols for end in ends))
        coordinates = sorted((s for s in symbols if s in self.bounds), key=str)
        parameters = sorted((s for s in symbols if s not in self.bounds), key=str)
        generator = random.Random(seed)  # noqa: S311
        for attempt in range(20 * POINTS):
            point = {s: self._parameter(s, attempt, i, generator) for i, s in enumerate(parameters)}
            values = [self._coordinate(s, point, attempt, i, generator) for i, s in enumerate(coordinates)]
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
    ) -> sp.Rational | None:
        """A rational number inside the coordinate's interval; None when the interval is empty for these parameters."""
        lower, upper = (None if end is None else end.subs(point) for end in self.bounds[symbol])
        if any(end is not None and end.is_real is False for end in (lower, upper)):
            return None
        share = Fraction(place + 1, place + 3) if attempt < 2 else Fraction(generator.randrange(1, 64), 64)
        if lower is None and upper is None:
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


def enclose(
    expression: sp.Expr, point: Mapping[sp.Expr, sp.Rational], precision: int = 64
) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Enclose the value of an expression at a rational point.

    Args:
        expression: real expression in the symbols and undetermined functions that ``point`` gives values to.
        point: rational values.
        precision: working precision in bits.

    Returns:
        Lower and upper bound of the true value.

    Raises:
        NoEnclosureError: a pole, a root or logarithm of what is not positive, or an unknown function.
    """
    return finite(lambda: Walk(point, precision)(expression))


def finite(compute: Callable[[], Interval]) -> tuple[mpmath.mpf, mpmath.mpf]:
    """The ends of an interval.

    Raises:
        NoEnclosureError: it could not be computed, or is not finite.
    """
    try:
        low, high = compute()
    except (libmp.ComplexResult, ValueError, ZeroDivisionError, OverflowError) as fault:
        raise NoEnclosureError(str(fault)) from fault
    if not all(end[1] or end == libmp.fzero for end in (low, high)):
        raise NoEnclosureError("the enclosure is not finite")
    return mpmath.mp.make_mpf(low), mpmath.mp.make_mpf(high)


class Walk:
    """One evaluation: remembers the values of shared subexpressions."""

    def __init__(self, point: Mapping[sp.Expr, sp.Rational], precision: int):
        self.point, self.precision = point, precision
        self.seen: dict[sp.Expr, Interval] = {}

    def __call__(self, x: sp.Expr) -> Interval:  # noqa: D102
        if x not in self.seen:
            self.seen[x] = self._value(x)
        return self.seen[x]

    def _value(self, x: sp.Expr) -> Interval:
        prec = self.precision
        if x in self.point:
            x = self.point[x]
        if x.is_Rational:
            return rational(int(x.p), int(x.q), prec)
        if x is sp.pi:
            return _pi(prec)
        if x is sp.E:
            return libmp.mpi_exp(rational(1, 1, prec), prec)
        if x.is_Add or x.is_Mul:
            combine = libmp.mpi_add if x.is_Add else libmp.mpi_mul
            total = self(x.args[0])
            for a in x.args[1:]:
                total = combine(total, self(a), prec)
            return total
        if x.is_Pow:
            return self._power(x.base, x.exp)
        if function := _FUNCTIONS.get(x.func):
            return function(self(x.args[0]), prec)
        raise NoEnclosureError(f"no interval extension of {x.func}")

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> Interval:
        prec, b = self.precision, self(base)
        if exponent.is_Integer:
            n = int(exponent)
            return inverse(libmp.mpi_pow_int(b, -n, prec), prec) if n < 0 else libmp.mpi_pow_int(b, n, prec)
        if exponent.is_Rational and exponent.q == 2:
            root = libmp.mpi_sqrt(b, prec)
            n = int(exponent.p)
            return inverse(libmp.mpi_pow_int(root, -n, prec), prec) if n < 0 else libmp.mpi_pow_int(root, n, prec)
        return libmp.mpi_exp(libmp.mpi_mul(self(exponent), _log(b, prec), prec), prec)


def rational(p: int, q: int, prec: int) -> Interval:
    """The rational p/q."""
    return libmp.from_rational(p, q, prec, "f"), libmp.from_rational(p, q, prec, "c")


def _pi(prec: int) -> Interval:
    return libmp.mpf_pi(prec, "f"), libmp.mpf_pi(prec, "c")


def _integer(n: int) -> Interval:
    return libmp.from_int(n), libmp.from_int(n)


def inverse(x: Interval, prec: int) -> Interval:
    """1/x; ``NoEnclosureError`` where x may be zero."""
    if not (libmp.mpf_sign(x[0]) > 0 or libmp.mpf_sign(x[1]) < 0):
        raise NoEnclosureError("division by an interval that contains zero")
    return libmp.mpi_div(_integer(1), x, prec)


def _log(x: Interval, prec: int) -> Interval:
    if libmp.mpf_sign(x[0]) <= 0:
        raise NoEnclosureError("logarithm of an interval that is not positive")
    return libmp.mpi_log(x, prec)


def _ratio(
    top: Callable[[Interval, int], Interval], bottom: Callable[[Interval, int], Interval]
) -> Callable[[Interval, int], Interval]:
    return lambda x, prec: libmp.mpi_mul(top(x, prec), inverse(bottom(x, prec), prec), prec)


def _reciprocal(function: Callable[[Interval, int], Interval]) -> Callable[[Interval, int], Interval]:
    return lambda x, prec: inverse(function(x, prec), prec)


def _half_sum(sign: int) -> Callable[[Interval, int], Interval]:
    def function(x: Interval, prec: int) -> Interval:
        up, down = libmp.mpi_exp(x, prec), libmp.mpi_exp(libmp.mpi_neg(x, prec), prec)
        total = libmp.mpi_add(up, down, prec) if sign > 0 else libmp.mpi_sub(up, down, prec)
        return libmp.mpi_div(total, _integer(2), prec)

    return function


def _asin(x: Interval, prec: int) -> Interval:
    rest = libmp.mpi_sub(_integer(1), libmp.mpi_mul(x, x, prec), prec)
    return libmp.mpi_atan(libmp.mpi_mul(x, inverse(libmp.mpi_sqrt(rest, prec), prec), prec), prec)


def _acos(x: Interval, prec: int) -> Interval:
    return libmp.mpi_sub(libmp.mpi_div(_pi(prec), _integer(2), prec), _asin(x, prec), prec)


def _area(constant: int) -> Callable[[Interval, int], Interval]:
    def function(x: Interval, prec: int) -> Interval:
        square = libmp.mpi_add(libmp.mpi_mul(x, x, prec), _integer(constant), prec)
        return _log(libmp.mpi_add(x, libmp.mpi_sqrt(square, prec), prec), prec)

    return function


def _atanh(x: Interval, prec: int) -> Interval:
    up, down = libmp.mpi_add(_integer(1), x, prec), libmp.mpi_sub(_integer(1), x, prec)
    return libmp.mpi_div(libmp.mpi_sub(_log(up, prec), _log(down, prec), prec), _integer(2), prec)


def _abs(x: Interval, prec: int) -> Interval:
    return libmp.mpi_abs(x, prec)


def _sign(x: Interval, _prec: int) -> Interval:
    if libmp.mpf_sign(x[0]) > 0:
        return _integer(1)
    if libmp.mpf_sign(x[1]) < 0:
        return _integer(-1)
    raise NoEnclosureError("sign of an interval that contains zero")


_SIN, _COS = libmp.mpi_sin, libmp.mpi_cos
_SINH, _COSH = _half_sum(-1), _half_sum(1)
_FUNCTIONS: dict[object, Callable[[Interval, int], Interval]] = {
    sp.sin: _SIN, sp.cos: _COS, sp.tan: _ratio(_SIN, _COS), sp.cot: _ratio(_COS, _SIN),
    sp.sec: _reciprocal(_COS), sp.csc: _reciprocal(_SIN),
    sp.sinh: _SINH, sp.cosh: _COSH, sp.tanh: _ratio(_SINH, _COSH), sp.coth: _ratio(_COSH, _SINH),
    sp.sech: _reciprocal(_COSH), sp.csch: _reciprocal(_SINH),
    sp.exp: libmp.mpi_exp, sp.log: _log, sp.Abs: _abs, sp.sign: _sign,
    sp.atan: libmp.mpi_atan, sp.asin: _asin, sp.acos: _acos,
    sp.asinh: _area(1), sp.acosh: _area(-1), sp.atanh: _atanh,
}  # fmt: skip


def find_witness(expression: sp.Expr, region: Region, budget: Budget | None = None) -> Witness | None:
    """Search rational points of the region for one where the expression is enclosed away from zero."""
    return search(partial(enclose, expression), region.points(expression), budget)


def search(
    enclosure: Callable[[Mapping[sp.Expr, sp.Rational], int], tuple[mpmath.mpf, mpmath.mpf]],
    points: Iterable[dict[sp.Expr, sp.Rational]],
    budget: Budget | None = None,
) -> Witness | None:
    """The first of the points where an enclosure, of a point and a precision, excludes zero."""
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
    """A point of the region and the value of the expression there to 40 digits; None when no point has one."""
    for point in region.points(expression):
        try:
            lower, upper = enclose(expression, point, 400)
        except NoEnclosureError:
            continue
        with mpmath.workdps(40):
            return {sp.sstr(s): v for s, v in point.items()}, (lower + upper) / 2
    return None
