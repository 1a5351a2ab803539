"""How a motion starts: in the coordinates it is solved in, or in the user's where these were changed to solve it.

``Solution.motion`` calls ``start``: make numbers of what is given, start in coordinates that run on through poles where
the motion meets some, and keep the input, so that the motion can be started anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import sympy as sp

from hjsolve import arguments
from hjsolve.coordinates.chart import Chart
from hjsolve.coordinates.charts.outer_map import SphereMap
from hjsolve.errors import ForbiddenPlaceError, HJSolveError, InvalidInputError, NotConvergedError, required
from hjsolve.formulas.read import number
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.quantities_given import in_units
from hjsolve.mechanics.system import kinetic_rest, mass_matrix
from hjsolve.motion.charted.charted_motion import ChartedMotion
from hjsolve.motion.charted.collisions import collision_times
from hjsolve.motion.charted.in_a_plane import motion_in_a_plane
from hjsolve.motion.charted.initial_map import at_singular_place, carried
from hjsolve.motion.initial_data import all_exact, clean, number_is_zero, read_initial_data, read_places, with_numbers
from hjsolve.motion.motion import Motion
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.through_poles.continued_motion import motion_through_poles
from hjsolve.motion.through_umbilics.starting import hint_at_umbilic, momenta_of, particle_mass, start_at_umbilic
from hjsolve.motion.tori.from_actions import start_on_torus
from hjsolve.motion.velocity_frame import COORDINATE, factors_of, lengths_in_units, rates_of
from hjsolve.motion.wanted import parts_of
from hjsolve.precision import one_at_a_time
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
    # where the separated coordinates are singular a plane or a focus may hold the motion, in other coordinates
    except (InvalidInputError, NotConvergedError):
        elsewhere = motion_in_a_plane(chart, given, **options) or _at_a_focus(solution, chart, given, t0, digits, parts)
        if elsewhere is None:
            raise
        return elsewhere
    motion = in_users_coordinates(chart, within, parts)
    # on the axis of a web a coordinate tends to a focus for ever; along the axis the body passes it
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
    # frequencies and periods are those of the motion that the regularised equations turn back at the focus
    times = {} if ends[1] is None else {name: ends[1]}
    kinds = motion.kinds if ends[1] is None else {**motion.kinds, name: "boundary"}
    return replace(motion, ends=ends, kinds=kinds, boundary_times=times, frequencies={}, periods={})


EXAMPLE = 'motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})'
_GROUPS = ("q", "velocity", "p", "constants", "signs", "parameters")


@dataclass(frozen=True, kw_only=True)
class StartGiven:
    """What a motion is started from; ``Solution.motion`` says what each of these is."""

    q: Mapping[str, object] | None = None
    velocity: Mapping[str, object] | None = None
    p: Mapping[str, object] | None = None
    constants: Mapping[str, object] | None = None
    signs: Mapping[str, int] | None = None
    actions: Mapping[str, object] | None = None
    angles: Mapping[str, object] | None = None
    kinds: Mapping[str, str] | None = None
    parameters: Mapping[str, object] | None = None
    t0: object = 0
    digits: int = FLOAT_DIGITS
    certified: bool = False
    want: Iterable[str] | None = None
    velocity_frame: str = COORDINATE

    @property
    def groups(self) -> dict[str, Any]:
        """The initial data by name, with None for what was not given."""
        return {name: getattr(self, name) for name in _GROUPS}


@one_at_a_time
def start(solution: Solution, given: StartGiven) -> Motion:
    """Start a motion; see ``Solution.motion``.

    Raises:
        InvalidInputError, MissingValueError, ForbiddenMotionError, NotConvergedError: as of ``Solution.motion``.
    """
    if given.actions is not None:
        others = ("velocity", "p", "constants", "signs")
        unused = {name: getattr(given, name) is not None for name in others}
        arguments.refuse_other(given.certified, bool, "certified", "True or False is needed")
        arguments.refuse_unused(unused, "actions={…} and angles={…} give the motion")
        return _on_torus(solution, given)
    unused = {"angles": given.angles is not None, "kinds": given.kinds is not None}
    arguments.refuse_unused(unused, "there are no actions={…}")
    if given.q is None:
        raise InvalidInputError(f"motion: no q={{…}}; write {EXAMPLE}")
    if solution.chart is not None and given.constants is not None:
        return _with_constants(solution, given)
    if _velocity_is_in_space(solution, given):
        return _with_velocity_in_space(solution, given)
    given = _checked(solution, _in_own_units(solution, given))
    motion = _as_given(solution, given) if solution.chart is None else _in_found_coordinates(solution, given)
    return _kept(solution, given, motion)


def _kept(solution: Solution, given: StartGiven, motion: Motion) -> Motion:
    """Keep the input with a motion, so that it can be started anew."""
    kept: dict[str, Any] = {name: None if group is None else dict(group) for name, group in given.groups.items()}
    again = partial(_again, solution, replace(given, **kept, certified=False))
    return replace(motion, given=kept, again=again)


def _in_own_units(solution: Solution, given: StartGiven) -> StartGiven:
    """Take units off, and turn lengths along unit vectors into rates of coordinates."""
    system = solution.system_as_given
    q, factors = in_units(system, required(given.q), "q"), factors_of(system, given.velocity_frame, given.velocity)
    if factors is None or given.velocity is None:
        velocity = in_units(system, given.velocity, "velocity")
    else:
        velocity = rates_of(system, q, lengths_in_units(system, given.velocity, factors), factors)
    constants = given.constants
    if solution.chart is None:
        alike = tuple((constant.symbol, constant.expression) for constant in solution.constants.values())
        constants = in_units(system, constants, "constants", alike)
    return replace(
        given, q=q, velocity=velocity, p=in_units(system, given.p, "p"), constants=constants,
        parameters=in_units(system, given.parameters, "parameters"), velocity_frame=COORDINATE,
    )  # fmt: skip


def _checked(solution: Solution, given: StartGiven) -> StartGiven:
    """Refuse what cannot be; times as exact numbers, words as a set."""
    if solution.chart is not None and given.signs is not None:
        raise InvalidInputError("signs: they belong to constants={…}, which are not there")
    digits = arguments.digits(given.digits)
    arguments.refuse_other(given.certified, bool, "certified", "True or False is needed")
    if given.certified and solution.chart is None:
        refuse_kinks(solution.system.kinks, "certified=True")
    return replace(given, digits=digits, want=_words(given.want), t0=number(given.t0, source="t0"))


def _words(want: Iterable[str] | None) -> frozenset[str] | None:
    return None if want is None else arguments.words(want, "want", '["actions", "periods"]')


def _as_given(solution: Solution, given: StartGiven) -> Motion:
    """Start a motion in the coordinates of its solution."""
    try:
        initial = read_initial_data(solution, **given.groups)
    except ForbiddenPlaceError as error:
        raise ForbiddenPlaceError(f"{error}{hint_at_umbilic(solution, required(given.q), given.parameters)}") from None
    parts = parts_of(given.want)
    return motion_through_poles(solution, initial, given.t0, given.digits, parts, certified=given.certified)


def _velocity_is_in_space(solution: Solution, given: StartGiven) -> bool:
    """Return True when the velocity is along the axes of the system's place, not the coordinates."""
    names, place = {c.name for c in solution.system.coordinates}, set(solution.system.place)
    velocity = given.velocity
    return solution.chart is None and isinstance(velocity, Mapping) and bool(velocity) and {*velocity} == place - names


def _with_velocity_in_space(solution: Solution, given: StartGiven) -> Motion:
    """Start with a velocity along the axes of the system's place: p = m (∂x/∂q)ᵀ v; at an umbilic by its direction."""
    system, q, velocity, parameters = solution.system, required(given.q), required(given.velocity), given.parameters
    along = {axis: number(value, source=f"velocity[{axis}]") for axis, value in velocity.items()}
    values = read_places(system, in_units(system, q, "q"), in_units(system, parameters, "parameters"))
    # M is regular: momenta are p = m Jᵀ v, and the start is an ordinary one
    if not any(number_is_zero(with_numbers(e, values)) for e in mass_matrix(system).diagonal()):
        return start(solution, replace(given, velocity=None, p=momenta_of(system, values, along)))
    given, exact = _checked(solution, given), all_exact(q, velocity, parameters)
    # the energy from the velocity in space: T of the coordinates is 0/0 at an umbilic
    potential = with_numbers(system.potential - kinetic_rest(system), values)
    energy = clean(particle_mass(system, values) * sp.Add(*(v**2 for v in along.values())) / 2 + potential)
    motion = start_at_umbilic(
        solution, values, along, given.t0, given.digits, parts_of(given.want),
        place=system.place, energy=energy, exact=exact,
    )  # fmt: skip
    return _kept(solution, given, motion)


def _in_found_coordinates(solution: Solution, given: StartGiven) -> Motion:
    """Start a motion in the user's coordinates."""
    data = {name: group for name, group in given.groups.items() if name not in ("constants", "signs")}
    return start_charted(
        solution, data, t0=given.t0, digits=given.digits, certified=given.certified, want=given.want
    )  # fmt: skip


def _with_constants(solution: Solution, given: StartGiven) -> Motion:
    """Start from constants and a place, both of the coordinates that were found; expressed in the user's."""
    names = [c.name for c in solution.system.coordinates]
    if isinstance(given.q, Mapping) and not set(given.q) & set(names):
        raise InvalidInputError(
            f"constants: they are those of the coordinates that were found, and so is q: {', '.join(names)}; "
            "in coordinates of your own give velocity={…} or p={…}"
        )
    within = replace(solution, chart=None)
    read = _checked(within, _in_own_units(within, given))
    motion = in_users_coordinates(required(solution.chart), _as_given(solution, read), parts_of(read.want))
    return _kept(solution, given, motion)


def _on_torus(solution: Solution, given: StartGiven) -> Motion:
    """Start a motion from actions and angles, those of the separated coordinates; expressed in the user's."""
    parts, digits = parts_of(_words(given.want)), arguments.digits(given.digits)
    parameters = in_units(solution.system, given.parameters, "parameters")
    well = _well(solution, given)
    torus = {"actions": given.actions, "angles": given.angles, "q": well, "kinds": given.kinds}
    data = {**torus, "parameters": parameters}
    motion = start_on_torus(solution, data, given.t0, digits, parts, certified=given.certified)
    if solution.chart is None:
        return motion
    again = partial(_again, solution, replace(given, certified=False))
    return replace(in_users_coordinates(solution.chart, motion, parts), given=motion.given, again=again)


def _well(solution: Solution, given: StartGiven) -> Mapping[str, object] | None:
    """Return a place in the well that is meant, in the coordinates that separate; the user's are carried there."""
    chart, q = solution.chart, given.q
    if chart is None or q is None or not set(q) & {c.name for c in chart.original.coordinates}:
        return q
    # only the place is wanted of what is carried over: any momentum does
    resting = {c.name: 0 for c in chart.original.coordinates}
    there = carried(solution, chart, q=q, velocity=None, p=resting, parameters=given.parameters)
    return {c.name: there.values[c.symbol] for c in solution.system.coordinates}


def _again(solution: Solution, given: StartGiven, digits: int, change: Mapping[str, Any]) -> Motion:
    """Start a motion anew from what was given, with other digits or changed input."""
    return start(solution, replace(given, digits=digits, **change))
