"""Bounces one after the other: what happens next, until something changes more than signs."""

from __future__ import annotations

from dataclasses import dataclass, replace

from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import NotConvergedError, required
from hjsolve.motion.initial_data import to_bits
from hjsolve.scenes.events import Event, Pending, once
from hjsolve.scenes.reflections import Candidate, Flight, Free, Now

_LOOK = 1000
"""Bounces after which it is judged how many there will be."""


@dataclass(frozen=True, eq=False)
class Flown:
    """A walk along a bouncing motion.

    Attributes:
        arcs: with the times and events that end them.
        pending: what is still to come, the last events among it.
        stopped: True where the last events change more than signs and are still to be carried out.
    """

    arcs: list[tuple[Flight, Mpf, tuple[Event, ...]]]
    pending: list[Pending]
    stopped: bool


def walk(free: Free, now: Now, pending: list[Pending], horizon: Mpf | None, most: int) -> Flown:
    """Follow a bouncing motion until an event that changes more than signs, or until nothing more happens.

    Args:
        free: the free motion.
        now: the beginning; left just before the last event, or after it where the walk is over.
        pending: what is to come.
        horizon: the last time of interest.
        most: arcs.

    Raises:
        NotConvergedError: many more bounces than ``most`` would come before the horizon.
    """
    found: list[tuple[Flight, Mpf, tuple[Event, ...]]] = []
    flight, begin = now.flight(), now.time
    while len(found) < most:
        if len(found) == _LOOK and horizon is not None and (horizon - begin) * _LOOK > 2 * most * (now.time - begin):
            raise NotConvergedError(
                f"{_LOOK} bounces came before t = {float(now.time):.6g}; up to t = {float(horizon):.6g} there would be "
                f"more than {most}: shorten the scene"
            )
        tolerance = free.context.mpf(10) ** (8 - free.motion.digits) * max(1, abs(now.time))
        ahead = _ahead(free, now, pending, tolerance)
        first = min((time for time, _, _ in ahead), default=None)
        if first is None or (horizon is not None and first > horizon):
            break
        free.advance(now, first)
        hits = [(p, land) for time, p, land in ahead if time - first <= tolerance]
        now.uncertainty += max(time - first for time, _, _ in ahead if time - first <= tolerance)
        for _, land in hits:
            land(now)
        happening = [p for p, _ in hits if not p.left]
        passed = [p for p, _ in hits if p.left]
        pending = [replace(p, left=p.left - 1) if p in passed else p for p in pending]
        if not happening:
            continue
        events = tuple(p.event for p in happening)
        exact = next((e.time for e in events if e.time is not None), first)
        found.append((flight, exact, events))
        if not all(e.elastic and e.coordinate in free.mirrors.even for e in once(events)):
            return Flown(found, pending, True)
        for name in dict.fromkeys(e.coordinate for e in events):
            free.reflect(now, required(name))
        free.reduce(now)
        flight = now.flight()
    return Flown(found, pending, False)


def _ahead(free: Free, now: Now, pending: list[Pending], tolerance: Mpf) -> list[Candidate]:
    """Return every event to come with its time."""
    ahead: list[Candidate] = []
    for p in pending:
        if p.event.time is not None:
            time = free.context.convert(to_bits(p.event.time)(free.context.prec))
            ahead.append((max(time, now.time), p, lambda _: None))
        elif (candidate := free.candidate(now, p, tolerance)) is not None:
            ahead.append(candidate)
    return ahead
