"""What an elliptic integral is of: the branch points of √P, a rational function in partial fractions, and where."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy as sp

Interval = tuple[int | None, int | None]
"""The real roots between which P > 0, by their places in ascending order; None for −∞ or +∞."""


class NoForm(Exception):  # noqa: N818 - an answer, not a fault: it says why there is none
    """No closed form is given here; the text says why, in one sentence."""


@dataclass(frozen=True)
class BranchPoints:
    """P(x) = leading · Π (x − rₖ) · Π ((x − α)² + β²), of degree 3 or 4; the ends of the interval are simple roots.

    Another root may be double, the same expression twice: the integrals are elementary then, R_C.

    Attributes:
        leading: the leading coefficient; its sign follows from the interval and the roots.
        real: real roots in ascending order.
        pairs: complex pairs α ± iβ as (α, β), β > 0.
        polynomial: P in powers of x, where it is known: at a place it may be shorter than the product.
        distances: real root → its distance from the complex pair, by a name.
        complement: k′ of the integrals between two real roots and beside a pair, by a name.
    """

    leading: sp.Expr
    real: tuple[sp.Expr, ...]
    pairs: tuple[tuple[sp.Expr, sp.Expr], ...] = ()
    polynomial: sp.Poly | None = None
    distances: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    complement: sp.Expr | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "leading", sp.sympify(self.leading))
        object.__setattr__(self, "real", tuple(map(sp.sympify, self.real)))
        object.__setattr__(self, "pairs", tuple(tuple(map(sp.sympify, pair)) for pair in self.pairs))

    @property
    def degree(self) -> int:
        """Degree of P."""
        return len(self.real) + 2 * len(self.pairs)

    def value(self, x: sp.Expr) -> sp.Expr:
        """P(x)."""
        factors = [x - r for r in self.real] + [(x - α) ** 2 + β**2 for α, β in self.pairs]
        return sp.Mul(self.leading, *factors)

    def at_pole(self, place: sp.Expr) -> sp.Expr:
        """P at the place of a pole."""
        return self.value(place) if self.polynomial is None else sp.factor(self.polynomial.eval(place))

    def distance(self, place: sp.Expr) -> sp.Expr:
        """Return the distance of a place from the complex pair."""
        if place in self.distances:
            return self.distances[place]
        α, β = self.pairs[0]
        return sp.sqrt((place - α) ** 2 + β**2)

    def taylor(self, place: sp.Expr) -> list[sp.Expr]:
        """Return the coefficients of P in powers of x − place; the first is exactly zero at a real root."""
        coefficients: list[sp.Expr] = [self.leading]
        factors = [(place - r if place != r else sp.S.Zero, sp.S.One) for r in self.real]
        longer = [((place - α) ** 2 + β**2, 2 * (place - α), sp.S.One) for α, β in self.pairs]
        for factor in (*factors, *longer):
            product = [sp.S.Zero] * (len(coefficients) + len(factor) - 1)
            for i, c in enumerate(coefficients):
                for k, f in enumerate(factor):
                    product[i + k] += c * f
            coefficients = product
        return coefficients

    def slope(self, place: sp.Expr) -> sp.Expr:
        """P′ at a real root, as a product."""
        factors = [place - r for r in self.real if r != place] + [(place - α) ** 2 + β**2 for α, β in self.pairs]
        return sp.Mul(self.leading, *factors)


@dataclass(frozen=True)
class PartialFractions:
    """A rational function in partial fractions: Σ coefficient·xᵏ + Σ coefficient/(x − place)^power.

    Attributes:
        powers: (k, coefficient), k ≥ 0.
        poles: (place, power ≥ 1, coefficient), the place real and outside the closed interval of integration; it may
            be a real root of P that is not an end of the interval.
        complex_poles: (re, im, A, B) for (A x + B)/((x − re)² + im²).
    """

    powers: tuple[tuple[int, sp.Expr], ...]
    poles: tuple[tuple[sp.Expr, int, sp.Expr], ...] = ()
    complex_poles: tuple[tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr], ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "powers", tuple((k, sp.sympify(c)) for k, c in self.powers))
        object.__setattr__(self, "poles", tuple((sp.sympify(r), m, sp.sympify(c)) for r, m, c in self.poles))
