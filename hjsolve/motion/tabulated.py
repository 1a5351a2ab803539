"""Many times at once: positions from a table of the inverted time law, each quantity only when it is read.

It serves motions with one separated coordinate (all others ignorable), in double precision. The table is made
once per motion from the same regular integrals (``time_law/table``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from hjsolve.arithmetic.error_free import Pair, split
from hjsolve.arithmetic.number_types import Counts, Mask, Numbers, Reals
from hjsolve.display.by_value import same
from hjsolve.display.shown import WIDEST, brief
from hjsolve.errors import NotConvergedError, of_kind, required
from hjsolve.motion.near_poles import roundings
from hjsolve.motion.positions import constant_index
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion, Unbounded
from hjsolve.one_coordinate.fourier_series import FourierSeries
from hjsolve.time_law.open_motion import integral_at_start, reaching
from hjsolve.time_law.phase_reduction import turns_and_rest
from hjsolve.time_law.table import DEGREE, InterpolationTable, tabulate
from hjsolve.time_law.torus import oscillation

if TYPE_CHECKING:
    from hjsolve.motion.separated import SeparatedMotion

T = TypeVar("T")
"""What is worked out."""
_FINE = 22
"""The crowding of a phase (``Periodic.crowding``) from which on a table of momenta is as exact as it is rounded."""
FEWEST = 2048
"""Below this many times a table does not pay."""


class OnDemand(Mapping[str, T]):
    """A mapping whose values are worked out when they are first read."""

    def __init__(self, names: tuple[str, ...], compute: Callable[[str], T]):
        self._names, self._compute, self._known = names, compute, dict[str, T]()

    def __getitem__(self, name: str) -> T:
        if name not in self._names:
            raise KeyError(name)
        if name not in self._known:
            self._known[name] = self._compute(name)
        return self._known[name]

    def __contains__(self, name: object) -> bool:
        return name in self._names  # that of Mapping works the value out

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __eq__(self, other: object) -> bool:
        return same(dict(self), dict(other)) if isinstance(other, Mapping) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[type, tuple[dict[str, T]]]:
        return dict, (dict(self),)

    def __repr__(self) -> str:
        return brief(dict(self), WIDEST)


@dataclass(frozen=True, eq=False)
class DenseOutput:
    """A motion as a table.

    Attributes:
        table: quantities 0: q, 1: shell momentum, then the oscillation of each ignorable coordinate.
        waves: ignorable coordinates in the table's order, and their oscillation at the start.
        first: least argument of a table that is not folded.
        begin: argument at t₀ where it is not an angle variable.
        ends: quantities that hold the distances from the lower and the upper turning point, where velocities need them.
    """

    table: InterpolationTable
    waves: Mapping[str, tuple[int, float]]
    first: float
    begin: float = 0.0
    ends: tuple[int, int] | None = None

    def places(self, motion: SeparatedMotion, θ: Reals) -> tuple[dict[str, Pair], dict[str, Numbers]]:
        """Return the separated coordinate in two doubles and its shell momentum, where ``ends`` are held.

        Args:
            motion: the one the table was made of.
            θ: argument, shape (m,).
        """
        name = motion.solution.coordinates[0]
        coordinate_motion = required(motion.located[name].coordinate_motion.cycle)
        below, above, shell = self.table.evaluate([*required(self.ends), 1], θ)
        return {name: coordinate_motion.beside(below, above)}, {name: shell}

    def argument(self, motion: SeparatedMotion, time: tuple[Reals, Reals]) -> tuple[Reals, Counts, Mask]:
        """Return the table's argument, the whole turns, and where the motion has ended, at times relative to t₀.

        Args:
            motion: the one the table was made of.
            time: t − t₀ as two doubles, shape (m,).
        """
        torus, scheme = motion.torus, motion.scheme
        if torus is not None:
            turn = 2 * torus.rates[0].context.pi
            # whole turns are taken out in two doubles before θ becomes an angle: after 10⁹ turns it has all its digits
            whole, rest = turns_and_rest(split(torus.rates[0] / turn), time, split(torus.starts[0] / turn))
            θ = rest
            θ *= 2 * np.pi
            if not self.table.even:
                # a table over [first, first + 2π): what lies outside is a turn away
                behind, beyond = θ < self.first, θ >= self.first + 2 * np.pi
                if behind.any() or beyond.any():
                    shift = behind.astype(int) - beyond
                    θ += 2 * np.pi * shift
                    whole -= shift
            return θ, whole, np.zeros(θ.shape, dtype=bool)
        coordinate_motion = required(scheme).coordinate_motions[0]
        # high parts first: their sum may cancel, and the low part keeps its digits
        value = (time[0] + self.begin) + time[1]
        low = -self.table.edges[-1] if self.table.even else self.table.edges[0]
        return (
            np.clip(value, low, self.table.edges[-1]),
            np.zeros(value.shape),
            _ended(coordinate_motion, value, low, self.table.edges[-1]),
        )


def _ended(coordinate_motion: CoordinateMotion, value: Reals, low: float, high: float) -> Mask:
    floor, ceiling = coordinate_motion.limits()
    return ((value > high) & np.isfinite(ceiling)) | ((value < low) & np.isfinite(floor))


@lru_cache(maxsize=64)
def needs_table(motion: SeparatedMotion) -> bool:
    """Return True where the time law is so uneven that its inverse needs a table even for one time.

    Where θ grows with χ at a rate d ≪ 1 (a fast perihelion), χ + D(χ) = θ solved in doubles leaves an error of about
    2⁻⁵² / d in χ; the table integrates the rate itself, without that cancellation.
    """
    torus = motion.torus
    if torus is None or len(torus.coordinate_motions) != 1 or "place" not in motion.parts:
        return False
    coordinate_motion = torus.coordinate_motions[0].cycle
    if coordinate_motion is None or not coordinate_motion.tabular:
        return False
    weighted_rate = np.abs(
        # the least rate of θ over a turn, on 129 phases; of an even motion half a turn is all
        coordinate_motion.weighted_rate(
            (1.0,), np.linspace(0.0 if coordinate_motion.anomaly.even else -np.pi, np.pi, 129)
        )
    )
    return bool(np.min(weighted_rate) < 0.05 * float(coordinate_motion.kernels[0].mean))


def dense_output(motion: SeparatedMotion, span: float) -> DenseOutput | None:
    """Return the table of a motion that reaches over a time span; None where a table does not serve.

    Args:
        motion: the one to tabulate.
        span: greatest |t − t₀|, in the units of t.
    """
    equations = motion.equations
    if motion.digits > 15 or equations is None or len(equations.coordinate_motions) != 1:
        return None
    coordinate_motion = equations.coordinate_motions[0]
    if not all(part.tabular for part in (*coordinate_motion.branches, *filter(None, [coordinate_motion.cycle]))):
        return None
    try:
        if coordinate_motion.branches:
            return (
                None
                if roundings(motion, coordinate_motion)
                else _open(motion, int(np.ceil(np.log2(max(span, 1e-290)))))
            )
        return _resting(motion) if coordinate_motion.rests else _bounded(motion)
    except NotConvergedError:
        return None


@lru_cache(maxsize=64)
def _bounded(motion: SeparatedMotion) -> DenseOutput:
    equations = required(motion.torus)
    coordinate_motion = required(equations.coordinate_motions[0].cycle)
    mean = float(coordinate_motion.kernels[0].mean)
    names = [c.name for c in motion.solution.system.coordinates if c.name not in motion.located]
    series = [oscillation(equations, 0, constant_index(motion, n)) for n in names]
    # q next to a turning point is known by its distance from it, where the velocity needs more digits than q has
    ends = (
        (2 + len(names), 3 + len(names))
        if coordinate_motion.anomaly.even and roundings(motion, coordinate_motion)
        else None
    )
    more = [None, None] if ends else []
    even = (True, False, *(False for _ in names), *(True for _ in more)) if coordinate_motion.anomaly.even else ()
    flat = [0.0] * (len(names) + len(more))
    edges = np.linspace(0 if even else -np.pi, np.pi, 17)
    own = equations.oscillations[0][0]
    moved = own.oscillation(np.array([-np.pi]))[0] if not own.constant else 0.0
    first = 0.0 if even else float(-np.pi + moved)

    def outputs(χ: Reals) -> list[Numbers]:
        return [
            *coordinate_motion.place(χ),
            *(_wave(s, χ) for s in series),
            *(coordinate_motion.distances(χ) if ends else ()),
        ]

    table = tabulate(
        edges,
        lambda χ: coordinate_motion.weighted_rate((1.0,), χ) / mean,
        outputs,
        [_scale(motion), None, *(np.pi for _ in names), *more],
        even=even,
        origin=first,
        total=np.pi if even else 2 * np.pi,
        known=lambda χ: _angle(equations.oscillations[0][0], χ),
        # p may be rounded as far as χ is, whose spacing its slope passes on
        spacings=lambda χ: [0.0, np.abs(coordinate_motion.place(χ)[1]) * coordinate_motion.crowding(χ) / _FINE, *flat],
    )
    begin = np.array([float(coordinate_motion.start)])
    waves = {name: (2 + k, float(_wave(s, begin)[0])) for k, (name, s) in enumerate(zip(names, series, strict=True))}
    return DenseOutput(table, waves, first, ends=ends)


def _resting(motion: SeparatedMotion) -> DenseOutput:
    """Return a table of constants: the coordinate rests, the ignorable ones grow evenly."""
    place = float(motion.located[motion.solution.coordinates[0]].coordinate_motion.rest)  # type: ignore[union-attr]
    names = [c.name for c in motion.solution.system.coordinates if c.name not in motion.located]
    rows = [np.zeros((DEGREE + 1, 1)) for _ in range(2 + len(names))]
    rows[0][0] = place
    table = InterpolationTable(
        np.array([-np.pi, np.pi]), tuple(rows), (), tuple(np.abs(row[0]) for row in rows), np.zeros(1)
    )
    return DenseOutput(table, {name: (2 + k, 0.0) for k, name in enumerate(names)}, -np.pi)


def _angle(periodic: FourierSeries, χ: Reals) -> Reals:
    """χ + D(χ), the sum taken in extended precision."""
    if periodic.constant:
        return χ
    return (χ.astype(np.longdouble) + periodic.oscillation(χ.astype(np.longdouble))).astype(float)


def _wave(series: FourierSeries, χ: Reals) -> Reals:
    return 0 * χ if series.constant else series.oscillation(χ)


def _scale(motion: SeparatedMotion) -> float:
    """Return the size below which q needs no relative accuracy: 0 unless it passes through zero."""
    name = motion.solution.coordinates[0]
    ends = motion.turning_points.get(name)
    if ends is None:
        cycle = motion.located[name].coordinate_motion.cycle
        return float(np.pi) * float(1 if cycle is None else cycle.radian)
    values = [float(e.value) for e in ends if e is not None]
    domain = motion.solution.system.coordinate(name).domain
    # a coordinate that never passes zero, such as r, is wanted to relative accuracy
    positive = domain.lower is not None and domain.lower == 0
    if positive or (len(values) == 2 and values[0] * values[1] > 0):
        return 0.0
    if values:
        return max(abs(v) for v in values)
    maps = [branch.end_map for branch in motion.located[name].coordinate_motion.branches]
    return float(maps[0].length) if maps else float(np.pi)


@lru_cache(maxsize=8)
def _open(motion: SeparatedMotion, power: int) -> DenseOutput:
    scheme = required(motion.scheme)
    coordinate_motion = of_kind(reaching(scheme.coordinate_motions[0], scheme, 2.0**power, 0), Unbounded)
    reduced = not coordinate_motion.both_directions
    edges = coordinate_motion.edges()
    names = [c.name for c in motion.solution.system.coordinates if c.name not in motion.located]
    indices = [constant_index(motion, n) for n in names]
    even = (True, False, *(False for _ in names)) if reduced else ()

    def outputs(y: Reals) -> list[Numbers]:
        return [*coordinate_motion.place(y), *(-coordinate_motion.integral(j, y) for j in indices)]

    # a motion that comes in and goes out on the same branch is even about its turning point
    used = edges[edges >= 0] if reduced else edges
    first = 0.0 if reduced else float(coordinate_motion.integral(0, edges[:1])[0])
    table = tabulate(
        used,
        lambda y: coordinate_motion.rate(0, y),
        outputs,
        [_scale(motion), None, *(np.pi for _ in names)],
        even=even,
        origin=first,
        spacings=lambda y: [0.0, 0.0, *(coordinate_motion.spacing(j, y) for j in indices)],
    )
    waves = {
        name: (2 + k, -integral_at_start(coordinate_motion, j))
        for k, (name, j) in enumerate(zip(names, indices, strict=True))
    }
    return DenseOutput(table, waves, first, integral_at_start(coordinate_motion, 0))
