"""Formulas with exponentials over disks far out: f = e^{λq} φ with a disk for φ.

Where all λ are multiples of one number ``arithmetic.local_expansion`` knows more; here they may be anything.

A disk that holds e^z over |z − c| ≤ r holds 0 as soon as r is above log 2, and cosh overflows; but what a motion needs
is a quotient, 8 e^{2q}/(1 + e^{2q})², whose exponentials go together: λ = −2, and φ = 8/(1 + e^{−2q})² is nearly
constant.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks, single
from hjsolve.arithmetic.number_types import Reals

EXPONENTIAL = frozenset({"exp", "sinh", "cosh", "sech"})
_LARGE = 600.0
_D = Disks()
_ONE, _ZERO = single(1.0, 0.0), single(0.0, 0.0)


class Rated(NamedTuple):
    """e^{λq} φ; ``line`` holds a and b where the number is known to be a q + b."""

    rate: float
    value: Disk
    line: tuple[Disk, Disk] | None = None


@dataclass(frozen=True)
class Rates:
    """Arithmetic on ``Rated`` over disks that all lie on one side of 0.

    Attributes:
        q: the disks.
        side: the sign of their real parts.
    """

    q: Disk
    side: int

    def constant(self, value: Disk) -> Rated:
        """Return a number that does not depend on q."""
        return Rated(0.0, value, (_ZERO, value))

    def variable(self) -> Rated:
        return Rated(0.0, self.q, (_ONE, _ZERO))

    def rational(self, numerator: int, denominator: int) -> Rated:
        """Return a fraction."""
        return self.constant(_D.rational(numerator, denominator))

    def pi(self) -> Rated:
        return self.constant(_D.pi())

    def _power_of_e(self, rate: float) -> Disk:
        return _D.unary("exp", _D.times(self.q, rate))

    def whole(self, x: Rated) -> Disk:
        """Return the number itself.

        Args:
            x: e^{λq} φ.
        """
        return x.value if x.rate == 0 else _D.mul(self._power_of_e(x.rate), x.value)

    def add(self, x: Rated, y: Rated) -> Rated:
        """Return x + y: the one that grows faster keeps its λ, the other enters its φ."""
        line = None
        if x.line and y.line:
            line = _D.add(x.line[0], y.line[0]), _D.add(x.line[1], y.line[1])
        if x.rate != y.rate:
            if self.side * x.rate < self.side * y.rate:
                x, y = y, x
            y = Rated(x.rate, _D.mul(self._power_of_e(y.rate - x.rate), y.value))
        return Rated(x.rate, _D.add(x.value, y.value), line)

    def sub(self, x: Rated, y: Rated) -> Rated:
        """Return x − y, in the same way."""
        return self.add(x, self.unary("neg", y))

    def mul(self, x: Rated, y: Rated) -> Rated:
        """Return x·y; the λ are added."""
        line = None
        if x.line and y.line:
            for one, other in ((x.line, y.line), (y.line, x.line)):
                if one[0] is _ZERO:
                    line = other[0] if other[0] is _ZERO else _D.mul(one[1], other[0]), _D.mul(one[1], other[1])
        return Rated(x.rate + y.rate, _D.mul(x.value, y.value), line)

    def div(self, x: Rated, y: Rated) -> Rated:
        """Return x/y; the λ are subtracted."""
        return self.mul(x, self.power(y, -1))

    def power(self, x: Rated, n: int) -> Rated:
        """Return xⁿ; λ is multiplied by n."""
        value = _D.power(x.value, n)
        constant = x.line is not None and x.line[0] is _ZERO
        return Rated(n * x.rate, value, (_ZERO, value) if constant else None)

    def unary(self, name: str, x: Rated) -> Rated:
        """Return a function of x; an exponential of a q + b becomes a factor e^{aq}."""
        if name == "neg":
            line = x.line and (x.line[0] if x.line[0] is _ZERO else -x.line[0], -x.line[1])
            return Rated(x.rate, -x.value, line)
        if x.line is not None and x.line[0] is _ZERO:
            return self.constant(_D.unary(name, x.value))
        if name in EXPONENTIAL and x.line is not None:
            return self._exponential(name, x.line)
        if name == "sqrt":
            return Rated(x.rate / 2, _D.unary("sqrt", x.value))
        if name == "log" and x.rate:
            return Rated(0.0, _D.add(_D.times(self.q, x.rate), _D.unary("log", x.value)))
        return Rated(0.0, _D.unary(name, self.whole(x)))

    def _exponential(self, name: str, line: tuple[Disk, Disk]) -> Rated:
        a, b = line
        rate = float(np.real(a.centre))
        if abs(np.real(b.centre)) > _LARGE:  # about a place far away: e^b would overflow
            return Rated(0.0, _D.unary(name, _D.add(_D.mul(a, self.q), b)))
        # what rounding leaves of the slope stays in the disk
        rest = _D.add(b, _D.mul(self.q, Disk(a.centre - rate, a.radius)))
        if name == "sech":
            return self.power(self._exponential("cosh", line), -1)
        if name == "exp":
            return Rated(rate, _D.unary("exp", rest))
        sign = 1.0 if self.side * rate > 0 else -1.0
        main = _D.unary("exp", _D.times(rest, sign))
        small = _D.unary("exp", _D.times(_D.add(_D.times(self.q, rate), rest), -2 * sign))
        both = _D.add(_ONE, small) if name == "cosh" else _D.sub(_ONE, small)
        scale = 0.5 if name == "cosh" else 0.5 * sign
        return Rated(sign * rate, _D.times(_D.mul(main, both), scale))


def largest(q: Disk, rate: float) -> Reals:
    """Return the exponent of the largest |e^{λq}|.

    Args:
        q: disks.
        rate: λ.
    """
    return rate * np.real(q.centre) + abs(rate) * q.radius
