"""A form as a list of steps that any arithmetic runs: with bounds on its rounding in doubles, or in two doubles.

A ``Tape`` has functions of one number alone; forms have cases, angles of points and elliptic functions besides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any, Protocol

import sympy as sp
from sympy.core.relational import Relational
from sympy.logic.boolalg import BooleanFalse, BooleanTrue

from hjsolve.arithmetic.number_types import Mask
from hjsolve.arithmetic.tape import UNARY, Arithmetic
from hjsolve.errors import InvalidInputError

_UNARY = {
    getattr(sp, name.capitalize() if name == "abs" else name): name for name in UNARY if name not in {"neg", "sqrt"}
}
_ELLIPTIC = frozenset({
    "CarlsonRF", "CarlsonRC", "CarlsonRD", "CarlsonRJ", "CarlsonRCRe", "CarlsonRCIm", "CarlsonRJRe", "CarlsonRJIm",
    "JacobiAM", "JacobiSN", "JacobiCN", "JacobiDN", "JacobiEpsilon",
    "elliptic_k", "elliptic_f", "elliptic_e", "elliptic_pi",
})  # fmt: skip
_MOST_HALVINGS = 4
"""Square roots of square roots that a power is made of: |a|^(1/4) of small oscillations."""


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


@dataclass(frozen=True)
class _Step:
    code: str
    operands: tuple[int, ...] = ()
    payload: Any = None


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
        self.inputs = tuple(inputs)
        self._known: dict[sp.Basic, int] = {s: k for k, s in enumerate(self.inputs)}
        self._steps = list[_Step]()
        for symbol, meaning in definitions.items():
            self._known[symbol] = self._slot(meaning)
        self._output = self._slot(expression)

    def run(self, arithmetic: ArithmeticOfForms, numbers: Sequence[Any]) -> Any:
        """Return the form.

        Args:
            arithmetic: of the numbers.
            numbers: of the inputs, in order.
        """
        slots = [*numbers]
        for step in self._steps:
            slots.append(_RULES.get(step.code, _plain)(arithmetic, step, [slots[k] for k in step.operands]))
        return slots[self._output]

    def _slot(self, e: sp.Basic) -> int:
        if e not in self._known:
            self._known[e] = self._written(e)
        return self._known[e]

    def _emit(self, code: str, operands: Sequence[int] = (), payload: Any = None) -> int:
        self._steps.append(_Step(code, tuple(operands), payload))
        return len(self.inputs) + len(self._steps) - 1

    def _written(self, e: sp.Basic) -> int:
        if e.is_Rational:
            return self._emit("rational", (), (int(e.p), int(e.q)))
        if e is sp.pi:
            return self._emit("pi")
        if isinstance(e, sp.Add):
            return self._sum(e)
        if isinstance(e, sp.Mul):
            return self._product(e)
        if isinstance(e, sp.exp) or e is sp.E:
            return self._emit("exp", [self._slot(e.exp)])
        if isinstance(e, sp.Pow):
            return self._power(e.base, e.exp)
        if isinstance(e, sp.Piecewise):
            return self._cases(e)
        return self._function(e)

    def _function(self, e: sp.Basic) -> int:
        if e.func in _UNARY:
            return self._emit(_UNARY[e.func], [self._slot(e.args[0])])
        if isinstance(e, sp.cot):
            return self._emit("div", [self._slot(sp.cos(e.args[0])), self._slot(sp.sin(e.args[0]))])
        if isinstance(e, sp.atan2 | sp.sign):
            return self._emit(type(e).__name__, [self._slot(a) for a in e.args])
        if type(e).__name__ in _ELLIPTIC:
            return self._emit("elliptic", [self._slot(a) for a in e.args], type(e).__name__)
        raise InvalidInputError(f"{type(e).__name__} has no rule in two doubles")

    def _sum(self, e: sp.Add) -> int:
        total: int | None = None
        for term in sorted(e.args, key=lambda t: bool(t.could_extract_minus_sign())):
            less = term.could_extract_minus_sign()
            own = self._slot(-term if less else term)
            if total is None:
                total = self._emit("neg", [own]) if less else own
            else:
                total = self._emit("sub" if less else "add", [total, own])
        return self._slot(sp.S.Zero) if total is None else total

    def _product(self, e: sp.Mul) -> int:
        if e.args[0] is sp.S.NegativeOne:
            return self._emit("neg", [self._slot(sp.Mul(*e.args[1:], evaluate=False))])
        above, below = list[int](), list[int]()
        for factor in e.args:
            if factor.is_Rational and factor.q != 1:
                above += [self._slot(sp.Integer(factor.p))] if factor.p != 1 else []
                below.append(self._slot(sp.Integer(factor.q)))
            elif isinstance(factor, sp.Pow) and factor.exp.is_Rational and factor.exp < 0:
                below.append(self._slot(sp.Pow(factor.base, -factor.exp, evaluate=False)))
            else:
                above.append(self._slot(factor))
        top = reduce(lambda x, y: self._emit("mul", [x, y]), above) if above else self._slot(sp.S.One)
        return self._emit("div", [top, reduce(lambda x, y: self._emit("mul", [x, y]), below)]) if below else top

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> int:
        if exponent == 1:
            return self._slot(base)
        if exponent.is_Rational and exponent < 0:
            return self._emit("div", [self._slot(sp.S.One), self._power(base, -exponent)])
        halvings = exponent.q.bit_length() - 1 if exponent.is_Rational else _MOST_HALVINGS
        if halvings < _MOST_HALVINGS and exponent.q == 2**halvings:
            slot = self._slot(base)
            for _ in range(halvings):
                slot = self._emit("sqrt", [slot])
            return slot if exponent.p == 1 else self._emit("power", [slot], int(exponent.p))
        logarithm = self._emit("log", [self._slot(base)])
        return self._emit("exp", [self._emit("mul", [self._slot(exponent), logarithm])])

    def _cases(self, e: sp.Piecewise) -> int:
        (value, condition), *others = reversed(e.args)
        slot = self._slot(value)
        if condition != True:  # noqa: E712  (sympy's truth)
            slot = self._emit("either", [self._condition(condition), slot, self._slot(sp.S.Zero)])
        for value, condition in others:
            slot = self._emit("either", [self._condition(condition), self._slot(value), slot])
        return slot

    def _condition(self, c: sp.Basic) -> int:
        if isinstance(c, BooleanTrue | BooleanFalse):
            return self._emit("truth", (), bool(c))
        if isinstance(c, sp.And | sp.Or | sp.Not):
            return self._emit(type(c).__name__, [self._condition(a) for a in c.args])
        if isinstance(c, Relational) and not isinstance(c, sp.Eq | sp.Ne):
            more = self._emit("sub", [self._slot(c.gts), self._slot(c.lts)])
            if isinstance(c, sp.StrictGreaterThan | sp.StrictLessThan):
                return self._emit("positive", [more])
            return self._emit("Not", [self._emit("positive", [self._emit("neg", [more])])])
        raise InvalidInputError(f"two doubles do not decide {c}")


def _plain(a: ArithmeticOfForms, step: _Step, values: Sequence[Any]) -> Any:
    return a.unary(step.code, *values)


_RULES = {
    "rational": lambda a, step, _: a.rational(*step.payload),
    "pi": lambda a, _step, _: a.pi(),
    "power": lambda a, step, v: a.power(v[0], step.payload),
    "elliptic": lambda a, step, v: a.elliptic(step.payload, *v),
    "truth": lambda _a, step, _: step.payload,
    "And": lambda _a, _step, v: reduce(lambda x, y: x & y, v),
    "Or": lambda _a, _step, v: reduce(lambda x, y: x | y, v),
    "Not": lambda _a, _step, v: ~v[0],
    **{
        name: lambda a, step, v: getattr(a, step.code)(*v)
        for name in ("add", "sub", "mul", "div", "atan2", "sign", "positive", "either")
    },
}
"""Code of a step → what it does, of those that are no function of one number."""
