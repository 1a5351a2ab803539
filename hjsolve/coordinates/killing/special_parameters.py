"""Values of the parameters at which d(K·dV) = 0 has more solutions than for general ones.

The rank can only drop where a pivot of the elimination vanishes, so the irreducible factors of the pivots are tried
one after the other: the factor is solved for one parameter, put into V and the kernel computed again, and so on for
the factors found there (the integrable cases of the Hénon–Heiles family need two conditions at once).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from hjsolve.algebra.time_limit import SearchTimeError
from hjsolve.coordinates.killing.killing_tensors import Kernel, kernel

_MOST_TRIES = {2: 36, 3: 24}


@dataclass(frozen=True)
class Exceptional:
    """More quadratic integrals than in general.

    Attributes:
        conditions: parameter → value or expression in the other parameters.
        dimension: dimension of the kernel there.
    """

    conditions: tuple[tuple[sp.Symbol, sp.Expr], ...]
    dimension: int


def exceptional_values(
    V: sp.Expr, x: Sequence[sp.Symbol], tensors: Sequence[sp.ImmutableMatrix], general: Kernel, *, depth: int = 2
) -> tuple[tuple[Exceptional, ...], bool]:
    """Find parameter values with a larger kernel, at most ``depth`` conditions deep and within a fixed number of tries.

    Args:
        V: potential V(x), with parameters.
        x: Cartesian coordinates, two or three.
        tensors: K of which linear combinations are sought, shape (n, n) each.
        general: the kernel for generic parameters.
        depth: most conditions at once.

    Returns:
        The values found, the fewest conditions first; a set of conditions that only repeats what a part of it gives is
        left out. The list need not be all; and whether the time sufficed to look at all that were to be tried.
    """
    found: dict[frozenset[tuple[sp.Symbol, sp.Expr]], int] = {}
    level: list[tuple[tuple[tuple[sp.Symbol, sp.Expr], ...], Kernel, sp.Expr]] = [((), general, V)]
    tried: set[frozenset[tuple[sp.Symbol, sp.Expr]]] = set()
    for _ in range(depth):
        following = []
        for conditions, there, potential in level:
            for symbol, value in _solutions(there.pivots):
                new = tuple((s, e.subs(symbol, value)) for s, e in conditions) + ((symbol, value),)
                if frozenset(new) in tried or len(tried) >= _MOST_TRIES[len(x)] or not _allowed(new):
                    continue
                tried.add(frozenset(new))
                special = potential.subs(symbol, value)
                if not special.free_symbols & set(x) or special.has(sp.zoo, sp.nan, sp.oo):
                    continue
                try:
                    result = kernel(special, x, tensors, check=False)
                except SearchTimeError:
                    return _ordered(found), False
                following.append((new, result, special))
                if result.dimension > _inherited(new, found, general.dimension):
                    found[frozenset(new)] = result.dimension
        level = following
    return _ordered(found), True


def _ordered(found: dict[frozenset[tuple[sp.Symbol, sp.Expr]], int]) -> tuple[Exceptional, ...]:
    ordered = sorted(found.items(), key=lambda item: (len(item[0]), str(sorted(item[0], key=str))))
    return tuple(Exceptional(tuple(sorted(c, key=str)), d) for c, d in ordered)


def _inherited(
    conditions: tuple[tuple[sp.Symbol, sp.Expr], ...],
    found: dict[frozenset[tuple[sp.Symbol, sp.Expr]], int],
    general: int,
) -> int:
    """Return the largest dimension that a part of the conditions already gives."""
    parts = [d for c, d in found.items() if all(sp.expand(s - e).subs(dict(conditions)).expand() == 0 for s, e in c)]
    return max([general, *parts])


def _allowed(conditions: tuple[tuple[sp.Symbol, sp.Expr], ...]) -> bool:
    """Tell whether the values respect what is assumed of the parameters."""
    return all(sp.Eq(symbol, value) is not sp.false and _same_sign(symbol, value) for symbol, value in conditions)


def _same_sign(symbol: sp.Symbol, value: sp.Expr) -> bool:
    if value.is_real is False:
        return False
    clash = (symbol.is_positive and value.is_nonpositive) or (symbol.is_negative and value.is_nonnegative)
    return not (clash or (symbol.is_nonzero and value.is_zero) or (symbol.is_nonnegative and value.is_negative))


def _solutions(factors: Sequence[sp.Expr]) -> list[tuple[sp.Symbol, sp.Expr]]:
    """Solve every factor for one of its parameters, where it is of degree one or two in it."""
    answers: list[tuple[sp.Symbol, sp.Expr]] = []
    for factor in factors:
        symbols = sorted(factor.free_symbols, key=str)
        if any(not isinstance(s, sp.Symbol) for s in symbols):
            continue
        linear = [s for s in symbols if sp.degree(factor, s) == 1 and not sp.Poly(factor, s).LC().free_symbols]
        if linear:
            chosen = linear[-1] if len(linear) == len(symbols) else linear[0]
            slope, rest = sp.Poly(factor, chosen).all_coeffs()
            answers.append((chosen, sp.expand(-rest / slope)))
        elif len(symbols) == 1 and sp.degree(factor, symbols[0]) == 2:
            answers.extend((symbols[0], root) for root in sp.solve(factor, symbols[0]) if root.is_real)
    return answers
