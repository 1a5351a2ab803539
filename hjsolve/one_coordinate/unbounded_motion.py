"""The motion of one coordinate that does not come back: escape, asymptotic, or to an end of the domain.

Gⱼ(χ) = ± ∫₀^|χ| kⱼ |dq/dy|/|p| dy along the branch ahead for χ ≥ 0 and along that behind for χ < 0, from Chebyshev
series on panels (``chebyshev_panels``). Where the motion turns at χ = 0 both are one branch, gone to and fro.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, cast

import numpy as np

from hjsolve.arithmetic.error_free import Pair, moved, split
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Elementwise, Mask, Mpf, Numbers, Reals
from hjsolve.arithmetic.work_counter import count
from hjsolve.one_coordinate.chain import Chain
from hjsolve.one_coordinate.chebyshev_panels import Panels
from hjsolve.one_coordinate.kind_of_motion import Kind, KindOfMotion, Weights, arithmetic_of, elementwise
from hjsolve.one_coordinate.open_branch import Branch


@dataclass(frozen=True, eq=False)
class Unbounded(KindOfMotion):
    """Escape, asymptotic motion, or motion to an end of the domain.

    Attributes:
        kind: escape, asymptotic or boundary.
        ahead: branch of the motion for χ ≥ 0.
        behind: branch for χ ≤ 0, run backwards; the same branch where the motion turns at χ = 0.
        start: χ of the initial place.
        reach: how far the panels go: (weights, amount of the weighted sum of integrals), or (None, greatest phase).
        back: the amount for the branch behind, where it is another; None for the same.
        partly: True where panels that do not reach so far will do, as far as they can be computed.
    """

    kind: Kind
    ahead: Branch | Chain
    behind: Branch | Chain
    start: Mpf
    reach: tuple[tuple[float, ...] | None, float] = (None, 1.0)
    back: float | None = None
    partly: bool = False

    action = None
    stable = True
    cycle: ClassVar[None] = None
    bounded: ClassVar[None] = None

    @property
    def branches(self) -> tuple[Branch | Chain, Branch | Chain]:
        """Ahead and behind."""
        return self.ahead, self.behind

    @property
    def both_directions(self) -> bool:
        """False where the motion turns at χ = 0."""
        return self.behind is not self.ahead

    def _sides(self, χ: Numbers) -> tuple[Mask, Panels, Panels]:
        weights, amount = self.reach
        ahead = self.ahead.panels(weights, amount, partly=self.partly)
        if not self.both_directions:
            return χ >= 0, ahead, ahead
        back = amount if self.back is None else self.back
        return χ >= 0, ahead, self.behind.panels(weights, back, partly=self.partly)

    def finished(self, side: int) -> bool:
        branch = self.branches[side < 0]
        return branch.end_map.end == "fall" or branch.panels(*self.reach, partly=self.partly).finished

    def covering(self, χ: Numbers) -> Unbounded:
        if not self.both_directions:
            return self.with_reach(float(np.max(np.abs(χ), initial=0)))
        return self.with_reach(float(np.max(χ, initial=0)), float(np.max(-χ, initial=0)))

    def with_reach(self, ahead: float, back: float | None = None) -> Unbounded:
        least = max(1.0, abs(float(self.start)))
        behind = None if back is None else max(least, back)
        return replace(self, reach=(None, max(least, ahead)), back=behind, partly=False)

    def with_amount(self, weights: Weights | None, amount: float, *, partly: bool = False) -> Unbounded:
        """Return the motion with panels as far as |Σ wⱼ Gⱼ| reaches an amount.

        Args:
            weights: wⱼ, one a constant; None where the phase itself is meant.
            amount: how far.
            partly: True where panels that do not reach so far will do.
        """
        return replace(self, reach=(weights, amount), back=None, partly=partly)

    def carries(self, j: int) -> bool:
        """Return False where the integral for a constant is zero all along."""
        return self.ahead.carries(j)

    def on_sides(self, *, ahead: bool, back: bool) -> Unbounded:
        """Return the motion with panels on those sides only.

        Args:
            ahead, back: False where there are no phases.
        """
        weights, amount = self.reach
        return replace(self, reach=(weights, amount if ahead else 1e-290), back=amount if back else 1e-290)

    def probes(self) -> Reals:
        """Return phases in all panels, and that of the start."""
        edges = self.edges()
        return np.concatenate([(edges[1:] + edges[:-1]) / 2, [float(self.start)]])

    def stations(self, side: int) -> Reals:
        """Return the ends of the panels outward, and doublings beyond where the motion goes on for ever."""
        start = float(self.start)
        edges, limit = self.edges(), self.limits()[side > 0]
        beyond = edges[edges > start] if side > 0 else edges[edges < start][::-1]
        places = np.concatenate([[start], beyond])
        # beyond the last panel the integrals go on evenly: doublings reach any time in sixty steps
        doublings = 2.0 ** np.arange(-2, 61)
        return places if np.isfinite(limit) else np.concatenate([places, places[-1] + side * doublings])

    def rounding_size(self, weights: Weights, χ: Reals) -> Reals:
        """Return what the rounding of Σ wⱼ Gⱼ(χ) is relative to: the greatest value of a panel's series."""
        used = [(j, abs(w)) for j, w in enumerate(weights) if w]
        edges = self.edges()
        # a panel's series is rounded like its greatest value, which is at one of its ends as integrals grow
        summed: Elementwise = sum(w * np.abs(self.integral(j, edges)) for j, w in used)
        position = np.clip(np.searchsorted(edges, χ) - 1, 0, len(edges) - 2)
        tail = sum(w * np.abs(self.integral(j, χ)) for j, w in used)
        return np.maximum(np.maximum(summed[position], summed[position + 1]), tail)

    def momentum_integral(self, χ: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        weights, amount = self.reach
        back = amount if self.back is None or not self.both_directions else self.back
        ahead, behind = self.ahead.swept(weights, amount), self.behind.swept(weights, back)
        forward, y = χ >= 0, np.abs(χ)
        # both branches run outward from χ = 0: behind it the integral is negative
        values = np.where(forward, ahead.integral(0, y), -behind.integral(0, y))
        slopes: Numbers = np.abs(np.where(forward, ahead.value(0, y), behind.value(0, y)))
        beyond = np.where(forward, y > ahead.edges[-1], y > behind.edges[-1])
        # past the last panel W is not known; it is not continued as phases are
        values = np.where(beyond, np.nan, values) if beyond.any() else values
        return values, slopes, np.where(forward, ahead.spacing(0, y), behind.spacing(0, y))

    def place_in_two_doubles(self, χ: Reals, approximate: Reals) -> Pair:  # noqa: ARG002
        """Return start or end of a branch and the distance from it."""
        pairs = []
        for branch in self.branches:
            end_map = branch.end_map.in_doubles()
            x, left, _ = cast("tuple[Elementwise, Elementwise, Elementwise]", end_map.distances(np.abs(χ), Float64()))
            start, end = (
                split(branch.end_map.start),
                split(branch.end_map.start + branch.end_map.side * branch.end_map.length),
            )
            # the exact start and the distance from it: near the start the place has more digits than a double
            from_start = moved(Pair(start.high + 0 * χ, start.low + 0 * χ), end_map.side * x)
            if left is None:
                pairs.append(from_start)
                continue
            from_end = moved(Pair(end.high + 0 * χ, end.low + 0 * χ), -end_map.side * left)
            # counted from the nearer end of the branch
            pairs.append(Pair(*(np.where(left < x, e, s) for s, e in zip(from_start, from_end, strict=True))))
        ahead, behind = pairs
        return Pair(*(np.where(χ >= 0, a, b) for a, b in zip(ahead, behind, strict=True)))

    def place_spacing(self, χ: Reals) -> Reals:
        """Return the size that the rounding of a place in two doubles refers to: its distance from the start."""
        return np.abs(cast("Reals", self.place(χ)[0]) - float(self.ahead.end_map.start))

    def integral(self, j: int, χ: Numbers) -> Numbers:
        forward, ahead, behind = self._sides(χ)
        return np.where(forward, ahead.integral(j, np.abs(χ)), -behind.integral(j, np.abs(χ)))

    def spacing(self, j: int, χ: Numbers) -> Reals:
        """Return the size that the rounding of an integral in doubles refers to."""
        forward, ahead, behind = self._sides(χ)
        return np.where(forward, ahead.spacing(j, np.abs(χ)), behind.spacing(j, np.abs(χ)))

    def rate(self, j: int, χ: Numbers) -> Numbers:
        forward, ahead, behind = self._sides(χ)
        return np.where(forward, ahead.value(j, np.abs(χ)), behind.value(j, np.abs(χ)))

    def edges(self) -> Reals:
        """Return the phases at all panel ends, increasing."""
        _, ahead, behind = self._sides(np.zeros(1))
        return np.concatenate([-behind.edges[:0:-1], ahead.edges]).astype(float)

    def rate_sum(self, weights: tuple[float, ...], χ: Reals) -> Reals:
        """Return Σ wⱼ dGⱼ/dχ.

        Args:
            weights: wⱼ, one a constant.
            χ: phases, shape (m,).
        """
        return cast("Reals", sum(w * self.rate(j, χ) for j, w in enumerate(weights) if w))

    def limits(self) -> tuple[float, float]:
        """Return the least and greatest phase the panels hold; infinite along an asymptote, whose tail is known.

        Not where it is reached in a finite time all the same, at a place where the kinetic energy vanishes.
        """
        _, ahead, behind = self._sides(np.zeros(1))
        ends = [
            np.inf if b.end_map.end == "asymptote" and not self._settled(p) else float(p.edges[-1])
            for b, p in ((self.behind, behind), (self.ahead, ahead))
        ]
        return -ends[0], ends[1]

    def _settled(self, panels: Panels) -> bool:
        """Return True where the time that the panels were made for no longer grows with the phase."""
        weights, _ = self.reach
        if weights is None or not any(weights):
            return False
        last = np.array([float(panels.edges[-1])])
        rate, total = (
            abs(sum(w * float(part(j, last)[0]) for j, w in enumerate(weights) if w))
            for part in (panels.value, panels.integral)
        )
        return bool(last[0] * rate <= 10.0**-self.ahead.digits * total)

    def place(self, χ: Numbers) -> tuple[Numbers, Numbers]:
        """Return q and the shell momentum at χ."""
        count(places=χ.size)
        forward, ahead, behind = self._sides(χ)
        (q1, p1), (q2, p2) = self._on(self.ahead, ahead, χ, 1), self._on(self.behind, behind, χ, -1)
        return np.where(forward, q1, q2), np.where(forward, p1, p2)

    def _on(self, branch: Branch | Chain, panels: Panels, χ: Numbers, sign: int) -> tuple[Numbers, Numbers]:
        y, arithmetic = np.abs(χ), arithmetic_of(χ)
        end_map = branch.end_map if χ.dtype == object else branch.end_map.in_doubles()
        q, slope = elementwise(lambda v: end_map.position(v, arithmetic), y, 2)
        return q, sign * slope * panels.value(-1, y) / elementwise(lambda v: end_map.rest(v, arithmetic), y, 1)
