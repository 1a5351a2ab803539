"""The inverted time law as a table: polynomials in time on panels, for many times at once.

One coordinate whose phase equation holds no other one is a function of its own angle θ alone. The
panels are chosen in the anomaly χ, where everything is smooth, and bisected until each quantity is a
polynomial of low degree in θ to the last bits *relative to its size on the panel*; so a perihelion of
10⁻¹² keeps its digits. dθ/dχ is positive and evaluated without cancellation, hence its integral too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from hjsolve.arithmetic.chebyshev import clenshaw
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Elementwise, Integers, Mask, Numbers, Reals
from hjsolve.errors import NotConvergedError
from hjsolve.time_law.compiled import kernels
from hjsolve.time_law.phase_reduction import CHUNK

DEGREE = 11
"""Degree of every polynomial; ``compiled_loops`` writes Horner's rule out for it."""

_GROWTH_NODES = 20  # of dθ/dχ on a panel; the last two coefficients tell whether they resolve it
_TOLERANCE = 1e-15  # of the last two coefficients: a table is to be as good as doubles
_CELLS = 4  # of the guide, a panel: the panel of a place is then at most a few further on
_MOST_PANELS = 4000
"""Above which there is no table: 48 000 coefficients a quantity."""


@dataclass(frozen=True, eq=False)
class InterpolationTable:
    """Quantities as functions of an increasing argument.

    Attributes:
        edges: argument at the panel ends, shape (panels + 1,).
        coefficients: for each quantity, powers of x ∈ [−1, 1] on each panel, lowest first, shape (degree + 1, panels).
        even: for each quantity of a table over [0, π]: True where f(−θ) = f(θ), False where f(−θ) = −f(θ).
        bounds: size that a quantity's accuracy refers to, one a panel.
        uncertainties: what the rounding of the phase may do to the argument, one a panel.
    """

    edges: Reals
    coefficients: tuple[Reals, ...]
    even: tuple[bool, ...]
    bounds: tuple[Reals, ...]
    uncertainties: Reals

    @cached_property
    def guide(self) -> Integers:
        """Last panel that begins at or before each of equally spaced places from the first edge to the last."""
        places = np.linspace(self.edges[0], self.edges[-1], _CELLS * (len(self.edges) - 1) + 1)
        return np.clip(np.searchsorted(self.edges, places, side="right") - 1, 0, len(self.edges) - 2)

    @cached_property
    def by_panel(self) -> tuple[Reals, ...]:
        """For each quantity its coefficients, those of a panel side by side; shape (panels, degree + 1)."""
        return tuple(np.ascontiguousarray(rows.T) for rows in self.coefficients)

    def panels(self, u: Reals) -> Integers:
        """Return the panel of each argument (not negative where the table is folded).

        The guide gives it where at most one edge lies in a cell; only the rest is searched for. At the end of a cell
        rounding may give the panel before or after, whose polynomial holds there as well.

        Args:
            u: arguments inside the table, shape (m,).
        """
        guide, first = self.guide, self.edges[0]
        cells = len(guide) - 1
        with np.errstate(invalid="ignore"):
            cell = ((u - first) * (cells / (self.edges[-1] - first))).astype(np.intp)
        np.clip(cell, 0, cells - 1, out=cell)
        panel, beyond = np.take(guide, cell), np.take(guide[1:], cell)
        crowded = np.flatnonzero(beyond - panel > 1)
        panel += (beyond > panel) & (np.take(self.edges, beyond) <= u)
        if len(crowded):
            found = np.searchsorted(self.edges, u[crowded], side="right") - 1
            panel[crowded] = np.clip(found, 0, len(self.edges) - 2)
        return panel

    def sizes(self, quantity: int, θ: Reals) -> Reals:
        """Return the size each value is accurate against: the largest of its quantity on its panel.

        Args:
            quantity: position of the quantity in the table.
            θ: arguments inside the table, shape (m,).
        """
        return np.take(self.bounds[quantity], self.panels(np.abs(θ) if self.even else θ))

    def uncertainty(self, θ: Reals) -> Reals:
        """Return the doubt in the argument that comes from the rounding of phases when the table was made.

        Args:
            θ: arguments inside the table, shape (m,).
        """
        return np.take(self.uncertainties, self.panels(np.abs(θ) if self.even else θ))

    def evaluate(self, quantities: Sequence[int], θ: Reals) -> list[Reals]:
        """Return the quantities at arguments inside the table, shape (m,).

        Args:
            quantities: their positions in the table.
            θ: arguments inside the table, shape (m,).
        """
        results = [np.empty_like(θ) for _ in quantities]
        if compiled := kernels(len(θ)):
            for quantity, result in zip(quantities, results, strict=True):
                parity = 0 if not self.even else 1 if self.even[quantity] else -1
                compiled.look_up(θ, self.edges, self.guide, self.by_panel[quantity], parity, result)
            return results
        for begin in range(0, len(θ), CHUNK):
            part = slice(begin, begin + CHUNK)
            self._chunk(quantities, θ[part], [r[part] for r in results])
        return results

    def _chunk(self, quantities: Sequence[int], θ: Reals, out: list[Reals]) -> None:
        reduced = bool(self.even)
        u = np.abs(θ) if reduced else θ
        panel = self.panels(u)
        left, right = np.take(self.edges, panel), np.take(self.edges[1:], panel)
        # both differences are exact or nearly so (Sterbenz) inside a narrow panel; 2u − left − right would round first
        x = ((u - left) - (right - u)) / (right - left)
        buffer = np.empty_like(x)
        for quantity, result in zip(quantities, out, strict=True):
            table = self.coefficients[quantity]
            np.take(table[-1], panel, out=result)
            for row in table[-2::-1]:
                result *= x
                np.take(row, panel, out=buffer)
                result += buffer
            if reduced and not self.even[quantity]:
                np.copysign(1.0, θ, out=buffer)
                result *= buffer


def tabulate(
    starts: Reals,
    growth: Callable[[Reals], Numbers],
    outputs: Callable[[Reals], list[Elementwise]],
    scales: Sequence[float | None],
    *,
    even: Sequence[bool] = (),
    origin: float = 0.0,
    total: float | None = None,
    known: Callable[[Reals], Numbers] | None = None,
    spacings: Callable[[Reals], list[Elementwise]] | None = None,
) -> InterpolationTable:
    """Build a table.

    Args:
        starts: first choice of panel edges in the phase, increasing.
        growth: phase ↦ dθ/dχ > 0, arrays of one shape.
        outputs: phase ↦ the quantities.
        scales: size below which a quantity needs no relative accuracy, one each; None: its largest value on the panel.
        even: parities for a table over [0, π]; empty for a table that is not folded.
        origin: θ at the first edge.
        total: known length of the table in θ, to which the sum is adjusted in the last bits.
        known: phase ↦ θ to a few units in the last place of ``total``: what the sum of many panels is not. Where θ has
            not grown far the sum is better, whose error is relative.
        spacings: phases at the left ends of panels ↦ sizes that the quantities are rounded against, where those are
            larger than the quantities.

    Raises:
        NotConvergedError: too many panels; a quantity is not smooth.
    """
    left, right = np.asarray(starts[:-1], dtype=float), np.asarray(starts[1:], dtype=float)
    done: list[tuple[Reals, Reals, list[Reals], Reals]] = []
    tables: tuple[Reals, ...]
    while len(left):
        lengths, parts, good = _panels(left, right, growth, outputs, scales)
        small = (right - left) <= 1e-13 * np.maximum(np.abs(left), np.abs(right))
        good |= small
        done.append((left[good], lengths[good], [part[:, good] for part in parts], right[good]))
        # bisection in χ: where a quantity varies fast in χ, and not in θ, panels pile up
        left, right = left[~good], right[~good]
        middle = _halfway(left, right)
        left, right = np.concatenate([left, middle]), np.concatenate([middle, right])
        if sum(len(d[0]) for d in done) + len(left) > _MOST_PANELS:
            raise NotConvergedError("the motion varies too fast for a table of positions")
    order = np.argsort(np.concatenate([d[0] for d in done]), kind="stable")
    lengths = np.concatenate([d[1] for d in done])[order]
    edges = origin + np.concatenate([[0.0], np.cumsum(lengths)])
    if total is not None:
        # the sum of lengths is off by rounding of many panels; the whole is known to be a turn
        edges = origin + (edges - origin) * (total / (edges[-1] - origin))
        if known is not None:
            phases = np.append(np.concatenate([d[0] for d in done])[order], starts[-1])
            # far from the origin an absolute error in the last bits of ``total`` beats a relative one that has added up
            edges = np.where(edges - origin > total / 16, known(phases), edges)
            edges = np.maximum.accumulate(np.minimum(edges, origin + total))
    tables = tuple(
        np.ascontiguousarray(np.concatenate([d[2][k] for d in done], axis=1)[:, order]) for k in range(len(scales))
    )
    begins, ends = (np.concatenate([d[k] for d in done])[order] for k in (0, 3))
    floors: list[Elementwise] = spacings(begins) if spacings else [0.0] * len(scales)
    bounds = tuple(
        np.maximum(np.sum(np.abs(rows), axis=0), np.maximum(scale or 0.0, floor))
        for rows, scale, floor in zip(tables, scales, floors)
    )
    # δθ = (dθ/dχ) δχ, with the mean slope of the panel, δχ the rounding of the phase at which samples were taken
    uncertainties = EPS * np.maximum(np.abs(begins), np.abs(ends)) * np.diff(edges) / (ends - begins)
    return InterpolationTable(edges, tables, tuple(even), bounds, uncertainties)


def _halfway(left: Reals, right: Reals) -> Reals:
    """Middle of a panel; nearer to zero where zero is one of its ends, since the rough places lie there."""
    at_zero = (left == 0) | (right == 0)
    return np.where(at_zero, 0.125 * (left + right), 0.5 * (left + right))


@cache
def _chebyshev(n: int) -> tuple[Reals, Reals]:
    """Chebyshev points of [−1, 1], increasing, and the matrix from values to Chebyshev coefficients."""
    angles = np.pi * (np.arange(n)[::-1] + 0.5) / n
    matrix = 2 / n * np.cos(np.outer(np.arange(n), angles))
    matrix[0] /= 2
    return np.cos(angles), matrix


@cache
def _to_powers(n: int) -> Reals:
    """Matrix from Chebyshev coefficients to powers."""
    return np.stack(
        [np.polynomial.chebyshev.cheb2poly(np.eye(n)[k]).tolist() + [0.0] * (n - 1 - k) for k in range(n)], axis=1
    )


def _panels(
    left: Reals,
    right: Reals,
    growth: Callable[[Reals], Numbers],
    outputs: Callable[[Reals], list[Elementwise]],
    scales: Sequence[float | None],
) -> tuple[Reals, list[Reals], Mask]:
    """Try panels: their lengths in θ, power coefficients of every quantity, and which panels are fine enough."""
    points, matrix = _chebyshev(_GROWTH_NODES)
    half = (right - left) / 2
    values: Elementwise = np.reshape(growth((left + half + half * points[:, None]).ravel()), (_GROWTH_NODES, -1))
    # Chebyshev coefficients of dθ/dχ: the last two tell whether twenty nodes resolve it
    series = matrix @ values
    good = np.max(np.abs(series[-2:]), axis=0) <= 2 * _TOLERANCE * np.abs(series[0])
    # θ on the panel, from its left edge: integrated term by term, no difference of two large angles
    integral: Reals = np.polynomial.chebyshev.chebint(series * half, lbnd=-1)
    length = np.sum(integral, axis=0)
    nodes, transform = _chebyshev(DEGREE + 1)
    goal = length * (1 + nodes[:, None]) / 2
    # the phases at which θ is at Chebyshev points: the quantities are interpolated in θ, that is in time
    s = np.clip(_local(integral, series * half, goal, nodes[:, None] + 0 * goal), -1, 1)
    tables = []
    argument = EPS * np.maximum(np.abs(left), np.abs(right)) / half
    for quantity, scale in zip(outputs((left + half + half * s).ravel()), scales, strict=True):
        rows = np.reshape(quantity, s.shape)
        middle = rows[len(rows) // 2]
        # less the middle value: a quantity that hardly varies on the panel would spend its digits on its mean
        coefficients = transform @ (rows - middle)
        # accuracy relative to the *least* value on the panel, down to the scale below which none is wanted
        size = np.max(np.abs(rows), axis=0) if scale is None else np.maximum(np.min(np.abs(rows), axis=0), scale)
        # what one rounding of the phase does to the quantity no degree can mend
        good &= np.max(np.abs(coefficients[-2:]), axis=0) <= _TOLERANCE * size + 2 * argument * np.abs(coefficients[1])
        # powers of x: Horner's rule takes one addition a term, Clenshaw's two
        powers = _to_powers(DEGREE + 1) @ _chopped(coefficients, np.max(np.abs(rows), axis=0))
        powers[0] += middle
        tables.append(powers)
    return length, tables, good


def _chopped(coefficients: Reals, size: Reals) -> Reals:
    """Chebyshev coefficients without their last ones, where these are the rounding of the samples."""
    # a coefficient stays if it or one after it is more than rounding: none is cut out of the middle
    largest = np.maximum.accumulate(np.abs(coefficients[::-1]), axis=0)[::-1]
    return np.where(largest > 1e-16 * size, coefficients, 0.0)


def _local(integral: Reals, series: Reals, goal: Reals, s: Reals) -> Reals:
    """Solve ∫ growth = goal on each panel by Newton's method in the panel's own variable."""
    for _ in range(14):
        value, slope = clenshaw(integral, s), clenshaw(series, s)
        # the integral is increasing on the panel, and nearly linear: Newton's method from the Chebyshev points settles
        # in a few steps
        step = (value - goal) / slope
        s = np.clip(s - step, -1, 1)
        if np.max(np.abs(step), initial=0) < 1e-9:
            break
    return s
