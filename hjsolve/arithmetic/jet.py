"""Value, first and second derivative together, in any arithmetic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, NamedTuple

from hjsolve.arithmetic.function_rules import ByOthers, bend, slope
from hjsolve.arithmetic.number_types import N
from hjsolve.arithmetic.tape import Arithmetic


class Jet(NamedTuple, Generic[N]):
    """f, f′, f″ at one place (or over one cell); a derivative that is exactly zero is None."""

    value: N
    first: N | None = None
    second: N | None = None


class Derivatives(NamedTuple, Generic[N]):
    """f, f′, f″ with nothing left out."""

    value: N
    first: N
    second: N


@dataclass(frozen=True, slots=True)
class Jets(ByOthers, Generic[N]):
    """Differentiation by the chain rule over a plain arithmetic or over intervals.

    Attributes:
        plain: the arithmetic of each component.
    """

    plain: Arithmetic[N]

    def variable(self, x: N) -> Jet[N]:
        """Return the jet of q itself."""
        return Jet(x, self.plain.rational(1, 1))

    def rational(self, numerator: int, denominator: int) -> Jet[N]:
        """Return a constant: both derivatives are zero."""
        return Jet(self.plain.rational(numerator, denominator))

    def pi(self) -> Jet[N]:
        return Jet(self.plain.pi())

    def _plus(self, x: N | None, y: N | None) -> N | None:
        return y if x is None else x if y is None else self.plain.add(x, y)

    def _times(self, x: N | None, y: N | None) -> N | None:
        return None if x is None or y is None else self.plain.mul(x, y)

    def _minus(self, x: N | None) -> N | None:
        return None if x is None else self.plain.unary("neg", x)

    def _double(self, x: N | None) -> N | None:
        return None if x is None else self.plain.mul(self.plain.rational(2, 1), x)

    def add(self, x: Jet[N], y: Jet[N]) -> Jet[N]:
        """Return x + y with its derivatives."""
        return Jet(self.plain.add(x.value, y.value), self._plus(x.first, y.first), self._plus(x.second, y.second))

    def mul(self, x: Jet[N], y: Jet[N]) -> Jet[N]:
        """Return x·y, by (xy)″ = x″y + 2x′y′ + xy″."""
        first = self._plus(self._times(x.first, y.value), self._times(x.value, y.first))
        cross = self._double(self._times(x.first, y.first))
        second = self._plus(self._plus(self._times(x.second, y.value), cross), self._times(x.value, y.second))
        return Jet(self.plain.mul(x.value, y.value), first, second)

    def div(self, x: Jet[N], y: Jet[N]) -> Jet[N]:
        """Return x/y, as x·y⁻¹."""
        return self.mul(x, self.power(y, -1))

    def power(self, x: Jet[N], n: int) -> Jet[N]:
        """Return xⁿ, by the chain rule with n xⁿ⁻¹ and n(n − 1) xⁿ⁻²."""
        a = self.plain
        if x.first is None:
            return Jet(a.power(x.value, n))
        if n < 0:
            inverse = a.power(x.value, -1)
            value = inverse if n == -1 else a.power(inverse, -n)
            slope = a.mul(a.rational(n, 1), a.mul(value, inverse))
            return self._chain(x, value, slope, a.mul(a.rational(n - 1, 1), a.mul(slope, inverse)))
        slope = a.mul(a.rational(n, 1), a.power(x.value, n - 1)) if n != 1 else a.rational(1, 1)
        bend = (
            a.mul(a.rational(n * (n - 1), 1), a.power(x.value, n - 2))
            if n not in {1, 2}
            else a.rational(n * (n - 1), 1)
        )
        return self._chain(x, a.power(x.value, n), slope, bend)

    def _chain(self, x: Jet[N], value: N, slope: N, bend: N) -> Jet[N]:
        """Φ(f) with Φ′ = slope and Φ″ = bend at f."""
        if x.first is None:
            return Jet(value)
        second = self._plus(self._times(bend, self.plain.power(x.first, 2)), self._times(slope, x.second))
        return Jet(value, self._times(slope, x.first), second)

    def unary(self, name: str, x: Jet[N]) -> Jet[N]:
        """Return Φ(x), by the chain rule."""
        if name == "neg":
            return Jet(self.plain.unary("neg", x.value), self._minus(x.first), self._minus(x.second))
        value = self.plain.unary(name, x.value)
        if x.first is None:
            return Jet(value)
        first = slope(self.plain, name, x.value, value)
        return self._chain(x, value, first, bend(self.plain, name, x.value, value, first))
