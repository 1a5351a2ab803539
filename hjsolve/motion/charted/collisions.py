"""Collisions with an attracting focus, which the separated coordinates would carry the motion through.

In elliptic and parabolic coordinates h² V is finite at a focus where V is not: the separated equations are regular
there (Levi-Civita's regularisation) and turn the body back. A motion meets a focus exactly where one coordinate rests
at its value there while the other passes its own: along the axis. There it ends, with the time of the collision.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import AtTimes, Mpf
from hjsolve.coordinates.chart import Chart
from hjsolve.errors import HJSolveError
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.formulas_at_places import tape_of
from hjsolve.motion.motion import Motion
from hjsolve.motion.state import Errors, State
from hjsolve.motion.times import exact_numbers

Ends = tuple[Estimate | None, Estimate | None]
_BITS, _CLOSE = 600, 200  # a place 2⁻²⁰⁰ from a focus tells whether V h² vanishes there
_FOCI = {
    "elliptic": ((0, 0), (0, 1)), "elliptic cylinder": ((0, 0), (0, 1)), "prolate spheroidal": ((0, 0), (0, 1)),
    "parabolic": ((0, 0),), "parabolic cylinder": ((0, 0),), "rotational parabolic": ((0, 0),),
}  # fmt: skip
"""Foci by kind: the first two coordinates, in units of 1 and π where they are (μ, ν)."""


def collision_times(chart: Chart, motion: Motion) -> tuple[str, Ends] | None:
    """Return the coordinate that reaches a focus where V is infinite, and when: last before and first after t₀.

    Returns:
        None where the motion meets no such focus.
    """
    field = Multi(_BITS)
    tiny = field.context.mpf(2) ** -_CLOSE
    names = chart.coordinates[:2]
    start = [to_bits(motion.initial.values[chart.system.coordinate(name).symbol])(_BITS) for name in names]
    found: list[tuple[str, Ends]] = []
    for focus in _FOCI.get(chart.kind, ()):
        place = [focus[0] * field.context.pi, focus[1] * field.context.pi]
        for still, moving in ((0, 1), (1, 0)):
            # one coordinate must rest at its value of the focus: else the body passes it by
            rests = abs(abs(start[still]) - place[still]) < tiny and motion.kinds[names[still]] == "equilibrium"
            if rests and _infinite(chart, motion, place, field):
                ends = _times(motion, names[moving], place[moving])
                if ends != (None, None):
                    found.append((names[moving], ends))
    if not found:
        return None
    before = [ends[0] for _, ends in found if ends[0] is not None]
    after = [ends[1] for _, ends in found if ends[1] is not None]
    return found[0][0], (
        max(before, key=lambda e: float(e.value), default=None), min(after, key=lambda e: float(e.value), default=None),
    )  # fmt: skip


def _infinite(chart: Chart, motion: Motion, place: list[Mpf], field: Multi) -> bool:
    """Return whether h² V does not vanish at a focus, where h² does."""
    values, system = motion.initial.values, chart.system
    rest = [system.coordinate(name).symbol for name in chart.coordinates[2:]]
    fixed = [*rest, *(p.symbol for p in system.parameters)]
    close = field.context.mpf(2) ** -_CLOSE
    at = [place[0] + close, place[1] + close, *(to_bits(values[s])(_BITS) for s in fixed)]
    # next to the focus, not at it: h² V is 0·∞ there
    V, h2 = tape_of((system.potential, chart.scale[0]), (*chart.symbols[:2], *fixed)).run(field, at)
    return bool(abs(V * h2) > field.context.mpf(2) ** (-_CLOSE // 2))


def _times(motion: Motion, name: str, place: Mpf) -> Ends:
    """When a coordinate is at ±place last before and first after t₀; None where it never is."""
    ends: list[Estimate | None] = []
    for passage in (-1, 0):
        times = []
        # the web has every place twice, as (u, v) and (−u, −v)
        for value in {place, -place}:
            try:
                times.append(motion.time_at(name, value, passage))
            except HJSolveError:
                continue
        pick = max if passage else min
        ends.append(pick(times, key=lambda e: float(e.value), default=None))
    return ends[0], ends[1]


def between(ends: Ends, state: State) -> State:
    """Return a state whose numbers are NaN and whose status is ``reaches_boundary`` outside of the time it lasts.

    Args:
        ends: first and last time.
        state: of the motion carried through the collisions.
    """
    shape, exact = exact_numbers(state.t, "t")
    times = np.array([float(x) for x in exact]).reshape(shape)
    over = np.zeros(shape, dtype=bool)
    for end, side in zip(ends, (-1, 1), strict=True):
        if end is not None:
            # within the error of the collision it has happened: no state beyond it is told
            over |= side * (times - float(end.value)) >= -float(end.error)

    def cut(group: Mapping[str, AtTimes]) -> dict[str, AtTimes]:
        cleared = {name: np.where(over, np.nan, np.asarray(x)) for name, x in group.items()}
        return {name: x if shape else x.item() for name, x in cleared.items()}

    status = np.where(over, "reaches_boundary", state.status)

    def errors() -> Errors:
        return Errors(cut(state.error.q), cut(state.error.p), cut(state.error.velocity))

    return State(
        state.t, cut(state.q), cut(state.p), cut(state.velocity), {}, status if shape else status.item(), errors
    )
