"""Second-order slopes from a base point: small motions without cancellation.

A function is carried as its value and derivative at q₀ and its second divided difference t = f[q₀, q₀, q], q = q₀ + δ:

    f[q₀, q] = f′(q₀) + δ t,     f(q) = f(q₀) + δ f[q₀, q].

Only t is propagated: by Leibniz' rule for products and quotients, and for an elementary function Φ by
(Φ∘f)[q₀, q₀, q] = Φ[f₀, f₀, f]·f[q₀, q]² + Φ′(f₀) t, with Φ[f₀, f₀, f] from the addition theorems (Krawczyk & Neumaier,
SIAM J. Numer. Anal. 22 (1985) 604). However small δ is, t keeps its relative accuracy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple

from hjsolve.arithmetic.function_rules import QUOTIENTS, ByOthers, quotient
from hjsolve.arithmetic.number_types import N
from hjsolve.arithmetic.tape import Arithmetic

FUNCTIONS = frozenset({"neg", "sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "sech", "abs"})
"""Elementary functions that have a rule."""


class SecondDifference(NamedTuple, Generic[N]):
    """f(q₀), f′(q₀), f[q₀, q₀, q], f[q₀, q] and f(q); a constant has None but at the first."""

    base: N
    first: Any = None
    second: Any = None
    slope: Any = None
    value: Any = None


@dataclass(frozen=True, slots=True)
class SecondDifferences(ByOthers, Generic[N]):
    """Arithmetic on ``SecondDifference`` values.

    Attributes:
        plain: arithmetic of the parts.
        offset: δ in it; base parts must broadcast against it.
        elementary: (name, x, d) ↦ Φ(x), Φ′(x) and Φ[x, x, x + d] of exp, log, sin, cos, sinh, cosh.
        sign: (x, y) ↦ the sign of x, NaN where that of y is another.
    """

    plain: Arithmetic[N]
    offset: N
    elementary: Callable[[str, N, N], tuple[N, N, N]]
    sign: Callable[[N, N], N]

    def variable(self, place: N) -> SecondDifference[N]:
        """Return the slope of q itself, q₀ = ``place``.

        Args:
            place: q₀.
        """
        return self._made(place, self.plain.rational(1, 1), self.plain.rational(0, 1))

    def _made(self, base: N, first: N, second: N) -> SecondDifference[N]:
        a = self.plain
        slope = a.add(first, a.mul(self.offset, second))
        return SecondDifference(base, first, second, slope, a.add(base, a.mul(self.offset, slope)))

    def rational(self, numerator: int, denominator: int) -> SecondDifference[N]:
        """Return a constant: it has no differences."""
        return SecondDifference(self.plain.rational(numerator, denominator))

    def pi(self) -> SecondDifference[N]:
        return SecondDifference(self.plain.pi())

    def add(self, x: SecondDifference[N], y: SecondDifference[N]) -> SecondDifference[N]:
        """Return x + y; differences are added."""
        a = self.plain
        base = a.add(x.base, y.base)
        if x.first is None or y.first is None:
            other = y if x.first is None else x
            return SecondDifference(base) if other.first is None else self._made(base, other.first, other.second)
        return self._made(base, a.add(x.first, y.first), a.add(x.second, y.second))

    def mul(self, x: SecondDifference[N], y: SecondDifference[N]) -> SecondDifference[N]:
        """Return x·y, by (xy)[q₀, q₀, q] = x₀ y[q₀, q₀, q] + x′₀ y[q₀, q] + x[q₀, q₀, q] y."""
        a = self.plain
        base = a.mul(x.base, y.base)
        if x.first is None or y.first is None:
            constant, other = (x, y) if x.first is None else (y, x)
            if other.first is None:
                return SecondDifference(base)
            return self._made(base, a.mul(constant.base, other.first), a.mul(constant.base, other.second))
        second = a.add(a.add(a.mul(x.base, y.second), a.mul(x.first, y.slope)), a.mul(x.second, y.value))
        return self._made(base, a.add(a.mul(x.first, y.base), a.mul(x.base, y.first)), second)

    def div(self, x: SecondDifference[N], y: SecondDifference[N]) -> SecondDifference[N]:
        """Solve x = h y for h = x/y: x[q₀,q₀,q] = h₀ y[q₀,q₀,q] + h′₀ y[q₀,q] + h[q₀,q₀,q] y."""
        a = self.plain
        if y.first is None:
            return self.mul(x, SecondDifference(a.div(a.rational(1, 1), y.base)))
        zero = a.rational(0, 1)
        base = a.div(x.base, y.base)
        first = a.div(a.sub(zero if x.first is None else x.first, a.mul(base, y.first)), y.base)
        rest = a.sub(zero if x.second is None else x.second, a.mul(base, y.second))
        return self._made(base, first, a.div(a.sub(rest, a.mul(first, y.slope)), y.value))

    def unary(self, name: str, x: SecondDifference[N]) -> SecondDifference[N]:
        """Return Φ(x), by the addition theorem of Φ."""
        a = self.plain
        if x.first is None:
            return SecondDifference(a.unary(name, x.base))
        if name == "neg":
            return SecondDifference(*(a.unary("neg", part) for part in x))
        if name in QUOTIENTS:
            return quotient(self, name, x)
        if name == "abs":
            return self.mul(x, SecondDifference(self.sign(x.base, x.value)))
        if name == "sqrt":
            base, here = a.unary("sqrt", x.base), a.unary("sqrt", x.value)
            total = a.add(base, here)
            first = a.div(x.first, a.mul(a.rational(2, 1), base))
            second = a.div(a.sub(x.second, a.div(a.mul(first, x.slope), total)), total)
            return self._made(base, first, second)
        base, derivative, bend = self.elementary(name, x.base, a.mul(self.offset, x.slope))
        second = a.add(a.mul(bend, a.mul(x.slope, x.slope)), a.mul(derivative, x.second))
        return self._made(base, a.mul(derivative, x.first), second)
