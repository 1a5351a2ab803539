"""A zero of a function of one real variable: near a place, or kept in a bracket; the power that its values follow.

xₙ₊₁ = xₙ − f/f′ (Newton) from nearby: ``newton``, ``stationary``, and ``stationary_places`` for arrays of doubles. In a
bracket, where f changes its sign: ``bracketed_root`` to many digits and ``bracketed_roots`` for many equations in
doubles take f′ too, ``interpolated_root`` takes values alone in either arithmetic (Chandrupatla 1997), ``bisected``
the side alone. Searches that stop by another rule are listed in docs/methods.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import cast

import numpy as np

from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.number_types import Context, Elementwise, Mask, Mpf, Reals, X

_MOST_VALUES = 400
"""Of a function whose zero is interpolated; three a binary digit at worst."""


def newton(
    step: Callable[[X], X | None],
    x: X,
    close: Callable[[X], X] | X,
    most: int,
    *,
    rough: float = 1,
    ended: bool = False,
) -> X | None:
    """Follow Newton's method from a place that is near, in doubles or many digits.

    Args:
        step: x ↦ f/f′; None where the method must not go on.
        x: where it begins.
        close: a step so small is the last; a number, or a function of x.
        most: how many steps are taken.
        rough: steps below ``rough`` times ``close`` that are no longer halved are rounding: the last one, too.
        ended: whether the place after ``most`` steps is an answer, however long the last one was.

    Returns:
        The zero; None where there was no step, or the steps did not become small.
    """
    before = None
    for _ in range(most):
        change = step(x)
        if change is None:
            return None
        x = x - change
        size, last = abs(change), close(x) if callable(close) else close
        if size <= last or (before is not None and size <= rough * last and 2 * size >= before):
            return x
        before = size
    return x if ended else None


def stationary(
    jet: Callable[[X], Sequence[X]], x: X, within: Callable[[X, X], bool], close: Callable[[X], X] | X, most: int = 60
) -> X | None:
    """Return the place near another one where F′ = 0, by Newton's method.

    Args:
        jet: x ↦ (F, F′, F″).
        x: where the method begins.
        within: (F″, new place) ↦ whether the method may go on to it.
        close: as of ``newton``.
        most: how many steps are taken.

    Returns:
        The place, to what ``most`` steps give where F is flat; None where F″ = 0 or ``within`` forbids a step.
    """

    def step(x: X) -> X | None:
        _, slope, bend = jet(x)
        return slope / bend if bend and within(bend, x - slope / bend) else None

    return newton(step, x, close, most, ended=True)


def stationary_places(
    jet: Callable[[Reals], Iterable[Reals]], x: Reals, farthest: Elementwise, steps: int
) -> tuple[Reals, Mask, Reals]:
    """Return the minima of F near many places by Newton's method, element by element.

    Args:
        jet: x ↦ (F, F′, F″), arrays of shape (m,).
        x: where the method begins, shape (m,).
        farthest: a step so long leads elsewhere, a number or shape (m,).
        steps: how many are taken.

    Returns:
        The places, which of them are minima (others stay where the method had come to), F″ before the last step.
    """
    fine = np.ones(len(x), dtype=bool)
    with np.errstate(all="ignore"):
        for _ in range(steps):
            _, slope, bend = jet(x)
            step = slope / bend
            fine &= (bend > 0) & (np.abs(step) < farthest)
            x = np.where(fine, x - step, x)
    return x, fine, bend


def bracketed_root(
    function: Callable[[Mpf], Sequence[Mpf]], x0: float | Mpf, x1: float | Mpf, bits: int,
    *, start: Mpf | None = None, rising: bool | None = None, size: float | Mpf = 0,
) -> Mpf:  # fmt: skip
    """Newton's method kept inside a bracket, to the last bits.

    Args:
        function: x ↦ (f, f′) with one sign change of f on [x0, x1].
        x0, x1: the bracket, x0 < x1.
        start: where the method begins; None for the middle.
        rising: whether f rises; None where its values at the ends are to tell.
        size: of numbers next to x: the error is relative to the greater of it and |x|.
    """
    context = multiprecision(bits)
    left, right = context.convert(x0), context.convert(x1)
    if rising is None:
        before, after = function(left)[0], function(right)[0]
        # an end of the bracket may be the zero itself, where the sign of f is rounding: the other end knows
        rising = after > 0 if abs(after) >= abs(before) else before < 0
    x = (left + right) / 2 if start is None else start
    tolerance, close = context.mpf(2) ** (8 - bits), context.mpf(2) ** (-bits // 3)
    for count in range(4 * bits):
        f, slope = function(x)
        left, right = (x, right) if (f < 0) == rising and f else (left, x)
        step = f / slope if slope else right - left
        if f == 0 or abs(step) <= close * max(abs(x), size):
            return _polished(function, x, step)
        new = x - step
        if not left < new < right or count % 16 == 15:
            new = (left + right) / 2
        if right - left <= tolerance * max(right, size):
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
    function: Callable[[X], X], ends: tuple[X, X], values: tuple[X, X], within: Callable[[X, X], bool] | None = None,
    *, width: float | Mpf = 0.0,
) -> X:  # fmt: skip
    """Return a zero from values alone: inverse quadratic interpolation where it is safe, else bisection.

    The rule by which interpolation is safe is that of Chandrupatla, Advances in Engineering Software 28 (1997) 145.

    Args:
        function: x ↦ f, costly; infinite where there is no value.
        ends: of the bracket.
        values: f there, of opposite signs.
        within: (x, f) ↦ whether x is good enough; None for f = 0 alone.
        width: of the last bracket, over |x|.
    """
    (b, a), (fb, fa) = ends, values
    c, fc, fraction = a, fa, a * 0 + 0.5
    best = min(((abs(fa), a, fa), (abs(fb), b, fb)), key=lambda one: one[0])
    for _ in range(_MOST_VALUES):
        if not best[2] or (within is not None and within(best[1], best[2])):
            break
        # a step of less than the width asked would leave the other end of the bracket where it is
        least = width * abs(best[1]) / abs(b - a)
        if 2 * least >= 1:
            break
        x = a + min(max(fraction, least), 1 - least) * (b - a)
        if x in (a, b):
            break
        f = function(x)
        if f * fa > 0:
            c, fc = a, fa
        else:
            c, b, fc, fb = b, a, fb, fa
        a, fa = x, f
        best = min(best, (abs(f), x, f), key=lambda one: one[0])
        ξ, φ = (a - b) / (c - b), (fa - fb) / (fc - fb)
        if φ**2 < ξ and (1 - φ) ** 2 < 1 - ξ:
            fraction = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        else:
            fraction = a * 0 + 0.5
    return best[1]


def bracketed_roots(
    function: Callable[[Reals], tuple[Reals, Reals]], x: Reals, low: Reals, high: Reals, close: float = 0.0
) -> tuple[Reals, Reals, Reals]:
    """Newton's method for an increasing function, element by element, never leaving its bracket.

    Args:
        function: x ↦ (f, f′), arrays of shape (m,).
        x, low, high: start and bracket, shape (m,).
        close: steps so small, in the unit of x, are the last; 0 for the last bits.

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
        last = max(close, 16 * EPS if count > 3 else 0.0)
        if np.all(moved <= 4 * EPS * np.maximum(np.abs(x), 1e-290)) or np.all(moved <= last):
            break
    f, slope = function(x)
    return x, f, slope


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
