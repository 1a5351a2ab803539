"""The zero test for an identity about a system: coordinates on their domain, parameters first at their defaults."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import sympy as sp

from hjsolve.algebra.signs import Bounds
from hjsolve.separation.zero_test.interval_evaluation import Region
from hjsolve.separation.zero_test.zero_test import Answer, free_region, is_zero


def vanishes(
    residual: sp.Expr,
    bounds: Mapping[sp.Symbol, Bounds],
    parameters: Iterable[sp.Symbol],
    defaults: Mapping[sp.Symbol, sp.Expr],
    budget: float,
) -> Answer:
    """Decide whether an expression vanishes identically where a system lives.

    Args:
        residual: in coordinates, momenta, constants and parameters.
        bounds: open interval of each coordinate.
        parameters: those that take their values before the coordinates, whose domains may end at them.
        defaults: values of parameters to try first.
        budget: seconds.
    """
    given = set(parameters)
    free = {symbol: ends for symbol, ends in free_region(residual).bounds.items() if symbol not in given}
    return is_zero(residual, Region({**free, **bounds}, defaults), budget=budget)
