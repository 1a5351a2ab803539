"""Velocities along the coordinates' unit vectors, v = h q̇, as astronomers give them: v_R, v_T = R φ̇, v_z."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve import arguments
from hjsolve.coordinates.charts.curvilinear import scale_factors
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.quantities_given import in_units
from hjsolve.mechanics.system import System
from hjsolve.motion.exact_numbers import number_is_zero
from hjsolve.motion.initial_data import complete_numbers

COORDINATE, ORTHONORMAL = "coordinate", "orthonormal"
"""What ``velocity_frame`` may be: rates q̇ of the coordinates, or lengths per time along their unit vectors."""
Values = Mapping[str, object]


def factors_of(system: System, velocity_frame: object, given: object) -> tuple[sp.Expr, ...] | None:
    """Return h of v = h q̇ for each coordinate; None where velocities are q̇ themselves.

    Args:
        system: whose coordinates are meant.
        velocity_frame: ``coordinate`` or ``orthonormal``.
        given: the velocities.

    Raises:
        InvalidInputError: another word, no velocities, or coordinates whose lengths T does not tell.
    """
    if velocity_frame == COORDINATE:
        return None
    if velocity_frame != ORTHONORMAL:
        raise InvalidInputError(
            f'velocity_frame: "{COORDINATE}" or "{ORTHONORMAL}" is needed, not {arguments.described(velocity_frame)}'
        )
    if given is None:
        raise InvalidInputError("velocity_frame: it says what velocity={…} means; leave it out, or give velocity={…}")
    factors = scale_factors(system)
    if factors is None:
        raise InvalidInputError(
            'velocity_frame: "orthonormal" needs polar, cylindrical, spherical or Cartesian coordinates, with T the '
            "kinetic energy of one particle; give the rates of the coordinates"
        )
    return factors


def lengths_in_units(system: System, velocity: Values, factors: tuple[sp.Expr, ...]) -> Values:
    """Turn quantities of length per time into numbers, whatever the unit of the coordinate.

    Args:
        system: whose units are declared.
        velocity: coordinate → number or quantity.
        factors: as ``factors_of``.
    """
    # the coordinate with h = 1 is a length: its rate has the unit that all components along unit vectors have
    length = next(c.name for c, h in zip(system.coordinates, factors, strict=True) if h == 1)
    result: dict[str, object] = {}
    for name, value in velocity.items():
        found = in_units(system, {length: value}, "velocity")
        result[name] = found[length]
    return result


def rates_of(system: System, q: Values, velocity: Values, factors: tuple[sp.Expr, ...]) -> dict[str, sp.Expr]:
    """Return q̇ = v/h, exactly.

    Args:
        system: whose coordinates are meant.
        q: coordinate → number.
        velocity: coordinate → number, along its unit vector.
        factors: as ``factors_of``.

    Raises:
        InvalidInputError: a place on the axis or at the pole, where there are no unit vectors.
    """
    places = complete_numbers(system.coordinates, q, "q")
    speeds = complete_numbers(system.coordinates, velocity, "velocity")
    at = {c.symbol: places[c.name] for c in system.coordinates}
    # v = h q̇ with h² = g_qq of the metric; exact, so that a start on the axis is told from one next to it
    scales = [h.xreplace(at) for h in factors]
    if any(number_is_zero(h) for h in scales):
        raise InvalidInputError("q: on the axis the coordinates have no unit vectors; start a little next to it")
    return {c.name: speeds[c.name] / h for c, h in zip(system.coordinates, scales, strict=True)}
