"""The regular factor of p² over disks: R(q) = −F[a, b, q], the second divided difference on the two turning points.

With F(a) = F(b) = 0 it is p² = (q − a)(b − q) R(q). The difference is carried through the formula by Leibniz' rule

    (fg)[b, q] = f(b) g[b, q] + f[b, q] g(q),   (fg)[a, b, q] = f(a) g[a, b, q] + f[a, b] g[b, q] + f[a, b, q] g(q),

and through an elementary function Φ by (Φ∘f)[a, b, q] = Φ[f(b), f(q)] f[a, b, q] + f[a, b] f[a, q] Φ[f(a), f(b), f(q)]
(Krawczyk & Neumaier, SIAM J. Numer. Anal. 22 (1985) 604). A difference of Φ is a quotient where its points are far
apart, and a mean value of Φ′ or ½Φ″ over their hull where they are close (Hermite–Genocchi): the smaller disk is taken.
However small b − a is, nothing cancels, and constants added to F do not matter.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from hjsolve.numeric.arithmetic import by_squaring
from hjsolve.numeric.disks import Disk, Disks, hull, tighter

_DISKS = Disks()


class Ends(NamedTuple):
    """Where q is seen from: the disks q − a, q − b and b − a."""

    from_lower: Disk
    from_upper: Disk
    width: Disk


class Values(NamedTuple):
    """f(a), f(b), f[a, b], then f(q), f[b, q], f[a, q] and f[a, b, q]; a constant has only the first."""

    lower: Disk
    upper: Any = None
    chord: Any = None
    here: Any = None
    from_upper: Any = None
    from_lower: Any = None
    second: Any = None
    ends: Any = None


def place(lower: Disk, upper: Disk, here: Disk, ends: Ends) -> Values:
    """Return the values of q itself."""
    one, zero = _DISKS.rational(1, 1), _DISKS.rational(0, 1)
    return Values(lower, upper, one, here, one, one, zero, ends)


def _made(lower: Disk, upper: Disk, chord: Disk, here: Disk, second: Disk, ends: Ends) -> Values:
    """Fill in f[b, q] = f[a, b] + (q − a) f[a, b, q] and f[a, q] = f[a, b] + (q − b) f[a, b, q].

    What cannot be had from the parts of a formula, because they overflow, is had from its values.
    """
    d = _DISKS
    if not chord.known.all():
        chord = tighter(chord, d.div(d.sub(upper, lower), ends.width))
    if not second.known.all():
        slope = d.div(d.sub(here, upper), ends.from_upper)
        second = tighter(second, d.div(d.sub(slope, chord), ends.from_lower))
    from_upper = d.add(chord, d.mul(ends.from_lower, second))
    from_lower = d.add(chord, d.mul(ends.from_upper, second))
    return Values(lower, upper, chord, here, from_upper, from_lower, second, ends)


class Differences:
    """Arithmetic on ``Values`` over disks of q."""

    __slots__ = ()

    def rational(self, numerator: int, denominator: int) -> Values:
        return Values(_DISKS.rational(numerator, denominator))

    def pi(self) -> Values:
        return Values(_DISKS.pi())

    def add(self, x: Values, y: Values) -> Values:
        d = _DISKS
        if y.second is None:
            x, y = y, x
        if y.second is None:
            return Values(d.add(x.lower, y.lower))
        if x.second is None:
            return y._replace(lower=d.add(x.lower, y.lower), upper=d.add(x.lower, y.upper), here=d.add(x.lower, y.here))
        return Values(*(d.add(a, b) for a, b in zip(x[:-1], y[:-1], strict=True)), x.ends)

    def sub(self, x: Values, y: Values) -> Values:
        return self.add(x, self.unary("neg", y))

    def mul(self, x: Values, y: Values) -> Values:
        d = _DISKS
        if y.second is None:
            x, y = y, x
        if x.second is None:
            return Values(*(None if part is None else d.mul(x.lower, part) for part in y[:-1]), y.ends)
        second = d.add(
            d.add(d.mul(x.lower, y.second), d.mul(x.chord, y.from_upper)),
            d.mul(x.second, y.here),
        )
        chord = d.add(d.mul(x.lower, y.chord), d.mul(x.chord, y.upper))
        return _made(d.mul(x.lower, y.lower), d.mul(x.upper, y.upper), chord, d.mul(x.here, y.here), second, x.ends)

    def div(self, x: Values, y: Values) -> Values:
        return self.mul(x, self._inverse(y))

    def _inverse(self, y: Values) -> Values:
        """1/f: (1/f)[a, b] = −f[a, b]/(f(a) f(b)), and the second difference by Leibniz' rule on f·(1/f) = 1."""
        d = _DISKS
        if y.second is None:
            return Values(d.inverse(y.lower))
        lower, upper, here = d.inverse(y.lower), d.inverse(y.upper), d.inverse(y.here)
        chord = d.mul(d.mul(lower, upper), _DISKS.unary("neg", y.chord))
        # (1/f)[a, b, q] = (f[a, b] f[a, q] − f(a) f[a, b, q]) / (f(a) f(b) f(q))
        inner = d.sub(d.mul(y.chord, y.from_lower), d.mul(y.lower, y.second))
        return _made(lower, upper, chord, here, d.mul(d.mul(d.mul(lower, upper), here), inner), y.ends)

    def power(self, x: Values, n: int) -> Values:
        if n < 0:
            return self._inverse(self.power(x, -n))
        if n == 0:
            return self.rational(1, 1)
        result: Values = by_squaring(self.mul, x, n)
        if result.here is not None:  # a power of a disk is narrower than its product with itself
            result = result._replace(here=_DISKS.power(x.here, n))
        return result

    def unary(self, name: str, x: Values) -> Values:
        d = _DISKS
        if x.second is None:
            return Values(d.unary(name, x.lower))
        if name == "neg":
            return Values(*(d.unary("neg", part) for part in x[:-1]), x.ends)
        lower, upper, here = (d.unary(name, part) for part in (x.lower, x.upper, x.here))
        chord = _first(name, x.lower, x.upper, lower, upper)
        near = _first(name, x.upper, x.here, upper, here)
        both = hull(hull(x.lower, x.upper), x.here)
        close = d.times(d.bend(name, both), 0.5)
        twice = tighter(d.div(d.sub(near, chord), d.sub(x.here, x.lower)), close)
        second = d.add(d.mul(near, x.second), d.mul(d.mul(x.chord, x.from_lower), twice))
        return _made(lower, upper, d.mul(chord, x.chord), here, second, x.ends)


def _first(name: str, x: Disk, y: Disk, at_x: Disk, at_y: Disk) -> Disk:
    """Φ[x, y]."""
    d = _DISKS
    return tighter(d.div(d.sub(at_y, at_x), d.sub(y, x)), d.derivative(name, hull(x, y)))
