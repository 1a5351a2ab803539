"""Divided differences without cancellation: the rules, and slopes of first and second order from a base point.

f[e, q] = (f(q) − f(e))/(q − e), f[a, b, q] = (f[b, q] − f[a, b])/(q − a), …, carried through a formula by Leibniz' rule
for products and quotients and by

    (Φ∘f)[b, q] = Φ[f(b), f(q)] f[b, q],
    (Φ∘f)[a, b, q] = Φ[f(b), f(q)] f[a, b, q] + Φ[f(a), f(b), f(q)] f[a, b] f[a, q]

(Krawczyk & Neumaier, SIAM J. Numer. Anal. 22 (1985) 604). Nodes may coincide: f[e, e] = f′(e). ``FirstDifferences`` and
``SecondDifferences`` are arithmetics on them, over any other; over disks, where poles are taken out or both nodes are
turning points, ``local_expansion`` and ``one_coordinate.difference_rules`` take the same rules from here.

Next to a zero e, F(q) = (q − e) F[e, q] keeps its relative accuracy. Small motions are seen from a start q₀, where a
function is its value and derivative at q₀ and t = f[q₀, q₀, q], q = q₀ + δ:

    f[q₀, q] = f′(q₀) + δ t,     f(q) = f(q₀) + δ f[q₀, q].

Only t is propagated: however small δ is, it keeps its relative accuracy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any, Generic, NamedTuple, Protocol

from hjsolve.arithmetic.function_rules import QUOTIENTS, ByOthers, quotient
from hjsolve.arithmetic.number_types import N
from hjsolve.arithmetic.tape import Arithmetic

WITH_FIRST = frozenset({"neg", "sqrt", "exp", "sin", "cos", "tan", "sinh", "cosh", "tanh", "sech"})
"""Elementary functions that have a rule for first differences."""
WITH_SECOND = WITH_FIRST | {"log", "abs"}
"""Elementary functions that have a rule for second differences on q₀, q₀, q."""
_TINY = (1, 10**290)
"""Keeps sinh h/h from 0/0; no other h is moved by it: doubles below 10⁻²⁷⁴ are no steps of a motion."""


# ----------------------------------------------------------------------------------------------------- the rules
class Ring(Protocol[N]):
    """What Leibniz' rule asks of an arithmetic."""

    @property
    def add(self) -> Callable[[N, N], N]:
        """Return x + y."""

    @property
    def sub(self) -> Callable[[N, N], N]:
        """Return x − y."""

    @property
    def mul(self) -> Callable[[N, N], N]:
        """Return x·y."""


def of_product(a: Ring[N], heads: Sequence[N], x: Sequence[N], y: Sequence[N]) -> N:
    """Return (xy)[x₀, …, q] = Σₗ x[x₀, …, xₗ] y[xₗ, …, q], Leibniz' rule.

    Args:
        a: the arithmetic of the parts.
        heads: x(x₀), x[x₀, x₁], … on all nodes but q; as many as the order.
        x, y: at least x(q), …, x[x₀, …, q], in the order of their lengths.
    """
    n = len(heads)
    return reduce(a.add, [*(a.mul(y[n - l], head) for l, head in enumerate(heads)), a.mul(y[0], x[n])])


def of_quotient(a: Arithmetic[N], heads: Sequence[N], x: N | None, y: Sequence[N]) -> N:
    """Return h[x₀, …, q] of h = x/y: Leibniz' rule for x = h y, solved for it.

    Args:
        a: the arithmetic of the parts.
        heads: h(x₀), h[x₀, x₁], … on all nodes but q; as many as the order, one or more.
        x: x[x₀, …, q]; None where x is constant.
        y: y(q), …, y[x₀, …, q].
    """
    for l, head in enumerate(heads):
        known = a.mul(head, y[len(heads) - l])
        x = a.unary("neg", known) if x is None else a.sub(x, known)
    return a.div(x, y[0])  # type: ignore[arg-type]  # there is a head


def of_reciprocal(a: Ring[N], inverses: Sequence[N], ends: Sequence[N], f: Sequence[N]) -> N:
    """Return (1/f)[a, b, q] = (f[a, b] f[a, q] − f(a) f[a, b, q])/(f(a) f(b) f(q)).

    Over disks it is narrower than the quotient rule: each 1/f stands there once.

    Args:
        a: the arithmetic of the parts.
        inverses: 1/f(a), 1/f(b) and 1/f(q).
        ends: f(a) and f[a, b].
        f: f[a, q] and f[a, b, q].
    """
    inner = a.sub(a.mul(ends[1], f[0]), a.mul(ends[0], f[1]))
    return a.mul(reduce(a.mul, inverses), inner)


def of_composition(a: Ring[N], chord: N, bend: N, head: N, f: Sequence[N]) -> N:
    """Return (Φ∘f)[a, b, q].

    Args:
        a: the arithmetic of the parts.
        chord, bend: Φ[f(b), f(q)] and Φ[f(a), f(b), f(q)].
        head: f[a, b].
        f: f[a, q] and f[a, b, q].
    """
    return a.add(a.mul(chord, f[1]), a.mul(a.mul(head, f[0]), bend))


# --------------------------------------------------------------------------------------------------- first order
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
        if x.slope is None or y.slope is None:
            left = None if x.slope is None else a.mul(x.slope, y.value)
            slope = left if y.slope is None else a.mul(x.base, y.slope)
        else:
            # the nodes may stand in any order: q, e
            slope = of_product(a, (y.value,), (y.base, y.slope), (x.base, x.slope))
        return self._made(slope, lambda part: a.mul(part(x), part(y)))

    def div(self, x: FirstDifference[N], y: FirstDifference[N]) -> FirstDifference[N]:
        """Return h = x/y, by x = h y and Leibniz' rule: h[e, q] = (x[e, q] − h(e) y[e, q])/y(q)."""
        a = self.plain
        if y.slope is None:
            slope = None if x.slope is None else a.div(x.slope, y.value)
            return self._made(slope, lambda part: a.div(part(x), part(y)))
        base, value = a.div(x.base, y.base), a.div(x.value, y.value)
        return FirstDifference(base, value, of_quotient(a, (base,), x.slope, (y.value, y.slope)))

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


# -------------------------------------------------------------------------------------------------- second order
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
        second = of_product(a, (x.base, x.first), (x.value, x.slope, x.second), (y.value, y.slope, y.second))
        return self._made(base, a.add(a.mul(x.first, y.base), a.mul(x.base, y.first)), second)

    def div(self, x: SecondDifference[N], y: SecondDifference[N]) -> SecondDifference[N]:
        """Solve x = h y for h = x/y: x[q₀,q₀,q] = h₀ y[q₀,q₀,q] + h′₀ y[q₀,q] + h[q₀,q₀,q] y."""
        a = self.plain
        if y.first is None:
            return self.mul(x, SecondDifference(a.div(a.rational(1, 1), y.base)))
        base = a.div(x.base, y.base)
        first = of_quotient(a, (base,), x.first, (y.base, y.first))
        return self._made(base, first, of_quotient(a, (base, first), x.second, (y.value, y.slope, y.second)))

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
