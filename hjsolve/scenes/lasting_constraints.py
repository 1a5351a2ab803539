"""A scene after a constraint that lasts: one more scene, in the coordinates that it leaves, carried back at the end.

    scene in q ──impact at t₁──▶ q = f(Q, t) ──▶ scene in Q from t₁ on, with what is still to come ──▶ states in q

Where the constraint moves, a frame is looked for in which the rest is autonomous (``extended.explicit_time``). Events
to come are carried over: a generalized impulse as (∂f/∂Q)ᵀ Q̂, a constraint a·q̇ = v as a ∂f/∂Q·Q̇ = v − a ∂f/∂t; a
wall, or a place of an event, only where it stands at a coordinate that is left.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import Integers, Numbers
from hjsolve.errors import InvalidInputError, NotSeparableError, required
from hjsolve.extended.change_of_frame import ChangeOfFrame
from hjsolve.extended.explicit_time import solve_in_time
from hjsolve.extended.impacts import ImpactForms
from hjsolve.extended.moving_frame_motion import CarriedOver
from hjsolve.extended.system_under_constraints import constrained, momenta_in, place_in, through
from hjsolve.mechanics.system import System, mass_matrix
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.state import Errors, State
from hjsolve.motion.tabulated import OnDemand
from hjsolve.scenes.arcs import FollowedArcs
from hjsolve.scenes.crossing import as_rational, bits_of
from hjsolve.scenes.events import Event, Pending
from hjsolve.scenes.question import InitialGroups, Question, Times
from hjsolve.scenes.results import Trajectory
from hjsolve.separation import DEFAULT_BUDGET
from hjsolve.solution.quadratures import FIND, Solution, solve


@dataclass(frozen=True, eq=False)
class Afterwards:
    """What comes after a constraint that lasts.

    Attributes:
        question: the scene in the coordinates that are left.
        solution: of its system.
        change: q = f(Q, t).
        turns: angle → whole turns made before.
    """

    question: Question
    solution: Solution
    change: ChangeOfFrame
    turns: Mapping[str, int]


def afterwards(scene: Question, followed: FollowedArcs, times: Times | None) -> Afterwards:
    """Write down the scene that goes on after the last arc.

    Args:
        scene: in q.
        followed: what came before, up to an event that lasts.
        times: those that are still to come.

    Raises:
        InvalidInputError: an event to come stands at a coordinate that is gone.
        InvalidSystemError: the constraint is not integrable.
        NotSeparableError: what is left does not separate.
    """
    leg, events = required(followed.leg), followed.arcs[-1].events
    texts = [text for e in events if e.lasts and e.forms is not None for text in e.forms.texts]
    change = constrained(scene.system, texts)
    change, solution = _solved(change)
    short = RationalNumbers(followed.digits)
    names = scene.system.symbols
    given = {**leg.arguments["q"], **leg.arguments["parameters"]}
    at = {names[name]: short(sp.sympify(x)) for name, x in given.items()}
    at[change.time] = short(sp.sympify(leg.arguments["t0"]))
    told = place_in(change, at, short)
    told |= {c.momentum: sp.sympify(leg.arguments["p"][c.name]) for c in scene.system.coordinates}
    P = momenta_in(change, told, short)
    pending = [_carried(p, change) for p in followed.pending]
    if solution.chart is not None and any(e.time is None for e in pending):
        raise InvalidInputError(
            "events: after the constraint only coordinates that are found separate; there only events at given times "
            "are computed"
        )
    left = change.system
    question = replace(
        scene, system=left, events=tuple(pending), times=times, orbit=None, coordinates=FIND,
        want=tuple(w for w in scene.want if w != "orbit"), forces={}, effects=(),
        initial=InitialGroups({c.name: told[c.symbol] for c in left.coordinates}, None, P, leg.arguments["t0"]),
        parameters={p.name: told[p.symbol] for p in left.parameters if p.symbol in told},
    )  # fmt: skip
    return Afterwards(question, solution, change, leg.turns)


def _solved(change: ChangeOfFrame) -> tuple[ChangeOfFrame, Solution]:
    """Return the change to the system that goes on, which holds no time, and its solution."""
    try:
        if change.system.time is None:
            return change, solved_or_found(change.system)
        found = solve_in_time(change.system, DEFAULT_BUDGET, FIND)
    except NotSeparableError as error:
        raise NotSeparableError(f"after the constraint that lasts: {error}", error.verdict) from error
    if found.frame is None or found.solution is None:
        raise NotSeparableError(
            "after the constraint that lasts T or V holds the time, and no frame without it was found", None
        )
    return through(change, found.frame), found.solution


def solved_or_found(system: System) -> Solution:
    """Solve a system in its coordinates, or in others that are found.

    Args:
        system: in the coordinates that a constraint leaves.

    Raises:
        NotSeparableError: it separates in none.
    """
    try:
        return solve(system)
    except NotSeparableError:
        return solve(system, FIND)


class RationalNumbers:
    """Numbers as the rationals of so many digits that they are.

    Args:
        digits: of the state at the event.
    """

    def __init__(self, digits: int):
        self._digits, self._bits = digits, bits_of(digits)

    def __call__(self, x: sp.Expr) -> sp.Expr:
        """Return the rational number nearest to a number, in so many digits."""
        return x if x.is_Rational else as_rational(to_bits(x)(self._bits), self._digits)

    def without(self, x: sp.Expr, terms: Iterable[sp.Expr]) -> sp.Expr:
        """Return the number; 0 where it is no larger than the rounding of its terms."""
        value, size = self(x), sum(abs(self(term)) for term in terms)
        return sp.S.Zero if abs(value) <= size * sp.Rational(10) ** (4 - self._digits) else value


# --------------------------------------------------------------------------------------------- events to come
def _carried(pending: Pending, change: ChangeOfFrame) -> Event:
    """Return an event in the coordinates that are left."""
    event, put = pending.event, {c.symbol: change.place[c.name] for c in change.original.coordinates}
    carried = replace(event, passage=pending.left)
    if event.coordinate is not None:
        carried = replace(carried, coordinate=_left(event, change))
    if event.surface is not None:
        carried = replace(carried, surface=event.surface.xreplace(put))
    if event.forms is not None:
        return replace(carried, forms=_forms(event.forms, change, put))
    jump = event.momentum
    if event.velocity is not None:
        old = change.original.coordinates
        faster = sp.Matrix([event.velocity.get(c.name, sp.S.Zero) for c in old])
        pushed = mass_matrix(change.original).xreplace(put) * faster
        jump = {c.name: pushed[i] for i, c in enumerate(old)}
    if jump is None:
        return carried
    momentum = {
        Q.name: sp.Add(*(x * sp.diff(change.place[name], Q.symbol) for name, x in jump.items()))
        for Q in change.system.coordinates
    }
    return replace(carried, momentum=momentum, velocity=None)


def _left(event: Event, change: ChangeOfFrame) -> str:
    f = change.place[str(event.coordinate)]
    name = next((c.name for c in change.system.coordinates if c.symbol == f), None)
    if name is None:
        raise InvalidInputError(
            f"events: {event} refers to {event.coordinate}, which the constraint eliminates ({event.coordinate} = {f})"
        )
    return name


def _forms(forms: ImpactForms, change: ChangeOfFrame, put: Mapping[sp.Symbol, sp.Expr]) -> ImpactForms:
    """Return the constraint a ∂f/∂Q·Q̇ = v − a ∂f/∂t, and its text."""
    old, new = change.original.coordinates, change.system.coordinates
    J = sp.Matrix([[sp.diff(change.place[c.name], Q.symbol) for Q in new] for c in old])
    drift = sp.Matrix([sp.diff(change.place[c.name], change.time) for c in old])
    a = sp.Matrix(forms.rows).xreplace(dict(put))
    rows, speeds = a * J, sp.Matrix(forms.speeds).xreplace(dict(put)) - a * drift
    levels = tuple(None if g is None else g.xreplace(dict(put)) for g in forms.levels)
    texts = []
    for k, g in enumerate(levels):
        terms = " + ".join(f"({x})*dot({Q.name})" for x, Q in zip(rows.row(k), new, strict=True) if x != 0)
        texts.append(f"{terms} = {speeds[k]}" if g is None else f"{g} = 0")
    return ImpactForms(tuple(texts), tuple(map(tuple, rows.tolist())), tuple(speeds), forms.restitution, levels)


# ------------------------------------------------------------------------------------------------ states in q
def carried_back(after: Afterwards, path: Trajectory, digits: int) -> Trajectory:
    """Return a trajectory in the coordinates before the constraint.

    Args:
        after: the change, and the turns before.
        path: in the coordinates left.
        digits: of the scene.
    """
    values = {after.change.system.symbols[n]: sp.sympify(x) for n, x in after.question.parameters.items()}
    state = State(path.t, path.q, path.p, path.velocity, path.turns, path.status, path.errors)
    found = CarriedOver(after.change, values, digits).state(state, path.t)
    kept = {n for n, f in after.change.place.items() if n in path.q and f == after.change.system.symbols[n]}
    old = after.change.original.coordinates
    q, turns = dict[str, Numbers](), dict[str, Integers]()
    for c in old:
        q[c.name] = path.q[c.name] if c.name in kept else found.q[c.name]
        if c.domain.kind == "angle":
            more = path.turns[c.name] if c.name in kept and c.name in path.turns else _turns(q[c.name])
            q[c.name] = q[c.name] if c.name in kept else _wrapped(q[c.name], more)
            turns[c.name] = more + after.turns.get(c.name, 0)

    def errors() -> Errors:
        bounds, own = found.error, path.error
        return Errors(
            {n: own.q[n] if n in kept else x for n, x in bounds.q.items()}, bounds.p,
            {n: own.velocity[n] if n in kept else x for n, x in bounds.velocity.items()},
        )  # fmt: skip

    velocity = {c.name: path.velocity[c.name] if c.name in kept else found.velocity[c.name] for c in old}
    return Trajectory(path.t, q, found.p, velocity, turns, path.status, path.arc, errors)


def _turns(angles: Numbers) -> Integers:
    return np.array([int(np.ceil((float(x) - np.pi) / (2 * np.pi))) for x in angles], dtype=int)


def _wrapped(angles: Numbers, turns: Integers) -> Numbers:
    if angles.dtype == float or not len(angles):
        return angles - 2 * np.pi * turns
    return angles - 2 * angles[0].context.pi * turns


def joined(first: Trajectory | None, second: Trajectory | None, places: Sequence[Integers], arcs: int) -> Trajectory:
    """Put the states before and after together.

    Args:
        first, second: None where there are no times.
        places: where the times of each stand among all.
        arcs: how many come before.
    """
    parts = [(p, x) for p, x in zip(places, (first, second), strict=True) if x is not None]
    count = sum(len(p) for p, _ in parts)

    def together(values: Sequence[Numbers]) -> Numbers:
        result = np.empty(count, dtype=np.result_type(*values))
        for (place, _), value in zip(parts, values, strict=True):
            result[place] = value
        return result

    def group(pick: str) -> OnDemand[Numbers]:
        names = tuple(getattr(parts[0][1], pick))
        return OnDemand(names, lambda n: together([np.asarray(getattr(x, pick)[n]) for _, x in parts]))

    def errors() -> Errors:
        bounds = [x.error for _, x in parts]

        def column(pick: str) -> OnDemand[Numbers]:
            return OnDemand(
                tuple(getattr(bounds[0], pick)), lambda n: together([np.asarray(getattr(b, pick)[n]) for b in bounds])
            )

        return Errors(column("q"), column("p"), column("velocity"))

    numbers = [np.asarray(x.arc) + (arcs if x is second else 0) for _, x in parts]
    return Trajectory(
        together([np.asarray(x.t) for _, x in parts]), group("q"), group("p"), group("velocity"), group("turns"),
        together([np.asarray(x.status) for _, x in parts]), together(numbers), errors,
    )  # fmt: skip
