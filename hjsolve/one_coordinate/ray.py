"""A half line along which turning points are looked for, and a simple zero of p² on it at any precision.

A zero x of F is believed to as many digits as |F(x)/F′(x)|, taken with twice the digits, is smaller than x.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.interval import Interval
from hjsolve.arithmetic.number_types import Elementwise, Mpf, Numbers, Reals
from hjsolve.arithmetic.root_finding import bracketed_root
from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.one_coordinate.momentum_squared import MomentumSquared, Number

_MOST_BITS = 65536
"""Of a turning point: by then zeros nearer to each other than 10⁻⁹⁰⁰⁰ would be told apart, or cannot be."""


@dataclass(frozen=True)
class Ray:
    """A half line q = origin + side·x, 0 ≤ x < reach.

    Attributes:
        radicand: p².
        origin: where it begins, at any precision.
        side: +1 upwards, −1 downwards.
        reach: distance to the end of the domain at any precision; None where there is none.
        turns: True where the reach is a full turn of an angle, not an end.
    """

    radicand: MomentumSquared
    origin: Number
    side: int
    reach: Number | None
    turns: bool = False

    def place(self, x: float | Mpf, bits: int) -> Mpf:
        """Return q at a distance from the origin.

        Args:
            x: the distance.
        """
        work = bits + self.radicand.guard
        return self.origin(work) + self.side * multiprecision(work).convert(x)

    def fixed(self, bits: int) -> Ray:
        """Return the ray from an origin that is not asked for ever more bits: it may be a turning point itself.

        Args:
            bits: to which the origin is taken.
        """
        origin = self.origin(bits)
        return replace(self, origin=lambda _: origin)

    def jet(self, x: float | Mpf, bits: int) -> tuple[Mpf, Mpf, Mpf]:
        """Return F, dF/dx and d²F/dx².

        Args:
            x: distance from the origin.
        """
        value, first, second = self.radicand.jet(self.place(x, bits), bits)
        return value, self.side * first, second

    def enclose(self, x0: Reals, x1: Reals, bits: int) -> tuple[Interval, Interval, Interval]:
        """Enclose the same over cells [x0, x1].

        Args:
            x0, x1: distances from the origin, shape (m,).
            bits: working precision; 53 for intervals of doubles.
        """
        if bits == 53:
            near = float(self.origin(128))
            # origin and sum are rounded to doubles: the cell is widened by both
            widening: Elementwise = EPS * (abs(near) + abs(x1))
            ends: tuple[Numbers, Numbers] = near + self.side * x0, near + self.side * x1
        else:
            work = bits + self.radicand.guard
            convert = np.frompyfunc(multiprecision(work).convert, 1, 1)
            origin: Elementwise = self.origin(work)
            widening, ends = 0, (origin + self.side * convert(x0), origin + self.side * convert(x1))
        value, first, second = self.radicand.enclose(np.minimum(*ends) - widening, np.maximum(*ends) + widening, bits)
        # dF/dx = side F′, d²F/dx² = F″
        return value, first if self.side > 0 else type(first)(-first.high, -first.low), second


def _value_and_slope(ray: Ray, bits: int, x: Mpf) -> tuple[Mpf, Mpf]:
    return ray.jet(x, bits)[:2]


class SimpleZero:
    """The place of a simple zero of F in a cell where F is monotone, at any precision.

    Its place is checked by F itself with twice the digits, F/F′ being the error left; what cancellation took away (a
    small amplitude about a deep minimum, close zeros) is made up by more digits. What is known is not worked out again.
    """

    def __init__(self, ray: Ray, x0: float | Mpf, x1: float | Mpf, digits: int):
        self.ray, self.cell, self.digits = ray, (x0, x1), digits
        self.best: tuple[int, Mpf] | None = None

    def __call__(self, bits: int) -> Mpf:
        if self.best is None or self.best[0] < bits:
            self.best = bits, self._found(bits)
        return self.best[1]

    def _found(self, bits: int) -> Mpf:
        ray, (x0, x1), extra = self.ray, self.cell, bits + 64
        while extra <= _MOST_BITS:
            fixed = ray.fixed(extra + 64)
            try:
                # F is monotone in the cell: one zero, and Newton's method in the bracket cannot lose it
                x = bracketed_root(partial(_value_and_slope, fixed, extra), x0, x1, extra)
            except InvalidInputError:  # far from here and next to a pole, which is hit where these bits do not tell
                extra *= 2
                continue
            f, slope, _ = fixed.jet(x, 2 * extra)
            # F/F′ with twice the digits is the error that is left of x
            if not f or abs(f) <= abs(slope * x) * multiprecision(64).mpf(2) ** -(bits + 32):
                return fixed.place(x, 2 * extra)
            # as many bits more as the check has found to be wrong
            left = float(multiprecision(64).log(abs(f / (slope * x)), 2)) if slope else 0.0
            extra += max(64, int(bits + 48 + left))
        raise NotConvergedError(
            f"the turning point near q = {float(ray.place(x1, 128)):.15g} did not converge to {self.digits} digits: "
            "p² is too flat there"
        )
