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

    def q(self, x: sp.Expr) -> sp.Expr:
        """Return the coordinate at a place x, its powers shortened."""
        return shortened_powers(self.inverse.subs(self.x, x))


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
