"""Partial fractions of the rational factor R(x) of ∫ R dx/√P, with poles at named or radical places."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from hjsolve.closed_form.curves import named_constants
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.signs import Signs
from hjsolve.closed_form.tidy import in_factors
from hjsolve.errors import required
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
    made = _split(R, x)
    poles, complex_poles = list[tuple[sp.Expr, int, sp.Expr]](), list[tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]]()
    for k, (factor, power) in enumerate(made.factors):
        # the sign of 4ac − b² is one of the regime: real zeros give logarithms or Π, a pair a complex pole
        D = _lacking(factor, x)
        if D is None or signs.sign(D.xreplace(made.back)) < 0:
            poles += _at_real_places(R, x, k)
        elif power > 1:
            # by parts such poles lower their order (Hermite), and a derivation of that is not there for pairs
            raise NoFormError(f"the integrand has multiple poles at complex places, where {factor} = 0")
        else:
            complex_poles.append(_at_complex_places(R, x, k))
    return PartialFractions(made.powers, tuple(poles), tuple(complex_poles))


@dataclass(frozen=True)
class _Split:
    """A rational function as a polynomial and a proper fraction.

    Attributes:
        powers: exponent and coefficient of the polynomial.
        rest: the numerator of the fraction.
        constant: the constant factor of its denominator.
        factors: the others, and their powers.
        back: name → constant, of constants that are no rational functions.
    """

    powers: tuple[tuple[int, sp.Expr], ...]
    rest: sp.Poly
    constant: sp.Expr
    factors: tuple[tuple[sp.Expr, int], ...]
    back: dict[sp.Symbol, sp.Expr]

    def others(self, k: int) -> sp.Expr:
        """Return the denominator without a factor."""
        return self.constant * sp.Mul(*(f**n for j, (f, n) in enumerate(self.factors) if j != k))


@lru_cache(maxsize=256)
def _split(R: sp.Expr, x: sp.Symbol) -> _Split:
    """Split a rational function; the same integrands occur in every regime of a curve."""
    # √2 and sin α by letters: sympy factors over the rationals, where a letter is as good
    bare, back = named_constants(R, x)
    top, bottom = sp.fraction(sp.cancel(sp.together(bare)))
    whole, rest = sp.div(sp.Poly(top, x), sp.Poly(bottom, x)) if bottom.has(x) else (sp.Poly(top / bottom, x), None)
    powers = tuple((int(k), sp.factor(c).xreplace(back)) for (k,), c in whole.terms() if c != 0)
    if rest is None or rest.is_zero:
        return _Split(powers, sp.Poly(0, x), sp.S.One, (), back)
    constant, factors = sp.factor_list(bottom, x)
    return _Split(powers, rest, constant, tuple(factors), back)


@lru_cache(maxsize=1024)
def _at_real_places(R: sp.Expr, x: sp.Symbol, k: int) -> tuple[tuple[sp.Expr, int, sp.Expr], ...]:
    """Place, order and weight of the poles at the zeros of a factor of the denominator."""
    made, poles = _split(R, x), list[tuple[sp.Expr, int, sp.Expr]]()
    (factor, power), others = made.factors[k], made.others(k)
    for place, cofactor in _zeros(factor, x):
        # of g/(x − r)ⁿ the weight of (x − r)^{k − n} is g⁽ᵏ⁾(r)/k!, Taylor's coefficient
        g = made.rest.as_expr() / (others * cofactor**power)
        for order in range(power):
            weight = sp.diff(g, x, order).subs(x, place) / sp.factorial(order)
            if (weight := in_factors(weight)) != 0:
                poles.append((place.xreplace(made.back), power - order, weight.xreplace(made.back)))
    return tuple(poles)


@lru_cache(maxsize=1024)
def _at_complex_places(R: sp.Expr, x: sp.Symbol, k: int) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
    """α, β, A, B of (Ax + B)/((x − α)² + β²), from a quadratic factor a((x − α)² + β²) of the denominator."""
    made = _split(R, x)
    factor, others = made.factors[k][0], made.others(k)
    a, b, _ = sp.Poly(factor, x).all_coeffs()
    D = required(_lacking(factor, x))
    re, im = -b / (2 * a), sp.sqrt(D) / (2 * sp.sqrt(a**2))
    # modulo the factor, 1/others is a polynomial (Bézout): the numerator is found without complex zeros
    inverse = sp.invert(sp.Poly(others, x), sp.Poly(factor, x)) if others.has(x) else sp.Poly(1 / others, x)
    line = sp.rem(made.rest * inverse, sp.Poly(factor, x))
    A, B = (sp.factor(line.coeff_monomial(x**k) / a).xreplace(made.back) for k in (1, 0))
    return re.xreplace(made.back), im.xreplace(made.back), A, B


def _lacking(factor: sp.Expr, x: sp.Symbol) -> sp.Expr | None:
    """4ac − b² of a quadratic factor, positive where it has no real zeros; None of a linear one."""
    if sp.degree(factor, x) != 2:
        return None
    a, b, c = sp.Poly(factor, x).all_coeffs()
    return sp.factor(4 * a * c - b**2)


def _zeros(factor: sp.Expr, x: sp.Symbol) -> list[tuple[sp.Expr, sp.Expr]]:
    """Return the zeros r of an irreducible factor, and factor/(x − r)."""
    coefficients = sp.Poly(factor, x).all_coeffs()
    if len(coefficients) == 2:
        a, b = coefficients
        return [(sp.cancel(-b / a), a)]
    if len(coefficients) == 3:
        a, b, c = coefficients
        # which of the two is the lower one depends on the sign of a, and nothing rests on it
        D = sp.factor(b**2 - 4 * a * c)
        low, high = ((-b + s * sp.sqrt(D)) / (2 * a) for s in (-1, 1))
        return [(low, a * (x - high)), (high, a * (x - low))]
    raise NoFormError(f"the integrand has poles at the roots of a polynomial of degree {len(coefficients) - 1}")
