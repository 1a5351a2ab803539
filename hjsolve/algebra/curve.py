"""A parameter in which functions of one variable are algebraic: x itself, tan(w/2) of an angle, or an exponential."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd

import sympy as sp

from hjsolve.algebra.constants import NotAlgebraicError
from hjsolve.algebra.signs import Bounds

MAX_MULTIPLE = 24
MAX_TURNS = 6
Ends = tuple[sp.Expr | None, sp.Expr | None]
_CIRCULAR, _RISING = (sp.sin, sp.cos), (sp.exp, sp.sinh, sp.cosh, sp.tanh, sp.coth, sp.sech, sp.csch)


@dataclass(frozen=True)
class AlgebraicCurve:
    """The variable as a function of the parameter t.

    Attributes:
        kind: ``plain`` (t = x), ``circular`` (t = tan(w/2)) or ``exponential`` (t = exp w), w = unit·x + shift.
        x, t: the symbols.
        unit, shift: of w.
        ends: of the interval of t; open.
        turns: for angles the turns k with (2k − 1)π < w < (2k + 1)π that the interval of x meets; empty if unknown.
    """

    kind: str
    x: sp.Symbol
    t: sp.Symbol
    unit: sp.Expr
    shift: sp.Expr
    ends: tuple[Ends, ...]
    turns: tuple[tuple[int, ...], ...]

    def carried(self, functions: Sequence[sp.Expr]) -> list[sp.Expr]:
        """Functions of x as functions of t.

        Args:
            functions: of x alone.
        """
        return [self._carried(f) for f in functions]

    def _carried(self, f: sp.Expr) -> sp.Expr:
        if self.kind == "plain":
            if f.has(*_CIRCULAR, *_RISING) and any(n.has(self.x) for n in f.atoms(*_CIRCULAR, *_RISING)):
                raise NotAlgebraicError("x stands next to functions of x")
            return f.xreplace({self.x: self.t})
        table = {node: self._node(node) for node in f.atoms(*_CIRCULAR, *_RISING) if node.has(self.x)}
        found = f.xreplace(table)
        if found.has(self.x):
            raise NotAlgebraicError("x stands next to functions of x")
        return found

    def _node(self, node: sp.Expr) -> sp.Expr:
        n = int(_multiple(node.args[0], self.x, self.unit))
        if abs(n) > MAX_MULTIPLE:
            raise NotAlgebraicError("a high multiple of an angle")
        t = self.t
        if isinstance(node, _CIRCULAR):
            if self.kind != "circular":
                raise NotAlgebraicError("circular and exponential functions together")
            c, s = (1 - t**2) / (1 + t**2), 2 * t / (1 + t**2)
            if isinstance(node, sp.cos):
                return sp.chebyshevt(abs(n), c)
            return s * sp.chebyshevu(abs(n) - 1, c) * (1 if n > 0 else -1)
        if self.kind != "exponential":
            raise NotAlgebraicError("circular and exponential functions together")
        return t**n if isinstance(node, sp.exp) else _hyperbolic(node.func, t**n)

    def values(self, f: sp.Expr, place: sp.Rational) -> list[sp.Expr]:
        """Return the values of f at the places of x where t is a rational number; one for each turn of an angle.

        Args:
            f: of x alone.
            place: the rational t.

        Raises:
            NotAlgebraicError: an angle whose interval meets infinitely many turns.
        """
        t = {self.t: place}
        if self.kind == "plain":
            return [f.xreplace({self.x: place})]
        table = {node: self._node(node).xreplace(t) for node in f.atoms(*_CIRCULAR, *_RISING) if node.has(self.x)}
        g = f.xreplace(table)
        if not g.has(self.x):
            return [g]
        if self.kind == "exponential":
            return [g.xreplace({self.x: (sp.log(place) - self.shift) / self.unit})]
        if not self.turns:
            raise NotAlgebraicError("infinitely many turns")
        angle = 2 * sp.atan(place)
        met = (row for row, ends in zip(self.turns, self.ends, strict=True) if _inside(place, ends))
        turns = sorted({k for row in met for k in row})
        return [g.xreplace({self.x: (angle + 2 * sp.pi * k - self.shift) / self.unit}) for k in turns]


def _inside(place: sp.Rational, ends: Ends) -> bool:
    low, high = ends
    return (low is None or bool(low < place)) and (high is None or bool(place < high))


def _hyperbolic(function: type[sp.Function], e: sp.Expr) -> sp.Expr:
    cosine, sine = (e + 1 / e) / 2, (e - 1 / e) / 2
    return {
        sp.cosh: cosine, sp.sinh: sine, sp.tanh: sine / cosine, sp.coth: cosine / sine, sp.sech: 1 / cosine,
        sp.csch: 1 / sine,
    }[function]  # fmt: skip


def _multiple(argument: sp.Expr, x: sp.Symbol, unit: sp.Expr) -> sp.Rational:
    n = sp.expand(argument).coeff(x, 1) / unit
    if not n.is_Integer:
        raise NotAlgebraicError("arguments without a common unit")
    return n


def curve_of(functions: Sequence[sp.Expr], x: sp.Symbol, bounds: Bounds) -> AlgebraicCurve:
    """Return the parameter for functions of x on an interval.

    Args:
        functions: of x alone.
        bounds: of the open interval.

    Raises:
        NotAlgebraicError: there is none.
    """
    t = sp.Dummy("t")  # no assumption: sympy would write √(t²) as |t|
    nodes = [n for f in functions for n in f.atoms(*_CIRCULAR, *_RISING) if n.has(x)]
    if not nodes:
        return AlgebraicCurve("plain", x, t, sp.S.One, sp.S.Zero, (bounds,), ())
    unit, shift = _unit([n.args[0] for n in nodes], x)
    circular = isinstance(nodes[0], _CIRCULAR)
    low, high = (None if e is None else sp.expand(unit * e + shift) for e in bounds)
    if not circular:
        ends = (sp.S.Zero if low is None else sp.exp(low), None if high is None else sp.exp(high))
        return AlgebraicCurve("exponential", x, t, unit, shift, (ends,), ())
    ranges, turns = _turned(low, high)
    return AlgebraicCurve("circular", x, t, unit, shift, ranges, turns)


def _unit(arguments: Sequence[sp.Expr], x: sp.Symbol) -> tuple[sp.Expr, sp.Expr]:
    """Return unit and shift of w = unit·x + shift, of which every argument is a whole multiple; unit is positive."""
    pairs = []
    for a in arguments:
        a = sp.expand(a)
        slope = a.coeff(x, 1)
        rest = sp.expand(a - slope * x)
        if slope == 0 or slope.has(x) or rest.has(x):
            raise NotAlgebraicError("an argument that is not linear")
        pairs.append((slope, rest))
    first, second = pairs[0]
    common = Fraction(0)
    for slope, rest in pairs:
        ratio = slope / first
        if not ratio.is_Rational or sp.expand(rest - ratio * second) != 0:
            raise NotAlgebraicError("arguments without a common unit")
        r = Fraction(int(ratio.p), int(ratio.q))
        common = Fraction(
            gcd(common.numerator * r.denominator, r.numerator * common.denominator), common.denominator * r.denominator
        )
    scale = sp.Rational(common.numerator, common.denominator) * (1 if first.is_positive else -1)
    return scale * first, scale * second


def _turned(low: sp.Expr | None, high: sp.Expr | None) -> tuple[tuple[Ends, ...], tuple[tuple[int, ...], ...]]:
    """Return the intervals of tan(w/2) that w runs through, each with its turns; all of the line where w has no end."""
    if low is None or high is None:
        return ((None, None),), ()
    first, last = (sp.floor((e / sp.pi + 1) / 2) for e in (low, high))
    if not (first.is_Integer and last.is_Integer) or last - first > MAX_TURNS:
        return ((None, None),), ()
    found: dict[Ends, list[int]] = {}
    for k in range(int(first), int(last) + 1):
        begin = sp.tan(low / 2) if k == first and (low / sp.pi + 1) / 2 != first else None
        end = sp.tan(high / 2) if k == last else None
        if k == last and (high / sp.pi + 1) / 2 == last:
            continue
        found.setdefault((begin, end), []).append(k)
    return tuple(found), tuple(tuple(ks) for ks in found.values())
