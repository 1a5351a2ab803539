"""A curve of a family: points with their momenta, errors, and place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hjsolve.arithmetic.number_types import Reals
from hjsolve.display.by_value import ByValue
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.motion.state import Errors, Placing, State


@dataclass(frozen=True, repr=False, eq=False)
class FamilyCurve(ByValue, Shown):
    """A wavefront, an orbit or a caustic of a family.

    Attributes:
        kind: ``front``, ``orbit`` or ``caustic``.
        value: of a front, W; of an orbit, its number in the family; of a caustic, the coordinate's turning point, or
            NaN for an envelope.
        q: coordinate → positions along the curve, shape (n,); angles are not reduced. NaN where it is interrupted.
        p: coordinate → ∂W/∂q of the orbit that passes there, shape (n,).
        errors: the rule behind ``error``.
        placing: the rule behind ``place``.
    """

    kind: str
    value: float
    q: Mapping[str, Reals]
    p: Mapping[str, Reals]
    errors: Callable[[], Errors] = field(repr=False, compare=False)
    placing: Placing | None = field(repr=False, compare=False)

    def _label(self) -> str:
        return f"{self.kind} {self.value:.6g}"

    @property
    def error(self) -> Errors:
        """Bounds on the errors of q, p, and of the place where that is known, worked out when asked for."""
        found = self.errors()
        if self.placing is None:
            return found
        return Errors(found.q, found.p, {}, self.placing.bounds(self._state(), found))

    @property
    def place(self) -> dict[str, Any]:
        """Where the points are in space: x, y, z (those there are) → values of shape (n,).

        Raises:
            InvalidInputError: the system does not say where its coordinates are.
        """
        if self.placing is None:
            raise InvalidInputError(
                'place: the system does not say where its coordinates are; System(…, place={"x": …})'
            )
        return self.placing.values(self._state())

    def _state(self) -> State:
        some = next(iter(self.q.values()))
        unknown, status = np.full(some.shape, np.nan), np.full(some.shape, "ok")
        return State(unknown, self.q, self.p, {}, {}, status, self.errors)
