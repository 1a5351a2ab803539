"""The walk over the tree of an expression, from the leaves up, in any kind of values.

Rooms without numpy evaluate formulas so: in intervals, which prove, to 80 digits, and in bounds on algebraic numbers.
Each of these says what a leaf, a sum, a product, a power and a function is; where numpy is, formulas are tapes
(``hjsolve.lowering``).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Generic, TypeVar

import sympy as sp

V = TypeVar("V")
"""The kind of values."""


class TreeWalk(ABC, Generic[V]):
    """One evaluation: remembers the values of shared subexpressions."""

    def __init__(self) -> None:
        self.seen: dict[sp.Expr, V] = {}

    def __call__(self, x: sp.Expr) -> V:
        """Return the value of an expression."""
        if x not in self.seen:
            self.seen[x] = self._value(x)
        return self.seen[x]

    def _value(self, x: sp.Expr) -> V:
        if (known := self.leaf(x)) is not None:
            return known
        if x.is_Add or x.is_Mul:
            return (self.total if x.is_Add else self.product)(map(self, x.args))
        return self.power(x) if x.is_Pow else self.function(x)

    @abstractmethod
    def leaf(self, x: sp.Expr) -> V | None:
        """Return the value of what has no parts, or is not to be taken apart; None for anything else."""

    @abstractmethod
    def total(self, parts: Iterable[V]) -> V:
        """Return the sum of one or more values."""

    @abstractmethod
    def product(self, parts: Iterable[V]) -> V:
        """Return the product of one or more values."""

    @abstractmethod
    def power(self, x: sp.Expr) -> V:
        """Return the value of a power."""

    @abstractmethod
    def function(self, x: sp.Expr) -> V:
        """Return the value of a function, or of anything else that has parts."""
