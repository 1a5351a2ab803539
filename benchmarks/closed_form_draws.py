"""Random motions of an entry, thousands at once, with what the engine of ensembles says of them.

Constants are those of random places and momenta over six decades. The first parameters are the default ones, then every
third set is drawn over six decades as well. A regime that is seldom met is drawn about motions of it (``Seeds``).
"""

from __future__ import annotations

from collections.abc import Mapping
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


_ABOUT = (-2.5, -0.3)
"""Decades that places and momenta are moved by about a motion that is known, by the logarithm: from 0.003 to 0.5."""
_KEPT = 64
"""Motions of a regime about which others are drawn."""


@dataclass(frozen=True)
class Seeds:
    """Motions of one regime with the same parameters, about which others are drawn.

    Attributes:
        parameters: name → value.
        places: coordinate → places.
        momenta: coordinate → momenta.
        at_rest: ignorable coordinates whose momentum is zero in the regime.
    """

    parameters: Mapping[str, float]
    places: Table
    momenta: Table
    at_rest: frozenset[str]

    @staticmethod
    def of(solution: Solution, columns: Table, table: Table, special: frozenset[str]) -> Seeds:
        """Return the first of some motions.

        Args:
            solution: what is solved.
            columns: of the motions, as ``motions_of`` returns them.
            table: parameters and constants of the motions.
            special: names of the constants that are zero.
        """
        names = [c.name for c in solution.system.coordinates]
        return Seeds(
            {p.name: float(table[p.name][0]) for p in solution.system.parameters},
            {n: columns[f"q.{n}"][:_KEPT] for n in names},
            {n: columns[f"p.{n}"][:_KEPT] for n in names},
            frozenset(n for n in names if f"p_{n}" in special),
        )

    def drawn(self, solution: Solution, dice: np.random.Generator, drawn: int) -> tuple[Table, Table]:
        """Return places and momenta about those of the seeds.

        Args:
            solution: what is solved.
            dice: random numbers.
            drawn: how many motions.
        """
        system = solution.system
        numbers = {p.symbol: sp.Float(self.parameters[p.name], 17) for p in system.parameters}
        which = dice.integers(0, len(next(iter(self.places.values()))), drawn)
        spread, places, momenta = 10 ** dice.uniform(*_ABOUT, drawn), Table(), Table()
        for c in system.coordinates:
            factor, q = 10 ** (spread * dice.normal(size=drawn)), self.places[c.name][which]
            low, high = ends_of(c, numbers)
            if c.domain.kind == "angle":
                q = np.remainder(q + spread * dice.normal(size=drawn) + np.pi, 2 * np.pi) - np.pi
            elif low is not None and high is not None:
                odds = factor * (q - low) / (high - q)
                q = low + (high - low) * odds / (1 + odds)
            else:
                end = low if low is not None else high if high is not None else 0.0
                q = end + (q - end) * factor
            places[c.name] = q
            p = self.momenta[c.name][which] * 10 ** (spread * dice.normal(size=drawn))
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


def motions_of(
    solution: Solution, dice: np.random.Generator, turn: int, drawn: int, about: Seeds | None = None
) -> tuple[Table, Table] | None:
    """Draw motions with one set of parameters.

    Args:
        solution: what is solved.
        dice: random numbers.
        turn: its number; the first has the default parameters.
        drawn: how many motions.
        about: motions of a regime that is wanted; None for any.

    Returns:
        The parameters, constants and separated coordinates; and the columns of the ensemble, with the momenta. None
        where the parameters are refused.
    """
    system = solution.system
    if about is None:
        values = {p.name: _parameter(p, dice, turn) for p in system.parameters}
        places, momenta = _anywhere(solution, dice, values, drawn)
    else:
        values = dict(about.parameters)
        places, momenta = about.drawn(solution, dice, drawn)
    try:
        batch = hjsolve.ensemble(
            solution, q=places, p=momenta, parameters=values, fallback=False,
            want={"constants", "actions", "frequencies", "periods", "turning_points"},
        )  # fmt: skip
    except hjsolve.HJSolveError as error:
        print(f"    parameters refused: {values}: {str(error)[:100]}")
        return None
    columns = {name: np.asarray(column) for name, column in batch.columns.items()}
    table = {name: np.full(drawn, value) for name, value in values.items()} | places
    refused = np.isin(columns["status"], [Status.FORBIDDEN, Status.OUTSIDE_DOMAIN, Status.NOT_FINITE])
    phase = table | {c.momentum.name: momenta[c.name] for c in system.coordinates}
    for constant in solution.constants.values():
        column, symbols = columns[f"constants.{constant.name}"], sorted(constant.expression.free_symbols, key=str)
        made = sp.lambdify(symbols, constant.expression, modules="numpy")
        with np.errstate(all="ignore"):  # those of motions that the engine hands back, by their formula
            own = np.broadcast_to(made(*(phase[s.name] for s in symbols)), (drawn,))
        known = np.where(refused, np.nan, np.where(np.isnan(column), own, column))
        table[constant.symbol.name] = np.where(abs(known) < _GREATEST, known, np.nan)
    return table, columns | {f"p.{name}": p for name, p in momenta.items()} | {f"q.{n}": q for n, q in places.items()}


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
    """Return the ends of the domain of a coordinate, None where it has none.

    Args:
        c: the coordinate.
        numbers: of the parameters.
    """
    low, high = (
        None if end is None else float(sp.N(end.xreplace(dict(numbers)))) for end in (c.domain.lower, c.domain.upper)
    )
    return low, high


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
