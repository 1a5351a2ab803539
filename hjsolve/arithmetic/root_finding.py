"""A zero of a function of one real variable, kept in a bracket; the power that its values follow.

With a derivative in many digits ``bracketed_root``, without one ``interpolated_root``; for many equations at once in
doubles ``bracketed_roots``; from values ``regula_falsi``; from the side alone ``bisected``. Searches that stop by
another rule say so where they are (``coupled_pair``, ``coupled_crossing``, ``stretched_anomaly``,
``proved_turning_points``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np

from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.number_types import Context, Mask, Mpf, Reals, X

_MOST_VALUES = 400
"""Of a function whose zero is interpolated; three a binary digit at worst."""


def bracketed_root(function: Callable[[Mpf], Sequence[Mpf]], x0: float | Mpf, x1: float | Mpf, bits: int) -> Mpf:
    """Newton's method kept inside a bracket, to the last bits.

    Args:
        function: x ↦ (f, f′) with one sign change of f on [x0, x1].
        x0, x1: the bracket, x0 < x1.
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
    """Return two more Newton steps where they converge quadratically; rounding decides the rest."""
    for _ in range(2):
        x -= step
        f, slope = function(x)
        step = f / slope if slope else 0 * x
    return x - step


def interpolated_root(
    function: Callable[[Mpf], Mpf], ends: tuple[Mpf, Mpf], values: tuple[Mpf, Mpf], within: Callable[[Mpf, Mpf], bool]
) -> Mpf:
    """Return a zero from values alone: inverse quadratic interpolation where it is safe, else bisection.

    The rule by which interpolation is safe is that of Chandrupatla, Advances in Engineering Software 28 (1997) 145.

    Args:
        function: x ↦ f, costly.
        ends: of the bracket.
        values: f there, of opposite signs.
        within: (x, f) ↦ whether x is good enough.
    """
    (b, a), (fb, fa) = ends, values
    c, fc, share = a, fa, a * 0 + 0.5
    best = min(((abs(fa), a, fa), (abs(fb), b, fb)), key=lambda one: one[0])
    for _ in range(_MOST_VALUES):
        if within(best[1], best[2]):
            break
        x = a + share * (b - a)
        if x in (a, b):
            break
        f = function(x)
        if f * fa > 0:
            c, fc = a, fa
        else:
            c, b, fc, fb = b, a, fb, fa
        a, fa = x, f
        best = min(best, (abs(f), x, f), key=lambda one: one[0])
        if not f:
            break
        ξ, φ = (a - b) / (c - b), (fa - fb) / (fc - fb)
        if φ**2 < ξ and (1 - φ) ** 2 < 1 - ξ:
            share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        else:
            share = a * 0 + 0.5
    return best[1]


def bracketed_roots(
    function: Callable[[Reals], tuple[Reals, Reals]], x: Reals, low: Reals, high: Reals
) -> tuple[Reals, Reals, Reals]:
    """Newton's method for an increasing function, element by element, never leaving its bracket.

    Args:
        function: x ↦ (f, f′), arrays of shape (m,).
        x, low, high: start and bracket, shape (m,).

    Returns:
        The zero, the residual and the slope there.
    """
    for count in range(80):
        f, slope = function(x)
        low, high = np.where(f <= 0, np.maximum(low, x), low), np.where(f >= 0, np.minimum(high, x), high)
        with np.errstate(all="ignore"):
            new = x - f / slope
        outside = ~((new >= low) & (new <= high))
        if outside.any() or count > 8:
            new = np.where(outside | ((count > 8) & (count % 4 == 3)), (low + high) / 2, new)
        moved = np.abs(new - x)
        x = new
        if np.all(moved <= 4 * EPS * np.maximum(np.abs(x), 1e-290)) or (count > 3 and np.all(moved <= 16 * EPS)):
            break
    f, slope = function(x)
    return x, f, slope


def regula_falsi(function: Callable[[float], float], low: float, high: float) -> float:
    """Return a zero in doubles from values alone, to the last bits: regula falsi, every third step a bisection.

    Args:
        function: f, not positive at one end and not negative at the other; infinite where there is no value.
        low, high: where f ≤ 0, and where f ≥ 0.
    """
    f0, f1 = function(low), function(high)
    for count in range(200):
        if f0 == 0 or high - low <= 2 * EPS * max(abs(low), abs(high)):
            return low
        middle = (low + high) / 2 if count % 3 == 2 or not np.isfinite(f1 - f0) else low - f0 * (high - low) / (f1 - f0)
        middle = min(max(middle, low + 0.001 * (high - low)), high - 0.001 * (high - low))
        f = function(middle)
        if f <= 0:
            low, f0 = middle, f
        else:
            high, f1 = middle, f
    return low


def bisected(below: Callable[[X], bool | Mask], low: X, high: X, times: int) -> tuple[X, X]:
    """Halve a bracket, or an array of brackets, a number of times.

    Args:
        below: whether a place, or which of an array of them, lies on the side of ``low``.
        low, high: the ends, in either order; of arrays shape (m,).
        times: how often.

    Returns:
        The ends of what is left.
    """
    for _ in range(times):
        middle = (low + high) / 2
        kept = below(middle)
        if isinstance(kept, np.ndarray):
            low, high = (
                cast("X", np.where(kept, *cast("tuple[Reals, Reals]", x))) for x in ((middle, low), (high, middle))
            )
        else:
            low, high = (middle, high) if kept else (low, middle)
    return low, high


def leading_power(values: list[Mpf], context: Context) -> float:
    """Exponent of growth of p² from one sample to the next, a factor 2¹⁶ apart.

    Args:
        values: samples, mpmath's numbers.
    """
    if not values[-1] or not values[-2]:
        return 0.0
    ratio = float(context.log(values[-1] / values[-2], 2)) / 16
    nearest = round(2 * ratio) / 2
    return nearest if abs(ratio - nearest) < 1e-3 else ratio
