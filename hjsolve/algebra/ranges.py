"""What a function can be over an interval, rounded outward: what ``Estimate`` and ``algebra.intervals`` rest on.

Every function takes c, mpmath's context, in whose precision ends are rounded, and intervals x, y. An interval is a pair
(low, high) of mpmath's numbers, each exactly what it is. The four operations, whole powers and the root are those of
mpmath's intervals: they are rounded in the direction asked. Its other functions are computed with 14 or 20 bits to
spare and then rounded, so that an end next to a number of the precision may fall on its wrong side (that of e^x does
at every ten thousandth place). So every other function is widened here by 2⁶ units in the last place of the working
precision, far more than mpmath's own rounding. Its value at the one place where it is exact (e⁰, ln 1, …) is left
alone; at every other fraction it is irrational, so that a short result there would be a rounded one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import inf
from typing import TypeAlias

import mpmath
from mpmath import libmp
from mpmath.ctx_mp import MPContext as Context

from hjsolve.errors import InvalidInputError

Range: TypeAlias = tuple[mpmath.mpf, mpmath.mpf]
"""Lower and upper end."""
Parts: TypeAlias = tuple[int, int, int, int]
"""Sign, mantissa, exponent and bits: what libmp computes with."""
Function: TypeAlias = Callable[[Context, Range], Range]
"""(mpmath's context, interval) → interval."""

FARTHEST = 1024
"""Binary digits before the point of the largest argument of an exponential; many more of a circular function."""
CIRCULAR = ("sin", "cos", "tan")
RISING: dict[str, tuple[float, float]] = {
    **dict.fromkeys(("exp", "expm1", "sinh", "tanh", "asinh", "atan", "cbrt"), (-inf, inf)),
    **dict.fromkeys(("sqrt", "log", "log2", "log10"), (0.0, inf)), "log1p": (-1.0, inf),
    **dict.fromkeys(("asin", "atanh"), (-1.0, 1.0)), "acosh": (1.0, inf),
}  # fmt: skip
"""Functions that rise wherever they are real, and where that is: their range over an interval is that of its ends."""
_WIDER = 6
_EXACT_AT_ONE = frozenset({"acosh", "log", "log2", "log10"})
"""Those that are exact at 1; the others are at 0."""
_POLES = {"log": (0,), "log2": (0,), "log10": (0,), "log1p": (-1,), "atanh": (-1, 1)}
"""Ends at which a function is infinite."""


def _by_mpmath(rule: Callable[..., tuple[Parts, Parts]], c: Context, *operands: Range) -> Range:
    """Return what an operation of mpmath's intervals gives, rounded outward to the context's precision."""
    low, high = rule(*((x[0]._mpf_, x[1]._mpf_) for x in operands), c.prec)
    return c.make_mpf(low), c.make_mpf(high)


def add(c: Context, x: Range, y: Range) -> Range:
    """Return the range of x + y."""
    return _by_mpmath(libmp.mpi_add, c, x, y)


def subtract(c: Context, x: Range, y: Range) -> Range:
    """Return the range of x − y."""
    return _by_mpmath(libmp.mpi_sub, c, x, y)


def multiply(c: Context, x: Range, y: Range) -> Range:
    """Return the range of x·y."""
    return _by_mpmath(libmp.mpi_mul, c, x, y)


def divide(c: Context, x: Range, y: Range) -> Range:
    """Return the range of x/y.

    Raises:
        InvalidInputError: y may be 0.
    """
    if y[0] <= 0 <= y[1]:
        raise InvalidInputError(f"division by {_text(c, y)}: it may be 0, so the quotient has no bound")
    return _by_mpmath(libmp.mpi_div, c, x, y)


def power(c: Context, x: Range, y: Range) -> Range:
    """Return the range of x^y.

    Args:
        c: mpmath's context, in whose precision the ends are rounded.
        x: interval of the base.
        y: interval of the exponent.

    Raises:
        InvalidInputError: x may be 0 or negative where the power then has no bound or is not real.
    """
    if y[0] == y[1] and c.isint(y[0]):
        return _whole_power(c, x, int(y[0]))
    if y[0] == y[1] == c.mpf(0.5):
        return square_root(c, x)
    if x[1] < 0 or (x[0] <= 0 and y[0] <= 0):
        raise InvalidInputError(f"power of {_text(c, x)}: for an exponent that is not whole the base must be above 0")
    if x[1] == 0:
        return x[1], x[1]
    top = apply(c, "exp", multiply(c, y, apply(c, "log", (x[1], x[1]))))
    if x[0] <= 0:
        return c.zero, top[1]
    bottom = apply(c, "exp", multiply(c, y, apply(c, "log", (x[0], x[0]))))
    return min(top[0], bottom[0]), max(top[1], bottom[1])


def _whole_power(c: Context, x: Range, n: int) -> Range:
    if n < 0:
        return divide(c, (c.one, c.one), _whole_power(c, x, -n))
    return _by_mpmath(lambda ends, bits: libmp.mpi_pow_int(ends, n, bits), c, x)


def absolute(c: Context, x: Range) -> Range:
    """Return the range of |x|."""
    size = sorted(abs_exact(c, end) for end in x)
    return (c.zero if x[0] < 0 < x[1] else size[0]), size[1]


def abs_exact(c: Context, x: mpmath.mpf) -> mpmath.mpf:
    """Return |x| with every digit of x, whatever the precision.

    Args:
        c: mpmath's context.
        x: a number of it.
    """
    return c.fneg(x, exact=True) if x < 0 else x


def square_root(c: Context, x: Range) -> Range:
    """Return the range of √x, of what is not negative of x.

    Raises:
        InvalidInputError: x is negative.
    """
    low, high = _inside(c, "sqrt", x, 0, inf)
    return c.sqrt(low, rounding="f"), c.sqrt(high, rounding="c")


def apply(c: Context, name: str, x: Range) -> Range:
    """Return the range of a function of one variable.

    Args:
        c: mpmath's context, in whose precision the ends are rounded.
        name: one of ``FUNCTIONS``.
        x: interval; what of it lies outside the function's domain is left out.

    Raises:
        InvalidInputError: the function is not real there, has no bound, or its argument is beyond reach.
    """
    if name in _OTHERS:
        return _OTHERS[name](c, x)
    low, high, exact = *_inside(c, name, x, *RISING[name]), int(name in _EXACT_AT_ONE)
    return _wide(c, name, low, exact)[0], _wide(c, name, high, exact)[1]


def _inside(c: Context, name: str, x: Range, left: float, right: float) -> Range:
    """Return the part of an interval where a function is real."""
    low, high = max(x[0], c.mpf(left)), min(x[1], c.mpf(right))
    if low > high:
        raise InvalidInputError(f"{name} of {_text(c, x)} is not real")
    if any(end in _POLES.get(name, ()) for end in (low, high)):
        raise InvalidInputError(f"{name} of {_text(c, x)}: it is infinite at an end of that, so there is no bound")
    return low, high


def _wide(c: Context, name: str, x: mpmath.mpf, exact: int | None) -> Range:
    """Return the value at one number, widened unless it is exact there."""
    value = _value(c, name, x)
    if exact is not None and x == exact:
        return value, value
    return _apart(c, value)


def _apart(c: Context, value: mpmath.mpf) -> Range:
    """Return a number less and more the widening, rounded outward."""
    number, bits = value._mpf_, c.prec
    margin = libmp.mpf_shift(libmp.mpf_abs(number), _WIDER - bits)
    low, high = libmp.mpf_sub(number, margin, bits, "f"), libmp.mpf_add(number, margin, bits, "c")
    return c.make_mpf(low), c.make_mpf(high)


def _value(c: Context, name: str, x: mpmath.mpf) -> mpmath.mpf:
    if name in CIRCULAR or name in {"exp", "expm1", "sinh", "cosh", "tanh"}:
        farthest = (16 if name in CIRCULAR else 1) * FARTHEST
        if c.mag(x) > farthest:
            raise InvalidInputError(f"{name} of a number beyond 2**{farthest}: choose other units")
    if name == "cbrt":
        return c.cbrt(x) if x >= 0 else -c.cbrt(c.fneg(x, exact=True))
    if name in {"log2", "log10"}:
        return c.log(x) / c.log(int(name[3:]))
    return getattr(c, name)(x)


def _text(c: Context, x: Range) -> str:
    middle, half = (x[0] + x[1]) / 2, (x[1] - x[0]) / 2
    return f"{c.nstr(middle, 6)} ± {c.nstr(half, 2)}"


# ------------------------------------------------------------------------------------------------ not monotone
def _wave(c: Context, name: str, x: Range) -> Range:
    """Return the range of sin or cos: the values at the ends, and ±1 where a maximum or minimum may lie inside."""
    if x[0] == x[1] == 0:
        return _wide(c, name, x[0], 0)
    ends = [_wide(c, name, end, None) for end in x]
    low, high = max(min(a for a, _ in ends), -c.one), min(max(b for _, b in ends), c.one)
    # in quarter turns, maxima of the sine lie at 1 + 4k and troughs at 3 + 4k; of the cosine at 4k and 2 + 4k
    first, last = (divide(c, (end, end), quarter_turn(c)) for end in x)
    barrier_top = 1 if name == "sin" else 0
    return (
        -c.one if _meets(c, first[0], last[1], barrier_top + 2) else low,
        c.one if _meets(c, first[0], last[1], barrier_top) else high,
    )


def _meets(c: Context, low: mpmath.mpf, high: mpmath.mpf, offset: int) -> bool:
    """Return whether a number offset + 4k may lie between two numbers, each good to the context's precision."""
    first, last = (low - offset) / 4, (high - offset) / 4
    return bool(c.ceil(first - 8 * c.eps * (1 + abs(low))) <= last + 8 * c.eps * (1 + abs(high)))


@lru_cache(maxsize=256)
def quarter_turn(c: Context) -> Range:
    """Return π/2, rounded outward.

    Args:
        c: mpmath's context.
    """
    return _apart(c, c.pi / 2)


def _tangent(c: Context, x: Range) -> Range:
    first, last = (divide(c, (end, end), quarter_turn(c)) for end in x)
    if _meets(c, first[0], last[1], 1) or _meets(c, first[0], last[1], 3):
        raise InvalidInputError(f"tan of {_text(c, x)}: a pole may lie in that, so there is no bound")
    return _wide(c, "tan", x[0], 0)[0], _wide(c, "tan", x[1], 0)[1]


def _cosh(c: Context, x: Range) -> Range:
    low, high = absolute(c, x)
    return max(_wide(c, "cosh", low, 0)[0], c.one), _wide(c, "cosh", high, 0)[1]


def _acos(c: Context, x: Range) -> Range:
    low, high = _inside(c, "acos", x, -1, 1)
    return max(_wide(c, "acos", high, 1)[0], c.zero), _wide(c, "acos", low, 1)[1]


_OTHERS: dict[str, Function] = {
    "sin": lambda c, x: _wave(c, "sin", x),
    "cos": lambda c, x: _wave(c, "cos", x),
    "tan": _tangent,
    "cosh": _cosh,
    "acos": _acos,
    "sqrt": square_root,
    "abs": absolute,
    "neg": lambda c, x: (c.fneg(x[1], exact=True), c.fneg(x[0], exact=True)),
    "square": lambda c, x: _whole_power(c, x, 2),
    "reciprocal": lambda c, x: divide(c, (c.one, c.one), x),
    "degrees": lambda c, x: divide(c, multiply(c, x, (c.mpf(90), c.mpf(90))), quarter_turn(c)),
    "radians": lambda c, x: divide(c, multiply(c, x, quarter_turn(c)), (c.mpf(90), c.mpf(90))),
}
FUNCTIONS = frozenset({*RISING, *_OTHERS})
"""Functions of one variable."""


# ------------------------------------------------------------------------------------------------ of two
def angle_of(c: Context, y: Range, x: Range) -> Range:
    """Return the range of atan2(y, x), in radians.

    Raises:
        InvalidInputError: (x, y) may lie on the cut, x ≤ 0 with y = 0, where the angle jumps.
    """
    if x[0] > 0:
        return apply(c, "atan", divide(c, y, x))
    if y[0] > 0:
        return subtract(c, quarter_turn(c), apply(c, "atan", divide(c, x, y)))
    if y[1] < 0:
        right = quarter_turn(c)
        return subtract(c, (-right[1], -right[0]), apply(c, "atan", divide(c, x, y)))
    raise InvalidInputError(
        f"the angle of x = {_text(c, x)}, y = {_text(c, y)}: it jumps by a turn there, so there is no bound"
    )


def hypotenuse(c: Context, x: Range, y: Range) -> Range:
    """Return the range of √(x² + y²)."""
    return square_root(c, add(c, _whole_power(c, x, 2), _whole_power(c, y, 2)))


def whole_quotient(c: Context, x: Range, y: Range) -> Range:
    """Return ⌊x/y⌋, as an interval of length zero.

    Raises:
        InvalidInputError: y may be 0, or two whole numbers are possible.
    """
    low, high = (c.floor(end) for end in divide(c, x, y))
    if low != high:
        raise InvalidInputError(
            f"the whole part of {_text(c, x)} over {_text(c, y)}: both {c.nstr(low)} and {c.nstr(high)} are possible"
        )
    return low, high


def remainder(c: Context, x: Range, y: Range) -> Range:
    """Return the range of x − y⌊x/y⌋.

    Raises:
        InvalidInputError: y may be 0, or two whole numbers ⌊x/y⌋ are possible.
    """
    return subtract(c, x, multiply(c, whole_quotient(c, x, y), y))


def greater(c: Context, x: Range, y: Range) -> Range:  # noqa: ARG001
    """Return the range of the greater of two."""
    return max(x[0], y[0]), max(x[1], y[1])


def less(c: Context, x: Range, y: Range) -> Range:  # noqa: ARG001
    """Return the range of the lesser of two."""
    return min(x[0], y[0]), min(x[1], y[1])


OF_TWO: dict[str, Callable[[Context, Range, Range], Range]] = {
    "add": add, "subtract": subtract, "multiply": multiply, "divide": divide, "power": power, "arctan2": angle_of,
    "hypot": hypotenuse, "floor_divide": whole_quotient, "remainder": remainder,
    "maximum": greater, "minimum": less,
}  # fmt: skip
"""Functions of two variables, with the names of numpy."""
