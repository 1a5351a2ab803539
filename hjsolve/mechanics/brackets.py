"""Poisson brackets, with the sign of Greenwood (6-212)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp

from hjsolve.mechanics.coordinates_and_parameters import Coordinate

Pairs = Sequence[tuple[sp.Symbol, sp.Symbol]]


def conjugate_pairs(coordinates: Iterable[Coordinate]) -> list[tuple[sp.Symbol, sp.Symbol]]:
    """Return the symbols (q, p) of every coordinate."""
    return [(c.symbol, c.momentum) for c in coordinates]


def bracket(u: sp.Expr, v: sp.Expr, pairs: Pairs) -> sp.Expr:
    """Return (u, v) = Σ ∂u/∂q ∂v/∂p − ∂u/∂p ∂v/∂q, Greenwood (6-212).

    Args:
        u, v: functions of coordinates, momenta and parameters.
        pairs: the symbols (q, p) of every coordinate.
    """
    return sp.Add(*(u.diff(q) * v.diff(p) - u.diff(p) * v.diff(q) for q, p in pairs))
