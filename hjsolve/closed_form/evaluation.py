"""Values of formulas in mpmath's numbers: every part once, what does not vary once for all places, slopes by rules.

The elliptic functions of long forms occur many times, and several integrals of a coordinate share them. A formula
becomes a list of lines, one for each different part, evaluated in order; derivatives are more lines of the same list.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache

import mpmath
import sympy as sp

from hjsolve.errors import of_kind
from hjsolve.functions.printing import Printable
from hjsolve.functions.tables import own_modules
from hjsolve.precision import mp

GUARD = 20
"""Digits beyond those asked of a constant."""
Rule = Callable[..., mpmath.mpf]
Line = tuple[Rule, tuple[int, ...]]


class Evaluator:
    """Formulas made ready for numbers.

    Args:
        expressions: the formulas.
        slopes: by which symbol each is differentiated as well; None for no derivatives.
    """

    def __init__(self, expressions: Sequence[sp.Expr], slopes: sp.Symbol | None = None):
        self.lines: list[Line] = []
        self.symbols: dict[int, sp.Symbol] = {}
        self._known: dict[sp.Expr, int] = {}
        self._slopes: dict[sp.Expr, int | None] = {}
        self._inlined: dict[sp.Expr, dict[sp.Expr, int]] = {}
        self.outputs = [self._line(e) for e in map(sp.sympify, expressions)]
        if slopes is not None:
            found = [self._slope(e, slopes) for e in map(sp.sympify, expressions)]
            self.outputs += [self._line(sp.S.Zero) if k is None else k for k in found]

    def at(self, numbers: Mapping[sp.Symbol, mpmath.mpf]) -> list[mpmath.mpf]:
        """Return the values, in mpmath's present precision; nan where a part is infinite or has no value.

        Args:
            numbers: symbol → number, of every symbol.
        """
        return self.along(numbers, None)(mp.mpf(0))

    def along(
        self, numbers: Mapping[sp.Symbol, mpmath.mpf], free: sp.Symbol | None
    ) -> Callable[[mpmath.mpf], list[mpmath.mpf]]:  # fmt: skip
        """Return the values as a function of one symbol; parts free of it are worked out now, in the present precision.

        Args:
            numbers: symbol → number, of the other symbols.
            free: the symbol that varies; None for none.
        """
        slots: list[mpmath.mpf] = [mp.nan] * len(self.lines)
        varying, moving = set[int](), list[tuple[int, Rule, tuple[int, ...]]]()
        for place, (rule, operands) in enumerate(self.lines):
            if (symbol := self.symbols.get(place)) is not None:
                if symbol == free:
                    varying.add(place)
                else:
                    slots[place] = mp.mpmathify(numbers[symbol])
            # constant along the path: K, E and the roots of moduli are worked out once for hundreds of nodes
            elif varying.isdisjoint(operands):
                slots[place] = _applied(rule, [slots[k] for k in operands])
            else:
                varying.add(place)
                moving.append((place, rule, operands))
        starts = [place for place, symbol in self.symbols.items() if symbol == free]

        def values(there: mpmath.mpf) -> list[mpmath.mpf]:
            own = [*slots]
            for place in starts:
                own[place] = there
            for place, rule, operands in moving:
                own[place] = _applied(rule, [own[k] for k in operands])
            return [own[k] for k in self.outputs]

        return values

    def _emit(self, rule: Rule, *operands: int) -> int:
        self.lines.append((rule, operands))
        return len(self.lines) - 1

    def _line(self, e: sp.Expr) -> int:
        if e not in self._known:
            self._known[e] = self._write(e)
        return self._known[e]

    def _write(self, e: sp.Expr, line: Callable[[sp.Expr], int] | None = None) -> int:
        line = self._line if line is None else line
        if e.is_Symbol:
            place = self._emit(_nothing)
            self.symbols[place] = e
            return place
        if e.is_Add or e.is_Mul:
            return self._emit(_sum if e.is_Add else _product, *map(line, e.args))
        if e.is_Pow:
            return self._power(e.base, e.exp, line)
        if not e.args:
            return self._emit(_constant(e))
        return self._emit(_function(e.func), *map(line, e.args))

    def _power(self, base: sp.Expr, exponent: sp.Expr, line: Callable[[sp.Expr], int]) -> int:
        if base is sp.E:
            return self._emit(mp.exp, line(exponent))
        if exponent.is_Integer:
            return self._emit(_integer_power(int(exponent)), line(base))
        if exponent.is_Rational and exponent.q == 2:
            # √ and a whole power: mp.power goes through exp and log
            root = self._emit(mp.sqrt, line(base))
            return root if exponent.p == 1 else self._emit(_integer_power(int(exponent.p)), root)
        return self._emit(mp.power, line(base), line(exponent))

    def _partial_line(self, e: sp.Expr, k: int) -> int:
        """∂e/∂(argument k), of Carlson's functions by a rule in names: sympy would order their long arguments."""
        if not isinstance(e, Printable) or len(set(e.args)) != len(e.args):
            return self._line(_partial(e, k))
        names, function, slopes = _slopes_in_names(e.func, len(e.args))
        if e not in self._inlined:
            self._inlined[e] = dict(zip(names, map(self._line, e.args), strict=True)) | {function: self._line(e)}
        known = self._inlined[e]

        def line(part: sp.Expr) -> int:
            if part not in known:
                known[part] = self._write(part, line)
            return known[part]

        return line(slopes[k])

    def _slope(self, e: sp.Expr, q: sp.Symbol) -> int | None:
        if e not in self._slopes:
            self._slopes[e] = self._differentiated(e, q)
        return self._slopes[e]

    def _differentiated(self, e: sp.Expr, q: sp.Symbol) -> int | None:
        """Return the line of ∂e/∂q; None where e does not hold q."""
        # forward derivatives: each part has a line for its slope, and parts free of q have none
        if e == q:
            return self._line(sp.S.One)
        parts = [(k, slope) for k, a in enumerate(e.args) if (slope := self._slope(a, q)) is not None]
        if not parts:
            return None
        if e.is_Add:
            return self._emit(_sum, *(slope for _, slope in parts))
        terms = []
        for k, slope in parts:
            if e.is_Mul:
                terms.append(self._emit(_product, slope, *(self._line(a) for j, a in enumerate(e.args) if j != k)))
            elif e.is_Pow:
                # ∂(bᵃ) = a bᵃ⁻¹ ∂b + bᵃ ln b ∂a
                by = e.exp * e.base ** (e.exp - 1) if k == 0 else e * sp.log(e.base)
                terms.append(self._emit(_product, slope, self._line(by)))
            else:
                terms.append(self._emit(_product, slope, self._partial_line(e, k)))
        return terms[0] if len(terms) == 1 else self._emit(_sum, *terms)


def number_of(expression: sp.Expr, numbers: Mapping[sp.Symbol, mpmath.mpf]) -> mpmath.mpf:
    """One formula at numbers, in mpmath's present precision.

    Args:
        expression: of parameters and constants.
        numbers: symbol → number, of every symbol.
    """
    return evaluator(expression).at(numbers)[0]


@lru_cache(maxsize=4096)
def magnitude(e: sp.Expr) -> sp.Expr:
    """Return the sum of the moduli of an expression's terms, by which its rounding errors are measured.

    A number is zero, or not, by what cancels in it, and in no unit: E − V₀ of 1e-60 is zero where both are 1, and E
    alone is not, however small. With n digits a sum is off by 10⁻ⁿ Σ|terms|, a product by its factors' parts (Higham,
    Accuracy and Stability of Numerical Algorithms, 2002, section 3.1).

    Args:
        e: of parameters and constants.
    """
    if e.is_Add or e.is_Mul:
        return e.func(*map(magnitude, e.args))
    if e.is_Pow and e.exp.is_Rational and e.exp.is_positive:
        return magnitude(e.base) ** e.exp
    if e.is_number:
        return abs(e)
    # unevaluated: sympy would look for the sign of every long part
    return e if e.is_Symbol and e.is_positive else sp.Abs(e, evaluate=False)


@lru_cache(maxsize=2048)
def evaluator(*expressions: sp.Expr) -> Evaluator:
    """Return formulas made ready for numbers, kept for the next time."""
    return Evaluator(expressions)


def many_digits(values: Mapping[sp.Symbol, sp.Expr], digits: int) -> dict[sp.Symbol, mpmath.mpf]:
    """Exact values as numbers with so many digits, and some to spare.

    Args:
        values: symbol → sympy number.
        digits: of each.
    """
    with mp.workdps(digits + GUARD):
        return {symbol: _constant(value)() for symbol, value in values.items()}


def _partial(e: sp.Expr, k: int) -> sp.Expr:
    return e.diff(e.args[0]) if not isinstance(e, sp.Function) else e.fdiff(k + 1)


@lru_cache(maxsize=32)
def _slopes_in_names(
    function: type[sp.Function], count: int
) -> tuple[tuple[sp.Symbol, ...], sp.Expr, tuple[sp.Expr, ...]]:  # fmt: skip
    """Return the names for the arguments of a function, the function of them, and its derivatives by each."""
    names = tuple(sp.Dummy(f"a{k}", real=True) for k in range(count))
    value = function(*names)
    return names, value, tuple(sp.diff(value, name) for name in names)


def _applied(rule: Rule, operands: list[mpmath.mpf]) -> mpmath.mpf:
    if any(isinstance(x, mp.mpc) and not mp.isfinite(x) for x in operands):
        return mp.nan  # of which mpmath's arc functions raise a TypeError
    try:
        # poles and what mpmath has no number for are nan: a case of the form that is not taken may have them
        return rule(*operands)
    except (ZeroDivisionError, ValueError):
        return mp.nan


def _nothing() -> mpmath.mpf:
    return mp.nan


def _sum(*terms: mpmath.mpf) -> mpmath.mpf:
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


def _product(*factors: mpmath.mpf) -> mpmath.mpf:
    value = factors[0]
    for factor in factors[1:]:
        value = value * factor
    return value


@lru_cache(maxsize=64)
def _integer_power(n: int) -> Rule:
    def power(x: mpmath.mpf) -> mpmath.mpf:
        return x**n

    return power


def _constant(e: sp.Expr) -> Rule:
    """Return a constant in the precision that is asked then."""
    if e.is_Rational:
        # exact until the precision is known: a float would fix it at 53 bits
        part = Fraction(int(e.p), int(e.q))
        return lambda: mp.mpf(part.numerator) / part.denominator
    if e.is_Float:
        return lambda: mp.make_mpf(e._mpf_)
    if e in (sp.oo, -sp.oo, sp.zoo, sp.nan):
        return lambda: mp.inf if e is sp.oo else -mp.inf if e is -sp.oo else mp.nan
    return lambda: mp.mpmathify(sp.N(e, mp.dps + 5))


@lru_cache(maxsize=256)
def _function(function: type[sp.Function]) -> Rule:
    """Return the function of mpmath's numbers."""
    table = of_kind(own_modules()[0], dict)
    name = function.__name__
    if name in table:
        return table[name]
    arguments = sp.symbols(f"a:{1 if not function.nargs else max(function.nargs)}")
    return sp.lambdify(arguments, function(*arguments), modules=own_modules())
