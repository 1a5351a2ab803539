"""Where the motion of one separated coordinate begins, and by which p² it goes on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from hjsolve.one_coordinate.coordinate_motion import PARTS
from hjsolve.one_coordinate.momentum_squared import MomentumSquared, Number


@dataclass(frozen=True)
class CoordinateStart:
    """One coordinate at the initial time.

    Attributes:
        name: of the coordinate.
        radicand: p² and its kernels.
        place: q at any precision.
        forward: sign of the shell momentum; 0 exactly at a turning point.
        lower, upper: ends of the domain at any precision; None where there is none.
        angle: True when p² has period 2π in q.
        skipped: kernels that are zero everywhere.
        parts: what is to be integrated; see ``coordinate_motion.PARTS``.
        winding: of a coordinate on a line along which p² repeats itself: the same as an angle.
        exact: what exact arithmetic tells of p², where it is known exactly.
        cells: where p² has kinks: the intervals on which it is analytic, upwards, with their own p²; else none.
    """

    name: str
    radicand: MomentumSquared
    place: Number
    forward: int
    lower: Number | None
    upper: Number | None
    angle: bool
    skipped: tuple[bool, ...]
    parts: frozenset[str] = PARTS
    winding: Winding | None = None
    cells: tuple[Cell, ...] = ()
    exact: ExactSquare | None = None


class ExactSquare(Protocol):
    """p² in exact numbers."""

    def order_at_start(self) -> int:
        """Return the order of the zero of p² at the initial place, 0 of none; 3 for all from 3 on."""
        ...

    def multiple_zeros(self) -> Sequence[Number]:
        """Return the zeros of p² proved to be triple or higher; none where p² is not a rational function."""
        ...


@dataclass(frozen=True)
class Cell:
    """An interval between kinks.

    Attributes:
        lower, upper: its ends at any precision: kinks, or ends of the domain; None where there is none.
        radicand: p² and its kernels there.
        at_lower, at_upper: p² at the ends, the limit from inside; None where that is infinite, or there is no end.
    """

    lower: Number | None
    upper: Number | None
    radicand: MomentumSquared
    at_lower: Number | None = None
    at_upper: Number | None = None


@dataclass(frozen=True)
class Winding:
    """A coordinate q on a line as an angle u, q = scale · u.

    Attributes:
        start: u at the initial time.
        scale: the length of a radian at any precision.
    """

    start: CoordinateStart
    scale: Number
