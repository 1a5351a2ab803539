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
            own: what this class has besides.
        """
        return cls(**{f.name: getattr(within, f.name) for f in fields(Motion)}, within=within, **own)

    def time_at(self, name: str, value: object, passage: int = 0) -> Estimate:
        """As ``Motion.time_at``, of a coordinate of ``within``, separated or continued through poles.

        Raises:
            InvalidInputError: also for a coordinate that only states have.
        """
        self._refuse_given(name)
        return self.within.time_at(name, value, passage)

    def orbit(self, name: str, *, along: str, values: object) -> Numbers:
        """As ``Motion.orbit``, of coordinates of ``within``; a coordinate that only states have is refused."""
        for coordinate in (name, along):
            self._refuse_given(coordinate)
        return self.within.orbit(name, along=along, values=values)

    def _refuse_given(self, name: str) -> None:
        """Refuse a coordinate that states are given in and that is none of ``within``."""
        raise NotImplementedError
