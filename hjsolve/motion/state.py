"""Where the system is at given times: positions, momenta, velocities, each with its error and status."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.display.by_value import ByValue
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError

if TYPE_CHECKING:
    from hjsolve.arithmetic.number_types import AtTimes, Mpf


@dataclass(frozen=True, repr=False, eq=False)
class Errors(ByValue, Shown):
    """Absolute error bounds, laid out like the state itself; scalars or arrays shaped like t."""

    q: Mapping[str, Any]
    p: Mapping[str, Any]
    velocity: Mapping[str, Any]
    place: Mapping[str, Any] = field(default_factory=dict)

    def __reduce__(self) -> tuple[object, ...]:
        return Errors, tuple(dict(group) for group in (self.q, self.p, self.velocity, self.place))


class Placing(Protocol):
    """Where a state is in space; ``motion.placing`` makes one."""

    def values(self, state: State) -> dict[str, AtTimes]:
        """Return axis → value.

        Args:
            state: in the coordinates that the place is a function of.
        """

    def bounds(self, state: State, errors: Errors) -> dict[str, AtTimes]:
        """Return axis → bound on the error.

        Args:
            state: in the coordinates that the place is a function of.
            errors: of its numbers.
        """


@dataclass(frozen=True)
class KnownErrors:
    """The rule behind the errors of a state that was pickled: they are there already."""

    errors: Errors

    def __call__(self) -> Errors:
        """Return them."""
        return self.errors


@dataclass(frozen=True, repr=False, eq=False)
class State(ByValue, Shown):
    """The state at the times ``t``.

    Attributes:
        t: the times asked, as given (scalar or array).
        q: coordinate → position; the principal value in (−π, π] for an angle.
        p: coordinate → canonical momentum.
        velocity: coordinate → dq/dt.
        turns: angle → whole turns (integers) to be added to ``q``.
        status: for each time ``ok``, ``reaches_boundary`` (the motion has ended), or ``not_converged`` (an unbounded
            motion is too far out for the numbers); the numbers are NaN where it is not ``ok``.
        errors: the rule behind ``error``.
        placing: the rule behind ``place``; None where the system says nothing about it.

    Example:
        >>> motion = solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
        >>> state = motion.at([0, "7.5"])
        >>> state.q["r"].round(6).tolist(), bool(state.error.q["r"].max() < 1e-14)
        ([1.0, 2.571428], True)
    """

    t: object
    q: Mapping[str, Any]
    p: Mapping[str, Any]
    velocity: Mapping[str, Any]
    turns: Mapping[str, Any]
    status: Any
    errors: Callable[[], Errors] = field(repr=False, compare=False)
    placing: Placing | None = field(default=None, repr=False, compare=False)

    def __reduce__(self) -> tuple[object, ...]:
        tables = (dict(group) for group in (self.q, self.p, self.velocity, self.turns))
        return type(self), (self.t, *tables, self.status, KnownErrors(self.errors()), self.placing)

    @property
    def error(self) -> Errors:
        """Bounds on the errors of q, p and velocity (and place, where it is known), worked out when asked for."""
        found = self.errors()
        return found if self.placing is None else replace(found, place=self.placing.bounds(self, found))

    @property
    def place(self) -> Mapping[str, Any]:
        """Where the system is in space: x, y, z (those there are) → value.

        Raises:
            InvalidInputError: nothing was said about it.
        """
        if self.placing is None:
            raise InvalidInputError(
                'place: the system does not say where its coordinates are; System(…, place={"x": "r*cos(phi)", …})'
            )
        return self.placing.values(self)

    def unwrapped(self, name: str) -> Any:
        """Return q plus its whole turns, the angle that grows without jumps; q itself for other coordinates.

        Args:
            name: of the coordinate.
        """
        if name not in self.turns:
            return self.q[name]
        value = self.q[name]
        pi = value.context.pi if hasattr(value, "context") else _pi_of(value)
        return value + 2 * pi * self.turns[name]

    def as_array(self, *, unwrapped: bool = False) -> Any:
        """Return the state as integrators take it, [q…, p…] in the order of the coordinates.

        Args:
            unwrapped: whether angles are counted on over their whole turns, without jumps by 2π.

        Returns:
            An array of shape (2n,) for one time, (…, 2n) for an array of times; of doubles, or of mpf beyond 15 digits.
        """
        places = [self.unwrapped(name) if unwrapped else self.q[name] for name in self.q]
        return np.stack([np.asarray(x) for x in (*places, *self.p.values())], axis=-1)


def _pi_of(value: Any) -> float | Mpf:
    """π in the arithmetic of an array."""
    if getattr(value, "dtype", None) is not None and value.dtype.kind == "O" and value.size:
        many: Mpf = +value.flat[0].context.pi
        return many
    return 3.141592653589793


@runtime_checkable
class AnyMotion(Protocol):
    """What every kind of motion answers, however it was found: ``isinstance(motion, AnyMotion)``.

    ``Motion``, those of a moving frame, of linear modes, and of H(q, p) that is not T + V.
    """

    @property
    def kinds(self) -> Mapping[str, str]:
        """Name of what moves (a coordinate, a mode) → libration, rotation, escape, …."""

    @property
    def constants(self) -> Mapping[str, Estimate]:
        """Name of a constant of the motion → its value and error."""

    def at(self, t: object) -> State:
        """Return the state at a time or at an array of times, in the coordinates as posed.

        Args:
            t: a time or an array of times.
        """
