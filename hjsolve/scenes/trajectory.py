"""The trajectory of a scene: its states at the times wanted, put together from the arcs."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.number_types import Integers, Mpf, Numbers, Reals
from hjsolve.errors import InvalidInputError, required
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.state import Errors, State
from hjsolve.motion.tabulated import OnDemand
from hjsolve.motion.times import LONGEST
from hjsolve.scenes.arcs import FreeArc
from hjsolve.scenes.crossing import bits_of
from hjsolve.scenes.question import Question, Times
from hjsolve.scenes.resting_contact import Rest
from hjsolve.scenes.results import Arc, Trajectory
from hjsolve.scenes.states_along_bounces import along


@dataclass(frozen=True, eq=False)
class _Part:
    """Some of the times: a slice of them, whole turns made before, and the states."""

    places: Integers
    turns: Mapping[str, int]
    state: State


def sampled(times: Times, digits: int) -> Numbers:
    """Return the times as an array: doubles where they are evenly spaced and 15 digits serve, exact numbers otherwise.

    Args:
        times: evenly spaced, or a list.

    Returns:
        Shape (m,); doubles, or exact numbers in an object array.

    Raises:
        InvalidInputError: a time beyond the range in which doubles tell times apart.
    """
    if times.doubles:
        return np.array(times.doubles)
    if digits <= FLOAT_DIGITS and not times.listed:
        ends = float(times.start), float(times.stop)
        if not max(map(abs, ends)) < LONGEST:
            raise InvalidInputError(f"times: one is beyond {LONGEST:.0e}; write times in another unit")
        return np.linspace(*ends, times.count)
    return np.array(times.exact(), dtype=object)


def belongings(times: Numbers, pieces: Sequence[FreeArc], rest: Rest | None) -> Integers:
    """Return the arc of each time, which is in [begin, end); −1 from the last bounce on where a wall keeps the body.

    Args:
        times: doubles or exact numbers, shape (m,).
        pieces: the arcs, in the order of time.
        rest: how the scene ended early; None where it did not.

    Returns:
        Numbers of the arcs, shape (m,).
    """
    ends = [piece.ends for piece in pieces if piece.ends is not None]
    if rest is not None and rest.bounces > 1:
        ends = ends[:-1]  # that is the limit, and what comes before it is not one arc
    if times.dtype == float:
        found = np.searchsorted(np.array([float(end) for end in ends]), times, side="right")
    else:
        exact = [end if isinstance(end, sp.Expr) else sp.Rational(*_ratio(end)) for end in ends]
        found = np.array([bisect.bisect_right(exact, t) for t in times], dtype=int)
    if rest is not None:
        found = np.where(found == len(ends), -1, found)
    return found


def _ratio(value: Mpf) -> tuple[int, int]:
    """Return an ``mpf`` as a fraction."""
    sign, mantissa, exponent, _ = value._mpf_
    top = int(-mantissa if sign else mantissa)
    return (top << exponent, 1) if exponent >= 0 else (top, 1 << -exponent)


def trajectory_of(
    scene: Question,
    arcs: Sequence[Arc],
    pieces: Sequence[FreeArc],
    rest: Rest | None,
    whole: Callable[[FreeArc], Motion],
) -> Trajectory:
    """Put the states of the arcs together; a quantity is worked out when it is read.

    Args:
        scene: with its times.
        arcs, pieces: in order.
        rest: how the scene ended early.
        whole: the free motion of a flight to the digits of the scene, started at t₀ = 0.
    """
    times = sampled(required(scene.times), scene.digits)
    number = belongings(times, pieces, rest)
    parts = _parts(times, number, arcs, pieces, whole)
    if rest is not None and (number < 0).any():
        parts.append(_Part(np.nonzero(number < 0)[0], {}, _resting(scene, rest, times[number < 0])))
    number = np.where(number < 0, len(arcs) - 1, number)
    coordinates = scene.system.coordinates
    names, angles = (tuple(c.name for c in coordinates if kind in ("any", c.domain.kind)) for kind in ("any", "angle"))

    def joined(pick: Callable[[_Part], Any]) -> Any:
        found = [(part.places, np.asarray(pick(part))) for part in parts]
        result = np.empty(times.shape, dtype=np.result_type(*(values.dtype for _, values in found)) if found else float)
        for places, values in found:
            result[places] = values
        return result

    def view(pick: Callable[[_Part, str], Any], chosen: tuple[str, ...] = names) -> OnDemand[Any]:
        return OnDemand(chosen, lambda name: joined(lambda part: pick(part, name)))

    def errors() -> Errors:
        bounds = {id(part): part.state.error for part in parts}
        q, p = view(lambda part, n: bounds[id(part)].q[n]), view(lambda part, n: bounds[id(part)].p[n])
        return Errors(q, p, view(lambda part, n: bounds[id(part)].velocity[n]))

    return Trajectory(
        joined(lambda part: _numbers(np.asarray(part.state.t), scene.digits)), view(lambda part, n: part.state.q[n]),
        view(lambda part, n: part.state.p[n]), view(lambda part, n: part.state.velocity[n]),
        view(lambda part, n: part.state.turns[n] + part.turns.get(n, 0), angles),
        joined(lambda part: part.state.status), number, errors,
    )  # fmt: skip


def _parts(
    times: Numbers, number: Integers, arcs: Sequence[Arc], pieces: Sequence[FreeArc], whole: Callable[[FreeArc], Motion]
) -> list[_Part]:
    """Return the flights of one free motion together, other arcs one by one; those without a time are left out."""
    order = np.argsort(number, kind="stable")
    ordered = number[order]
    found: list[_Part] = []
    first = 0
    for free, group in itertools.groupby(pieces, key=lambda piece: piece.free):
        members = list(group)
        spans = [(first, members)] if free is not None else [(first + k, [one]) for k, one in enumerate(members)]
        for begin, these in spans:
            low, high = np.searchsorted(ordered, [begin, begin + len(these)])
            places = np.sort(order[low:high])
            if not len(places):
                continue
            if free is None:
                found.append(_Part(places, arcs[begin].turns, arcs[begin].motion.at(times[places])))
                continue
            used, which = np.unique(number[places] - begin, return_inverse=True)
            flights = [f for k in used if (f := these[k].flight) is not None]
            state = along(free, whole(these[0]), flights, which, times[places])
            found.append(_Part(places, these[0].leg.turns, state))
        first += len(members)
    return found


def _resting(scene: Question, rest: Rest, times: Numbers) -> State:
    """Return the state of a body that a wall keeps; not a number where other coordinates still move."""
    kind = object if scene.digits > FLOAT_DIGITS else float
    missing = rest.limit.context.nan if kind is object else np.nan

    def spread(value: float | Mpf) -> NDArray[Any]:
        return np.full(len(times), value if rest.alone else missing, dtype=kind)

    q = {name: spread(estimate.value) for name, estimate in rest.q.items()}
    p = {name: spread(estimate.value) for name, estimate in rest.p.items()}
    velocity = {name: spread(0 * rest.limit if kind is object else 0.0) for name in q}
    turns = {}
    for c in scene.system.coordinates:
        if c.domain.kind == "angle":
            turns[c.name] = np.full(len(times), int(np.ceil((float(rest.q[c.name].value) - np.pi) / (2 * np.pi))))
            q[c.name] = q[c.name] - 2 * (rest.limit.context.pi if kind is object else np.pi) * turns[c.name]

    def errors() -> Errors:
        """Before the limit the body still bounces: the lower, the less of the time is left (both fall like eⁿ)."""
        end = rest.limit + abs(rest.limit.context.convert(rest.time.error))
        left = [float(end - (t if times.dtype == float else to_bits(t)(end.context.prec))) for t in times]
        whole = float(end - rest.last) * float(rest.wall.restitution)
        share = np.array([2.0 if x > whole else 2 * x / whole if x > 0 else 0.0 for x in left])
        speed, push = (abs(float(x)) * share for x in (rest.speed, rest.push))
        height = speed * np.maximum(left, 0.0)

        def bound(own: float | Mpf, more: Reals) -> Reals:
            return np.where(rest.alone, float(own) + more, np.nan)

        return Errors(
            {name: bound(estimate.error, height) for name, estimate in rest.q.items()},
            {name: bound(estimate.error, push) for name, estimate in rest.p.items()},
            {name: bound(0, speed) for name in q},
        )

    return State(times, q, p, velocity, turns, np.full(len(times), "at_rest" if rest.alone else "ended"), errors)


def _numbers(times: Numbers, digits: int) -> Numbers:
    if times.dtype == float:
        return times
    if digits <= FLOAT_DIGITS:
        return np.array([float(t) for t in times])
    return np.array([to_bits(t)(bits_of(digits)) for t in times], dtype=object)
