"""Signs of expressions in the constants at a sample of a regime: each sign that a form rests on becomes a condition."""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import sympy as sp

from hjsolve.closed_form.evaluation import evaluator, magnitude, many_digits, number_of
from hjsolve.precision import mp

DIGITS = 60
"""Of constants at a sample: 40 for what is left after cancellation, and 20 more."""
_NOTHING = mp.mpf(10) ** -40
"""Of the terms of an expression, what is left of them where they cancel: constants have 60 digits, named roots 50."""


class Signs:
    """Signs at a sample, with a record of those that decided something.

    Args:
        values: symbol → exact value, of every parameter and constant.
        place: the x of the sample, on the piece of the x-axis that the motion is on.
    """

    def __init__(self, values: Mapping[sp.Symbol, sp.Expr], place: mpmath.mpf):
        self.values, self.place = dict(values), place
        self.numbers = many_digits(values, DIGITS)
        self.decided: dict[sp.Expr, int] = {}
        self.named = set[sp.Symbol]()

    def number(self, expression: sp.Expr) -> mpmath.mpf:
        """Return the value of an expression at the sample.

        Args:
            expression: of parameters and constants.
        """
        with mp.workdps(DIGITS):
            return number_of(expression, self.numbers)

    def agree(self, conditions: Mapping[sp.Expr, int]) -> bool:
        """Return whether expressions have given signs at the sample.

        Args:
            conditions: expression → its sign.
        """
        return all(self.there(expression) == sign for expression, sign in conditions.items())

    def there(self, expression: sp.Expr) -> int:
        """Return the sign at the sample, and do not keep it; 0 of what is not real.

        Args:
            expression: of parameters and constants.
        """
        with mp.workdps(DIGITS):
            value, size = evaluator(expression, magnitude(expression)).at(self.numbers)
            if isinstance(value, mp.mpc) or mp.isnan(value) or abs(value) <= size * _NOTHING:
                return 0
            return 1 if value > 0 else -1

    def sign(self, expression: sp.Expr) -> int:
        """Return the sign at the sample; kept as a condition where the symbols do not imply it.

        Args:
            expression: of parameters and constants.
        """
        if expression.is_zero or expression == 0:
            return 0
        known = 1 if expression.is_positive else -1 if expression.is_negative else None
        if known is not None:
            return known
        found = self.there(expression)
        # the order of named roots is a condition already: a sign that holds them says no more
        if found and not expression.free_symbols & self.named:
            self.decided[sp.factor_terms(expression)] = found
        return found

    def name(self, numbers: Mapping[sp.Symbol, sp.Expr]) -> None:
        """Learn the values of named roots; signs of what holds them follow from the order of the roots.

        Args:
            numbers: symbol → value.
        """
        self.values |= numbers
        self.numbers |= many_digits(numbers, DIGITS)
        self.named |= set(numbers)

    def slope_sign(self, A: sp.Expr, B: sp.Expr, place: sp.Expr | None) -> int:
        """Return the sign of 2Au + B at the sample, u = x or 1/(x − r).

        Args:
            A, B: coefficients.
            place: r; None where u = x.
        """
        with mp.workdps(DIGITS):
            u = self.place if place is None else 1 / (self.place - self.number(place))
            return 1 if 2 * self.number(A) * u + self.number(B) > 0 else -1
