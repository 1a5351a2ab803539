"""The inverted time law as a table: polynomials in time on panels, for many times at once.

One coordinate whose phase equation holds no other one is a function of its own angle θ alone. The
panels are chosen in the anomaly χ, where everything is smooth, and bisected until each quantity is a
polynomial of low degree in θ to the last bits *relative to its size on the panel*; so a perihelion of
10⁻¹² keeps its digits. dθ/dχ is positive and evaluated without cancellation, hence its integral too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from hjsolve.errors import NotConvergedError

_DEGREE = 11
_GROWTH_NODES = 20
_TOLERANCE = 1e-15
_CHUNK = 8192
_MOST = 4000


@dataclass(frozen=True, eq=False)
class Table:
    """Quantities as functions of an increasing argument.

    Attributes:
        edges: argument at the panel ends, shape (panels + 1,).
        coefficients: for each quantity, powers of x ∈ [−1, 1] on each panel, lowest first, shape (degree + 1, panels).
        even: for each quantity of a table over [0, π]: True where f(−θ) = f(θ), False where f(−θ) = −f(θ).
        bounds: size that a quantity's accuracy refers to, one a panel.
    """

    edges: Any
    coefficients: tuple[Any, ...]
    even: tuple[bool, ...]
    bounds: tuple[Any, ...]

    def sizes(self, quantity: int, θ: Any) -> Any:
        """Return the size each value is accurate against: the largest of its quantity on its panel."""
        u = np.abs(θ) if self.even else θ
        panel = np.clip(np.searchsorted(self.edges, u, side="right") - 1, 0, len(self.edges) - 2)
        return np.take(self.bounds[quantity], panel)

    def evaluate(self, quantities: Sequence[int], θ: Any) -> list[Any]:
        """Return the quantities at arguments inside the table, shape (m,); chunked to stay in the cache."""
        results = [np.empty_like(θ) for _ in quantities]
        for begin in range(0, len(θ), _CHUNK):
            part = slice(begin, begin + _CHUNK)
            self._chunk(quantities, θ[part], [r[part] for r in results])
        return results

    def _chunk(self, quantities: Sequence[int], θ: Any, out: list[Any]) -> None:
        folded = bool(self.even)
        u = np.abs(θ) if folded else θ
        panel = np.searchsorted(self.edges, u, side="right") - 1
        np.clip(panel, 0, len(self.edges) - 2, out=panel)
        left, right = np.take(self.edges, panel), np.take(self.edges[1:], panel)
        x = ((u - left) - (right - u)) / (right - left)
        buffer = np.empty_like(x)
        for quantity, result in zip(quantities, out, strict=True):
            table = self.coefficients[quantity]
            np.take(table[-1], panel, out=result)
            for row in table[-2::-1]:
                result *= x
                np.take(row, panel, out=buffer)
                result += buffer
            if folded and not self.even[quantity]:
                np.copysign(1.0, θ, out=buffer)
                result *= buffer


def tabulate(
    starts: Any,
    growth: Callable[[Any], Any],
    outputs: Callable[[Any], list[Any]],
    scales: Sequence[float | None],
    *,
    even: Sequence[bool] = (),
    origin: float = 0.0,
    total: float | None = None,
) -> Table:
    """Build a table.

    Args:
        starts: first choice of panel edges in the phase, increasing.
        growth: phase ↦ dθ/dχ > 0, arrays of one shape.
        outputs: phase ↦ the quantities.
        scales: size below which a quantity needs no relative accuracy, one each; None: its largest value on the panel.
        even: parities for a table over [0, π]; empty for a table that is not folded.
        origin: θ at the first edge.
        total: known length of the table in θ, to which the sum is adjusted in the last bits.

    Raises:
        NotConvergedError: too many panels; a quantity is not smooth.
    """
    left, right = np.asarray(starts[:-1], dtype=float), np.asarray(starts[1:], dtype=float)
    done: list[tuple[Any, Any, Any]] = []
    tables: tuple[Any, ...]
    while len(left):
        lengths, parts, good = _panels(left, right, growth, outputs, scales)
        small = (right - left) <= 1e-13 * np.maximum(np.abs(left), np.abs(right))
        good |= small
        done.append((left[good], lengths[good], [part[:, good] for part in parts]))
        left, right = left[~good], right[~good]
        middle = _halfway(left, right)
        left, right = np.concatenate([left, middle]), np.concatenate([middle, right])
        if sum(len(d[0]) for d in done) + len(left) > _MOST:
            raise NotConvergedError("the motion is too rough for a table of positions")
    order = np.argsort(np.concatenate([d[0] for d in done]), kind="stable")
    lengths = np.concatenate([d[1] for d in done])[order]
    edges = origin + np.concatenate([[0.0], np.cumsum(lengths)])
    if total is not None:
        edges = origin + (edges - origin) * (total / (edges[-1] - origin))
    tables = tuple(
        np.ascontiguousarray(np.concatenate([d[2][k] for d in done], axis=1)[:, order]) for k in range(len(scales))
    )
    bounds = tuple(np.maximum(np.sum(np.abs(rows), axis=0), scale or 0.0) for rows, scale in zip(tables, scales))
    return Table(edges, tables, tuple(even), bounds)


def _halfway(left: Any, right: Any) -> Any:
    """Middle of a panel; nearer to zero where zero is one of its ends, since the rough places lie there."""
    at_zero = (left == 0) | (right == 0)
    return np.where(at_zero, 0.125 * (left + right), 0.5 * (left + right))


@cache
def _chebyshev(n: int) -> tuple[Any, Any]:
    """Chebyshev points of [−1, 1], increasing, and the matrix from values to Chebyshev coefficients."""
    angles = np.pi * (np.arange(n)[::-1] + 0.5) / n
    matrix = 2 / n * np.cos(np.outer(np.arange(n), angles))
    matrix[0] /= 2
    return np.cos(angles), matrix


@cache
def _to_powers(n: int) -> Any:
    """Matrix from Chebyshev coefficients to powers."""
    return np.stack(
        [np.polynomial.chebyshev.cheb2poly(np.eye(n)[k]).tolist() + [0.0] * (n - 1 - k) for k in range(n)], axis=1
    )


def _panels(
    left: Any, right: Any, growth: Any, outputs: Any, scales: Sequence[float | None]
) -> tuple[Any, list[Any], Any]:
    """Try panels: their lengths in θ, power coefficients of every quantity, and which panels are fine enough."""
    points, matrix = _chebyshev(_GROWTH_NODES)
    half = (right - left) / 2
    values = np.reshape(growth((left + half + half * points[:, None]).ravel()), (_GROWTH_NODES, -1))
    series = matrix @ values
    good = np.max(np.abs(series[-2:]), axis=0) <= 2 * _TOLERANCE * np.abs(series[0])
    integral = np.polynomial.chebyshev.chebint(series * half, lbnd=-1)
    length = np.sum(integral, axis=0)
    nodes, transform = _chebyshev(_DEGREE + 1)
    goal = length * (1 + nodes[:, None]) / 2
    s = np.clip(_local(integral, series * half, goal, nodes[:, None] + 0 * goal), -1, 1)
    tables = []
    argument = 2.0**-52 * np.maximum(np.abs(left), np.abs(right)) / half
    for quantity, scale in zip(outputs((left + half + half * s).ravel()), scales, strict=True):
        rows = np.reshape(quantity, s.shape)
        coefficients = transform @ rows
        size = np.max(np.abs(rows), axis=0) if scale is None else np.maximum(np.min(np.abs(rows), axis=0), scale)
        good &= np.max(np.abs(coefficients[-2:]), axis=0) <= _TOLERANCE * size + 2 * argument * np.abs(coefficients[1])
        tables.append(_to_powers(_DEGREE + 1) @ coefficients)
    return length, tables, good


def _local(integral: Any, series: Any, goal: Any, s: Any) -> Any:
    """Solve ∫ growth = goal on each panel by Newton's method in the panel's own variable."""
    for _ in range(14):
        value = np.stack([np.polynomial.chebyshev.chebval(row, integral, tensor=False) for row in s])
        slope = np.stack([np.polynomial.chebyshev.chebval(row, series, tensor=False) for row in s])
        step = (value - goal) / slope
        s = np.clip(s - step, -1, 1)
        if np.max(np.abs(step), initial=0) < 1e-15:
            break
    return s
