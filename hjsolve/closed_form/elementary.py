"""∫ R(x) dx/√P(x) for deg P ≤ 2, in the functions that are real where the motion is.

Hermite's reduction leaves simple poles (``reduction.py``). With u = 1/(x − r), ∫ dx/((x − r) √P) = −σ ∫ du/√Q(u),
Q = P(r) u² + P′(r) u + ½P″, σ the sign of x − r: arc sine, area functions, a root or a logarithm, according to the
signs of the leading coefficient and of the discriminant.

Gradshteyn and Ryzhik (2007), 2.26; the discriminant of Q is that of P.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from hjsolve.closed_form.complex_poles import PairOfComplexPoles, pair_of_complex_poles
from hjsolve.closed_form.fractions import partial_fractions
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.reduction import reduced
from hjsolve.closed_form.signs import Signs
from hjsolve.closed_form.tidy import in_factors
from hjsolve.display.shown import Shown


@dataclass(frozen=True)
class BasicIntegral:
    """∫ dx/√P, or ∫ dx/((x − r) √P) with u = 1/(x − r), or ∫ dx/((r² − x²) √P) where P is even and P(r) < 0 < P(0).

    The last is arcsin(κ x/√(C (1 − x²/r²)))/(κ r²), κ² r² = −P(r): the great circle's arcsin(cot θ …).

    Attributes:
        kind: arcsine, area sine, area cosine right, area cosine left, root, line, logarithm; pair.
        quadratic: A, B, C of Q = A u² + B u + C.
        place: r; None where u = x.
        side: σ, the sign of x − r; −1 where u = x, so that the integral is −σ ∫ du/√Q always.
    """

    kind: str
    quadratic: tuple[sp.Expr, sp.Expr, sp.Expr]
    place: sp.Expr | None
    side: int

    @property
    def ratio(self) -> sp.Expr:
        """It is one logarithm."""
        return sp.S.One

    def variable(self, x: sp.Expr) -> sp.Expr:
        """u(x).

        Args:
            x: the variable of the curve, or what stands for it.
        """
        return x if self.place is None else 1 / (x - self.place)

    def written(self, x: sp.Expr) -> sp.Expr:
        """Return the integral as a function of x.

        Args:
            x: the variable of the curve, or what stands for it.
        """
        A, B, C = self.quadratic
        if self.kind == "pair":
            # d/dx arcsin(κ x/√(C (1 − x²/r²))) = κ r²/((r² − x²) √P) with P = Ax² + C, by P(r) = −κ² r²
            κ, r = self.rate, self.pole
            return sp.asin(κ * x / (positive_root(C) * sp.sqrt(1 - x**2 / r**2))) / (κ * r**2)
        u = self.variable(x)
        slope, D = _halved(A, B, C, sp.Dummy("u"), u)
        match self.kind:
            # 2Au + B over the root of the discriminant is −cos of the eccentric anomaly, so within ± 1
            case "arcsine":
                value = sp.asin(-slope / positive_root(D)) / positive_root(-A)
            # D < 0: no turning point, u from −∞ to ∞
            case "area sine":
                value = sp.asinh(slope / positive_root(-D)) / positive_root(A)
            # D > 0 and beyond the greater root: 2Au + B > √(B² − 4AC)
            case "area cosine right":
                value = sp.acosh(slope / positive_root(D)) / positive_root(A)
            case "area cosine left":
                value = -sp.acosh(-slope / positive_root(D)) / positive_root(A)
            # A = 0, uniform acceleration: P itself is linear
            case "root":
                value = 2 * positive_root(B * u + C) / B
            case "line":
                value = u / positive_root(C)
            case _:
                value = self.sign_of_u * sp.log(self.sign_of_u * u) / positive_root(A)
        # du = −dx/(x − r)², and √P = |x − r| √Q: the sign of x − r is left
        return -self.side * value

    @property
    def rate(self) -> sp.Expr:
        """Κ of a pair of poles; nan where there is none."""
        A, _, C = self.quadratic
        if self.place is None:
            return sp.nan
        return positive_root(sp.factor(-(A * self.pole**2 + C))) / self.pole

    @property
    def pole(self) -> sp.Expr:
        """R, of an integrand that has a pole; nan of others."""
        return sp.nan if self.place is None else self.place

    def integrand(self, x: sp.Symbol) -> sp.Expr:
        """Return the rational factor of the integrand.

        Args:
            x: the variable.
        """
        if self.place is None:
            return sp.S.One
        return 1 / (self.place**2 - x**2) if self.kind == "pair" else 1 / (x - self.place)

    @property
    def leading(self) -> sp.Expr:
        """The integral is a logarithm, or an arc function, over √ of this."""
        A = self.quadratic[0]
        return -((self.rate * self.pole**2) ** 2) if self.kind == "pair" else A

    @property
    def sign_of_u(self) -> int:
        """The sign of u on the piece; of a logarithm only."""
        return self.side

    def complete(self) -> sp.Expr | None:
        """Return the integral from root to root; None where P does not have two roots with P > 0 between."""
        A = self.quadratic[0]
        if self.kind == "pair":
            return sp.pi / (self.rate * self.pole**2)
        if self.kind != "arcsine":
            return None
        # from −1 to 1 the arcsine grows by π
        return (1 if self.place is None else self.side) * sp.pi / positive_root(-A)


@dataclass(frozen=True, repr=False)
class Antiderivative(Shown):
    """∫ R dx/√P = a(x) √P + Σ c_k I_k(x).

    Attributes:
        x: the variable.
        polynomial: P.
        algebraic: a(x), rational.
        terms: the coefficients and the integrals.
    """

    x: sp.Symbol
    polynomial: sp.Expr
    algebraic: sp.Expr
    terms: tuple[tuple[sp.Expr, BasicIntegral | PairOfComplexPoles], ...]

    def written(self, x: sp.Expr | None = None) -> sp.Expr:
        """Return the function.

        Args:
            x: what is put for the variable; the variable itself by default.
        """
        place = self.x if x is None else x
        algebraic = sp.factor(self.algebraic) * positive_root(self.polynomial) if self.algebraic != 0 else sp.S.Zero
        return algebraic.subs(self.x, place) + sp.Add(*(c * term.written(place) for c, term in self.terms))

    def complete(self) -> sp.Expr | None:
        """From root to root of P, where P > 0 between two of them; None elsewhere."""
        values = [(c, term.complete()) for c, term in self.terms]
        if any(value is None for _, value in values):
            return None
        return sp.Add(*(c * value for c, value in values))

    def residual(self, integrand: sp.Expr) -> sp.Expr:
        """√P d/dx of the function less R: zero, exactly, where the function is right.

        Args:
            integrand: R(x).
        """
        P, a = self.polynomial, self.algebraic
        # d(a √P) = (a′P + aP′/2) dx/√P
        slope = sp.diff(a, self.x) * P + a * sp.diff(P, self.x) / 2
        rest = sp.Add(*(c * t.integrand(self.x) for c, t in self.terms))
        return sp.cancel(sp.together(slope + rest - integrand))


def _halved(
    A: sp.Expr, B: sp.Expr, C: sp.Expr, name: sp.Symbol, u: sp.Expr
) -> tuple[sp.Expr, sp.Expr]:  # fmt: skip
    """Au + B/2 and B²/4 − AC, both without the positive factor of the first."""
    slope, D = A * name + B / 2, sp.expand(B**2 / 4 - A * C)
    # only the ratio slope/√D enters the arcs: Kepler's (kmr − p²)/… has no 2 and no m left
    number, rest = sp.factor_terms(slope).as_coeff_Mul()
    common = abs(number) * sp.Mul(*(f for f in sp.Mul.make_args(rest) if f.is_positive))
    slope = sp.expand(sp.cancel(slope / common)).subs(name, u)
    if u.is_Pow or not u.is_Symbol:
        slope = sp.factor(sp.together(slope))
    return slope, sp.factor_terms(sp.expand(sp.cancel(D / common**2)))


def positive_root(radicand: sp.Expr) -> sp.Expr:
    """√ of what is positive, with squares and common factors taken out.

    Args:
        radicand: positive where the form holds.
    """
    return sp.sqrt(sp.factor_terms(radicand))


def elementary_antiderivative(
    R: sp.Expr, P: sp.Poly, signs: Signs, side_of: Callable[[sp.Expr], int]
) -> Antiderivative:
    """Integrate R/√P, deg P ≤ 2, real on the piece of the x-axis that a motion is on.

    Args:
        R: rational in the variable.
        P: of degree 0, 1 or 2, squarefree.
        signs: decides between the real forms, and keeps what it decided.
        side_of: r ↦ the sign of x − r on the piece.

    Raises:
        NoFormError: R has multiple poles at complex places, or poles at a root of P that is not rational.
    """
    (x,) = P.gens
    # Hermite's reduction first: what is left has simple poles and no powers, each with one logarithm or arc
    algebraic, rest = reduced(R, P)
    parts = partial_fractions(rest, x, signs)
    if any(power > 1 for _, power, _ in parts.poles):
        raise NoFormError("the integrand has a multiple pole at a root of p²")
    C, B, A = (P.coeff_monomial(x**k) for k in range(3))
    kept = [(weight, BasicIntegral(_kind((A, B, C), signs, None), (A, B, C), None, -1)) for _, weight in parts.powers]
    for place, _, weight in parts.poles:
        # with x = r + 1/u, P = (P(r) u² + P′(r) u + A)/u²: Q is the quadratic of u
        here, slope = (in_factors(sp.expand(f.as_expr().subs(x, place))) for f in (P, P.diff(x)))
        Q = (here, slope, A)
        kept.append((in_factors(sp.expand(weight)), BasicIntegral(_kind(Q, signs, place), Q, place, side_of(place))))
    terms = _in_pairs([(w, one) for w, one in kept if w != 0], signs)
    past = [(sp.S.One, pair_of_complex_poles(P, pair, signs)) for pair in parts.complex_poles]
    return Antiderivative(x, P.as_expr(), algebraic, (*terms, *past))


def _in_pairs(terms: list[tuple[sp.Expr, BasicIntegral]], signs: Signs) -> list[tuple[sp.Expr, BasicIntegral]]:
    """Poles at ±r with opposite weights as one integral, where P is even, the motion between them and an arcsine."""
    poles = [(w, one) for w, one in terms if one.place is not None]
    if len(poles) != 2 or sum(w for w, _ in poles) != 0 or sum(one.place or 0 for _, one in poles) != 0:
        return terms
    (w, one), (_, other) = sorted(poles, key=lambda row: -row[1].side)  # right of −r, left of r
    A, slope = one.quadratic[2], one.quadratic[1]
    C = sp.expand(one.quadratic[0] - A * one.pole**2)
    even = sp.expand(slope + other.quadratic[1]) == 0 and sp.expand(slope - 2 * A * one.pole) == 0
    if one.kind != "arcsine" or not even or one.side == other.side or signs.sign(C) <= 0:
        return terms
    pair = BasicIntegral("pair", (A, sp.S.Zero, C), other.place, -1)  # w/(x + r) − w/(x − r) = 2wr/(r² − x²)
    return [*(row for row in terms if row[1].place is None), (2 * w * other.place, pair)]


def _kind(
    quadratic: tuple[sp.Expr, sp.Expr, sp.Expr], signs: Signs, place: sp.Expr | None
) -> str:  # fmt: skip
    A, B, C = quadratic
    leading = signs.sign(A)
    if leading < 0:
        return "arcsine"
    if leading == 0:
        return "line" if signs.sign(B) == 0 else "root"
    # a double root is a separatrix: ∫ du/(√A |u|)
    discriminant = sp.expand(B**2 - 4 * A * C)
    if signs.sign(discriminant) == 0:
        return "logarithm"
    if signs.sign(discriminant) < 0:
        return "area sine"
    # 2Au + B is positive right of the greater root of Q and negative left of the smaller
    return "area cosine right" if signs.slope_sign(A, B, place) > 0 else "area cosine left"
