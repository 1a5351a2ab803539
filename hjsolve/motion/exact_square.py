"""What exact arithmetic tells of p² where numbers of any precision leave it open: zeros of high multiplicity.

A zero of multiplicity three or more cannot be distinguished from a zero and a pair close to it by any number of digits.
Where p² is a rational function of q with rational coefficients, its square-free factorisation decides (Yun 1976).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve.motion.exact_numbers import InBits, expanded, number_is_zero, to_bits


@dataclass(frozen=True)
class ExactZeros:
    """Zeros of p², decided exactly; see ``one_coordinate.coordinate_start.ExactSquare``.

    Attributes:
        squared: p² as a formula.
        variable: the symbol of q.
        values: symbol → exact number, of all other symbols.
        place: q at the start, exact.
    """

    squared: sp.Expr
    variable: sp.Symbol
    values: Mapping[sp.Symbol, sp.Expr]
    place: sp.Expr

    def order_at_start(self) -> int:
        """Return the order of the zero of p² at the initial place, 0 of none; 3 for all from 3 on."""
        slope = self.squared
        for order in range(3):
            value = expanded(slope.xreplace({**self.values, self.variable: self.place}))
            if value.has(sp.nan, sp.zoo, sp.oo) or not number_is_zero(value):
                return order
            slope = sp.diff(slope, self.variable)
        return 3

    def multiple_zeros(self) -> list[InBits]:
        """Return the zeros of p² proved to be triple or higher; none where p² is not a rational function."""
        number = expanded(self.squared.xreplace(dict(self.values)))
        if not number.is_rational_function(self.variable):
            return []
        above = sp.fraction(sp.together(number))[0]
        polynomial = sp.Poly(above, self.variable)
        if not all(c.is_Rational for c in polynomial.coeffs()):
            return []
        factors = [factor for factor, multiplicity in polynomial.sqf_list()[1] if multiplicity >= 3]
        return [to_bits(root) for factor in factors for root in sp.real_roots(factor)]
