"""What numbers and source code need of the closed forms of a regime."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import sympy as sp

from hjsolve.closed_form.regime import Regime
from hjsolve.closed_form.why_not import WhyNot
from hjsolve.solution.quadratures import Solution


class NamedForms(Protocol):
    """Forms by name, and the regime in which they hold; ``forms.RegimeForms`` is one."""

    @property
    def solution(self) -> Solution:
        """What they are forms of."""

    @property
    def regime(self) -> Regime:
        """For which constants they hold."""

    @property
    def where(self) -> Mapping[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]:
        """Symbol → its definition: an expression, or (polynomial, index of the real root)."""

    @property
    def why_not(self) -> Mapping[str, WhyNot]:
        """Quantity → why there is no form of it."""

    def named(self) -> dict[str, sp.Expr]:
        """Every form that is a function, by name."""
