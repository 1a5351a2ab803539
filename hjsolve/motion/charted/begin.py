"""How a motion starts: in the coordinates it is solved in, or in the user's where these were changed to solve it.

``Solution.motion`` calls ``start``: read the initial data, start in coordinates that run on through poles where the
motion meets some, and keep the input, so that the motion can be started anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import sympy as sp

from hjsolve import arguments
from hjsolve.errors import ForbiddenPlaceError, InvalidInputError
from hjsolve.formulas.read import number
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.quantities_given import in_units
from hjsolve.mechanics.system import kinetic_rest, mass_matrix
from hjsolve.motion.charted.starting import start_charted
from hjsolve.motion.initial_data import (
    all_exact,
    clean,
    number_is_zero,
    read_initial_data,
    read_places,
    with_numbers,
)
from hjsolve.motion.motion import Motion
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.through_poles.continued_motion import motion_through_poles
from hjsolve.motion.through_umbilics.starting import hint_at_umbilic, momenta_of, particle_mass, start_at_umbilic
from hjsolve.motion.tori.from_actions import start_on_torus
from hjsolve.motion.velocity_frame import COORDINATE, factors_of, lengths_in_units, rates_of
from hjsolve.motion.wanted import parts_of
from hjsolve.precision import one_at_a_time
from hjsolve.solution.quadratures import Solution

EXAMPLE = 'motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})'


@one_at_a_time
def start(
    solution: Solution,
    *,
    q: Mapping[str, object] | None = None,
    velocity: Mapping[str, object] | None = None,
    p: Mapping[str, object] | None = None,
    constants: Mapping[str, object] | None = None,
    signs: Mapping[str, int] | None = None,
    actions: Mapping[str, object] | None = None,
    angles: Mapping[str, object] | None = None,
    kinds: Mapping[str, str] | None = None,
    parameters: Mapping[str, object] | None = None,
    t0: object = 0,
    digits: int = FLOAT_DIGITS,
    certified: bool = False,
    want: Iterable[str] | None = None,
    velocity_frame: str = COORDINATE,
) -> Motion:
    """Start a motion from initial data.

    Args:
        solution: of the system.
        q: coordinate → position, every one.
        velocity: coordinate → velocity, every one; or
        p: coordinate → canonical momentum, every one; or
        constants: name of a constant of the motion (``Solution.constants``) → value, every one, with
        signs: separated coordinate → 1 or −1, the sign its root P = √P² starts with; needless where P = 0.
        actions: coordinate → J, every one that has an action; instead of the four above, with
        angles: coordinate → angle variable at t0, 0 where left out; q is then a place in the well that is meant.
        kinds: with actions, separated coordinate → the kind that is meant, where several tori have them.
        parameters: name → value, where it differs from the default.
        t0: time of the initial data.
        digits: relative digits wanted, at least 1; float64 up to 15.
        certified: prove constants, turning points, actions, frequencies and periods (needs the extra ``certified``);
            states stay estimates, at the digits asked.
        want: which of ``QUANTITIES`` will be asked; nothing else is integrated. None for all.
        velocity_frame: ``coordinate``, or ``orthonormal`` where velocities are along the coordinates' unit vectors.

    Returns:
        The motion.

    Raises:
        InvalidInputError: initial data that are no numbers, incomplete, or outside the domain.
        MissingValueError: a parameter or an initial value is missing.
        ForbiddenMotionError: no real motion has these constants.
        NotConvergedError: a turning point or an integral could not be had to the digits asked.

    Example:
        >>> import hjsolve
        >>> kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
        >>> motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
        >>> motion.kinds["r"], round(motion.periods["r"].value, 9)
        ('libration', 14.99332061)
    """
    if actions is not None:
        arguments.refuse_unused(
            {"velocity": velocity is not None, "p": p is not None, "constants": constants is not None,
             "signs": signs is not None, "certified": certified},
            "actions={…} and angles={…} give the motion",
        )  # fmt: skip
        given = {"actions": actions, "angles": angles, "q": q, "kinds": kinds, "parameters": parameters}
        return _on_torus(solution, given, t0, digits, want)
    arguments.refuse_unused({"angles": angles is not None, "kinds": kinds is not None}, "there are no actions={…}")
    if q is None:
        raise InvalidInputError(f"motion: no q={{…}}; write {EXAMPLE}")
    system = solution.system if solution.chart is None else solution.chart.original
    if (
        solution.chart is None
        and isinstance(velocity, Mapping)
        and velocity
        and set(velocity) == set(system.place) - {c.name for c in system.coordinates}
    ):
        return _with_velocity_in_space(solution, q, velocity, parameters, t0, digits, want)
    q, factors = in_units(system, q, "q"), factors_of(system, velocity_frame, velocity)
    if factors is None or velocity is None:
        velocity = in_units(system, velocity, "velocity")
    else:
        velocity = rates_of(system, q, lengths_in_units(system, velocity, factors), factors)
    p, parameters = in_units(system, p, "p"), in_units(system, parameters, "parameters")
    if solution.chart is not None:
        return start_charted(
            solution, q=q, velocity=velocity, p=p, constants=constants, signs=signs, parameters=parameters, t0=t0,
            digits=digits, certified=certified, want=want,
        )  # fmt: skip
    told = tuple((constant.symbol, constant.expression) for constant in solution.constants.values())
    constants = in_units(system, constants, "constants", told)
    digits = arguments.digits(digits)
    arguments.refuse_other(certified, bool, "certified", "True or False is needed")
    if certified:
        refuse_kinks(system.kinks, "certified=True")
    try:
        initial = read_initial_data(
            solution, q=q, velocity=velocity, p=p, constants=constants, signs=signs, parameters=parameters
        )
    except ForbiddenPlaceError as error:
        raise ForbiddenPlaceError(f"{error}{hint_at_umbilic(solution, q, parameters)}") from None
    wanted = None if want is None else arguments.words(want, "want", '["actions", "periods"]')
    parts, exact_t0 = parts_of(wanted), number(t0, source="t0")
    groups = {
        "q": q, "velocity": velocity, "p": p, "constants": constants, "signs": signs, "parameters": parameters,
    }  # fmt: skip
    given = {name: None if group is None else dict(group) for name, group in groups.items()}
    motion = motion_through_poles(solution, initial, exact_t0, digits, parts, certified=certified)
    return replace(motion, given=given, again=partial(_again, solution, given, exact_t0, wanted))


def _with_velocity_in_space(
    solution: Solution, q: Mapping[str, object], velocity: Mapping[str, object],
    parameters: Mapping[str, object] | None, t0: object, digits: int, want: Iterable[str] | None,
) -> Motion:  # fmt: skip
    """Start with a velocity along the axes of the system's place: p = m (∂x/∂q)ᵀ v; at an umbilic by its direction."""
    system = solution.system
    given = {axis: number(value, source=f"velocity[{axis}]") for axis, value in velocity.items()}
    values = read_places(system, in_units(system, q, "q"), in_units(system, parameters, "parameters"))
    if any(number_is_zero(with_numbers(e, values)) for e in mass_matrix(system).diagonal()):
        parts = parts_of(None if want is None else arguments.words(want, "want", '["actions", "periods"]'))
        exact = all_exact(q, velocity, parameters)
        exact_t0, wanted = number(t0, source="t0"), None if want is None else frozenset(want)
        speed2 = sp.Add(*(v**2 for v in given.values()))
        V = with_numbers(system.potential - kinetic_rest(system), values)
        energy = clean(particle_mass(system, values) * speed2 / 2 + V)
        motion = start_at_umbilic(
            solution, values, given, exact_t0, arguments.digits(digits), parts,
            place=system.place, energy=energy, exact=exact,
        )  # fmt: skip
        again = {"q": dict(q), "velocity": dict(velocity), "parameters": parameters}
        return replace(motion, given=again, again=partial(_again, solution, again, exact_t0, wanted))
    p = momenta_of(system, values, given)
    return start(solution, q=q, p=p, parameters=parameters, t0=t0, digits=digits, want=want)


def _on_torus(
    solution: Solution, given: Mapping[str, Any], t0: object, digits: int, want: Iterable[str] | None
) -> Motion:
    """Start a motion from actions and angles, those of the separated coordinates."""
    if solution.chart is not None:
        raise InvalidInputError(
            "actions: not with coordinates that were found; solve the system in its separated coordinates, "
            "solution.system, instead"
        )
    parts = parts_of(None if want is None else arguments.words(want, "want", '["actions", "periods"]'))
    parameters = in_units(solution.system, given["parameters"], "parameters")
    return start_on_torus(solution, {**given, "parameters": parameters}, t0, arguments.digits(digits), parts)


def _again(
    solution: Solution, given: Mapping[str, Any], t0: sp.Expr, want: frozenset[str] | None, digits: int,
    change: Mapping[str, Any],
) -> Motion:  # fmt: skip
    """Start a motion anew from what was given, with other digits or changed input."""
    return start(solution, **{**given, **change}, t0=t0, digits=digits, want=want)
