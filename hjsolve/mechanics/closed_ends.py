"""Ends of a domain that were written as included: the axis R = 0, the poles of a sphere."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.coordinates_and_parameters import Coordinate


def check_closed_ends(matrix: sp.ImmutableMatrix, coordinates: Sequence[Coordinate]) -> None:
    """Refuse an included end at which T does not degenerate: the coordinate ends there, and domains are open.

    At an axis or a pole det M = 0, for all values of another coordinate are one point there; motions that are regular
    at it go on.

    Args:
        matrix: M(q), shape (n, n).
        coordinates: as declared.

    Raises:
        InvalidSystemError: with the domain to be written instead.
    """
    for c in coordinates:
        for end in c.domain.closed:
            if sp.simplify(matrix.det().subs(c.symbol, end)) != 0:
                raise InvalidSystemError(
                    f"domain of {c.name}: domains are open, and {c.name} = {end} is not an axis or a pole of T; write "
                    f'"{c.domain.written(c.name)}"'
                )
