"""Separatrices of a family: values of one constant at which p² of a coordinate has a double zero that is a minimum.

There the motion tends to an unstable equilibrium of that coordinate, or leaves it. F(q; u) = 0 gives u at every place;
its extrema over q are the double zeros (F = F_q = 0), of which those with F_qq > 0 are barriers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.root_finding import interpolated_root, stationary
from hjsolve.errors import InvalidInputError
from hjsolve.formulas.read import number
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.initial_data import parameter_values
from hjsolve.motion.tori.radicand_curve import RadicandCurve, curves_of
from hjsolve.resonances.families import MotionFamily, critical_values
from hjsolve.solution.quadratures import Solution

_WIDENINGS, _FIRST = 40, 2.0**-40
"""Newton steps to a minimum of p², and widenings of a bracket about a separatrix, doubled each from a relative one."""
_ROUNDING = 12
"""Bits of the working precision that the result may miss."""


@dataclass(frozen=True)
class Separatrix:
    """A value of a constant at which a coordinate has a separatrix.

    Attributes:
        unknown: name of the constant.
        value: of it.
        coordinate: that has the double zero.
        place: of the unstable equilibrium.
    """

    unknown: str
    value: Estimate
    coordinate: str
    place: Estimate


def separatrices(solution: Solution, fixed: object, parameters: object, digits: int) -> tuple[Separatrix, ...]:
    """Find the separatrices of a family; see ``Solution.separatrices``."""
    held = {n: number(v, source=f"fixed[{n}]") for n, v in arguments.table(fixed, "fixed", '{"L": 1}').items()}
    unknown = [name for name in solution.constants if name not in held]
    if stray := [name for name in held if name not in solution.constants]:
        raise InvalidInputError(f"fixed: {stray[0]!r} is not a constant; known are {', '.join(solution.constants)}")
    if len(unknown) != 1:
        raise InvalidInputError(
            f"separatrices: fixed={{…}} must leave one of {', '.join(solution.constants)}, not {len(unknown)}"
        )
    table = arguments.table(parameters, "parameters", '{"m": 1}')
    letters = {n: number(v, source=f"parameters[{n}]") for n, v in table.items()}
    family = MotionFamily(solution, {n: to_bits(v) for n, v in held.items()}, unknown[0], letters)
    curves = curves_of(solution, parameter_values(solution.system, letters), {})
    bits = bits_for(max(digits, 15), 128)
    found: list[Separatrix] = []
    for curve in curves:
        for u, q in _begins(curve, family):
            exact = _exactly(curve, family, u, q, bits)
            if exact is None:
                continue
            exact = exact[0], _in_one_turn(curve, exact[1])
            if not any(_same(curve.name, exact, other) for other in found):
                found.append(_estimated(curve.name, family.unknown, exact, digits, bits))
    return tuple(sorted(found, key=lambda one: float(one.value.value)))


def _begins(curve: RadicandCurve, family: MotionFamily) -> list[tuple[float, float]]:
    """Return places where u(q) has an extremum on the samples and p² a minimum."""
    q, result = curve.samples(), list[tuple[float, float]]()
    for branch in critical_values(curve, family):
        with np.errstate(invalid="ignore"):
            inner, left, right = branch[1:-1], branch[:-2], branch[2:]
            turns = ((inner >= left) & (inner > right)) | ((inner <= left) & (inner < right))
        for k in np.flatnonzero(turns & np.isfinite(left) & np.isfinite(right)) + 1:
            u, place = float(branch[k]), float(q[k])
            if curve.bend(place, family.in_doubles(u))[2] > 0:
                result.append((u, place))
    return result


def _exactly(curve: RadicandCurve, family: MotionFamily, u: float, q: float, bits: int) -> tuple[Mpf, Mpf] | None:
    """Return the constant and the place of a double zero; None where the search leads away."""
    context = multiprecision(bits)
    places: dict[Mpf, Mpf] = {}

    def least(value: Mpf) -> Mpf:
        κ = list(family.constants(value, bits).values())
        place = stationary(
            lambda x: curve.exactly(x, κ, bits), context.mpf(q), lambda bend, _: bend > 0,
            lambda x: abs(x) * context.ldexp(1, 8 - bits),
        )  # fmt: skip
        if place is None:
            return context.nan
        places[value] = place
        return curve.exactly(place, κ, bits)[0]

    middle = context.mpf(u)
    size = abs(middle) or context.mpf(1)
    tiny = context.ldexp(size, 8 - bits)
    for k in range(_WIDENINGS):
        ends = middle - size * _FIRST * 2**k, middle + size * _FIRST * 2**k
        values = least(ends[0]), least(ends[1])
        if values[0] * values[1] < 0:
            root = interpolated_root(least, ends, values, lambda _, F: abs(F) <= tiny)
            return (root, places[root]) if root in places else None
    return None


def _in_one_turn(curve: RadicandCurve, q: Mpf) -> Mpf:
    """Return a place of a coordinate that goes round, in (−π, π] or its like."""
    if not curve.turn:
        return q
    whole = q.context.floor(q / (2 * q.context.pi) + q.context.mpf(1) / 2 - q.context.mpf(2) ** -30)
    return q if curve.turn != 2 * np.pi else q - 2 * q.context.pi * whole


def _same(name: str, exact: tuple[Mpf, Mpf], other: Separatrix) -> bool:
    u, q = (float(x) for x in exact)
    v, place = float(other.value.value), float(other.place.value)
    return name == other.coordinate and abs(u - v) <= 1e-12 * abs(u) and abs(q - place) <= 1e-9 * (abs(q) + abs(place))


def _estimated(name: str, unknown: str, exact: tuple[Mpf, Mpf], digits: int, bits: int) -> Separatrix:
    """Return the results with their errors: of the place half as many digits are known as of p² there."""
    u, q = exact
    κ_error, place_error = (
        float(abs(u)) * 2.0 ** (_ROUNDING - bits),
        (float(abs(q)) or 1.0) * 2.0 ** (_ROUNDING - bits // 2),
    )
    if digits > 15:
        return Separatrix(unknown, Estimate(u, κ_error), name, Estimate(q, place_error))
    rounded = [Estimate(float(x), e + abs(float(x)) * 2.0**-53) for x, e in ((u, κ_error), (q, place_error))]
    return Separatrix(unknown, rounded[0], name, rounded[1])
