"""What two_point is asked, read and checked once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve import arguments
from hjsolve.errors import InvalidInputError
from hjsolve.formulas.read import number
from hjsolve.mechanics.system import System
from hjsolve.motion.initial_data import read_places, sign
from hjsolve.solution.quadratures import Solution

_MOST_TURNS = 1000
EXAMPLE = 'two_point(q0={"r": 1, "theta": 0}, q1={"r": 2, "theta": "pi/2"}, time=3, turns=range(0, 3))'


@dataclass(frozen=True, eq=False)
class TwoPlaceQuestion:
    """A question of two places and a time.

    Attributes:
        solution: whose motions are wanted.
        system: the user's, in whose coordinates q0 and q1 are.
        q0, q1: coordinate → exact number.
        time: T, exact, > 0.
        turns: counts of whole turns, in increasing order.
        given: the parameters as they came.
        digits: of the motions.
    """

    solution: Solution
    system: System
    q0: Mapping[str, sp.Expr]
    q1: Mapping[str, sp.Expr]
    time: sp.Expr
    turns: tuple[int, ...]
    given: Mapping[str, object]
    digits: int


def read_turns(turns: object) -> tuple[int, ...]:
    """Read how many whole turns are asked.

    Args:
        turns: a number, or several.

    Raises:
        InvalidInputError: not whole, negative, too many or none.
    """
    if isinstance(turns, int):
        return (arguments.whole(turns, "turns", 0, _MOST_TURNS),)
    if not isinstance(turns, Iterable) or isinstance(turns, str | Mapping):
        raise InvalidInputError(
            f"turns: whole numbers such as range(0, 3) are needed, not {arguments.described(turns)}"
        )
    read = sorted({arguments.whole(int(n) if hasattr(n, "__index__") else n, "turns", 0, _MOST_TURNS) for n in turns})
    if not read:
        raise InvalidInputError("turns: none is given; write range(0, 3) for 0, 1 and 2 whole turns")
    return tuple(read)


def read_question(
    solution: Solution, q0: object, q1: object, time: object, turns: object, parameters: object, digits: int
) -> tuple[TwoPlaceQuestion, dict[sp.Symbol, sp.Expr]]:
    """Read a question, and the values of the parameters.

    Args:
        solution, q0, q1, time, turns, parameters, digits: as of ``two_point``.

    Returns:
        The question; and symbol → exact number.

    Raises:
        InvalidInputError: places that are incomplete or outside the domain, a time that is not positive.
        MissingValueError: a parameter without a value.
    """
    system = solution.system if solution.chart is None else solution.chart.original
    for name, given in (("q0", q0), ("q1", q1)):
        if given is None:
            raise InvalidInputError(f"two_point: no {name}={{…}}; write {EXAMPLE}")
    if time is None:
        raise InvalidInputError(f"two_point: no time=…; write {EXAMPLE}")
    given = arguments.table({} if parameters is None else parameters, "parameters", '{"m": 1}')
    places = []
    for name, q in (("q0", q0), ("q1", q1)):
        values = read_places(system, arguments.table(q, name, '{"r": 1, "theta": 0}'), given)
        places.append({c.name: values[c.symbol] for c in system.coordinates})
    span = number(time, source="time")
    if sign(span) <= 0:
        raise InvalidInputError(
            f"time: {time} is not positive; write the time from q0 to q1 (to go back in time exchange q0 and q1)"
        )
    letters = {c.symbol for c in system.coordinates}
    known = {symbol: value for symbol, value in values.items() if symbol not in letters}
    return TwoPlaceQuestion(solution, system, places[0], places[1], span, read_turns(turns), given, digits), known
