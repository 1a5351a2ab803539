"""Random motions of an entry, thousands at once, with what the engine of ensembles says of them.

Constants are those of random places and momenta over six decades. The first parameters are the default ones, then every
third set is drawn over six decades as well. Two sets of three are drawn about motions of the regime that fewest are
known of (``Seeds``). Motions are told apart by their constants, and the engine integrates those that are wanted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

import hjsolve
from hjsolve import Status
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.solution.quadratures import Solution

Reals = NDArray[np.float64]
Table = dict[str, Reals]
"""Name of a symbol → its value at every motion."""

DECADES = 3.0
"""Decades to either side of 1 that momenta and parameters are drawn from; places from half as many."""
_GREATEST = 1e75
"""A constant beyond it is not drawn (V = e^{ax} with ax = 700): its fourth power, in a discriminant, is no double."""
_IGNORED = 0.02
"""Of the motions, those with p_θ = 0."""


_ABOUT = (-2.5, 0.0)
"""Decades that places and momenta are moved by about a motion that is known, by the logarithm: from 0.003 to 1."""
_KEPT = 64
"""Motions of a regime about which others are drawn: a random choice of all that were met."""
_TRIES = 100
"""Draws of parameters until all domains have real ends: a horizon is there for every second set or so."""
_REVERSED = 0.1
"""Of the motions about others, those that have an ignorable momentum of the other sign."""


@dataclass(frozen=True)
class Seeds:
    """Motions of one regime, about which others are drawn.

    A regime that random motions meet once in thousands is met at every second motion about a known one, as it is open.
    Motions that are found become seeds in their turn, with parameters that were moved too: what is drawn wanders
    through the regime, and does not stay where it was met first. Steps of 0.003 decades find a narrow regime again,
    those of a decade cross a wide one. Every set of
    motions of the whole box is followed by two of this kind.

    Attributes:
        parameters: of the sets with motions of the regime, name → value.
        places: coordinate → places.
        momenta: coordinate → momenta.
        at_rest: ignorable coordinates whose momentum is zero in the regime.
    """

    parameters: tuple[Mapping[str, float], ...]
    places: Table
    momenta: Table
    at_rest: frozenset[str]

    @staticmethod
    def of(solution: Solution, columns: Table, table: Table, special: frozenset[str]) -> Seeds:
        """Return motions as seeds.

        Args:
            solution: what is solved.
            columns: of the motions, as ``followed`` returns them.
            table: parameters and constants of the motions.
            special: names of the constants that are zero.
        """
        names = [c.name for c in solution.system.coordinates]
        return Seeds(
            ({p.name: float(table[p.name][0]) for p in solution.system.parameters},),
            {n: columns[f"q.{n}"] for n in names},
            {n: columns[f"p.{n}"] for n in names},
            frozenset(n for n in names if f"p_{n}" in special),
        )

    def joined(self, others: Seeds | None, dice: np.random.Generator) -> Seeds:
        """Return a random choice of these and other seeds, half of each where there are enough.

        Args:
            others: of the same regime, None where there are none yet.
            dice: random numbers.
        """
        half = _KEPT if others is None else _KEPT // 2
        parts = [self, *([] if others is None else [others])]
        which = [dice.permutation(len(next(iter(part.places.values()))))[:half] for part in parts]

        def both(tables: Sequence[Table]) -> Table:
            return {n: np.concatenate([t[n][k] for t, k in zip(tables, which, strict=True)]) for n in tables[0]}

        sets = [*{tuple(values.items()): values for part in parts for values in part.parameters}.values()]
        kept = [sets[k] for k in dice.permutation(len(sets))[:_KEPT]]
        return Seeds(tuple(kept), both([s.places for s in parts]), both([s.momenta for s in parts]), self.at_rest)

    def parameters_about(self, solution: Solution, dice: np.random.Generator) -> dict[str, float]:
        """Return parameters about those of a set with motions of the regime.

        Args:
            solution: what is solved.
            dice: random numbers.
        """
        known, spread = self.parameters[dice.integers(0, len(self.parameters))], 10 ** dice.uniform(*_ABOUT)
        moved = {p.name for p in solution.system.parameters if p.assume != "integer"}
        return {n: v * 10 ** (spread * dice.normal()) if n in moved else v for n, v in known.items()}

    def drawn(
        self, solution: Solution, dice: np.random.Generator, values: Mapping[str, float], drawn: int
    ) -> tuple[Table, Table]:  # fmt: skip
        """Return places and momenta about those of the seeds.

        Args:
            solution: what is solved.
            dice: random numbers.
            values: of the parameters.
            drawn: how many motions.
        """
        system = solution.system
        numbers = {p.symbol: sp.Float(values[p.name], 17) for p in system.parameters}
        which = dice.integers(0, len(next(iter(self.places.values()))), drawn)
        spread, places, momenta = 10 ** dice.uniform(*_ABOUT, drawn), Table(), Table()
        for c in system.coordinates:
            factor, q = 10 ** (spread * dice.normal(size=drawn)), self.places[c.name][which]
            low, high = ends_of(c, numbers)
            if c.domain.kind == "angle":
                q = np.remainder(q + spread * dice.normal(size=drawn) + np.pi, 2 * np.pi) - np.pi
            elif low is not None and high is not None:
                part = np.clip((q - low) / (high - low), 1e-6, 1 - 1e-6)  # the ends are others for other parameters
                odds = factor * part / (1 - part)
                q = low + (high - low) * odds / (1 + odds)
            elif low is not None or high is not None:
                end, away = (low, 1.0) if low is not None else (high or 0.0, -1.0)
                q = end + away * np.fmax(away * (q - end), 1e-6) * factor
            else:
                q = q * factor
            places[c.name] = q
            p = self.momenta[c.name][which] * 10 ** (spread * dice.normal(size=drawn))
            if c.name not in solution.coordinates:
                p = p * np.where(dice.random(drawn) < _REVERSED, -1.0, 1.0)
            momenta[c.name] = np.zeros(drawn) if c.name in self.at_rest else p
        return places, momenta


def ignorable(solution: Solution) -> list[str]:
    """Return the coordinates that do not occur in H.

    Args:
        solution: what is solved.
    """
    return [c.name for c in solution.system.coordinates if c.name not in solution.coordinates]


def constants_of(solution: Solution) -> list[sp.Symbol]:
    """Return the symbols of E, the separation constants and the ignorable momenta.

    Args:
        solution: what is solved.
    """
    return [c.symbol for c in solution.constants.values()]


def exact(value: float) -> sp.Rational:
    """Return the rational number that a double is.

    Args:
        value: the double.
    """
    part = Fraction(float(value))
    return sp.Rational(part.numerator, part.denominator)


class Draws:
    """Random motions of a solution: first their constants, by the formulas, and what the engine says of those wanted.

    Args:
        solution: what is solved.
    """

    def __init__(self, solution: Solution):
        self.solution = solution
        self.constants = dict[str, tuple[list[str], Any]]()
        for constant in solution.constants.values():
            symbols = sorted(constant.expression.free_symbols, key=str)
            made = sp.lambdify(symbols, constant.expression, modules="numpy")
            self.constants[constant.symbol.name] = [s.name for s in symbols], made

    def parameters(self, dice: np.random.Generator, turn: int, about: Seeds | None) -> dict[str, float]:
        """Draw the parameters of one set.

        Args:
            dice: random numbers.
            turn: the set's number; the first has the default parameters.
            about: motions of a regime that is wanted; None for any.
        """
        parameters = self.solution.system.parameters
        for _ in range(_TRIES):
            if about is not None:
                values = about.parameters_about(self.solution, dice)
            else:
                values = {p.name: _parameter(p, dice, turn) for p in parameters}
            numbers = {p.symbol: sp.Float(values[p.name], 17) for p in parameters}
            ends = [ends_of(c, numbers) for c in self.solution.system.coordinates]
            if not any(np.isnan(end) for pair in ends for end in pair if end is not None):
                return values  # outside a horizon, and there is one
        raise ValueError(f"no parameters with real ends of the domain in {_TRIES} draws")

    def motions(
        self, dice: np.random.Generator, values: Mapping[str, float], drawn: int, about: Seeds | None
    ) -> tuple[Table, Table]:  # fmt: skip
        """Draw motions with one set of parameters.

        Args:
            dice: random numbers.
            values: of the parameters.
            drawn: how many motions.
            about: motions of a regime that is wanted; None for any.

        Returns:
            The parameters, places and constants, nan where these are no doubles; and the momenta.
        """
        pick = _anywhere if about is None else about.drawn
        places, momenta = pick(self.solution, dice, values, drawn)
        table = {name: np.full(drawn, value) for name, value in values.items()} | places
        return table | self._by_formula(table, momenta), momenta

    def _by_formula(self, table: Table, momenta: Table) -> Table:
        phase = table | {c.momentum.name: momenta[c.name] for c in self.solution.system.coordinates}
        found = Table()
        with np.errstate(all="ignore"):
            for name, (needed, made) in self.constants.items():
                value = np.broadcast_to(made(*(phase[n] for n in needed)), np.shape(next(iter(momenta.values()))))
                found[name] = np.where(abs(value) < _GREATEST, value, np.nan)
        return found

    def followed(self, values: Mapping[str, float], table: Table, momenta: Table) -> tuple[Table, Table] | None:
        """Let the engine of ensembles integrate motions.

        Args:
            values: of the parameters.
            table: of the motions, as ``motions`` returns it.
            momenta: likewise.

        Returns:
            The table with the engine's constants, nan where it refuses a motion; and the columns of the ensemble, with
            places and momenta. None where the parameters are refused.
        """
        names = [c.name for c in self.solution.system.coordinates]
        places = {n: table[n] for n in names}
        try:
            batch = hjsolve.ensemble(
                self.solution, q=places, p=momenta, parameters=dict(values), fallback=False,
                want={"constants", "actions", "frequencies", "periods", "turning_points"},
            )  # fmt: skip
        except hjsolve.HJSolveError as error:
            print(f"    parameters refused: {values}: {str(error)[:100]}")
            return None
        columns = {name: np.asarray(column) for name, column in batch.columns.items()}
        refused = np.isin(columns["status"], [Status.FORBIDDEN, Status.OUTSIDE_DOMAIN, Status.NOT_FINITE])
        engine = Table()
        for constant in self.solution.constants.values():
            column, own = columns[f"constants.{constant.name}"], table[constant.symbol.name]
            # those of motions that the engine hands back, by their formula
            known = np.where(refused, np.nan, np.where(np.isnan(column), own, column))
            engine[constant.symbol.name] = np.where(abs(known) < _GREATEST, known, np.nan)
        return table | engine, columns | {f"p.{n}": p for n, p in momenta.items()} | {
            f"q.{n}": places[n] for n in names
        }


def _anywhere(
    solution: Solution, dice: np.random.Generator, values: Mapping[str, float], drawn: int
) -> tuple[Table, Table]:
    system = solution.system
    numbers = {p.symbol: sp.Float(values[p.name], 17) for p in system.parameters}
    places = {c.name: _places(c, numbers, dice, drawn) for c in system.coordinates}
    ignored = dice.random(drawn) < _IGNORED  # at rest in what is ignorable: p_θ = 0
    momenta = Table()
    for c in system.coordinates:
        p = 10 ** dice.uniform(-DECADES, DECADES / 2, drawn)
        momenta[c.name] = (
            p if c.name in solution.coordinates else np.where(ignored, 0.0, p * dice.choice((-1, 1), drawn))
        )
    return places, momenta


def _parameter(parameter: Any, dice: np.random.Generator, turn: int) -> float:
    default = 1.0 if parameter.value is None else float(parameter.value)
    if parameter.assume == "integer" or (turn == 0 and parameter.value is not None):
        return default
    size = 10 ** dice.uniform(-DECADES, DECADES) if turn % 3 == 2 else dice.uniform(0.25, 2)
    if parameter.value is None and parameter.assume == "negative":
        return -size
    return float((default or 1.0) * size)


def ends_of(c: Coordinate, numbers: Mapping[sp.Symbol, sp.Expr]) -> tuple[float | None, float | None]:
    """Return the ends of the domain of a coordinate, None where it has none, nan where they are not real.

    Args:
        c: the coordinate.
        numbers: of the parameters.
    """
    low, high = (None if end is None else sp.N(end.xreplace(dict(numbers))) for end in (c.domain.lower, c.domain.upper))
    return tuple(None if end is None else float(end) if end.is_real else np.nan for end in (low, high))  # type: ignore[return-value]


def _places(c: Coordinate, numbers: Mapping[sp.Symbol, sp.Expr], dice: np.random.Generator, drawn: int) -> Reals:
    size, part = 10 ** dice.uniform(-DECADES / 2, DECADES / 2, drawn), dice.uniform(0.01, 0.99, drawn)
    if c.domain.kind == "angle":
        return np.pi * (2 * part - 1)
    low, high = ends_of(c, numbers)
    if low is not None and high is not None:
        return low + (high - low) * part
    if low is None and high is None:
        return size * dice.choice((-1, 1), drawn)
    return low + size if low is not None else (high or 0.0) - size
