"""Is this expression identically zero on the domain? Proved zero, proved not, or undecided: never a guess.

In this order, each step within the budget:

1. values modulo a prime at random points, a filter that takes about a millisecond (``algebra.modular``);
2. the exact normal form over the field of the expression (``algebra.field``): a numerator that reduces to zero is a
   proof;
3. a rational witness where interval arithmetic excludes zero: a proof of the opposite;
4. relations on the domain that the normal form does not know: half angles, roots of squares, logarithms of powers, sums
   of inverse functions, constants (``algebra.vanishing``), each proved;
5. otherwise ``Unproved``, with the value to 40 digits.

``simplify``, ``equals`` and float thresholds decide nothing here: they miss zeros, take minutes and guess (docs,
baselines).
"""

from __future__ import annotations

from dataclasses import dataclass

import mpmath
import sympy as sp

from hjsolve.algebra.modular import products_vanish
from hjsolve.algebra.poly import Budget, WorkLimitError
from hjsolve.algebra.reader import Reader
from hjsolve.algebra.vanishing import proved_zero
from hjsolve.separation.zero_test.interval_evaluation import Region, Witness, find_witness, value_to_40_digits

DEFAULT_SECONDS = 20.0


@dataclass(frozen=True)
class Zero:
    """Proved: the expression is zero wherever it is defined."""

    how: str = "exact normal form"


@dataclass(frozen=True)
class NonZero:
    """Proved: the expression is not identically zero.

    Attributes:
        witness: a rational point and an enclosure of the value that excludes zero.
    """

    witness: Witness


@dataclass(frozen=True)
class Unproved:
    """Neither was proved.

    Attributes:
        point: where the value was taken; empty when no value could be computed.
        value: the expression there to 40 digits, or None.
        reason: what stood in the way.
    """

    point: dict[str, sp.Rational]
    value: mpmath.mpf | None
    reason: str


Answer = Zero | NonZero | Unproved


def is_zero(expression: sp.Expr, region: Region | None = None, *, budget: Budget | float | None = None) -> Answer:
    """Decide whether an expression is identically zero on a region.

    Args:
        expression: real expression; undetermined functions f(r) and their derivatives count as independent.
        region: domain of the coordinates and first values for parameters; by default every symbol ranges over the reals
            its own assumptions allow.
        budget: seconds, or a ``Budget``; 20 s by default.

    Returns:
        ``Zero``, ``NonZero`` with a witness, or ``Unproved``.
    """
    if not isinstance(budget, Budget):
        budget = Budget.processor_seconds(DEFAULT_SECONDS) if budget is None else Budget.seconds(budget)
    region = region or free_region(expression)
    reason = "no witness was found"
    if not expression.free_symbols and (witness := find_witness(expression, region, budget)) is not None:
        return NonZero(witness)  # a constant is decided at once, and roots of numbers may take seconds to denest
    try:
        reader = Reader([expression], region.bounds, budget)
        terms = [reader.element(term) for term in sp.Add.make_args(expression)]
        if products_vanish(reader.field, [[x] for x in terms]) is not False and reader.field.total(terms).is_zero:
            return Zero()
    except (WorkLimitError, ZeroDivisionError) as fault:
        reason = str(fault)
    answer = not_zero(expression, region, budget, reason)
    if isinstance(answer, Unproved) and proved_zero(expression, region.bounds, budget):
        return Zero("relations on the domain")
    return answer


def not_zero(expression: sp.Expr, region: Region, budget: Budget, reason: str) -> NonZero | Unproved:
    """Return the second half of the test: a witness, or the value to 40 digits.

    Args:
        expression: what the first half did not prove to be zero.
        region: where the points are taken from.
        reason: why the first half gave no proof, for ``Unproved``.
    """
    witness = find_witness(expression, region, budget)
    if witness is not None:
        return NonZero(witness)
    at = value_to_40_digits(expression, region)
    return Unproved({}, None, reason) if at is None else Unproved(at[0], at[1], reason)


def free_region(expression: sp.Expr) -> Region:
    """Return every symbol over the reals that its own assumptions allow."""
    bounds = {}
    for s in expression.free_symbols:
        lower = sp.S.Zero if s.is_nonnegative else None
        upper = sp.S.Zero if s.is_nonpositive else None
        bounds[s] = (lower, upper)
    return Region(bounds)
