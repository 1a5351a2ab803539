"""R dx/√P = d(a √P) + R₁ dx/√P: of R₁ only simple poles off the roots of P, and powers below deg P − 1, are left.

Hermite's reduction. With n ≥ 1 and f a factor of the denominator of R,

    d(c √P/fⁿ) = (c′P + cP′/2)/fⁿ dx/√P − n c f′P/fⁿ⁺¹ dx/√P         takes 1/fⁿ⁺¹ away where f does not divide P,
    d(c √P/fⁿ) = (c′G + cG′/2)/fⁿ⁻¹ dx/√P + (½ − n) c f′G/fⁿ dx/√P   takes 1/fⁿ away where P = f G,
    d(xⁿ √P) = (n xⁿ⁻¹ P + xⁿ P′/2) dx/√P                            takes xⁿ⁺ᵈ⁻¹ away, d = deg P.

So the actions and W of an elliptic motion are made of the same few integrals as its periods, with coefficients in the
constants of P, not in its roots. Bronstein, Symbolic integration I (2005), 2.2; Byrd and Friedman (1971), 230.
"""

from __future__ import annotations

from functools import lru_cache

import sympy as sp

from hjsolve.closed_form.curves import named_constants


@lru_cache(maxsize=512)
def reduced(R: sp.Expr, P: sp.Poly) -> tuple[sp.Expr, sp.Expr]:
    """Return a and R₁.

    Args:
        R: rational in the variable.
        P: squarefree.

    Returns:
        Both; 0 and R where a pole is a root of P that only its radical shows.
    """
    x = P.gen
    (bare, polynomial), back = named_constants(sp.Tuple(R, P.as_expr()), x)
    a, rest = _Reduction(bare, sp.Poly(polynomial, x)).results()
    if a.has(sp.zoo, sp.nan) or rest.has(sp.zoo, sp.nan):
        return sp.S.Zero, R
    return sp.factor(sp.together(a)).xreplace(back), rest.xreplace(back)


class _Reduction:
    """R as a polynomial and Σ h/fⁿ, and a as far as it is found."""

    def __init__(self, R: sp.Expr, P: sp.Poly):
        self.x = x = P.gen
        top, bottom = sp.fraction(sp.cancel(sp.together(R)))
        # square-free factors over the constants' field, not its closure: no root of the denominator is needed
        constant, factors = sp.factor_list(bottom, x) if bottom.has(x) else (bottom, [])
        held = [P, sp.Poly(top / constant, x), *(sp.Poly(f, x) for f, _ in factors)]
        # one domain for all: sympy would find it anew in each product, which takes most of the time
        domain = sp.construct_domain([c for p in held for c in p.all_coeffs()], field=True)[0]
        self.domain = domain
        self.P = self._poly(P.as_expr())
        self.a: sp.Expr = sp.S.Zero
        self.factors = [(self._poly(f), n) for f, n in factors]
        numerator, whole = self._poly(top / constant), self._poly(1)
        for f, n in self.factors:
            whole *= f**n
        self.whole, rest = sp.div(numerator, whole)
        self.parts = dict[int, list[sp.Poly]]()
        for k, (f, n) in enumerate(self.factors):
            others = self._poly(1)
            for j, (g, power) in enumerate(self.factors):
                others *= g**power if j != k else self._poly(1)
            self.parts[k] = [self._poly(0)] * (n + 1)
            # partial fractions by Bézout: h ≡ rest/others modulo fⁿ
            self._add(k, n, sp.rem(rest * sp.invert(others, f**n), f**n) if n else rest)

    def _poly(self, e: sp.Expr | int) -> sp.Poly:
        return sp.Poly(e, self.x, domain=self.domain)

    def _add(self, k: int, n: int, h: sp.Poly) -> None:
        """h/fⁿ, in digits of f."""
        f = self.factors[k][0]
        while n > 0 and not h.is_zero:
            h, digit = sp.div(h, f)
            self.parts[k][n] += digit
            n -= 1
        self.whole += h

    def results(self) -> tuple[sp.Expr, sp.Expr]:
        """Return a and R₁, once everything that can be is taken away."""
        for k in range(len(self.factors)):
            self._take_poles(k)
        self._take_powers()
        rest = sum((self.parts[k][1].as_expr() / f.as_expr() for k, (f, n) in enumerate(self.factors) if n), sp.S.Zero)
        return self.a, self.whole.as_expr() + rest

    def _take_poles(self, k: int) -> None:
        f, n = self.factors[k]
        slope = f.diff()
        G, common = sp.div(self.P, f)
        # f divides P: then √P/fⁿ has its pole at a branch point, and 1/f itself can be taken away
        inside = common.is_zero
        # h = c f′P modulo f has a solution, since f is square-free and prime to P: c = h (f′P)⁻¹
        unit = sp.invert(slope * G if inside else slope * self.P, f)
        # off the roots of P a simple pole is an integral of the third kind and stays
        while n >= (1 if inside else 2):
            power = n if inside else n - 1
            factor = sp.Rational(1, 2) - power if inside else -sp.Integer(power)
            h, self.parts[k][n] = self.parts[k][n], self._poly(0)
            c = sp.rem(h * unit, f) * self._poly(1 / factor)
            self.a += c.as_expr() / f.as_expr() ** power
            half = self._poly(sp.Rational(1, 2))
            if inside:  # h/fⁿ − (½ − n) c f′G/fⁿ is a multiple of f over fⁿ
                left = sp.quo(h - c * slope * G * self._poly(factor), f)
                self._add(k, n - 1, left - c.diff() * G - c * G.diff() * half)
            else:
                left = sp.quo(h - c * slope * self.P * self._poly(factor), f)
                self._add(k, n - 1, left - c.diff() * self.P - c * self.P.diff() * half)
            n -= 1

    def _take_powers(self) -> None:
        d = self.P.degree()
        x = self._poly(self.x)
        # of x⁰ … xᵈ⁻² the integrals are independent (first and second kind); higher powers are not
        while not self.whole.is_zero and (k := self.whole.degree()) >= (d - 1 if d else 1):
            n = k - d + 1
            slope = x ** (n - 1) * self.P * self._poly(n) if n else self._poly(0)
            slope += x**n * self.P.diff() * self._poly(sp.Rational(1, 2))
            weight = self.whole.coeff_monomial(self.x**k) / slope.coeff_monomial(self.x**k)
            self.a += weight * self.x**n
            self.whole -= slope * self._poly(weight)
