"""Enclosing S_ij(f) at a rational point from the expressions of a shell: no derivative is written down.

Interval arithmetic on second-order jets (f, ∂ᵢf, ∂ⱼf, ∂ᵢ∂ⱼf). A shell with thousands of terms has a condition with
millions; its value at a point costs no more than a few evaluations of the shell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache, lru_cache, reduce
from typing import TypeAlias

import mpmath
import sympy as sp
from mpmath import libmp

from hjsolve.algebra.intervals import Interval, NoEnclosureError, Walk, enclose_inverse, finite, rational
from hjsolve.algebra.tree_walk import TreeWalk

Slope: TypeAlias = Interval | None
Jet: TypeAlias = tuple[Interval, Slope, Slope, Slope]


def enclose_condition(
    f: sp.Expr,
    gi: sp.Expr,
    gj: sp.Expr,
    pair: tuple[sp.Symbol, sp.Symbol],
    point: Mapping[sp.Expr, sp.Rational],
    precision: int,
) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Lower and upper bound of S_ij(f) = ∂ᵢ∂ⱼf − (∂ᵢ ln gʲʲ) ∂ⱼf − (∂ⱼ ln gⁱⁱ) ∂ᵢf.

    Args:
        f: gʰʰ, or the potential.
        gi, gj: gⁱⁱ and gʲʲ.
        pair: symbols of the coordinates i and j.
        point: symbol, or function left undetermined, → rational value.

    Raises:
        NoEnclosureError: a value is not finite or not real there, or a function has no jet here.
    """

    def value() -> Interval:
        walk = JetWalk(pair, point, precision)
        _, fi, fj, fij = walk(f)
        a, b = walk(gi), walk(gj)
        first = walk.times(walk.over(b[1], b[0]), fj)
        second = walk.times(walk.over(a[2], a[0]), fi)
        total = walk.plus(fij, walk.negative(walk.plus(first, second)))
        return rational(0, 1, precision) if total is None else total

    return finite(value)


def has_jets(x: sp.Expr, pair: tuple[sp.Symbol, sp.Symbol]) -> bool:
    """Whether every function of an expression that depends on two coordinates has a jet; if not, no point has one."""
    return all(f.func in _KNOWN or not _moves(f, pair) for f in x.atoms(sp.Function))


@lru_cache(maxsize=16384)
def _moves(x: sp.Expr, pair: tuple[sp.Symbol, sp.Symbol]) -> bool:
    """Return whether an expression depends on one of two coordinates; asked of the same parts at every point."""
    return not x.free_symbols.isdisjoint(pair)


class JetWalk(TreeWalk[Jet]):
    """The walk in jets of intervals; None is a derivative that is identically zero."""

    def __init__(self, pair: tuple[sp.Symbol, sp.Symbol], point: Mapping[sp.Expr, sp.Rational], precision: int):
        super().__init__()
        self.pair, self.precision = pair, precision
        self.plain = Walk(point, precision)

    def leaf(self, x: sp.Expr) -> Jet | None:  # noqa: D102
        one = rational(1, 1, self.precision)
        if x in self.pair:
            return self.plain(x), one if x == self.pair[0] else None, one if x == self.pair[1] else None, None
        return None if _moves(x, self.pair) else (self.plain(x), None, None, None)

    def total(self, parts: Iterable[Jet]) -> Jet:  # noqa: D102
        return reduce(self._sum, parts)

    def product(self, parts: Iterable[Jet]) -> Jet:  # noqa: D102
        return reduce(self._product, parts)

    def power(self, x: sp.Expr) -> Jet:  # noqa: D102
        if x.base is not sp.E and not x.exp.is_Rational:
            return self.function(sp.exp(x.exp * sp.log(x.base), evaluate=False))
        return self.function(x)

    def function(self, x: sp.Expr) -> Jet:
        """Return h(u) by the chain rule: ∂ᵢ∂ⱼh = h″ uᵢuⱼ + h′ uᵢⱼ."""
        h, argument = _outermost(x)
        u, (first, second) = self(argument), (self.plain(d.xreplace({_U: argument})) for d in _derivatives(h))
        mixed = self.plus(self.times(second, self.times(u[1], u[2])), self.times(first, u[3]))
        return self.plain(x), self.times(first, u[1]), self.times(first, u[2]), mixed

    def _sum(self, a: Jet, b: Jet) -> Jet:
        plus = self.plus
        return libmp.mpi_add(a[0], b[0], self.precision), plus(a[1], b[1]), plus(a[2], b[2]), plus(a[3], b[3])

    def _product(self, a: Jet, b: Jet) -> Jet:
        plus, times = self.plus, self.times
        mixed = plus(plus(times(a[3], b[0]), times(a[0], b[3])), plus(times(a[1], b[2]), times(a[2], b[1])))
        first, second = (plus(times(a[k], b[0]), times(a[0], b[k])) for k in (1, 2))
        return libmp.mpi_mul(a[0], b[0], self.precision), first, second, mixed

    def plus(self, a: Slope, b: Slope) -> Slope:
        """Return the sum."""
        if a is None or b is None:
            return b if a is None else a
        return libmp.mpi_add(a, b, self.precision)

    def times(self, a: Slope, b: Slope) -> Slope:
        """Return the product."""
        return None if a is None or b is None else libmp.mpi_mul(a, b, self.precision)

    def over(self, a: Slope, b: Interval) -> Slope:
        """Return the quotient."""
        return None if a is None else libmp.mpi_mul(a, enclose_inverse(b, self.precision), self.precision)

    def negative(self, a: Slope) -> Slope:
        """Return the negative."""
        return None if a is None else libmp.mpi_neg(a)


_U = sp.Dummy("u", real=True)
_KNOWN: tuple[Callable[[sp.Expr], sp.Expr], ...] = (
    sp.sin, sp.cos, sp.tan, sp.sinh, sp.cosh, sp.tanh, sp.exp, sp.log, sp.atan, sp.asin, sp.acos,
    sp.asinh, sp.acosh, sp.atanh,
)  # fmt: skip


def _outermost(x: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Return h, a function of ``_U``, and u of x = h(u)."""
    if x.is_Pow:
        return (sp.exp(_U), x.exp) if x.base is sp.E else (_U**x.exp, x.base)
    if x.func not in _KNOWN:
        raise NoEnclosureError(f"no jet of {x.func}")
    return x.func(_U), x.args[0]


@cache
def _derivatives(h: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """h′ and h″; worked out when a function is first met."""
    return h.diff(_U), h.diff(_U, 2)
