"""A formula that is too wide for a page, in parts: sums inside it get letters u₁, u₂ …, defined below it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator

import sympy as sp

_MOST_PARTS, _FEWEST, _MOST = 30, 3, 60
"""Of letters; and of operations in what one stands for."""
Parts = list[tuple[sp.Symbol, sp.Expr]]


def in_parts(
    formula: sp.Basic, fits: Callable[[sp.Basic], bool], letters: Iterator[sp.Symbol], known: dict[sp.Expr, sp.Symbol]
) -> tuple[sp.Basic, Parts] | None:  # fmt: skip
    """Give letters to sums until a formula fits, and until what the letters stand for fits.

    Args:
        formula: an expression or an equation.
        fits: whether one can be set.
        letters: to be used.
        known: sum → letter that it has; gets more.

    Returns:
        The formula in letters, and each letter with its meaning, in the order of their use; None where there are too
        many.
    """
    parts: Parts = []
    waiting: list[sp.Basic] = [formula]
    done: list[sp.Basic] = []
    while waiting:
        e = waiting.pop(0)
        while not fits(e):
            sum_ = _widest_sum(e)
            if sum_ is None or len(parts) >= _MOST_PARTS:
                return None
            if sum_ not in known:
                known[sum_] = next(letters)
                parts.append((known[sum_], sum_))
                waiting.append(sum_)
            e = e.xreplace({sum_: known[sum_]})
        done.append(e)
    first, *rest = done
    return first, [(letter, e) for (letter, _), e in zip(parts, rest, strict=True)]


def _widest_sum(e: sp.Basic) -> sp.Expr | None:
    """Return the sum inside a formula that saves most."""
    outer = set(e.args) | {e} if isinstance(e, sp.Eq) else {e}
    found = Counter(p for p in sp.preorder_traversal(e) if p.is_Add and p not in outer)
    sizes = {p: sp.count_ops(p) for p in found}
    good = [(found[p] * n, n, sp.srepr(p), p) for p, n in sizes.items() if _FEWEST <= n <= _MOST]
    return max(good)[-1] if good else None
