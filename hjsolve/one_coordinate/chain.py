"""A branch of an open motion through kinks: branches one after the other, each as long as p² is analytic.

The parameter y of a chain runs through its parts, from k to k + 1 in the k-th; the last part goes on to the end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from hjsolve.arithmetic.floats import Float64, Multi, context_of
from hjsolve.arithmetic.number_types import Context, Elementwise, Mpf, Numbers, Numeric
from hjsolve.one_coordinate.chebyshev_panels import EndMap, Panels
from hjsolve.one_coordinate.momentum_integral import swept
from hjsolve.one_coordinate.open_branch import Branch
from hjsolve.one_coordinate.turning_points import EndKind


@dataclass(frozen=True)
class ChainMap:
    """The map q(y) of a chain; it answers what ``EndMap`` answers.

    Attributes:
        maps: of the parts, in their order.
        thrown_back: whether it begins at a wall.
    """

    maps: tuple[EndMap, ...]
    thrown_back: bool

    @property
    def turning(self) -> bool:
        """True where the motion turns at the beginning, at a turning point or a wall."""
        return self.thrown_back or self.maps[0].turning

    @property
    def end(self) -> EndKind:
        """How it ends."""
        return self.maps[-1].end

    @property
    def start(self) -> Mpf:
        """The place at y = 0."""
        return self.maps[0].start

    @property
    def side(self) -> int:
        """+1 where q grows with y."""
        return self.maps[0].side

    @property
    def length(self) -> Mpf:
        """The distance to the end; for infinity that of the kinks and the natural length beyond."""
        total: Mpf = sum(part.length for part in self.maps)  # type: ignore[assignment]
        return total

    def last(self, context: Context) -> Mpf | None:
        """Return the greatest y, None where there is none."""
        last = self.maps[-1].last(context)
        # each part but the last takes one unit of y
        return None if last is None else len(self.maps) - 1 + last

    def in_doubles(self) -> ChainMap:
        """Return the same with its constants rounded to doubles."""
        return ChainMap(tuple(part.in_doubles() for part in self.maps), self.thrown_back)

    def rest(self, y: Numeric, arithmetic: Float64 | Multi) -> Numeric | int:
        """Return what |p|/|dq/dy| is multiplied by to stay finite."""
        return self._of_part(y, lambda part, z: (part.rest(z, arithmetic) + 0 * z,))[0]

    def distances(self, y: Numeric, arithmetic: Float64 | Multi) -> tuple[Numeric, Numeric | None, Numeric]:
        """Return x, the distance left to the end (None for infinity) and dx/dy."""
        ahead: dict[EndMap, tuple[Elementwise, Elementwise]] = {}
        for k, part in enumerate(self.maps):
            ahead[part] = (sum(p.length for p in self.maps[:k]), sum(p.length for p in self.maps[k + 1 :]))

        def at(part: EndMap, z: Elementwise) -> tuple[Elementwise, ...]:
            x, left, slope = part.distances(z, arithmetic)
            before, after = ahead[part]
            # distances add up over parts; the one to the end of the last part keeps its relative digits
            return before + x, after + (part.length - x if left is None else left), slope

        x, left, slope = self._of_part(y, at)
        return x, None if self.end == "infinity" else left, slope

    def position(self, y: Numeric, arithmetic: Float64 | Multi) -> tuple[Numeric, Numeric]:
        """Return q and dq/dy at y ≥ 0."""
        q, slope = self._of_part(y, lambda part, z: part.position(z, arithmetic))
        return q, slope

    def parameter(self, q: Mpf) -> Mpf | None:
        """Return y of a place; None where the chain does not pass it."""
        for k, part in enumerate(self.maps):
            y = part.parameter(q)
            # a kink belongs to the part that ends there
            if y is not None and (k == len(self.maps) - 1 or y <= 1):
                return k + y
        return None

    def _of_part(
        self, y: Elementwise, answer: Callable[[EndMap, Elementwise], tuple[Elementwise, ...]]
    ) -> tuple[Elementwise, ...]:
        """Return what the part to which y belongs answers."""
        last = len(self.maps) - 1
        if context_of(y) is not None or not np.ndim(y):
            k = min(int(y), last)
            return tuple(answer(self.maps[k], y - k))
        inside = np.clip(np.asarray(y).astype(int), 0, last)
        found = [
            answer(part, np.clip(y - k, 0, 1) if k < last else np.maximum(y - k, 0)) for k, part in enumerate(self.maps)
        ]
        return tuple(np.choose(inside, rows) for rows in zip(*found, strict=True))


@dataclass(frozen=True, eq=False)
class Chain:
    """Branches one after the other; it answers what ``Branch`` answers.

    Attributes:
        parts: the branches.
        thrown_back: whether it begins at a wall.
    """

    parts: tuple[Branch, ...]
    thrown_back: bool = False

    tabular = False

    @property
    def end_map(self) -> ChainMap:
        """The map q(y)."""
        return ChainMap(tuple(part.end_map for part in self.parts), self.thrown_back)

    @property
    def digits(self) -> int:
        """Decimal digits asked."""
        return self.parts[0].digits

    def carries(self, j: int) -> bool:
        """Return False where a kernel is zero all along."""
        return self.parts[0].carries(j)

    def panels(self, weights: tuple[float, ...] | None, amount: float, *, partly: bool = False) -> Panels:
        """Return the integrals over all parts, over the last one so far that |Σ wⱼ Gⱼ| reaches ``amount`` there."""
        return _joined(self, weights, amount, partly, False)

    def swept(self, weights: tuple[float, ...] | None, amount: float) -> Panels:
        """Return panels of |P dq/dy| that reach as far."""
        return _joined(self, weights, amount, False, True)


@lru_cache(maxsize=32)
def _joined(
    chain: Chain, weights: tuple[float, ...] | None, amount: float, partly: bool, momentum: bool
) -> Panels:  # fmt: skip
    tables: list[Panels] = []
    for k, part in enumerate(chain.parts):
        final = k == len(chain.parts) - 1
        asked = (weights, amount) if final else (None, 1.0)
        tables.append(swept(part, *asked) if momentum else part.panels(*asked, partly=partly and final))
    edges: list[Any] = [tables[0].edges[:1]]
    coefficients, sums = [], []
    before: Elementwise = 0
    for k, table in enumerate(tables):
        own = table.edges[1:].copy()
        if k < len(tables) - 1:
            # panels end just before a kink at which p² is not analytic: the gap is closed, and the last polynomial goes
            # on over it
            own[-1] = own[-1] * 0 + 1
        edges.append(own + k)
        added = table.sums.copy()
        # the integral is continuous through a kink: the next part begins with what the last one ended with
        added[:, :, 0] = added[:, :, 0] + (before[:, None] if k else 0)
        coefficients.append(table.coefficients)
        sums.append(added)
        # the value of a Chebyshev series at x = 1 is the sum of its coefficients
        before = np.sum(added[:, -1, :], axis=-1)
    return Panels(
        np.concatenate(edges), _padded(coefficients), _padded(sums), max(t.nodes for t in tables), tables[-1].finished
    )


def _padded(tables: list[Numbers]) -> Numbers:
    longest = max(t.shape[2] for t in tables)
    wide = [np.concatenate([t, np.zeros((*t.shape[:2], longest - t.shape[2]), dtype=t.dtype)], axis=2) for t in tables]
    return np.concatenate(wide, axis=1)
