"""Turns of the angles of forms: a form is that of one turn, and what lies beyond is made of it.

Of an angle whole turns are taken off, and added to q(t) again. Along a motion that goes round, ∫ R dq/√P² from q₀ to q
is what it is within the turn of the form, and as much more as it gains from one end of the turn to the other, as often
as these were passed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import sympy as sp

from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.named_forms import NamedForms
from hjsolve.closed_form.regions import RootInterval

_GIVE_A_PLACE = ("inverse", "orbit", "parametric", "anomaly")
"""Groups of forms that give a coordinate."""
_SUMS = ("time_law", "characteristic_function", "orbit_equations")
"""Groups of forms that are sums of integrals over coordinates, from the lower limits on."""

DIGITS_AT_ENDS = 4
"""Times the digits of the result, next to the ends of a turn: tan(q/2) has as many zeros there as that has digits, and
squares of it cancel."""


class CountedAngle(NamedTuple):
    """An angle of a form, or its lower limit: a place that is told apart from others only by whole turns.

    Attributes:
        curve: of the coordinate.
        symbol: of the place.
        begin: the symbol that says in which turn it is.
        turn: after what P² repeats itself, or a whole turn.
    """

    curve: MomentumCurve
    symbol: sp.Symbol
    begin: sp.Symbol
    turn: sp.Expr

    @property
    def middle(self) -> sp.Expr:
        """Of the turn that the form is for."""
        substitution = self.curve.substitution
        return substitution.inverse.subs(substitution.x, 0)


def counted_angles(form: NamedForms, held: Iterable[sp.Symbol]) -> list[CountedAngle]:
    """Return the angles and lower limits among symbols that count turns; and places along lattices, which count cells.

    A libration of an angle is in one well, whatever turns are counted. A rotation is counted from its lower limit, and
    so is a motion along a line: its cell is not another one.

    Args:
        form: of a regime.
        held: the symbols.
    """
    known, found = set(held), list[CountedAngle]()
    for curve, region, symbol in curves_held(form, known):
        coordinate, rotates = curve.coordinate, region.kind == "rotation"
        if any(own.symbol == symbol for own in found):  # of another curve of the coordinate, over the same turn
            continue
        angle, turn = coordinate.domain.kind == "angle", curve.substitution.turn
        # A of a shift p = P − A repeats itself along a whole angle, and need not repeat itself with P²
        shifted = form.solution.shift.get(coordinate.name, sp.S.Zero) != 0
        if not curve.substitution.closed or (shifted and not angle):
            continue
        begin = form.solution.lower_limits.get(coordinate.name, symbol)
        counts = begin in known and (rotates or not angle)
        whole = angle and (shifted or not rotates)
        found.append(CountedAngle(curve, symbol, begin if counts else symbol, 2 * sp.pi if whole else turn))
    return found


def passing_angles(form: NamedForms, name: str, held: Iterable[sp.Symbol]) -> list[CountedAngle]:
    """Return the angles that may go on beyond the turn of a form: over each it gains as much as over one.

    Args:
        form: of a regime.
        name: of the quantity.
        held: the symbols.
    """
    found = list[CountedAngle]()
    rotating = {id(curve) for curve, region in form.regime.regions if region.kind == "rotation"}
    for own in counted_angles(form, held) if name.partition(".")[0] in _SUMS else ():
        if id(own.curve) not in rotating:
            continue
        turn = own.curve.substitution.turn
        # W holds ∫ A dq of a shift, which repeats itself with the angle alone
        again = name != "characteristic_function" or turn == own.turn
        if own.symbol == own.curve.coordinate.symbol != own.begin and again:
            found.append(own._replace(turn=turn))
    return found


def gained_in_a_turn(form: NamedForms, name: str) -> dict[sp.Symbol, sp.Expr]:
    """Return what a form gains where an angle moves on by its turn, by the symbol of the angle.

    q(t) is counted from q(t₀), and W holds −∫ A dq of a shift A of the momenta, p = P − A. Other forms gain nothing.

    Args:
        form: of a regime.
        name: of the quantity.
    """
    solution, (group, _, coordinate) = form.solution, name.partition(".")
    if group in _GIVE_A_PLACE and coordinate in solution.lower_limits:
        begin = solution.lower_limits[coordinate]
        return {own.symbol: own.turn for own in counted_angles(form, {begin})}
    if name != "characteristic_function":
        return {}
    shifts = ((solution.system.coordinate(q).symbol, A) for q, A in solution.shift.items() if A != 0)
    return {q: -sp.integrate(A, (q, -sp.pi, sp.pi)) for q, A in shifts}


def curves_held(form: NamedForms, held: Iterable[sp.Symbol]) -> list[tuple[MomentumCurve, RootInterval, sp.Symbol]]:
    """Return the curves of coordinates and lower limits that are among symbols.

    Args:
        form: of a regime.
        held: the symbols.
    """
    known = set(held)
    return [
        (curve, region, symbol)
        for curve, region in form.regime.regions
        for symbol in (curve.coordinate.symbol, form.solution.lower_limits.get(curve.coordinate.name))
        if symbol in known
    ]


class CompiledAngle(NamedTuple):
    """An angle of a compiled form.

    Attributes:
        place, begin: positions among the arguments of the angle, and of what says in which turn it is.
        middle, turn: of the turn that the form is for, as functions of all arguments.
    """

    place: int
    begin: int
    middle: Callable[..., Any]
    turn: Callable[..., Any]

    def turns_at(self, numbers: Sequence[Any], at: int, rounded: Callable[[Any], Any]) -> Any:
        """Return how many turns an argument is from that of the form.

        Args:
            numbers: the arguments, numbers or arrays.
            at: position of that one.
            rounded: to whole numbers.
        """
        return rounded((numbers[at] - self.middle(*numbers)) / self.turn(*numbers))

    def at_end(self, numbers: Sequence[Any], side: int, short: Any) -> list[Any]:
        """Return the arguments with the angle next to an end of the turn.

        Args:
            numbers: the arguments.
            side: 1 for the upper end, −1 for the lower one.
            short: what is left to the end, over the turn.
        """
        moved = [*numbers]
        moved[self.place] = 0 * numbers[self.place] + self.middle(*numbers) + side * (0.5 - short) * self.turn(*numbers)
        return moved
