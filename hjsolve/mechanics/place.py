"""Where a system is in space: x, y, z as functions of its coordinates, for drawings and tables.

T need not be that of the point: a top has a place, that of its tip. What is asked is that there is a place wherever the
coordinates are in their domains, and the same place after a whole turn of an angle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from hjsolve import arguments
from hjsolve.errors import InvalidSystemError
from hjsolve.formulas.point_values import NoValueError, evaluate
from hjsolve.formulas.read import admit, number, parse
from hjsolve.mechanics.coordinates_and_parameters import Coordinate, Parameter
from hjsolve.mechanics.periodicity import check_periodic
from hjsolve.mechanics.positive_definite import sample_points

AXES = ("x", "y", "z")
_EXAMPLE = '{"x": "r*cos(phi)", "y": "r*sin(phi)"}'
Places = tuple[tuple[str, sp.Expr], ...]


def read_place(
    given: object, symbols: Mapping[str, sp.Symbol], coordinates: Sequence[Coordinate], parameters: Sequence[Parameter]
) -> Places:
    """Read where coordinates are in space.

    Args:
        given: x, y, z or some of them → text or sympy expression of the coordinates and parameters; None for nowhere.
        symbols: of coordinates and parameters, by name.

    Returns:
        Axis and formula, in the order x, y, z.

    Raises:
        InvalidSystemError: another axis, a formula of velocities, or one without a value in the domain, or that a whole
            turn of an angle changes.
        ExpressionError: a formula cannot be read.
    """
    table = arguments.table({} if given is None else given, "place", _EXAMPLE)
    for axis in table:
        if axis not in AXES:
            raise InvalidSystemError(
                f'place: "{axis}" is not an axis; give x, y, z as functions of the coordinates: {_EXAMPLE}'
            )
    places = tuple((axis, _formula(table[axis], axis, symbols)) for axis in AXES if axis in table)
    if places:
        check_periodic([(f"place.{axis}", f) for axis, f in places], coordinates, parameters)
        _check_values(places, coordinates, parameters)
    return places


def _formula(given: object, axis: str, symbols: Mapping[str, sp.Symbol]) -> sp.Expr:
    source = f"place.{axis}"
    if isinstance(given, str):
        return parse(given, symbols, source=source)
    if isinstance(given, sp.Expr):
        return admit(given, symbols, source=source)
    if isinstance(given, (int, float)):
        return number(given, source=source)
    raise InvalidSystemError(f"{source}: a formula of the coordinates is needed, not {arguments.described(given)}")


def _check_values(places: Places, coordinates: Sequence[Coordinate], parameters: Sequence[Parameter]) -> None:
    for axis, formula in places:
        for point in sample_points(coordinates, parameters):
            try:
                evaluate(formula, point)
            except NoValueError:
                at = ", ".join(f"{s.name} = {float(v):.4g}" for s, v in point.items() if s in formula.free_symbols)
                raise InvalidSystemError(
                    f"place.{axis}: {formula} has no real value at {at}, which is in the domain"
                ) from None


def place_of(coordinates: Sequence[Coordinate], places: Places) -> dict[str, sp.Expr]:
    """Return axis → formula: as declared, or of coordinates called x, y, z themselves; empty where nothing is known.

    Args:
        places: as declared.
    """
    if places:
        return dict(places)
    names = [c.name for c in coordinates]
    if len(names) in (2, 3) and set(names) <= set(AXES) and all(c.domain.kind != "angle" for c in coordinates):
        return {axis: c.symbol for axis in AXES for c in coordinates if c.name == axis}
    return {}
