"""Start a motion from initial data in the user's coordinates, in the separated ones or on an axis of their web."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from functools import partial
from typing import Any

import sympy as sp

from hjsolve import arguments
from hjsolve.coordinates.chart import Chart
from hjsolve.coordinates.charts.outer_map import SphereMap
from hjsolve.errors import HJSolveError, InternalError, InvalidInputError, NotConvergedError
from hjsolve.formulas.read import number
from hjsolve.motion.charted.charted_motion import ChartedMotion
from hjsolve.motion.charted.collisions import collision_times
from hjsolve.motion.charted.in_a_plane import motion_in_a_plane
from hjsolve.motion.charted.initial_map import at_singular_place, carried
from hjsolve.motion.initial_data import all_exact
from hjsolve.motion.motion import Motion
from hjsolve.motion.through_poles.continued_motion import motion_through_poles
from hjsolve.motion.through_umbilics.starting import start_at_umbilic
from hjsolve.motion.wanted import parts_of
from hjsolve.solution.quadratures import Solution


def start_charted(
    solution: Solution,
    *,
    q: Mapping[str, object],
    velocity: Mapping[str, object] | None = None,
    p: Mapping[str, object] | None = None,
    constants: Mapping[str, object] | None = None,
    signs: Mapping[str, int] | None = None,
    parameters: Mapping[str, object] | None = None,
    t0: object = 0,
    digits: int = 15,
    certified: bool = False,
    want: Iterable[str] | None = None,
) -> ChartedMotion:
    """Start a motion from initial data in the user's coordinates.

    Args:
        solution: with a chart.
        q, velocity, p: every one of the user's coordinates → number; velocity or p.
        constants, signs: refused; a motion is started in the user's coordinates.
        parameters: name → value, where it differs from the default.
        t0: time of the initial data.
        digits: relative digits wanted.
        certified: prove constants, turning points, actions, frequencies and periods.
        want: which of ``QUANTITIES`` will be asked; None for all.

    Raises:
        InvalidInputError: initial data that are no numbers, incomplete, or where the coordinates found are singular.
        MissingValueError: a parameter or an initial value is missing.
        NotConvergedError: a turning point or an integral could not be had to the digits asked.
    """
    chart = solution.chart
    if chart is None:
        raise InternalError("a charted motion of a solution without a chart")
    if constants is not None or signs is not None:
        raise InvalidInputError("constants, signs: with coordinates that were found, give velocity={…} or p={…}")
    digits = arguments.digits(digits)
    arguments.refuse_other(certified, bool, "certified", "True or False is needed")
    wanted = None if want is None else arguments.words(want, "want", '["actions", "periods"]')
    parts, exact_t0 = parts_of(wanted), number(t0, source="t0")
    given = {
        name: None if group is None else dict(group)
        for name, group in (("q", q), ("velocity", velocity), ("p", p), ("parameters", parameters))
    }
    in_plane = partial(
        motion_in_a_plane, chart, given, t0=exact_t0, digits=digits, certified=certified, want=wanted
    )  # fmt: skip
    motion: ChartedMotion | None
    try:
        initial = carried(solution, chart, q=q, velocity=velocity, p=p, parameters=parameters)
        within = motion_through_poles(solution, initial, exact_t0, digits, parts, certified=certified)
    except (InvalidInputError, NotConvergedError):
        motion = in_plane() or _at_a_focus(solution, chart, given, exact_t0, digits, parts)
        if motion is None:
            raise
    else:
        motion = _told(chart, within, parts)
        if "asymptotic" in motion.kinds.values():
            motion = in_plane() or motion
    return replace(motion, given=given, again=partial(_again, solution, given, exact_t0, wanted))


def _at_a_focus(
    solution: Solution, chart: Chart, given: Mapping[str, Any], t0: sp.Expr, digits: int, parts: frozenset[str]
) -> ChartedMotion | None:  # fmt: skip
    """A motion that starts at a focus of a web of the plane where V is smooth; None elsewhere."""
    if len(chart.symbols) != 2 or chart.linear or isinstance(chart.outer, SphereMap):
        return None
    try:
        values, speed, energy = at_singular_place(solution, chart, **given)
        place = {s.name: x for s, x in zip(chart.symbols, chart.place, strict=True)}
        within = start_at_umbilic(
            solution, values, dict(zip(place, speed, strict=True)), t0, digits, parts, place=place, energy=energy,
            exact=all_exact(given["q"], given["velocity"], given["p"], given["parameters"]),
        )  # fmt: skip
    except HJSolveError:
        return None
    return ChartedMotion(**{f.name: getattr(within, f.name) for f in fields(Motion)}, within=within)


def _told(chart: Chart, within: Motion, parts: frozenset[str]) -> ChartedMotion:
    """A motion in the separated coordinates, told in the user's; it ends where it collides with a focus."""
    motion = ChartedMotion(**{f.name: getattr(within, f.name) for f in fields(Motion)}, within=within)
    found = collision_times(chart, within) if "time" in parts else None
    if found is None:
        return motion
    name, ends = found
    times = {} if ends[1] is None else {name: ends[1]}
    kinds = motion.kinds if ends[1] is None else {**motion.kinds, name: "boundary"}
    return replace(motion, ends=ends, kinds=kinds, boundary_times=times, frequencies={}, periods={})


def _again(
    solution: Solution, given: Mapping[str, Any], t0: sp.Expr, want: frozenset[str] | None, digits: int,
    change: Mapping[str, Any],
) -> ChartedMotion:  # fmt: skip
    """Start a motion anew from what was given, with other digits or changed input."""
    return start_charted(solution, **{**given, **change}, t0=t0, digits=digits, want=want)
