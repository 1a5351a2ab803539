"""A motion with events, as smooth arcs: Hamilton–Jacobi on each, new constants from the exact state at every event.

    arc ──t(q) or a given time──▶ state at the event, many digits ──Δp──▶ constants recomputed ──▶ next arc

(Greenwood §3-2: an impulse changes the momenta and leaves the coordinates.) Between events nothing is approximated
by steps. The state handed on has ``GUARD`` digits more than the scene asks for, and as many again as the length
of the scene costs; what is exact (the place of a surface, ignorable momenta, a coordinate at rest) stays exact.
Where a bounce changes only signs nothing is recomputed: see ``reflections``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import InvalidInputError, NotConvergedError, required
from hjsolve.mechanics.system import velocities
from hjsolve.motion.initial_data import number_is_zero, read_initial_data, to_bits
from hjsolve.motion.motion import Motion
from hjsolve.scenes.crossing import as_rational, bits_of, crossings, surface_crossings
from hjsolve.scenes.events import Event, Pending, changed, once
from hjsolve.scenes.impact_budgets import ImpactBudget, budgets
from hjsolve.scenes.question import Question
from hjsolve.scenes.reflecting_walls import Mirrors, mirrors
from hjsolve.scenes.reflections import Flight, Free
from hjsolve.scenes.resting_contact import Rest, Settling, acceleration
from hjsolve.scenes.walk_along_bounces import walk
from hjsolve.solution.quadratures import Solution

GUARD = 10
MOST_EVENTS, MOST_BOUNCES, _LOOK = 10_000, 1_000_000, 40
"""Events that change constants, bounces that change only signs; events after which it is judged how many will come."""
Turns = Mapping[str, int]


@dataclass(frozen=True, eq=False)
class Leg:
    """Where an arc starts.

    Attributes:
        arguments: for ``solution.motion``, exact.
        turns: angle → whole turns made before.
    """

    arguments: Mapping[str, Any]
    turns: Turns


@dataclass(frozen=True, eq=False)
class FreeArc:
    """One arc before anything wanted is computed.

    Attributes:
        leg: its start; of an arc that is a flight, that of the free motion.
        ends: the time of the events that end it, exact or in many digits; None for the last.
        events: those events.
        free, flight: the free motion that it is part of, and how; None where it has constants of its own.
    """

    leg: Leg
    ends: Any
    events: tuple[Event, ...]
    free: Free | None = None
    flight: Flight | None = None


@dataclass(frozen=True, eq=False)
class Change:
    """The state just before events that change constants.

    Attributes:
        motion: that led there.
        time: exact.
        events: that happen.
        q: coordinate → position, many digits or exact; angles in (−π, π].
        p: momenta.
        turns: of the angles.
    """

    motion: Motion
    time: sp.Expr
    events: tuple[Event, ...]
    q: Mapping[str, sp.Expr | Mpf]
    p: Mapping[str, sp.Expr | Mpf]
    turns: Turns


@dataclass(frozen=True, eq=False)
class Stretch:
    """Arcs up to a change of constants, or to the end, where ``change`` is None; and what is still to come then."""

    pieces: list[FreeArc]
    pending: list[Pending]
    change: Change | None


@dataclass(frozen=True, eq=False)
class FollowedArcs:
    """How far a motion was followed.

    Attributes:
        arcs: in order, one where nothing happens.
        rest: how the scene ended early, if a wall keeps the body.
        impacts: what each impact did, in order.
        leg: the state from which it goes on under a constraint that lasts; None where there is none.
        pending: what is still to come then.
        digits: of the states at events.
    """

    arcs: list[FreeArc]
    rest: Rest | None = None
    impacts: tuple[ImpactBudget, ...] = ()
    leg: Leg | None = None
    pending: tuple[Pending, ...] = ()
    digits: int = 15


def free_arcs(scene: Question, solution: Solution, first: Mapping[str, Any]) -> FollowedArcs:
    """Follow the motion from event to event.

    Args:
        scene: with its events.
        solution: of its system.
        first: the arguments of the first motion.

    Returns:
        The arcs, up to a constraint that lasts.

    Raises:
        NotConvergedError: an event without a definite time, or more than ``MOST_EVENTS`` of them.
    """
    pending = [Pending(event, event.passage) for event in scene.events]
    _refuse_rest_on_a_wall(scene, solution, first)
    leg, found = Leg(first, {}), list[FreeArc]()
    horizon = scene.times.last if scene.times is not None else None
    digits = _digits(scene, horizon)
    turning = mirrors(solution) if any(e.kind == "wall" for e in scene.events) else None
    settling: Settling | None = None
    happened: list[Mpf] = []
    impacts = list[ImpactBudget]()
    for _ in range(MOST_EVENTS):
        if not pending:
            return FollowedArcs([*found, FreeArc(leg, None, ())], None, tuple(impacts))
        stretch = _flown(solution, leg, pending, horizon, digits, turning)
        stretch = stretch or _one_arc(solution, leg, pending, horizon, digits)
        found, change, pending = found + stretch.pieces, stretch.change, stretch.pending
        if change is None:
            return FollowedArcs(found, None, tuple(impacts))
        before, leg = change, _after(change, leg.turns)
        impacts += budgets(before.motion, before.time, once(before.events), before.q, before.p, leg.arguments["p"])
        if any(e.lasts for e in before.events):
            return FollowedArcs(found, None, tuple(impacts), leg, tuple(pending), digits)
        happened.append(to_bits(change.time)(64))
        _refuse_too_many(happened, horizon)
        if all(e.elastic or e.kind != "wall" for e in once(change.events)):
            settling = None
            continue
        settling = settling or Settling(scene, change.motion.initial.values, digits)
        rest = settling.landed(change.events, change.time, leg.arguments, _side(change), pending)
        if rest is not None:
            return FollowedArcs(_ended(found, leg, rest), rest, tuple(impacts))
    raise NotConvergedError(f"more than {MOST_EVENTS} events before the last time; shorten the scene")


def _refuse_too_many(happened: list[Mpf], horizon: sp.Expr | None) -> None:
    """Say early that there will be too many events, where they come evenly or ever later."""
    if len(happened) != _LOOK or horizon is None:
        return
    before, last = happened[-2] - happened[-3], happened[-1] - happened[-2]
    if last >= before and (to_bits(horizon)(64) - happened[-1]) > 2 * MOST_EVENTS * last:
        raise NotConvergedError(
            f"{_LOOK} events came before t = {float(happened[-1]):.6g}; up to the last time there would be more than "
            f"{MOST_EVENTS}: shorten the scene"
        )


def _refuse_rest_on_a_wall(scene: Question, solution: Solution, first: Mapping[str, object]) -> None:
    """Refuse a body at rest on a wall, and drawn away from there: nothing says on which side of it the body is."""
    walls = [e for e in scene.events if e.kind == "wall"]
    if not walls:
        return
    system = solution.system
    given = {name: first.get(name) for name in ("q", "velocity", "p", "parameters")}
    values = read_initial_data(solution, **given).values  # type: ignore[arg-type]
    for wall in walls:
        c = system.coordinate(str(wall.coordinate))
        speed = velocities(system)[c.name]
        if all(number_is_zero(x.subs(values)) for x in (c.symbol - wall.value, speed)) and not number_is_zero(
            acceleration(system, c.name).subs(values)
        ):
            raise InvalidInputError(
                f"initial: the motion starts at rest on the {wall}, and its side is not determined; start it a "
                "little to one side, or with a velocity"
            )


def _digits(scene: Question, horizon: sp.Expr | None) -> int:
    """Return the digits of the state at events: a phase loses as many as the time has before the point."""
    span = abs(to_bits(horizon)(64)) + 1 if horizon is not None else 1000
    return max(scene.digits, 15) + GUARD + math.ceil(multiprecision(64).log10(span))


# ------------------------------------------------------------------------------- bounces that change only signs
def _flown(
    solution: Solution, leg: Leg, pending: list[Pending], horizon: sp.Expr | None, digits: int, turning: Mirrors | None
) -> Stretch | None:
    """Walk along the bounces of one free motion; None where that does not serve."""
    if turning is None or not any(p.event.kind == "wall" for p in pending):
        return None
    motion = solution.motion(**{**leg.arguments, "t0": 0}, digits=digits, want={"trajectory"})
    free = Free(motion, turning)
    if not free.serves([p.event for p in pending]):
        return None
    bits = free.context.prec
    now = free.start(to_bits(sp.sympify(leg.arguments.get("t0", 0)))(bits))
    flown = walk(free, now, pending, None if horizon is None else to_bits(horizon)(bits), MOST_BOUNCES)
    found = [FreeArc(leg, time, events, free, flight) for flight, time, events in flown.arcs]
    if len(found) == MOST_BOUNCES:
        raise NotConvergedError(f"more than {MOST_BOUNCES} bounces before the last time; shorten the scene")
    if not flown.stopped:
        return Stretch([*found, FreeArc(leg, None, (), free, now.flight())], flown.pending, None)
    last = found[-1]
    left = [p for p in flown.pending if p.event not in last.events or p.event.kind == "wall"]
    time = last.ends if isinstance(last.ends, sp.Expr) else as_rational(last.ends, digits)
    q, p, turns = free.state(now)
    return Stretch(found, left, Change(motion, time, last.events, q, p, turns))


# --------------------------------------------------------------------------------------------- one arc at a time
def _one_arc(solution: Solution, leg: Leg, pending: list[Pending], horizon: sp.Expr | None, digits: int) -> Stretch:
    """Return the arc up to the next event, whatever it is."""
    motion = solution.motion(**leg.arguments, digits=digits, want={"trajectory"})
    hit = _next(motion, pending, horizon)
    if hit is None:
        return Stretch([FreeArc(leg, None, ())], pending, None)
    time, happening = hit
    events = tuple(p.event for p in happening)
    state = motion.at(to_bits(time)(bits_of(motion.digits)))
    if not all(x.context.isfinite(x) for x in (*state.q.values(), *state.p.values())):
        raise NotConvergedError(f"the motion ends, or is too far out for its numbers, before {events[0]}")
    given, system = motion.initial.values, solution.system_as_given
    if solution.chart is not None:
        q, p = (_known(group, bound) for group, bound in ((state.q, state.error.q), (state.p, state.error.p)))
        return Stretch([FreeArc(leg, time, events)], _later(motion, pending, happening, time),
                       Change(motion, time, events, q, p, {}))  # fmt: skip
    resting = {name for name, place in motion.separated.located.items() if place.coordinate_motion.rests}
    q = {c.name: given[c.symbol] if c.name in resting else state.q[c.name] for c in system.coordinates}
    p = {c.name: given[c.momentum] if c.name in resting or c.name not in motion.separated.located else state.p[c.name]
         for c in system.coordinates}  # fmt: skip
    change = Change(motion, time, events, q, p, {name: int(n) for name, n in state.turns.items()})
    return Stretch([FreeArc(leg, time, events)], _later(motion, pending, happening, time), change)


def _known(values: Mapping[str, Mpf], bounds: Mapping[str, Mpf]) -> dict[str, sp.Expr | Mpf]:
    """Return numbers of a state; what is no larger than its error is zero, as in a plane that the motion stays in."""
    return {name: sp.S.Zero if abs(x) <= bounds[name] else x for name, x in values.items()}


def _next(motion: Motion, pending: list[Pending], horizon: sp.Expr | None) -> tuple[sp.Expr, list[Pending]] | None:
    """Return the earliest event, and those at the same time; None where nothing happens before the end."""
    bits = bits_of(motion.digits)
    times = [(_time(motion, p, horizon), p) for p in pending]
    ahead = [(t, p) for t, p in times if t is not None and not (horizon is not None and t > horizon)]
    if not ahead:
        return None
    first = min((t for t, _ in ahead), key=lambda t: to_bits(t)(bits))
    if any(to_bits(first)(64) > end.value for end in motion.boundary_times.values()):
        return None
    tolerance = multiprecision(64).mpf(10) ** (8 - motion.digits) * max(1, abs(to_bits(first)(64)))
    return first, [p for t, p in ahead if abs(to_bits(t - first)(bits)) <= tolerance]


def _time(motion: Motion, pending: Pending, horizon: sp.Expr | None) -> sp.Expr | None:
    event = pending.event
    if event.time is not None:
        return event.time
    if event.surface is not None:
        time = next(surface_crossings(motion, event.surface, horizon), None)
        return None if time is None else as_rational(time, motion.digits)
    time = next(crossings(motion, required(event.coordinate), required(event.value), horizon, pending.left), None)
    return None if time is None else as_rational(time, motion.digits)


def _later(motion: Motion, pending: list[Pending], happening: list[Pending], time: sp.Expr) -> list[Pending]:
    """Return what is still to come: walls stay, impulses are spent, passages of the others are counted down."""
    result = []
    tolerance = sp.Rational(10) ** (8 - motion.digits) * sp.Max(1, abs(time))
    for p in pending:
        if p in happening:
            if p.event.kind == "wall":
                result.append(p)
            continue
        if p.left and p.event.coordinate is not None and p.event.value is not None:
            passed = sum(1 for _ in crossings(motion, p.event.coordinate, p.event.value, time + tolerance))
            p = replace(p, left=p.left - passed)
        result.append(p)
    return result


# ----------------------------------------------------------------------------------------------- after an event
def _after(change: Change, before: Turns) -> Leg:
    """Return the state just after the events, exact where it can be."""
    system, given = change.motion.solution.system_as_given, change.motion.initial.values
    digits = change.motion.digits
    surfaces = {e.coordinate: e.value for e in change.events if e.coordinate is not None}
    q, values, turns = {}, dict(given), dict(before)
    for c in system.coordinates:
        q[c.name], values[c.momentum] = (
            x if isinstance(x, sp.Expr) else as_rational(x, digits) for x in (change.q[c.name], change.p[c.name])
        )
        if c.name in surfaces and c.domain.kind != "angle":
            q[c.name] = surfaces[c.name]
        values[c.symbol] = q[c.name]
        if c.domain.kind == "angle":
            turns[c.name] = turns.get(c.name, 0) + change.turns[c.name] - whole_turns(q[c.name])
    for event in once(change.events):
        p = changed(event, system, values)
        values |= {c.momentum: p[c.name] for c in system.coordinates}
    arguments = {
        "q": q, "p": {c.name: values[c.momentum] for c in system.coordinates},
        "parameters": {p.name: given[p.symbol] for p in system.parameters}, "t0": change.time,
    }  # fmt: skip
    return Leg(arguments, turns)


def start_of(piece: FreeArc) -> Leg:
    """Return where an arc starts, worked out where it is a flight.

    Args:
        piece: an arc of the free motion.
    """
    if piece.flight is None or piece.free is None:
        return piece.leg
    free, flight = piece.free, piece.flight
    q, p, turns = free.state(free.back(flight))
    time = as_rational(flight.begin, free.motion.digits)
    return _after(Change(free.motion, time, (), q, p, turns), piece.leg.turns)


def _side(change: Change) -> int:
    """Return the side of a wall that a body comes from: −1 where its coordinate grows."""
    system, wall = change.motion.solution.system, next(e for e in change.events if e.kind == "wall")
    values = dict(change.motion.initial.values)
    for c in system.coordinates:
        for symbol, x in ((c.symbol, change.q[c.name]), (c.momentum, change.p[c.name])):
            values[symbol] = x if isinstance(x, sp.Expr) else as_rational(x, change.motion.digits)
    speed = to_bits(velocities(system)[str(wall.coordinate)].xreplace(values))(64)
    return -1 if speed > 0 else 1


def _ended(found: list[FreeArc], leg: Leg, rest: Rest) -> list[FreeArc]:
    """Return the arcs of a scene that ends at a wall."""
    end = Event("rest", f"{rest.wall.name} keeps the body", coordinate=rest.wall.coordinate, value=rest.wall.value)
    if rest.bounces == 1:
        return [*found[:-1], replace(found[-1], events=(*found[-1].events, end))]
    return [*found, FreeArc(leg, rest.limit, (end,))]


def whole_turns(angle: sp.Expr) -> int:
    """Return how many turns an angle has beyond its principal value in (−π, π].

    Args:
        angle: in radians, exact.
    """
    return int(sp.ceiling((angle - sp.pi) / (2 * sp.pi)))
