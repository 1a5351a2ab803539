"""Units in which tori with small or large actions have numbers of order one.

A coordinate is as long as makes p q of the order of the action: where p² without constants, U(q), is 2^f at q = 2^e, e
is the solution of e + f/2 = A. In a core, where U is kept as a difference (``arithmetic.block_exponents``), f = 2e.
"""

from __future__ import annotations

from hjsolve.arithmetic.block_exponents import NOTHING, Unit, tape_in_units, unit_of
from hjsolve.ensembles.engine.lowered_solution import Model, Separated
from hjsolve.ensembles.engine.units_of_orbits import UnitsOfOrbits
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.solution.quadratures import Solution

_FARTHEST_EXPONENT = 1000
"""Of the length of a coordinate."""


def units_of_tori(solution: Solution, model: Model, action: int) -> UnitsOfOrbits:
    """Return units for tori.

    Args:
        solution: of the system.
        model: the same, lowered.
        action: exponent of the largest action, about.
    """
    places = [0] * len(model.names)
    for one in model.separated:
        if not one.periodic and _grows_from_zero(solution.system.coordinate(one.name)):
            places[one.index] = _length(one, model, action)
    return UnitsOfOrbits(tuple(places), action)


def _grows_from_zero(coordinate: Coordinate) -> bool:
    """Return whether the domain is a line or a half of it, which every unit leaves as it is."""
    ends = [end for end in (coordinate.domain.lower, coordinate.domain.upper) if end is not None]
    return len(ends) < 2 and all(end == 0 for end in ends)


def _length(one: Separated, model: Model, action: int) -> int:
    """Return the exponent of a coordinate's length; 0 where there is none."""
    constants = [Unit(NOTHING)] * len(model.constants)
    own = [unit_of(pair) for pair in model.numbers]

    def too_short(e: int) -> bool:
        (f,) = tape_in_units(one.plain.squared, [Unit(e), *constants, *own]).exponents
        return 2 * e + f < 2 * action

    low, high = -_FARTHEST_EXPONENT, _FARTHEST_EXPONENT
    if not too_short(low) or too_short(high):
        return 0
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if too_short(middle) else (low, middle)
    return high
