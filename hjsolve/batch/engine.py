"""The front of the batch engine: which columns, in which chunks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hjsolve.batch.columns import QUANTITIES, Columns, blank
from hjsolve.errors import InvalidInputError
from hjsolve.initial import parameter_values
from hjsolve.solution import Solution


@dataclass(frozen=True)
class Engine:
    """A system made ready for many orbits; made by ``build``.

    Attributes:
        solution: of the system.
        want: which of ``QUANTITIES`` are computed; nothing else is integrated.
        parameters: name → exact value (sympy number), every one.
        names: quantity → names of its columns.
    """

    solution: Solution
    want: frozenset[str]
    parameters: Mapping[str, Any]
    names: Mapping[str, tuple[str, ...]]

    def run(self, q: Mapping[str, Any], p: Mapping[str, Any]) -> Columns:  # noqa: ARG002
        """Compute what is wanted for many orbits.

        Args:
            q, p: every coordinate → positions and canonical momenta, float64 arrays of shape (n,).

        Returns:
            Columns of shape (n,).
        """
        count = len(np.asarray(next(iter(q.values()))))
        return blank(self.names, count)


def build(solution: Solution, want: frozenset[str], parameters: Mapping[str, Any] | None = None) -> Engine:
    """Make a system ready for many orbits.

    Args:
        solution: of the system.
        want: quantities, of ``QUANTITIES``.
        parameters: name → value, where it differs from the default; the same for all orbits.

    Raises:
        InvalidInputError: a quantity that is not known.
        MissingValueError: a parameter without a value.
    """
    for name in sorted(want - set(QUANTITIES)):
        raise InvalidInputError(f'want: "{name}" is not known for many orbits; known are {", ".join(QUANTITIES)}')
    values = parameter_values(solution.system, parameters or {})
    return Engine(solution, want, {str(s): v for s, v in values.items()}, _names(solution, want))


def _names(solution: Solution, want: frozenset[str]) -> dict[str, tuple[str, ...]]:
    """Columns of every quantity: coordinates that are separated or ignorable angles have actions and angles."""
    periodic = tuple(
        c.name for c in solution.system.coordinates if c.name in solution.coordinates or c.domain.kind == "angle"
    )
    ends = tuple(f"{name}.{side}" for name in solution.coordinates for side in ("lower", "upper"))
    names = dict.fromkeys(QUANTITIES, periodic) | {"constants": tuple(solution.constants), "turning_points": ends}
    return {quantity: names[quantity] for quantity in QUANTITIES if quantity in want}
