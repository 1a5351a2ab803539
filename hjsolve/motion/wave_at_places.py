"""W as a function of place and branch: Hamilton's characteristic function on the torus of a motion.

Each separated coordinate has two branches, P > 0 and P < 0, that meet at its turning points. From the place at t₀,
W = Σᵢ ∫ Pᵢ dqᵢ + Σ c_k Δq_k − Δχ as along the motion (``characteristic.py``), with every coordinate brought to its own
place on its own branch: ∂W/∂q = p there. A libration is taken once round from its lower turning point, up on P > 0
and down on P < 0; more rounds add ∮ Pᵢ dqᵢ each.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.estimate_array import EstimateArray
from hjsolve.arithmetic.floats import EPS, Multi, bits_for
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import InvalidInputError, OutsideMotionError
from hjsolve.motion.characteristic import FINER, estimates, gauge, swept_from_start, unit_of
from hjsolve.motion.crossings import between_turning_points, open_phases
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.separated import SeparatedMotion, separated_motion
from hjsolve.motion.times import exact_numbers
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion, Periodic


def wave_at(motion: SeparatedMotion, q: Mapping[str, object], branch: Mapping[str, int]) -> Estimate | EstimateArray:
    """Return W at places and branches; see ``Motion.characteristic_function``."""
    solution = motion.solution
    q, branch = arguments.table(q, "q"), arguments.table(branch, "branch", '{"r": -1}')
    _check(motion, q, branch)
    fine = motion if motion.digits > FLOAT_DIGITS else separated_motion(
        solution, motion.initial, motion.t0, FINER, motion.parts
    )  # fmt: skip
    # a double is worked out in ``FINER`` digits: W between two places is a difference of sweeps from the start
    bits, unit = bits_for(fine.digits, 128), unit_of(fine)
    given = {name: exact_numbers(values, f"place of {name}") for name, values in q.items()}
    shape = np.broadcast_shapes(*(own for own, _ in given.values()))
    places = {
        name: np.broadcast_to(np.array([to_bits(x)(bits) for x in row], dtype=object).reshape(own), shape).ravel()
        for name, (own, row) in given.items()
    }
    value, error = 0 * next(iter(places.values())), np.zeros(int(np.prod(shape)))
    for name in solution.coordinates:
        sign, tolerance = branch.get(name), 4 * EPS if fine is not motion else 0.0
        found = [_phase(fine, name, _on_turning_point(fine, name, x, tolerance), sign) for x in places[name]]
        χ, whole = np.array([x for x, _ in found], dtype=object), np.array([n for _, n in found], dtype=object)
        part, slope, size = swept_from_start(fine.located[name].coordinate_motion, χ, whole, many=True)
        value = value + part
        # a phase is known to a unit of 1 + |χ|, and W changes by its slope there; four roundings of its size
        error = error + unit * ((1 + abs(χ.astype(float))) * abs(slope.astype(float)) + 4 * size.astype(float))
    for coordinate in solution.system.coordinates:
        if coordinate.name not in solution.coordinates:
            c = to_bits(fine.initial.values[coordinate.momentum])(bits)
            end_map = places[coordinate.name] - to_bits(fine.initial.values[coordinate.symbol])(bits)
            value, error = value + c * end_map, error + 4 * unit * abs(c * end_map).astype(float)
    if solution.shift_potential != 0:
        moved, uncertainty = gauge(fine, places, {})
        value, error = value - moved, error + uncertainty
    return estimates(value, error + unit * abs(value).astype(float), shape, motion.digits)


def _check(motion: SeparatedMotion, q: Mapping[str, object], branch: Mapping[str, int]) -> None:
    names = [c.name for c in motion.solution.system.coordinates]
    if set(q) != set(names):
        raise InvalidInputError(
            f"W at a place needs q of every coordinate: q={{{', '.join(f'{n!r}: …' for n in names)}}}"
        )
    for name, sign in branch.items():
        if name not in motion.solution.coordinates:
            raise InvalidInputError(f"{name!r} has no branches; separated are {', '.join(motion.solution.coordinates)}")
        if isinstance(sign, bool) or sign not in (1, -1):
            raise InvalidInputError(f"branch of {name}: +1 or -1, not {sign!r}")


def _on_turning_point(motion: SeparatedMotion, name: str, place: Mpf, tolerance: float) -> Mpf:
    """Return a place beyond a turning point by the rounding of a double is the turning point."""
    cycle = motion.located[name].coordinate_motion.cycle
    if cycle is None or cycle.rotates:
        return place
    low, high = cycle.turning_points
    rounding = tolerance * (abs(low) + abs(high))
    return min(max(place, low), high) if low - rounding <= place <= high + rounding else place


def _phase(motion: SeparatedMotion, name: str, place: Mpf, sign: int | None) -> tuple[Mpf, int]:
    """Return the phase of a place on a branch, and whole turns next to it."""
    coordinate_motion, bits = motion.located[name].coordinate_motion, bits_for(motion.digits, 128)
    if coordinate_motion.rests:
        # p = 0 wherever it rests, so that W has nothing to add and no place but this one
        rest = coordinate_motion.place(np.array([0 * place], dtype=object))[0][0]
        if abs(place - rest) > (1 + abs(rest)) * 10.0**-FLOAT_DIGITS:
            raise OutsideMotionError(f"{name} rests at {float(rest):.12g}: it is nowhere else")
        return 0 * place, 0
    if coordinate_motion.cycle is not None:
        return _on_cycle(motion, name, coordinate_motion.cycle, place, sign, Multi(bits))
    phases = open_phases(name, coordinate_motion, place, bits)
    signs = [_sign(coordinate_motion, phase) for phase in phases]
    wanted = sign if sign is not None else 1 if 1 in signs else -1
    if wanted not in signs:
        raise OutsideMotionError(f"{name} has no branch {wanted:+d} at {float(place):.9g}")
    return phases[signs.index(wanted)], 0


def _on_cycle(
    motion: SeparatedMotion, name: str, cycle: Periodic, place: Mpf, sign: int | None, arithmetic: Multi
) -> tuple[Mpf, int]:
    """Of a libration once round from its lower turning point; of a rotation as far as its angle goes, not reduced."""
    turn = 2 * arithmetic.pi()
    χ = cycle.phase(between_turning_points(motion, name, cycle, place), arithmetic)
    if not cycle.rotates:
        # p > 0 on the first half of a turn from the lower turning point, p < 0 on the way back
        χ = abs(χ) if sign != -1 else turn - abs(χ)
        begin = motion.located[name].coordinate_motion.start
        return χ, int(arithmetic.context.floor(begin / turn))
    if sign is not None and sign != cycle.direction:
        raise OutsideMotionError(f"{name} rotates in one direction only, so it has no branch {sign:+d}")
    start = to_bits(motion.initial.values[motion.solution.system.coordinate(name).symbol])(bits_for(motion.digits, 128))
    there, first = cycle.place(np.array([χ, cycle.start], dtype=object))[0]
    end_map = cycle.direction * turn * cycle.radian
    # a phase is known within a turn; what is left of the place are whole turns, counted from the start
    turns = [arithmetic.context.nint((x - y) / end_map) for x, y in ((place, there), (start, first))]
    return χ, int(turns[0] - turns[1])


def _sign(coordinate_motion: CoordinateMotion, phase: Mpf) -> int:
    """Of the momentum at a phase of an open course: one that turns comes back with the other sign."""
    end_map = coordinate_motion.branches[0].end_map
    return int(end_map.side) * (-1 if end_map.turning and phase < 0 else 1)
