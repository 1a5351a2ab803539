"""∫ R(x²) dx/√P(x²), deg P = 6: a curve of genus 2 that x ↦ −x maps to itself, and that X = x² makes elliptic.

    ∫ R(x²) dx/√P(x²) = ± ½ ∫ R(X) dX/√(X P(X)),   + for x > 0,

of degree 4 in X. Where the motion passes x = 0 the integral is taken from the root X = 0, and is odd in x: every
square root of X is written as x. So rotates the angle of two centres, whose squared momentum is quadratic in the
cosine.

Jacobi's reduction; Byrd and Friedman, Handbook of elliptic integrals (1971), 575.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import mpmath
import sympy as sp

from hjsolve.closed_form.branch_points import NamedRoots, named_roots
from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.even_curves import in_square
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.regions import RootInterval, real_roots
from hjsolve.closed_form.signs import Signs


@dataclass(frozen=True)
class SquareCurve:
    """The curve in X = x², and how the motion lies on it.

    Attributes:
        X: the variable, positive.
        inner: the curve y² = X P(X).
        roots: of X P(X), by name.
        side: the sign of x where the motion does not pass x = 0; 1 where it does.
        passes: whether it passes x = 0.
        place: X of the sample.
    """

    X: sp.Symbol
    inner: MomentumCurve
    roots: NamedRoots
    side: int
    passes: bool
    place: mpmath.mpf

    def integrand(self, R: sp.Expr, x: sp.Symbol) -> sp.Expr:
        """± ½ R in X.

        Args:
            R: rational in x.
            x: the variable of the curve.

        Raises:
            NoFormError: R is not even.
        """
        return self.side * in_square(R, x, self.X) / 2

    def in_x(self, value: sp.Expr, x: sp.Symbol) -> sp.Expr:
        """Return an integral over X as a function of x, odd where the motion passes x = 0.

        Args:
            value: of the integral.
            x: the variable of the curve.
        """
        if not self.passes:
            return value.xreplace({self.X: x**2})
        # of y > 0 the root √X is y: with x of either sign in its place the integral is odd
        # sympy would write √(x²) as |x|, which is even
        y = sp.Dummy("y", positive=True)
        return value.subs(self.X, y**2).xreplace({y: x})

    def turning_points(self, signs: Signs) -> tuple[sp.Expr, ...]:
        """Return the real roots of P(x²) in x, ascending.

        Args:
            signs: of the sample.
        """
        positive = [sp.sqrt(r) for r in self.roots.real if signs.there(r) > 0]
        return (*(-r for r in reversed(positive)), *positive)


def square_curve(curve: MomentumCurve, region: RootInterval, signs: Signs, prefix: str) -> SquareCurve:
    """Return the curve in X of an even P of degree 6.

    Args:
        curve: of degree 6.
        region: where the motion is.
        signs: of the sample.
        prefix: of the names of roots.

    Raises:
        NoFormError: P is not even, or the roots have no names.
    """
    P, x = curve.polynomial, curve.x
    X = sp.Symbol(x.name, positive=True)
    # dx/√P = dX/(2 √X √P): the X under the root makes a quartic of the cubic P(X)
    polynomial = sp.Poly(sum(c * X ** (n // 2 + 1) for (n,), c in P.terms()), X)
    end = curve.substitution.upper
    squares = replace(curve.substitution, x=X, lower=sp.S.Zero, upper=end**2 if end.is_finite else sp.oo)
    inner = replace(curve, polynomial=polynomial, substitution=squares)
    below = [r for r in region.roots if r < region.place]
    above = [r for r in region.roots if r > region.place]
    # between −x₁ and x₁: X goes from 0 to x₁² and back, and the integral over X is odd in x
    passes = (not below or below[-1] < 0) and (not above or above[0] > 0)
    real, double = real_roots(inner, signs.numbers)
    if double:
        raise NoFormError("two roots of the curve in x² meet")
    there = replace(region, curve=inner, place=region.place**2, roots=tuple(real))
    named = named_roots(inner, there, signs, prefix)
    return SquareCurve(X, inner, named, 1 if passes or region.place > 0 else -1, passes, region.place**2)


def between_the_roots_of_a_power(R: sp.Expr, curve: MomentumCurve) -> sp.Expr | None:
    """∫ R dx/√(a − b xⁿ) over −r ≤ x ≤ r = (a/b)^(1/n), n even, by Euler's integral of the first kind.

    ∫₀ʳ xᵏ dx/√(a − b xⁿ) = rᵏ⁺¹/(n √a) B((k + 1)/n, ½), which shows how V = α xⁿ scales (Landau and Lifshitz, Mechanics
    §11, problem 2a).

    Args:
        R: rational in the variable.
        curve: with roots ± r.

    Returns:
        The integral; None of another P, or of an R with poles.
    """
    P, x, n, ends = curve.polynomial, curve.x, curve.degree, roots_of_a_power(curve)
    if ends is None or not R.is_polynomial(x):
        return None
    total, r, a = sp.S.Zero, ends[1], P.coeff_monomial(1)
    for (k,), c in sp.Poly(R, x).terms():
        if k % 2 == 0:
            # xᵏ and xᵏ⁺ⁿ are of one period, up to a rational factor: J and T of xⁿ hold one beta function
            first, whole = sp.Rational(k % n + 1, n), k // n  # by Γ(s + 1) = s Γ(s), so that terms of one period join
            total += c * r ** (k + 1) * sp.rf(first, whole) / sp.rf(first + sp.S.Half, whole) * _beta(first)
    return 2 * sp.factor_terms(sp.expand(total)) / (n * sp.sqrt(a))


def roots_of_a_power(curve: MomentumCurve) -> tuple[sp.Expr, sp.Expr] | None:
    """Return the real roots ± (a/b)^(1/n) of P = a − b xⁿ, n even; None of another P.

    Args:
        curve: of P.
    """
    P, n = curve.polynomial, curve.degree
    a, b = P.coeff_monomial(1), -P.LC()
    if n % 2 or a == 0 or P.as_expr() != a - b * curve.x**n:
        return None
    r = sp.Pow(sp.factor(a / b), sp.Rational(1, n))
    return -r, r


def _beta(s: sp.Rational) -> sp.Expr:
    """B(s, ½) in Γ of arguments up to 1."""
    other = (s - sp.S.Half) * sp.gamma(s - sp.S.Half) if s > sp.S.Half else sp.gamma(s + sp.S.Half)
    return sp.gamma(s) * sp.sqrt(sp.pi) / other


def reduces(curve: MomentumCurve) -> bool:
    """Return whether a curve of genus 2 is one of these.

    Args:
        curve: of any degree.
    """
    return curve.degree == 6 and all(n % 2 == 0 for (n,) in curve.polynomial.monoms())
