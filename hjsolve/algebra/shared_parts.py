"""Expressions as the parts they share: derivatives of a potential hold the same few hundred parts thousands of times.

What is looked for, differentiated or worked out in numbers is looked for, differentiated, worked out once in each part.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from itertools import combinations_with_replacement, count

import sympy as sp
from sympy.core.function import AppliedUndef


def parts(expressions: Iterable[sp.Basic]) -> list[sp.Basic]:
    """Return every part of some expressions once, a whole before its parts, in the order they are first met.

    Args:
        expressions: those to take apart.
    """
    seen: dict[sp.Basic, None] = {}
    stack = list(expressions)[::-1]
    while stack:
        node = stack.pop()
        if node not in seen:
            seen[node] = None
            stack.extend(node.args[::-1])
    return list(seen)


@lru_cache(maxsize=16384)
def holds(e: sp.Basic, symbols: tuple[sp.Symbol, ...]) -> bool:
    """Return whether an expression depends on one of some symbols; asked of the same parts again and again."""
    if e.is_Add or e.is_Mul or e.is_Pow or isinstance(e, sp.Function):
        return any(holds(a, symbols) for a in e.args)
    return not e.free_symbols.isdisjoint(symbols)


@lru_cache(maxsize=8)
def derivatives(V: sp.Expr, x: tuple[sp.Symbol, ...]) -> tuple[sp.Expr, ...]:
    """Return the first and second derivatives of V, in the order of the slots.

    Args:
        V: potential V(x).
        x: Cartesian coordinates, two or three.
    """
    slope, done = {q: slope_by(q) for q in x}, _each_part_once(_rebuilt)
    first = [done(slope[q](V)) for q in x]
    second = [done(slope[x[b]](first[a])) for a, b in combinations_with_replacement(range(len(x)), 2)]
    return (*first, *second)


_OfParts = Callable[[sp.Expr, Callable[[sp.Expr], sp.Expr]], sp.Expr]


def _each_part_once(rule: _OfParts) -> Callable[[sp.Expr], sp.Expr]:
    """Return a function of expressions given by a rule that may ask for its own values at their parts."""
    known: dict[sp.Expr, sp.Expr] = {}

    def value(e: sp.Expr) -> sp.Expr:
        if e not in known:
            known[e] = rule(e, value)
        return known[e]

    return value


def slope_by(q: sp.Symbol) -> Callable[[sp.Expr], sp.Expr]:
    """Return ∂/∂q, by the rules of sympy's own ``diff``; it remembers every part that it has met.

    Args:
        q: what is differentiated by.
    """

    def rule(e: sp.Expr, slope: Callable[[sp.Expr], sp.Expr]) -> sp.Expr:
        if not _is_composed(e):
            return sp.diff(e, q)
        inner = [slope(a) for a in e.args]
        if not any(inner):
            return sp.S.Zero
        if e.is_Add:
            return sp.Add(*inner)
        if e.is_Mul:
            return sp.Add(*(sp.Mul(*e.args[:k], d, *e.args[k + 1 :]) for k, d in enumerate(inner) if d))
        if e.is_Pow:
            return e * (inner[1] * sp.log(e.base) + inner[0] * e.exp / e.base)
        return e.fdiff() * inner[0]

    return _each_part_once(rule)


def _rebuilt(e: sp.Expr, done: Callable[[sp.Expr], sp.Expr]) -> sp.Expr:
    """Return what sympy's ``doit`` makes of an expression."""
    return e.func(*map(done, e.args)) if _is_composed(e) else e.doit()


def _is_composed(e: sp.Expr) -> bool:
    """Whether an expression is a sum, product, power or function of its parts, known to be differentiated by parts."""
    if e.is_Add or e.is_Mul or e.is_Pow:
        return bool(e.is_commutative)
    if not isinstance(e, sp.Function) or isinstance(e, AppliedUndef) or len(e.args) != 1:
        return False
    own = type(e)
    return own._eval_derivative is sp.Function._eval_derivative and own.doit is sp.Function.doit


def common_parts(expressions: Sequence[sp.Expr]) -> tuple[list[tuple[sp.Symbol, sp.Expr]], list[sp.Expr]]:
    """Give a name to every part that occurs more than once; the names, those they need before them, and what is left.

    For numbers, as the ``cse`` of ``sympy.lambdify``: nothing is looked for but parts that are equal as they stand.
    """
    every = parts(expressions)
    uses = Counter(a for node in every for a in node.args)
    taken = {node.name for node in every if isinstance(node, sp.Symbol)}
    names = (sp.Symbol(name) for k in count() if (name := f"part_{k}") not in taken)
    written: dict[sp.Basic, sp.Basic] = {}
    named: list[tuple[sp.Symbol, sp.Expr]] = []

    def write(node: sp.Basic) -> sp.Basic:
        if not node.args or isinstance(node, sp.Rational):
            return node
        if node not in written:
            new = node.func(*map(write, node.args))
            if uses[node] > 1 and isinstance(node, sp.Expr):
                symbol = next(names)
                named.append((symbol, new))
                new = symbol
            written[node] = new
        return written[node]

    left = [write(e) for e in expressions]
    return named, left
