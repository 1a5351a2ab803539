"""T and V of a system as they were written, read and checked term by term."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import sympy as sp

from hjsolve.errors import InvalidSystemError
from hjsolve.formulas.read import admit, number, parse
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.mechanics.kinetic_energy import check_quadratic


def read_signature(signature: str) -> Literal["definite", "indefinite"]:
    """Read the signature of T.

    Args:
        signature: ``definite`` or ``indefinite``.

    Raises:
        InvalidSystemError: another word.
    """
    if signature == "definite":
        return "definite"
    if signature == "indefinite":
        return "indefinite"
    raise InvalidSystemError(f"signature: {signature!r} is unknown; write definite or indefinite")


@dataclass(frozen=True)
class Formulas:
    """What a formula of a system may hold.

    Attributes:
        coordinates: of the system.
        symbols: of coordinates and parameters, by name.
        functions: left undetermined, by name.
    """

    coordinates: tuple[Coordinate, ...]
    symbols: Mapping[str, sp.Symbol]
    functions: Mapping[str, sp.Expr]

    def kinetic(self, given: object) -> sp.Expr:
        """Read T.

        Args:
            given: text, sympy expression or number.

        Raises:
            InvalidSystemError: it is none of these, or no polynomial of second degree in the velocities.
            ExpressionError: it cannot be read.
        """
        return check_quadratic(self._read(given, "kinetic"), [c.velocity for c in self.coordinates])

    def potential(self, given: object) -> sp.Expr:
        """Read V; absolute values, signs and pieces stand in it as written.

        Args:
            given: text, sympy expression or number.

        Raises:
            InvalidSystemError: it is none of these, or depends on a velocity.
            ExpressionError: it cannot be read.
        """
        potential = self._read(given, "potential", kinks=True)
        for c in self.coordinates:
            if c.velocity in potential.free_symbols:
                raise InvalidSystemError(
                    f"potential: V depends on {c.velocity}; V may depend on coordinates only. A term linear in "
                    "velocities belongs into kinetic, with the opposite sign (L = T − V)"
                )
        return potential

    def _read(self, given: object, source: str, *, kinks: bool = False) -> sp.Expr:
        speeds = {c.name: c.velocity for c in self.coordinates}
        if isinstance(given, str):
            return parse(given, self.symbols, velocities=speeds, functions=self.functions, kinks=kinks, source=source)
        if isinstance(given, sp.Expr):
            return admit(given, self.symbols, velocities=speeds, kinks=kinks, source=source)
        if isinstance(given, (int, float)):
            return number(given, source=source)
        raise InvalidSystemError(
            f"{source}: expected a formula as text or as a sympy expression, got {type(given).__name__}"
        )
