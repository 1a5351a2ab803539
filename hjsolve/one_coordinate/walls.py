"""A libration against walls: ends of the domain at which p² is finite and p changes its sign.

It is the libration through kinks (``kinked_libration``) with one cell, the whole domain, whose ends are walls.
"""

from __future__ import annotations

from dataclasses import replace

from hjsolve.one_coordinate import kinks
from hjsolve.one_coordinate.classify import Located, locate
from hjsolve.one_coordinate.coordinate_start import Cell, CoordinateStart
from hjsolve.one_coordinate.turning_points import End


def between_walls(start: CoordinateStart, walls: tuple[bool, bool], digits: int) -> Located:
    """Classify and integrate the motion of one coordinate that some ends of its domain throw back.

    Args:
        start: the coordinate, at a place inside its domain.
        walls: whether the lower and the upper end of the domain throw it back.
        digits: decimal digits asked.

    Returns:
        The motion; ends that it is thrown back by are of the kind ``wall``.

    Raises:
        NotConvergedError: a zero of p² could not be decided, or an integrand stays rough.
    """
    if not any(walls):
        return locate(start, digits)
    whole = replace(start, cells=(Cell(start.lower, start.upper, start.radicand),), winding=None)
    lower, upper = (_thrown_back(kinks.reached(whole, side, digits), walls[side > 0]) for side in (-1, 1))
    if "wall" not in {lower.end.kind, upper.end.kind} or not {lower.end.kind, upper.end.kind} <= {"turning", "wall"}:
        return locate(start, digits)
    return Located(kinks.libration(whole, lower, upper, start.forward, digits), lower.end, upper.end)


def _thrown_back(reached: kinks.Reached, wall: bool) -> kinks.Reached:
    end = reached.end
    return reached._replace(end=End("wall", end.place)) if wall and end.kind == "boundary" else reached
