"""Walls that take energy: bounces that accumulate at a finite time, and bodies that stay on a wall.

With restitution e < 1 and a force towards the wall the speeds after the bounces fall like eⁿ, and the whole of them
takes a finite time (Zeno). Speed after → speed before the next bounce is an analytic map of slope 1, so the times are
tₙ = t∞ + c₁ eⁿ + c₂ e²ⁿ + …, and so is every quantity at the bounces: the limit follows by Richardson's rule with the
known ratios e, e², … (Brezinski & Redivo Zaglia, *Extrapolation Methods*, §2.1), long before the bounces are too small
to be seen. Its error is taken from the change with the last bounce.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import Multi, bits_for
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.display.shown import Shown
from hjsolve.errors import required
from hjsolve.lowering import lower
from hjsolve.mechanics.system import System, hamiltonian, velocities
from hjsolve.motion.initial_data import to_bits
from hjsolve.scenes.events import Event, Pending, once
from hjsolve.scenes.question import Question

_COLUMNS, _FEWEST, _SAFETY_OF_DIFFERENCES = 40, 4, 8


@dataclass(frozen=True, eq=False, repr=False)
class Rest(Shown):
    """How a scene ended early: a body that a wall keeps.

    Attributes:
        wall: the event it stays at.
        bounces: how many of them, one after the other, were followed.
        time: when the last of infinitely many bounces is over, or the only one.
        q, p: coordinate → position and momentum then; whole turns of angles included.
        alone: True where nothing else moves, so that the body is at rest from then on.
        limit: the time in many digits.
        last: that of the last bounce that was followed.
        speed, push: of the wall's coordinate just after it, velocity and momentum less that at rest.
    """

    wall: Event
    bounces: int
    time: Estimate
    q: Mapping[str, Estimate]
    p: Mapping[str, Estimate]
    alone: bool
    limit: Mpf
    last: Mpf
    speed: Mpf
    push: Mpf

    def __str__(self) -> str:
        """Say what happened."""
        how = "its bounces accumulate" if self.bounces > 1 else "it does not bounce"
        slides = "the scene ends: what follows slides along the wall"
        after = "the body rests there from then on" if self.alone else slides
        return f"{self.wall}: {how} at t = {self.time}; {after}"


@dataclass(frozen=True, eq=False)
class Landing:
    """The state just after a bounce: time, positions and momenta in many digits, in the order of the coordinates."""

    time: Mpf
    values: tuple[Mpf, ...]


def acceleration(system: System, name: str) -> sp.Expr:
    """q̈ of a coordinate where no wall is: d/dt ∂H/∂p by Hamilton's equations, in coordinates and momenta.

    Args:
        system: with H(q, p).
    """
    H, rates = hamiltonian(system), velocities(system)
    return sp.Add(*(
        sp.diff(rates[name], c.symbol) * rates[c.name] - sp.diff(rates[name], c.momentum) * sp.diff(H, c.symbol)
        for c in system.coordinates
    ))  # fmt: skip


class Settling:
    """Bounces at one wall after the other, and where they lead.

    Args:
        scene: what is run.
        values: exact parameters, by symbol, among others.
        work: digits of the states.
    """

    def __init__(self, scene: Question, values: Mapping[sp.Symbol, sp.Expr], work: int):
        self.system, self.digits, self.work, self.times = scene.system, max(scene.digits, 15), work, scene.times
        self.parameters = {p.symbol: values[p.symbol] for p in scene.system.parameters}
        self.arithmetic = Multi(bits_for(work, 64))
        self.wall: Event | None = None
        self.landings: list[Landing] = []
        self.rows: list[_Limit] = []

    def landed(
        self,
        events: Sequence[Event],
        time: sp.Expr,
        state: Mapping[str, Mapping[str, sp.Expr]],
        side: int,
        pending: Sequence[Pending],
    ) -> Rest | None:
        """Take note of a bounce that costs energy, and say whether it is the end.

        Args:
            events: that happened.
            time: exact.
            state: ``q`` and ``p`` just after, exact.
            side: of the wall that the body is on, −1 below its surface.
            pending: what is to come.
        """
        walls = [e for e in once(events) if e.kind == "wall"]
        if len(walls) != 1 or walls[0] is not self.wall:
            self.wall, self.landings, self.rows = walls[0] if len(walls) == 1 else None, [], []
        if self.wall is None:
            return None
        names, bits = [c.name for c in self.system.coordinates], self.arithmetic.bits
        values = tuple(to_bits(state[group][n])(bits) for group in ("q", "p") for n in names)
        here = Landing(to_bits(time)(bits), values)
        self.landings.append(here)
        if not self.wall.restitution:
            push = self._evaluated(acceleration(self.system, str(self.wall.coordinate)))
            return self._kept(here) if side * push <= 0 else None
        if not self.rows:
            self.rows = [_Limit(to_bits(self.wall.restitution)(bits), self.work) for _ in (here.time, *values)]
        for row, value in zip(self.rows, (here.time, *values), strict=True):
            row.add(value)
        return self._ending(pending)

    def _kept(self, here: Landing) -> Rest:
        """Return a wall without any restitution, and a body that is pressed against it."""
        return self._rest(here, [self.arithmetic.context.mpf(10) ** (4 - self.work) * abs(x)
                                 for x in (here.time, *here.values)], 1)  # fmt: skip

    def _ending(self, pending: Sequence[Pending]) -> Rest | None:
        """Return the limit of the bounces, where it is known well enough and nothing is asked or happens before it."""
        if len(self.landings) < _FEWEST:
            return None
        a, b, c = (landing.time for landing in self.landings[-3:])
        if c - b >= b - a:
            return None
        limits, context = [row.limit() for row in self.rows], self.arithmetic.context
        time, error = limits[0]
        fine = context.mpf(10) ** -(self.digits + 1)
        goal = fine * max(1, abs(time))
        last = None if self.times is None else to_bits(self.times.last)(self.arithmetic.bits)
        if error > goal or (last is not None and time - error > last):
            return None
        if any(error > fine * row.size for row, (_, error) in zip(self.rows, limits, strict=True)):
            return None
        if time - c > goal and (self._asked(c, time - error) or self._met(pending, limits)):
            return None
        return self._rest(Landing(time, tuple(v for v, _ in limits[1:])), [e for _, e in limits], len(self.landings))

    def _asked(self, begin: Mpf, end: Mpf) -> bool:
        """Return whether the state is wanted at some time between."""
        if self.times is None:
            return False
        return any(begin < to_bits(t)(self.arithmetic.bits) < end for t in self.times.between(float(begin), float(end)))

    def _met(self, pending: Sequence[Pending], limits: Sequence[tuple[Mpf, Mpf]]) -> bool:
        """Return whether another event comes before the limit."""
        names = [c.name for c in self.system.coordinates]
        for p in pending:
            if p.event is self.wall:
                continue
            if p.event.time is not None:
                if to_bits(p.event.time)(self.arithmetic.bits) < limits[0][0]:
                    return True
                continue
            k = names.index(required(p.event.coordinate))
            here, there = self.landings[-1].values[k], limits[1 + k][0]
            place = to_bits(p.event.value)(self.arithmetic.bits)
            distance = 2 * abs(there - here)
            off = place - here
            if self.system.coordinates[k].domain.kind == "angle":
                turn = 2 * self.arithmetic.context.pi
                off -= turn * self.arithmetic.context.nint(off / turn)
            if abs(off) <= distance and distance:
                return True
        return False

    def _evaluated(self, formula: sp.Expr) -> Mpf:
        """Return a formula in coordinates and momenta just after the last bounce."""
        symbols = [c.symbol for c in self.system.coordinates] + [c.momentum for c in self.system.coordinates]
        tape = lower([formula], [*symbols, *self.parameters])
        fixed = [to_bits(value)(self.arithmetic.bits) for value in self.parameters.values()]
        return tape.run(self.arithmetic, [*self.landings[-1].values, *fixed])[0]

    def _rest(self, at: Landing, errors: Sequence[Mpf], bounces: int) -> Rest:
        wall = required(self.wall)
        names, n = [c.name for c in self.system.coordinates], len(self.system.coordinates)
        found = [self._estimate(v, e) for v, e in zip((at.time, *at.values), errors, strict=True)]
        q, p = dict(zip(names, found[1 : n + 1], strict=True)), dict(zip(names, found[n + 1 :], strict=True))
        place = to_bits(wall.value)(self.arithmetic.bits)
        q[str(wall.coordinate)] = self._estimate(place, 0)
        last, k = self.landings[-1], names.index(str(wall.coordinate))
        speed = self._evaluated(velocities(self.system)[names[k]])
        push = last.values[n + k] - at.values[n + k]
        return Rest(wall, bounces, found[0], q, p, n == 1, at.time, last.time, speed, push)

    def _estimate(self, value: Mpf, error: Mpf | int) -> Estimate:
        if self.digits > 15:
            return Estimate(value, abs(error) + abs(value) * self.arithmetic.context.mpf(10) ** -self.digits)
        rounded = float(value)
        return Estimate(rounded, abs(float(error)) + abs(float(value - rounded)))


class _Limit:
    """Richardson's table of one quantity, its last two rows.

    Args:
        ratio: e.
        work: digits of the values.
    """

    def __init__(self, ratio: Mpf, work: int):
        self.ratio, self.noise = ratio, ratio.context.mpf(10) ** (2 - work)
        self.last: list[Mpf] = []
        self.before: list[Mpf] = []
        self.size = 0 * ratio

    def add(self, value: Mpf) -> None:
        """One more bounce."""
        self.size = max(self.size, abs(value))
        row = [value]
        for j, old in enumerate(self.last[:_COLUMNS], start=1):
            power = self.ratio**j
            row.append((row[-1] - power * old) / (1 - power))
        self.last, self.before = row, self.last

    def limit(self) -> tuple[Mpf, Mpf]:
        """Return the best entry of the last row and a bound on its error."""
        best: tuple[Mpf, Mpf] | None = None
        grown = self.noise * self.size
        for j in range(1, len(self.before)):
            power = self.ratio**j
            grown = grown * (1 + power) / (1 - power)
            change = abs(self.last[j] - self.before[j]) / (1 - self.ratio ** (j + 1))
            error = _SAFETY_OF_DIFFERENCES * change + grown
            if best is None or error < best[1]:
                best = self.last[j], error
        return required(best)
