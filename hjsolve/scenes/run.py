"""The run of a scene: its arcs, the quantities it wants of each, and the state at its times."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Mask, Mpf, Numbers
from hjsolve.arithmetic.work_counter import counted
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError, MissingValueError, NotSeparableError, required
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.tabulated import OnDemand
from hjsolve.scenes.arc_motions import ArcMotion, FreeMotions, TurnsBefore
from hjsolve.scenes.arcs import FollowedArcs, FreeArc, free_arcs
from hjsolve.scenes.crossing import bits_of
from hjsolve.scenes.force_refusal import dissipative, force_words
from hjsolve.scenes.lasting_constraints import afterwards, carried_back, joined
from hjsolve.scenes.question import OrbitAsked, Question, Times
from hjsolve.scenes.results import Arc, Choice, Run, Trajectory
from hjsolve.scenes.trajectory import belongings, sampled, trajectory_of
from hjsolve.solution.quadratures import Solution, solve

_PLACES = 33


@dataclass(frozen=True, eq=False, repr=False)
class OrbitTable(Shown):
    """An orbit equation as numbers, of the whole orbit that an arc is part of.

    Attributes:
        of, along: the coordinates.
        places: of ``along``, shape (m,).
        values: of ``of`` at its first passage of each place, shape (m,).
    """

    of: str
    along: str
    places: Numbers
    values: Numbers


def orbit_table(asked: OrbitAsked | None, motion: Motion) -> OrbitTable:
    """Work out the orbit equation.

    Args:
        asked: which; None for the first separated coordinate that turns or goes round, and the first other one.
        motion: with all that ``orbit`` needs.

    Raises:
        InvalidInputError: nothing was asked and the motion offers no such pair.
        OutsideMotionError: a place that the motion never reaches.
    """
    if asked is None:
        asked = _chosen(motion)
    places = list(asked.values) or _places(motion, asked.along)
    return OrbitTable(asked.of, asked.along, np.array(places), motion.orbit(asked.of, along=asked.along, values=places))


def _chosen(motion: Motion) -> OrbitAsked:
    names = [c.name for c in motion.solution.system.coordinates]
    along = next((n for n in motion.separated.located if motion.kinds[n] in ("libration", "rotation")), None)
    of = next((n for n in names if n != along), None)
    if along is None or of is None:
        raise InvalidInputError(
            'orbit: say which, e.g. [orbit] of = "theta", along = "r", values = [1, 2]; no coordinate here comes back'
        )
    return OrbitAsked(of, along)


def _places(motion: Motion, along: str) -> list[float]:
    """Return places inside the region, closer together towards its ends."""
    angles = np.pi * (np.arange(_PLACES) + 0.5) / _PLACES
    if motion.kinds[along] == "rotation":
        start = float(to_bits(motion.initial.values[motion.solution.system.coordinate(along).symbol])(64))
        direction = 1 if float(motion.frequencies[along].value) > 0 else -1
        return [float(x) for x in start + direction * 2 * angles]
    ends = motion.turning_points.get(along)
    if ends is None or ends[0] is None or ends[1] is None:
        raise InvalidInputError(f"orbit: {along} does not turn on both sides; give orbit.values")
    low, high = float(ends[0].value), float(ends[1].value)
    return [float(x) for x in (low + high) / 2 - (high - low) / 2 * np.cos(angles)]


__all__ = ["Arc", "Choice", "Run", "Trajectory", "first_arguments", "run_by_quadratures", "sampled", "solved"]
_FIELDS = (
    "constants", "kinds", "turning_points", "actions", "periods", "frequencies", "mean_velocities", "boundary_times",
)  # fmt: skip
_TIMED, _OWN = frozenset({"trajectory", "angles"}), frozenset({"angles", "orbit"})
"""What needs times inside an arc; what is not the same on all arcs of one free motion."""


def run_by_quadratures(scene: Question, solution: Solution | None = None) -> Run:
    """Compute what a scene wants with the digits it has; a solution that is there already is not made again.

    Args:
        solution: of the scene's system, where it was made before.

    Raises:
        InvalidInputError: a certified scene with events.
    """
    if scene.method == "integrate":
        from hjsolve.scenes.integrate import integrated

        _started(scene)
        return integrated(scene)
    if solution is None:
        solution = required(solved(scene))
    if scene.certified and scene.events:
        raise InvalidInputError("proofs end at an event: the state there is computed, not proved; leave certified out")
    with counted() as work:
        followed = free_arcs(scene, solution, first_arguments(scene))
        if followed.leg is None:
            arcs, path = _computed(scene, solution, followed)
            return Run(scene, solution, arcs, path, {}, work, rest=followed.rest, impacts=followed.impacts)
        places, (before, later) = _parted(scene, followed)
        after = afterwards(scene, followed, later)
        arcs, path = _computed(_at_times(scene, before), solution, followed)
        lasting = run_by_quadratures(_at_times(after.question, later), after.solution)
        states = None
        if "trajectory" in scene.want:
            gone_on = None if lasting.trajectory is None else carried_back(after, lasting.trajectory, scene.digits)
            states = joined(path, gone_on, places, len(arcs))
    return Run(
        scene, solution, (*arcs, *lasting.arcs), states, {}, work, rest=lasting.rest,
        impacts=(*followed.impacts, *lasting.impacts), lasting=lasting,
    )  # fmt: skip


def _computed(scene: Question, solution: Solution, followed: FollowedArcs) -> tuple[tuple[Arc, ...], Trajectory | None]:
    """Return the arcs with what is wanted of each, and the states."""
    found, rest = followed.arcs, followed.rest
    free_motions = FreeMotions(scene, solution)
    busy = np.zeros(len(found) + 1, dtype=bool)
    if scene.times is not None and {"trajectory", "angles"} & set(scene.want):
        busy[belongings(sampled(scene.times, scene.digits), found, rest)] = True
    last = None if rest is None else rest.time
    arcs = tuple(
        _arc(scene, solution, piece, bool(timed), free_motions, last if piece is found[-1] else None)
        for piece, timed in zip(found, busy, strict=False)
    )
    return arcs, trajectory_of(scene, arcs, found, rest, free_motions) if "trajectory" in scene.want else None


def _parted(scene: Question, followed: FollowedArcs) -> tuple[list[Integers], list[Times | None]]:
    """Return the places and the times before and after the last event, where a constraint begins that lasts."""
    if scene.times is None:
        return [np.zeros(0, dtype=int)] * 2, [None, None]
    times = sampled(scene.times, scene.digits)
    early = belongings(times, followed.arcs, None) < len(followed.arcs)
    places = [np.nonzero(early)[0], np.nonzero(~early)[0]]
    return places, [_some(times[place]) for place in places]


def _some(times: Numbers) -> Times | None:
    if not len(times):
        return None
    doubles = tuple(map(float, times)) if times.dtype == float else ()
    return Times(tuple(map(sp.Rational, doubles)) if doubles else tuple(times), doubles=doubles)


def _at_times(scene: Question, times: Times | None) -> Question:
    """Return the scene at other times; without states where there are none."""
    want = scene.want if times is not None else tuple(w for w in scene.want if w not in _TIMED)
    return replace(scene, times=times, want=want)


def _started(scene: Question) -> None:
    if scene.sweep is not None:
        raise InvalidInputError(
            f"{scene.source}: has many motions; run it by hjsolve.sweep(scene, out) or `hjsolve sweep FILE -o OUT`"
        )
    if scene.initial is None:
        raise MissingValueError(f"{scene.source}: initial: missing, and the system has no default motion")


def solved(scene: Question) -> Solution | None:
    """Solve the system of a scene; None where it is to be integrated.

    Raises:
        NotSeparableError: it does not separate, or a force acts on it.
        MissingValueError: nothing says where the motion starts.
    """
    _started(scene)
    if scene.method == "integrate":
        return None
    if scene.forces:
        verdict = dissipative(scene.system, scene.forces)
        raise NotSeparableError(force_words(verdict), verdict)
    try:
        return solve(scene.system, scene.coordinates)
    except NotSeparableError as error:
        text = f'{error}; or write method = "integrate" in the scene'
        raise NotSeparableError(text, error.verdict) from error


def first_arguments(scene: Question) -> dict[str, Any]:
    """Return the arguments of the first motion, as the scene gives them.

    Returns:
        Keywords of ``Solution.motion``.
    """
    start = required(scene.initial)
    given = {"q": start.q, "velocity": start.velocity, "p": start.p, "parameters": scene.parameters, "t0": start.t}
    return {name: value for name, value in given.items() if value is not None}


def _arc(
    scene: Question, solution: Solution, piece: FreeArc, timed: bool, free_motions: FreeMotions, rest: Estimate | None
) -> Arc:
    """Compute what is wanted of an arc."""
    names = [n for n in (*_FIELDS, "angles", "orbit") if n in scene.want and (n != "angles" or scene.times)]
    ends = rest if rest is not None else None if piece.ends is None else _moment(piece.ends, scene.digits)
    arc_motion = ArcMotion(scene, solution, piece)
    if piece.flight is None:
        without = tuple(word for word in scene.want if word not in _TIMED)  # no time wanted, no place needed
        source = arc_motion if timed or len(without) == len(scene.want) else ArcMotion(scene, solution, piece, without)
        begins = _moment(sp.sympify(piece.leg.arguments.get("t0", 0)), scene.digits)
        quantities = {n: _quantity(scene, piece, n, arc_motion() if n in _TIMED else source()) for n in names}
        return Arc(begins, ends, piece.events, piece.leg.turns, quantities, arc_motion)
    angles = tuple(c.name for c in scene.system.coordinates if c.domain.kind == "angle")
    begins, turns = _moment(piece.flight.begin, scene.digits, piece.flight.uncertainty), TurnsBefore(arc_motion, angles)
    if _OWN.isdisjoint(names):
        return Arc(begins, ends, piece.events, turns, free_motions.shared(piece, tuple(names)), arc_motion)

    def compute(name: str) -> object:
        return _quantity(scene, piece, name, arc_motion() if name in _OWN else free_motions.mirrored(piece))

    return Arc(begins, ends, piece.events, turns, OnDemand(tuple(names), compute), arc_motion)


def _quantity(scene: Question, piece: FreeArc, name: str, motion: Motion) -> object:
    if name == "angles":
        array = sampled(required(scene.times), scene.digits)
        return motion.angles(array[_mask(array, motion.t0, piece.ends)])
    return orbit_table(scene.orbit, motion) if name == "orbit" else getattr(motion, name)


def _mask(array: Numbers, begins: Any, ends: Any) -> Mask:
    """Return which times lie in [begins, ends)."""
    low, high = (t if t is None or array.dtype != float else float(t) for t in (begins, ends))
    inside = (array >= low).astype(bool)
    return inside if high is None else inside & (array < high).astype(bool)


def _moment(time: sp.Expr, digits: int, uncertainty: Mpf | int = 0) -> Estimate:
    """Return a time, exact or in many digits, as a number with its error."""
    value = to_bits(time)(bits_of(max(digits, 15))) if isinstance(time, sp.Expr) else time
    if digits <= 15:
        known = isinstance(time, sp.Rational) and sp.Rational(float(value)) == time
        return Estimate(float(value), 0.0 if known else abs(float(value)) * EPS + float(uncertainty))
    return Estimate(value, abs(value) * value.context.mpf(10) ** -digits + uncertainty)
