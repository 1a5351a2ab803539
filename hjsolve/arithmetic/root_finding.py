"""A zero of a function of one real variable, kept in a bracket; the power that its values follow."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Context, Mpf


def bracketed_root(function: Callable[[Mpf], Sequence[Mpf]], x0: float | Mpf, x1: float | Mpf, bits: int) -> Mpf:
    """Newton's method kept inside a bracket, to the last bits.

    Args:
        function: x ↦ (f, f′) with one sign change of f on [x0, x1].
        x0, x1: the bracket, x0 < x1.
        bits: working precision.
    """
    context = multiprecision(bits)
    left, right = context.convert(x0), context.convert(x1)
    before, after = function(left)[0], function(right)[0]
    # an end of the bracket may be the zero itself, where the sign of f is rounding: the other end knows
    sign = (1 if after > 0 else -1) if abs(after) >= abs(before) else (1 if before < 0 else -1)
    x = (left + right) / 2
    tolerance, close = context.mpf(2) ** (8 - bits), context.mpf(2) ** (-bits // 3)
    for count in range(4 * bits):
        f, slope = function(x)
        left, right = (x, right) if f * sign < 0 else (left, x)
        step = f / slope if slope else right - left
        if f == 0 or abs(step) <= close * abs(x):
            return _polished(function, x, step)
        new = x - step
        if not left < new < right or count % 16 == 15:
            new = (left + right) / 2
        if right - left <= tolerance * right:
            return new
        x = new
    return x


def _polished(function: Callable[[Mpf], Sequence[Mpf]], x: Mpf, step: Mpf) -> Mpf:
    """Two more Newton steps where they converge quadratically; rounding decides the rest."""
    for _ in range(2):
        x -= step
        f, slope = function(x)
        step = f / slope if slope else 0 * x
    return x - step


def leading_power(values: list[Mpf], context: Context) -> float:
    """Exponent of growth of p² from one sample to the next, a factor 2¹⁶ apart.

    Args:
        values: samples, mpmath's numbers.
        context: of mpmath.
    """
    if not values[-1] or not values[-2]:
        return 0.0
    ratio = float(context.log(values[-1] / values[-2], 2)) / 16
    nearest = round(2 * ratio) / 2
    return nearest if abs(ratio - nearest) < 1e-3 else ratio
