"""First-order slopes from a base point, f[e, q] = (f(q) − f(e))/(q − e), without cancellation, over any arithmetic.

Sums and products by Leibniz' rule; an elementary function by Φ[f₀, f], which for exp, sin, … follows from the addition
theorems with the half difference h = (f − f₀)/2 and the middle m: sinh[f₀, f] = cosh m · sinh h/h, and so on (Krawczyk
& Neumaier, SIAM J. Numer. Anal. 22 (1985) 604). Next to a zero e, F(q) = (q − e) F[e, q] keeps its relative accuracy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple

from hjsolve.arithmetic.function_rules import QUOTIENTS, ByOthers, quotient
from hjsolve.arithmetic.number_types import N
from hjsolve.arithmetic.tape import Arithmetic

FUNCTIONS = frozenset({"neg", "sqrt", "exp", "sin", "cos", "tan", "sinh", "cosh", "tanh", "sech"})
"""Elementary functions that have a rule."""

_TINY = (1, 10**290)
"""Keeps sinh h/h from 0/0; no other h is moved by it."""


class FirstDifference(NamedTuple, Generic[N]):
    """f(e), f(q), and f[e, q]; a constant has no slope."""

    base: N
    value: N
    slope: Any = None


@dataclass(frozen=True, slots=True)
class FirstDifferences(ByOthers, Generic[N]):
    """Arithmetic on ``FirstDifference`` values.

    Attributes:
        plain: arithmetic of the parts.
        offset: q − e in it.
    """

    plain: Arithmetic[N]
    offset: N

    def constant(self, value: N) -> FirstDifference[N]:
        """Return a number that does not depend on q."""
        return FirstDifference(value, value)

    def variable(self, base: N, value: N) -> FirstDifference[N]:
        """Return q itself, from e to q.

        Args:
            base: e, or f(e).
            value: q.
        """
        return FirstDifference(base, value, self.plain.rational(1, 1))

    def rational(self, numerator: int, denominator: int) -> FirstDifference[N]:
        """Return a constant: it has no slope."""
        return self.constant(self.plain.rational(numerator, denominator))

    def pi(self) -> FirstDifference[N]:
        return self.constant(self.plain.pi())

    def add(self, x: FirstDifference[N], y: FirstDifference[N]) -> FirstDifference[N]:
        """Return x + y; slopes are added."""
        a = self.plain
        slope = y.slope if x.slope is None else x.slope if y.slope is None else a.add(x.slope, y.slope)
        return self._made(slope, lambda part: a.add(part(x), part(y)))

    def mul(self, x: FirstDifference[N], y: FirstDifference[N]) -> FirstDifference[N]:
        """Return x·y, by Leibniz' rule (xy)[e, q] = x[e, q] y(q) + x(e) y[e, q]."""
        a = self.plain
        left = None if x.slope is None else a.mul(x.slope, y.value)
        right = None if y.slope is None else a.mul(x.base, y.slope)
        slope = right if left is None else left if right is None else a.add(left, right)
        return self._made(slope, lambda part: a.mul(part(x), part(y)))

    def div(self, x: FirstDifference[N], y: FirstDifference[N]) -> FirstDifference[N]:
        """Return h = x/y, by x = h y and Leibniz' rule: h[e, q] = (x[e, q] − h(e) y[e, q])/y(q)."""
        a = self.plain
        if y.slope is None:
            slope = None if x.slope is None else a.div(x.slope, y.value)
            return self._made(slope, lambda part: a.div(part(x), part(y)))
        base = a.div(x.base, y.base)
        rest = a.unary("neg", a.mul(base, y.slope))
        rest = rest if x.slope is None else a.add(x.slope, rest)
        return FirstDifference(base, a.div(x.value, y.value), a.div(rest, y.value))

    def unary(self, name: str, x: FirstDifference[N]) -> FirstDifference[N]:
        """Return Φ(x), its slope by Φ[x(e), x(q)] x[e, q]."""
        a = self.plain
        if x.slope is None:
            return self.constant(a.unary(name, x.value))
        if name in QUOTIENTS:
            return quotient(self, name, x)
        base, value = a.unary(name, x.base), a.unary(name, x.value)
        return FirstDifference(base, value, a.mul(self._between(name, x, base, value), x.slope))

    def _between(self, name: str, x: FirstDifference[N], base: N, value: N) -> N:
        """Φ[f₀, f]."""
        a = self.plain
        if name == "neg":
            return a.rational(-1, 1)
        if name == "sqrt":
            return a.div(a.rational(1, 1), a.add(base, value))
        half = a.rational(1, 2)
        h = a.add(a.mul(half, a.mul(self.offset, x.slope)), a.rational(*_TINY))
        middle = a.mul(half, a.add(x.base, x.value))
        match name:
            case "sin" | "cos":
                rise = a.unary("cos" if name == "sin" else "sin", middle)
                rise = rise if name == "sin" else a.unary("neg", rise)
                return a.mul(rise, a.div(a.unary("sin", h), h))
            case "exp":  # e^(m + |h|) (1 − e^(−2|h|))/(2|h|): e^m sinh h is 0·∞ where the two are far apart
                size = a.unary("abs", h)
                turn = a.unary("tanh", size)
                top = a.unary("exp", a.add(middle, size))
                return a.mul(top, a.div(turn, a.mul(size, a.add(a.rational(1, 1), turn))))
            case "sinh" | "cosh":
                rise = a.unary({"sinh": "cosh", "cosh": "sinh"}[name], middle)
                return a.mul(rise, a.div(a.unary("sinh", h), h))
            case _:
                raise NotImplementedError(name)

    def _made(self, slope: N | None, combined: Callable[[Callable[[FirstDifference[N]], N]], N]) -> FirstDifference[N]:
        value = combined(lambda x: x.value)
        return (
            FirstDifference(value, value)
            if slope is None
            else FirstDifference(combined(lambda x: x.base), value, slope)
        )
