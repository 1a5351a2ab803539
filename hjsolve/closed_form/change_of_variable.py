"""A variable x = φ(q) in which a squared momentum is rational, and the ends of a coordinate's domain."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from hjsolve.closed_form.tidy import shortened_powers
from hjsolve.display.shown import Shown
from hjsolve.mechanics.coordinates_and_parameters import Coordinate


@dataclass(frozen=True, repr=False)
class Substitution(Shown):
    """A variable x = φ(q), monotone on the domain of q.

    Attributes:
        x: the variable.
        place: φ(q).
        inverse: q as a function of x.
        slope_squared: G(x) = φ′(q)².
        function: P² as a function of x.
        lower: the lower end of the values of x, ±oo allowed.
        upper: the upper end.
        increasing: whether x grows with q.
        closed: whether x runs over its whole range while q makes one turn: a rotation is then the whole range.
        turn: how long a turn is, in q.
        condition: positive where the variable is that; 1 where it is so for every value of the letters.
        turns: how many such make up a turn of an angle along which P² repeats itself.
    """

    x: sp.Symbol
    place: sp.Expr
    inverse: sp.Expr
    slope_squared: sp.Expr
    function: sp.Expr
    lower: sp.Expr
    upper: sp.Expr
    increasing: bool
    closed: bool = False
    turn: sp.Expr = 2 * sp.pi
    condition: sp.Expr = sp.S.One
    turns: int = 1

    def q(self, x: sp.Expr) -> sp.Expr:
        """Return the coordinate at a place x, its powers shortened."""
        return shortened_powers(self.inverse.subs(self.x, x))

    def unwound(self, value: sp.Expr, symbol: sp.Symbol, q: sp.Expr) -> sp.Expr:
        """Return a value with arcsin φ(q), √(1 − φ²) and the like as functions of q itself.

        The variable is monotone on its turn: which branch is meant is that of ``inverse``, also where sympy writes
        sin((q − π)/2) as −cos(q/2).

        Args:
            value: what may hold them.
            symbol: the coordinate's.
            q: the coordinate, or its lower limit.
        """
        arcs = [f for f in self.inverse.atoms(*_ARCS) if f.args[0] == self.x]
        place, u = self.place.subs(symbol, q), sp.Dummy("u")
        line = self.inverse.subs(arcs[0], u) if len(arcs) == 1 else sp.S.NaN
        if place == q or line.has(self.x) or not line.is_polynomial(u) or sp.degree(line, u) != 1:
            return value
        own, kind = sp.expand((q - line.subs(u, 0)) / sp.diff(line, u)), arcs[0].func
        known = (
            {kind: own} if kind is sp.atan else {f: own if f is kind else sp.pi / 2 - own for f in (sp.asin, sp.acos)}
        )
        root = {sp.asin: sp.cos, sp.acos: sp.sin}.get(kind)

        def written(e: sp.Expr) -> sp.Expr:
            if e.is_Pow:
                return e if root is None else root(own) ** (2 * e.exp)
            arc = known[e.func]
            return arc if e.args[0] == place else sp.pi - arc if e.func is sp.acos else -arc

        return value.replace(lambda e: e.func in known and e.args[0] in (place, -place), written).replace(
            lambda e: e.is_Pow and abs(e.exp) == sp.S.Half and e.base == 1 - place**2, written
        )


_ARCS = (sp.asin, sp.acos, sp.atan)


def extended_domain_ends(coordinate: Coordinate) -> tuple[sp.Expr, sp.Expr]:
    """Return the ends of a domain as extended real numbers; one turn about zero of an angle."""
    domain = coordinate.domain
    if domain.kind == "angle":
        return -sp.pi, sp.pi
    return (
        -sp.oo if domain.lower is None else domain.lower,
        sp.oo if domain.upper is None else domain.upper,
    )


def scaled_end(κ: sp.Expr, end: sp.Expr) -> sp.Expr:
    """Return an end of the domain times a positive factor.

    Args:
        κ: the factor.
        end: may be infinite.
    """
    return end if end in (sp.oo, -sp.oo) else κ * end


def possible_signs(κ: sp.Expr) -> tuple[int, ...]:
    """Return the signs of a factor that are possible.

    Args:
        κ: the factor.
    """
    return (1,) if κ.is_positive else (-1,) if κ.is_negative else (1, -1)


def condition_on(κ: sp.Expr) -> sp.Expr:
    """Return what must be positive; 1 where it is.

    Args:
        κ: a factor that is to be positive.
    """
    return sp.S.One if κ.is_positive else κ
