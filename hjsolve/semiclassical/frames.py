"""The coordinates in which the tori of given ignorable momenta are found, and the tori with given actions there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import Reals
from hjsolve.errors import NotSeparableError
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.through_poles.continuation import continued_coordinates
from hjsolve.motion.tori.from_actions import AskedTorus, asked_torus, candidates_of, tori_of, wanted_of
from hjsolve.motion.tori.polish import Torus
from hjsolve.motion.tori.radicand_curve import Cycle
from hjsolve.motion.tori.search import Candidate, SampledActions, sampled_actions
from hjsolve.semiclassical.maslov_indices import ROTATION, Circuit, Poles, circuits_of, poles_in_doubles, walls_of
from hjsolve.solution.quadratures import Solution, solve

_DOUBLINGS = 40
"""How often the action of sampled rotations is doubled, at most."""
_SHAPE = 512
"""Places at which the maxima of p² inside a well are counted."""
_FLAT = 1e-9
"""Change of p² along a turn, over p², below which nothing stands in the turn."""

FoundTorus = tuple[Candidate, Torus]


@dataclass(frozen=True, eq=False)
class ContinuedFrame:
    """Coordinates for some ignorable momenta, continued through the poles of those that are zero.

    In its methods ``candidate`` is the torus in doubles, ``circuits`` and ``actions`` are those of each separated
    coordinate, the latter in the limit that ``Circuit`` speaks of.

    Attributes:
        solution: in these coordinates.
        asked: the momenta, with arbitrary other actions.
        hbar: ħ.
        circuits: of each separated coordinate.
        round: coordinates that are ignorable only in these coordinates, because they run through both of their poles.
        known: tori found before, in doubles: (circuits, actions) → tori.
    """

    solution: Solution
    asked: AskedTorus
    hbar: sp.Expr
    circuits: tuple[tuple[Circuit, ...], ...]
    round: tuple[str, ...]
    known: dict[tuple[tuple[Circuit, ...], tuple[sp.Expr, ...]], list[Candidate]] = field(repr=False)

    def candidates(self, circuits: tuple[Circuit, ...], actions: tuple[sp.Expr, ...]) -> list[Candidate]:
        """Return the tori in doubles with given actions that go round in given circuits."""
        if (circuits, actions) not in self.known:
            kinds = {name: circuit.kind for name, circuit in zip(self.solution.coordinates, circuits, strict=True)}
            found = candidates_of(self._with(circuits, actions), kinds, partial(self._meant, circuits))
            self.known[circuits, actions] = [c for c in found if self._fit(circuits, c)]
        return self.known[circuits, actions]

    def tori(self, circuits: tuple[Circuit, ...], actions: tuple[sp.Expr, ...]) -> list[FoundTorus]:
        """Return the tori with given actions that go round in given circuits, to the digits asked."""
        return tori_of(self._with(circuits, actions), self.candidates(circuits, actions))

    def _with(self, circuits: tuple[Circuit, ...], actions: tuple[sp.Expr, ...]) -> AskedTorus:
        rows = zip(self.solution.coordinates, circuits, actions, strict=True)
        own = {name: circuit.multiple * J for name, circuit, J in rows}
        return replace(self.asked, actions={**self.asked.actions, **own})

    def _meant(self, circuits: tuple[Circuit, ...], rows: Sequence[tuple[float, float, bool]]) -> bool:
        own = zip(circuits, self.asked.curves, rows, strict=True)
        return all(circuit.fits(curve, *row, crude=True) for circuit, curve, row in own)

    def _fit(self, circuits: tuple[Circuit, ...], candidate: Candidate) -> bool:
        rows = zip(circuits, self.asked.curves, candidate.cycles, strict=True)
        return all(circuit.fits(curve, c.low, c.high, c.kind == ROTATION) for circuit, curve, c in rows)

    def energy(self, torus: Torus) -> sp.Expr:
        """Return E of a torus."""
        return torus.initial.constants[next(iter(self.solution.constants))]

    def shape(self, candidate: Candidate) -> tuple[int, ...]:
        """Count the maxima of p² inside the wells of a torus: tori of one family have as many."""
        return tuple(_maxima(p) if c.kind != ROTATION else 1 for p, c in zip(*self._inside(candidate), strict=True))

    def has_barrier(self, candidate: Candidate, k: int) -> bool:
        """Tell whether a motion passes over a barrier along a coordinate, below which its family does not exist.

        Args:
            k: position of the coordinate.
        """
        squares, cycles = self._inside(candidate)
        if cycles[k].kind != ROTATION:
            return _maxima(squares[k]) > 1
        return bool(np.ptp(squares[k]) > _FLAT * np.max(squares[k]))

    def _inside(self, candidate: Candidate) -> tuple[list[Reals], tuple[Cycle, ...]]:
        """p² on places inside the cycle of each coordinate."""
        rows = zip(self.asked.curves, candidate.cycles, strict=True)
        places = [(curve, np.linspace(c.low, c.high, _SHAPE + 2)[1:-1]) for curve, c in rows]
        return [curve.value(q, candidate.constants) for curve, q in places], candidate.cycles

    def sampled(self, energy: float | None) -> list[SampledActions]:
        """Return samples of bounded motions below an energy: at rest, and faster and faster where none need be at rest.

        Args:
            energy: the greatest; None for any.
        """
        limit, n = np.inf if energy is None else energy, len(self.solution.coordinates)
        solution, values, curves, wanted = self.solution, self.asked.values, self.asked.curves, wanted_of(self.asked)
        hbar = float(to_bits(self.hbar)(64))
        found = [sampled_actions(solution, values, curves, wanted, limit)]
        moving = any(curve.turn or all(curve.walls) for curve in curves)
        for k in range(_DOUBLINGS if moving else 0):
            faster = replace(wanted, actions=np.full(n, hbar * 2.0**k))
            found.append(sampled_actions(solution, values, curves, faster, limit))
            if np.max(found[-1].actions, initial=0.0) < hbar * 2.0 ** (k - 1):
                break
        return found

    def actions_seen(self, circuits: tuple[Circuit, ...], samples: Sequence[SampledActions]) -> Reals | None:
        """Return the actions of the samples that follow some circuits, shape (n, s); None where none does.

        Args:
            samples: of this frame.
        """
        found = []
        for table in samples:
            for s in range(len(table.energies)):
                rows = zip(table.low[:, s], table.high[:, s], table.rotations[:, s], strict=True)
                if self._meant(circuits, [(float(low), float(high), bool(round_)) for low, high, round_ in rows]):
                    found.append(table.actions[:, s] / [circuit.multiple for circuit in circuits])
        return np.stack(found, axis=1) if found else None


def frame_of(
    solution: Solution, momenta: Mapping[str, sp.Expr], values: Mapping[sp.Symbol, sp.Expr], hbar: sp.Expr, digits: int
) -> ContinuedFrame:
    """Choose the coordinates for some ignorable momenta.

    Args:
        momenta: ignorable coordinate → its momentum; also of those in ``ContinuedFrame.round``, 0 where left out.
        values: parameter → exact number.
        hbar: ħ.
        digits: asked of energies.
    """
    other = solution
    poles: dict[str, Poles] = {}
    for name, p in momenta.items():
        beyond = continued_coordinates(other.system, name) if p == 0 and name not in solution.coordinates else None
        if beyond is None:
            continue
        try:
            other = solve(beyond.system)
        except NotSeparableError:
            continue
        poles |= {
            c: poles_in_doubles(reflection.lower, reflection.upper, values)
            for c, reflection in beyond.reflections.items()
        }
    own = {p.symbol: values[p.symbol] for p in other.system.parameters}
    actions = {c.name: momenta.get(c.name, sp.S.Zero) for c in other.system.coordinates}
    known = own | {c.momentum: actions[c.name] for c in other.system.coordinates if c.name not in other.coordinates}
    walls = {name: (False, False) if name in poles else walls_of(other, name, known) for name in other.coordinates}
    size = float(to_bits(hbar)(64))
    asked = asked_torus(other, own, actions, digits, frozenset(), exact=True, walls=walls, action=size)
    circuits = tuple(circuits_of(other, name, asked.values, poles.get(name)) for name in other.coordinates)
    gone_round = tuple(name for name in solution.coordinates if name not in other.coordinates)
    return ContinuedFrame(other, asked, hbar, circuits, gone_round, {})


def interval(circuit: Circuit, low: float, high: float) -> tuple[float, float]:
    """Return where a coordinate librates, in the coordinates given: from a pole on, where it passes one.

    Args:
        circuit: round which it goes.
        low, high: its turning points in the coordinates that run on.
    """
    if circuit.poles is None:
        return low, high
    lower, upper = circuit.poles.lower, circuit.poles.upper
    if circuit.kind == "rotation" and lower is not None and upper is not None:
        return lower, upper
    half = (high - low) / 2
    if circuit.across[0] and lower is not None:
        return lower, lower + half
    if circuit.across[1] and upper is not None:
        return upper - half, upper
    if lower is not None and upper is not None:
        shift = 2 * np.pi * np.floor(((low + high) / 2 - lower) / (2 * np.pi))
        return low - shift, high - shift
    return low, high


def _maxima(p: Reals) -> int:
    inner = int(np.sum((p[1:-1] > p[:-2]) & (p[1:-1] >= p[2:])))
    return inner + int(p[0] > p[1]) + int(p[-1] > p[-2])


def overlapping(one: Sequence[tuple[float, float]], other: Sequence[tuple[float, float]]) -> bool:
    """Tell whether wells overlap along every coordinate.

    Args:
        one, other: intervals.
    """
    return all(a < d and c < b for (a, b), (c, d) in zip(one, other, strict=True))
