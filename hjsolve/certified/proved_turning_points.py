"""The turning points of a libration, proved by balls on one walk to each side.

The walk goes outward from the start, F = p² > 0 at its front. A step from x₀ to x₁ is taken where F(x₁) > 0 and, on the
ball between, F′ has one sign, F″ < 0 or F > 0. It ends where F(x₁) < 0 and F′ < 0 or F″ < 0 on the ball: one simple
zero. Where neither is seen the step is made smaller; a walk that gets tired proves nothing, and ``turning_points`` has
to decide. What that does for any motion, with arrays of intervals, this does quickly for the usual one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from hjsolve.arithmetic.ball import between, flint, from_mpf, working
from hjsolve.certified.ball_radicand import BallMomentumSquared
from hjsolve.one_coordinate.coordinate_start import CoordinateStart

_BITS = 128  # of the balls of the walk: 22 digits more than doubles have
_MOST_STEPS = 240  # each up to twice the last: a factor of 10⁷² in all
_SMALLEST = 2.0**-60  # of the first step: below, a double plus the step is the double
_NEWTON = 30  # in a bracket, for a centre of 25 bits: a simple zero takes five from nearby


@dataclass(frozen=True)
class ProvedTurningPoint:
    """A simple zero of p², and p² > 0 from the start up to it.

    Attributes:
        inside, outside: distances from the start between which it lies, and no other zero.
        guess: its place, as an exact ball; Newton's last step was below 2⁻²⁵ of the way.
    """

    inside: float
    outside: float
    guess: flint.arb


def prove_turning_points(
    start: CoordinateStart, place: flint.arb, line: BallMomentumSquared
) -> tuple[ProvedTurningPoint, ProvedTurningPoint] | None:
    """Return the turning points below and above the start; None where that could not be proved.

    Args:
        place: a ball that holds its initial place.
        line: its p² in balls.
    """
    with working(_BITS):
        # a ball of 2^(8 − bits) about the start: what is proved from it holds for the exact place
        origin = flint.arb(
            from_mpf(start.place(_BITS)), abs(from_mpf(start.place(_BITS))) * flint.arb(2) ** (8 - _BITS)
        )
        walker = _Walker(line.rounded(_BITS), origin)
        still = ProvedTurningPoint(0.0, 0.0, place.mid())
        found: list[ProvedTurningPoint | None] = []
        for side in (-1, 1):
            # a start at rest is itself a turning point: the sign of F′ says on which side the motion lies
            resting = start.forward == 0
            if resting and walker.rises(-side):
                found.append(still)
                continue
            if resting and not walker.rises(side):
                return None
            found.append(walker.walk(side, _reach(start, side), resting=resting))
            if found[-1] is None:
                return None
        return found[0], found[1]  # type: ignore[return-value]


def _reach(start: CoordinateStart, side: int) -> float | None:
    """Return how far the domain goes, or a turn of an angle; None where it has no end."""
    if start.angle:
        return 2 * math.pi
    end = start.upper if side > 0 else start.lower
    return None if end is None else abs(float(end(64) - start.place(64))) * (1 - 2.0**-40)


@dataclass(frozen=True)
class _Walker:
    """F along the line, from a start."""

    line: BallMomentumSquared
    origin: flint.arb

    def rises(self, side: int) -> bool:
        """Return True when F certainly grows from the start to one side."""
        return bool(side * self.line.taylor(self.origin, 2)[1] > 0)

    def walk(self, side: int, reach: float | None, *, resting: bool) -> ProvedTurningPoint | None:
        """Walk to one side; ``resting``: F = 0 at the start itself."""
        x0, steps, here = 0.0, _MOST_STEPS, self.line.value(self.origin)
        if not resting and not here > 0:
            return None
        # the first step follows from F/F′, F′/F″ and √(F/F″): the lengths over which F changes
        step = first = self._step(reach)
        growth = 2.0
        while (steps := steps - 1) > 0 and step > _SMALLEST * first:
            x1 = x0 + step if reach is None else min(x0 + step, reach)
            if x1 <= x0:
                return None
            # the sign at the front is decided at a point; what lies between is decided over the ball
            end = self.line.value(self.origin + side * flint.arb(x1))
            ball = self.origin + side * between(x0, x1)
            value, slope, bend = self.line.taylor(ball, 3)
            slope = side * slope
            # F > 0 at both ends, and monotone, concave or positive between: no zero was passed
            if end > 0 and (slope > 0 or slope < 0 or bend < 0 or value > 0):
                x0, here, step, growth = x1, end, growth * step, min(2.0, growth + 0.25)
            # from F > 0 to F < 0, falling or concave: exactly one zero, and it is simple
            elif end < 0 and (slope < 0 or bend < 0):
                return ProvedTurningPoint(x0, x1, self._refined(side, x0, x1, float((here / (here - end)).mid())))
            else:
                step, growth = (x1 - x0) * 0.4, 1.0
        return None

    def _step(self, reach: float | None) -> float:
        """Return a first step: a part of the way there is, or a length over which F changes."""
        if reach is not None:
            return reach / 8
        value, slope, bend = (float(abs(x).mid()) for x in self.line.taylor(self.origin, 3))
        guesses = [
            value / slope if slope else 0.0,
            slope / bend if bend else 0.0,
            (value / bend) ** 0.5 if bend else 0.0,
        ]
        return min((x for x in guesses if x > 0), default=1.0) / 2

    def _refined(self, side: int, x0: float, x1: float, part: float) -> flint.arb:
        """Newton's method kept inside a bracket, from a part of the way on."""
        low, high = flint.arb(x0), flint.arb(x1)  # centres of balls, to 25 bits: a guess, proved afterwards
        x = flint.arb(x0 + min(0.9, max(0.1, part)) * (x1 - x0))
        for _ in range(_NEWTON):
            value, slope = (part.mid() for part in self.line.taylor(self.origin.mid() + side * x, 2))
            low, high = (x, high) if value > 0 else (low, x)
            if slope == 0:
                # a zero slope between a positive and a negative value: halve
                new = (low + high) / 2
            else:
                # the sign of the side: x counts the distance outward, F′ the direction of q
                new = (x - side * value / slope).mid()
            new = new if low < new < high else ((low + high) / 2).mid()
            if abs(new - x) <= abs(new) * 2.0**-25:
                return (self.origin.mid() + side * new).mid()
            x = new
        return (self.origin.mid() + side * x).mid()
