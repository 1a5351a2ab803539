"""The family of one complete integral: all motions with the same constants, which differ in Jacobi's β alone.

W(q; E, α) is a sum over the coordinates, and in the phase of each its part grows. So a wavefront W = w is a smooth
curve in the plane of the two phases, found by inverting one part; in the plane of the coordinates it turns back with a
cusp wherever a momentum vanishes. Those turning curves are the caustics of the family: every orbit touches them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import EPS, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.positions import constant_index
from hjsolve.motion.separated import SeparatedMotion
from hjsolve.motion.state import Errors, KnownErrors, Placing, State
from hjsolve.motion.state_at import state_at_times
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion, Periodic
from hjsolve.rays.family_curve import FamilyCurve
from hjsolve.rays.sweeps_of_phase import (
    IgnorableSweep,
    PhaseSweep,
    SeparatedSweep,
    phase_tolerance,
    separated_sweep,
    uncertainty_of_place,
)
from hjsolve.time_law.open_motion import plan
from hjsolve.time_law.torus import torus_equations

_POINTS, _ORBIT_POINTS = 193, 241
_FAR = 4.0
_DOUBLINGS = 40


@dataclass(frozen=True, eq=False, repr=False)
class SameConstants(Shown):
    """What the curves of a family of motions with the same constants are made from.

    Attributes:
        motion: one of them, taken apart.
        first, second: the two coordinates; W grows with the phase of each.
        fixed: coordinates that stay at a place, since only the plane of the two others is looked at.
        placing: where coordinates are in space; None where unknown.
    """

    motion: SeparatedMotion
    first: SeparatedSweep
    second: PhaseSweep
    fixed: dict[str, float]
    placing: Placing | None

    @cached_property
    def steepest(self) -> tuple[float, float]:
        """The greatest growth of W with each phase."""
        first, second = (
            float(np.nanmax(s.gained(np.linspace(s.low, s.high, 65))[1])) or 1.0 for s in (self.first, self.second)
        )
        return first, second

    @cached_property
    def times(self) -> Reals:
        """Times at which orbits are followed: one cycle of the slowest coordinate, or the passage of the window."""
        return self._times(self.motion)

    # -------------------------------------------------------------------------------------------- wavefronts
    def levels(self, count: int) -> Reals:
        """Choose values of W at equal steps, over one turn of a coordinate that goes round, else over the family."""
        (low, high) = (s.gained(np.array([s.low, s.high]))[0] for s in (self.first, self.second))
        if turn := self.second.turn:
            return turn * np.arange(count) / count
        bottom, top = low[0] + high[0], low[1] + high[1]
        return bottom + (top - bottom) * (np.arange(count) + 0.5) / count

    def fronts(self, values: Reals) -> tuple[FamilyCurve, ...]:
        """Return the lines on which W has some values.

        Args:
            values: of W, which is 0 where the motion is at t₀.
        """
        return tuple(self._front(float(value)) for value in values)

    def _front(self, value: float) -> FamilyCurve:
        a, b = self.first, self.second
        χa, χb = self._by(a, b, value)
        across, along = self._by(b, a, value) if not isinstance(b, IgnorableSweep) or b.momentum == 0 else (χb[:0],) * 2
        ends = self._steepness(a, χa) <= self._steepness(b, χb) if len(across) else np.ones(len(χa), bool)
        ends &= np.isfinite(χb)
        kept = (self._steepness(b, across) < self._steepness(a, along)) & np.isfinite(along)
        phases = np.concatenate([np.stack([χa[ends], χb[ends]]), np.stack([along[kept], across[kept]])], axis=1)
        solved = np.concatenate([np.ones(ends.sum(), bool), np.zeros(kept.sum(), bool)])
        order = np.lexsort((-phases[1], phases[0]))
        return self._curve(value, phases[:, order], solved[order])

    def _by(self, given: PhaseSweep, sought: PhaseSweep, value: float) -> tuple[Reals, Reals]:
        """Return the phases of one coordinate, all along and at the cusps, and those of the other where W = value."""
        low, high = given.low, given.high
        if given.turn:
            low, high = given.phase_of(value - sought.gained(np.array([sought.high, sought.low]))[0])
        grid = np.linspace(low, high, _POINTS)
        if sought.turning:
            cusps = given.phase_of(value - sought.gained(np.array(sought.turning))[0])
            grid = np.concatenate([grid, cusps[np.isfinite(cusps)]])
        grid = np.unique(np.concatenate([grid, given.turning]))
        return grid, sought.phase_of(value - given.gained(grid)[0])

    def _steepness(self, sweep: PhaseSweep, χ: Reals) -> Reals:
        """Return how fast W grows with a phase, in units of its greatest growth."""
        steepest = self.steepest[sweep is self.second]
        with np.errstate(invalid="ignore"):
            slope = sweep.gained(np.where(np.isfinite(χ), χ, sweep.low))[1]
        return slope / steepest

    def _curve(self, value: float, phases: Reals, second_solved: Mask) -> FamilyCurve:
        places = [s.place(χ) for s, χ in zip(self._sweeps, phases, strict=True)]
        q, p = ({s.name: found[i] for s, found in zip(self._sweeps, places, strict=True)} for i in (0, 1))
        return self._placed("front", value, q, p, partial(self._uncertainties, value, phases, second_solved))

    @property
    def _sweeps(self) -> tuple[PhaseSweep, PhaseSweep]:
        return self.first, self.second

    def _uncertainties(self, value: float, phases: Reals, second_solved: Mask) -> Errors:
        """Return the errors of a front: of the coordinate that was solved for, how far its phase may be off."""
        sums = [s.gained(χ) for s, χ in zip(self._sweeps, phases, strict=True)]
        uncertainty = np.abs(sums[0][0] + sums[1][0] - value) + sums[0][2] + sums[1][2] + EPS * abs(value)
        q_error, p_error = {}, {}
        for s, χ, solved in zip(self._sweeps, phases, (~second_solved, second_solved), strict=True):
            _, _, q_error[s.name], p_error[s.name] = s.place(χ)
            if solved.any():
                tolerance = phase_tolerance(s, χ[solved], uncertainty[solved])
                q_error[s.name][solved], p_error[s.name][solved] = uncertainty_of_place(s, χ[solved], tolerance)
        return Errors(q_error, p_error, {})

    def _placed(
        self, kind: str, value: float, q: dict[str, Reals], p: dict[str, Reals], errors: Callable[[], Errors]
    ) -> FamilyCurve:
        some = next(iter(q.values()))
        still = {name: np.full(some.shape, place) for name, place in self.fixed.items()}
        return FamilyCurve(kind, value, {**q, **still}, p, partial(_with_fixed, errors, still), self.placing)

    # -------------------------------------------------------------------------------------------- orbits
    def orbits(self, count: int) -> tuple[FamilyCurve, ...]:
        """Return orbits of the family, at equal steps of the phase of the second coordinate; the first is the motion.

        Args:
            count: how many.
        """
        width = self.second.high - self.second.low
        steps = width * np.arange(count) / count
        if isinstance(self.second, IgnorableSweep):
            own = self._orbit(self.motion, 0)
            return tuple(self._shifted(own, k, float(step)) for k, step in enumerate(steps))
        return tuple(self._orbit(self._started(float(step)), k) for k, step in enumerate(steps))

    def _shifted(self, own: FamilyCurve, number: int, step: float) -> FamilyCurve:
        name, low, high = self.second.name, *sorted(float(x) for x in self.second.place(self._ends)[0])
        moved = own.q[name] + step
        q = dict(own.q)
        if not self.second.turn:
            moved = np.where(moved > high, moved - (high - low), moved)
            broken = np.append(np.abs(np.diff(moved)) > (high - low) / 2, [False])
            q = {n: np.where(broken, np.nan, values) for n, values in q.items()}
        q[name] = np.where(np.isfinite(next(iter(q.values()))), moved, np.nan)
        return replace(own, value=float(number), q=q, errors=partial(_moved, own.errors, name, EPS * np.abs(moved)))

    @property
    def _ends(self) -> Reals:
        return np.array([self.second.low, self.second.high])

    def _started(self, step: float) -> SeparatedMotion:
        """Return the motion that begins with another phase of the second coordinate."""
        if step == 0:
            return self.motion
        name, bits = self.second.name, bits_for(self.motion.digits, 128)
        low, high = self.second.low, self.second.high
        place = self.motion.located[name]
        phase = float(place.coordinate_motion.start) + step
        phase = phase if phase < high else phase - (high - low)
        coordinate_motion = replace(place.coordinate_motion, start=multiprecision(bits).mpf(phase))
        located = {**self.motion.located, name: replace(place, coordinate_motion=coordinate_motion)}
        coordinate_motions = [located[n].coordinate_motion for n in self.motion.solution.coordinates]
        bounded = [stays for c in coordinate_motions if (stays := c.bounded) is not None]
        equations = (
            torus_equations(bounded, bits) if len(bounded) == len(coordinate_motions) else plan(coordinate_motions)
        )
        return replace(self.motion, located=located, equations=equations)

    def _orbit(self, motion: SeparatedMotion, number: int) -> FamilyCurve:
        names = (self.first.name, self.second.name)
        t = self.times
        state = state_at_times(motion, t)
        q = {n: np.asarray(state.unwrapped(n), float) for n in names}
        p = {n: np.asarray(state.p[n], float) for n in names}
        outside = np.zeros(len(t), dtype=bool)
        for sweep in (self.first, self.second):
            if isinstance(sweep, SeparatedSweep) and sweep.coordinate_motion.cycle is None:
                ends = sweep.place(np.array([sweep.low, 0.0, sweep.high]))[0]
                outside |= (q[sweep.name] < ends.min()) | (q[sweep.name] > ends.max())
        q = {n: np.where(outside, np.nan, v) for n, v in q.items()}
        return self._placed("orbit", float(number), q, p, partial(_of_state, state, names))

    def _times(self, motion: SeparatedMotion) -> Reals:
        """One cycle of the slowest coordinate; of a motion that does not come back, while it is in the window."""
        start = float(to_bits(motion.t0)(64))
        if motion.torus is not None:
            longest = max(2 * np.pi / abs(float(motion.frequencies[n].value)) for n in motion.solution.coordinates)
            return np.linspace(start, start + longest, _ORBIT_POINTS)
        open_ = [
            s for s in (self.first, self.second) if isinstance(s, SeparatedSweep) and s.coordinate_motion.cycle is None
        ]
        j = list(motion.solution.constants).index(motion.solution.separation.shell.energy.name)
        ends = []
        for side in (-1, 1):
            reach = max(abs(float(s.coordinate_motion.integral(j, np.array([s.high]))[0])) for s in open_) or 1.0
            for _ in range(_DOUBLINGS):
                q = state_at_times(motion, np.array([start + side * reach])).q
                if any(_beyond(s, float(np.asarray(q[s.name], float)[0])) for s in open_):
                    break
                reach *= 2
            ends.append(start + side * reach)
        return np.linspace(ends[0], ends[1], _ORBIT_POINTS)

    # -------------------------------------------------------------------------------------------- caustics
    def caustics(self) -> tuple[FamilyCurve, ...]:
        """Return the turning curves: one coordinate at a turning point, the other anywhere in the family."""
        found = []
        pairs: tuple[tuple[PhaseSweep, PhaseSweep], ...] = ((self.first, self.second), (self.second, self.first))
        for resting, other in pairs:
            ends = self.motion.turning_points.get(resting.name, ()) if resting.turning else ()
            for end in (e for e in ends if e is not None):
                χ = np.linspace(other.low, other.high, _POINTS)
                q, p, approximate, coarse = other.place(χ)
                value = float(end.value)
                errors = Errors(
                    {resting.name: float(end.error) + EPS * abs(value) + 0 * χ, other.name: approximate},
                    {resting.name: 0 * χ, other.name: coarse}, {},
                )  # fmt: skip
                places, momenta = {resting.name: value + 0 * χ, other.name: q}, {resting.name: 0 * χ, other.name: p}
                found.append(self._placed("caustic", value, places, momenta, KnownErrors(errors)))
        return tuple(found)


def _with_fixed(errors: Callable[[], Errors], still: Mapping[str, Reals]) -> Errors:
    """Return the errors of a curve in the plane where a coordinate stays."""
    found = errors()
    return Errors({**found.q, **{name: 0 * values for name, values in still.items()}}, dict(found.p), {})


def _moved(errors: Callable[[], Errors], name: str, more: Reals) -> Errors:
    """Return the errors of an orbit that was moved along a coordinate."""
    found = errors()
    return Errors({**found.q, name: found.q[name] + more}, found.p, {})


def _of_state(state: State, names: tuple[str, str]) -> Errors:
    """Return the errors of an orbit."""
    found = state.error
    q = {n: np.asarray(found.q[n], float) + EPS * np.abs(np.asarray(state.unwrapped(n), float)) for n in names}
    return Errors(q, {n: np.asarray(found.p[n], float) for n in names}, {})


def _beyond(sweep: SeparatedSweep, q: float) -> bool:
    ends = sweep.place(np.array([sweep.low, 0.0, sweep.high]))[0]
    return not ends.min() <= q <= ends.max()


# ------------------------------------------------------------------------------------------------ the two coordinates
def started_with_same_constants(motion: Motion, placing: Placing | None) -> SameConstants:
    """Make the family of a motion's constants ready.

    Args:
        motion: one of the family.
        placing: where coordinates are in space; None where unknown.

    Raises:
        InvalidInputError: the motion has not two coordinates that move, or one of them rests.
    """
    taken, names = motion.separated, motion.solution.coordinates
    rest = [c.name for c in motion.solution.system.coordinates if c.name not in names]
    if not (len(names) == 2 and len(rest) <= 1) and not (len(names) == 1 and len(rest) == 1):
        raise InvalidInputError("wavefronts: two coordinates are needed, or two next to one ignorable one")
    if resting := [n for n in names if taken.located[n].coordinate_motion.rests]:
        raise InvalidInputError(f"wavefronts: {resting[0]} rests, so the orbits of the family fill no area")
    separated = [_separated(taken, name) for name in names]
    if len(names) == 1:
        return SameConstants(taken, separated[0], _ignorable(taken, separated[0], rest[0]), {}, placing)
    first, second = sorted(separated, key=lambda s: s.turn != 0)
    return SameConstants(taken, first, second, dict.fromkeys(rest, 0.0), placing)


def _separated(motion: SeparatedMotion, name: str) -> SeparatedSweep:
    coordinate_motion = motion.located[name].coordinate_motion
    if isinstance(coordinate_motion, Periodic):
        return separated_sweep(
            name, 0.0, 2 * np.pi, coordinate_motion, () if coordinate_motion.rotates else (0.0, np.pi, 2 * np.pi)
        )
    low, high = _window(coordinate_motion)
    turning = (0.0,) if coordinate_motion.branches[0].end_map.turning else ()
    return separated_sweep(name, low, high, coordinate_motion.with_reach(1.01 * max(-low, high, 1e-9)), turning)


def _window(coordinate_motion: CoordinateMotion) -> tuple[float, float]:
    """Return phases within which an open motion goes several times its own size away."""
    begin, start = (float(coordinate_motion.place(np.array([x]))[0][0]) for x in (0.0, float(coordinate_motion.start)))
    size = max(abs(begin), abs(start - begin), 0.3)
    ends = []
    for side in (-1, 1):
        χ = max(1.0, abs(float(coordinate_motion.start)))
        for _ in range(_DOUBLINGS):
            reaching = coordinate_motion.with_reach(χ)
            limit = 0.999 * abs(reaching.limits()[side > 0])
            if χ >= limit or abs(float(reaching.place(np.array([side * χ]))[0][0]) - begin) > _FAR * size:
                χ = min(χ, limit)
                break
            χ *= 1.3
        ends.append(side * χ)
    return ends[0], ends[1]


def _ignorable(motion: SeparatedMotion, other: SeparatedSweep, name: str) -> IgnorableSweep:
    """Return the window of an ignorable coordinate: a turn of an angle.

    Of a length, what the motion itself goes through.
    """
    coordinate = motion.solution.system.coordinate(name)
    start = float(to_bits(motion.initial.values[coordinate.symbol])(64))
    c = float(to_bits(motion.initial.values[coordinate.momentum])(64))
    if coordinate.domain.kind == "angle":
        return IgnorableSweep(name, 0.0, 2 * np.pi, c, start, angle=True)
    sums = other.coordinate_motion.integral(constant_index(motion, name), np.linspace(other.low, other.high, 65))
    extent = np.ptp(other.place(np.linspace(other.low, other.high, 65))[0])
    half = 0.75 * max(float(np.ptp(np.asarray(sums, float))), float(extent))
    sense = -1.0 if c < 0 else 1.0
    return IgnorableSweep(name, sense * start - half, sense * start + half, c, start, angle=False)


def momentum_shift(motion: Motion) -> sp.Expr:
    """Return the sum of the shifts by which momenta differ from ∂W/∂q; 0 where there are none."""
    return sum(motion.solution.shift.values(), sp.S.Zero)
