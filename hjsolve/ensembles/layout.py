"""Which columns the result of an ensemble has: quantity by quantity, name by name; known before any number is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from hjsolve import arguments
from hjsolve.catalog.schema import nearest
from hjsolve.ensembles.conventions import AxialRoles, axial_roles
from hjsolve.errors import InvalidInputError
from hjsolve.motion.wanted import OF_MANY_ORBITS
from hjsolve.solution.quadratures import Solution

QUANTITIES = OF_MANY_ORBITS
"""What may be asked of an ensemble."""

STATUS, RECOMPUTED, ERROR = "status", "recomputed", "error."
"""The columns that every result has, and the prefix of the columns of errors."""


@dataclass(frozen=True)
class Layout:
    """The columns of a result.

    Attributes:
        names: wanted quantity → the coordinates (constants) it has values for; in the order of ``QUANTITIES``.
        solution: of the system, where that declares units.
        roles: of the coordinates of an axially symmetric system.
    """

    names: Mapping[str, tuple[str, ...]]
    solution: Solution | None = field(default=None, repr=False, compare=False)
    roles: AxialRoles | None = field(default=None, repr=False, compare=False)

    @property
    def want(self) -> tuple[str, ...]:
        """The quantities wanted."""
        return tuple(self.names)

    def values(self) -> Iterator[str]:
        """Yield the columns of values: ``actions.r`` … ``turning_points.r.lower``."""
        for quantity, names in self.names.items():
            for name in names:
                if quantity == "turning_points":
                    yield from (f"{quantity}.{name}.{side}" for side in ("lower", "upper"))
                else:
                    yield f"{quantity}.{name}"

    def numbers(self) -> tuple[str, ...]:
        """Return the columns of values and, after them, those of their errors."""
        values = tuple(self.values())
        return values + tuple(ERROR + name for name in values)


def wanted(want: Iterable[str] | str | None) -> tuple[str, ...]:
    """Read what is wanted, in the order of ``QUANTITIES``; None for all.

    Args:
        want: one word or several.

    Raises:
        InvalidInputError: a word that is none of them, or no word at all.
    """
    if want is None:
        return QUANTITIES
    words = arguments.words(want, "want", '["actions", "periods"]')
    for word in sorted(words - set(QUANTITIES), key=str):
        raise InvalidInputError(f'want: "{word}" is not known of an ensemble{nearest(str(word), QUANTITIES)}')
    if not words:
        raise InvalidInputError(f"want: is empty; name at least one of {', '.join(QUANTITIES)}")
    return tuple(word for word in QUANTITIES if word in words)


def layout_of(solution: Solution, want: Iterable[str] | str | None) -> Layout:
    """Return the columns that a solution has of what is wanted.

    A quantity that no orbit of the system can have (the action of an ignorable coordinate on a line) has no column.

    Args:
        want: words as in ``wanted``.
    """
    coordinates = solution.system.coordinates
    cyclic = tuple(c.name for c in coordinates if c.name in solution.coordinates or c.domain.kind == "angle")
    names = dict.fromkeys(QUANTITIES, cyclic)
    names["constants"] = tuple(solution.constants)
    names["turning_points"] = tuple(solution.coordinates)
    return Layout(
        {quantity: names[quantity] for quantity in wanted(want)},
        solution if solution.system_as_given.declared_units else None,
        axial_roles(solution),
    )
