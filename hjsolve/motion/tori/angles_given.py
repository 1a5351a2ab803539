"""The state of a torus at given angles: the time law inverted with θ in place of θ⁰ + Ω (t − t₀).

θ = θ⁰ + Ω (t − t₀) are the right sides of Jacobi's equations in angle form (``time_law.torus``). With the angles given
at t₀ the same equations are solved for the phases χ, which are then where the coordinates start.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import InternalError, required
from hjsolve.formulas.read import number
from hjsolve.motion.angles_along import oscillation_at, phase_of_zero
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.initial_data import Initial
from hjsolve.motion.positions import constant_index
from hjsolve.motion.separated import SeparatedMotion
from hjsolve.one_coordinate.classify import Located
from hjsolve.time_law.refine import on_torus
from hjsolve.time_law.torus import TorusEquations, oscillation, torus_equations, torus_phases


def started_at(motion: SeparatedMotion, angles: Mapping[str, sp.Expr]) -> SeparatedMotion:
    """Return the motion on the same torus that has given angles at t₀.

    Args:
        motion: any motion on the torus, all of whose coordinates are bounded.
        angles: every coordinate that has an angle → its value in radians, exact.
    """
    torus, solution = motion.torus, motion.solution
    if torus is None:
        raise InternalError("a torus without its equations")
    bits = bits_for(motion.digits, 128)
    context = multiprecision(bits)
    θ = {name: to_bits(value)(bits) for name, value in angles.items()}
    begins = [phase_of_zero(coordinate_motion, context, bits) for coordinate_motion in torus.coordinate_motions]
    starts = []
    for k, name in enumerate(solution.coordinates):
        frequency = motion.frequencies.get(name)
        # an angle grows with the time; Jacobi's rate of the coordinate may have the other sign
        direction = -1 if frequency is not None and float(frequency.value) * float(torus.rates[k]) < 0 else 1
        series = torus.oscillations[k]
        # χₖ + Σᵢ Dₖᵢ(χᵢ) is ±θₖ more than where all angles are zero: θ is where the time would in Jacobi's equations
        zero = sum((oscillation_at(s, begin) for s, begin in zip(series, begins, strict=True)), begins[k])
        starts.append(zero + direction * θ[name])
    phases = [_in_first_turn(motion, k, χ) for k, χ in enumerate(_phases(replace(torus, starts=tuple(starts)), bits))]
    located: dict[str, Located] = {}
    values = dict(motion.initial.values)
    for k, name in enumerate(solution.coordinates):
        place = motion.located[name]
        coordinate_motion = replace(place.coordinate_motion, start=phases[k])
        located[name] = replace(place, coordinate_motion=coordinate_motion)
        q, p = (x[0] for x in coordinate_motion.place(np.array([phases[k]], dtype=object)))
        coordinate = solution.system.coordinate(name)
        values[coordinate.symbol] = number(q, source=name)
        values[coordinate.momentum] = number(p, source=name)
    # the separated equations hold for p with its shift; the start is told in the user's p
    for name in solution.coordinates:
        shift = solution.shift[name].subs(values)
        values[solution.system.coordinate(name).momentum] -= shift
    for name, angle in θ.items():
        if name not in located:
            values[solution.system.coordinate(name).symbol] = _ignorable(motion, torus, name, angle, phases, begins)
    initial = Initial(values, motion.initial.constants, motion.initial.exact)
    coordinate_motions = [stays for place in located.values() if (stays := place.coordinate_motion.bounded) is not None]
    return replace(motion, initial=initial, located=located, equations=torus_equations(coordinate_motions, bits))


def _phases(torus: TorusEquations, bits: int) -> list[Mpf]:
    """Return the phases at which the right sides of Jacobi's equations are those of the equations."""
    context, now = multiprecision(bits), np.zeros(1)
    χ, whole, _ = torus_phases(torus, (now, now))
    # the time is zero: what is solved is in the starts alone
    refined, _ = on_torus(torus, χ, whole, [context.mpf(0)], bits)
    return [x[0] for x in refined]


def _in_first_turn(motion: SeparatedMotion, k: int, χ: Mpf) -> Mpf:
    """Return a phase, by whole turns such that an angle that rotates lies in (−π, π]."""
    name = motion.solution.coordinates[k]
    coordinate_motion = motion.located[name].coordinate_motion
    if not coordinate_motion.rotates or motion.solution.system.coordinate(name).domain.kind != "angle":
        return χ
    context, cycle = χ.context, required(coordinate_motion.cycle)
    turn = 2 * context.pi
    q = cycle.place(np.array([χ], dtype=object))[0][0]
    # (−π, π] is closed above, so that the half turn itself counts down: ceil(x − ½), not rint
    return χ - cycle.direction * turn * context.ceil(q / turn - context.mpf(1) / 2)


def _ignorable(
    motion: SeparatedMotion, torus: TorusEquations, name: str, angle: Mpf, phases: list[Mpf], begins: list[Mpf]
) -> sp.Expr:
    """Return an ignorable angle at t₀, in (−π, π]: θ and what the separated coordinates add to its mean growth."""
    j = constant_index(motion, name)
    # the mean growth is in θ; what is left of ∂W/∂p_φ are the oscillations from the places of angle zero to the phases
    total = angle
    for i, (χ, begin) in enumerate(zip(phases, begins, strict=True)):
        series = oscillation(torus, i, j)
        total = total + oscillation_at(series, χ) - oscillation_at(series, begin)
    turn = 2 * total.context.pi
    return number(total - turn * total.context.ceil(total / turn - total.context.mpf(1) / 2), source=name)
