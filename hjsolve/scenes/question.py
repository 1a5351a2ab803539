"""What one question calls for: a system, numbers, events and the quantities wanted; data, without what answers it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve.catalog.toml_file import Toml
from hjsolve.display.by_value import ByValue
from hjsolve.display.shown import Shown
from hjsolve.mechanics.system import System
from hjsolve.scenes.events import Event
from hjsolve.scenes.initial_grid import Varied

INTEGRATED_DIGITS, MOST_INTEGRATED_DIGITS = 10, 12


Numbers = Mapping[str, object]


@dataclass(frozen=True)
class Times:
    """When the state is wanted: listed, or evenly spaced.

    Attributes:
        listed: exact times; empty where they are evenly spaced.
        start, stop, count: of the spacing, both ends included.
        doubles: the listed times, where they are some of those of a spacing in double precision.
    """

    listed: tuple[sp.Expr, ...] = ()
    start: sp.Expr = sp.S.Zero
    stop: sp.Expr = sp.S.Zero
    count: int = 0
    doubles: tuple[float, ...] = ()

    def exact(self) -> list[sp.Expr]:
        """Return every time as an exact number."""
        if self.listed:
            return list(self.listed)
        step = (self.stop - self.start) / (self.count - 1)
        return [self.start + k * step for k in range(self.count)]

    def between(self, begin: float, end: float) -> list[sp.Expr]:
        """Return the times from ``begin`` to ``end``, and perhaps one more on each side.

        Args:
            begin, end: the span of time, in the units of t.
        """
        if self.listed:
            return [t for t in self.listed if begin - 1 <= t <= end + 1]
        step = (self.stop - self.start) / (self.count - 1)
        first, last = (math.floor((x - float(self.start)) / float(step)) for x in (begin, end))
        return [self.start + k * step for k in range(max(first - 1, 0), min(last + 3, self.count))]

    @property
    def last(self) -> sp.Expr:
        """The latest time."""
        return sp.Max(*self.listed) if self.listed else sp.Max(self.start, self.stop)

    @property
    def first(self) -> sp.Expr:
        """The earliest time."""
        return sp.Min(*self.listed) if self.listed else sp.Min(self.start, self.stop)


@dataclass(frozen=True)
class InitialGroups:
    """Initial data of a scene: exact numbers at the time ``t``; velocities or momenta."""

    q: Numbers
    velocity: Numbers | None
    p: Numbers | None
    t: sp.Expr


@dataclass(frozen=True)
class OrbitAsked:
    """The orbit equation wanted: ``of`` as a function of ``along``; at ``values``, or at places chosen by the run."""

    of: str
    along: str
    values: tuple[object, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class Question(ByValue, Shown):
    """What one question calls for.

    Attributes:
        source: the file, or ``scene``.
        title, summary: for display.
        table: of the system, as in its file.
        effects: names of those switched on.
        system: with the terms that the effects add to T and V.
        forces: generalized forces of the effects, by coordinate; with any of them only ``integrate`` can run the scene.
        parameters: values that differ from the defaults.
        initial: where the motion starts; None if nothing says so.
        want: the quantities wanted.
        times: for ``trajectory`` and ``angles``.
        digits: relative digits of every number.
        events: impulses and walls, in the file's order.
        orbit: see ``OrbitAsked``.
        method: ``quadratures`` (Hamilton-Jacobi) or ``integrate`` (an ODE integrator).
        certified: constants, turning points, actions, frequencies and periods are proved.
        seconds: the time allowed, where the scene asks for the best that fits into it instead of digits.
        coordinates: ``as given``, or ``find`` for others where those of the system do not separate; initial data,
            events and the trajectory speak the system's own either way.
        velocity_frame: ``coordinate``, or ``orthonormal`` where the velocities given are along unit vectors.
        sweep: many initial conditions in place of one; such a scene is for ``hjsolve.sweep``, not for ``run``.
    """

    source: str
    title: str
    summary: str
    table: Toml
    effects: tuple[str, ...]
    system: System
    forces: Mapping[str, sp.Expr]
    parameters: Numbers
    initial: InitialGroups | None
    want: tuple[str, ...]
    times: Times | None
    digits: int
    events: tuple[Event, ...]
    orbit: OrbitAsked | None
    method: str
    certified: bool = False
    seconds: float | None = None
    sweep: Varied | None = None
    coordinates: str = "as given"
    velocity_frame: str = "coordinate"

    @property
    def fixed(self) -> dict[str, Mapping[str, object] | None]:
        """The initial data by group: ``q``, ``p``, ``velocity``; what a sweep does not vary is taken from them."""
        start = self.initial
        return {} if start is None else {"q": start.q, "p": start.p, "velocity": start.velocity}
