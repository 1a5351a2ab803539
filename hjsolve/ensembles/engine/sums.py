"""What the integrals of one coordinate over a cycle are, for many orbits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.number_types import Mask, Reals, Which


@dataclass(frozen=True)
class Sums:
    """Integrals of one coordinate; arrays (n,), or (constants, n).

    Attributes:
        action: (1/2π) ∮ |p| dq.
        means: ∂J/∂cⱼ.
        oscillations: ∫₀^χ₀ kⱼ r dχ less its mean growth.
        phase: χ of the start.
        speeds: kⱼ r there.
        action_error, mean_errors, oscillation_errors, phase_error: bounds.
        good: True where the nodes sufficed.
    """

    action: Reals
    action_error: Reals
    means: Reals
    mean_errors: Reals
    oscillations: Reals
    oscillation_errors: Reals
    phase: Reals
    phase_error: Reals
    speeds: Reals
    good: Mask

    def put(self, index: Which, other: Sums) -> None:
        """Write the results of some orbits into these.

        Args:
            index: the places of the orbits, positions or a mask.
            other: their results, in the same order.
        """
        for name in self.__dataclass_fields__:
            mine, theirs = getattr(self, name), getattr(other, name)
            mine[..., index] = theirs

    def take(self, index: Which) -> Sums:
        """Return the results of some of the orbits.

        Args:
            index: which, positions or a mask.
        """
        return Sums(**{name: getattr(self, name)[..., index] for name in self.__dataclass_fields__})


def empty(constants: int, count: int) -> Sums:
    """Return sums that hold nothing: nan, and ``good`` nowhere true.

    Args:
        constants: how many constants of the motion there are.
        count: how many orbits.
    """
    row, block = (lambda: np.full(count, np.nan)), (lambda: np.full((constants, count), np.nan))
    return Sums(row(), row(), block(), block(), block(), block(), row(), row(), block(), np.zeros(count, dtype=bool))
