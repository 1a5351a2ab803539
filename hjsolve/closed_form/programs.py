"""A form as a list of steps that any arithmetic runs: with bounds on its rounding in doubles, or in two doubles.

The steps are those of a ``Tape``, written by the same writer. A tape has functions of one number alone; forms have
cases, angles of points and elliptic functions besides.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from operator import and_, invert, or_
from typing import Any, Protocol

import sympy as sp
from sympy.core.relational import Relational

from hjsolve.arithmetic.number_types import Mask
from hjsolve.arithmetic.tape import Arithmetic, Operation, applied
from hjsolve.errors import InvalidInputError
from hjsolve.lowering import TapeWriter

_ELLIPTIC = frozenset({
    "CarlsonRF", "CarlsonRC", "CarlsonRD", "CarlsonRJ", "CarlsonRCRe", "CarlsonRCIm", "CarlsonRJRe", "CarlsonRJIm",
    "JacobiAM", "JacobiSN", "JacobiCN", "JacobiDN", "JacobiEpsilon",
    "elliptic_k", "elliptic_f", "elliptic_e", "elliptic_pi",
})  # fmt: skip
_BY_SQUARE_ROOTS = 4, 8
"""Denominators of powers that are square roots of square roots: |a|^(1/4) of small oscillations."""
_MASKS: Mapping[str, Callable[..., Any]] = {"And": and_, "Or": or_, "Not": invert}
_OF_FORMS = frozenset({"atan2", "sign", "positive", "either"})
"""Steps that are methods of an arithmetic of forms."""


class ArithmeticOfForms(Arithmetic[Any], Protocol):
    """What forms need beside what tapes do."""

    def atan2(self, y: Any, x: Any) -> Any:
        """Return the angle of a point.

        Args:
            y, x: its coordinates.
        """
        ...

    def sign(self, x: Any) -> Any:
        """Return 1, 0 or −1.

        Args:
            x: a number.
        """
        ...

    def positive(self, x: Any) -> Mask:
        """Return where a number is positive.

        Args:
            x: the number.
        """
        ...

    def either(self, condition: Mask, x: Any, y: Any) -> Any:
        """Return x where a condition holds, else y.

        Args:
            condition: which of both.
            x, y: the numbers.
        """
        ...

    def elliptic(self, name: str, *arguments: Any) -> Any:
        """Return an elliptic function.

        Args:
            name: of sympy's class.
            arguments: of the function.
        """
        ...


class Program:
    """A form, and the definitions it rests on, each different part once.

    Args:
        expression: the form.
        definitions: symbol → its definition, each after those that it uses.
        inputs: symbols whose numbers are given.

    Raises:
        InvalidInputError: a function without a rule.
    """

    def __init__(self, expression: sp.Expr, definitions: Mapping[sp.Symbol, sp.Expr], inputs: Sequence[sp.Symbol]):
        writer = _FormWriter(tuple(inputs))
        for symbol, meaning in definitions.items():
            writer.known[symbol] = writer.slot(meaning)
        self._output, self._steps = writer.slot(expression), writer.operations

    def run(self, arithmetic: ArithmeticOfForms, numbers: Sequence[Any]) -> Any:
        """Return the form.

        Args:
            arithmetic: of the numbers.
            numbers: of the inputs, in order.
        """
        slots = [*numbers]
        for step in self._steps:
            slots.append(_done(arithmetic, step, slots))
        return slots[self._output]


class _FormWriter(TapeWriter):
    """Writes what forms have besides: cases, angles of points, signs and elliptic functions."""

    def _write(self, e: sp.Expr) -> int:
        if isinstance(e, sp.Piecewise):
            return self._cases(e)
        if isinstance(e, sp.cot):
            return self._emit("div", (self.slot(sp.cos(e.args[0])), self.slot(sp.sin(e.args[0]))))
        name = type(e).__name__
        if name in _OF_FORMS or name in _ELLIPTIC:
            return self._emit(name, tuple(map(self.slot, e.args)))
        return super()._write(e)

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> int:
        if not exponent.is_Rational or exponent.q not in _BY_SQUARE_ROOTS:
            return super()._power(base, exponent)
        # exp(¼ log a) has an error that grows with log a, and no number at a = 0
        root = self._emit("sqrt", (self.slot(base ** sp.Rational(2, exponent.q)),))
        return root if exponent.p == 1 else self._emit("power", (root,), (int(exponent.p),))

    def _cases(self, e: sp.Piecewise) -> int:
        (value, condition), *others = reversed(e.args)
        slot = self.slot(value)
        if condition != True:  # noqa: E712  (sympy's truth)
            slot = self._emit("either", (self._condition(condition), slot, self.slot(sp.S.Zero)))
        for value, condition in others:
            slot = self._emit("either", (self._condition(condition), self.slot(value), slot))
        return slot

    def _condition(self, c: sp.Basic) -> int:
        if isinstance(c, sp.And | sp.Or | sp.Not):
            return self._emit(type(c).__name__, tuple(map(self._condition, c.args)))
        if isinstance(c, Relational) and not isinstance(c, sp.Eq | sp.Ne):
            more = self._emit("sub", (self.slot(c.gts), self.slot(c.lts)))
            if isinstance(c, sp.StrictGreaterThan | sp.StrictLessThan):
                return self._emit("positive", (more,))
            # x ≥ y is that y − x is not positive: so equal numbers hold
            return self._emit("Not", (self._emit("positive", (self._emit("neg", (more,)),)),))
        raise InvalidInputError(f"two doubles do not decide {c}")


def _done(arithmetic: ArithmeticOfForms, step: Operation, slots: Sequence[Any]) -> Any:
    values = [slots[k] for k in step.operands]
    if step.code in _ELLIPTIC:
        return arithmetic.elliptic(step.code, *values)
    if step.code in _OF_FORMS:
        return getattr(arithmetic, step.code)(*values)
    if step.code in _MASKS:
        return reduce(_MASKS[step.code], values) if len(values) > 1 else _MASKS[step.code](*values)
    return applied(arithmetic, step, slots)
