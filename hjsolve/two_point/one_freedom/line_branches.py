"""The paths along one coordinate from one place to another, by the direction at the start and the turning points met.

With D the time from the lower place to the upper one, U from the upper place to the turning point above it and L from
the lower place to the one below, every way takes d D + 2u U + 2l L with whole numbers d, u, l.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple


class LineBranch(NamedTuple):
    """A path from q0 to q1.

    Attributes:
        sign: of the velocity at q0.
        direct, upper, lower: d, u and l.
        turns: whole periods that it holds.
    """

    sign: int
    direct: int
    upper: int
    lower: int
    turns: int

    @property
    def path(self) -> str:
        """It in words."""
        turned = self.upper + self.lower
        begin = "up" if self.sign > 0 else "down"
        return f"{begin}, {turned} turning point{'s' if turned != 1 else ''}" if turned else f"{begin}, directly"


def branches(order: int, most: int) -> Iterator[LineBranch]:
    """Yield the paths with a given number of whole periods.

    Args:
        order: the sign of q1 − q0, 0 where they are one place.
        most: the largest number of periods.
    """
    for sign in (1, -1):
        yield from (_returning(sign, most) if order == 0 else _between(sign, order, most))


def _returning(sign: int, most: int) -> Iterator[LineBranch]:
    """From a place to itself: up and back, down and back in turn."""
    upper = lower = 0
    direction = sign
    while True:
        upper, lower = upper + (direction > 0), lower + (direction < 0)
        direction = -direction
        turns = min(upper, lower)
        if turns > most:
            return
        # after whole periods the direction is that of the start, else the other one
        yield LineBranch(sign, 0, upper, lower, turns)


def _between(sign: int, order: int, most: int) -> Iterator[LineBranch]:
    direct = upper = lower = 0
    at_upper, direction = order < 0, sign  # where the walk is, and which way it goes
    while True:
        if (direction > 0) == at_upper:  # outwards: to the turning point and back
            upper, lower = upper + at_upper, lower + (not at_upper)
            direction = -direction
        else:
            direct += 1
            at_upper = not at_upper
        turns = min(direct // 2, upper, lower)
        if turns > most:
            return
        if at_upper == (order > 0):
            yield LineBranch(sign, direct, upper, lower, turns)
