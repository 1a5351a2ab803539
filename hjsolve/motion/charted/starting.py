"""Start a motion from initial data in the user's coordinates, in the separated ones or on an axis of their web."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import sympy as sp

from hjsolve.coordinates.chart import Chart
from hjsolve.coordinates.charts.outer_map import SphereMap
from hjsolve.errors import HJSolveError, InvalidInputError, NotConvergedError, required
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
    solution: Solution, given: Mapping[str, Any], *, t0: sp.Expr, digits: int, certified: bool,
    want: Iterable[str] | None,
) -> ChartedMotion:  # fmt: skip
    """Start a motion from initial data in the user's coordinates.

    Args:
        solution: with a chart.
        given: q, velocity, p and parameters in the user's coordinates, velocity or p; None for what is not given.
        certified: prove constants, turning points, actions, frequencies and periods.
        want: which of ``QUANTITIES`` will be asked; None for all.

    Raises:
        InvalidInputError: initial data that are no numbers, incomplete, or where the coordinates found are singular.
        MissingValueError: a parameter or an initial value is missing.
        NotConvergedError: a turning point or an integral did not converge to the digits asked.
    """
    chart, parts = required(solution.chart), parts_of(want)
    options: dict[str, object] = {"t0": t0, "digits": digits, "certified": certified, "want": want}
    try:
        initial = carried(solution, chart, **given)
        within = motion_through_poles(solution, initial, t0, digits, parts, certified=certified)
    except (InvalidInputError, NotConvergedError):
        elsewhere = motion_in_a_plane(chart, given, **options) or _at_a_focus(solution, chart, given, t0, digits, parts)
        if elsewhere is None:
            raise
        return elsewhere
    motion = in_users_coordinates(chart, within, parts)
    if "asymptotic" in motion.kinds.values():
        return motion_in_a_plane(chart, given, **options) or motion
    return motion


def _at_a_focus(
    solution: Solution, chart: Chart, given: Mapping[str, Any], t0: sp.Expr, digits: int, parts: frozenset[str]
) -> ChartedMotion | None:  # fmt: skip
    """Return a motion that starts at a focus of a web of the plane where V is smooth; None elsewhere."""
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
    return ChartedMotion.of(within)


def in_users_coordinates(chart: Chart, within: Motion, parts: frozenset[str]) -> ChartedMotion:
    """Return a motion in the separated coordinates, expressed in the user's; it ends where it collides with a focus.

    Args:
        chart: how the coordinates are tied to the user's.
        within: the motion in the separated coordinates.
    """
    motion = ChartedMotion.of(within)
    found = collision_times(chart, within) if "time" in parts else None
    if found is None:
        return motion
    name, ends = found
    times = {} if ends[1] is None else {name: ends[1]}
    kinds = motion.kinds if ends[1] is None else {**motion.kinds, name: "boundary"}
    return replace(motion, ends=ends, kinds=kinds, boundary_times=times, frequencies={}, periods={})
