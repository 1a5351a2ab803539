"""What a formula does towards infinity, proved: terms in e^{λs} sᵏ (log s)ᵐ and a remainder, for all s ≥ Q at once.

    f(s) = Σ cᵢ Mᵢ(s) + M(s) φ(s),   low ≤ φ ≤ high for every s ≥ Q

with the monomials M in the order of their growth (a field of Hardy; Gruntz, On Computing Limits in a Symbolic
Manipulation System, ETH 1996, does the same for limits). Terms that cancel are dropped when nothing is left of them in
half of all digits; so a leading term is known even where doubles see only rounding, 2 − 2/(1 + e^{−s}) or 2(s + 2)/(s
+ 1) − 2, and its sign is that of f once the others together are smaller.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.asymptotic_scale import (
    CONSTANT,
    WIDENING,
    Growth,
    Monomial,
    Remainder,
    UnknownGrowthError,
    widened,
)
from hjsolve.arithmetic.floats import Float64, Multi, by_squaring
from hjsolve.arithmetic.interval import Interval, Intervals
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import required

BITS = 1024
_TERMS = 6
_INTERVALS = Jets(Intervals(Float64()))


@dataclass(frozen=True)
class Growths:
    """Arithmetic on ``Growth`` for all s ≥ ``start``.

    Attributes:
        start: Q ≥ 3.
        bits: of the coefficients.
    """

    start: float
    bits: int = BITS

    @property
    def plain(self) -> Multi:
        return Multi(self.bits)

    def constant(self, value: Mpf) -> Growth:
        """Return a number that does not depend on s."""
        return Growth(((CONSTANT, value),)) if value else Growth(())

    def variable(self, sign: int) -> Growth:
        """Return ±s.

        Args:
            sign: +1 or −1.
        """
        return Growth(((Monomial(0.0, 1.0, 0.0), self.plain.context.mpf(sign)),))

    def rational(self, numerator: int, denominator: int) -> Growth:
        """Return a fraction: one term that does not grow."""
        return self.constant(self.plain.rational(numerator, denominator))

    def pi(self) -> Growth:
        return self.constant(self.plain.pi())

    def largest(self, m: Monomial) -> float:
        """Return the greatest value of a monomial that is not above 1 in growth, on s ≥ Q.

        Args:
            m: e^{λs} sᵏ (log s)ˡ; exponents (λ, k, l).

        Raises:
            UnknownGrowthError: the monomial grows, or does not fall from s = Q on.
        """
        q, l = self.start, math.log(self.start)
        if m == CONSTANT:
            return 1.0
        rate, power, logs = (float(part) for part in m)
        falling = power + max(logs, 0.0) / l if power else logs
        falling = rate + (max(power, 0.0) + max(logs, 0.0) / l) / q if rate else falling
        if m > CONSTANT or falling > 0:
            raise UnknownGrowthError
        return math.exp(min(rate * q + power * l + logs * math.log(l), 700.0)) * (1 + WIDENING) + 1e-300

    def range_of(self, f: Growth, over: Monomial) -> Remainder:
        """Return f as a remainder over a monomial that grows no slower.

        Args:
            f: a formula known for all s ≥ Q.
            over: the monomial.
        """
        low = high = 0.0
        for monomial, c in f.terms:
            bound, value = self.largest(monomial.times(over, -1.0)), float(c)
            same = monomial == over
            low = low + (value if same else min(value * bound, 0))
            high = high + (value if same else max(value * bound, 0))
        if f.rest is not None:
            bound, same = self.largest(f.rest.monomial.times(over, -1.0)), f.rest.monomial == over
            low += f.rest.low if same else min(f.rest.low * bound, 0.0)
            high += f.rest.high if same else max(f.rest.high * bound, 0.0)
        return widened(over, low, high)

    def _made(self, terms: Iterable[tuple[Monomial, Mpf]], rests: Iterable[Growth]) -> Growth:
        """Collect equal terms, drop those that cancelled, and put what is beyond the first few into the remainder."""
        total: dict[Monomial, tuple[Mpf, Mpf]] = {}
        for monomial, c in terms:
            before, size = total.get(monomial, (0 * c, 0 * c))
            total[monomial] = before + c, max(size, abs(c))
        tiny = self.plain.context.mpf(2) ** (-self.bits // 2)
        kept = ((m, c) for m, (c, size) in total.items() if abs(c) > tiny * size)
        left = sorted(kept, key=lambda term: term[0])[::-1]
        parts = [*rests, *([Growth(tuple(left[_TERMS:]))] if left[_TERMS:] else [])]
        heads = [p.rest.monomial for p in parts if p.rest] + [p.terms[0][0] for p in parts if p.terms]
        if not heads:
            return Growth(tuple(left))
        top = max(heads)
        ranges = [self.range_of(part, top) for part in parts]
        rest = widened(top, sum(r.low for r in ranges), sum(r.high for r in ranges))
        return Growth(tuple(left[:_TERMS]), rest)

    def add(self, x: Growth, y: Growth) -> Growth:
        """Return x + y; terms that cancel are dropped, the remainders are added."""
        return self._made([*x.terms, *y.terms], [Growth((), part.rest) for part in (x, y) if part.rest])

    def sub(self, x: Growth, y: Growth) -> Growth:
        """Return x − y, as a sum."""
        return self.add(x, self._times(y, -1))

    def _times(self, x: Growth, c: Mpf | int) -> Growth:
        terms = tuple((m, c * value) for m, value in x.terms)
        rest = x.rest and widened(x.rest.monomial, *sorted((float(c) * x.rest.low, float(c) * x.rest.high)))
        return Growth(terms, rest)

    def mul(self, x: Growth, y: Growth) -> Growth:
        """Return x·y, every term by every term; what meets a remainder becomes part of the remainder."""
        terms = [(m.times(n), a * b) for m, a in x.terms for n, b in y.terms]
        rests = []
        for one, other in ((x, y), (y, x)):
            if one.rest is not None and other.terms:
                whole = self.range_of(Growth(other.terms), other.terms[0][0])
                rests.append(Growth((), one.rest.times(whole)))
        if x.rest is not None and y.rest is not None:
            rests.append(Growth((), x.rest.times(y.rest)))
        return self._made(terms, rests)

    def div(self, x: Growth, y: Growth) -> Growth:
        """Return x/y, by the binomial series of 1/y about its leading term."""
        return self.mul(x, self.power(y, -1))

    def power(self, x: Growth, n: int) -> Growth:
        """Return xⁿ; for n < 0 by the binomial series about the leading term."""
        if n == 0:
            return self.rational(1, 1)
        if n > 0:
            result: Growth = by_squaring(self.mul, x, n)
            return result
        if not x.terms and x.rest is not None and x.rest.low * x.rest.high > 0:
            inverse = widened(CONSTANT.times(x.rest.monomial, -1.0), *sorted((1 / x.rest.low, 1 / x.rest.high)))
            return self.power(Growth((), inverse), -n)
        return self._binomial(x, -1.0) if n == -1 else self.power(self._binomial(x, -1.0), -n)

    def _split(self, x: Growth) -> tuple[Monomial, Mpf, Growth, float]:
        """Write f = c M (1 + ε): M, c, ε and a bound on |ε| that is below ½."""
        if not x.terms:
            raise UnknownGrowthError
        (monomial, c), others = x.terms[0], x.terms[1:]
        inverse = 1 / c
        rest = x.rest and widened(
            x.rest.monomial.times(monomial, -1.0), *sorted((float(inverse) * x.rest.low, float(inverse) * x.rest.high))
        )
        ε = Growth(tuple((m.times(monomial, -1.0), inverse * value) for m, value in others), rest)
        size = self.range_of(ε, CONSTANT).size
        if not size < 0.5:
            raise UnknownGrowthError
        return monomial, c, ε, size

    def _binomial(self, x: Growth, exponent: float) -> Growth:
        """f^exponent."""
        monomial, c, ε, size = self._split(x)
        if c < 0 and exponent != -1:
            raise UnknownGrowthError
        coefficients = [1.0]
        for j in range(_TERMS):
            coefficients.append(coefficients[-1] * (exponent - j) / (j + 1))
        tail = abs(coefficients[-1]) / (1 - size)  # the coefficients do not grow
        series = self._series(ε, coefficients[:-1], tail)
        leading = CONSTANT.times(monomial, exponent), c**exponent if exponent != -1 else 1 / c
        return self.mul(Growth((leading,)), series)

    def _series(self, ε: Growth, coefficients: Sequence[float | Mpf], tail: float) -> Growth:
        """Σ aⱼ εʲ + R, |R| ≤ tail·|ε|ⁿ."""
        convert = self.plain.convert
        result, power = self.constant(convert(coefficients[0])), self.rational(1, 1)
        for a in coefficients[1:]:
            power = self.mul(power, ε)
            result = self.add(result, self._times(power, convert(a)))
        if not ε.terms and ε.rest is None:
            return result
        n = len(coefficients)
        size = tail * self.range_of(ε, ε.fastest).size ** n
        rests = (result.rest, widened(CONSTANT.times(ε.fastest, n), -size, size))
        return self._made(result.terms, [Growth((), r) for r in rests if r])

    def unary(self, name: str, x: Growth) -> Growth:
        """Return a function of x: by its own rule, as of something that grows, or by Taylor's series."""
        if name == "neg":
            return self._times(x, -1)
        if name in _OWN:
            return _OWN[name](self, x)
        if self._grows(x):
            return self._of_growing(name, x)
        return self._smooth(name, x)

    def _grows(self, x: Growth) -> bool:
        if x.terms:
            return x.terms[0][0] > CONSTANT
        if x.rest is not None and x.rest.monomial > CONSTANT:
            raise UnknownGrowthError
        return False

    def _abs(self, x: Growth) -> Growth:
        _, c, _, _ = self._split(x)
        return x if c > 0 else self._times(x, -1)

    def _sqrt(self, x: Growth) -> Growth:
        return self._binomial(x, 0.5)

    def _log(self, x: Growth) -> Growth:
        monomial, c, ε, size = self._split(x)
        if c < 0 or monomial.logs:
            raise UnknownGrowthError
        context = self.plain.context
        parts = [(Monomial(0.0, 1.0, 0.0), +context.convert(monomial.rate)),
                 (Monomial(0.0, 0.0, 1.0), +context.convert(monomial.power)),
                 (CONSTANT, context.log(c))]  # fmt: skip
        coefficients: list[float | Mpf] = [0.0, *(self.plain.rational((-1) ** (j + 1), j) for j in range(1, _TERMS))]
        small = self._series(ε, coefficients, 1 / (1 - size))
        return self.add(Growth(tuple(p for p in parts if p[1])), small)

    def _exp(self, x: Growth) -> Growth:
        """e^{λs + k log s + c + ε}; of what falls faster, e^{−s²}, a bound."""
        linear, logarithm = Monomial(0.0, 1.0, 0.0), Monomial(0.0, 0.0, 1.0)
        if x.rest is not None and x.rest.monomial > CONSTANT:
            raise UnknownGrowthError
        if x.terms and x.terms[0][0] > linear:
            return self._falling(x)
        known = dict(x.terms)
        rate, power, c = (known.pop(m, self.plain.context.mpf(0)) for m in (linear, logarithm, CONSTANT))
        if any(m > CONSTANT for m in known):
            raise UnknownGrowthError
        ε = Growth(tuple(known.items()), x.rest)
        if ε.rest is not None and ε.rest.monomial == CONSTANT:
            whole = self.range_of(ε, CONSTANT)
            low, high = (math.exp(min(end, 700.0)) for end in (whole.low, whole.high))
            extra = Growth((), widened(CONSTANT, low, high))
        else:
            size = self.range_of(ε, CONSTANT).size
            if size > 1:
                raise UnknownGrowthError
            coefficients = [self.plain.rational(1, math.factorial(j)) for j in range(_TERMS)]
            extra = self._series(ε, coefficients, math.e / math.factorial(_TERMS))
        factor = Growth(((Monomial(rate, power, 0.0), self.plain.context.exp(c)),))
        return self.mul(factor, extra)

    def _falling(self, x: Growth) -> Growth:
        """Return e^f for f ≤ −μ s: f/s is largest at the start."""
        monomial, c, _, _ = self._split(x)
        if c > 0 or monomial.rate > 0:
            raise UnknownGrowthError
        above = monomial.times(Monomial(0.0, 1.0, 0.0), -1.0)
        least = 1 / self.largest(CONSTANT.times(above, -1.0))  # of M/s on s ≥ Q
        return Growth((), widened(Monomial(float(c) / 2 * least * (1 - WIDENING), 0.0, 0.0), 0.0, 1.0))

    def _tanh(self, x: Growth) -> Growth:
        """1 − 2/(1 + e^{2f})."""
        if not self._grows(x):
            return self._smooth("tanh", x)
        one = self.rational(1, 1)
        if x.terms[0][1] < 0:
            return self._times(self._tanh(self._times(x, -1)), -1)
        small = self._exp(self._times(x, -2))
        return self.div(self.sub(one, small), self.add(one, small))

    def _sech(self, x: Growth) -> Growth:
        return self.power(self._hyperbolic(x, 1), -1) if self._grows(x) else self._smooth("sech", x)

    def _hyperbolic(self, x: Growth, sign: int) -> Growth:
        up, down = self._exp(x), self._exp(self._times(x, -1))
        return self._times(self.add(up, self._times(down, sign)), self.plain.rational(1, 2))

    def _of_growing(self, name: str, x: Growth) -> Growth:
        """Return a function far out on the real line."""
        up = x.terms[0][1] > 0
        match name:
            case "sin" | "cos":
                return Growth((), Remainder(CONSTANT, -1.0, 1.0))
            case "atan":
                half = self._times(self.pi(), self.plain.rational(1 if up else -1, 2))
                return self.sub(half, self._smooth("atan", self.power(x, -1)))
            case "asinh" if not up:
                return self._times(self._of_growing("asinh", self._times(x, -1)), -1)
            case "asinh" | "acosh" if up:
                one = self.rational(1 if name == "asinh" else -1, 1)
                return self._log(self.add(x, self._sqrt(self.add(self.mul(x, x), one))))
        raise UnknownGrowthError

    def _smooth(self, name: str, x: Growth) -> Growth:
        """Φ(c + ε) = Φ(c) + Φ′(c) ε + ½Φ″ ε²."""
        context = self.plain.context
        c = dict(x.terms).get(CONSTANT, context.mpf(0))
        ε = Growth(tuple(term for term in x.terms if term[0] != CONSTANT), x.rest)
        whole = self.range_of(x, CONSTANT)
        if ε.rest is not None and ε.rest.monomial == CONSTANT:
            found = _INTERVALS.unary(name, _jet(whole.low, whole.high))
            return Growth((), widened(CONSTANT, float(found.value.low[0]), float(found.value.high[0])))
        at = Jets(self.plain).unary(name, Jet(c, context.mpf(1), context.mpf(0)))
        bend = required(_INTERVALS.unary(name, _jet(whole.low, whole.high)).second)
        most = max(abs(float(bend.low[0])), abs(float(bend.high[0]))) / 2
        if not most < math.inf:
            raise UnknownGrowthError
        return self.add(self.constant(at.value), self._linear(ε, required(at.first), most))

    def _linear(self, ε: Growth, slope: Mpf, most: float) -> Growth:
        first = self._times(ε, slope)
        if not ε.terms and ε.rest is None:
            return first
        size = most * self.range_of(ε, ε.fastest).size ** 2
        beyond = widened(CONSTANT.times(ε.fastest, 2), -size, size)
        return self._made(first.terms, [Growth((), r) for r in (first.rest, beyond) if r])

    def sign(self, x: Growth) -> int:
        """Return the sign that f has for all s ≥ Q.

        Raises:
            UnknownGrowthError: it could not be decided.
        """
        if x.rest is not None and (not x.terms or x.rest.monomial >= x.terms[0][0]):
            whole = self.range_of(x, x.rest.monomial)
            if whole.low * whole.high > 0:
                return 1 if whole.low > 0 else -1
        return 1 if self._split(x)[1] > 0 else -1


_OWN: dict[str, Callable[[Growths, Growth], Growth]] = {
    "abs": Growths._abs, "sqrt": Growths._sqrt, "log": Growths._log, "exp": Growths._exp, "tanh": Growths._tanh,
    "sech": Growths._sech,
    "sinh": lambda g, x: g._hyperbolic(x, -1) if g._grows(x) else g._smooth("sinh", x),
    "cosh": lambda g, x: g._hyperbolic(x, 1) if g._grows(x) else g._smooth("cosh", x),
}  # fmt: skip


def _jet(low: float, high: float) -> Jet[Interval]:
    one = Interval(np.ones(1), np.ones(1))
    return Jet(Interval(np.array([low]), np.array([high])), one, Interval(np.zeros(1), np.zeros(1)))
