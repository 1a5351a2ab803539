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

The integrals are Chebyshev series on panels, each as long as its integrands are proved to be analytic around it
(``one_coordinate.panel_length``); far out panels grow geometrically, so the cost rises with the logarithm of the time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from threading import Lock
from typing import Protocol

import numpy as np

from hjsolve.arithmetic.floats import Float64, Multi, multiprecision
from hjsolve.arithmetic.fourier import smooth, waves
from hjsolve.arithmetic.number_types import Context, Mpf, Numbers, Numeric, Reals
from hjsolve.errors import NotConvergedError
from hjsolve.one_coordinate.panel_length import Surroundings, longest, nodes_for
from hjsolve.one_coordinate.turning_points import EndKind

_MAX_PANELS = 1600
_GROWTH, _LONGEST, _FIRST = 4.0, 8.0, 2.0
"""The longest panel thought of: so many times the last one, at most this on the way to an asymptote; the first one."""
_COSTLIEST = 4
"""Nodes of one panel, over those for integrands that are no larger in the ellipse than on the panel."""
_RETRIES = 8
"""How often a panel is shortened whose integrands are smaller than their bounds made them look."""


@dataclass(frozen=True)
class EndMap:
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
    start: Mpf
    side: int
    length: Mpf
    pole: int = 0

    def last(self, context: Context) -> Mpf | None:
        """Return the greatest y, None where there is none.

        Args:
            context: of mpmath.
        """
        if self.end != "boundary":
            return None
        return +context.pi if self.turning else context.mpf(1)

    def rest(self, y: Numeric, arithmetic: Float64 | Multi) -> Numeric | int:
        """Return what |p|/|dq/dy| is multiplied by to stay finite: a power of the share of the way that is left.

        Args:
            y: place on the branch, y ≥ 0.
            arithmetic: that y belongs to.
        """
        if self.end == "fall":
            root = arithmetic.unary("sqrt", self.distances(y, arithmetic)[1] / self.length)
            return root ** (self.pole + 2)
        if self.end == "boundary":
            root = arithmetic.unary("cos", y / 2) if self.turning else 1 - y
            return root ** (self.pole + 1)
        return 1

    def distances(self, y: Numeric, arithmetic: Float64 | Multi) -> tuple[Numeric, Numeric | None, Numeric]:
        """Return x, the distance left to the end (None for infinity) and dx/dy, none of them by cancellation.

        Args:
            y: place on the branch, y ≥ 0.
            arithmetic: that y belongs to.
        """
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
            decay = call("exp", -y)  # 1/cosh y without the overflow of cosh y
            rise, fall = call("tanh", y), 2 * decay / (1 + decay * decay)
            return self.length * rise * rise, self.length * fall * fall, 2 * self.length * rise * fall * fall
        decay = call("exp", -y)
        return -self.length * call("expm1", -y), self.length * decay, self.length * decay

    def position(self, y: Numeric, arithmetic: Float64 | Multi) -> tuple[Numeric, Numeric]:
        """Return q and dq/dy at y ≥ 0.

        Args:
            y: place on the branch, y ≥ 0.
            arithmetic: that y belongs to.
        """
        x, left, slope = self.distances(y, arithmetic)
        q = self.start + self.side * x
        if left is not None:
            finish = self.start + self.side * self.length
            q = arithmetic.where(left < x, finish - self.side * left, q)
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

    edges: Numbers
    coefficients: Numbers
    sums: Numbers
    nodes: int
    finished: bool

    def value(self, function: int, y: Numbers) -> Numbers:
        """Return the integrand at y ≥ 0; doubles for doubles.

        Args:
            function: position of the integrand.
            y: places, shape (m,).
        """
        panels = self._for(y)
        return panels._clenshaw(panels.coefficients[function], y)

    def integral(self, function: int, y: Numbers) -> Numbers:
        """Return its integral from 0 to y ≥ 0; past the last panel the integrand is continued by its last value.

        Args:
            function: position of the integrand.
            y: places, shape (m,).
        """
        panels = self._for(y)
        inside = np.minimum(y, panels.edges[-1])
        return panels._clenshaw(panels.sums[function], inside) + (y - inside) * panels.value(function, inside)

    def grain(self, function: int, y: Numbers) -> Reals:
        """Return the size that the rounding of the integral in doubles refers to: that of its panel's coefficients.

        Args:
            function: position of the integrand.
            y: places, shape (m,).
        """
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

    def _clenshaw(self, table: Numbers, y: Numbers) -> Numbers:
        panel = np.clip(np.searchsorted(self.edges, y, side="right") - 1, 0, len(self.edges) - 2)
        left, right = self.edges[panel], self.edges[panel + 1]
        x2 = 2 * ((np.minimum(y, self.edges[-1]) - left) - (right - np.minimum(y, self.edges[-1]))) / (right - left)
        rows = table[panel]
        b1 = b2 = 0 * x2
        for k in range(rows.shape[-1] - 1, 0, -1):
            b1, b2 = x2 * b1 - b2 + rows[..., k], b1
        return x2 / 2 * b1 - b2 + rows[..., 0]


class Integrated(Protocol):
    """Functions of y in many digits, with what is known of them about a place; see ``open_branch.Branch``."""

    def integrands(self, y: Mpf, extra: int = 0) -> list[Mpf]:
        """Return the values of all functions at y (``mpf``), with so many bits more than usual.

        Args:
            y: place on the branch.
            extra: bits above the working precision.
        """
        ...

    def cancelled(self, y: Mpf, extra: int) -> int:
        """Return the bits more than usual that the functions need at y, at least ``extra``.

        Args:
            y: place on the branch.
            extra: bits above the working precision to begin with.
        """
        ...

    def around(self, y: Mpf, rest: float) -> Surroundings:
        """Return where the functions are analytic about y; ``rest`` is left from there to the greatest y.

        Args:
            y: place on the branch.
            rest: what is left from there to the greatest y.
        """
        ...


class Growing:
    """The integrals along a branch, panel by panel, as far as they were asked for; what is there is never done again.

    The panels do not depend on how far is asked for: a shorter reach has the first ones of a longer.
    """

    def __init__(self, way: EndMap, course: Integrated, *, digits: int, bits: int):
        """Start at y = 0.

        Args:
            way: the branch.
            course: what is integrated.
            digits: relative digits wanted.
            bits: working precision.
        """
        self.way, self.course, self.digits, self.bits, self.extra = way, course, digits, bits, 0
        self.context = multiprecision(bits)
        self.last = way.last(self.context)
        self.step = self.context.mpf(_FIRST) / _GROWTH
        self.edges, self.values, self.sums, self.totals = [self.context.mpf(0)], [], [], []  # type: ignore[var-annotated]
        self.nodes: list[int] = []
        self.over = self.blown = False
        self.failed: NotConvergedError | None = None
        self.lock = Lock()

    def until(self, enough: Callable[[Mpf, list[Mpf]], bool]) -> Panels:
        """Return the panels up to the first that is enough, or to the last there is.

        Args:
            enough: (y, integrals so far) ↦ True when the branch is long enough.

        Raises:
            NotConvergedError: too many panels; the integrand could not be shown to be analytic along the branch.
        """
        count = 0
        with self.lock:
            while count < len(self.values) or not self.over:
                if count == len(self.values):
                    self._grow()
                count += 1
                if enough(self.edges[count], self.totals[count - 1]):
                    break
        y, kind = self.edges[count], float if self.digits <= 15 else object
        ends = self.over and count == len(self.values)
        return Panels(
            np.array(self.edges[: count + 1], dtype=kind),
            np.array(_filled(self.values[:count]), dtype=kind).transpose(1, 0, 2),
            np.array(_filled(self.sums[:count]), dtype=kind).transpose(1, 0, 2),
            self.nodes[count - 1],
            (ends and self.blown) or (self.last is not None and bool(y >= self.last * (1 - 2.0**-40))),
        )

    def _grow(self) -> None:
        """Add one panel."""
        if self.failed is None:
            try:
                rows, nodes = self._resolved()
            except NotConvergedError as error:
                self.failed = error
        if self.failed is not None:
            raise self.failed
        context, y = self.context, self.edges[-1] + self.step
        before = self.totals[-1] if self.totals else [context.mpf(0)] * len(rows)
        integrated = [integrated_row(row, self.step / 2, total) for row, total in zip(rows, before, strict=True)]
        after = [context.fsum(row) for row in integrated]
        self.values.append(rows)
        self.sums.append(integrated)
        self.totals.append(after)
        self.edges.append(y)
        self.nodes.append(nodes)
        self.blown = self.way.end == "infinity" and _settled(before, after, self.digits, context)
        # the end; or, where it is not analytic there, near enough
        self.over = self.blown or (
            self.last is not None and self.last - y <= self.last * context.mpf(10) ** -self.digits
        )

    def _resolved(self) -> tuple[list[list[Mpf]], int]:
        """Chebyshev coefficients over the next panel, proved to be enough, and the nodes used so far."""
        y, nodes = self.edges[-1], self.nodes[-1] if self.nodes else 0
        if len(self.values) > _MAX_PANELS:
            raise NotConvergedError(f"more than {_MAX_PANELS} panels on the way to {self.way.end}; {self._reached(y)}")
        rest = 0.0 if self.last is None else float(self.last - y)
        around, most = self.course.around(y, rest), _GROWTH * float(self.step)
        if self.last is not None:
            most = min(most, rest) if most < rest / 2 else rest
        elif self.way.end != "infinity":
            most = min(most, _LONGEST)
        for _ in range(_RETRIES):
            reach = longest(around, most, self.digits)
            if reach is None:
                break
            self.step = self.last - y if reach.length == rest else self.context.mpf(reach.length)
            count, most = reach.nodes, reach.length / 2
            ends = [y + self.step] if self.last is None or y + self.step < self.last else []
            extra = max([self.extra, *(self.course.cancelled(end, self.extra) for end in ends)])
            while count <= _COSTLIEST * nodes_for(0.0, self.digits):
                points = chebyshev_points(smooth(count), self.bits)
                rows = _expand(self.course, y, self.step, points, self.bits, extra)
                nodes += len(points)
                count = reach.nodes_for([max(abs(c) for c in row) for row in rows], self.digits)
                if count <= len(points):
                    self.extra = extra
                    return rows, nodes
        raise NotConvergedError(
            f"the integrand could not be shown to be smooth near y = {float(y):.6g} on its way to {self.way.end}; "
            + self._reached(y)
        )

    def _reached(self, y: Mpf) -> str:
        q, _ = self.way.position(y, Multi(self.bits))
        return f"the integrals are known up to q = {float(q):.9g}"


def _filled(rows: list[list[list[Mpf]]]) -> list[list[list[Mpf]]]:
    """Series of panels, all of the same length."""
    longest_ = max(len(series) for panel in rows for series in panel)
    return [[[*series, *[0 * series[0]] * (longest_ - len(series))] for series in panel] for panel in rows]


@lru_cache(maxsize=64)
def chebyshev_points(count: int, bits: int) -> list[Mpf]:
    """The zeros of a Chebyshev polynomial.

    Args:
        count: its degree.
        bits: of the result.
    """
    context = multiprecision(bits)
    return [context.cos(context.pi * (2 * m + 1) / (2 * count)) for m in range(count)]


def _settled(before: list[Mpf], after: list[Mpf], digits: int, context: Context) -> bool:
    """True when the integrals (the momentum's apart) no longer grow: infinity is reached in a finite time."""
    tiny = context.mpf(10) ** -(digits + 3)
    return all(abs(b - a) <= tiny * abs(b) for a, b in zip(before[:-1], after[:-1], strict=True))


def _expand(course: Integrated, y: Mpf, step: Mpf, points: list[Mpf], bits: int, extra: int) -> list[list[Mpf]]:
    """Chebyshev coefficients on [y, y + step] from values at Chebyshev points."""
    context, n = multiprecision(bits), len(points)
    samples = [course.integrands(y + step * (1 + x) / 2, extra) for x in points]
    rows = []
    for column in zip(*samples, strict=True):
        values = [context.convert(v) for v in column]
        waves_ = waves(values, even=True, bits=bits)[0] if any(values) else [context.mpf(0)] * (n - 1)
        rows.append([context.fsum(values) / n, *waves_])
    return rows


def integrated_row(row: list[Mpf], half: Mpf, start: Mpf) -> list[Mpf]:
    """Coefficients of the integral, equal to ``start`` at the left edge (Mason & Handscomb 2003, (2.43)).

    Args:
        row: coefficients of the integrand.
        half: half the length of the panel.
        start: value at its left edge.
    """
    c = [*row, 0 * row[0], 0 * row[0]]
    result = [0 * row[0], half * (c[0] - c[2] / 2)]
    result += [half * (c[k - 1] - c[k + 1]) / (2 * k) for k in range(2, len(row) + 1)]
    result[0] = start - sum(v if k % 2 == 0 else -v for k, v in enumerate(result))
    return result
