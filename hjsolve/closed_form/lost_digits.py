"""Where a form loses digits in doubles: it is worked out again in two doubles, from its constants and roots on.

What doubles may be off by says what two doubles may be off by, too: where that is too much, nobody but many digits is
left, one element at a time. Kepler's problem in prolate coordinates with E = −1e−72: all 32 digits are lost.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce

import numpy as np
import sympy as sp

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.arithmetic.running_error import WithErrorBound
from hjsolve.closed_form.doubles import RootsOfPolynomial, Solved
from hjsolve.closed_form.programs import Program
from hjsolve.closed_form.regions import Where
from hjsolve.closed_form.two_arithmetics import DoublesWithBounds, PairsOfForms
from hjsolve.errors import InvalidInputError

_FEW = 32
"""Units of the last place, by the bound, up to which a form is as good in doubles."""
_FINER = 2.0**-47
"""Of what is lost in doubles, what is lost in two: an operation is off by 2⁻¹⁰⁰ there, here by 2⁻⁵³."""
_NEWTON_STEPS = 3
"""Of Newton's rule to a root in two doubles: the double next to it is known, and each step doubles the digits."""
_PAIRS = DoubleDouble()


class FormInTwoDoubles:
    """A form that can be worked out in two doubles.

    Args:
        expression: the form, as it is arranged for doubles.
        where: what it rests on, in order.
        symbols: of the arguments.
        roots: polynomial → its roots for arrays.

    Raises:
        InvalidInputError: a function or a root without numbers in two doubles.
    """

    def __init__(
        self, expression: sp.Expr, where: Where, symbols: Sequence[sp.Symbol],
        roots: Callable[[sp.Poly], RootsOfPolynomial | None],
    ):  # fmt: skip
        self._symbols, self._roots = list(symbols), dict[sp.Symbol, tuple[RootsOfPolynomial, int]]()
        for symbol, meaning in where.items():
            if isinstance(meaning, tuple):
                found = roots(meaning[0])
                if found is None or not meaning[0].free_symbols_in_domain <= set(symbols):
                    raise InvalidInputError(f"{symbol} has no number in two doubles")
                self._roots[symbol] = found, meaning[1]
        defined = {s: e for s, e in where.items() if not isinstance(e, tuple)}
        self._program = Program(expression, defined, [*self._symbols, *self._roots])

    def error(self, table: Mapping[sp.Symbol, Reals], shape: tuple[int, ...], solved: Solved) -> Reals:
        """Return how far the form may be off in doubles, to first order.

        Args:
            table: symbol → its values, in arrays of one shape.
            shape: of the arrays.
            solved: roots that were found for these arrays.
        """
        numbers = [WithErrorBound(table[s]) for s in self._symbols]
        for roots, index in self._roots.values():
            found, _ = roots.once(table, shape, solved)
            size = abs(found.roots[index])
            # the form in doubles is given the root as a double, however well it is known
            numbers.append(WithErrorBound(found.roots[index], np.fmax(found.errors[index], EPS * size)))
        error = self._program.run(DoublesWithBounds(), numbers).error
        return np.broadcast_to(0.0 if error is None else error, shape)

    def again(self, table: Mapping[sp.Symbol, Reals], shape: tuple[int, ...], solved: Solved) -> Reals:
        """Return the form by two doubles, rounded to one; nan where these have no number.

        Args:
            table: symbol → its values, in arrays of one shape.
            shape: of the arrays.
            solved: roots that were found for these arrays.
        """
        zero = np.zeros(shape)
        numbers = [Pair(table[s] + zero, zero) for s in self._symbols]
        for roots, index in self._roots.values():
            found, _ = roots.once(table, shape, solved)
            numbers.append(_root(roots, table, found.roots[index]))
        value = self._program.run(PairsOfForms(), numbers)
        return np.broadcast_to(value.high + value.low, shape)


def lost(values: Reals, error: Reals) -> Mask:
    """Return where numbers may be off by more than a few units of the last place.

    Args:
        values: of a form.
        error: how far they may be off.
    """
    return np.isfinite(values) & ~(error <= _FEW * EPS * abs(values))


def lost_in_two_doubles(values: Reals, error: Reals) -> Mask:
    """Return the same for numbers made in two doubles.

    Args:
        values: of a form.
        error: how far they may be off in doubles.
    """
    return ~np.isfinite(values) | lost(values, _FINER * error)


def _root(roots: RootsOfPolynomial, table: Mapping[sp.Symbol, Reals], near: Reals) -> Pair:
    """Return a root in two doubles, by Newton's rule from the double next to it."""
    coefficients = [value for value, _ in roots.coefficients(table, near.shape)]
    degree = len(coefficients) - 1
    slopes = [_PAIRS.mul(c, _PAIRS.rational(degree - k, 1)) for k, c in enumerate(coefficients[:-1])]
    x = Pair(near, np.zeros(near.shape))
    for _ in range(_NEWTON_STEPS):
        value, slope = (
            reduce(lambda total, c: _PAIRS.add(_PAIRS.mul(total, x), c), row) for row in (coefficients, slopes)
        )
        x = _PAIRS.sub(x, _PAIRS.div(value, slope))
    return x
