"""Special constants, at which a curve changes its degree or two of its roots meet: E = 0, the separatrix."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache

import sympy as sp

from hjsolve.closed_form.curves import MomentumCurve, named_constants


def deciders(curve: MomentumCurve, constants: Iterable[sp.Symbol]) -> list[sp.Expr]:
    """Factors of the leading coefficient, the discriminant and the values of P at the ends that depend on constants.

    A factor that enters to an even power is given squared: its sign says nothing.

    Args:
        curve: of a coordinate.
        constants: of the motion.
    """
    ends = (curve.substitution.lower, curve.substitution.upper)
    return list(_deciders(curve.polynomial, ends, frozenset(constants)))


@lru_cache(maxsize=256)
def _deciders(
    P: sp.Poly, ends: tuple[sp.Expr, sp.Expr], constants: frozenset[sp.Symbol]
) -> tuple[sp.Expr, ...]:  # fmt: skip
    x = P.gen
    bare, back = named_constants(P.as_expr(), x)
    factors = [f for f, _ in sp.factor_list(sp.numer(sp.together(bare)), x)[1]]
    # the degree falls with the leading coefficient; roots meet where a discriminant or a resultant is zero
    found: list[sp.Expr] = [P.LC()]
    for k, f in enumerate(factors):
        if 2 <= sp.degree(f, x) <= 3:
            found.append(sp.discriminant(f, x).xreplace(back))
        # a x⁴ + b x² + c: of the square, b² − 4ac, and c, where two roots meet at 0
        if sp.degree(f, x) == 4 and f.coeff(x, 3) == 0 and f.coeff(x, 1) == 0:
            a, b, c = (f.expand().coeff(x, n) for n in (4, 2, 0))
            found += [c.xreplace(back), (b**2 - 4 * a * c).xreplace(back)]
        found += [sp.resultant(f, g, x).xreplace(back) for g in factors[:k]]
    # a root at an end of the domain: the motion reaches it, or turns before
    found += [P.as_expr().subs(x, end) for end in ends if end.is_finite]
    result = list[sp.Expr]()
    for expression in found:
        bare, back = named_constants(sp.together(expression), x)
        top = sp.fraction(sp.cancel(bare))[0]
        for factor, power in sp.factor_list(top)[1]:
            plain = factor.xreplace(back)
            plain = plain if power % 2 else plain**2  # of which only it is known that it is not zero
            if plain.free_symbols & constants and plain not in result:
                result.append(plain)
    return tuple(result)


def fixed_constant(decider: sp.Expr, constants: Iterable[sp.Symbol]) -> dict[sp.Symbol, sp.Expr] | None:
    """Return the constant that a decider fixes where it is zero, the first that it holds to first degree.

    Args:
        decider: zero in the special case.
        constants: of the motion, in the order of preference.
    """
    base = decider.base if decider.is_Pow else decider
    for constant in constants:
        if not base.has(constant) or not base.is_polynomial(constant):
            continue
        # of the first degree there is one value, and it is rational in the other letters
        p = sp.Poly(base, constant)
        if p.degree() == 1:
            return {constant: sp.factor(sp.cancel(-p.coeff_monomial(1) / p.LC()))}
    return None


def special_cases_of(
    curves: Mapping[str, list[MomentumCurve]], constants: list[sp.Symbol]
) -> list[dict[sp.Symbol, sp.Expr]]:
    """Return every special case that fixes one constant.

    Args:
        curves: separated coordinate → its curves.
        constants: E, the separation constants, the ignorable momenta.
    """
    found = list[dict[sp.Symbol, sp.Expr]]()
    for own in curves.values():
        for curve in own[:1]:
            for decider in deciders(curve, constants):
                special = fixed_constant(decider, constants)
                if special is not None and special not in found:
                    found.append(special)
    return found
