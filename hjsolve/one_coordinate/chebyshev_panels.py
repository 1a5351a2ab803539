"""Motions that do not come back: escape, collision with an end of the domain, creeping to a separatrix.

One analytic parameter y runs from the start of a branch (a turning point, or any regular place) to
its end; the map q(y) is chosen by the two ends so that dq/p is analytic in y up to and including both:

    start → end            distance x from the start       what it cures
    turning → infinity     x = L y²                        the inverse square root at the start
    turning → boundary     x = ℓ sin²(y/2), y ≤ π          the same, and an integer power of p² at the end
    turning → asymptote    x = ℓ tanh² y                   the same, and the double zero: t grows like y
    regular → infinity     x = L y
    turning → kink         x = ℓ y², y ≤ 1                 at a kink p² goes on with another formula
    regular → kink         x = ℓ y, y ≤ 1
    regular → boundary     x = ℓ (1 − (1 − y)²), y ≤ 1
    regular → asymptote    x = ℓ (1 − e^{−y})
    … → fall               as to an asymptote: reached in a finite time, but an angle winds for ever on the way

The integrals are Chebyshev series on panels, each as long as its integrands are proved to be analytic around it
(``one_coordinate.panel_length``); far out panels grow geometrically, so the cost rises with the logarithm of the time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from hjsolve.arithmetic.chebyshev import clenshaw, in_panel
from hjsolve.arithmetic.floats import Float64, Multi, multiprecision
from hjsolve.arithmetic.number_types import Context, Mpf, Numbers, Numeric, Reals
from hjsolve.one_coordinate.turning_points import EndKind


@dataclass(frozen=True)
class EndMap:
    """The map q(y) of one branch.

    In its methods y ≥ 0 is the place on the branch, in an arithmetic.

    Attributes:
        turning: True where the branch starts at a turning point.
        end: ``infinity``, ``boundary``, ``fall``, ``asymptote`` or ``kink``.
        start: q at y = 0.
        side: +1 where q grows with y.
        length: ℓ, the distance to the end; for infinity the length L that makes y a number of order one.
        pole: order of the pole of p² at a boundary; 0 where p² has none.
    """

    turning: bool
    end: EndKind
    start: Mpf
    side: int
    length: Mpf
    pole: int = 0

    def last(self, context: Context) -> Mpf | None:
        """Return the greatest y, None where there is none."""
        if self.end == "kink":
            return context.mpf(1)
        if self.end != "boundary":
            return None
        return +context.pi if self.turning else context.mpf(1)

    def in_doubles(self) -> EndMap:
        """Return the same with its constants rounded to doubles."""
        return replace(self, start=float(self.start), length=float(self.length))  # type: ignore[arg-type]

    def parameter(self, q: Mpf) -> Mpf | None:
        """Return y of a place; None where the branch does not pass it."""
        x, context = self.side * (q - self.start) / self.length, q.context
        if x < 0 or (self.end == "kink" and x > 1) or (self.end not in {"infinity", "kink"} and x >= 1):
            return None
        if self.end in {"infinity", "kink"}:
            return context.sqrt(x) if self.turning else x
        if self.end == "boundary":
            # x/ℓ = sin²(y/2), or 1 − (1 − y)²: square roots at the end, and at a turning point, become analytic
            return 2 * context.asin(context.sqrt(x)) if self.turning else 1 - context.sqrt(1 - x)
        # x/ℓ = tanh²y, or 1 − e^−y: the way to a fall or an asymptote takes for ever in y
        return context.atanh(context.sqrt(x)) if self.turning else -context.log(1 - x)

    def rest(self, y: Numeric, arithmetic: Float64 | Multi) -> Numeric | int:
        """Return what |p|/|dq/dy| is multiplied by to stay finite: a power of the fraction of the way that is left."""
        if self.end == "fall":
            # p ~ left^(−pole/2) and dq/dy ~ left: both powers together
            root = arithmetic.unary("sqrt", self.distances(y, arithmetic)[1] / self.length)
            return root ** (self.pole + 2)
        if self.end == "boundary":
            root = arithmetic.unary("cos", y / 2) if self.turning else 1 - y
            return root ** (self.pole + 1)
        return 1

    def distances(self, y: Numeric, arithmetic: Float64 | Multi) -> tuple[Numeric, Numeric | None, Numeric]:
        """Return x, the distance left to the end (None for infinity and kinks) and dx/dy, none by cancellation."""
        call = arithmetic.unary
        if self.end in {"infinity", "kink"}:
            return (
                (self.length * y * y, None, 2 * self.length * y)
                if self.turning
                else (self.length * y, None, self.length + 0 * y)
            )
        if self.end == "boundary":
            if self.turning:
                sine, cosine = call("sin", y / 2), call("cos", y / 2)
                return self.length * sine * sine, self.length * cosine * cosine, self.length * sine * cosine
            rest = 1 - y
            return self.length * y * (2 - y), self.length * rest * rest, 2 * self.length * rest
        if self.turning:
            decay = call("exp", -y)  # 1/cosh y without the overflow of cosh y
            rise, fall = call("tanh", y), 2 * decay / (1 + decay * decay)
            return self.length * rise * rise, self.length * fall * fall, 2 * self.length * rise * fall * fall
        decay = call("exp", -y)
        return -self.length * call("expm1", -y), self.length * decay, self.length * decay

    def position(self, y: Numeric, arithmetic: Float64 | Multi) -> tuple[Numeric, Numeric]:
        """Return q and dq/dy at y ≥ 0."""
        x, left, slope = self.distances(y, arithmetic)
        q = self.start + self.side * x
        if left is not None:
            finish = self.start + self.side * self.length
            # in the second half from the end, of which the distance left is known to all digits
            q = arithmetic.where(left < x, finish - self.side * left, q)
        return q, self.side * slope


@dataclass(frozen=True)
class Panels:
    """Integrals along a branch, piecewise in Chebyshev polynomials.

    In its methods y are places, shape (m,), and ``function`` is the position of an integrand.

    Attributes:
        edges: y at the panel ends, shape (panels + 1,).
        coefficients: of the integrands, shape (functions, panels, degree + 1).
        sums: coefficients of their integrals from y = 0, shape (functions, panels, degree + 2).
        nodes: evaluations used.
        finished: True when the edges reach the end of a boundary branch, or infinity in a finite time.
    """

    edges: Numbers
    coefficients: Numbers
    sums: Numbers
    nodes: int
    finished: bool

    def value(self, function: int, y: Numbers) -> Numbers:
        """Return the integrand at y ≥ 0; doubles for doubles."""
        panels = self._for(y)
        return panels._sums(panels.coefficients[function], y)

    def integral(self, function: int, y: Numbers) -> Numbers:
        """Return its integral from 0 to y ≥ 0; past the last panel the integrand is continued by its last value."""
        panels = self._for(y)
        inside = np.minimum(y, panels.edges[-1])
        return panels._sums(panels.sums[function], inside) + (y - inside) * panels.value(function, inside)

    def spacing(self, function: int, y: Numbers) -> Reals:
        """Return the size that the rounding of the integral in doubles refers to: that of its panel's coefficients."""
        panels = self._for(y)
        sizes = np.sum(np.abs(panels.sums[function].astype(float)), axis=-1)
        return sizes[np.clip(np.searchsorted(panels.edges, y, side="right") - 1, 0, len(sizes) - 1)]

    def _for(self, y: Numbers) -> Panels:
        return self._rounded if y.dtype == float and self.edges.dtype == object else self

    @cached_property
    def _rounded(self) -> Panels:
        edges, coefficients, sums = (part.astype(float) for part in (self.edges, self.coefficients, self.sums))
        wide = np.diff(edges) > 0  # next to an end of many digits panels are narrower than doubles can tell
        edges, coefficients, sums = np.append(edges[:-1][wide], edges[-1]), coefficients[:, wide], sums[:, wide]
        return Panels(edges, coefficients, sums, self.nodes, self.finished)

    def _sums(self, table: Numbers, y: Numbers) -> Numbers:
        panel = np.clip(np.searchsorted(self.edges, y, side="right") - 1, 0, len(self.edges) - 2)
        x = in_panel(np.minimum(y, self.edges[-1]), self.edges[panel], self.edges[panel + 1])
        return clenshaw(np.moveaxis(table[panel], -1, 0), x)


@lru_cache(maxsize=64)
def chebyshev_points(count: int, bits: int) -> list[Mpf]:
    """Return the zeros of a Chebyshev polynomial.

    Args:
        count: its degree.
    """
    context = multiprecision(bits)
    return [context.cos(context.pi * (2 * m + 1) / (2 * count)) for m in range(count)]


def integrated_row(row: list[Mpf], half: Mpf, start: Mpf) -> list[Mpf]:
    """Return the coefficients of the integral, equal to ``start`` at the left edge (Mason & Handscomb 2003, (2.43)).

    Args:
        row: coefficients of the integrand.
        half: half the length of the panel.
        start: value at its left edge.
    """
    c = [*row, 0 * row[0], 0 * row[0]]
    # ∫T₀ = T₁, ∫Tₖ = (Tₖ₊₁/(k + 1) − Tₖ₋₁/(k − 1))/2; c₀ is the mean here, not twice it
    result = [0 * row[0], half * (c[0] - c[2] / 2)]
    result += [half * (c[k - 1] - c[k + 1]) / (2 * k) for k in range(2, len(row) + 1)]
    result[0] = start - sum(v if k % 2 == 0 else -v for k, v in enumerate(result))
    return result
