"""Truncated power series in any number of digits: the Taylor coefficients of a formula at a place, from its tape.

Coefficients of products and quotients are those of Cauchy's rule; those of elementary functions follow from their
differential equations, such as y = e^x: k y_k = Σ_{j ≤ k} j x_j y_{k−j} (Griewank and Walther, ch. 13).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.function_rules import QUOTIENTS, ByOthers, quotient
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import NotConvergedError

Series = list[Mpf]
"""Coefficients of s⁰ … s^order."""


@dataclass(frozen=True)
class PowerSeriesArithmetic(ByOthers):
    """Arithmetic of series up to an order.

    Attributes:
        plain: the arithmetic of the coefficients.
        order: highest power kept.
    """

    plain: Multi
    order: int

    def variable(self, x: Mpf) -> Series:
        """Return the series of the variable itself at a place."""
        return [x, self.plain.rational(1, 1), *self._zeros(self.order - 1)][: self.order + 1]

    def rational(self, numerator: int, denominator: int) -> Series:
        """Return a constant.

        Args:
            numerator, denominator: whole numbers, the second not zero.
        """
        return [self.plain.rational(numerator, denominator), *self._zeros(self.order)]

    def pi(self) -> Series:
        """Return π."""
        return [self.plain.pi(), *self._zeros(self.order)]

    def add(self, x: Series, y: Series) -> Series:
        """Return x + y."""
        return [a + b for a, b in zip(x, y, strict=True)]

    def mul(self, x: Series, y: Series) -> Series:
        """Return x y."""
        return [self._dot(x[: k + 1], y[k::-1]) for k in range(self.order + 1)]

    def div(self, x: Series, y: Series) -> Series:
        """Return x/y."""
        found: Series = []
        for k in range(self.order + 1):
            found.append((x[k] - self._dot(found, y[k:0:-1])) / y[0])
        return found

    def unary(self, name: str, x: Series) -> Series:
        """Return f(x).

        Raises:
            NotConvergedError: no rule is known for the function.
        """
        if name == "neg":
            return [-a for a in x]
        if name in QUOTIENTS:
            return quotient(self, name, x)
        rule = _RULES.get(name)
        if rule is None:
            raise NotConvergedError(f"{name}(t) has no power series here; write it by exp, log, sqrt, sin and cos")
        return rule(self, x)

    def _zeros(self, count: int) -> Series:
        return [self.plain.rational(0, 1)] * max(count, 0)

    def _dot(self, x: Series, y: Series) -> Mpf:
        total = self.plain.rational(0, 1)
        for a, b in zip(x, y, strict=True):
            total += a * b
        return total

    def weighted(self, x: Series, y: Series, k: int) -> Mpf:
        """Return Σ_{1 ≤ j ≤ k} j x_j y_{k−j}/k.

        Args:
            x, y: series, y known below k.
            k: from 1 on.
        """
        return self._dot([j * x[j] for j in range(1, k + 1)], [y[k - j] for j in range(1, k + 1)]) / k


def _exp(s: PowerSeriesArithmetic, x: Series) -> Series:
    y = [s.plain.unary("exp", x[0])]
    for k in range(1, s.order + 1):
        y.append(s.weighted(x, y, k))
    return y


def _pair(s: PowerSeriesArithmetic, x: Series, names: tuple[str, str], sign: int) -> tuple[Series, Series]:
    """Sin and cos (sign −1) or sinh and cosh (sign 1)."""
    first, second = ([s.plain.unary(name, x[0])] for name in names)
    for k in range(1, s.order + 1):
        one, other = s.weighted(x, second, k), sign * s.weighted(x, first, k)
        first.append(one)
        second.append(other)
    return first, second


def _circular(which: int) -> Callable[[PowerSeriesArithmetic, Series], Series]:
    return lambda s, x: _pair(s, x, ("sin", "cos"), -1)[which]


def _hyperbolic(which: int) -> Callable[[PowerSeriesArithmetic, Series], Series]:
    return lambda s, x: _pair(s, x, ("sinh", "cosh"), 1)[which]


def _log(s: PowerSeriesArithmetic, x: Series) -> Series:
    y = [s.plain.unary("log", x[0])]
    for k in range(1, s.order + 1):
        rest = s.plain.rational(0, 1)
        for j in range(1, k):
            rest += j * y[j] * x[k - j]
        y.append((x[k] - rest / k) / x[0])
    return y


def _sqrt(s: PowerSeriesArithmetic, x: Series) -> Series:
    y = [s.plain.unary("sqrt", x[0])]
    for k in range(1, s.order + 1):
        rest = s.plain.rational(0, 1)
        for j in range(1, k):
            rest += y[j] * y[k - j]
        y.append((x[k] - rest) / (2 * y[0]))
    return y


_RULES: dict[str, Callable[[PowerSeriesArithmetic, Series], Series]] = {
    "exp": _exp, "sin": _circular(0), "cos": _circular(1), "sinh": _hyperbolic(0), "cosh": _hyperbolic(1),
    "log": _log, "sqrt": _sqrt,
}  # fmt: skip
