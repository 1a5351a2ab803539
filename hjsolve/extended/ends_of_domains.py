"""When a motion known by formulas first reaches an end of a domain, proved by steps that pass no zero.

Let g be the distance from the end, known to ε, and |g̈| ≤ M over the next times. A time h later it is at least
g − ε + ġ h − M h²/2, so that no zero lies within the step

    h = (ġ + √(ġ² + 2M(g − ε)))/M.

Next to a zero with ġ < 0 these are steps of Newton's method from the side where nothing is lost: they converge.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import NotConvergedError
from hjsolve.mechanics.system import System
from hjsolve.motion.initial_data import domain_ends, to_bits

_MOST_STEPS = 200_000
"""About 20 000 oscillations next to an end that is not reached."""
_ROUNDINGS = 16
"""Of g = ±(q − end) and of h, in units of the last place of q and of the end; generous."""


class Wall(NamedTuple):
    """An end of the domain of a coordinate: q > end with ``side`` 1, q < end with −1.

    Attributes:
        row: of the coordinate among all.
    """

    row: int
    side: int
    end: sp.Expr


class Approach(NamedTuple):
    """Where a motion is: the coordinates, their rates by the time walked, and bounds on the errors of each of both."""

    q: Sequence[Mpf]
    rates: Sequence[Mpf]
    error: Mpf
    error_of_rates: Mpf


Bends = Callable[[int, Mpf, Mpf], Mpf]
"""(row of a coordinate, a, b) ↦ a bound on |q̈| from a to b."""


def walls_of(system: System, values: Mapping[sp.Symbol, sp.Expr]) -> tuple[Wall, ...]:
    """Return the ends of all domains.

    Args:
        system: whose coordinates are meant.
        values: symbol → exact number, of the parameters.
    """
    ends = [domain_ends(system, c.name, values) for c in system.coordinates]
    sided = ((row, *pair) for row, both in enumerate(ends) for pair in zip((1, -1), both, strict=True))
    return tuple(Wall(row, side, end) for row, side, end in sided if end is not None)


def first_end(
    walls: Sequence[Wall], start: Mpf, stop: Mpf, at: Callable[[Mpf], Approach], bends: Bends
) -> Estimate | None:
    """Return when the first of some ends is reached, None where none is.

    Args:
        walls: the ends, all with q inside at the start.
        start, stop: from when, and how long, the motion is followed; start ≤ stop.
        at: time walked ↦ where the motion is.
        bends: bounds on second derivatives.

    Raises:
        NotConvergedError: the motion comes next to the end too often.
    """
    context, t = stop.context, start
    ends = [context.convert(to_bits(wall.end)(context.prec)) for wall in walls]
    window = stop - start
    for _ in range(_MOST_STEPS):
        place, step = at(t), stop - t
        if not step:
            return None
        window = min(window, step)
        for wall, end in zip(walls, ends, strict=True):
            q, rate = place.q[wall.row], wall.side * place.rates[wall.row]
            ε = place.error + _ROUNDINGS * context.ldexp(abs(q) + abs(end), -context.prec)
            g = wall.side * (q - end)
            if g <= 3 * ε:
                return Estimate(t, _uncertain(g + ε, rate, bends(wall.row, t, t)))
            while True:  # bounds over long times may be larger than the motion comes to need
                M = bends(wall.row, t, t + window)
                h = _free(g - ε, rate - place.error_of_rates, M)
                if h >= window or h > window / 16:
                    break
                window /= 4
            step = min(step, h)
        step = min(step, window)
        if t + step == t:
            raise NotConvergedError("a motion touches an end of its domain: whether it reaches it needs more digits")
        t, window = (stop if step == stop - t else t + step), 2 * step + window
    raise NotConvergedError(
        f"a motion comes next to an end of its domain too often to be followed to t = {float(stop):.6g}"
    )


def _free(g: Mpf, rate: Mpf, M: Mpf) -> Mpf:
    """Return a time in which g + ġ h − M h²/2 stays positive."""
    context = g.context
    if g <= 0:
        return context.mpf(0)
    root = context.sqrt(rate**2 + 2 * M * g)
    if rate <= 0:
        return 2 * g / (root - rate) if root > rate else context.inf
    return (rate + root) / M if M else context.inf


def _uncertain(g: Mpf, rate: Mpf, M: Mpf) -> Mpf:
    """Return within which time g comes to 0 by its rate; twice √(2g/M) where it may only touch."""
    context = g.context
    touch = context.sqrt(2 * g / M) if M else context.mpf(0)
    return 2 * g / -rate if rate < 0 and M * g < rate**2 / 4 else 2 * touch
