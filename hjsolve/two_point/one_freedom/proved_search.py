"""All energies at which one coordinate goes from one place to another in a time, isolated by enclosures.

Energies are E = V* + s², V* the greatest V on the way between the places. Intervals of s are discarded where the time
cannot be the one asked, kept where it is monotone and passes it, and halved else; energies beyond the last interval are
discarded by bounds that hold for all of them (``high_energies.py``).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from hjsolve.algebra.time_limit import out_of_time
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.interval import Interval
from hjsolve.arithmetic.root_finding import interpolated_root
from hjsolve.two_point.one_freedom.high_energies import HIGHEST, far_time
from hjsolve.two_point.one_freedom.line_branches import LineBranch
from hjsolve.two_point.one_freedom.travel_time import Line, Segment, across, outward

_COARSE, _FINE, _FINEST = 96, 384, 1536
_SMALLEST = 2.0**-22
_DOUBLINGS = 60
_CELLS_AT_MOST = 4000
_WIDER = (0.0, *(4.0**k for k in range(20)))
"""How much wider, in its own width, an interval is made that halving does not decide."""


@dataclass(frozen=True)
class IsolatedEnergy:
    """An energy at which a branch takes the time asked.

    Attributes:
        branch: the branch.
        value: E in doubles, near the true one.
        low, high: an interval that holds this one alone.
    """

    branch: LineBranch
    value: float
    low: float
    high: float


@dataclass
class EnergyProof:
    """What was isolated, and what was not decided.

    Attributes:
        energies: the energies found.
        undecided: intervals of E in which there may be more.
        least: the least time of the branches asked, as far as sampled; inf where there is none.
        faster: whether some branch takes less than the time asked.
        ended: whether the time ended it.
    """

    energies: list[IsolatedEnergy] = field(default_factory=list)
    undecided: list[tuple[float, float]] = field(default_factory=list)
    least: float = np.inf
    faster: bool = False
    ended: bool = False


class TravelTimes:
    """Times of one pair of places as functions of s, enclosed.

    Attributes:
        line: V and μ.
        low, high: the lower and the upper place.
        base: V*, rounded up.
    """

    def __init__(self, line: Line, low: float, high: float):
        self.line, self.low, self.high = line, low, high
        nodes = np.unique(np.concatenate([np.linspace(low, high, 4000), [low, high]]))
        V = line.over(nodes, nodes, 1)[0]
        k = int(np.argmax(V.high))
        # at the ends themselves E may not be less than V; inside, a barrier is approached from below
        self.base = float(V.high[k]) if k in (0, len(nodes) - 1) else float(V.low[k])
        self._known: dict[tuple[float, float, int], tuple[Segment, Segment, Segment]] = {}

    def energy(self, s: float) -> float:
        """Return E of s.

        Args:
            s: not negative.
        """
        return self.base + s * s

    def segments(self, s: tuple[float, float], count: int) -> tuple[Segment, Segment, Segment]:
        """Return D, U and L over an interval of s.

        Args:
            s: its ends.
            count: of cells.
        """
        key = (*s, count)
        if key not in self._known:
            E = Interval(self.energy(s[0]), self.energy(s[1]) * (1 + 2 * EPS) if s[1] > s[0] else self.energy(s[0]))
            self._known[key] = (
                across(self.line, self.low, self.high, E, count),
                outward(self.line, self.high, 1, E, count),
                outward(self.line, self.low, -1, E, count),
            )
        return self._known[key]

    def far(self, s: float) -> tuple[Segment, Segment, Segment]:
        """Return D, U and L over all energies from one on.

        Args:
            s: of the least energy.
        """
        E = self.energy(s)
        return (
            across(self.line, self.low, self.high, Interval(E, HIGHEST), _FINE),
            far_time(self.line, self.high, 1, E),
            far_time(self.line, self.low, -1, E),
        )


def total(branch: LineBranch, parts: tuple[Segment, Segment, Segment]) -> tuple[Interval, Interval, bool | None]:
    """Return time and slope of a branch; and whether it exists: for all of the energies, none of them, or undecided.

    Args:
        branch: the branch.
        parts: D, U and L.
    """
    counts = (branch.direct, 2 * branch.upper, 2 * branch.lower)
    low = high = slope_low = slope_high = 0.0
    there: bool | None = True
    for n, part, turned in zip(counts, parts, (False, True, True), strict=True):
        if not n:
            continue
        if turned and part.turns is not True:
            there = False if part.turns is False or there is False else None
        low, high = low + n * part.time.low, high + n * part.time.high
        slope_low, slope_high = slope_low + n * part.slope.low, slope_high + n * part.slope.high
    return Interval(low, high), Interval(slope_low, slope_high), there


def isolate(times: TravelTimes, branch: LineBranch, T: float, scale: float, proof: EnergyProof) -> None:
    """Find every energy at which a branch takes a time; what is found is added to a proof.

    Args:
        times: of the places.
        branch: the branch.
        T: the time.
        scale: a speed in units of s that the search begins with.
        proof: filled here.
    """
    top = _top(times, branch, T, scale, proof)
    if top is None:
        top = scale * 2.0**_DOUBLINGS**0.5
        proof.undecided.append((times.energy(top), np.inf))
    edges = [0.0, *(scale * 2.0**k for k in range(-34, 200) if scale * 2.0**k < top), top]
    stack, open_ = list(pairwise(edges)), list[tuple[float, float]]()
    for _ in range(_CELLS_AT_MOST):
        if not stack or out_of_time():
            break
        s = stack.pop()
        if _judged(times, branch, T, s, proof) == "split":
            if s[1] - s[0] <= _SMALLEST * max(s[1], scale):
                open_.append(s)
                continue
            middle = (s[0] + s[1]) / 2
            stack += [(s[0], middle), (middle, s[1])]
    for s in _joined(open_ + stack):
        if out_of_time() or not _decided_wider(times, branch, T, s, proof):
            proof.undecided.append((times.energy(s[0]), times.energy(s[1])))


def _joined(intervals: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the unions of intervals that touch."""
    found = list[tuple[float, float]]()
    for low, high in sorted(intervals):
        if found and low <= found[-1][1]:
            found[-1] = found[-1][0], max(found[-1][1], high)
        else:
            found.append((low, high))
    return found


def _decided_wider(
    times: TravelTimes, branch: LineBranch, T: float, s: tuple[float, float], proof: EnergyProof
) -> bool:
    """Decide an interval that halving came down to, with finer enclosures.

    Where an end of the halves fell on an energy that is sought, a wider interval has ends at which the time differs
    from T by more than its enclosure.
    """
    for times_wider in _WIDER:
        more = times_wider * (s[1] - s[0])
        wide = max(s[0] - more, 0.0), s[1] + more
        low, high = (times.energy(x) for x in wide)
        if any(e.branch == branch and e.low < high and low < e.high for e in proof.energies):
            return False
        if _judged(times, branch, T, wide, proof, (_FINE, _FINEST)) != "split":
            return True
    return False


def _judged(
    times: TravelTimes, branch: LineBranch, T: float, s: tuple[float, float], proof: EnergyProof,
    counts: tuple[int, ...] = (_COARSE, _FINE),
) -> str:  # fmt: skip
    """Discard an interval, keep its one energy, or ask to split it."""
    for count in counts:
        time, slope, there = total(branch, times.segments(s, count))
        if there is False or time.low > T:
            if there is not False and np.isfinite(time.low):
                proof.least = min(proof.least, time.low)
            return "none"
        if there and time.high < T:
            proof.faster = True
            return "none"
        if there and (slope.low > 0 or slope.high < 0):
            return _at_most_one(times, branch, T, s, proof)
    return "split"


def _at_most_one(times: TravelTimes, branch: LineBranch, T: float, s: tuple[float, float], proof: EnergyProof) -> str:
    """Return an interval in which the time is monotone: it is T once, or never."""
    ends = [_side(times, branch, T, at) for at in s]
    if ends[0] and ends[0] == ends[1]:
        return "none"
    if ends[0] and ends[1]:
        sign = ends[0]

        def miss(at: float) -> float:
            time, _, there = total(branch, times.segments((at, at), _FINEST))
            return -sign * ((time.low + time.high) / 2 - T) if there and np.isfinite(time.high) else -np.inf

        values = miss(s[0]), miss(s[1])
        at = interpolated_root(miss, s, values, width=EPS) if values[0] <= 0 <= values[1] else (s[0] + s[1]) / 2
        proof.energies.append(IsolatedEnergy(branch, times.energy(at), times.energy(s[0]), times.energy(s[1])))
        return "one"
    return "split"


def _side(times: TravelTimes, branch: LineBranch, T: float, at: float) -> int:
    """Return the sign of time − T at one energy; 0 where enclosures do not tell it."""
    for count in (_FINE, _FINEST):
        time, _, there = total(branch, times.segments((at, at), count))
        if time.low > T:
            return 1
        if there and time.high < T:
            return -1
    return 0


def _top(times: TravelTimes, branch: LineBranch, T: float, scale: float, proof: EnergyProof) -> float | None:
    """Return an s beyond which the branch does not take the time, proved; None where there is no proof."""
    s = scale
    for _ in range(_DOUBLINGS // 2):
        time, _, there = total(branch, times.far(s))
        if there is False or time.low > T:
            return s
        if there and time.high < T:
            proof.faster = True
            return s
        s *= 2
    return None


def all_energies(times: TravelTimes, asked: Iterable[LineBranch], T: float, scale: float) -> EnergyProof:
    """Find all energies at which any of some branches takes a time.

    Args:
        times: of the places.
        asked: the branches.
        T: the time.
        scale: a speed in units of s.
    """
    proof = EnergyProof()
    for branch in asked:
        isolate(times, branch, T, scale, proof)
    proof.ended = bool(proof.undecided) and out_of_time()
    return proof
