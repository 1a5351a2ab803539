"""Numbers of a motion from its courses: turning points, actions, frequencies and periods, rounded with their errors.

Here ``equations`` are Jacobi's equations made ready for inversion, and ``digits`` the decimal digits of what is
returned.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS, Multi, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import required
from hjsolve.lowering import lower
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.motion.initial_data import Initial, to_bits
from hjsolve.one_coordinate.allowed_regions import AllowedRegion
from hjsolve.one_coordinate.classify import Located
from hjsolve.solution.quadratures import Solution
from hjsolve.time_law.open_motion import TriangularScheme, own_turns
from hjsolve.time_law.torus import TorusEquations, mean_rate

Equations = TorusEquations | TriangularScheme
"""Jacobi's equations made ready for inversion."""
FLOAT_DIGITS = 15
"""Up to here results are doubles, above they are ``mpf``."""
_NORMAL, _LEAST = 2.0**-1022, 2.0**-1074
"""Doubles below the first have fewer digits; the second is the smallest."""


def rounded(value: float | Mpf, digits: int, nodes: int = 0) -> Estimate:
    """Round a number computed with many digits to spare.

    Args:
        value: the number, in more digits than are asked.
        digits: decimal digits to give it to.
        nodes: of the quadrature behind it.
    """
    if digits <= FLOAT_DIGITS:
        near = float(value)
        return Estimate(near, abs(near) * EPS + (_LEAST if value and abs(near) < _NORMAL else 0.0), nodes=nodes)
    context = multiprecision(bits_for(digits, 16))
    return Estimate(context.convert(value), abs(context.convert(value)) * context.mpf(10) ** -digits, nodes=nodes)


def period(frequency: Estimate) -> Estimate:
    """Return 2π/|Ω|.

    Args:
        frequency: Ω, in radians per unit of t.
    """
    pi = np.pi if isinstance(frequency.value, float) else frequency.value.context.pi
    value = 2 * pi / abs(frequency.value)
    relative = abs(frequency.error / frequency.value)
    return Estimate(value, value * (relative + EPS * isinstance(value, float)), nodes=frequency.nodes)


def turning_points_of(place: Located | AllowedRegion, digits: int) -> tuple[Estimate | None, Estimate | None]:
    """Return the turning points of a region, None where it ends in another way.

    An end is known to its distance from where the search began: one at zero has an absolute error, not a relative one.

    Args:
        place: the region of one coordinate.

    Returns:
        Lower, upper.
    """
    bits = bits_for(digits, 32)
    # an asymptote bounds a region, while a motion only tends to it; a wall turns a motion where p² is not zero
    kinds = {"turning", "asymptote"} if isinstance(place, AllowedRegion) else {"turning", "wall"}
    places = [end.place(bits) if end.kind in kinds and end.place else None for end in (place.lower, place.upper)]
    # one end is known by its distance from the other: what the larger one is rounded to is lost in both
    rounding = max((abs(x) for x in places if x is not None), default=0) * multiprecision(64).mpf(2) ** -bits
    lower_end, upper_end = (None if x is None else _less_exact(rounded(x, digits), rounding) for x in places)
    return lower_end, upper_end


def _less_exact(estimate: Estimate, rounding: float | Mpf) -> Estimate:
    own = float(rounding) if isinstance(estimate.value, float) else rounding
    return replace(estimate, error=estimate.error + own)


def actions(solution: Solution, initial: Initial, located: Mapping[str, Located], digits: int) -> dict[str, Estimate]:
    """Return J of every coordinate that has one: signed like p for a rotation, p itself for an ignorable angle.

    Args:
        located: separated coordinate → its motion and the ends of its region.

    Returns:
        Coordinate → J = (1/2π) ∮ p dq.
    """
    result = {}
    for coordinate in solution.system.coordinates:
        if coordinate.name not in located:
            if coordinate.domain.kind == "angle":
                result[coordinate.name] = rounded(
                    to_bits(initial.values[coordinate.momentum])(bits_for(digits, 64)), digits
                )
            continue
        coordinate_motion = located[coordinate.name].coordinate_motion
        value = coordinate_motion.signed_action
        if value is not None:
            if coordinate_motion.rotates:  # of a libration ∮ A dq is zero: there and back
                radian = coordinate_motion.cycle.radian if coordinate_motion.cycle is not None else 1
                value -= _mean_shift(solution, initial, coordinate, radian, digits)
            result[coordinate.name] = rounded(value, digits, coordinate_motion.nodes)
    return result


def _mean_shift(
    solution: Solution, initial: Initial, coordinate: Coordinate, radian: Mpf | int, digits: int
) -> Mpf | int:
    """(1/2π) ∫ A dq over a turn: what the shift p = P − A adds to the action of a rotation."""
    A = solution.shift[coordinate.name]
    if A == 0:
        return 0
    bits, nodes = bits_for(digits, 64), 8 * digits  # equal steps: A repeats itself over a turn
    tape = lower([A.subs({s: v for s, v in initial.values.items() if s != coordinate.symbol})], [coordinate.symbol])
    context = multiprecision(bits)
    places = (2 * context.pi * radian * k / nodes for k in range(nodes))
    return context.fsum(tape.run(Multi(bits), [q])[0] for q in places) * radian / nodes


def frequencies(solution: Solution, initial: Initial, equations: Equations | None, digits: int) -> dict[str, Estimate]:
    """Ω = ∂H/∂J: the growth of the phases, and of the ignorable angles with them.

    Returns:
        Coordinate → Ω, in radians per unit of t.
    """
    system, names = solution.system, list(solution.coordinates)
    if equations is None:
        return _free_rates(solution, initial, digits, angles=True)
    result = {}
    if (torus := equations.torus) is not None:
        for k, name in enumerate(names):
            coordinate_motion = torus.coordinate_motions[k]
            if coordinate_motion.stable:
                result[name] = rounded(coordinate_motion.direction * torus.rates[k], digits, coordinate_motion.nodes)
        result |= _ignorable_rates(solution, torus, digits, angles=True)
        return {c.name: result[c.name] for c in system.coordinates if c.name in result}
    # coordinates of a triangular scheme that turn by themselves, whatever the others do
    for own in own_turns(required(equations.scheme), bits_for(digits, 128)):
        result[names[own.index]] = rounded(own.cycle.direction * own.rate, digits, own.cycle.nodes)
    return {name: f for name, f in result.items() if f.value}


def mean_velocities(
    solution: Solution, initial: Initial, equations: Equations | None, digits: int
) -> dict[str, Estimate]:
    """⟨dq/dt⟩ = ∂H/∂c, at constant actions, of the ignorable coordinates that are no angles (Greenwood (5-83)).

    Returns:
        Coordinate → mean of dq/dt over all times.
    """
    if equations is None:
        return _free_rates(solution, initial, digits, angles=False)
    torus = equations.torus
    return {} if torus is None else _ignorable_rates(solution, torus, digits, angles=False)


def _ignorable_rates(
    solution: Solution, equations: TorusEquations, digits: int, *, angles: bool
) -> dict[str, Estimate]:
    constants = list(solution.constants)
    return {
        c.name: _ignorable_rate(equations, constants.index(c.momentum.name), digits)
        for c in solution.system.coordinates
        if c.name not in solution.coordinates and (c.domain.kind == "angle") == angles
    }


def _ignorable_rate(equations: TorusEquations, j: int, digits: int) -> Estimate:
    """Return the mean growth of an ignorable angle, a sum that may cancel.

    What is below the noise of its terms is zero.
    """
    value = mean_rate(equations, j)
    sizes = [abs(rate) * c.libration(j) for rate, c in zip(equations.rates, equations.coordinate_motions, strict=True)]
    # integrals have more than twice the digits asked: what is below those of the terms is their rounding
    noise = sum(sizes) * multiprecision(64).mpf(10) ** (-2 * digits)
    nodes = max(c.nodes for c in equations.coordinate_motions)
    plain = rounded(value if abs(value) > noise else 0, digits, nodes)
    return Estimate(plain.value, plain.error + (noise if digits > FLOAT_DIGITS else float(noise)), nodes=nodes)


def _free_rates(solution: Solution, initial: Initial, digits: int, *, angles: bool) -> dict[str, Estimate]:
    H = solution.separation.shell.potential
    rates = {
        c.name: sp.diff(H, c.momentum).subs(initial.values)
        for c in solution.system.coordinates
        if (c.domain.kind == "angle") == angles
    }
    return {name: rounded(to_bits(rate)(bits_for(digits, 64)), digits) for name, rate in rates.items()}
