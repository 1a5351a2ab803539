"""Arguments of functions as sums of rational multiples of monomials."""

from __future__ import annotations

from collections.abc import Collection
from fractions import Fraction
from math import gcd

import sympy as sp


def is_shifted(argument: sp.Expr, coordinates: Collection[sp.Symbol]) -> bool:
    """Tell whether an argument is that of one coordinate, moved by something that holds none."""
    parts = [part.free_symbols.intersection(coordinates) for part in sp.Add.make_args(sp.expand(argument))]
    return len(parts) > 1 and not all(parts) and len(set().union(*parts)) == 1


def rational_multiples(x: sp.Expr) -> list[tuple[sp.Expr, Fraction]]:
    """Return an expression as Σ coefficient · monomial with rational coefficients.

    Args:
        x: an argument of a function, or an exponent.
    """
    pairs = sp.expand(x).as_coefficients_dict().items()
    return [(m, Fraction(int(c.p), int(c.q))) for m, c in pairs if c.is_Rational and c != 0]


def rational_gcd(a: Fraction, b: Fraction) -> Fraction:
    """Return the greatest rational number of which both are integer multiples.

    Args:
        a, b: not both zero.
    """
    return Fraction(gcd(a.numerator * b.denominator, b.numerator * a.denominator), a.denominator * b.denominator)
