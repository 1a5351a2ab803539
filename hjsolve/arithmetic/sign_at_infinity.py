"""The sign that a formula has from some place to infinity, proved by its asymptotic expansion.

A ``tape`` is that of the formula, with one output and the inputs q, then numbers; a ``side`` is 1 towards +∞ and −1
towards −∞, and ``start`` at least 3, for nothing is known below; ``bits`` are those of the coefficients.
"""

from __future__ import annotations

from collections.abc import Sequence

from hjsolve.arithmetic.asymptotic_expansion import BITS, Growths
from hjsolve.arithmetic.asymptotic_scale import CONSTANT, Growth, Monomial, UnknownGrowthError, widened
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.tape import Tape
from hjsolve.errors import InvalidInputError

_FEWER_BITS = 256
_NEAREST, _FAR = 4, 1e200
"""Where expansions begin: next to an end, and for the sign that a formula has in the end."""


def sign_beyond(tape: Tape, inputs: list[Mpf], side: int, start: float, bits: int = BITS) -> int:
    """Return the sign that a formula has for all side·q ≥ start; 0 where that is not known."""
    if not 3 <= start < 1e300:
        return 0
    growths = Growths(start, bits)
    try:
        return growths.sign(tape.run(growths, [growths.variable(side), *map(growths.constant, inputs)])[0])
    except (UnknownGrowthError, InvalidInputError, ArithmeticError):
        return 0


def sign_in_the_end(tape: Tape, inputs: list[Mpf], side: int, end: Mpf | None, bits: int = BITS) -> int:
    """Return the sign that a formula has from some place on, however close to an end of q; 0 where it is not known.

    It is that of the leading term: E − log q is negative beyond e^E.

    Args:
        end: where q ends, None for infinity.
        side: 1 towards it from below, −1 from above.
    """
    growths = Growths(_FAR, bits)
    q = growths.variable(side)
    if end is not None:  # q = end − side/s
        q = growths.add(growths.constant(end), growths.power(growths.variable(-side), -1))
    try:
        found = tape.run(growths, [q, *map(growths.constant, inputs)])[0]
    except (UnknownGrowthError, InvalidInputError, ArithmeticError):
        return 0
    if not found.terms or (found.rest is not None and not found.rest.monomial < found.terms[0][0]):
        return 0
    return 1 if found.terms[0][1] > 0 else -1


def sign_before(tape: Tape, inputs: list[Mpf], end: Mpf, side: int, distance: Mpf, bits: int = BITS) -> int:
    """Return the sign that a formula has wherever 0 < side·(end − q) ≤ distance; 0 where that is not known.

    With q = end − side·4·distance/s it is the sign for all s ≥ 4.

    Args:
        end: where q ends.
        side: 1 from below, −1 from above.
        distance: from the end.
    """
    growths = Growths(_NEAREST, bits)
    q = growths.add(growths.constant(end), Growth(((Monomial(0.0, -1.0, 0.0), -side * _NEAREST * distance),)))
    try:
        return growths.sign(tape.run(growths, [q, *map(growths.constant, inputs)])[0])
    except (UnknownGrowthError, InvalidInputError, ArithmeticError):
        return 0


def sign_beyond_for_all(
    tape: Tape, ranges: Sequence[tuple[Mpf, Mpf]], side: int, start: float, bits: int = _FEWER_BITS
) -> int:
    """Return the sign that a formula has for all side·q ≥ start, whatever its numbers are; 0 where that is not known.

    Args:
        ranges: the least and the greatest value of each number; equal for one that is known.
    """
    if not 3 <= start < 1e300:
        return 0
    growths = Growths(start, bits)
    try:
        numbers = [growths.constant(low) if low == high else _between(low, high) for low, high in ranges]
        return growths.sign(tape.run(growths, [growths.variable(side), *numbers])[0])
    except (UnknownGrowthError, InvalidInputError, ArithmeticError):
        return 0


def _between(low: Mpf, high: Mpf) -> Growth:
    """Any number between two."""
    middle, reach = (low + high) / 2, float(high - low)
    return Growth(((CONSTANT, middle),) if middle else (), widened(CONSTANT, -reach, reach))
