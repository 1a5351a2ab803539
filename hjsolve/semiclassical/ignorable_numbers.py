"""Which quantum numbers of ignorable coordinates have motions below an energy: not always those about m = 0.

The effective potential (``Shell.potential``) is the least energy at a place for given ignorable momenta c, and of
second degree in them: V(q; c) = V₀ + b·c + ½ c·K c. Where T holds linear terms (a magnetic flux through a ring) it is
least at c = −K⁻¹ b, far from 0; where K couples two momenta, those of low energy lie along a line.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.lowering import lower
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.tori.radicand_curve import curves_of
from hjsolve.solution.quadratures import Solution

_SAMPLES = 900
"""Places at which the effective potential is looked at, about."""
_ROUNDS, _CLOSER = 3, 33
"""How often the neighbourhood of the lowest place is looked at more closely, and at how many places along each axis."""
_MOST_SETS = 20000
"""Sets of quantum numbers that are tried, at most."""


def numbers_to_begin_with(
    solution: Solution, values: Mapping[sp.Symbol, sp.Expr], hbar: sp.Expr, limit: sp.Expr,
    chosen: Sequence[tuple[int, ...] | None],
) -> list[tuple[int, ...]]:  # fmt: skip
    """Return sets of quantum numbers of ignorable coordinates from which all with motions below an energy are reached.

    Args:
        values: parameter → exact number.
        hbar: ħ.
        limit: greatest energy.
        chosen: of each ignorable coordinate, in the system's order, the numbers wanted; None for all.
    """
    others = [c for c in solution.system.coordinates if c.name not in solution.coordinates]
    H, momenta = solution.separation.shell.potential, [c.momentum for c in others]
    first = [sp.diff(H, p) for p in momenta]
    slopes = [f.subs(dict.fromkeys(momenta, 0)) for f in first]
    curvatures = [[sp.diff(f, p) for p in momenta] for f in first]
    n = len(momenta)
    coupled = any(sp.simplify(curvatures[i][j]) != 0 for i in range(n) for j in range(i))
    found = list(itertools.product(*(choice or (0,) for choice in chosen)))
    if not coupled and all(sp.simplify(b) == 0 for b in slopes):
        return found
    formulas = [H.subs(dict.fromkeys(momenta, 0)), *slopes, *itertools.chain(*curvatures)]
    known = {**values, **{c.symbol: sp.S.Zero for c in others}, **dict.fromkeys(momenta, sp.S.Zero)}
    h = float(to_bits(hbar)(64))
    places = _Places(solution, known, formulas, n)
    return [*found, *_below(places.around_the_lowest(h), h, float(to_bits(limit)(64)), chosen)]


@dataclass(frozen=True)
class _Parabolas:
    """V(q; c) at places q: V₀ of shape (s,), b of shape (s, n), K of shape (s, n, n), and the places, shape (k, s)."""

    V: Reals
    b: Reals
    K: Reals
    places: Reals

    @property
    def middle(self) -> Reals:
        """The momenta of least energy, shape (s, n)."""
        return np.asarray(-np.linalg.solve(self.K, self.b[:, :, None])[:, :, 0], dtype=float)

    @property
    def least(self) -> Reals:
        """The least energy, shape (s,)."""
        return np.asarray(self.V + np.einsum("si,si->s", self.b, self.middle) / 2)

    def take(self, which: Mask | Integers) -> _Parabolas:
        """Return some of them.

        Args:
            which: a mask, or positions.
        """
        return _Parabolas(self.V[which], self.b[which], self.K[which], self.places[:, which])


@dataclass(frozen=True)
class _Places:
    """The formulas of V₀, b and K, in this order, and what they are functions of."""

    solution: Solution
    known: Mapping[sp.Symbol, sp.Expr]
    formulas: Sequence[sp.Expr]
    n: int

    def around_the_lowest(self, hbar: float) -> _Parabolas:
        """Look at samples of the separated coordinates, then closer and closer to the place of least energy."""
        curves = curves_of(self.solution, self.known, {}, hbar) if self.solution.coordinates else []
        most = max(2, round(_SAMPLES ** (1 / max(len(curves), 1))))
        grids = [curve.samples() for curve in curves]
        grids = [grid[np.unique(np.linspace(0, len(grid) - 1, min(most, len(grid))).astype(int))] for grid in grids]
        found = self._at(grids)
        for _ in range(_ROUNDS if grids and len(found.V) else 0):
            best = found.places[:, int(np.argmin(found.least))]
            grids = [_between_neighbours(grid, q, most) for grid, q in zip(grids, best, strict=True)]
            closer = self._at(grids)
            parts = ("V", 0), ("b", 0), ("K", 0), ("places", 1)
            found = _Parabolas(
                *(np.concatenate([getattr(found, part), getattr(closer, part)], axis=axis) for part, axis in parts)
            )
        return found

    def _at(self, grids: Sequence[Reals]) -> _Parabolas:
        places = np.array(np.meshgrid(*grids, indexing="ij")).reshape(len(grids), -1) if grids else np.zeros((0, 1))
        symbols = [self.solution.system.coordinate(name).symbol for name in self.solution.coordinates]
        fixed = {s: x for s, x in self.known.items() if s not in symbols}
        tape = lower(self.formulas, [*symbols, *fixed])
        with np.errstate(all="ignore"):
            rows = tape.run(Float64(), [*places, *(float(to_bits(x)(64)) for x in fixed.values())])
        table = np.stack([np.broadcast_to(np.asarray(row, dtype=float), places.shape[1:]) for row in rows], axis=1)
        K = table[:, 1 + self.n :].reshape(-1, self.n, self.n)
        known = np.isfinite(table).all(axis=1)
        known[known] = np.abs(np.linalg.det(K[known])) > 0
        return _Parabolas(table[known, 0], table[known, 1 : 1 + self.n], K[known], places[:, known])


def _between_neighbours(grid: Reals, q: float, most: int) -> Reals:
    k = int(np.argmin(np.abs(grid - q)))
    return np.linspace(grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)], min(most, _CLOSER))


def _below(
    seen: _Parabolas, hbar: float, limit: float, chosen: Sequence[tuple[int, ...] | None]
) -> list[tuple[int, ...]]:
    low = seen.least <= limit
    if not low.any():
        return []
    seen = seen.take(low)
    middle, room = seen.middle, limit - seen.least
    reach = np.sqrt(2 * room[:, None] * np.einsum("sii->si", np.linalg.inv(seen.K)))
    ends = np.floor(np.min((middle - reach) / hbar, axis=0)), np.ceil(np.max((middle + reach) / hbar, axis=0))
    if not np.isfinite(ends).all() or np.prod(ends[1] - ends[0] + 1) > _MOST_SETS:
        return [tuple(round(x) for x in middle[int(np.argmax(room))] / hbar)]
    choices = [c or range(int(a), int(z) + 1) for a, z, c in zip(*ends, chosen, strict=True)]
    sets = list(itertools.product(*choices))
    least = np.full(len(sets), np.inf)
    c = np.array(sets) * hbar
    for one, slope, curvature in zip(seen.V, seen.b, seen.K, strict=True):
        least = np.fmin(least, one + c @ slope + np.einsum("mi,ij,mj->m", c, curvature, c) / 2)
    return [m for m, E in zip(sets, least, strict=True) if limit >= E]
