"""The verb of this room: every semiclassical level up to an energy.

For each set of ignorable momenta p = m ħ and each circuit of the cycles (``circuits``) the quantum numbers are counted
up until the energy of the torus with J = (n + μ/4) ħ is too large. Tori are those of ``motion.tori``: where several
families have the same actions, wells or both sides of a barrier, each gives a level.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS, bits_for
from hjsolve.arithmetic.number_types import Reals
from hjsolve.errors import InvalidInputError, required
from hjsolve.formulas.read import number
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.quantities_given import in_units
from hjsolve.motion.initial_data import domain_ends, parameter_values, to_bits
from hjsolve.motion.quantities import FLOAT_DIGITS, rounded
from hjsolve.motion.tori.from_actions import names_of_actions
from hjsolve.motion.tori.polish import Torus
from hjsolve.motion.tori.search import Candidate
from hjsolve.precision import one_at_a_time
from hjsolve.semiclassical.frames import ContinuedFrame, FoundTorus, frame_of, interval, overlapping
from hjsolve.semiclassical.ignorable_numbers import numbers_to_begin_with
from hjsolve.semiclassical.level import Level, Levels
from hjsolve.semiclassical.maslov_indices import LIBRATION, ROTATION, Circuit
from hjsolve.solution.quadratures import Solution, solve

_MOST_TORI = 20000
"""Tori that are looked at, at most."""
_MORE, _SPARE = 1.5, 4
"""Quantum numbers that are tried beyond those of samples: as a factor, and how many."""
EXAMPLE = "levels(solution, hbar=1, up_to=-0.01)"


@arguments.with_known_names(EXAMPLE)
@one_at_a_time
def levels(
    solution: Solution | Any,
    hbar: object = 1,
    *,
    up_to: object = None,
    numbers: Mapping[str, object] | None = None,
    parameters: Mapping[str, object] | None = None,
    digits: int = FLOAT_DIGITS,
) -> Levels:
    """Return the semiclassical levels of a system: the tori with J = (n + μ/4) ħ (Einstein, Brillouin, Keller).

    Maslov indices μ are those of the kinds of motion: 2 for a libration, 3 or 4 with one or two hard walls (ends of a
    domain at which p² is finite), 0 for a rotation and for an ignorable angle, whose J = m ħ. Poles of coordinates are
    turning points for p_φ ≠ 0, and levels with p_φ = 0 are those of the limit p_φ → 0, so that Langer's correction
    needs no further term (``semiclassical.maslov_indices``). A pendulum that rotates has two levels, one a direction.

    Args:
        solution: of the system, or what ``solve`` takes.
        hbar: ħ > 0, in the units of the actions of the system.
        up_to: the greatest energy, a number as ``Solution.motion`` takes it.
        numbers: coordinate → a quantum number, or several, where not all are wanted. Without ``up_to`` every coordinate
            needs one.
        parameters: name → value, where it differs from the default.
        digits: relative digits of the energies, at least 15.

    Returns:
        The levels, lowest first. What the method leaves out is in ``skipped``.

    Raises:
        InvalidInputError: ħ or an energy that is not a number, numbers that are not whole, a system with a coordinate
            that never comes back or with T indefinite, or more levels than can be listed.
        MissingValueError: a parameter without a value.

    Example:
        >>> import hjsolve
        >>> hydrogen = hjsolve.solve("kepler-spherical")
        >>> [(round(level.energy.value, 9), dict(level.numbers)) for level in levels(hydrogen, up_to="-0.4")]
        [(-0.5, {'r': 0, 'theta': 0, 'phi': 0})]

    References:
        Keller, Ann. Phys. 4 (1958) 180, eq. (22); Langer, Phys. Rev. 51 (1937) 669.
    """
    solution = solution if isinstance(solution, Solution) else solve(solution)
    _refuse(solution)
    h = number(hbar, source="hbar")
    if not h > 0:
        raise InvalidInputError(f"hbar: a positive number is needed, not {hbar!r}")
    names = [c.name for c in solution.system.coordinates]
    chosen = {name: _whole(given, name) for name, given in _known(numbers, names)}
    if up_to is None and (missing := [name for name in names if name not in chosen]):
        raise InvalidInputError(f"levels: no up_to and no numbers of {', '.join(missing)}; write {EXAMPLE}")
    limit_kind = tuple((constant.symbol, constant.expression) for constant in solution.constants.values())
    given = in_units(solution.system, {"E": up_to}, "constants", limit_kind) if up_to is not None else None
    limit = None if given is None else number(given["E"], source="up_to")
    values = parameter_values(solution.system, in_units(solution.system, parameters or {}, "parameters") or {})
    search = _Search(solution, values, h, limit, chosen, max(arguments.digits(digits), FLOAT_DIGITS))
    skipped: list[str] = []
    found = sorted(search.everything(skipped), key=_order)
    return Levels(tuple(found), solution, h, limit, tuple(dict.fromkeys(skipped)))


def _refuse(solution: Solution) -> None:
    refuse_kinks(solution.system.kinks, "levels")
    if solution.system.relativity is not None or solution.separation.shell.null:
        raise InvalidInputError("levels: T must be an ordinary kinetic energy, neither relativistic nor indefinite")
    if solution.system.signature == "indefinite":
        raise InvalidInputError("levels: T is indefinite, so there is no lowest level")
    names_of_actions(solution)


def _known(numbers: Mapping[str, object] | None, names: Sequence[str]) -> Iterator[tuple[str, object]]:
    for name, given in arguments.table(numbers or {}, "numbers", '{"phi": 0}').items():
        if name not in names:
            raise InvalidInputError(f"numbers: {name!r} is not a coordinate; known are {', '.join(names)}")
        yield name, given


def _whole(given: object, name: str) -> tuple[int, ...]:
    several = tuple(given) if isinstance(given, Iterable) and not isinstance(given, str) else (given,)
    return tuple(arguments.whole(n, f"numbers[{name}]") for n in several)


def _order(level: Level) -> tuple[float, tuple[int, ...]]:
    return float(level.energy.value), tuple(level.numbers.values())


@dataclass(frozen=True)
class _Search:
    """What is looked for.

    Attributes:
        solution: of the system.
        values: parameter → exact number.
        hbar: ħ.
        limit: greatest energy; None where the numbers alone are given.
        chosen: coordinate → the quantum numbers wanted; those of the others are free.
        digits: of the energies.
    """

    solution: Solution
    values: Mapping[sp.Symbol, sp.Expr]
    hbar: sp.Expr
    limit: sp.Expr | None
    chosen: Mapping[str, tuple[int, ...]]
    digits: int

    @property
    def ignorable(self) -> list[str]:
        """The coordinates whose momentum is m ħ."""
        return [c.name for c in self.solution.system.coordinates if c.name not in self.solution.coordinates]

    def everything(self, skipped: list[str]) -> Iterator[Level]:
        """Yield all levels: outward from the m of least energy, as long as there are tori below the greatest energy.

        Args:
            skipped: filled with what is left out.
        """
        names = self.ignorable
        given = [self.chosen.get(name) for name in names]
        if self.limit is None or all(choice is not None for choice in given):
            for m in itertools.product(*(choice or () for choice in given)):
                yield from self._of(dict(zip(names, m, strict=True)), skipped)[0]
            return
        mirrored = _is_even(self.solution)
        waiting = numbers_to_begin_with(self.solution, self.values, self.hbar, self.limit, given)[::-1]
        seen = set[tuple[int, ...]]()
        while waiting:
            m = waiting.pop()
            opposite = tuple(-k for k in m)
            if m in seen or not all(c is None or k in c for k, c in zip(m, given, strict=True)):
                continue
            twice = mirrored and opposite != m and opposite not in seen
            seen |= {m, opposite} if twice else {m}
            found, more = self._of(dict(zip(names, m, strict=True)), skipped)
            yield from found
            if twice and all(c is None or k in c for k, c in zip(opposite, given, strict=True)):
                signs = dict(zip(names, opposite, strict=True))
                yield from (self._mirrored(level, signs) for level in found)
            if len(seen) > _MOST_TORI:
                raise self._too_many()
            if more:
                for k, (own, choice) in enumerate(zip(m, given, strict=True)):
                    steps = (own + 1, own - 1) if choice is None else choice
                    waiting += [(*m[:k], step, *m[k + 1 :]) for step in steps]
                    waiting += [tuple(-x for x in (*m[:k], step, *m[k + 1 :])) for step in steps]

    def _mirrored(self, level: Level, signs: Mapping[str, int]) -> Level:
        actions = {n: -level.actions[n] if signs.get(n) else J for n, J in level.actions.items()}
        return replace(level, numbers={**level.numbers, **signs}, actions=actions)

    def _too_many(self) -> InvalidInputError:
        return InvalidInputError(
            f"levels: more than {_MOST_TORI} tori below up_to; lower it, or choose quantum numbers by numbers={{…}}"
        )

    def _of(self, m: Mapping[str, int], skipped: list[str]) -> tuple[list[Level], bool]:
        """Return the levels of some ignorable momenta, and whether there may be some beyond them."""
        momenta = {name: k * self.hbar for name, k in m.items()}
        frame = frame_of(self.solution, momenta, self.values, self.hbar, self.digits)
        if not frame.round:
            return self._within(frame, m, {}, skipped)
        found: list[Level] = []
        name, more = frame.round[0], False
        for n in self.chosen.get(name) or itertools.count():
            # a coordinate that runs through both of its poles, with nothing that depends on it, is a free rotation
            own = frame_of(
                self.solution, {**momenta, name: (n + sp.S.Half) * self.hbar}, self.values, self.hbar, self.digits
            )
            levels, below = self._within(own, m, {name: n}, skipped)
            found, more = found + levels, more or below
            if name not in self.chosen and not below:
                break
        return found, more

    def _within(
        self, frame: ContinuedFrame, m: Mapping[str, int], turns: Mapping[str, int], skipped: list[str]
    ) -> tuple[list[Level], bool]:
        """Return the levels of some coordinates, and whether there may be some beyond them."""
        if not frame.solution.coordinates:
            level = self._free(frame, m, turns)
            below = self.limit is None or to_bits(self.limit)(256) >= level.energy.value
            return ([level] if below else []), below
        samples = frame.sampled(self._roughly)
        if samples[0].at_ends.any() and not all(m.values()):
            zero = ", ".join(f"{name} = 0" for name, k in m.items() if k == 0)
            ends = ", ".join(itertools.compress(frame.solution.coordinates, samples[0].at_ends))
            skipped.append(f"{zero}: {ends} falls into an end of its domain at which p^2 is infinite")
        found: list[Level] = []
        # a well that is narrower than samples are apart has none below the greatest energy
        anywhere = frame.sampled(None)
        for circuits in itertools.product(*frame.circuits):
            reach = frame.actions_seen(circuits, samples)
            all_chosen = all(name in self.chosen for name in frame.solution.coordinates)
            if reach is not None or all_chosen or frame.actions_seen(circuits, anywhere) is not None:
                found += _Counting(self, frame, circuits, m, turns, reach).levels()
        first = not any((*m.values(), *turns.values()))
        return found, bool(found) or first or self.limit is None or any(len(table.energies) for table in samples)

    @property
    def _roughly(self) -> float | None:
        """The greatest energy in doubles; None for none."""
        return None if self.limit is None else float(to_bits(self.limit)(64))

    def _free(self, frame: ContinuedFrame, m: Mapping[str, int], turns: Mapping[str, int]) -> Level:
        """Return the level of coordinates that are all ignorable: E = H(p)."""
        system, bits = frame.solution.system, bits_for(self.digits, 128)
        known = {**frame.asked.values, **{system.coordinate(n).momentum: p for n, p in frame.asked.actions.items()}}
        E = to_bits(sp.sympify(frame.solution.separation.shell.potential).subs(known))(bits)
        return self.level(frame, rounded(E, self.digits), m, turns, _Round({}, {}, {}, {}), ())

    def level(
        self, frame: ContinuedFrame, energy: Estimate, m: Mapping[str, int], turns: Mapping[str, int],
        separated: _Round, near: tuple[str, ...],
    ) -> Level:  # fmt: skip
        """Return a level, its coordinates in the order of the system.

        Args:
            frame: in which its torus was found.
            energy: E.
            m: numbers of ignorable coordinates.
            turns: numbers of coordinates that run freely through both of their poles.
            separated: of the others.
            near: coordinates along which a separatrix is near.
        """
        bits = bits_for(self.digits, 128)
        numbers = {**m, **turns, **separated.numbers}
        kinds = {**dict.fromkeys(m, "ignorable"), **dict.fromkeys(turns, LIBRATION), **separated.kinds}
        maslov = {**dict.fromkeys(m, 0), **dict.fromkeys(turns, 2), **separated.maslov}
        wells = dict(separated.wells)
        for name in turns:
            low, high = domain_ends(self.solution.system, name, frame.asked.values)
            wells[name] = float(to_bits(required(low))(64)), float(to_bits(required(high))(64))
        order = [c.name for c in self.solution.system.coordinates]
        # the sign of a rotation is that of its number, and its index is 0
        J = {n: (numbers[n] + sp.Rational(maslov[n], 4)) * self.hbar for n in order}
        return Level(
            energy, {n: numbers[n] for n in order}, {n: kinds[n] for n in order}, {n: maslov[n] for n in order},
            {n: rounded(to_bits(J[n])(bits), self.digits) for n in order},
            {n: wells[n] for n in order if n in wells}, near,
        )  # fmt: skip


@dataclass(frozen=True)
class _Round:
    """How the separated coordinates of a level go round; coordinate → what a ``Level`` has of it."""

    numbers: Mapping[str, int]
    kinds: Mapping[str, str]
    maslov: Mapping[str, int]
    wells: Mapping[str, tuple[float, float]]


def _is_even(solution: Solution) -> bool:
    """Whether the opposite of all ignorable momenta leaves p² as it is."""
    flipped = {c.momentum: -c.momentum for c in solution.system.coordinates if c.name not in solution.coordinates}
    if not solution.coordinates:
        H = solution.separation.shell.potential
        return bool(sp.expand(H - H.xreplace(flipped)) == 0)
    squares = solution.momentum_squared.values()
    return all(sp.expand(F - F.xreplace(flipped)) == 0 for F in squares) and all(
        solution.shift[name] == 0 for name in solution.coordinates
    )


@dataclass(frozen=True)
class _Counting:
    """The levels of one circuit of the cycles, for some ignorable momenta.

    Attributes:
        reach: actions of samples below the greatest energy, shape (n, s); None where none follows the circuits.
    """

    search: _Search
    frame: ContinuedFrame
    circuits: tuple[Circuit, ...]
    m: Mapping[str, int]
    turns: Mapping[str, int]
    reach: Reals | None

    def levels(self) -> list[Level]:
        """Return the levels, counted up in every quantum number until the energy is too large."""
        found: list[Level] = []
        self._count((), found)
        return found

    def _tried(self, k: int) -> tuple[Iterable[int], float]:
        """Return the numbers to try along a coordinate, without signs, and up to which one some may have no torus."""
        name, circuit = self.frame.solution.coordinates[k], self.circuits[k]
        chosen = self.search.chosen.get(name)
        if chosen is not None:
            signed = circuit.direction if circuit.limit_kind == ROTATION else 1
            return sorted({abs(n) for n in chosen if signed * n >= circuit.first}), math.inf
        if self.reach is None:
            return itertools.count(circuit.first), circuit.first
        most = float(np.max(self.reach[k])) / float(to_bits(self.search.hbar)(64))
        return itertools.count(circuit.first), int(_MORE * most) + _SPARE + circuit.first

    def _count(self, begun: tuple[int, ...], found: list[Level]) -> float | None:
        """Add the levels whose first numbers are given; return the least energy of their first tori."""
        if len(begun) == len(self.circuits):
            return self._add(begun, found)
        least, limit = None, math.inf if self.search._roughly is None else self.search._roughly
        numbers, last = self._tried(len(begun))
        for n in numbers:
            lowest = self._count((*begun, n), found)
            if lowest is not None:
                least = lowest if least is None else min(least, lowest)
            if lowest is None or lowest > limit:
                # samples may lie too wide apart to show a narrow well: as long as there are levels, more are tried
                ended = n >= last if lowest is None else not self._others_beyond((*begun, n))
                if ended:
                    break
        return least

    def _others_beyond(self, begun: tuple[int, ...]) -> bool:
        """Tell whether samples below the greatest energy have actions as large as some numbers.

        Motions above a barrier begin at larger numbers than its two wells have. Their energies may be below those of a
        steep third well, which has the smaller numbers too.
        """
        if self.reach is None:
            return False
        hbar = self.search.hbar
        pairs = zip(self.circuits, begun, strict=False)
        least = np.array([abs(float(to_bits(circuit.action(k, hbar))(64))) for circuit, k in pairs])
        return bool(np.any(np.all(self.reach[: len(begun)] >= least[:, None], axis=0)))

    def _add(self, n: tuple[int, ...], found: list[Level]) -> float | None:
        tori = self._tori(n)
        limit = None if self.search.limit is None else to_bits(self.search.limit)(256)
        if len(self.frame.known) > _MOST_TORI:
            raise self.search._too_many()
        energies = []
        for torus in tori:
            E = to_bits(self.frame.energy(torus[1]))(256)
            energies.append(float(E))
            if limit is None or limit >= E:
                found.append(self._level(n, torus))
        return min(energies, default=None)

    def _tori(self, n: Sequence[int]) -> list[FoundTorus]:
        hbar = self.search.hbar
        return self.frame.tori(
            self.circuits, tuple(circuit.action(k, hbar) for circuit, k in zip(self.circuits, n, strict=True))
        )

    def _level(self, n: tuple[int, ...], found: FoundTorus) -> Level:
        candidate, torus = found
        rows = list(zip(self.frame.solution.coordinates, self.circuits, n, candidate.cycles, strict=True))
        separated = _Round(
            {name: circuit.direction * k for name, circuit, k, _ in rows},
            {name: circuit.limit_kind for name, circuit, _, _ in rows},
            {name: circuit.maslov for name, circuit, _, _ in rows},
            {name: interval(circuit, c.low, c.high) for name, circuit, _, c in rows if circuit.limit_kind != ROTATION},
        )  # fmt: skip
        near = self._ends_nearby(n, candidate)
        return self.search.level(self.frame, self._energy(torus), self.m, self.turns, separated, near)

    def _energy(self, torus: Torus) -> Estimate:
        """E, with what the digits of the actions leave open: Σ Ω J times their relative error."""
        digits = self.search.digits
        own = rounded(to_bits(self.frame.energy(torus))(bits_for(digits, 128)), digits)
        constants = list(self.frame.solution.constants)
        unknown = [j for j, name in enumerate(constants) if name not in self.frame.asked.constants]
        rates = torus.rates(unknown)
        actions = [place.coordinate_motion.action for place in torus.located.values()]
        spread = sum(abs(Ω * J) for Ω, J in zip(rates, actions, strict=True) if J is not None)
        more = float(spread) * EPS if digits <= FLOAT_DIGITS else spread * own.value.context.mpf(10) ** -digits
        return replace(own, error=own.error + more)

    def _ends_nearby(self, n: tuple[int, ...], found: Candidate) -> tuple[str, ...]:
        """Return the coordinates along which the family of a torus has none with J ± ħ, nor shrinks to a point."""
        hbar, names, near = self.search.hbar, self.frame.solution.coordinates, []
        J = [circuit.action(k, hbar) for circuit, k in zip(self.circuits, n, strict=True)]
        for k, (name, circuit) in enumerate(zip(names, self.circuits, strict=True)):
            beside = [
                (*J[:k], circuit.action(n[k] + step, hbar), *J[k + 1 :])
                for step in (1, -1)
                if n[k] + step >= circuit.first
            ]
            ends = n[k] == circuit.first and self.frame.has_barrier(found, k)
            if ends or not all(self._goes_on(found, actions) for actions in beside):
                near.append(name)
        return tuple(near)

    def _goes_on(self, found: Candidate, actions: tuple[sp.Expr, ...]) -> bool:
        shape, wells = self.frame.shape(found), self._wells(found)
        return any(
            self.frame.shape(other) == shape and overlapping(wells, self._wells(other))
            for other in self.frame.candidates(self.circuits, actions)
        )

    def _wells(self, found: Candidate) -> list[tuple[float, float]]:
        pairs = zip(self.circuits, found.cycles, strict=True)
        return [interval(circuit, c.low, c.high) for circuit, c in pairs if circuit.kind != ROTATION]
