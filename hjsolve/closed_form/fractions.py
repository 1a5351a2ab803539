"""Partial fractions of the rational factor R(x) of ∫ R dx/√P, with poles at named or radical places."""

from __future__ import annotations

import sympy as sp

from hjsolve.closed_form.curves import named_constants
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.signs import Signs
from hjsolve.functions.elliptic import PartialFractions


def partial_fractions(R: sp.Expr, x: sp.Symbol, signs: Signs) -> PartialFractions:
    """Partial fractions.

    Args:
        R: rational in x.
        x: the variable.
        signs: decides whether the zeros of a quadratic factor are real, and keeps what it decided.

    Raises:
        NoFormError: a denominator of degree above 2 that does not factor, or with multiple complex zeros.
    """
    bare, back = named_constants(R, x)
    top, bottom = sp.fraction(sp.cancel(sp.together(bare)))
    whole, rest = sp.div(sp.Poly(top, x), sp.Poly(bottom, x)) if bottom.has(x) else (sp.Poly(top / bottom, x), None)
    powers = tuple((int(k), sp.factor(c).xreplace(back)) for (k,), c in whole.terms() if c != 0)
    if rest is None or rest.is_zero:
        return PartialFractions(powers)
    poles, complex_poles = [], []
    constant, factors = sp.factor_list(bottom, x)
    for factor, power in factors:
        others = constant * sp.Mul(*(f**n for f, n in factors if f != factor))
        if (square := _without_real_zeros(factor, x, back, signs)) is not None:
            if power > 1:
                raise NoFormError(f"the integrand has multiple poles at complex places, where {factor} = 0")
            re, im, leading = square
            inverse = sp.invert(sp.Poly(others, x), sp.Poly(factor, x)) if others.has(x) else sp.Poly(1 / others, x)
            line = sp.rem(rest * inverse, sp.Poly(factor, x))
            A, B = (sp.factor(line.coeff_monomial(x**k) / leading).xreplace(back) for k in (1, 0))
            complex_poles.append((re.xreplace(back), im.xreplace(back), A, B))
            continue
        for place, cofactor in _zeros(factor, x):
            g = rest.as_expr() / (others * cofactor**power)
            for order in range(power):
                weight = sp.diff(g, x, order).subs(x, place) / sp.factorial(order)
                weight = sp.factor(sp.cancel(sp.together(weight)))
                if weight != 0:
                    poles.append((place.xreplace(back), power - order, weight.xreplace(back)))
    return PartialFractions(powers, tuple(poles), tuple(complex_poles))


def _without_real_zeros(
    factor: sp.Expr, x: sp.Symbol, back: dict[sp.Symbol, sp.Expr], signs: Signs
) -> tuple[sp.Expr, sp.Expr, sp.Expr] | None:  # fmt: skip
    """α, β and a of a((x − α)² + β²); None where the factor has real zeros."""
    if sp.degree(factor, x) != 2:
        return None
    a, b, c = sp.Poly(factor, x).all_coeffs()
    D = sp.factor(4 * a * c - b**2)
    if signs.sign(D.xreplace(back)) < 0:
        return None
    return -b / (2 * a), sp.sqrt(D) / (2 * sp.sqrt(a**2)), a


def _zeros(factor: sp.Expr, x: sp.Symbol) -> list[tuple[sp.Expr, sp.Expr]]:
    """The zeros r of an irreducible factor, and factor/(x − r)."""
    coefficients = sp.Poly(factor, x).all_coeffs()
    if len(coefficients) == 2:
        a, b = coefficients
        return [(sp.cancel(-b / a), a)]
    if len(coefficients) == 3:
        a, b, c = coefficients
        D = sp.factor(b**2 - 4 * a * c)
        low, high = ((-b + s * sp.sqrt(D)) / (2 * a) for s in (-1, 1))
        return [(low, a * (x - high)), (high, a * (x - low))]
    raise NoFormError(f"the integrand has poles at the roots of a polynomial of degree {len(coefficients) - 1}")
