"""The answer of two_point: the motions found, how complete they are, and what there is in place of single motions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.display.shown import Shown
from hjsolve.motion.motion import Motion

MORE_SECONDS = ", as the time was used up (budget=)"
"""Ends the statement of a proof that was not finished."""


@dataclass(frozen=True, eq=False, repr=False)
class Connection(Shown):
    """One motion that is at q0 at time 0 and at q1 after the time asked.

    Attributes:
        turns: whole turns; without an angle, whole periods (or there-and-backs) that the time holds.
        path: which one it is, in words.
        p0, p1: coordinate → canonical momentum at q0 and at q1: p0 = −∂S/∂q0, p1 = ∂S/∂q1 (Greenwood (5-17)).
        energy: value of H, −∂S/∂T (5-18).
        principal_function: S(q0, q1, T) = ∫ L dt along it (5-8), in units of action.
        conjugate_points: places along it, before its end, that are conjugate to q0, counted with their multiplicity:
            zeros of det(∂q(t)/∂p0). It is the Morse index of the motion: 0 where ∫ L dt is a minimum.
        sweep: angle → how far it runs in all, in radians, with its sign.
        begin: the rule that starts the motion, with the initial momenta to more digits.
    """

    turns: int
    path: str
    p0: Mapping[str, Estimate]
    p1: Mapping[str, Estimate]
    energy: Estimate
    principal_function: Estimate
    conjugate_points: int
    sweep: Mapping[str, float]
    begin: Callable[[], Motion] = field(repr=False)

    @property
    def motion(self) -> Motion:
        """The motion from q0 at time 0 on, verified to be at q1 after the time asked."""
        return _begun(self)

    def _label(self) -> str:
        return f"{self.path}, S = {self.principal_function.value:.9g}"


@lru_cache(maxsize=64)
def _begun(connection: Connection) -> Motion:
    return connection.begin()


@dataclass(frozen=True, eq=False, repr=False)
class Completeness(Shown):
    """Whether the motions found are all that there are. It is true as a condition where that is proved.

    Attributes:
        proved: whether it is.
        statement: what was proved, or where the search looked.
        searched: of a search, what → the range it covered; of a proof that holds up to an energy, that range.
    """

    proved: bool
    statement: str
    searched: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """Return whether completeness is proved."""
        return self.proved

    def __str__(self) -> str:
        """Return the statement, with the ranges of a search."""
        ranges = "; ".join(f"{name} from {low:.6g} to {high:.6g}" for name, (low, high) in self.searched.items())
        return f"{self.statement}{': ' + ranges if ranges else ''}."


@dataclass(frozen=True, eq=False, repr=False)
class Continuum(Shown):
    """A family of motions with a free parameter, all of which join the two places: q1 is conjugate to q0.

    Attributes:
        statement: which motions these are, in a sentence.
        free: what may be chosen.
        turns: whole turns of its motions.
        energy: of its motions, the same for all; None where it is not.
        principal_function: S, the same for all of them.
        member: one of them, as a ``Connection``; None where none is singled out.
    """

    statement: str
    free: tuple[str, ...]
    turns: int
    energy: Estimate | None = None
    principal_function: Estimate | None = None
    member: Connection | None = None

    def __str__(self) -> str:
        """Return the statement and what is free."""
        return f"{self.statement} Free: {', '.join(self.free)}."


@dataclass(frozen=True, eq=False, repr=False)
class Connections(Shown):
    """All motions found that join two places in a time; iterable, those with fewer turns first.

    Attributes:
        connections: the motions.
        complete: whether these are all, with these turns.
        continua: families with a free parameter, in place of single motions.
        least_time: where there is no motion with these turns, the least time in which there is one; None where that is
            not known or does not apply.
    """

    connections: tuple[Connection, ...]
    complete: Completeness
    continua: tuple[Continuum, ...] = ()
    least_time: Estimate | None = None

    def __iter__(self) -> Iterator[Connection]:
        return iter(self.connections)

    def __len__(self) -> int:
        return len(self.connections)

    def __getitem__(self, index: int) -> Connection:
        return self.connections[index]

    def __str__(self) -> str:
        """Return what was found, in a few sentences."""
        count = len(self.connections)
        parts = [f"{count or 'No'} motion{'' if count == 1 else 's'}"]
        if not count and not self.continua and self.least_time is not None:
            parts[0] += f" in this time; the least time with these turns is {self.least_time.value:.9g}"
        sentences = [f"{parts[0]}.", *(str(family) for family in self.continua), str(self.complete)]
        return " ".join(sentences)
