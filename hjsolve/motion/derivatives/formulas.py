"""p²(q; κ, λ) of one separated coordinate with its derivatives by q, by the constants κ and by the parameters λ.

The derivatives are taken of the formula itself, and all of them are one tape: common parts are computed once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import sympy as sp

from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.tape import BoundTape, Tape
from hjsolve.lowering import lower, with_plain_exponents
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.initial_data import Initial
from hjsolve.solution.quadratures import Solution

HIGHEST = 4
"""Derivatives of p² by q that the second derivatives of an action take at a place of rest."""


@dataclass(frozen=True)
class VariedSymbols:
    """What is varied.

    Attributes:
        constants: names of the constants of the motion, all of them.
        parameters: names of the parameters; none where they are not varied.
        symbols: of the constants, then of the parameters.
    """

    constants: tuple[str, ...]
    parameters: tuple[str, ...]
    symbols: tuple[sp.Symbol, ...]

    @property
    def count(self) -> int:
        """How many they are."""
        return len(self.symbols)


class AtPlace(NamedTuple):
    """F = p² and its derivatives at one place; ``b`` runs over the variables and ``j`` over the constants.

    Attributes:
        value, slope, bend: F, F_q and F_qq.
        by: F_b.
        slope_by: F_qb.
        mixed: F_jb, one row a constant.
    """

    value: Mpf
    slope: Mpf
    bend: Mpf
    by: list[Mpf]
    slope_by: list[Mpf]
    mixed: list[list[Mpf]]


@dataclass(frozen=True, eq=False)
class SquareDerivatives:
    """The derivatives of p² of one coordinate, ready to be evaluated.

    Attributes:
        squared: F.
        q: symbol of the coordinate.
        variables: what is varied.
        arguments: symbol → exact number, of constants and parameters.
        exponents: the same of parameters that are exponents.
    """

    squared: sp.Expr
    q: sp.Symbol
    variables: VariedSymbols
    arguments: tuple[tuple[sp.Symbol, sp.Expr], ...]
    exponents: tuple[tuple[sp.Symbol, sp.Expr], ...] = ()

    def bound(self, bits: int) -> Evaluation:
        """Return the rule for places, in so many bits."""
        tape = _second_order(self.squared, self.q, self.variables, self._symbols, self.exponents)
        return Evaluation(tape.bind(Multi(bits), self.numbers(bits)), len(self.variables.constants), bits)

    def numbers(self, bits: int) -> list[Mpf]:
        """Return constants and parameters.

        Args:
            bits: binary digits of each.
        """
        return [to_bits(value)(bits) for _, value in self.arguments]

    def expansions(self, q: Mpf, bits: int) -> list[list[Mpf]]:
        """Return the derivatives by q of F (orders 0 to 4), of each F_b (0 to 2) and of each F_jb (0) at a place."""
        tape = _high_order(self.squared, self.q, self.variables, self._symbols, self.exponents)
        values = tape.run(Multi(bits), [q, *self.numbers(bits)])
        rows, position = [values[: HIGHEST + 1]], HIGHEST + 1
        for _ in range(self.variables.count):
            rows.append(values[position : position + 3])
            position += 3
        return [*rows, values[position:]]

    @property
    def _symbols(self) -> tuple[sp.Symbol, ...]:
        return tuple(symbol for symbol, _ in self.arguments)


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The derivatives of p² with all but the place known.

    Attributes:
        tape: with the place free.
        constants: how many there are.
        bits: of the arithmetic.
    """

    tape: BoundTape[Mpf]
    constants: int
    bits: int

    def at(self, q: Mpf) -> AtPlace:
        """Return F and its derivatives."""
        values = self.tape.run(q)
        rest, n = values[3:], self.constants
        count = len(rest) // (n + 2)
        # F_b, F_qb and F_jb one after the other, each with as many numbers as there are variables
        rows = [rest[k * count : (k + 1) * count] for k in range(n + 2)]
        return AtPlace(values[0], values[1], values[2], rows[0], rows[1], rows[2:])


def variables_of(solution: Solution, *, parameters: bool) -> VariedSymbols:
    """Return what is varied: the constants of the motion, and the parameters where they are asked for.

    Args:
        parameters: whether these are varied.
    """
    constants = tuple(solution.constants)
    names = tuple(p.name for p in solution.system.parameters) if parameters else ()
    symbols = [solution.constants[name].symbol for name in constants]
    symbols += [p.symbol for p in solution.system.parameters] if parameters else []
    return VariedSymbols(constants, names, tuple(symbols))


def formulas_of(solution: Solution, initial: Initial, name: str, variables: VariedSymbols) -> SquareDerivatives:
    """Return the derivatives of p² of one separated coordinate."""
    arguments = [(solution.constants[c].symbol, initial.constants[c]) for c in solution.constants]
    arguments += [(p.symbol, initial.values[p.symbol]) for p in solution.system.parameters]
    F, symbol = solution.momentum_squared[name], solution.system.coordinate(name).symbol
    # x^k with k a number needs no logarithm: exponents are put in after the derivatives by them are taken
    powers: set[sp.Symbol] = set().union(*(power.exp.free_symbols for power in F.atoms(sp.Pow)))
    exponents = tuple((s, value) for s, value in arguments if s in powers)
    return SquareDerivatives(F, symbol, variables, tuple(arguments), exponents)


Known = tuple[tuple[sp.Symbol, sp.Expr], ...]


@lru_cache(maxsize=256)
def _second_order(
    F: sp.Expr, q: sp.Symbol, variables: VariedSymbols, symbols: tuple[sp.Symbol, ...], exponents: Known
) -> Tape:
    z, n = variables.symbols, len(variables.constants)
    by = [sp.diff(F, b) for b in z]
    outputs = [F, sp.diff(F, q), sp.diff(F, q, 2), *by, *(sp.diff(f, q) for f in by)]
    outputs += [sp.diff(by[j], b) for j in range(n) for b in z]
    return lower([_plain(e, exponents) for e in outputs], [q, *symbols])


@lru_cache(maxsize=64)
def _high_order(
    F: sp.Expr, q: sp.Symbol, variables: VariedSymbols, symbols: tuple[sp.Symbol, ...], exponents: Known
) -> Tape:
    z, n = variables.symbols, len(variables.constants)
    by = [sp.diff(F, b) for b in z]
    outputs = [sp.diff(F, q, k) if k else F for k in range(HIGHEST + 1)]
    # next to a turning point F_b/F′ is a quotient of series: two orders of F_b go with four of F
    outputs += [sp.diff(f, q, k) if k else f for f in by for k in range(3)]
    outputs += [sp.diff(by[j], b) for j in range(n) for b in z]
    return lower([_plain(e, exponents) for e in outputs], [q, *symbols])


def _plain(e: sp.Expr, exponents: Known) -> sp.Expr:
    """Return a formula with numbers for exponents, and without sign functions: |x| is analytic on each side."""
    e = with_plain_exponents(e, dict(exponents)) if exponents else e
    return e.replace(sp.sign, lambda x: sp.Abs(x) / x) if e.has(sp.sign) else e
