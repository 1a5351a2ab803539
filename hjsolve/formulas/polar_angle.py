"""The angle of a point, atan2(y, x), in functions that are smooth wherever it is.

Sines, cosines and tangents of its multiples are algebraic: cos(2θ) = (x² − y²)/(x² + y²). What is left is

    atan2(y, x) = atan(y/x)  (x > 0),   ±π/2 − atan(x/y)  (±y > 0),   else  2 atan(y/(x + √(x² + y²))),

whose denominator vanishes where the angle jumps by 2π and nowhere else.
"""

from __future__ import annotations

import sympy as sp

MAX_MULTIPLE = 24
_TRIGONOMETRIC = (sp.sin, sp.cos, sp.tan)


def angle_of_point(y: sp.Expr, x: sp.Expr) -> sp.Expr:
    """Return atan2(y, x): exact for numbers, an arc tangent where a sign is known, else sympy's atan2.

    Args:
        y, x: real, not both zero.
    """
    if x.is_positive:
        return sp.atan(y / x)
    if y.is_positive:
        return sp.pi / 2 - sp.atan(x / y)
    if y.is_negative:
        return -sp.pi / 2 - sp.atan(x / y)
    return sp.pi if y.is_zero and x.is_negative else sp.atan2(y, x)


def largest_multiple(expression: sp.Expr) -> int:
    """Return the largest whole number in an expression that holds atan2; 0 where none does."""
    if not expression.has(sp.atan2):
        return 0
    bare = expression.replace(sp.atan2, lambda *_: sp.S.One)
    return max((abs(int(n)) for n in bare.atoms(sp.Integer)), default=0)


def without_polar_angles(expression: sp.Expr) -> sp.Expr:
    """Return the expression with each atan2 written by the formulas of this module.

    Args:
        expression: real.
    """
    if not expression.has(sp.atan2):
        return expression
    of_multiples = expression.replace(_is_trigonometric_of_angle, sp.expand_trig)
    return of_multiples.replace(sp.atan2, _arc_tangent)


def _is_trigonometric_of_angle(node: sp.Basic) -> bool:
    return isinstance(node, _TRIGONOMETRIC) and node.has(sp.atan2)


def _arc_tangent(y: sp.Expr, x: sp.Expr) -> sp.Expr:
    known = angle_of_point(y, x)
    return 2 * sp.atan(y / (x + sp.sqrt(x**2 + y**2))) if known.has(sp.atan2) else known
