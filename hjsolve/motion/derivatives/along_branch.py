r"""How the integrals of a motion that does not come back change with constants and parameters.

A branch is q(y) = a ± x(y) from its start to its end (``one_coordinate.chebyshev_panels``). A turning point a moves
with the variables, a_b = −F_b/F_q; the start of a motion that does not turn, and an end at a finite distance ℓ, are
kept. So

    q_b = a_b (1 − x/ℓ),  ω_b = (ln dq/dy)_b = ∓a_b/ℓ      (ℓ = ∞ on the way to infinity),

and with ρ_b = (F_b + F_q q_b)/(2F) the integrands (k_j)_b are those of ``along_cycle``: analytic in y wherever k_j is,
the turning point included. They are integrated as Chebyshev series on the panels of the motion (Mason & Handscomb 2003,
(2.43)), halved where the series do not fall.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np

from hjsolve.arithmetic.chebyshev import clenshaw, in_panel
from hjsolve.arithmetic.floats import Multi, multiprecision
from hjsolve.arithmetic.fourier import smooth, waves
from hjsolve.arithmetic.number_types import Context, Counts, Mpf, Numbers
from hjsolve.errors import NotConvergedError, of_kind
from hjsolve.motion.derivatives.bounded import Bounded, converted
from hjsolve.motion.derivatives.formulas import AtPlace, SquareDerivatives
from hjsolve.motion.derivatives.slopes import Slopes
from hjsolve.one_coordinate.chebyshev_panels import chebyshev_points, integrated_row
from hjsolve.one_coordinate.coordinate_motion import Unbounded
from hjsolve.one_coordinate.open_branch import Branch

_STEP = 2.0**-60
"""Of a phase, relative to it, by which the slopes of functions are measured that only serve error bounds."""
_LEAST = 80
"""At a turning point what is even in y is taken at 2^−80: its limit to 2^−160."""
_HALVINGS_OF_A_PANEL = 24  # a panel of 2⁻²⁴ of the first that does not converge stands at a singularity


@dataclass(frozen=True, eq=False)
class BranchVariations:
    """One branch with the derivatives of its integrals.

    Attributes:
        branch: of an open motion.
        formulas: of the coordinate.
        start: a_b, one a variable.
        digits: wanted of the series.
    """

    branch: Branch
    formulas: SquareDerivatives
    start: list[Mpf]
    digits: int

    @property
    def context(self) -> Context:
        """Of the numbers."""
        return multiprecision(self.branch.bits + 64)

    def at(self, y: Mpf) -> tuple[AtPlace, Mpf, Mpf, list[Mpf], list[Mpf]]:
        """Return F with its derivatives, dq/dy, √F, q_b and ρ_b at a place of the branch.

        Args:
            y: place on the branch, y > 0.
        """
        end_map, branch = self.branch.end_map, self.branch
        x, left, _ = end_map.distances(y, Multi(64))
        # next to an end F cancels, its derivatives more so: six times the bits by which the place is near it are added
        nearest = min(v for v in (x, left) if v is not None)
        lost = max(0.0, -float(Multi(64).context.log(nearest / end_map.length, 2))) if nearest < end_map.length else 0.0
        work = 64 * (2 + (branch.bits + branch.radicand.guard + 6 * int(lost)) // 64)
        q, slope = end_map.position(y, Multi(work))
        at = _rule(self.formulas, work).at(cast("Mpf", q))
        moved, _ = self.moved(y, work)
        # ρ_b = (ln √F)_b along the moving place, F_b + F_q q_b; it stays finite at a turning point, where both vanish
        growth = [(by + at.slope * m) / (2 * at.value) for by, m in zip(at.by, moved, strict=True)]
        return at, cast("Mpf", slope), at.value**0.5, moved, growth

    def moved(self, y: Mpf, bits: int) -> tuple[list[Mpf], list[Mpf]]:
        """Return q_b and ω_b at a place of the branch.

        Args:
            y: place on the branch.
        """
        end_map = self.branch.end_map
        _, left, _ = end_map.distances(y, Multi(bits))
        if left is None:
            return self.start, [0 * a for a in self.start]
        return [a * left / end_map.length for a in self.start], [-end_map.side * a / end_map.length for a in self.start]

    def integrands(self, y: Mpf) -> tuple[list[Mpf], list[float]]:
        """Return (k_j)_b with b inside j, and the sizes of what they are sums of.

        Args:
            y: place on the branch, y > 0.
        """
        at, slope, root, moved, growth = self.at(y)
        _, stretched = self.moved(y, self.branch.bits)
        weight, values, sizes = abs(slope) / root / 2, [], []
        for j, row in enumerate(at.mixed):
            for b, mixed in enumerate(row):
                # (k_j)_b of k_j = F_j/(2√F) dq/dy: F_jb + F_jq q_b + F_j (ω_b − ρ_b), times dq/(2√F dy)
                terms = (mixed, at.slope_by[j] * moved[b], at.by[j] * stretched[b], -at.by[j] * growth[b])
                values.append(sum(terms) * weight)
                scale = abs(at.by[j] * self.start[b] / self.branch.end_map.length)  # what cancels in ρ_b is no smaller
                sizes.append(float((sum(map(abs, terms)) + scale) * weight))
        return values, sizes

    def integral(self, y: Mpf) -> tuple[list[Mpf], list[float]]:
        """Return ∫ (k_j)_b dy from 0 to y, and bounds on their errors.

        Args:
            y: place on the branch, y ≥ 0.
        """
        context, count = self.context, len(self.formulas.variables.constants) * len(self.start)
        totals, errors = [context.mpf(0)] * count, [0.0] * count
        if not y:
            return totals, errors
        panels = self.branch.panels(None, max(1.0, float(y) * (1 + 2.0**-40)))
        edges = [context.convert(edge) for edge in panels.edges]
        degree = panels.coefficients.shape[-1]
        # the last panel goes on to y: the panels of the motion end where its own series were asked for
        for left, right in zip(edges, [*edges[1:-1], max(edges[-1], y)], strict=False):
            if left >= y:
                break
            for piece in _resolved(self, left, right, degree, 0):
                if piece.left < y:
                    position = in_panel(min(y, piece.right), piece.left, piece.right)
                    for k, (row, lack) in enumerate(zip(piece.rows, piece.lacks, strict=True)):
                        totals[k] += clenshaw(row, position)
                        errors[k] += lack
        return totals, errors


@dataclass(frozen=True, eq=False)
class _Piece:
    """Integrals from the left end of a panel as Chebyshev series, and what they lack."""

    left: Mpf
    right: Mpf
    rows: list[list[Mpf]]
    lacks: list[float]


@lru_cache(maxsize=1024)
def _rule(formulas: SquareDerivatives, bits: int):  # type: ignore[no-untyped-def]
    return formulas.bound(bits)


@lru_cache(maxsize=512)
def _resolved(variations: BranchVariations, left: Mpf, right: Mpf, degree: int, depth: int) -> tuple[_Piece, ...]:
    """Return a panel, halved as long as its series do not fall.

    Raises:
        NotConvergedError: they never do.
    """
    context, points = variations.context, chebyshev_points(smooth(degree + 8), variations.context.prec)
    found = [variations.integrands(left + (right - left) * (1 + x) / 2) for x in points]
    rows, lacks = [], []
    for k in range(len(found[0][0])):
        values = [context.convert(v[k]) for v, _ in found]
        largest = max(s[k] for _, s in found)
        terms = waves(values, even=True, bits=context.prec)[0] if any(values) else [context.mpf(0)] * (len(points) - 1)
        row = [context.fsum(values) / len(points), *terms]
        # three, not one: the last coefficient of a function even in x is zero whatever the others are
        lack = float(max(abs(c) for c in row[-3:])) / (largest or 1.0)
        if lack > 10.0 ** (4 - variations.digits):
            if depth == _HALVINGS_OF_A_PANEL:
                raise NotConvergedError("the derivatives of the integrals of an open motion did not converge")
            middle = (left + right) / 2
            halves = ((left, middle), (middle, right))
            return tuple(p for low, high in halves for p in _resolved(variations, low, high, degree, depth + 1))
        rows.append(integrated_row(row, (right - left) / 2, context.mpf(0)))
        lacks.append(8 * max(lack, 10.0**-variations.digits) * largest * float(right - left))
    return (_Piece(left, right, rows, lacks),)


@dataclass(frozen=True, eq=False)
class OpenVariations:
    """A motion that does not come back, with the derivatives of its integrals.

    Attributes:
        coordinate_motion: the motion of the coordinate.
        ahead, behind: its branches.
    """

    coordinate_motion: Unbounded
    ahead: BranchVariations
    behind: BranchVariations

    rests = False

    @property
    def context(self) -> Context:
        """Of the numbers."""
        return self.ahead.context

    def slopes(self, χ: Numbers, whole: Counts, errors: Numbers) -> Slopes:  # noqa: ARG002
        """Return how place, momentum and integrals change with the phase and with the variables.

        Args:
            χ: phases, shape (m,).
            whole: zeros; there are no turns.
            errors: bounds on the errors of χ, shape (m,).
        """
        context = self.context
        χ = converted(χ, context)
        step = context.mpf(_STEP)
        here, beside = self._functions(χ), self._functions(χ + step)
        return here.with_phase_errors(beside, errors.astype(float), _STEP)

    def _functions(self, χ: Numbers) -> Slopes:
        columns = [self._one(x) for x in χ]
        parts = []
        for k in range(len(Slopes._fields)):
            values = np.empty((*columns[0][k].value.shape, len(columns)), dtype=object)
            errors = np.empty(values.shape)
            for m, column in enumerate(columns):
                values[..., m], errors[..., m] = column[k].value, column[k].error
            parts.append(Bounded(converted(values, self.context), errors))
        return Slopes(*parts)

    def _one(self, χ: Mpf) -> Slopes:
        own, sign = (self.ahead, 1) if χ >= 0 else (self.behind, -1)
        y, end_map = abs(χ), own.branch.end_map
        # at a turning point F = dq/dy = 0 and each formula below is 0/0; all of them are even in y there
        regular = max(y, self.context.ldexp(1, -_LEAST)) if end_map.turning else y
        if not regular:
            regular = self.context.ldexp(1, -4 * self.context.prec)
        at, slope, root, moved, growth = own.at(regular)
        # p/(dq/dy) is finite at a turning point, where p and dq/dy vanish together: P from it is exact there
        ratio = root / abs(slope)
        now = sign * cast("Mpf", end_map.position(y, Multi(self.context.prec))[1])
        P = now * ratio
        integrals, lacks = own.integral(y)
        n, count = len(at.mixed), len(moved)
        G = np.array([sign * g for g in integrals], dtype=object).reshape(n, count)
        exact = [
            np.array(now, dtype=object), np.array(at.slope / ratio / 2, dtype=object),
            np.array([by / ratio / 2 for by in at.by[:n]], dtype=object), np.array(moved, dtype=object),
            np.array([P * g for g in growth], dtype=object),
        ]  # fmt: skip
        found = [*(Bounded.exact(v) for v in exact), Bounded(G, np.array(lacks).reshape(n, count))]
        return Slopes(*found)


def open_variations(coordinate_motion: Unbounded, formulas: SquareDerivatives, digits: int) -> OpenVariations:
    """Differentiate the integrals of a motion that does not come back.

    Args:
        coordinate_motion: integrated to many digits, without kinks.
        formulas: of its coordinate.
        digits: wanted of the series.
    """
    ahead, behind = (
        _branch_variations(of_kind(branch, Branch), formulas, digits)
        for branch in (coordinate_motion.ahead, coordinate_motion.behind)
    )
    return OpenVariations(coordinate_motion, ahead, behind)


def _branch_variations(branch: Branch, formulas: SquareDerivatives, digits: int) -> BranchVariations:
    bits = branch.bits + 512 + branch.radicand.guard
    start = [multiprecision(bits).mpf(0)] * formulas.variables.count
    if branch.end_map.turning:
        at = formulas.bound(bits).at(branch.end_map.start)
        # F(a(z); z) = 0 stays true: F_b + F_q a_b = 0
        start = [-by / at.slope for by in at.by]
    return BranchVariations(branch, formulas, start, digits)
