"""Values with a bound on their rounding error, carried along: Wilkinson's running error analysis.

Every number is (value, bound on |computed − true|). Each operation passes the bounds of its operands on by the first
order rule and adds its own rounding (Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., §3.3). Terms of
second order are left out; callers multiply by ``SECOND_ORDER``. The plain arithmetic underneath may be arrays of
doubles or one that writes source code.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, NamedTuple

from hjsolve.arithmetic.function_rules import slope
from hjsolve.arithmetic.number_types import N
from hjsolve.arithmetic.tape import Arithmetic

SECOND_ORDER = 2.0
"""By which a bound carried to first order is multiplied when a number is given: terms of second order are within it."""


class WithErrorBound(NamedTuple, Generic[N]):
    """A value and a bound on its error; None for an exact value."""

    value: N
    error: N | None = None


@dataclass(frozen=True, slots=True)
class RunningError(Generic[N]):
    """Arithmetic on ``WithErrorBound`` values over a plain one.

    Attributes:
        plain: arithmetic of values and bounds.
        own: units of rounding of an elementary function.
        bits: binary digits of the values bounded; those of the plain arithmetic may be fewer.
    """

    plain: Arithmetic[N]
    own: int = 2
    bits: int = 53

    def _scaled(self, value: N, units: int = 1) -> N:
        a = self.plain
        return a.mul(a.rational(units, 2**self.bits), a.unary("abs", value))

    def _sum(self, *parts: N | None) -> N | None:
        total: N | None = None
        for part in parts:
            if part is not None:
                total = part if total is None else self.plain.add(total, part)
        return total

    def _part(self, factor: N, error: N | None) -> N | None:
        """|factor|·error."""
        return None if error is None else self.plain.mul(self.plain.unary("abs", factor), error)

    def rational(self, numerator: int, denominator: int) -> WithErrorBound[N]:
        """Return a fraction with the error of its rounding; None where it is exact."""
        value = self.plain.rational(numerator, denominator)
        power_of_two = denominator & (denominator - 1) == 0 and abs(numerator) < 2**53
        return WithErrorBound(value, None if power_of_two else self._scaled(value))

    def pi(self) -> WithErrorBound[N]:
        return WithErrorBound(self.plain.pi(), self._scaled(self.plain.pi()))

    def add(self, x: WithErrorBound[N], y: WithErrorBound[N]) -> WithErrorBound[N]:
        """Return x + y; its bound is δx + δy and the rounding of the sum."""
        value = self.plain.add(x.value, y.value)
        return WithErrorBound(value, self._sum(x.error, y.error, self._scaled(value)))

    def sub(self, x: WithErrorBound[N], y: WithErrorBound[N]) -> WithErrorBound[N]:
        """Return x − y; its bound is δx + δy and the rounding of the difference."""
        value = self.plain.sub(x.value, y.value)
        return WithErrorBound(value, self._sum(x.error, y.error, self._scaled(value)))

    def mul(self, x: WithErrorBound[N], y: WithErrorBound[N]) -> WithErrorBound[N]:
        """Return x·y; its bound is |y| δx + |x| δy and the rounding of the product."""
        value = self.plain.mul(x.value, y.value)
        passed = self._part(y.value, x.error), self._part(x.value, y.error)
        own = self._scaled(value, self._units_of_product(x.value, y.value))
        return WithErrorBound(value, self._sum(*passed, own))

    def div(self, x: WithErrorBound[N], y: WithErrorBound[N]) -> WithErrorBound[N]:
        """Return x/y; its bound is (δx + |x/y| δy)/|y| and the rounding of the quotient."""
        value = self.plain.div(x.value, y.value)
        passed = self._sum(x.error, self._part(value, y.error))
        if passed is not None:
            passed = self.plain.div(passed, self.plain.unary("abs", y.value))
        return WithErrorBound(value, self._sum(passed, self._scaled(value, self._units_of_quotient(y.value))))

    def power(self, x: WithErrorBound[N], n: int) -> WithErrorBound[N]:
        """Return xⁿ; its bound is |n xⁿ⁻¹| δx and |n| roundings of the power."""
        a = self.plain
        value = a.power(x.value, n)
        slope = a.mul(a.rational(n, 1), a.power(x.value, n - 1)) if n != 1 else a.rational(1, 1)
        passed, own = self._part(slope, x.error), self._scaled(value, self._units_of_power(x.value, n))
        return WithErrorBound(value, self._sum(passed, own))

    def _units_of_product(self, x: N, y: N) -> int:  # noqa: ARG002  (complex products have more)
        return 1

    def _units_of_quotient(self, y: N) -> int:  # noqa: ARG002
        return 1

    def _units_of_power(self, x: N, n: int) -> int:  # noqa: ARG002
        return abs(n)

    def unary(self, name: str, x: WithErrorBound[N]) -> WithErrorBound[N]:
        """Return Φ(x); its bound is |Φ′(x)| δx and ``own`` roundings of the value."""
        value = self.plain.unary(name, x.value)
        if name == "neg" or name == "abs":
            return WithErrorBound(value, x.error)
        if name == "sqrt":
            passed = None if x.error is None else self.plain.div(x.error, value)
            return WithErrorBound(value, self._sum(passed, self._scaled(value)))
        passed = None if x.error is None else self._part(self._slope(name, x.value, value), x.error)
        return WithErrorBound(value, self._sum(passed, self._scaled(value, self.own)))

    def _slope(self, name: str, x: N, f: N) -> N:
        """Return a bound on the derivative at x, where the function is f."""
        a = self.plain
        one = a.rational(1, 1)
        match name:
            case "exp" | "cosh":
                return f
            case "sin" | "cos" | "tanh" | "sech" | "asinh" | "atan":
                return one
            case "sinh":
                return a.add(one, a.unary("abs", f))
            case _:
                return slope(a, name, x, f)
