"""A formula seen from one place e of its line, over disks: f = uᵏ φ with φ = φ(e) + φ[e, q] u, u = q − e.

What vanishes or has a pole at e keeps its relative accuracy however small u is, and nothing that is common to f(q) and
f(e) matters. Differences on e, e, q are carried through a formula by the rules of ``divided_differences``; one of an
elementary function is a quotient or a mean value over the hull, whichever is narrower. Poles and zeros of the parts of
a formula are taken out where their orders are known.

The place may be infinity, with u = 1/q, or with u = e^{−c|q|}: q itself has no series in that u, but exp(aq + b) is
e^b times a power of it. So what is linear in q is kept as a and b.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import ceil, lcm
from typing import Final, Literal, NamedTuple

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks, hull, tighter
from hjsolve.arithmetic.divided_differences import of_composition, of_product, of_reciprocal
from hjsolve.arithmetic.floats import by_squaring
from hjsolve.arithmetic.tape import Tape
from hjsolve.errors import required

_DISKS = Disks()
_EXPONENTIAL = frozenset({"exp", "sinh", "cosh", "tanh", "sech"})
_HIGHEST = 48
"""Of the powers of one exponential."""
ZERO: Final = "zero"
"""In place of an order: the number is exactly 0."""


class LocalExpansion(NamedTuple):
    """f = uᵏ φ: φ(q), φ[e, q], φ[e, e, q], as many as are known; the first element of each array is at q = e.

    ``constant``: f does not depend on q, and all further differences are 0. ``line``: a and b where f = a q + b, known
    only with exponentials.
    """

    order: float
    parts: tuple[Disk, ...]
    constant: bool = False
    line: tuple[Disk, Disk] | None = None


def _after(base: Disk, cells: Disk) -> Disk:
    """Return the cells with the base before them."""
    return Disk(np.append(base.centre, cells.centre), np.append(base.radius, cells.radius))


def _at_base(x: Disk) -> Disk:
    """Return the element that belongs to q = e."""
    return Disk(np.ravel(x.centre)[0], np.ravel(x.radius)[0])


@dataclass
class Locals:
    """Arithmetic on ``LocalExpansion``.

    Attributes:
        offset: u over all cells; its first element is 0.
        depth: greatest order of a difference that is kept, 1 or 2.
        rate: −c·sign q where u = e^{−c|q|}, else 0.
        orders: of the slots of the tape that is run, in their order; None for one that is not known. Empty: none is.
        q: the cells, the first element of no meaning, where u is an exponential.
    """

    offset: Disk
    depth: int
    orders: Sequence[int | Literal["zero"] | None] = ()
    rate: float = 0.0
    q: Disk | None = None
    _count: int = field(default=0)

    def constant(self, value: Disk) -> LocalExpansion:
        """Return a number that does not depend on q."""
        return LocalExpansion(0, (value,), constant=True)

    def variable(self, base: Disk, sign: float, q: Disk | None = None, *, centred: bool = False) -> LocalExpansion:
        """Return q = e + sign·u; the cells themselves may be known more closely.

        With e = 0, ``centred``, it is of first order.

        Args:
            base: e, or f(e).
            sign: +1 or −1.
            q: the cells, where they are known more closely; None elsewhere.
            centred: True where e = 0.
        """
        slope = self._full(sign)
        if centred:
            return LocalExpansion(1, (slope, *(self._full(0.0) for _ in range(self.depth))))
        value = _DISKS.add(base, _DISKS.mul(slope, self.offset))
        if q is not None:
            value = tighter(value, _after(base, q))
        return LocalExpansion(0, (value, slope, *(self._full(0.0) for _ in range(self.depth - 1))))

    def inverse_variable(self, sign: float) -> LocalExpansion:
        """Return q = sign/u: the place is infinity.

        Args:
            sign: +1 or −1.
        """
        return LocalExpansion(-1, (self._full(sign), *(self._full(0.0) for _ in range(self.depth))))

    def exponent(self) -> LocalExpansion:
        """Return q where u is an exponential."""
        return LocalExpansion(0, (required(self.q),), line=(_DISKS.rational(1, 1), _DISKS.rational(0, 1)))

    def _full(self, value: float) -> Disk:
        return Disk(np.full(np.shape(self.offset.radius), value, dtype=complex), np.zeros(np.shape(self.offset.radius)))

    # ------------------------------------------------------------------ what a tape calls: one result a slot

    def rational(self, numerator: int, denominator: int) -> LocalExpansion:
        """Return a constant: all differences are zero."""
        return self._of_known_order(self.constant(_DISKS.rational(numerator, denominator)))

    def pi(self) -> LocalExpansion:
        return self._of_known_order(self.constant(_DISKS.pi()))

    def add(self, x: LocalExpansion, y: LocalExpansion) -> LocalExpansion:
        """Return x + y; where the leading parts cancel at e, the order is raised if it is known."""
        return self._of_known_order(self._add(x, y))

    def sub(self, x: LocalExpansion, y: LocalExpansion) -> LocalExpansion:
        """Return x − y, in the same way."""
        return self._of_known_order(self._add(x, self._negative(y)))

    def mul(self, x: LocalExpansion, y: LocalExpansion) -> LocalExpansion:
        """Return x·y; orders are added, differences by Leibniz' rule."""
        return self._of_known_order(self._mul(x, y))

    def div(self, x: LocalExpansion, y: LocalExpansion) -> LocalExpansion:
        """Return x/y; orders are subtracted."""
        return self._of_known_order(self._mul(x, self._inverse(y)))

    def power(self, x: LocalExpansion, n: int) -> LocalExpansion:
        """Return xⁿ; the order is multiplied by n."""
        if n == 0:
            return self._of_known_order(self.constant(_DISKS.rational(1, 1)))
        base = self._inverse(x) if n < 0 else x
        result = by_squaring(self._mul, base, abs(n))
        if not x.constant:  # a power of a disk is narrower than its product with itself
            result = result._replace(parts=(_DISKS.power(base.parts[0], abs(n)), *result.parts[1:]))
        return self._of_known_order(result)

    def unary(self, name: str, x: LocalExpansion) -> LocalExpansion:
        """Return Φ(x), by the differences of Φ over disks."""
        return self._of_known_order(self._negative(x) if name == "neg" else self._unary(name, x))

    # ------------------------------------------------------------------ orders

    def _of_known_order(self, x: LocalExpansion) -> LocalExpansion:
        """Take out what is known of the order of this slot."""
        if not self.orders:
            return x
        known = self.orders[self._count]
        self._count += 1
        if known == ZERO:
            return self.constant(_DISKS.rational(0, 1))
        if known is None or x.constant:
            return x
        while known > x.order and len(x.parts) > 1:  # φ(e) = 0
            x = LocalExpansion(x.order + 1, x.parts[1:])
        return self.lowered(x, known) if known < x.order else x

    def _scale(self, n: float) -> Disk:
        """Return uⁿ."""
        return _DISKS.power(self.offset, int(n))

    def _order(self, rate: float) -> float:
        """Return the order of e^{aq} for the real part of a, a multiple of ``rate``."""
        return round(rate / self.rate)

    def lowered(self, x: LocalExpansion, order: float) -> LocalExpansion:
        """Return the same with φ multiplied by a power of u.

        Args:
            x: of some order.
            order: the lower order.
        """
        n = x.order - order
        if n == 0:
            return x
        parts = [_DISKS.mul(self._scale(n - i), x.parts[0]) for i in range(min(ceil(n), self.depth + 1))]
        if n <= self.depth:
            parts += x.parts[: self.depth + 1 - int(n)]
        return LocalExpansion(order, tuple(parts))

    # ------------------------------------------------------------------ the arithmetic

    def _negative(self, x: LocalExpansion) -> LocalExpansion:
        line = x.line and (-x.line[0], -x.line[1])
        return x._replace(parts=tuple(-part for part in x.parts), line=line)

    def _add(self, x: LocalExpansion, y: LocalExpansion) -> LocalExpansion:
        if x.constant and y.constant:
            return self.constant(_DISKS.add(x.parts[0], y.parts[0]))
        if not self.rate:
            return self._sum(x, y)
        one, other = (part.line or (_DISKS.rational(0, 1), part.parts[0]) for part in (x, y))
        known = all(part.line or part.constant for part in (x, y))
        line = (_DISKS.add(one[0], other[0]), _DISKS.add(one[1], other[1])) if known else None
        return self._sum(x, y)._replace(line=line)

    def _sum(self, x: LocalExpansion, y: LocalExpansion) -> LocalExpansion:
        if x.constant:
            x, y = y, x
        if y.constant and x.order == 0:
            return x._replace(parts=(_DISKS.add(x.parts[0], y.parts[0]), *x.parts[1:]))
        y = self._opened(y)
        order = min(x.order, y.order)
        x, y = self.lowered(x, order), self.lowered(y, order)
        return LocalExpansion(order, tuple(_DISKS.add(a, b) for a, b in zip(x.parts, y.parts, strict=False)))

    def _opened(self, x: LocalExpansion) -> LocalExpansion:
        if not x.constant:
            return x
        value = Disk(np.broadcast_to(x.parts[0].centre, np.shape(self.offset.radius)),
                     np.broadcast_to(x.parts[0].radius, np.shape(self.offset.radius)))  # fmt: skip
        return LocalExpansion(0, (value, *(self._full(0.0) for _ in range(self.depth))))

    def _mul(self, x: LocalExpansion, y: LocalExpansion) -> LocalExpansion:
        d = _DISKS
        if y.constant:
            x, y = y, x
        if x.constant:
            line = y.line and (d.mul(x.parts[0], y.line[0]), d.mul(x.parts[0], y.line[1]))
            return y._replace(parts=tuple(d.mul(x.parts[0], part) for part in y.parts), line=line)
        parts = [d.mul(x.parts[0], y.parts[0])]
        known = min(len(x.parts), len(y.parts))
        bases = [_at_base(part) for part in x.parts[: known - 1]]
        parts += [of_product(d, bases[:i], x.parts, y.parts) for i in range(1, known)]
        return LocalExpansion(x.order + y.order, tuple(parts))

    def _inverse(self, x: LocalExpansion) -> LocalExpansion:
        """1/f: f·(1/f) = 1 and Leibniz' rule."""
        d = _DISKS
        value = d.inverse(x.parts[0])
        if x.constant:
            return self.constant(value)
        parts = [value]
        base = _at_base(value)
        if len(x.parts) > 1:
            parts.append(-d.mul(d.mul(base, value), x.parts[1]))
        if len(x.parts) > 2:
            ends = _at_base(x.parts[0]), _at_base(x.parts[1])
            parts.append(of_reciprocal(d, (base, base, value), ends, x.parts[1:]))
        return LocalExpansion(-x.order, tuple(parts))

    def _unary(self, name: str, x: LocalExpansion) -> LocalExpansion:
        d = _DISKS
        if x.constant:
            return self.constant(d.unary(name, x.parts[0]))
        if x.line is not None and name in _EXPONENTIAL:
            return self._exponential(name, x.line)
        if name == "sqrt" and x.order % 2 == 0:
            return self._composed(name, LocalExpansion(0, x.parts))._replace(order=x.order // 2)
        if name == "log" and x.order:
            return self._logarithm(x)
        if x.order < 0:  # no expansion; its values where u is not 0
            return LocalExpansion(0, (d.unary(name, d.mul(x.parts[0], self._scale(x.order))),))
        return self._composed(name, self.lowered(x, 0))

    def _exponential(self, name: str, line: tuple[Disk, Disk]) -> LocalExpansion:
        """e^{aq + b} = uᵏ e^{b + …}, and what is made of it."""
        d = _DISKS
        if name == "tanh":
            return self._mul(self._exponential("sinh", line), self._inverse(self._exponential("cosh", line)))
        if name == "sech":
            return self._inverse(self._exponential("cosh", line))
        if name == "exp":
            order = self._order(float(np.real(line[0].centre)))
            left = d.mul(d.shifted(line[0], -order * self.rate), self.exponent().parts[0])
            return LocalExpansion(
                order, (d.unary("exp", d.add(left, line[1])), *(self._full(0.0) for _ in range(self.depth)))
            )
        up, down = (self._exponential("exp", ends) for ends in (line, (-line[0], -line[1])))
        both = self._sum(up, down if name == "cosh" else self._negative(down))
        return both._replace(parts=tuple(d.times(part, 0.5) for part in both.parts))

    def _logarithm(self, x: LocalExpansion) -> LocalExpansion:
        d = _DISKS
        log = d.times(self.exponent().parts[0], self.rate) if self.rate else d.unary("log", self.offset)
        return LocalExpansion(0, (d.add(d.times(log, x.order), d.unary("log", x.parts[0])),))

    def _composed(self, name: str, x: LocalExpansion) -> LocalExpansion:
        d, f = _DISKS, x.parts
        value = d.unary(name, f[0])
        if len(f) == 1:
            return LocalExpansion(0, (value,))
        f0, at0 = _at_base(f[0]), _at_base(value)
        first = d.chord(name, f[0], f0, value, at0)
        parts = [value, d.mul(first, f[1])]
        if len(f) > 2:
            close = d.times(d.bend(name, hull(f[0], f0)), 0.5)
            second = tighter(d.div(d.sub(first, _at_base(first)), d.sub(f[0], f0)), close)
            parts.append(of_composition(d, first, second, _at_base(f[1]), f[1:]))
        return LocalExpansion(0, tuple(parts))


def _unit(rates: list[float]) -> float:
    """Return the largest number of which all are multiples, 0 where there is none or the multiples are high."""
    least = min((abs(a) for a in rates if a), default=0.0)
    if not least:
        return 0.0
    ratios = [Fraction(a / least).limit_denominator(_HIGHEST) for a in rates]
    if any(abs(r * least - a) > 1e-12 * abs(a) for r, a in zip(ratios, rates, strict=True)):
        return 0.0
    common = lcm(*(r.denominator for r in ratios))
    return least / common if max(abs(r) for r in ratios) * common <= _HIGHEST else 0.0


@dataclass
class _Listening(Locals):
    """The same, writing down the rates of all exponentials."""

    heard: list[float] = field(default_factory=list)

    def _exponential(self, name: str, line: tuple[Disk, Disk]) -> LocalExpansion:  # noqa: ARG002  (asked like the others)
        self.heard.append(float(np.real(line[0].centre)))
        return LocalExpansion(0, (_DISKS.rational(1, 1),))


def exponential_unit(tapes: Sequence[Tape], inputs: list[Disk]) -> float:
    """Return c such that all exponentials of linear forms are powers of e^{cq}; 0 where there is none."""
    place = Disk(np.array([0.0, 1.0]), np.array([0.0, 0.0]))
    listening = _Listening(place, 1, rate=1.0, q=place)
    for tape in tapes:
        tape.run(listening, [listening.exponent(), *map(listening.constant, inputs)])
    return _unit(listening.heard)
