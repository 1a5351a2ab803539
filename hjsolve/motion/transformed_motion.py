"""A motion computed in other coordinates than those in which its states are given."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Self

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.number_types import Numbers
from hjsolve.motion.motion import Motion


@dataclass(frozen=True, eq=False, repr=False)
class TransformedMotion(Motion):
    """A motion with the results of another, which gives its states in other coordinates.

    Attributes:
        within: the motion in the coordinates it is computed in.
    """

    within: Motion = field(kw_only=True, repr=False)

    @classmethod
    def of(cls, within: Motion, **own: Any) -> Self:
        """Return the motion with the results of another.

        Args:
            within: the other.
            own: what this class has besides.
        """
        return cls(**{f.name: getattr(within, f.name) for f in fields(Motion)}, within=within, **own)

    def time_at(self, name: str, value: object, passage: int = 0) -> Estimate:
        """Return the time of the passage-th crossing of a position, counted from t₀ on.

        Args:
            name: coordinate of ``within``, separated or continued through poles.
            value: position; for an angle modulo 2π.
            passage: 0 for the first crossing at t ≥ t₀, 1 for the next, −1 for the last before t₀ …

        Raises:
            InvalidInputError: an unknown coordinate, one that only states have, a value that is not a number, or
                a passage that is not whole.
            OutsideMotionError: the motion never reaches that position, or not that often.
        """
        self._refuse_given(name)
        return self.within.time_at(name, value, passage)

    def orbit(self, name: str, *, along: str, values: object) -> Numbers:
        """Return one coordinate where another passes given values for the first time after t₀.

        Args:
            name: coordinate of ``within`` that is wanted; unwrapped if it is an angle.
            along: coordinate of ``within`` whose values are given.
            values: positions of ``along``, shape (m,).

        Returns:
            Array of shape (m,).

        Raises:
            InvalidInputError: an unknown coordinate, one that only states have, or a value that is not a number.
            OutsideMotionError: the motion never reaches a value.
        """
        for coordinate in (name, along):
            self._refuse_given(coordinate)
        return self.within.orbit(name, along=along, values=values)

    def _refuse_given(self, name: str) -> None:
        """Refuse a coordinate that states are given in and that is none of ``within``."""
        raise NotImplementedError
