"""Motions that do not come back: escape, collision with an end of the domain, creeping to a separatrix.

One analytic parameter y runs from the start of a branch (a turning point, or any regular place) to
its end; the map q(y) is chosen by the two ends so that dq/p is analytic in y up to and including both:

    start → end            distance x from the start       what it cures
    turning → infinity     x = L y²                        the inverse square root at the start
    turning → boundary     x = ℓ sin²(y/2), y ≤ π          the same, and an integer power of p² at the end
    turning → asymptote    x = ℓ tanh² y                   the same, and the double zero: t grows like y
    regular → infinity     x = L y
    regular → boundary     x = ℓ (1 − (1 − y)²), y ≤ 1
    regular → asymptote    x = ℓ (1 − e^{−y})
    … → fall               as to an asymptote: reached in a finite time, but an angle winds for ever on the way

The integrals are Chebyshev series on panels whose length adapts to their decay; far out panels grow
geometrically, so the cost rises with the logarithm of the time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from hjsolve.errors import NotConvergedError
from hjsolve.numeric.arithmetic import Float64, Multi, multiprecision
from hjsolve.numeric.fourier import smooth, waves
from hjsolve.numeric.turning_points import EndKind

_MAX_PANELS = 1600
_LEAST_SHARE = 2.0**-10
"""Of the way that is left to a boundary; where a panel may take less, the singularity there is essential."""


@dataclass(frozen=True)
class Way:
    """The map q(y) of one branch.

    Attributes:
        turning: True where the branch starts at a turning point.
        end: ``infinity``, ``boundary``, ``fall`` or ``asymptote``.
        start: q at y = 0.
        side: +1 where q grows with y.
        length: ℓ, the distance to the end; for infinity the length L that makes y a number of order one.
        pole: order of the pole of p² at a boundary; 0 where p² has none.
    """

    turning: bool
    end: EndKind
    start: Any
    side: int
    length: Any
    pole: int = 0

    def last(self, context: Any) -> Any:
        """Return the greatest y, None where there is none."""
        if self.end != "boundary":
            return None
        return +context.pi if self.turning else context.mpf(1)

    def rest(self, y: Any, arithmetic: Float64 | Multi) -> Any:
        """Return what |p|/|dq/dy| is multiplied by to stay finite: a power of the share of the way that is left."""
        if self.end == "fall":
            root = arithmetic.unary("sqrt", self.distances(y, arithmetic)[1] / self.length)
            return root ** (self.pole + 2)
        if self.end == "boundary":
            root = arithmetic.unary("cos", y / 2) if self.turning else 1 - y
            return root ** (self.pole + 1)
        return 1

    def distances(self, y: Any, arithmetic: Float64 | Multi) -> tuple[Any, Any, Any]:
        """Return x, the distance left to the end (None for infinity) and dx/dy, none of them by cancellation."""
        call = arithmetic.unary
        if self.end == "infinity":
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
            rise, fall = call("tanh", y), 1 / call("cosh", y)
            return self.length * rise * rise, self.length * fall * fall, 2 * self.length * rise * fall * fall
        decay = call("exp", -y)
        return -self.length * call("expm1", -y), self.length * decay, self.length * decay

    def position(self, y: Any, arithmetic: Float64 | Multi) -> tuple[Any, Any]:
        """Return q and dq/dy at y ≥ 0."""
        x, left, slope = self.distances(y, arithmetic)
        q = self.start + self.side * x
        if left is not None:
            finish = self.start + self.side * self.length
            q = (
                np.where(left < x, finish - self.side * left, q)
                if isinstance(x, np.ndarray)
                else q
                if x <= left
                else finish - self.side * left
            )
        return q, self.side * slope


@dataclass(frozen=True)
class Panels:
    """Integrals along a branch, piecewise in Chebyshev polynomials.

    Attributes:
        edges: y at the panel ends, shape (panels + 1,).
        coefficients: of the integrands, shape (functions, panels, degree + 1).
        sums: coefficients of their integrals from y = 0, shape (functions, panels, degree + 2).
        nodes: evaluations used.
        finished: True when the edges reach the end of a boundary branch, or infinity in a finite time.
    """

    edges: Any
    coefficients: Any
    sums: Any
    nodes: int
    finished: bool

    def value(self, function: int, y: Any) -> Any:
        """Return the integrand at y ≥ 0; doubles for doubles."""
        panels = self._for(y)
        return panels._clenshaw(panels.coefficients[function], y)

    def integral(self, function: int, y: Any) -> Any:
        """Return its integral from 0 to y ≥ 0; past the last panel the integrand is continued by its last value."""
        panels = self._for(y)
        inside = np.minimum(y, panels.edges[-1])
        return panels._clenshaw(panels.sums[function], inside) + (y - inside) * panels.value(function, inside)

    def _for(self, y: Any) -> Panels:
        return self._rounded if y.dtype == float and self.edges.dtype == object else self

    @cached_property
    def _rounded(self) -> Panels:
        edges, coefficients, sums = (part.astype(float) for part in (self.edges, self.coefficients, self.sums))
        wide = np.diff(edges) > 0  # next to an end of many digits panels are narrower than doubles can tell
        edges, coefficients, sums = np.append(edges[:-1][wide], edges[-1]), coefficients[:, wide], sums[:, wide]
        return Panels(edges, coefficients, sums, self.nodes, self.finished)

    def _clenshaw(self, table: Any, y: Any) -> Any:
        panel = np.clip(np.searchsorted(self.edges, y, side="right") - 1, 0, len(self.edges) - 2)
        left, right = self.edges[panel], self.edges[panel + 1]
        x2 = 2 * ((np.minimum(y, self.edges[-1]) - left) - (right - np.minimum(y, self.edges[-1]))) / (right - left)
        rows = table[panel]
        b1 = b2 = 0 * x2
        for k in range(rows.shape[-1] - 1, 0, -1):
            b1, b2 = x2 * b1 - b2 + rows[..., k], b1
        return x2 / 2 * b1 - b2 + rows[..., 0]


def build(
    way: Way,
    integrands: Callable[[Any], list[Any]],
    enough: Callable[[Any, list[Any]], bool],
    *,
    digits: int,
    bits: int,
) -> Panels:
    """Integrate along a branch, panel by panel.

    Args:
        way: the branch.
        integrands: y (``mpf``) ↦ the values of all functions.
        enough: (y, integrals so far) ↦ True when the branch is long enough.
        digits: relative digits wanted.
        bits: working precision.

    Raises:
        NotConvergedError: too many panels; the integrand is not analytic along the branch.
    """
    context = multiprecision(bits)
    degree = smooth(max(20, int(1.3 * digits)) + 1) - 1
    points = [context.cos(context.pi * (2 * m + 1) / (2 * (degree + 1))) for m in range(degree + 1)]
    last = way.last(context)
    y, step = context.mpf(0), context.mpf(1) / 2
    tiny = context.mpf(10) ** -digits
    totals: list[Any] | None = None
    blown, share = False, 1.0  # share: of the way that is left, which one panel may take
    edges, values, sums, nodes = [y], [], [], 0
    while totals is None or not enough(y, totals):
        if last is not None:
            step = min(step, share * (last - y))
        rows = _expand(integrands, y, step, points, bits)
        nodes += degree + 1
        if _tail(rows) > 10.0 ** -(digits + 1):
            step /= 2
            share = 1.0 if last is None else float(step / (last - y))
            if nodes > _MAX_PANELS * degree or step < context.mpf(2) ** -200 or share < _LEAST_SHARE:
                raise NotConvergedError(f"the integrand stays rough near y = {float(y):.6g} on its way to {way.end}")
            continue
        if totals is None:
            totals = [context.mpf(0)] * len(rows)
        before = totals
        integrated = [_antiderivative(row, step / 2, total) for row, total in zip(rows, totals, strict=True)]
        totals = [context.fsum(row) for row in integrated]
        values.append(rows)
        sums.append(integrated)
        y += step
        edges.append(y)
        if last is not None and last - y <= last * tiny:  # the end; or, where it is not analytic there, near enough
            break
        share = min(1.0, share * 1.1)
        if way.end == "infinity" and _settled(before, totals, digits, context):
            blown = True
            break
        if len(values) > _MAX_PANELS:
            raise NotConvergedError(f"more than {_MAX_PANELS} panels on the way to {way.end}")
        step = (
            min(2 * step, max(step, 5 * y / 8))
            if way.end in {"infinity", "boundary"}
            else min(2 * step, context.mpf(2))
        )
    kind = float if digits <= 15 else object
    return Panels(
        np.array(edges, dtype=kind),
        np.array(values, dtype=kind).transpose(1, 0, 2),
        np.array(sums, dtype=kind).transpose(1, 0, 2),
        nodes,
        blown or (last is not None and y >= last * (1 - 2.0**-40)),
    )


def _settled(before: list[Any], after: list[Any], digits: int, context: Any) -> bool:
    """True when the integrals (the momentum's apart) no longer grow: infinity is reached in a finite time."""
    tiny = context.mpf(10) ** -(digits + 3)
    return all(abs(b - a) <= tiny * abs(b) for a, b in zip(before[:-1], after[:-1], strict=True))


def _expand(integrands: Callable[[Any], list[Any]], y: Any, step: Any, points: list[Any], bits: int) -> list[list[Any]]:
    """Chebyshev coefficients on [y, y + step] from values at Chebyshev points."""
    context, n = multiprecision(bits), len(points)
    samples = [integrands(y + step * (1 + x) / 2) for x in points]
    rows = []
    for column in zip(*samples, strict=True):
        values = [context.convert(v) for v in column]
        waves_ = waves(values, even=True, bits=bits)[0] if any(values) else [context.mpf(0)] * (n - 1)
        rows.append([context.fsum(values) / n, *waves_])
    return rows


def _tail(rows: list[list[Any]]) -> float:
    """Largest of the last three coefficients, relative to the largest of all, over all functions."""
    worst = 0.0
    for row in rows:
        size = max(abs(c) for c in row)
        if size:
            worst = max(worst, float(max(abs(c) for c in row[-3:]) / size))
    return worst


def _antiderivative(row: list[Any], half: Any, start: Any) -> list[Any]:
    """Coefficients of the integral, equal to ``start`` at the left edge (Mason & Handscomb 2003, (2.43))."""
    c = [*row, 0 * row[0], 0 * row[0]]
    result = [0 * row[0], half * (c[0] - c[2] / 2)]
    result += [half * (c[k - 1] - c[k + 1]) / (2 * k) for k in range(2, len(row) + 1)]
    result[0] = start - sum(v if k % 2 == 0 else -v for k, v in enumerate(result))
    return result
