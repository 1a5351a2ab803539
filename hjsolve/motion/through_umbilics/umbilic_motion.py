"""A motion through umbilics, expressed in the given coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from hjsolve.arithmetic.floats import EPS, bits_for
from hjsolve.arithmetic.number_types import AtTimes, Mpf, Numbers
from hjsolve.errors import InvalidInputError, required
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.placing import with_place
from hjsolve.motion.positions import coordinate_velocities
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.shapes import shaped
from hjsolve.motion.state import Errors, State
from hjsolve.motion.through_umbilics.arcs import Arcs, UmbilicArc, places_on
from hjsolve.motion.times import read_times
from hjsolve.motion.transformed_motion import TransformedMotion

SPARE = 25
"""Decimal digits by which the series are better than what is told."""
_BUFFER = 200
"""Binary digits that p² and the metric may lose next to an umbilic."""
_UNCERTAINTY = 20
"""Decimal digits beyond those asked to which the time is taken to be known."""
_LEAST = 2.0**-200
"""What a coordinate that is zero is not known to."""


def work_bits(digits: int) -> int:
    """Return the binary digits of the arithmetic."""
    return bits_for(max(digits, FLOAT_DIGITS) + SPARE, _BUFFER)


@dataclass(frozen=True, eq=False, repr=False)
class UmbilicMotion(TransformedMotion):
    """A motion both of whose coordinates tend to double zeros of p², which it reaches in a finite time, and goes on.

    At every umbilic the first coordinate goes on and the second one turns back; (2e₁ − q₁, 2e₂ − q₂) is the same place.
    States only: W, angles and passages are not given.

    Attributes:
        arcs: of the motion.
        unfolding: the coordinate that goes on.
    """

    arcs: Arcs | None = field(default=None, repr=False)
    unfolding: int = 0

    def at(self, t: object) -> State:
        """As ``Motion.at``; at an umbilic itself velocities of the coordinates are infinite.

        Raises:
            NotConvergedError: there are too many umbilics before that time.
        """
        self._require("trajectory")
        shape, floats, exact = read_times(t)
        bits = work_bits(self.digits)
        begin = to_bits(self.t0)(bits)
        context = begin.context
        times = [context.mpf(x) - begin for x in floats] if floats is not None else [x(bits) - begin for x in exact]
        rows = [self._state(x) for x in times]
        status = np.array(["ok" if row is not None else "reaches_boundary" for row in rows], dtype="<U16")
        names = list(self.solution.coordinates)
        nothing = _Row((context.nan,) * 2, (context.nan,) * 2, (0, 0), (context.nan,) * 2)
        states = [nothing if row is None else row for row in rows]
        q = {n: np.array([row.q[k] for row in states], dtype=object) for k, n in enumerate(names)}
        p = {n: np.array([row.p[k] for row in states], dtype=object) for k, n in enumerate(names)}
        turns = {n: np.array([row.turns[k] for row in states], dtype=int) for k, n in enumerate(names)}
        away = {n: np.array([row.away[k] for row in states], dtype=object) for k, n in enumerate(names)}
        v = self._velocities(q, p, away)
        angles = {c.name for c in self.solution.system.coordinates if c.domain.kind == "angle"}

        def group(table: Mapping[str, Numbers]) -> dict[str, AtTimes]:
            few = self.digits <= FLOAT_DIGITS
            return {n: shaped(x.astype(float) if few else x, shape) for n, x in table.items()}

        def errors() -> Errors:
            return self._errors(q, p, v, away, shape)

        state = State(
            t, group(q), group(p), group(v), {n: shaped(x, shape) for n, x in turns.items() if n in angles},
            shaped(status, shape), errors,
        )  # fmt: skip
        return with_place(self.solution.system, self.initial.values, state)

    def _state(self, t: Mpf) -> _Row | None:
        arcs = required(self.arcs)
        found = arcs.at(t)
        if found is None:
            return None
        number, arc = found
        begin, end = arc.ends(arcs.paths)
        # at the umbilic itself z is infinite: the coordinates are at their ends
        near = arcs.smallest(t)
        if t - begin <= near or end - t <= near:
            z: tuple[Mpf | None, Mpf | None] = (None, None)
            sides = arc.sides(1 if end - t <= near else -1)
        else:
            z, sides = places_on(arc, arcs.paths, t), arc.directions
        return self._states(arc, number, z, sides)

    def _states(self, arc: UmbilicArc, number: int, z: tuple[Mpf | None, Mpf | None], sides: tuple[int, int]) -> _Row:
        """Coordinates and momenta from both paths; of a coordinate at a double zero the end at which it is."""
        arcs = required(self.arcs)
        states = []
        for k, (path, v) in enumerate(zip(arcs.paths, z, strict=True)):
            c, coordinate_motion = path.residues[0].context, path.coordinate_motion
            x = c.mpf(sides[k]) if v is None else c.tanh(v)
            place, slope = coordinate_motion.place(x), coordinate_motion.slope(x) * arc.directions[k]
            # the sign of p is that of dq/dt, which dq/dx and the direction of x give: p² says nothing of it
            size = c.zero if v is None else path.momentum(v, x) * (1 if slope > 0 else -1 if slope < 0 else 0)
            distance = min(abs(place - coordinate_motion.lower), abs(place - coordinate_motion.upper))
            if k == self.unfolding:
                shift, direction = self._unfolded(number)
                place, size = shift + direction * place, direction * size
            whole = 0
            if self.solution.system.coordinate(list(self.solution.coordinates)[k]).domain.kind == "angle":
                whole = int(c.ceil((place - c.pi) / (2 * c.pi)))
                place -= 2 * c.pi * whole
            states.append((place, size, whole, distance))
        return _Row(*zip(*states, strict=True))

    def _unfolded(self, number: int) -> tuple[Mpf, int]:
        """Return a and B of q = A + B q̃, q̃ on the path: turned over at each umbilic that was passed."""
        arcs, k = required(self.arcs), self.unfolding
        coordinate_motion = arcs.paths[k].coordinate_motion
        side, count = (1 if number >= 0 else -1), abs(number)
        d = arcs.known[side][0].directions[k]
        ends = (
            (coordinate_motion.upper, coordinate_motion.lower)
            if d > 0
            else (coordinate_motion.lower, coordinate_motion.upper)
        )
        if arcs.known[1][0].rest is not None:  # moves on every second arc alone
            return self._unfolded_resting(side, count)
        # two reflections about different ends make a shift by twice their distance
        pairs, odd = divmod(count, 2)
        shift, direction = 2 * pairs * (ends[0] - ends[1]), 1
        return (shift + 2 * ends[0], -1) if odd else (shift, direction)

    def _unfolded_resting(self, side: int, count: int) -> tuple[Mpf, int]:
        arcs, k = required(self.arcs), self.unfolding
        coordinate_motion, shift, direction = (
            arcs.paths[k].coordinate_motion,
            0 * required(self.arcs).paths[k].weight,
            1,
        )
        for arc in arcs.known[side][:count]:
            e = coordinate_motion.upper if arc.directions[k] > 0 else coordinate_motion.lower
            shift, direction = shift + 2 * direction * e, -direction
        return shift, direction

    def _velocities(
        self, q: Mapping[str, Numbers], p: Mapping[str, Numbers], away: Mapping[str, Numbers]
    ) -> dict[str, Numbers]:
        """dq/dt; infinite at an umbilic, nan where the motion has ended."""
        names = list(q)
        rows: dict[str, list[Mpf]] = {n: [] for n in names}
        for m in range(len(q[names[0]])):
            context = q[names[0]][m].context
            # nan: the motion ended before
            if any(q[n][m] != q[n][m] for n in names):
                own = dict.fromkeys(names, context.nan)
            # q̇ = p/(h a) with h = 0; of ẋ in space nothing is infinite there
            elif all(away[n][m] == 0 for n in names):
                own = dict.fromkeys(names, context.inf)
            else:
                at = [{n: group[n][m : m + 1] for n in names} for group in (q, p)]
                own = {n: x[0] for n, x in coordinate_velocities(self.separated, *at).items()}
            for n in names:
                rows[n].append(own[n])
        return {n: np.array(row, dtype=object) for n, row in rows.items()}

    def _errors(
        self, q: Mapping[str, Numbers], p: Mapping[str, Numbers], v: Mapping[str, Numbers],
        away: Mapping[str, Numbers], shape: tuple[int, ...] | None,
    ) -> Errors:  # fmt: skip
        """Return what the time is not known to, times the velocity, and the rounding of what is told.

        h is at least a multiple of the square of the distance from an umbilic, so that q̇ changes by itself over it, in
        proportion, by no more than a few times the relative change of that distance.
        """
        few = self.digits <= FLOAT_DIGITS
        unit = EPS if few else 10.0**-self.digits
        uncertainty = 10.0 ** -(max(self.digits, FLOAT_DIGITS) + _UNCERTAINTY) * (
            1 + float(required(self.arcs).longest())
        )
        moved: dict[str, Numbers] = {n: uncertainty * np.abs(x.astype(float)) for n, x in v.items()}
        near = np.sqrt(sum(x.astype(float) ** 2 for x in away.values()))
        exactly = {n: np.array([x == 0 for x in away[n]]) for n in q}
        size = {n: [np.abs(x.astype(float)) for x in (q[n], p[n], v[n])] for n in q}
        with np.errstate(all="ignore"):
            # near umbilics q̇ ∝ 1/distance, so that a change of place changes p and q̇ in proportion to it
            relative = 16 * sum(moved.values()) / near
            places = {n: np.where(exactly[n], 0.0, moved[n]) + unit * size[n][0] + _LEAST for n in q}
            momenta = {n: np.where(exactly[n], 0.0, size[n][1] * relative) + unit * size[n][1] for n in q}
            rates = {n: size[n][2] * (unit + relative) for n in q}

        def group(table: Mapping[str, Numbers]) -> dict[str, AtTimes]:
            return {n: shaped(x, shape) for n, x in table.items()}

        return Errors(group(places), group(momenta), group(rates))

    def _refuse_given(self, name: str) -> None:
        raise _refused(f"passages of {name}")

    def _require(self, quantity: str) -> None:
        if quantity != "trajectory":
            raise _refused(quantity)
        super()._require(quantity)


def _refused(quantity: str) -> InvalidInputError:
    return InvalidInputError(f"{quantity}: not given for a motion through umbilics; at(t) gives its states")


@dataclass(frozen=True)
class _Row:
    """A state in many digits."""

    q: tuple[Mpf, ...]
    p: tuple[Mpf, ...]
    turns: tuple[int, ...]
    away: tuple[Mpf, ...]


def going_on(motion: Motion, arcs: Arcs, unfolding: int) -> UmbilicMotion:
    """Return a motion that goes on through umbilics.

    Args:
        motion: with its constants and kinds.
        arcs: what it does.
        unfolding: the coordinate that goes on at each.
    """
    # the separated equations come to rest at each umbilic: their periods and times at the ends are not the motion's
    states_only = replace(motion, frequencies={}, periods={}, boundary_times={})
    return UmbilicMotion.of(states_only, arcs=arcs, unfolding=unfolding)
