"""A libration through kinks of V: between two kinks p² is analytic, at a kink it goes on with another formula.

The way from the lower to the upper end is cut at the kinks. Half a turn of the phase, 0 ≤ χ ≤ π, is shared out equally
among the pieces; on each q is a polynomial in the fraction y of it, so that dq/dχ has no zero but at turning points:

    turning point → kink    q = a + ℓ y²         kink → kink or wall    q = a + ℓ y
    kink → turning point    q = b − ℓ (1 − y)²

At a wall V jumps above the energy, and p changes its sign (Greenwood, item 102, has turning points only).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from hjsolve.arithmetic.floats import Float64, Multi, context_of
from hjsolve.arithmetic.number_types import Elementwise, Mpf, Numbers, Numeric, Reals
from hjsolve.one_coordinate.chebyshev_panels import Panels, integrated_row
from hjsolve.one_coordinate.kind_of_motion import Weights
from hjsolve.one_coordinate.momentum_integral import swept
from hjsolve.one_coordinate.open_branch import Branch
from hjsolve.one_coordinate.panel_series import PanelSeries
from hjsolve.one_coordinate.periodic_motion import Periodic
from hjsolve.one_coordinate.phase_map import Place, Unstretched


@dataclass(frozen=True)
class PieceMap:
    """The map of one piece.

    Attributes:
        lower, length: where it begins, and how long it is.
        turning: −1 where its lower end is a turning point, 1 where its upper end is, else 0.
    """

    lower: Mpf
    length: Mpf
    turning: int

    def distances(self, y: Numeric) -> tuple[Numeric, Numeric, Numeric]:
        """Return q − lower, upper − q and dq/dy, none by cancellation.

        Args:
            y: fraction of the phase of the piece.
        """
        # 1 − y² = z (1 + y), 1 − z² = y (1 + z): differences of squares as products
        z = 1 - y
        if self.turning < 0:
            return self.length * y * y, self.length * z * (1 + y), 2 * self.length * y
        if self.turning > 0:
            return self.length * y * (1 + z), self.length * z * z, 2 * self.length * z
        return self.length * y, self.length * z, self.length + 0 * y

    def fraction(self, q: Mpf) -> Mpf:
        """Return y of a place."""
        x = (q - self.lower) / self.length
        # |·|: a place at the end may lie beyond it by its rounding
        root: Mpf = x.context.sqrt(abs(x if self.turning < 0 else 1 - x)) if self.turning else x
        return 1 - root if self.turning > 0 else root


@dataclass(frozen=True)
class PieceByPiece(Unstretched):
    """To and fro through kinks; χ = 0 at the lower end, π at the upper one.

    Attributes:
        pieces: from the lower end upwards.
        lower, upper: the ends.
    """

    pieces: tuple[PieceMap, ...]
    lower: Mpf
    upper: Mpf

    even: ClassVar[bool] = True
    direction: ClassVar[int] = 1

    def place(self, χ: Elementwise, arithmetic: Float64 | Multi) -> Place:
        n, pi = len(self.pieces), arithmetic.pi()
        # even in χ: the way back passes the same pieces
        reduced = χ - 2 * pi * arithmetic.rint(χ / (2 * pi))
        step = pi / n
        if context_of(χ) is not None:
            k = min(int(abs(reduced) / step), n - 1)
            below, above, speed = self._within(k, (abs(reduced) - k * step) / step, step)
            sign: Elementwise = 1 if reduced >= 0 else -1
        else:
            a = np.abs(reduced)
            inside = np.clip((a / step).astype(int), 0, n - 1)
            below, above, speed = (np.choose(inside, part) for part in zip(
                *(self._within(k, (a - k * step) / step, step) for k in range(n)), strict=True))  # fmt: skip
            sign = np.where(reduced >= 0, 1.0, -1.0)
        # from the nearer end, as for every libration
        q = arithmetic.where(below < above, self.lower + below, self.upper - above)
        product = below * above
        return Place(q, sign * speed, product, abs(speed), 1, below, above)

    def _within(self, k: int, y: Elementwise, step: Elementwise) -> tuple[Elementwise, Elementwise, Elementwise]:
        """Distances from both ends and |dq/dχ| on a piece."""
        piece = self.pieces[k]
        x, left, slope = piece.distances(y)
        # only the first and the last piece touch an end: there the first difference is 0 exactly, and x keeps its
        # digits
        return piece.lower - self.lower + x, self.upper - (piece.lower + piece.length) + left, slope / step

    def phase(self, q: Mpf, forward: int, arithmetic: Multi) -> Mpf:
        """Return χ in (−π, π] of a position; ``forward`` is the sign of p, 0 at a turning point.

        Args:
            q: position between the ends.
            forward: sign of p, 0 at a turning point.
            arithmetic: in which χ is worked out.
        """
        if forward == 0:
            return arithmetic.pi() if q - self.lower > self.upper - q else 0 * q
        k = max([0, *(k for k, piece in enumerate(self.pieces) if q > piece.lower)])
        return forward * arithmetic.pi() * (k + self.pieces[k].fraction(q)) / len(self.pieces)

    def in_doubles(self) -> Self:
        return self._converted(float)

    def lowered(self, arithmetic: Multi) -> Self:
        return self._converted(arithmetic.convert)

    def _converted(self, convert: Callable[[Mpf], Any]) -> Self:
        pieces = tuple(PieceMap(convert(p.lower), convert(p.length), p.turning) for p in self.pieces)
        return type(self)(pieces, convert(self.lower), convert(self.upper))


@dataclass(frozen=True)
class KinkedLibration(Periodic):
    """A libration through kinks; ``momentum`` is the series of p/(dq/dχ) itself, not of its logarithm."""

    tabular: ClassVar[bool] = False

    @property
    def turning_points(self) -> tuple[Mpf, Mpf]:
        """Lower and upper end, turning points or walls."""
        return self.anomaly.lower, self.anomaly.upper  # type: ignore[union-attr]

    def in_doubles(self) -> KinkedLibration:
        """Return the motion itself: its series serve doubles as well."""
        return self

    def ratio(self, χ: Elementwise) -> Elementwise:
        """Return p/(dq/dχ) to full relative accuracy; χ a float array or one ``mpf``."""
        return self.momentum.value(χ)

    def weighted_rate(self, weights: Weights, χ: Reals) -> Reals:
        """Return Σ wⱼ dGⱼ/dχ."""
        found: Elementwise = sum(w * self.rate(j, χ) for j, w in enumerate(weights) if w)
        return found

    def crowding(self, χ: Reals) -> Reals:
        """Return how the rounding of χ comes out in p/(dq/dχ), relative to it."""
        h = 1e-5
        return np.abs(χ * (self.momentum.value(χ + h) - self.momentum.value(χ - h)) / (2 * h * self.momentum.value(χ)))

    def momentum_noise(self, χ: Reals) -> Reals:
        """Return the rounding of p in units of the last place: of a sum, and of χ in it."""
        return 4 * self.momentum.size / np.abs(self.momentum.value(χ)) + 4 * self.crowding(χ)


@dataclass(frozen=True)
class SmoothPiece:
    """A piece with its integrals.

    Attributes:
        branch: from the turning point, if it has one, else from the lower end; its greatest y is 1.
        map: the same way as the libration goes it.
    """

    branch: Branch
    map: PieceMap


def integrated(pieces: list[SmoothPiece], digits: int, bits: int) -> tuple[list[PanelSeries], PanelSeries, PanelSeries]:
    """Return the series of all kernels, of p/(dq/dχ), and of p dq/dχ.

    Args:
        pieces: from the lower end upwards.
        digits: to which the branches are proved.
        bits: of the results.
    """
    # y goes from 0 to 1 on each piece
    own = [piece.branch.panels(None, 1.0) for piece in pieces]
    sweeps = [swept(piece.branch, None, 1.0) for piece in pieces]
    count = len(own[0].coefficients)
    kernels = [_joined(pieces, own, j, digits, bits, -1) for j in range(count - 1)]
    return kernels, _joined(pieces, own, count - 1, digits, bits, 1), _joined(pieces, sweeps, 0, digits, bits, -1)


def _joined(pieces: list[SmoothPiece], panels: list[Panels], j: int, digits: int, bits: int, power: int) -> PanelSeries:
    """One function over half a turn: that of each piece divided by dχ/dy, or multiplied where ``power`` is 1."""
    context = Multi(bits).context
    step = context.pi / len(pieces)
    edges, rows, sums, total = [context.mpf(0)], [], [], context.mpf(0)
    for k, (piece, part) in enumerate(zip(pieces, panels, strict=True)):
        ends = [context.convert(y) for y in part.edges]
        ends[-1] = context.mpf(1)  # next to a kink at which it is not analytic the last panel ends before it
        back = piece.map.turning > 0
        order = range(len(ends) - 2, -1, -1) if back else range(len(ends) - 1)
        for m in order:
            # dχ = step dy: rates are divided by it, p/(dq/dχ) is multiplied
            row = [context.convert(c) * step**power for c in part.coefficients[j][m]]
            # Tᵢ(−x) = (−1)ⁱ Tᵢ(x): a branch that was integrated from its turning point is gone the other way
            row = [c if i % 2 == 0 else -c for i, c in enumerate(row)] if back else row
            right = 1 - ends[m] if back else ends[m + 1]
            edges.append(step * (k + right))
            integral = integrated_row(row, (edges[-1] - edges[-2]) / 2, total)
            total = context.fsum(integral)
            rows.append(row)
            sums.append(integral)
    return PanelSeries(np.array(edges, dtype=object), _table(rows), _table(sums), panels[0].nodes, digits)


def _table(rows: list[list[Mpf]]) -> Numbers:
    longest = max(map(len, rows))
    return np.array([[*row, *[0 * row[0]] * (longest - len(row))] for row in rows], dtype=object)
