"""A motion with events, as smooth arcs: Hamilton–Jacobi on each, new constants from the exact state at every event.

    arc ──t(q) or a given time──▶ state at the event, many digits ──Δp──▶ constants recomputed ──▶ next arc

(Greenwood §3-2: an impulse changes the momenta and leaves the coordinates.) Between events nothing is approximated
by steps. The state handed on has ``GUARD`` digits more than the scene asks for, and as many again as the length
of the scene costs; what is exact (the place of a surface, ignorable momenta, a coordinate at rest) stays exact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from hjsolve.errors import NotConvergedError
from hjsolve.initial import to_bits
from hjsolve.motion import Motion
from hjsolve.numeric.arithmetic import multiprecision
from hjsolve.numeric.course import Frozen
from hjsolve.scenes.crossing import bits_of, crossings, exact
from hjsolve.scenes.events import Event, changed
from hjsolve.scenes.scene import Scene
from hjsolve.solution import Solution

GUARD = 10
MOST_EVENTS = 10_000
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
class Piece:
    """One arc before anything wanted is computed.

    Attributes:
        leg: its start. ends: the time of the events that end it, exact; None for the last.
        events: those events.
    """

    leg: Leg
    ends: sp.Expr | None
    events: tuple[Event, ...]


@dataclass(frozen=True)
class _Pending:
    """An event to come, and how many passages it still lets by."""

    event: Event
    left: int


def pieces(scene: Scene, solution: Solution, first: Mapping[str, Any]) -> list[Piece]:
    """Follow the motion from event to event.

    Args:
        scene: with its events.
        solution: of its system.
        first: the arguments of the first motion.

    Returns:
        The arcs in order; one where nothing happens.

    Raises:
        NotConvergedError: an event without a definite time, or more than ``MOST_EVENTS`` of them.
    """
    pending = [_Pending(event, event.passage) for event in scene.events]
    leg, found = Leg(first, {}), list[Piece]()
    horizon = scene.times.last if scene.times is not None else None
    digits = _digits(scene, horizon)
    while pending and len(found) < MOST_EVENTS:
        motion = solution.motion(**leg.arguments, digits=digits, want={"trajectory"})
        hit = _next(motion, pending, horizon)
        if hit is None:
            break
        time, happening = hit
        events = tuple(p.event for p in happening)
        found.append(Piece(leg, time, events))
        pending = _later(motion, pending, happening, time)
        leg = _after(motion, leg, time, events)
    if len(found) == MOST_EVENTS:
        raise NotConvergedError(f"more than {MOST_EVENTS} events before the last time; shorten the scene")
    return [*found, Piece(leg, None, ())]


def _digits(scene: Scene, horizon: sp.Expr | None) -> int:
    """Digits of the state at events: a phase loses as many as the time has before the point."""
    span = abs(float(horizon)) + 1 if horizon is not None else 1e3
    return max(scene.digits, 15) + GUARD + math.ceil(math.log10(span))


def _next(motion: Motion, pending: list[_Pending], horizon: sp.Expr | None) -> tuple[sp.Expr, list[_Pending]] | None:
    """The earliest event, and those at the same time; None where nothing happens before the end."""
    bits = bits_of(motion.digits)
    times = [(_time(motion, p, horizon), p) for p in pending]
    ahead = [(t, p) for t, p in times if t is not None and not (horizon is not None and t > horizon)]
    if not ahead:
        return None
    first = min((t for t, _ in ahead), key=lambda t: to_bits(t)(bits))
    if any(to_bits(first)(64) > end.value for end in motion.boundary_times.values()):
        return None
    slack = multiprecision(64).mpf(10) ** (8 - motion.digits) * max(1, abs(to_bits(first)(64)))
    return first, [p for t, p in ahead if abs(to_bits(t - first)(bits)) <= slack]


def _time(motion: Motion, pending: _Pending, horizon: sp.Expr | None) -> sp.Expr | None:
    event = pending.event
    if event.time is not None:
        return event.time
    assert event.coordinate is not None
    assert event.value is not None
    time = next(crossings(motion, event.coordinate, event.value, horizon, pending.left), None)
    return None if time is None else exact(time, motion.digits)


def _later(motion: Motion, pending: list[_Pending], happening: list[_Pending], time: sp.Expr) -> list[_Pending]:
    """What is still to come: walls stay, impulses are spent, passages of the others are counted down."""
    result = []
    slack = sp.Rational(10) ** (8 - motion.digits) * sp.Max(1, abs(time))
    for p in pending:
        if p in happening:
            if p.event.kind == "wall":
                result.append(p)
            continue
        if p.left and p.event.coordinate is not None and p.event.value is not None:
            passed = sum(1 for _ in crossings(motion, p.event.coordinate, p.event.value, time + slack))
            p = replace(p, left=p.left - passed)
        result.append(p)
    return result


def _after(motion: Motion, leg: Leg, time: sp.Expr, events: tuple[Event, ...]) -> Leg:
    """The state just after the events, exact where it can be."""
    system, given = motion.solution.system, motion.initial.values
    state = motion.at(to_bits(time)(bits_of(motion.digits)))
    surfaces = {e.coordinate: e.value for e in events if e.coordinate is not None}
    resting = {name for name, place in motion.located.items() if isinstance(place.course, Frozen)}
    q, values, turns = {}, dict(given), dict(leg.turns)
    for c in system.coordinates:
        if c.name in resting:
            q[c.name], values[c.momentum] = given[c.symbol], given[c.momentum]
        else:
            q[c.name] = exact(state.q[c.name], motion.digits)
            if c.name in motion.located:
                values[c.momentum] = exact(state.p[c.name], motion.digits)
        if c.name in surfaces and c.domain.kind != "angle":
            q[c.name] = surfaces[c.name]
        values[c.symbol] = q[c.name]
        if c.domain.kind == "angle":
            turns[c.name] = turns.get(c.name, 0) + int(state.turns[c.name]) - whole_turns(q[c.name])
    for event in events:
        p = changed(event, system, values)
        values |= {c.momentum: p[c.name] for c in system.coordinates}
    arguments = {
        "q": q, "p": {c.name: values[c.momentum] for c in system.coordinates},
        "parameters": {p.name: given[p.symbol] for p in system.parameters}, "t0": time,
    }  # fmt: skip
    return Leg(arguments, turns)


def whole_turns(angle: sp.Expr) -> int:
    """How many turns an angle has beyond its principal value in (−π, π]."""
    return int(sp.ceiling((angle - sp.pi) / (2 * sp.pi)))
