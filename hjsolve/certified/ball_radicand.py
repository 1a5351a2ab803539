"""p² along the line of one coordinate, in balls: values and Taylor coefficients, and its zeros proved.

If N = m − F(m)/F′(X) lies inside a ball X about m, X holds one zero of F, a simple one, and N holds it (Moore, Interval
Analysis, 1966): one evaluation of F at the centre and one of F′ over the ball.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

from hjsolve.arithmetic.ball import Ball, Balls, BallSeries, flint, working
from hjsolve.arithmetic.tape import BoundTape
from hjsolve.errors import NotConvergedError
from hjsolve.one_coordinate.momentum_squared import MomentumSquared

if TYPE_CHECKING:
    from hjsolve.arithmetic.ball import PowerSeries

_FINE = 256
"""Bits beyond which numbers are rounded before they are used at a low precision; below it costs more than it saves."""
_SPARE = 40
"""Bits that a turning point need not have of the working precision: about half of what that has to spare."""


@dataclass(frozen=True, eq=False)
class BallMomentumSquared:
    """F(q) = p²(q) and its kernels.

    Attributes:
        radicand: p² and kernels.
        inputs: constants and parameters, as balls.
        bits: the precision of the inputs.
    """

    radicand: MomentumSquared
    inputs: list[flint.arb]
    bits: int

    def rounded(self, bits: int) -> BallMomentumSquared:
        """Return the same line for a low precision."""
        # rounding the inputs costs a new tape: worth it where the operations of many digits are dearer
        if self.bits <= _FINE:
            return self
        with working(bits):
            return BallMomentumSquared(self.radicand, [x + 0 for x in self.inputs], bits)

    @cached_property
    def _square(self) -> BoundTape[Ball]:
        with working(self.bits):
            return self.radicand.squared.bind(Balls(), self.inputs)

    @cached_property
    def _series(self) -> BoundTape[Ball | PowerSeries]:
        with working(self.bits):
            return self.radicand.squared.bind(BallSeries(), self.inputs)

    def weights(self, *chosen: int) -> BoundTape[Ball]:
        """Return the rule of some of the kernels.

        Args:
            *chosen: positions of the kernels.
        """
        with working(self.bits):
            return self.radicand.kernels.only(*chosen).bind(Balls(), self.inputs)

    @overload
    def value(self, q: flint.arb) -> flint.arb: ...
    @overload
    def value(self, q: Ball) -> Ball: ...
    def value(self, q: Ball) -> Ball:
        """Return F at a real or complex ball.

        Args:
            q: position, a ball.
        """
        return self._square.run(q)[0]

    @overload
    def taylor(self, q: flint.arb, terms: int) -> list[flint.arb]: ...
    @overload
    def taylor(self, q: Ball, terms: int) -> list[Ball]: ...
    def taylor(self, q: Ball, terms: int) -> Sequence[Ball]:
        """Return F, F′, F″/2 … at a real or complex ball; "nan" for what is not known.

        Args:
            q: position, a ball.
            terms: how many coefficients.
        """
        real = isinstance(q, flint.arb)
        kind, number = (flint.arb_series, flint.arb) if real else (flint.acb_series, flint.acb)
        # the series of q + h: its k-th coefficient is F⁽ᵏ⁾/k! over the ball
        value: Any = self._series.run(kind([q, 1], prec=terms))[0]  # type: ignore[list-item]  # of its own kind
        if not isinstance(value, kind):
            return [number(value), *[number(0)] * (terms - 1)]
        if value.prec < terms:  # cut off on the way (``ball._composed``, ``flint.ctx.cap``)
            return [number("nan")] * terms
        return [value[k] for k in range(terms)]


def turning_point(line: BallMomentumSquared, guess: flint.arb, bits: int) -> flint.arb:
    """Prove a simple zero of F next to a guess by the interval Newton test, and enclose it to about ``bits``.

    Args:
        line: F = p² in balls.
        guess: near the zero.
        bits: wanted of the zero.

    Raises:
        NotConvergedError: the test does not contract.
    """
    # 2^(−bits) stands for the size of a zero at q = 0
    centre, size = guess.mid(), abs(guess.mid()) + flint.arb(2) ** -bits
    for _ in range(2 * bits.bit_length()):
        value, slope = line.taylor(centre, 2)
        # Newton's step in balls of no width doubles the digits; what it is worth is proved below, not here
        step = (value / slope).mid()
        # quadratic convergence: a step below 2^(−bits/2) leaves 2^(−bits); the test before would be over too wide a
        # ball
        if abs(step) < size * flint.arb(2) ** (16 - bits // 2):  # the square of it is left
            found = _contracted(line, centre, value, 2 * abs(step), size, bits)
            if found is not None and (found.rad() < size * flint.arb(2) ** (_SPARE - bits) or value.contains(0)):
                return found
        centre = (centre - step).mid()
    raise NotConvergedError(f"the turning point near {float(guess.mid()):.15g} could not be proved to be one")


def _contracted(
    line: BallMomentumSquared, centre: flint.arb, value: flint.arb, reach: flint.arb, size: flint.arb, bits: int
) -> flint.arb | None:
    """Newton's step from the values of F and the slopes on a ball; it holds the only zero there if it lies inside."""
    # too narrow a ball misses the zero by rounding, too wide a one has a slope that holds 0: several are tried
    for spare in (16, 24, 48, 96, bits // 2):
        around = flint.arb(centre, reach + size * flint.arb(2) ** (spare - bits))
        slope = line.taylor(around, 2)[1]
        # F is monotone on the ball, so that it has at most one zero there
        if not slope.contains(0):
            newton = centre - value / slope
            # N(X) ⊂ X: a zero lies in it, and it is the only one (Moore, Interval Analysis, 1966)
            if around.contains(newton):
                return newton
    return None
