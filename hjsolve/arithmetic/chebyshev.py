"""Chebyshev series on a panel, in any arithmetic that has operators: Σ cₖ Tₖ(x) for −1 ≤ x ≤ 1.

Clenshaw's recurrence bₖ = cₖ + 2x bₖ₊₁ − bₖ₊₂, Σ = c₀ + x b₁ − b₂ (Math. Tables Aids Comput. 9 (1955) 118). Rounding
is magnified by at most the square of the number of terms, and only next to x = ±1.
"""

from __future__ import annotations

from hjsolve.arithmetic.number_types import Elementwise


def in_panel(x: Elementwise, left: Elementwise, right: Elementwise) -> Elementwise:
    """Return the position of x in [left, right], from −1 to 1, without cancellation at either end."""
    return ((x - left) - (right - x)) / (right - left)


def clenshaw(row: Elementwise, x: Elementwise) -> Elementwise:
    """Return Σ cₖ Tₖ(x).

    Args:
        row: cₖ along the first axis, from k = 0 on.
        x: where; each cₖ has its shape, or none.
    """
    b1 = b2 = 0 * x
    for k in range(len(row) - 1, 0, -1):
        b1, b2 = 2 * x * b1 - b2 + row[k], b1
    return x * b1 - b2 + row[0]
