"""Walls that are answered by a sign: which coordinates may be turned round without any constant changing.

Where H(q, …, −pᵢ, …) = H(q, …, pᵢ, …) an elastic wall at qᵢ = const makes pᵢ into −pᵢ, and the motion after it is the
free motion run on another way: a coordinate with a clock of its own, (qᵢ, pᵢ) closed under Hamilton's equations, runs
backwards through the places it came from, and an ignorable one goes the other way at the same rate. No constant of the
motion is new, so no integral is: the billiard on the invariant torus (Kozlov & Treshchev, *Billiards*, §2.1).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve.mechanics.system import hamiltonian
from hjsolve.solution.quadratures import Solution


@dataclass(frozen=True)
class Mirrors:
    """What of a system may be turned round.

    Attributes:
        even: coordinates whose momentum may change its sign: H, all constants and all separated momenta are even in it.
        carrier: ignorable coordinate → the separated coordinate that alone sets its rate; None where it is constant.
    """

    even: frozenset[str]
    carrier: Mapping[str, str | None]


def mirrors(solution: Solution) -> Mirrors | None:
    """Find what may be turned round, by the formulas alone.

    Returns:
        None where a separated coordinate has no clock of its own, or an ignorable one is carried by several.
    """
    system, H = solution.system, hamiltonian(solution.system)
    if any(A != 0 for A in (*solution.shift.values(), solution.shift_potential)):
        return None
    separated = [system.coordinate(name) for name in solution.coordinates]
    pairs = {c.name: {c.symbol, c.momentum} for c in separated}
    places = {c.symbol for c in system.coordinates} | {c.momentum for c in separated}
    for c in separated:
        if (sp.diff(H, c.momentum).free_symbols | sp.diff(H, c.symbol).free_symbols) & places - pairs[c.name]:
            return None
    carrier: dict[str, str | None] = {}
    for c in system.coordinates:
        if c.name in pairs:
            continue
        told = sp.diff(H, c.momentum).free_symbols & places
        carriers = [name for name, pair in pairs.items() if told & pair]
        if len(carriers) > 1 or c.symbol in told:
            return None
        carrier[c.name] = carriers[0] if carriers else None
    even = frozenset(c.name for c in system.coordinates if _even(solution, H, c.momentum))
    return Mirrors(even, carrier)


def _even(solution: Solution, H: sp.Expr, p: sp.Symbol) -> bool:
    """Return whether H, every other constant and every separated momentum are even in a momentum."""
    constants = [c.expression for c in solution.constants.values() if c.expression != p]
    return all(_same(f, f.xreplace({p: -p})) for f in (H, *constants, *solution.momentum_squared.values()))


def _same(one: sp.Expr, other: sp.Expr) -> bool:
    return bool(one == other or sp.expand(one - other) == 0)
