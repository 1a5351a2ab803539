"""What became of an orbit: one list of codes, for the engine that decides and for the batch that shows."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """What became of an orbit. Rows of all but ``ok`` hold NaN where a quantity does not exist or is not known."""

    OK = 0
    UNBOUNDED = 1
    ASYMPTOTIC = 2
    REACHES_BOUNDARY = 3
    FORBIDDEN = 4
    OUTSIDE_DOMAIN = 5
    NOT_FINITE = 6
    NOT_CONVERGED = 7
    AMBIGUOUS = 8

    @property
    def word(self) -> str:
        """The word that ``Batch.status`` shows."""
        return self.name.lower()

    @property
    def meaning(self) -> str:
        """One sentence about it."""
        return _MEANINGS[self]


_MEANINGS = {
    Status.OK: "every number wanted is there",
    Status.UNBOUNDED: "a coordinate escapes: it has no action, frequency or angle",
    Status.ASYMPTOTIC: "on a separatrix: an equilibrium is approached for ever, or stood on without stability",
    Status.REACHES_BOUNDARY: "the orbit reaches an end of a domain in a finite time (a collision, an axis)",
    Status.FORBIDDEN: "no real motion has these constants",
    Status.OUTSIDE_DOMAIN: "the place lies outside the domain, or on a singularity of the coordinates",
    Status.NOT_FINITE: "an input is NaN or infinite",
    Status.NOT_CONVERGED: "a result did not reach 15 digits",
    Status.AMBIGUOUS: "several tori have these actions; kinds={…} chooses between libration and rotation, q={…} a well",
}


UNDECIDED, ENDLESS = len(Status), len(Status) + 1
"""Codes between the passes, never shown: not decided; no turning point was found, which proves nothing."""
